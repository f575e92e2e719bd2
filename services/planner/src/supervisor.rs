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

/// How long the process that serves has to end beyond its grace.
const BEYOND_GRACE: Duration = Duration::from_millis(900);

/// Deaths closer together than this are repeated ones.
const QUICK: Duration = Duration::from_secs(1);

/// How long to wait before each start after repeated deaths, at most.
const LONGEST_PAUSE: Duration = Duration::from_secs(1);

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
    let mut deaths = 0;
    loop {
        let begun = Instant::now();
        let mut child = start()?;
        let status = watch(&mut child, grace)?;
        if let Some(exit) = ended(status) {
            return Ok(Some(exit));
        }
        deaths = if begun.elapsed() < QUICK { deaths + 1 } else { 0 };
        let pause = match deaths {
            0 => Duration::ZERO,
            deaths => LONGEST_PAUSE.min(Duration::from_millis(10 << deaths.min(7))),
        };
        tracing::error!(
            cause = cause(status),
            ?pause,
            "the serving process died; starting another"
        );
        if ends_within(pause) {
            return Ok(Some(Exit::Done));
        }
    }
}

fn start() -> std::io::Result<Child> {
    // Also when the file was replaced meanwhile.
    let program = std::env::current_exe().ok().filter(|path| path.is_file());
    Command::new(program.unwrap_or_else(|| "/proc/self/exe".into()))
        .args(std::env::args_os().skip(1))
        .env(SUPERVISOR_VARIABLE, std::process::id().to_string())
        .spawn()
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
            Some(signal) => format!("{signal:?}"),
            None => format!("signal {signal}"),
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
