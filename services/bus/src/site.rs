//! Where a domain's files are.
//!
//! Under the user's directory, each domain has a file `NAME.toml`, which names a directory and
//! the prefix of its files in shared memory; as a configuration of iceoryx2 it shows the
//! domain to iceoryx2's own tools. Both names are random, so that equal names of domains of
//! two users do not meet in `/dev/shm`, and short, as paths of sockets have at most 107 bytes.

use std::fs::{DirBuilder, File, OpenOptions, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::prelude::{Config, FileName, Path as IoxPath, SemanticString};
use rustix::fs::{AtFlags, CWD, FlockOperation, Timespec, Timestamps, UTIME_NOW};

use crate::root::RootProblem;

/// Where shared memory appears as files.
pub(crate) const MEMORY: &str = "/dev/shm";

/// Letters of the random part of names.
const LETTERS: &[u8; 32] = b"abcdefghijklmnopqrstuvwxyz234567";

/// Length of the random part: 40 bits.
const KEY: usize = 8;

/// The file in which iceoryx2 counts the nodes of a domain, after the prefix. It makes it with
/// mode 666 if it is not there, so it is made here. (The digits are the SHA-1 of the type's name.)
const COUNTER: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt";

/// What it contains at first: the version, 0.10.0, and no node.
const COUNTER_BYTES: [u8; 16] = [0, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];

/// How its name ends, in any version.
const COUNTER_END: &str = ".global_mgmt";

/// Where a domain's files are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Site {
    root: PathBuf,
    name: String,
    key: String,
}

impl Site {
    /// Finds that of the domain `name`, if there is one.
    pub(crate) fn find(root: &Path, name: &str) -> Result<Option<Self>, RootProblem> {
        let file = settings(root, name);
        let text = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) if error.kind() == io::ErrorKind::InvalidData => String::new(),
            Err(error) => return Err(error.into()),
        };
        let key =
            text.lines().find_map(|line| line.strip_prefix("prefix = \"cw_")?.strip_suffix("_\""));
        let key = key.filter(|key| key.len() == KEY && key.bytes().all(|c| LETTERS.contains(&c)));
        let damaged = || RootProblem::Damaged(format!("{name}.toml"));
        let site =
            Self { root: root.into(), name: name.into(), key: key.ok_or_else(damaged)?.into() };
        if site.text() == text { Ok(Some(site)) } else { Err(damaged()) }
    }

    /// All domains there.
    pub(crate) fn all(root: &Path) -> io::Result<Vec<Self>> {
        let mut names = Vec::new();
        for entry in std::fs::read_dir(root)? {
            let name = entry?.file_name();
            names.extend(
                name.to_str().and_then(|name| name.strip_suffix(".toml")).map(String::from),
            );
        }
        names.sort();
        // What was removed or is damaged is no domain.
        Ok(names.iter().filter_map(|name| Self::find(root, name).ok().flatten()).collect())
    }

    /// Makes one, under the lock of the root.
    pub(crate) fn create(root: &Path, name: &str) -> Result<Self, RootProblem> {
        let random = getrandom::u64().map_err(|error| RootProblem::System(error.to_string()))?;
        let letter = |at: usize| char::from(LETTERS[(random >> (5 * at)) as usize % LETTERS.len()]);
        let key = (0..KEY).map(letter).collect();
        let site = Self { root: root.into(), name: name.into(), key };
        // First of all, so that a kill at any time leaves nothing that nobody finds.
        let new = root.join("new");
        let mut file =
            OpenOptions::new().write(true).create(true).truncate(true).mode(0o600).open(&new)?;
        file.write_all(site.text().as_bytes())?;
        drop(file);
        std::fs::rename(new, settings(root, name))?;
        site.furnish()?;
        Ok(site)
    }

    /// Makes what is missing: all of it at first, nothing otherwise.
    pub(crate) fn furnish(&self) -> io::Result<()> {
        for directory in [self.directory(), self.visitors()] {
            match DirBuilder::new().mode(0o700).create(&directory) {
                Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
                // iceoryx2 changes the umask of the whole process while it binds a socket.
                _ => std::fs::set_permissions(directory, Permissions::from_mode(0o700))?,
            }
        }
        let counter = Path::new(MEMORY).join(format!("{}{COUNTER}", self.prefix()));
        match OpenOptions::new().write(true).create_new(true).mode(0o600).open(counter) {
            Ok(mut file) => file.write_all(&COUNTER_BYTES),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Ok(()),
            Err(error) => Err(error),
        }
    }

    /// Keeps what removes old files, as systemd does in `/tmp`, from the directory for as long as
    /// the result is open: it leaves alone what is locked.
    pub(crate) fn keep(&self) -> io::Result<File> {
        let directory = File::open(self.directory())?;
        rustix::fs::flock(&directory, FlockOperation::LockShared)?;
        Ok(directory)
    }

    /// Makes the file that leads here look new.
    pub(crate) fn renew(&self) {
        let now = Timespec { tv_sec: 0, tv_nsec: UTIME_NOW };
        let now = Timestamps { last_access: now, last_modification: now };
        let file = settings(&self.root, &self.name);
        let _ = rustix::fs::utimensat(CWD, file, &now, AtFlags::SYMLINK_NOFOLLOW);
    }

    /// Takes from others what another version of iceoryx2 gave them.
    pub(crate) fn close_to_others(&self) {
        for name in self.in_memory().iter().filter(|name| name.ends_with(COUNTER_END)) {
            let path = Path::new(MEMORY).join(name);
            // Only the owner can; shared memory has no links.
            let _ = std::fs::set_permissions(path, Permissions::from_mode(0o600));
        }
    }

    /// Removes everything, under the lock of the root.
    pub(crate) fn remove(&self) {
        let memory = self.in_memory();
        let mut removed: Vec<_> =
            memory.iter().map(|name| std::fs::remove_file(Path::new(MEMORY).join(name))).collect();
        removed.push(std::fs::remove_dir_all(self.directory()));
        let gone = |result: &io::Result<()>| match result {
            Err(error) => error.kind() == io::ErrorKind::NotFound,
            Ok(()) => true,
        };
        if let Some(Err(error)) = removed.iter().find(|result| !gone(result)) {
            tracing::debug!(domain = self.name, %error, "could not remove all files");
        }
        let _ = std::fs::remove_file(self.root.join("new"));
        // Last, as it leads to the others.
        let _ = std::fs::remove_file(settings(&self.root, &self.name));
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The prefix of its files.
    pub(crate) fn prefix(&self) -> String {
        format!("cw_{}_", self.key)
    }

    /// The directory of iceoryx2's small files and sockets.
    pub(crate) fn directory(&self) -> PathBuf {
        self.root.join(&self.key)
    }

    /// The directory of iceoryx2's nodes, one for each program.
    pub(crate) fn nodes(&self) -> PathBuf {
        self.directory().join("nodes")
    }

    /// The directory in which programs show that they live.
    pub(crate) fn visitors(&self) -> PathBuf {
        self.directory().join("visitors")
    }

    /// The names of its files in shared memory.
    pub(crate) fn in_memory(&self) -> Vec<String> {
        let prefix = self.prefix();
        names(Path::new(MEMORY)).filter(|name| name.starts_with(&prefix)).collect()
    }

    pub(crate) fn config(&self) -> Config {
        let mut config = Config::default();
        config.global.prefix = FileName::new(self.prefix().as_bytes()).expect("letters and '_'");
        let directory = self.directory();
        let directory = directory.as_os_str().as_encoded_bytes();
        config.global.set_root_path(&IoxPath::new(directory).expect("its length was checked"));
        // Opening a service takes as long as a busy machine needs.
        config.global.creation_timeout = Duration::from_secs(5);
        // The janitor does it: by itself, iceoryx2 leaves some files of the dead for ever.
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
        // Clients that leave before their requests are taken stay in it; full, it ends the planner.
        config.defaults.request_response.server_expired_connection_buffer = 1024;
        config
    }

    fn text(&self) -> String {
        format!(
            "# A domain of Clearway. As config/iceoryx2.toml it shows the domain to iceoryx2's tools.\n\
             [global]\nroot-path = {:?}\nprefix = \"{}\"\n",
            self.directory(),
            self.prefix()
        )
    }
}

/// The file that leads to a domain's others.
fn settings(root: &Path, name: &str) -> PathBuf {
    root.join(format!("{name}.toml"))
}

/// The names in a directory, if it can be read.
pub(crate) fn names(directory: &Path) -> impl Iterator<Item = String> {
    let entries = std::fs::read_dir(directory).into_iter().flatten();
    entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok())
}

/// Opens a file that may vanish at any time.
pub(crate) fn open(path: &Path) -> Option<File> {
    File::open(path).ok()
}
