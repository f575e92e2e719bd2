//! The directory under which a user's domains keep their small files.

use std::fs::{DirBuilder, File, Permissions};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::fs::{Access, CWD, FlockOperation, Mode, OFlags};
use rustix::io::Errno;
use thiserror::Error;

/// The environment variable that chooses the directory.
pub const ROOT_VARIABLE: &str = "CLEARWAY_ROOT";

/// Longest path of the directory, bytes: below it are sockets, whose paths have at most 107.
const MOST_PATH: usize = 40;

/// Why the directory can't be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("can't use the directory {} for the files of domains: {problem}", path.display())]
pub struct RootError {
    /// The directory.
    pub path: PathBuf,
    /// What is wrong with it.
    pub problem: RootProblem,
}

/// What is wrong with the directory.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RootProblem {
    /// Relative paths mean something else in every process.
    #[error("set {ROOT_VARIABLE} to an absolute path")]
    Relative,
    /// Sockets below it would have no names.
    #[error(
        "its path has {length} bytes, at most {MOST_PATH} are possible; set {ROOT_VARIABLE} to a shorter one"
    )]
    Long {
        /// Bytes of the path.
        length: usize,
    },
    /// It is not a directory, or only by way of a symbolic link.
    #[error(
        "it is not a directory of its own (a file, or a symbolic link); set {ROOT_VARIABLE} to another"
    )]
    NoDirectory,
    /// Somebody else could remove what is in it.
    #[error(
        "it belongs to the user with id {owner}, this program runs as {user}; set {ROOT_VARIABLE} to a \
         directory of your own"
    )]
    Owner {
        /// Whose it is.
        owner: u32,
        /// Who wants to use it.
        user: u32,
    },
    /// Others could enter.
    #[error("its mode is {mode:03o}, others can enter; run `chmod 700` on it")]
    Mode {
        /// The permissions.
        mode: u32,
    },
    /// A program that starts or ends in it does not get on.
    #[error(
        "another program that is starting or ending has locked it for {waited:?}; end that, and try again"
    )]
    Locked {
        /// Time waited.
        waited: Duration,
    },
    /// A file in it makes no sense.
    #[error(
        "its file {0} is damaged; end the programs that use the domain, remove the file, and try again"
    )]
    Damaged(String),
    /// It can't be made.
    #[error(
        "the directory that it would be in does not exist; make that, or set {ROOT_VARIABLE} to another"
    )]
    NoParent,
    /// The operating system refused.
    #[error("{0}; set {ROOT_VARIABLE} to a directory where you can make files")]
    System(String),
}

impl From<io::Error> for RootProblem {
    fn from(error: io::Error) -> Self {
        Self::System(error.to_string())
    }
}

/// The directory, locked until this is dropped: nobody joins or leaves a domain meanwhile.
#[derive(Debug)]
pub(crate) struct Root {
    path: PathBuf,
    /// Whether somebody has chosen it: then it stays when it is empty.
    is_chosen: bool,
    _locked: File,
}

impl Root {
    /// Locks the directory. Without `create`, gives none if it does not exist.
    pub(crate) fn lock(
        chosen: Option<&Path>,
        create: bool,
        patience: Duration,
    ) -> Result<Option<Self>, RootError> {
        let (path, is_chosen) = find(chosen)?;
        let begin = Instant::now();
        let failed = |problem| RootError { path: path.clone(), problem };
        loop {
            let Some(directory) = open(&path, create).map_err(failed)? else { return Ok(None) };
            while let Err(error) =
                rustix::fs::flock(&directory, FlockOperation::NonBlockingLockExclusive)
            {
                let waited = begin.elapsed();
                match error {
                    Errno::WOULDBLOCK | Errno::INTR if waited < patience => {
                        std::thread::sleep(Duration::from_micros(500));
                    }
                    Errno::WOULDBLOCK | Errno::INTR => {
                        return Err(failed(RootProblem::Locked { waited }));
                    }
                    error => return Err(failed(io::Error::from(error).into())),
                }
            }
            // Whoever left last may have removed the directory meanwhile.
            if is_at(&directory, &path) {
                return Ok(Some(Self { path, is_chosen, _locked: directory }));
            }
        }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Removes the directory if it is empty, unless somebody has chosen it.
    pub(crate) fn remove_if_empty(self) {
        if !self.is_chosen {
            let _ = std::fs::remove_dir(&self.path);
        }
    }
}

/// The directory's path, and whether somebody has chosen it.
pub(crate) fn find(chosen: Option<&Path>) -> Result<(PathBuf, bool), RootError> {
    let variable = |name| std::env::var_os(name).filter(|value| !value.is_empty());
    let chosen = chosen.map(Path::to_owned).or_else(|| variable(ROOT_VARIABLE).map(PathBuf::from));
    if let Some(path) = chosen {
        let length = path.as_os_str().len();
        let problem = match () {
            () if !path.is_absolute() => RootProblem::Relative,
            () if length > MOST_PATH => RootProblem::Long { length },
            () => return Ok((path, true)),
        };
        return Err(RootError { path, problem });
    }
    let runtime = variable("XDG_RUNTIME_DIR").map(PathBuf::from).filter(|path| is_usable(path));
    let default = runtime.map(|path| path.join("clearway"));
    let default = default.filter(|path| path.as_os_str().len() <= MOST_PATH);
    let user = rustix::process::geteuid().as_raw();
    Ok((default.unwrap_or_else(|| format!("/tmp/clearway-{user}").into()), false))
}

/// Whether a runtime directory is this user's, as the standard says it is.
fn is_usable(path: &Path) -> bool {
    path.is_absolute()
        && std::fs::symlink_metadata(path)
            .is_ok_and(|found| found.is_dir() && check(&found).is_ok())
        && rustix::fs::access(path, Access::WRITE_OK | Access::EXEC_OK).is_ok()
}

/// Opens the directory; without `create`, gives none if it does not exist.
pub(crate) fn open(path: &Path, create: bool) -> Result<Option<File>, RootProblem> {
    let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
    loop {
        match rustix::fs::openat(CWD, path, flags, Mode::empty()) {
            Ok(directory) => {
                let directory = File::from(directory);
                let found = directory.metadata()?;
                check(&found)?;
                if found.mode() & 0o700 != 0o700 {
                    // iceoryx2 changes the umask of the whole process while it binds a socket.
                    directory.set_permissions(Permissions::from_mode(0o700))?;
                }
                return Ok(Some(directory));
            }
            Err(Errno::NOENT) if create => {
                let made = DirBuilder::new().mode(0o700).create(path);
                made.or_else(|error| match error.kind() {
                    io::ErrorKind::AlreadyExists => Ok(()),
                    io::ErrorKind::NotFound => Err(RootProblem::NoParent),
                    _ => Err(error.into()),
                })?;
            }
            Err(Errno::NOENT) => return Ok(None),
            Err(Errno::ACCESS) => {
                // Its owner is to be seen even so.
                std::fs::symlink_metadata(path)
                    .map_err(RootProblem::from)
                    .and_then(|found| check(&found))?;
                return Err(io::Error::from(Errno::ACCESS).into());
            }
            Err(Errno::NOTDIR | Errno::LOOP) => return Err(RootProblem::NoDirectory),
            Err(error) => return Err(io::Error::from(error).into()),
        }
    }
}

/// Whether a directory is this user's alone.
fn check(found: &std::fs::Metadata) -> Result<(), RootProblem> {
    let (owner, user) = (found.uid(), rustix::process::geteuid().as_raw());
    let mode = found.mode() & 0o777;
    match () {
        () if owner != user => Err(RootProblem::Owner { owner, user }),
        () if mode & 0o077 != 0 => Err(RootProblem::Mode { mode }),
        () => Ok(()),
    }
}

/// Whether an open directory still is the one at `path`.
fn is_at(directory: &File, path: &Path) -> bool {
    let same = |open: std::fs::Metadata, there: std::fs::Metadata| {
        (open.dev(), open.ino()) == (there.dev(), there.ino())
    };
    directory
        .metadata()
        .is_ok_and(|open| std::fs::symlink_metadata(path).is_ok_and(|there| same(open, there)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A directory for this test.
    fn scratch(name: &str) -> PathBuf {
        let path = PathBuf::from(format!("/tmp/root-{}-{name}", std::process::id()));
        DirBuilder::new().mode(0o700).create(&path).unwrap();
        path
    }

    #[track_caller]
    fn problem(path: &Path) -> RootProblem {
        Root::lock(Some(path), true, Duration::ZERO).unwrap_err().problem
    }

    #[test]
    fn a_directory_of_others_is_refused() {
        let path = scratch("modes");
        std::fs::set_permissions(&path, Permissions::from_mode(0o750)).unwrap();
        assert_eq!(problem(&path), RootProblem::Mode { mode: 0o750 });
        std::fs::remove_dir(&path).unwrap();
        if rustix::process::geteuid().is_root() {
            let path = scratch("owners");
            std::os::unix::fs::chown(&path, Some(65534), None).unwrap();
            assert_eq!(problem(&path), RootProblem::Owner { owner: 65534, user: 0 });
            std::fs::remove_dir(&path).unwrap();
        }
    }

    #[test]
    fn a_directory_made_under_a_narrow_umask_is_opened_to_its_owner() {
        let path = scratch("umask");
        std::fs::set_permissions(&path, Permissions::from_mode(0o600)).unwrap();
        drop(Root::lock(Some(&path), true, Duration::ZERO).unwrap().unwrap());
        assert_eq!(std::fs::metadata(&path).unwrap().mode() & 0o777, 0o700);
        std::fs::remove_dir(&path).unwrap();
    }

    #[test]
    fn links_and_files_are_refused() {
        let path = scratch("links");
        let (link, file) = (path.join("link"), path.join("file"));
        std::os::unix::fs::symlink(&path, &link).unwrap();
        std::fs::write(&file, "").unwrap();
        assert_eq!(problem(&link), RootProblem::NoDirectory);
        assert_eq!(problem(&file), RootProblem::NoDirectory);
        std::fs::remove_dir_all(&path).unwrap();
    }

    #[test]
    fn paths_are_absolute_and_short() {
        assert_eq!(problem(Path::new("here")), RootProblem::Relative);
        assert_eq!(problem(Path::new("/nowhere/at/all")), RootProblem::NoParent);
        let long = format!("/tmp/{}", "x".repeat(MOST_PATH));
        assert_eq!(problem(Path::new(&long)), RootProblem::Long { length: MOST_PATH + 5 });
    }

    #[test]
    fn a_missing_directory_is_made_for_the_user_alone_and_locked() {
        let path = scratch("missing").join("root");
        assert!(Root::lock(Some(&path), false, Duration::ZERO).unwrap().is_none());
        let root = Root::lock(Some(&path), true, Duration::ZERO).unwrap().unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().mode() & 0o777, 0o700);
        assert!(matches!(problem(&path), RootProblem::Locked { .. }));
        root.remove_if_empty();
        assert!(path.exists(), "it was chosen");
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }
}
