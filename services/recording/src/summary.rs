//! What a recording says about itself at its end.

use std::collections::BTreeMap;

use crate::fields::Fields;

/// Name of the metadata record that holds it.
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
}

impl Summary {
    /// The summary in the body of a metadata record, if it holds one.
    pub(crate) fn parse(body: &[u8]) -> Option<Self> {
        let mut fields = Fields(body);
        if fields.text()? != SUMMARY_NAME {
            return None;
        }
        let mut pairs = Fields(fields.block()?);
        let mut summary = Self::default();
        while !pairs.0.is_empty() {
            let (name, value) = (pairs.text()?, pairs.text()?);
            let field = match name {
                "recorded" => &mut summary.recorded,
                "lost" => &mut summary.lost,
                "gaps" => &mut summary.gaps,
                _ => continue,
            };
            *field = value.parse().ok()?;
        }
        Some(summary)
    }

    pub(crate) fn to_metadata(self) -> BTreeMap<String, String> {
        [("recorded", self.recorded), ("lost", self.lost), ("gaps", self.gaps)]
            .map(|(name, value)| (name.to_owned(), value.to_string()))
            .into()
    }
}
