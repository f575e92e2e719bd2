//! The generated files that are text, and what generates each.

use std::fs;
use std::io::ErrorKind;
use std::path::PathBuf;

use integration_tests::root;

use crate::pictures::picture;
use crate::{Error, figures, header, tables, wire};

/// A generated file, or one with a generated block.
pub(crate) struct File {
    /// Where it is in the repository.
    pub(crate) path: &'static str,
    content: Content,
}

type Make = fn() -> String;

enum Content {
    /// All of the file.
    Whole(Make),
    /// The lines between `<!-- generated: NAME -->` and `<!-- end: NAME -->`; the rest is
    /// written by hand.
    Block { name: &'static str, make: Make },
}

const fn whole(path: &'static str, make: Make) -> File {
    File { path, content: Content::Whole(make) }
}

const fn block(path: &'static str, name: &'static str, make: Make) -> File {
    File { path, content: Content::Block { name, make } }
}

/// Every generated text of the repository.
pub(crate) const FILES: &[File] = &[
    whole("docs/disassemble.svg", || picture("disassemble.json")),
    whole("docs/drive-a.svg", || picture("drive-a.json")),
    whole("docs/drive-b.svg", || picture("drive-b.json")),
    block("docs/driving.md", "corridors", tables::corridors),
    block("docs/method.md", "corners", tables::corners),
    block("docs/wire.md", "layout", wire::layout),
    block("docs/wire.md", "services", wire::services),
    whole("services/clients/c/include/clearway.h", header::c),
    whole("docs/figures/channels.svg", figures::channels::figure),
    whole("docs/figures/guiding-circle.svg", figures::guiding_circle::figure),
    whole("docs/figures/profile.svg", figures::profile::figure),
    whole("docs/figures/route.svg", figures::route::figure),
    whole("docs/figures/safest-gap.svg", figures::safest_gap::figure),
    whole("docs/figures/smooth-corners.svg", figures::smooth_corners::figure),
    whole("docs/figures/solids.svg", figures::solids::figure),
    whole("docs/figures/table-1.svg", figures::table_1::figure),
    whole("docs/figures/tangents.svg", figures::tangents::figure),
    whole("schemas/src/wire/layout.txt", schemas::wire::layout_text),
    #[cfg(feature = "json-schema")]
    whole("schemas/json/check.schema.json", comparison::report::schema::check),
    #[cfg(feature = "json-schema")]
    whole("schemas/json/diff.schema.json", comparison::report::schema::diff),
    #[cfg(feature = "json-schema")]
    whole("schemas/json/reply.schema.json", schemas::json::schema::reply),
    #[cfg(feature = "json-schema")]
    whole("schemas/json/scene.schema.json", schemas::json::schema::scene),
];

impl File {
    /// The file as it should be, if it is not so already.
    pub(crate) fn renewed(&self) -> Result<Option<String>, Error> {
        let present = read(self.path)?.map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        let wanted = match &self.content {
            Content::Whole(make) => make(),
            Content::Block { name, make } => {
                let text = present.as_deref().unwrap_or_default();
                replace_block(text, name, &make()).ok_or_else(|| Error::Content {
                    path: PathBuf::from(self.path),
                    reason: format!(
                        "needs the lines `{}` and `{}`, in this order",
                        begin(name),
                        end(name)
                    ),
                })?
            }
        };
        Ok((present.as_ref() != Some(&wanted)).then_some(wanted))
    }
}

fn begin(name: &str) -> String {
    format!("<!-- generated: {name} -->\n")
}

fn end(name: &str) -> String {
    format!("<!-- end: {name} -->\n")
}

/// `text` with `block` between the two lines that name it.
fn replace_block(text: &str, name: &str, block: &str) -> Option<String> {
    let (begin, end) = (begin(name), end(name));
    let from = text.find(&begin)? + begin.len();
    let to = from + text[from..].find(&end)?;
    Some(format!("{}\n{}\n\n{}", &text[..from], block.trim_end(), &text[to..]))
}

/// A file of the repository, if it exists.
pub(crate) fn read(path: &str) -> Result<Option<Vec<u8>>, Error> {
    let path = root().join(path);
    match fs::read(&path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(cause) if cause.kind() == ErrorKind::NotFound => Ok(None),
        Err(cause) => Err(Error::Read { path, cause }),
    }
}

/// Writes a file of the repository, and the folder that it lies in.
pub(crate) fn write(path: &str, bytes: &[u8]) -> Result<(), Error> {
    let path = root().join(path);
    let written =
        path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&path, bytes));
    written.map_err(|cause| Error::Write { path, cause })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_block_is_replaced() {
        let text = "a\n<!-- generated: t -->\nold\n<!-- end: t -->\nb\n";
        let once = replace_block(text, "t", "new\n").unwrap();
        assert_eq!(once, "a\n<!-- generated: t -->\n\nnew\n\n<!-- end: t -->\nb\n");
        assert_eq!(replace_block(&once, "t", "new\n").unwrap(), once);
        assert_eq!(replace_block(text, "u", "new"), None);
    }
}
