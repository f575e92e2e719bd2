//! The file of a recording while it is written.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rustix::fs::{CWD, FlockOperation, RenameFlags};
use rustix::io::Errno;

use crate::write_error::{Trouble, WriteError};

/// A file that has another name until it is finished, so that nobody takes a part for the whole.
///
/// It is locked, so that two recorders never write the same one, and each flush looks whether it
/// still is what was written.
#[derive(Debug)]
pub struct NewFile {
    output: BufWriter<Guarded>,
    /// Where it is until it is finished.
    part: PathBuf,
    path: PathBuf,
    overwrite: bool,
    sync: bool,
    /// Device and inode; none for what is no file, such as a pipe: it is written as it is.
    is: Option<(u64, u64)>,
}

/// A file that nobody else may make shorter or longer.
#[derive(Debug)]
struct Guarded {
    file: File,
    part: PathBuf,
    is_file: bool,
    written: u64,
}

impl Guarded {
    fn check(&self) -> Result<(), WriteError> {
        let (written, found) = (self.written, self.file.metadata()?.len());
        if !self.is_file || found == written {
            return Ok(());
        }
        Err(WriteError::File { path: self.part.clone(), trouble: Trouble::Size { written, found } })
    }
}

impl Write for Guarded {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // Before: behind a cut, the next bytes would leave a hole of the same size.
        self.check().map_err(io::Error::other)?;
        let taken = self.file.write(bytes)?;
        self.written += taken as u64;
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl NewFile {
    /// `input` is the device and inode of a file that must stay as it is: an unfinished recording
    /// of the same name that is being finished.
    pub(crate) fn create(
        path: &Path,
        overwrite: bool,
        sync: bool,
        input: Option<(u64, u64)>,
    ) -> Result<Self, WriteError> {
        let failed = |error: io::Error| WriteError::Create {
            path: path.to_owned(),
            source: Arc::new(error),
        };
        let with = |file, part: PathBuf, is: Option<(u64, u64)>| Self {
            output: BufWriter::with_capacity(
                64 << 10,
                Guarded { file, part: part.clone(), is_file: is.is_some(), written: 0 },
            ),
            part,
            path: path.to_owned(),
            overwrite,
            sync,
            is,
        };
        match fs::metadata(path) {
            Ok(_) if !overwrite => return Err(WriteError::Exists { path: path.to_owned() }),
            Ok(found) if found.is_dir() => return Err(failed(io::ErrorKind::IsADirectory.into())),
            Ok(found) if !found.is_file() => {
                let file = OpenOptions::new().write(true).open(path).map_err(failed)?;
                return Ok(with(file, path.to_owned(), None));
            }
            _ => {}
        }
        let mut part = path.as_os_str().to_owned();
        part.push(".part");
        let is = |part: &std::ffi::OsStr| fs::metadata(part).ok().map(|is| (is.dev(), is.ino()));
        if input.is_some() && is(&part) == input {
            part.push(".new");
        }
        let part = PathBuf::from(part);
        let new = OpenOptions::new().write(true).create_new(true).open(&part);
        let is_new = new.is_ok();
        let file = match new {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                OpenOptions::new().write(true).open(&part)
            }
            new => new,
        }
        .map_err(failed)?;
        match rustix::fs::flock(&file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => {}
            Err(Errno::WOULDBLOCK) => return Err(WriteError::Locked { path: part }),
            // Not every file system has locks.
            Err(Errno::NOTSUP | Errno::NOSYS | Errno::NOLCK) => {}
            Err(error) => return Err(failed(error.into())),
        }
        if !is_new && !overwrite {
            return Err(WriteError::Unfinished { path: part });
        }
        if !is_new {
            // Only then: ext4 writes what was cut to disk when it is closed, and not in its own time.
            file.set_len(0).map_err(failed)?;
        }
        let found = file.metadata().map_err(failed)?;
        Ok(with(file, part, Some((found.dev(), found.ino()))))
    }

    /// Where it is until it is finished; none for what is no file.
    pub(crate) fn part(&self) -> Option<&Path> {
        self.is.map(|_| &*self.part)
    }

    /// Whether the file still is what was written.
    fn check(&self) -> Result<(), WriteError> {
        let Some(is) = self.is else { return Ok(()) };
        let gone = WriteError::File { path: self.part.clone(), trouble: Trouble::Gone };
        match fs::symlink_metadata(&self.part) {
            Ok(found) if (found.dev(), found.ino()) == is => self.output.get_ref().check(),
            Ok(_) => Err(gone),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Err(gone),
            Err(error) => Err(error.into()),
        }
    }

    /// Gives the finished file its name.
    pub(crate) fn commit(mut self) -> Result<(), WriteError> {
        self.flush()?;
        if self.is.is_none() {
            return Ok(());
        }
        if self.sync {
            self.output.get_ref().file.sync_all()?;
        }
        let (part, path) = (&self.part, &self.path);
        if self.overwrite {
            fs::rename(part, path)?;
        } else {
            match rustix::fs::renameat_with(CWD, part, CWD, path, RenameFlags::NOREPLACE) {
                Ok(()) => {}
                Err(Errno::EXIST) => return Err(WriteError::Exists { path: path.clone() }),
                // Not every file system can; a link does not replace anything either.
                Err(Errno::INVAL | Errno::NOSYS) => {
                    fs::hard_link(part, path).and_then(|()| fs::remove_file(part))?;
                }
                Err(error) => return Err(io::Error::from(error).into()),
            }
        }
        self.part = self.path.clone();
        self.check()?;
        if self.sync {
            let folder = self.path.parent().filter(|folder| !folder.as_os_str().is_empty());
            File::open(folder.unwrap_or(Path::new(".")))?.sync_all()?;
        }
        Ok(())
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.output.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.flush()?;
        if self.sync {
            self.output.get_ref().file.sync_data()?;
        }
        self.check().map_err(io::Error::other)
    }
}
