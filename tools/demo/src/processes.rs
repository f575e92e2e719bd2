//! The other processes: this program, started again in another role.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use bus::{Client, ConnectError, Domain, Server, Wait};
use configuration::Config;
use recorder::Settings;
use rustix::process::{Pid, Signal, kill_process};

use crate::Error;

/// Tells a process of this program that it has a role; its value is the role's name.
const ROLE: &str = "CLEARWAY_DEMO_ROLE";

/// What a process of this program does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    Planner,
    Recorder,
}

impl Role {
    fn name(self) -> &'static str {
        match self {
            Self::Planner => "planner",
            Self::Recorder => "recorder",
        }
    }

    /// The role of this process; none for the demo itself.
    pub(crate) fn of_this_process() -> Option<Self> {
        let name = std::env::var(ROLE).ok()?;
        [Self::Planner, Self::Recorder].into_iter().find(|role| role.name() == name)
    }

    /// Plays the role until told to stop.
    pub(crate) fn run(self) -> ExitCode {
        let mut arguments = std::env::args_os().skip(1);
        let (Some(domain), Some(recording)) = (arguments.next(), arguments.next()) else {
            return ExitCode::from(2);
        };
        let played =
            domain.to_string_lossy().parse::<Domain>().map_err(Error::from).and_then(|domain| {
                match self {
                    Self::Planner => serve(&domain),
                    Self::Recorder => record(domain, recording.into()),
                }
            });
        played.unwrap_or_else(|error| {
            eprintln!("demo, {}: {error}", self.name());
            ExitCode::FAILURE
        })
    }
}

fn serve(domain: &Domain) -> Result<ExitCode, Error> {
    let mut server = Server::open(domain, &planner::service::server_options(&Config::default()))?;
    planner::service::serve(&mut server, &Config::default());
    Ok(ExitCode::SUCCESS)
}

fn record(domain: Domain, output: PathBuf) -> Result<ExitCode, Error> {
    let summary = recorder::run(&Settings {
        output,
        domain,
        overwrite: false,
        duration: None,
        flush: recording::FLUSH_INTERVAL,
        wait: Duration::from_secs(10),
    })?;
    Ok(if summary.lost == 0 { ExitCode::SUCCESS } else { ExitCode::from(3) })
}

/// A process in a role. Dropped, it is killed.
pub(crate) struct Child {
    child: std::process::Child,
    role: Role,
}

impl Child {
    pub(crate) fn start(role: Role, domain: &Domain, recording: &Path) -> Result<Self, Error> {
        let child = Command::new(std::env::current_exe()?)
            .env(ROLE, role.name())
            .arg(domain.to_string())
            .arg(recording)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .spawn()?;
        Ok(Self { child, role })
    }

    /// Asks it to end, as a service manager would, and waits; its exit code.
    pub(crate) fn stop(mut self) -> Result<u8, Error> {
        kill_process(Pid::from_child(&self.child), Signal::TERM)?;
        let status = self.child.wait()?;
        status
            .code()
            .and_then(|code| u8::try_from(code).ok())
            .ok_or_else(|| format!("the {} ended by {status}", self.role.name()).into())
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        // Nothing to do for one that has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A connection to the planner, as soon as it is up.
pub(crate) fn connect(domain: &Domain, patience: Duration) -> Result<Client, Error> {
    let until = Instant::now() + patience;
    loop {
        match Client::connect(domain, Wait::Hybrid) {
            Err(ConnectError::NoPlanner { .. }) if Instant::now() < until => {
                std::thread::sleep(Duration::from_millis(5));
            }
            done => return Ok(done?),
        }
    }
}

/// Waits until the recorder has opened its file: from then on it sees everything.
pub(crate) fn wait_for_file(path: &Path, patience: Duration) -> Result<(), Error> {
    let until = Instant::now() + patience;
    while !path.exists() {
        if Instant::now() >= until {
            return Err(format!("the recorder has not opened {}", path.display()).into());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}
