//! The other processes: this program, started again in another role.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use bus::{CallError, Domain, Server};
use configuration::Config;
use program::{Diagnostics, Exit, LogFormat};
use recorder::{Ended, Settings};
use recording::Finished;
use rustix::process::{Pid, Signal, kill_process};

use crate::Error;

/// Set in a process of this program that plays a role; its value is the role's name.
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

    /// The role of this process, if it isn't the demo itself.
    pub(crate) fn of_this_process() -> Option<Self> {
        let name = std::env::var(ROLE).ok()?;
        [Self::Planner, Self::Recorder].into_iter().find(|role| role.name() == name)
    }

    /// The name that its errors begin with.
    pub(crate) fn program(self) -> &'static str {
        match self {
            Self::Planner => "demo (planner)",
            Self::Recorder => "demo (recorder)",
        }
    }

    /// Plays the role until a signal asks it to end.
    pub(crate) fn run(self) -> Result<Exit, Error> {
        program::start_diagnostics(Diagnostics::Warnings, LogFormat::Text);
        bus::forward_to_tracing();
        let mut arguments = std::env::args_os().skip(1);
        let (Some(domain), Some(recording)) = (arguments.next(), arguments.next()) else {
            return Ok(Exit::Usage);
        };
        let domain = domain.to_string_lossy().parse::<Domain>()?;
        match self {
            Self::Planner => serve(&domain),
            Self::Recorder => record(domain, recording.into()),
        }
    }
}

fn serve(domain: &Domain) -> Result<Exit, Error> {
    let config = Config::default();
    let mut server = Server::open(domain, &planner::options::server_options(&config))?;
    planner::service::serve((&mut server, domain), &config, None)?;
    Ok(Exit::Done)
}

fn record(domain: Domain, output: PathBuf) -> Result<Exit, Error> {
    let Ended { finished: Finished { summary, .. }, .. } =
        recorder::run(&Settings::new(output, domain))?;
    Ok(if summary.lost == 0 { Exit::Done } else { Exit::Lost })
}

/// A process in a role. Dropped, it is asked to end, and killed if it doesn't.
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
        self.signal()?;
        let status = self.child.wait()?;
        status
            .code()
            .and_then(|code| u8::try_from(code).ok())
            .ok_or_else(|| format!("the {} ended by {status}", self.role.name()).into())
    }

    fn signal(&self) -> std::io::Result<()> {
        Ok(kill_process(Pid::from_child(&self.child), Signal::TERM)?)
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        const PATIENCE: Duration = Duration::from_secs(2);
        if !matches!(self.child.try_wait(), Ok(None)) || self.signal().is_err() {
            return;
        }
        let until = Instant::now() + PATIENCE;
        while matches!(self.child.try_wait(), Ok(None)) {
            if Instant::now() >= until {
                let _ = self.child.kill();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Removes what is left of a domain that nobody uses any more.
pub(crate) struct Tidy<'a>(pub(crate) &'a Domain);

impl Drop for Tidy<'_> {
    fn drop(&mut self) {
        self.0.tidy();
    }
}

/// Waits until the recorder has opened its file: from then on it sees everything.
pub(crate) fn wait_for_file(path: &Path, patience: Duration) -> Result<(), Error> {
    let until = Instant::now() + patience;
    let part = path.with_added_extension("part");
    while !part.exists() {
        if bus::terminated() {
            return Err(CallError::Interrupted.into());
        }
        if Instant::now() >= until {
            return Err(format!("the recorder did not open {}", path.display()).into());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}
