//! The `demo` command: the project's main job from end to end; see `demo --help`.

mod output;
mod processes;
mod scenes;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use bus::{Client, Domain};
use clap::Parser;
use replay::check;
use replay::compare::Tolerance;
use schemas::message::{ClearanceWish, Reply, SceneRequest, Trajectory};

use output::Row;
use processes::Role;

/// Plans the paper's examples over shared memory, records and replays the traffic, and
/// draws the pictures.
///
/// A planner, a recorder and a client run as processes of their own in a domain of their own, so
/// that several demos can run at once.
#[derive(Parser)]
#[command(
    version,
    after_help = "\
Exit codes: 0 done, 1 failure, 2 usage, 3 messages were lost, 4 the replay differs."
)]
struct Arguments {
    /// Where to put recording and pictures [default: target/demo/N, the next free number]
    #[arg(short, long, value_name = "DIRECTORY")]
    output: Option<PathBuf>,
}

/// How often each request is made; the round trip shown is the median.
const ROUNDS: usize = 11;

const PATIENCE: Duration = Duration::from_secs(20);

type Error = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    bus::forward_to_tracing();
    if let Some(role) = Role::of_this_process() {
        return role.run();
    }
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_max_level(tracing_subscriber::filter::LevelFilter::WARN)
        .init();
    match run(Arguments::parse()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("demo: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> Result<ExitCode, Error> {
    let directory = output::directory(arguments.output)?;
    let recording = directory.join("demo.mcap");
    let domain = Domain::new(&format!("demo-{}", std::process::id()))?;

    let planner = processes::Child::start(Role::Planner, &domain, &recording)?;
    let mut client = processes::connect(&domain, PATIENCE)?;
    let recorder = processes::Child::start(Role::Recorder, &domain, &recording)?;
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
        output::save(&directory, name, &plan::picture::draw(&scene, &reply))?;
    }
    drop(client);
    let recorded = recorder.stop()?;
    let served = planner.stop()?;

    let plan = |request: &_| answer::reply_to(request, &answer::Caps::default());
    let checked = check::check(&recording, Tolerance::Exact, plan, |_| {});
    domain.tidy();
    output::print(&rows, &directory, &checked)?;
    let contents = &checked.contents;
    let lost = recorded == 3 || contents.lost() > 0 || !contents.losses.is_empty();
    Ok(match (served, recorded) {
        _ if checked.counts().different > 0 => ExitCode::from(4),
        _ if lost => ExitCode::from(3),
        (0, 0) if contents.error.is_none() => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    })
}

/// The reply, and the median round trip of several.
fn ask(client: &mut Client, scene: &SceneRequest) -> Result<(Reply, Duration), Error> {
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
    let gaps = plan::output::gaps(trajectory);
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
