//! Domains for tests.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

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
    /// Prefixes of its files in memory: new ones each time that somebody comes first.
    prefixes: Mutex<BTreeSet<String>>,
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
            prefixes: Mutex::default(),
            started: AtomicU32::new(0),
            killed: Arc::default(),
        }
    }

    /// The domain for the ports of this process.
    pub fn domain(&self) -> Domain {
        Domain::new(&self.name).expect("the name is possible").under(&self.root())
    }

    /// The directory under which the programs of this test find their domains.
    pub fn root(&self) -> PathBuf {
        self.path("root")
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
        command.args(arguments).env_remove("RUST_LOG");
        self.start_command(name, command, stdin)
    }

    /// The same for a program that others start, or in an environment of its own.
    pub fn start_command(&self, name: &str, mut command: Command, stdin: Option<&str>) -> Process {
        command.current_dir(self.directory.path()).env(bus::ROOT_VARIABLE, self.root());
        let number = self.started.fetch_add(1, Ordering::Relaxed);
        let outputs = self.path(&format!("{name}-{number}"));
        Process::start(name, command, outputs, stdin, Arc::clone(&self.killed))
    }

    /// Starts a shell with a script, in the directory of this test.
    pub fn shell(&self, shell: &[&str], script: &str) -> Process {
        let mut command = Command::new(shell[0]);
        command.args(&shell[1..]).arg(script).current_dir(self.directory.path());
        command.env(bus::ROOT_VARIABLE, self.root()).env_remove("RUST_LOG");
        let number = self.started.fetch_add(1, Ordering::Relaxed);
        let outputs = self.path(&format!("shell-{number}"));
        Process::start("shell", command, outputs, None, Arc::clone(&self.killed))
    }

    /// Starts a planner and waits until it is ready.
    #[track_caller]
    pub fn planner(&self, arguments: &[&str]) -> Process {
        let arguments = [&["--domain", &self.name], arguments].concat();
        let mut planner = self.start("planner", &arguments, None);
        planner.wait_until_it_says("ready");
        self.note();
        planner
    }

    /// Starts a recorder and waits until it sees everything.
    #[track_caller]
    pub fn recorder(&self, file: &str, arguments: &[&str]) -> Process {
        let arguments = [&["--domain", &self.name, "-o", file], arguments].concat();
        let mut recorder = self.start("recorder", &arguments, None);
        recorder.wait_until_it_says("recording");
        self.note();
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

    /// Notes what the files of this test's domains in memory are called.
    fn note(&self) {
        let settings = entries(&self.root()).into_iter().filter(|path| path.is_file());
        let texts = settings.map(|path| std::fs::read_to_string(path).unwrap_or_default());
        let mut prefixes = self.prefixes.lock().expect("nobody panics with it");
        for text in texts {
            let mut lines = text.lines();
            let prefix = lines.find_map(|line| line.strip_prefix("prefix = \"")?.strip_suffix('"'));
            prefixes.extend(prefix.map(String::from));
        }
    }

    /// What lies in memory and on disk for this test's domains.
    pub fn left(&self) -> Vec<PathBuf> {
        self.note();
        let prefixes = self.prefixes.lock().expect("nobody panics with it");
        let named = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            prefixes.iter().any(|prefix| name.starts_with(prefix))
        };
        let mut left = entries(Path::new("/dev/shm"));
        left.retain(named);
        let mut directories = entries(&self.root());
        while let Some(directory) = directories.pop() {
            directories.extend(entries(&directory));
            left.push(directory);
        }
        left
    }
}

impl Drop for TestDomain {
    fn drop(&mut self) {
        if self.killed.load(Ordering::Relaxed) {
            // Who is killed clears nothing up.
            self.note();
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

fn entries(directory: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(directory).into_iter().flatten();
    entries.filter_map(|entry| Some(entry.ok()?.path())).collect()
}
