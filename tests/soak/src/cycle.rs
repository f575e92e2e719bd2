//! One cycle: clients come, some are killed, all leave; then nothing may be left of them.

use std::io::BufReader;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use bus::{ConnectError, StatusReader};
use fastrand::Rng;
use integration_tests::{Signal, TestDomain, kill_pid, kill_process};
use schemas::status::Status;

use crate::account::{Account, Open};
use crate::health::Health;
use crate::{REQUESTS_PER_CLIENT, SEED};

/// How long it may take until what the clients left is cleared away.
const TIDYING: Duration = Duration::from_secs(20);

/// What a cycle is to do.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plan {
    pub(crate) clients: usize,
    pub(crate) lasts: Duration,
    /// Whether planners are killed as well.
    pub(crate) kills_planners: bool,
}

/// What came of it.
#[derive(Debug)]
pub(crate) struct Cycle {
    pub(crate) account: Account,
    pub(crate) kills: u64,
    pub(crate) status: Status,
    pub(crate) health: Health,
}

/// A client's process.
struct Running {
    child: Child,
    /// None once it has ended.
    says: Option<JoinHandle<(Account, Open)>>,
}

impl Running {
    fn start(test: &TestDomain, rng: &mut Rng) -> std::io::Result<Self> {
        // Its file may have been built anew since it was started.
        let mut command = Command::new("/proc/self/exe");
        command.arg("--domain").arg(test.domain().name()).env(SEED, rng.u64(..).to_string());
        command.env(bus::ROOT_VARIABLE, test.root()).stdin(Stdio::null()).stdout(Stdio::piped());
        let mut child = command.spawn()?;
        let says = BufReader::new(child.stdout.take().expect("it is piped"));
        // Nonsense has its own client beside.
        let most_open = REQUESTS_PER_CLIENT;
        let says = std::thread::spawn(move || Account::read(says, most_open));
        Ok(Self { child, says: Some(says) })
    }

    /// Waits for its end; what became of its requests.
    fn ended(mut self, killed: bool) -> std::io::Result<Account> {
        let status = self.child.wait()?;
        let says = self.says.take().expect("it ends once");
        let (mut account, open) = says.join().expect("it only reads");
        account.close(open, killed);
        // One that has hardly started knows no better than to die.
        let was_early = account.sent == 0 && status.signal() == Some(Signal::TERM.as_raw());
        if !(killed || was_early || status.success()) {
            account.fault(format!("a client ended with {status}"));
        }
        Ok(account)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if self.says.is_some() {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// Runs a cycle; `alone` is how the planner was before the first client came.
pub(crate) fn run(
    test: &TestDomain,
    watch: &Watch,
    plan: &Plan,
    alone: &Health,
    rng: &mut Rng,
) -> std::io::Result<Cycle> {
    let (mut account, mut kills) = (Account::default(), 0);
    let mut running = Vec::new();
    for _ in 0..plan.clients {
        running.push(Running::start(test, rng)?);
    }
    let file = test.path("soak.mcap");
    let recorder = test.recorder(&file.to_string_lossy(), &["--overwrite"]);
    let until = Instant::now() + plan.lasts;
    while Instant::now() < until && !bus::terminated() {
        std::thread::sleep(Duration::from_millis(rng.u64(20..150)));
        let at = rng.usize(..running.len());
        let killed = rng.u8(..4) > 0;
        let client = std::mem::replace(&mut running[at], Running::start(test, rng)?);
        kill_process(&client.child, if killed { Signal::KILL } else { Signal::TERM });
        account += client.ended(killed)?;
        kills += u64::from(killed);
        if plan.kills_planners && rng.u8(..20) == 0 {
            kill_pid(watch.status()?.pid, Signal::KILL);
            kills += 1;
        }
    }
    let lives_on = rng.bool();
    let recorded = if lives_on { recorder.stop() } else { recorder.kill() };
    if lives_on && !matches!(recorded.code, Some(0 | 3)) {
        account.fault(format!("the recorder ended with {:?}: {}", recorded.code, recorded.stderr));
    }
    // One that was killed leaves what it had under another name.
    for file in [&file, &file.with_extension("mcap.part")] {
        let _ = std::fs::remove_file(file);
    }
    for client in &running {
        kill_process(&client.child, Signal::TERM);
    }
    for client in running {
        account += client.ended(false)?;
    }
    let (status, health) = quiet(test, watch, Some(alone), &mut account)?;
    Ok(Cycle { account, kills, status, health })
}

/// Waits until the planner has nothing in hand, and no more files than when it was `alone`.
pub(crate) fn quiet(
    test: &TestDomain,
    watch: &Watch,
    alone: Option<&Health>,
    account: &mut Account,
) -> std::io::Result<(Status, Health)> {
    let until = Instant::now() + TIDYING;
    let mut seen = false;
    loop {
        let status = watch.status()?;
        let health = Health::of(test, status.pid)?;
        let counted = status.answered + status.undelivered;
        let in_hand = status.queue.requests + status.workers.planning + status.unsent;
        let is_done = in_hand == 0 && status.requests == counted;
        let is_tidy = alone.is_none_or(|alone| health.files <= alone.files);
        if is_done && is_tidy && seen {
            return Ok((status, health));
        }
        // It lets go of the last within a second.
        seen = is_done && is_tidy;
        if Instant::now() >= until {
            if !is_done {
                account.fault(format!(
                    "{TIDYING:?} after the last client left, {} requests were taken, {counted} \
                     have an end, {} wait, {} are planned, {} bytes are unsent",
                    status.requests, status.queue.requests, status.workers.planning, status.unsent
                ));
            }
            if !is_tidy {
                let left = test.left();
                let left: Vec<_> = left.iter().filter_map(|path| path.file_name()).collect();
                account.fault(format!("{} files are left: {left:?}", health.files));
            }
            return Ok((status, health));
        }
        std::thread::sleep(Duration::from_millis(1_200));
    }
}

/// Listens to what the planner says of itself, whichever serves.
pub(crate) struct Watch(StatusReader);

impl Watch {
    pub(crate) fn start(test: &TestDomain) -> Result<Self, ConnectError> {
        StatusReader::connect(&test.domain()).map(Self)
    }

    /// What it says next.
    fn status(&self) -> std::io::Result<Status> {
        // What it said before.
        while self.0.receive().is_some() {}
        let until = Instant::now() + TIDYING;
        while let Some(text) = self.0.wait(until.saturating_duration_since(Instant::now())) {
            if let Ok(status) = Status::from_json(&text) {
                return Ok(status);
            }
        }
        Err(std::io::Error::other(format!("no planner for {TIDYING:?}")))
    }
}
