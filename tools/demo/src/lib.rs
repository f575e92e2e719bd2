//! The `demo` command: the project's main job from end to end; see `demo --help`.

mod output;
mod processes;
mod scenes;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use bus::{CallError, Client, Domain, Wait};
use clap::{ArgMatches, Command, CommandFactory, FromArgMatches, Parser};
use comparison::check;
use comparison::tolerance::Tolerance;
use program::{Diagnostics, Exit, LogFormat, PrintError};
use schemas::message::{ClearanceWish, Reply, SceneRequest, Trajectory};

use output::Row;
use processes::{Child, Role, Tidy};

/// Plans the paper's examples over shared memory, records and replays the traffic, and
/// draws pictures of the answers.
///
/// Planner, recorder and client are processes in a domain of their own, so several demos can
/// run at once.
#[derive(Parser)]
#[command(
    name = "demo",
    version,
    after_help = "\
Examples:
  demo
  demo -o /tmp/demo

Results go to stdout, diagnostics to stderr.
Exit codes: 0 done, 1 failure, 2 usage, 3 messages were lost, 4 the replay differs, 129 SIGHUP,
130 SIGINT (Ctrl-C), 143 SIGTERM."
)]
struct Arguments {
    /// Folder for recording and pictures [default: target/demo/N, the next free number]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// How often each request is made; the round trip shown is the median.
const ROUNDS: usize = 11;

const PATIENCE: Duration = Duration::from_secs(20);

type Error = Box<dyn std::error::Error>;

/// Its command line.
pub fn command() -> Command {
    Arguments::command()
}

/// What this process does if a demo has started it: to be asked before anything else.
pub fn play_role() -> Option<ExitCode> {
    Role::of_this_process().map(|role| program::main(role.program(), || role.run()))
}

/// Runs it.
pub fn run(matches: &ArgMatches) -> ExitCode {
    program::main("demo", || {
        let arguments = Arguments::from_arg_matches(matches)?;
        program::start_diagnostics(Diagnostics::Warnings, LogFormat::Text);
        bus::forward_to_tracing();
        match (show(arguments), bus::termination_signal()) {
            // Planner and recorder end too if they got the signal, as with Ctrl-C: whatever
            // failed then, the signal is why.
            (Err(_), Some(signal)) => Ok(Exit::interrupted_by(signal)),
            (done, _) => done,
        }
    })
}

fn show(arguments: Arguments) -> Result<Exit, Error> {
    // From this call on, a signal leaves time to end the other processes.
    bus::terminated();
    let directory = output::directory(arguments.output)?;
    let recording = directory.join("demo.mcap");
    let domain = Domain::new(&format!("demo-{}", std::process::id()))?;
    let tidy = Tidy(&domain);

    let planner = Child::start(Role::Planner, &domain, &recording)?;
    let mut client = Client::connect_within(&domain, Wait::Hybrid, PATIENCE)?;
    let recorder = Child::start(Role::Recorder, &domain, &recording)?;
    processes::wait_for_file(&recording, PATIENCE)?;

    let mut rows = Vec::new();
    for (name, scene) in scenes::all() {
        let mut whole: Option<Reply> = None;
        for request in scenes::one_by_one(&scene) {
            let (reply, round_trip) = ask(&mut client, &request)?;
            let answer = reply.answers.clone().map_err(|refusal| refusal.message)?.remove(0);
            let trajectory = answer.as_ref().map_err(|refusal| refusal.message.clone())?;
            rows.push(row(name, &request, trajectory, round_trip));
            match &mut whole {
                None => whole = Some(reply),
                Some(whole) => whole.answers.as_mut().expect("answers only").push(answer),
            }
        }
        let reply = whole.expect("every scene has a wish");
        output::save(&directory, name, &render::picture::draw(&scene, &reply))?;
    }
    if bus::terminated() {
        return Err(CallError::Interrupted.into());
    }
    drop(client);
    let recorded = recorder.stop()?;
    let served = planner.stop()?;
    drop(tidy);

    let plan = |request: &_| answer::reply_to(request, &answer::Caps::default());
    let checked = check::check(std::slice::from_ref(&recording), &Tolerance::EXACT, plan, |_| {});
    output::print(&rows, &directory, &checked).map_err(PrintError)?;
    let contents = &checked.contents;
    let done = Exit::Done.code();
    Ok(if checked.counts().different > 0 {
        Exit::Regression
    } else if recorded == Exit::Lost.code() || contents.is_incomplete() {
        Exit::Lost
    } else if (served, recorded) == (done, done) && contents.error.is_none() {
        Exit::Done
    } else {
        Exit::Failure
    })
}

/// The reply, and the median round trip of several.
fn ask(client: &mut Client, scene: &SceneRequest) -> Result<(Reply, Duration), CallError> {
    let mut times = Vec::with_capacity(ROUNDS);
    let mut reply = None;
    for _ in 0..ROUNDS {
        let begin = Instant::now();
        reply = Some(client.call(scene, PATIENCE)?);
        times.push(begin.elapsed());
    }
    times.sort();
    Ok((reply.expect("asked at least once"), times[ROUNDS / 2]))
}

fn row(task: &str, request: &SceneRequest, trajectory: &Trajectory, round_trip: Duration) -> Row {
    let gaps = render::table::gaps(trajectory);
    Row {
        task: task.to_owned(),
        gap: match request.clearance {
            ClearanceWish::Safest => format!("safest: {gaps}"),
            _ => gaps,
        },
        length: trajectory.length,
        clearance: trajectory.clearance.value,
        legs: trajectory.legs.iter().map(|leg| leg.clearance).collect(),
        duration: trajectory.duration,
        samples: trajectory.samples.len(),
        round_trip,
    }
}
