//! Pictures of scenes, for `plan --svg`.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use render::picture::Look;
use rustix::fs::Access;
use schemas::message::{Reply, SceneRequest};

/// Where pictures go.
pub(crate) struct Pictures {
    /// The first picture's file.
    path: PathBuf,
    overwrite: bool,
}

#[derive(Debug, thiserror::Error)]
pub(crate) enum PictureError {
    #[error("{} exists; --overwrite replaces it", .0.display())]
    Exists(PathBuf),
    #[error("{} is a folder; --svg needs a file", .0.display())]
    IsFolder(PathBuf),
    #[error("the picture {} would replace a scene", .0.display())]
    IsInput(PathBuf),
    #[error("can't write {}: {cause}", path.display())]
    Write { path: PathBuf, cause: io::Error },
}

impl Pictures {
    pub(crate) fn new(path: PathBuf, overwrite: bool) -> Self {
        Self { path, overwrite }
    }

    /// Checks, before anything is planned, that a picture can be written for each of
    /// `inputs`. How many scenes stdin holds is not known yet: it counts as one.
    pub(crate) fn check(&self, inputs: &[PathBuf]) -> Result<(), PictureError> {
        let folder = match self.path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let unwritable = |cause| PictureError::Write { path: self.path.clone(), cause };
        if !fs::metadata(folder).map_err(unwritable)?.is_dir() {
            return Err(unwritable(rustix::io::Errno::NOTDIR.into()));
        }
        rustix::fs::access(folder, Access::WRITE_OK | Access::EXEC_OK)
            .map_err(|error| unwritable(error.into()))?;
        let inputs_found: Vec<_> =
            inputs.iter().filter_map(|input| fs::canonicalize(input).ok()).collect();
        for number in 1..=inputs.len() {
            let path = numbered(&self.path, number);
            // A link that leads nowhere exists, too.
            let Ok(metadata) = fs::symlink_metadata(&path) else { continue };
            if metadata.is_dir() {
                return Err(PictureError::IsFolder(path));
            }
            if !self.overwrite {
                return Err(PictureError::Exists(path));
            }
            if fs::canonicalize(&path).is_ok_and(|found| inputs_found.contains(&found)) {
                return Err(PictureError::IsInput(path));
            }
        }
        Ok(())
    }

    /// Draws the scene with this number, from 1, and the reply to it.
    pub(crate) fn draw(
        &self,
        number: usize,
        scene: &SceneRequest,
        reply: &Reply,
        look: Look,
    ) -> Result<(), PictureError> {
        let path = numbered(&self.path, number);
        let picture = render::picture::draw_with(scene, reply, look);
        let failed = |cause: io::Error| match cause.kind() {
            io::ErrorKind::AlreadyExists => PictureError::Exists(path.clone()),
            _ => PictureError::Write { path: path.clone(), cause },
        };
        let mut options = File::options();
        match self.overwrite {
            true => options.write(true).create(true).truncate(true),
            false => options.write(true).create_new(true),
        };
        let mut file = options.open(&path).map_err(failed)?;
        file.write_all(picture.as_bytes()).map_err(failed)
    }
}

/// The first picture has the name given, the others a number before the extension.
fn numbered(path: &Path, number: usize) -> PathBuf {
    if number == 1 {
        return path.to_owned();
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
    path.with_file_name(format!("{stem}-{number}{extension}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn further_pictures_are_numbered_before_the_extension() {
        let name = |path: &str, number| numbered(Path::new(path), number).display().to_string();
        assert_eq!(name("a/b.svg", 1), "a/b.svg");
        assert_eq!(name("a/b.svg", 2), "a/b-2.svg");
        assert_eq!(name("b.old.svg", 3), "b.old-3.svg");
        assert_eq!(name("b", 4), "b-4");
    }
}
