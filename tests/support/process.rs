//! Processes that end with their test.

use std::fs::{self, File};
use std::io::Write;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal};

use crate::{LONG, wait_for};

/// A running program; what it prints goes to files. Dropped, it is asked to end and waited
/// for; when the test has failed, it is killed.
#[derive(Debug)]
pub struct Process {
    name: String,
    child: Child,
    ended: Option<ExitStatus>,
    stdout: PathBuf,
    stderr: PathBuf,
    /// Whether anybody in the domain was killed, so that others have to clear up.
    killed: Arc<AtomicBool>,
}

/// Sends a signal to a process of this test.
pub fn kill_process(child: &Child, signal: Signal) {
    rustix::process::kill_process(Pid::from_child(child), signal).expect("the process is there");
}

/// Sends a signal to a process that one of this test has started.
pub fn kill_pid(process: u32, signal: Signal) {
    let pid = i32::try_from(process).ok().and_then(Pid::from_raw).expect("a process");
    rustix::process::kill_process(pid, signal).expect("the process is there");
}

/// Sends a signal to a process of this test and all of its process group, as a terminal does.
pub fn kill_group(leader: &Child, signal: Signal) {
    rustix::process::kill_process_group(Pid::from_child(leader), signal).expect("it leads a group");
}

/// How a program ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Ended {
    /// Its exit code; none when a signal ended it.
    pub code: Option<i32>,
    /// What it printed.
    pub stdout: String,
    /// What it said beside.
    pub stderr: String,
}

impl Process {
    /// Starts `command`, whose output goes to `<outputs>.stdout` and `<outputs>.stderr`.
    pub(crate) fn start(
        name: &str,
        mut command: Command,
        outputs: PathBuf,
        stdin: Option<&str>,
        killed: Arc<AtomicBool>,
    ) -> Self {
        let [stdout, stderr] = ["stdout", "stderr"].map(|kind| outputs.with_extension(kind));
        let create = |path| File::create(path).expect("the test's directory takes files");
        command.stdout(create(&stdout)).stderr(create(&stderr));
        command.stdin(if stdin.is_some() { Stdio::piped() } else { Stdio::null() });
        let mut child = command.spawn().unwrap_or_else(|error| panic!("{name}: {error}"));
        if let Some(text) = stdin {
            let mut input = child.stdin.take().expect("it is piped");
            // Who stops reading early shows it by what it prints.
            let _ = input.write_all(text.as_bytes());
        }
        Self { name: name.to_owned(), child, ended: None, stdout, stderr, killed }
    }

    /// The number of its process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Sends it a signal.
    pub fn signal(&self, signal: Signal) {
        if signal == Signal::KILL {
            self.killed.store(true, Ordering::Relaxed);
        }
        kill_process(&self.child, signal);
    }

    /// What it has said on stderr so far.
    pub fn stderr(&self) -> String {
        fs::read_to_string(&self.stderr).expect("it says UTF-8")
    }

    /// Waits until it has said `text` on stderr.
    #[track_caller]
    pub fn wait_until_it_says(&mut self, text: &str) {
        let what = format!("{} to say {text:?}", self.name);
        wait_for(&what, || {
            let said = self.stderr();
            let ended = self.child.try_wait().expect("it can be waited for");
            assert!(ended.is_none(), "{} ended instead of saying {text:?}: {said}", self.name);
            said.contains(text).then_some(())
        });
    }

    /// Whether it has ended.
    pub fn has_ended(&mut self) -> bool {
        self.ended = self.ended.or_else(|| self.child.try_wait().expect("it can be waited for"));
        self.ended.is_some()
    }

    /// Waits until it ends by itself.
    #[track_caller]
    pub fn wait(mut self) -> Ended {
        wait_for(&format!("{} to end", self.name), || self.has_ended().then_some(()));
        let read = |path| fs::read_to_string(path).expect("programs print UTF-8");
        Ended {
            code: self.ended.and_then(|status| status.code()),
            stdout: read(&self.stdout),
            stderr: read(&self.stderr),
        }
    }

    /// Asks it to end as a service manager would, and waits.
    #[track_caller]
    pub fn stop(self) -> Ended {
        self.signal(Signal::TERM);
        self.wait()
    }

    /// Ends it as a crash would.
    #[track_caller]
    pub fn kill(self) -> Ended {
        self.signal(Signal::KILL);
        self.wait()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if self.has_ended() {
            return;
        }
        let mut patience = LONG;
        if std::thread::panicking() {
            eprintln!("{} said: {}", self.name, self.stderr());
            patience = Duration::ZERO;
        }
        let until = Instant::now() + patience;
        self.signal(Signal::TERM);
        while !self.has_ended() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(2));
        }
        if !self.has_ended() {
            self.signal(Signal::KILL);
            let _ = self.child.wait();
            assert!(std::thread::panicking(), "{} did not end when told to", self.name);
        }
    }
}
