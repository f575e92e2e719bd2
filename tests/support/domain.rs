//! Domains for tests.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use bus::{Client, ConnectError, Domain, Wait};
use tempfile::TempDir;

use crate::{Ended, Process, program, wait_for};

/// A domain that nobody else uses, and a directory for files. In the end nothing of the
/// domain may be left in memory or on disk.
///
/// Declare it first in a test: what is declared later is dropped, and so ended, before.
#[derive(Debug)]
pub struct TestDomain {
    name: String,
    directory: TempDir,
    started: AtomicU32,
    killed: Arc<AtomicBool>,
}

impl TestDomain {
    /// A new domain.
    #[expect(clippy::new_without_default, reason = "no two are equal")]
    pub fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        Self {
            name: format!("it-{}-{count}", std::process::id()),
            directory: TempDir::new().expect("the system has room for files"),
            started: AtomicU32::new(0),
            killed: Arc::default(),
        }
    }

    /// The domain for the ports of this process.
    pub fn domain(&self) -> Domain {
        Domain::new(&self.name).expect("the name is possible")
    }

    /// A file of this test.
    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// Writes a file of this test.
    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).expect("the test's directory takes files");
        path
    }

    /// Starts a program as it is told, in the directory of this test.
    pub fn start(&self, name: &str, arguments: &[&str], stdin: Option<&str>) -> Process {
        let mut command = Command::new(program(name));
        command.args(arguments).current_dir(self.directory.path()).env_remove("RUST_LOG");
        let number = self.started.fetch_add(1, Ordering::Relaxed);
        let outputs = self.path(&format!("{name}-{number}"));
        Process::start(name, command, outputs, stdin, Arc::clone(&self.killed))
    }

    /// Starts a planner and waits until it is ready.
    #[track_caller]
    pub fn planner(&self, arguments: &[&str]) -> Process {
        let arguments = [&["--domain", &self.name], arguments].concat();
        let mut planner = self.start("planner", &arguments, None);
        planner.wait_until_it_says("ready");
        planner
    }

    /// Starts a recorder and waits until it sees everything.
    #[track_caller]
    pub fn recorder(&self, file: &str, arguments: &[&str]) -> Process {
        let arguments = [&["--domain", &self.name, "-o", file], arguments].concat();
        let mut recorder = self.start("recorder", &arguments, None);
        recorder.wait_until_it_says("recording");
        recorder
    }

    /// Runs `plan` in this domain.
    #[track_caller]
    pub fn plan(&self, arguments: &[&str]) -> Ended {
        let arguments = [&["--domain", &self.name, "--timeout", "60s"], arguments].concat();
        self.start("plan", &arguments, None).wait()
    }

    /// Runs `plan` in this domain on scenes, a line each, with JSON Lines for replies.
    #[track_caller]
    pub fn plan_lines(&self, lines: &str) -> Ended {
        let arguments = ["--domain", &self.name, "--timeout", "60s", "--format", "json", "-"];
        self.start("plan", &arguments, Some(lines)).wait()
    }

    /// Runs a program that takes no part in the domain.
    #[track_caller]
    pub fn run(&self, name: &str, arguments: &[&str]) -> Ended {
        self.start(name, arguments, None).wait()
    }

    /// Connects this process to the planner of this domain, as soon as it is up.
    #[track_caller]
    pub fn connect(&self) -> Client {
        wait_for("a planner", || match Client::connect(&self.domain(), Wait::Hybrid) {
            Err(ConnectError::NoPlanner { .. }) => None,
            done => Some(done.expect("there is a place for a client")),
        })
    }

    /// What lies in memory and on disk for this domain.
    pub fn left(&self) -> Vec<PathBuf> {
        left_by(&self.name)
    }
}

impl Drop for TestDomain {
    fn drop(&mut self) {
        if self.killed.load(Ordering::Relaxed) {
            // Who is killed clears nothing up; whoever joins next does. There is no planner to
            // connect to.
            let _ = Client::connect(&self.domain(), Wait::Poll);
            self.domain().tidy();
        }
        let left = self.left();
        for path in &left {
            let _ = std::fs::remove_file(path).or_else(|_| std::fs::remove_dir_all(path));
        }
        if !std::thread::panicking() {
            assert!(left.is_empty(), "{} left behind {left:?}", self.name);
        }
    }
}

/// What lies in memory and on disk for the domain with this name.
pub fn left_by(domain: &str) -> Vec<PathBuf> {
    let prefix = format!("iox2_{domain}_");
    let named = |name: &OsStr| name.to_string_lossy().starts_with(&prefix);
    let mut left = entries(Path::new("/dev/shm"));
    left.retain(|path| path.file_name().is_some_and(named));
    let mut directories = vec![Path::new("/tmp/iceoryx2").join(domain)];
    while let Some(directory) = directories.pop() {
        if directory.exists() {
            directories.extend(entries(&directory));
            left.push(directory);
        }
    }
    left
}

fn entries(directory: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(directory).into_iter().flatten();
    entries.filter_map(|entry| Some(entry.ok()?.path())).collect()
}
