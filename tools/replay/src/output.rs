//! Files that commands write.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Why a file can't be written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OutputError {
    #[error("{} exists; --overwrite replaces it", .0.display())]
    Exists(PathBuf),
    #[error("{} is read from and can't be written to", .0.display())]
    IsInput(PathBuf),
    #[error("can't write {}: {cause}", path.display())]
    Write { path: PathBuf, cause: io::Error },
}

impl OutputError {
    pub(crate) fn write(path: &Path, cause: io::Error) -> Self {
        Self::Write { path: path.to_owned(), cause }
    }
}

/// Whether something is in the way of writing `path`, seen before the work begins.
pub(crate) fn check(path: &Path, overwrite: bool, inputs: &[&Path]) -> Result<(), OutputError> {
    if let Ok(canonical) = fs::canonicalize(path)
        && inputs.iter().any(|input| fs::canonicalize(input).is_ok_and(|it| it == canonical))
    {
        return Err(OutputError::IsInput(path.to_owned()));
    }
    // A link that leads nowhere exists, too.
    if !overwrite && fs::symlink_metadata(path).is_ok() {
        return Err(OutputError::Exists(path.to_owned()));
    }
    Ok(())
}

/// Creates a file.
pub(crate) fn create(path: &Path, overwrite: bool) -> Result<File, OutputError> {
    let mut options = File::options();
    match overwrite {
        true => options.write(true).create(true).truncate(true),
        false => options.write(true).create_new(true),
    };
    options.open(path).map_err(|cause| match cause.kind() {
        io::ErrorKind::AlreadyExists => OutputError::Exists(path.to_owned()),
        _ => OutputError::write(path, cause),
    })
}

/// Writes a file.
pub(crate) fn write(path: &Path, content: &str, overwrite: bool) -> Result<(), OutputError> {
    let mut file = create(path, overwrite)?;
    file.write_all(content.as_bytes()).map_err(|cause| OutputError::write(path, cause))
}
