//! A process that starts the one which serves, and starts it again when it dies.
//!
//! A peer of the same user can make the bus's library read outside its memory or panic; shared
//! memory that runs out ends a process by SIGBUS. The serving process can't survive that. This one
//! touches no shared memory.

use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

use bus::SUPERVISOR_VARIABLE;
use program::Exit;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{
    Pid, PidfdFlags, Signal, getppid, kill_process, pidfd_open, set_parent_process_death_signal,
};

use crate::manager;

/// How long the process that serves has to end beyond its grace.
const BEYOND_GRACE: Duration = Duration::from_millis(900);

/// Deaths closer together than this are repeated ones.
const QUICK: Duration = Duration::from_secs(1);

/// How long to wait before each start after repeated deaths, at most.
const LONGEST_PAUSE: Duration = Duration::from_secs(1);

/// How long it is tried to start one after the one before has died; until then, what ended that
/// one, such as a lack of memory, may still be in the way.
const PERSISTENCE: Duration = Duration::from_secs(30);

/// The exit code of a program that panicked.
const PANICKED: i32 = 101;

/// Serves under a supervisor: returns in the process that is to serve (`None`), and in the
/// supervisor when that one has ended for good.
///
/// # Errors
///
/// If no process can be started or watched.
pub fn supervise(grace: Duration) -> std::io::Result<Option<Exit>> {
    if let Some(supervisor) = std::env::var_os(SUPERVISOR_VARIABLE) {
        // Whoever kills the supervisor means the planner.
        set_parent_process_death_signal(Some(Signal::KILL))?;
        let lives = getppid().is_some_and(|parent| {
            supervisor.to_str() == Some(parent.as_raw_nonzero().to_string().as_str())
        });
        return Ok((!lives).then_some(Exit::Failure));
    }
    // From now on signals are passed on.
    bus::terminated();
    let watchdog = sd_notify::watchdog_enabled();
    let mut deaths = 0;
    // Since when none has served for long.
    let mut died: Option<Instant> = None;
    loop {
        let begun = Instant::now();
        let mut child = start(watchdog)?;
        let status = watch(&mut child, grace)?;
        let exit = ended(status);
        if begun.elapsed() >= QUICK && exit != Some(Exit::Failure) {
            (deaths, died) = (0, None);
        }
        let pause = match exit {
            Some(Exit::Failure) if died.is_some_and(|died| died.elapsed() < PERSISTENCE) => {
                tracing::error!(pause = ?LONGEST_PAUSE, "the serving process can't start again yet");
                LONGEST_PAUSE
            }
            Some(exit) => return Ok(Some(exit)),
            None => {
                let pause = match deaths {
                    0 => Duration::ZERO,
                    deaths => LONGEST_PAUSE.min(Duration::from_millis(10 << deaths.min(7))),
                };
                let cause = cause(status);
                tracing::error!(
                    cause = cause.as_str(),
                    ?pause,
                    "the serving process died; starting another"
                );
                manager::restarting(&cause);
                deaths += 1;
                died.get_or_insert_with(Instant::now);
                pause
            }
        };
        if ends_within(pause) {
            return Ok(Some(Exit::Done));
        }
    }
}

fn start(watchdog: Option<Duration>) -> std::io::Result<Child> {
    // Also when the file was replaced meanwhile.
    let program = std::env::current_exe().ok().filter(|path| path.is_file());
    let mut command = Command::new(program.unwrap_or_else(|| "/proc/self/exe".into()));
    command.args(std::env::args_os().skip(1));
    command.env(SUPERVISOR_VARIABLE, std::process::id().to_string());
    if watchdog.is_some() {
        // It is meant for this process, and answered by the one that serves.
        command.env_remove("WATCHDOG_PID");
    }
    command.spawn()
}

/// Passes signals that ask to end on to the child, until it has ended.
fn watch(child: &mut Child, grace: Duration) -> std::io::Result<ExitStatus> {
    let pid = Pid::from_child(child);
    let process = pidfd_open(pid, PidfdFlags::empty())?;
    let mut until: Option<Instant> = None;
    loop {
        if until.is_none()
            && let Some(signal) = bus::termination_signal()
        {
            if let Some(signal) = Signal::from_named_raw(signal) {
                kill_process(pid, signal)?;
            }
            until = Some(Instant::now() + grace + BEYOND_GRACE);
        }
        if until.is_some_and(|until| Instant::now() >= until) {
            tracing::error!("the serving process does not end; killing it");
            child.kill()?;
            until = None;
        }
        let most = Timespec { tv_sec: 0, tv_nsec: 20_000_000 };
        // A signal ends it as well.
        let ended = poll(&mut [PollFd::new(&process, PollFlags::IN)], Some(&most));
        if ended.is_ok_and(|ended| ended > 0) {
            return child.wait();
        }
    }
}

/// How the planner ends, if its serving process has ended by itself or was asked to.
fn ended(status: ExitStatus) -> Option<Exit> {
    match status.code() {
        Some(PANICKED) | None if bus::terminated() => Some(Exit::Done),
        Some(PANICKED) | None => None,
        Some(0) => Some(Exit::Done),
        Some(_) => Some(Exit::Failure),
    }
}

fn cause(status: ExitStatus) -> String {
    match status.signal() {
        None => "a defect; please report it".to_owned(),
        Some(signal) if signal == Signal::BUS.as_raw() => match bus::free_memory() {
            Some(free) => {
                format!("SIGBUS: no shared memory was left; now /dev/shm has {free} bytes free")
            }
            None => "SIGBUS: no shared memory was left".to_owned(),
        },
        Some(signal) => match Signal::from_named_raw(signal) {
            Some(Signal::ABORT) => "SIGABRT".to_owned(),
            Some(Signal::KILL) => "SIGKILL".to_owned(),
            Some(Signal::SEGV) => "SIGSEGV".to_owned(),
            _ => format!("signal {signal}"),
        },
    }
}

/// Waits; whether the process is asked to end meanwhile.
fn ends_within(pause: Duration) -> bool {
    let until = Instant::now() + pause;
    while Instant::now() < until && !bus::terminated() {
        std::thread::sleep(Duration::from_millis(5));
    }
    bus::terminated()
}
