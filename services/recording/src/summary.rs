//! What a recording says about itself, at its beginning and at its end.

use std::collections::BTreeMap;

use crate::error::Damage;
use crate::fields::Fields;

/// Name of the metadata record at the beginning.
pub(crate) const DESCRIPTION_NAME: &str = "clearway.description";

/// The description's checksum among its values, eight hexadecimal digits: in a file that was not
/// finished no other covers it.
const CHECKSUM_KEY: &str = "checksum";

/// Name of the metadata record at the end.
pub(crate) const SUMMARY_NAME: &str = "clearway.recording";

/// What a recording says about itself at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Summary {
    /// Messages in the file.
    pub recorded: u64,
    /// Messages that the recorder knows it missed.
    pub lost: u64,
    /// Runs of missed messages.
    pub gaps: u64,
    /// Messages that were not to be recorded.
    pub left_out: u64,
}

impl Summary {
    /// The summary in the body of a metadata record, if it holds one, and what is written beside it.
    pub(crate) fn parse(body: &[u8]) -> Option<(Self, BTreeMap<String, String>)> {
        let mut fields = Fields(body);
        if fields.text()? != SUMMARY_NAME {
            return None;
        }
        let mut pairs = Fields(fields.block()?);
        let (mut summary, mut notes) = (Self::default(), BTreeMap::new());
        while !pairs.0.is_empty() {
            let (name, value) = (pairs.text()?, pairs.text()?);
            let field = match name {
                "recorded" => &mut summary.recorded,
                "lost" => &mut summary.lost,
                "gaps" => &mut summary.gaps,
                "left_out" => &mut summary.left_out,
                _ => {
                    notes.insert(name.to_owned(), value.to_owned());
                    continue;
                }
            };
            *field = value.parse().ok()?;
        }
        Some((summary, notes))
    }

    /// Both together.
    pub fn plus(self, other: Self) -> Self {
        Self {
            recorded: self.recorded + other.recorded,
            lost: self.lost + other.lost,
            gaps: self.gaps + other.gaps,
            left_out: self.left_out + other.left_out,
        }
    }

    pub(crate) fn to_metadata(self) -> BTreeMap<String, String> {
        let left_out = (self.left_out > 0).then_some(("left_out", self.left_out));
        [("recorded", self.recorded), ("lost", self.lost), ("gaps", self.gaps)]
            .into_iter()
            .chain(left_out)
            .map(|(name, value)| (name.to_owned(), value.to_string()))
            .collect()
    }
}

/// What is written at the beginning of a recording.
pub(crate) fn with_checksum(mut description: BTreeMap<String, String>) -> BTreeMap<String, String> {
    let checksum = format!("{:08x}", checksum(&description));
    description.insert(CHECKSUM_KEY.to_owned(), checksum);
    description
}

/// The description in the body of a metadata record, if it holds one.
pub(crate) fn description(body: &[u8]) -> Option<Result<BTreeMap<String, String>, Damage>> {
    let mut fields = Fields(body);
    if fields.text()? != DESCRIPTION_NAME {
        return None;
    }
    let mut pairs = || {
        let mut pairs = Fields(fields.block()?);
        let mut description = BTreeMap::new();
        while !pairs.0.is_empty() {
            description.insert(pairs.text()?.to_owned(), pairs.text()?.to_owned());
        }
        let saved = u32::from_str_radix(&description.remove(CHECKSUM_KEY)?, 16).ok()?;
        Some((saved, description))
    };
    let Some((saved, description)) = pairs() else {
        return Some(Err(Damage::Broken { what: "the description" }));
    };
    let calculated = checksum(&description);
    Some(if saved == calculated {
        Ok(description)
    } else {
        Err(Damage::Checksum { of: "the description", saved, calculated })
    })
}

fn checksum(description: &BTreeMap<String, String>) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    for text in description.iter().flat_map(|(name, value)| [name, value]) {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    }
    hasher.finalize()
}
