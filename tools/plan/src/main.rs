//! The `plan` command; see `plan --help`.

use std::fs::{self, File};
use std::io::{self, BufRead, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use answer::Caps;
use bus::{CallError, Client, Domain, Wait};
use clap::{Parser, ValueEnum};
use configuration::{Config, ConfigError};
use plan::map::{self, MapError};
use plan::output;
use schemas::json;
use schemas::message::{FreeSpace, Reply, Request, RequestContent, RequestKey, SceneRequest};
use tracing_subscriber::EnvFilter;

/// Sends scenes to the running planner and prints the replies, in order.
#[derive(Parser)]
#[command(
    version,
    after_help = "\
Examples:
  plan recordings/scenes/disassemble.json
  plan --map office.yaml drive-office.json
  plan --local --format json scene.json | jq .trajectories[0].length
  generate-scenes | plan --format csv - > samples.csv

Results go to stdout, diagnostics to stderr.
Exit codes: 0 every scene has a trajectory, 1 a scene was refused or something failed, 2 usage."
)]
struct Arguments {
    /// Scene files; `-` reads JSON Lines from stdin
    #[arg(required = true, value_name = "SCENE.json")]
    scenes: Vec<PathBuf>,
    /// The planner's domain
    #[arg(long, value_name = "NAME")]
    domain: Option<Domain>,
    /// A floor plan as the ROS map server has them: the free space of every scene, which then
    /// has none of its own
    #[arg(long, value_name = "FILE.yaml")]
    map: Option<PathBuf>,
    /// Plan in this process, without a planner: the same bytes
    #[arg(long)]
    local: bool,
    /// The planner's configuration, for the caps on what a request may cost: the same bytes as
    /// a planner with this file gives; nothing else in it matters here
    #[arg(long, value_name = "FILE", requires = "local")]
    config: Option<PathBuf>,
    /// How to print replies: tables, one JSON object per line, or rows of samples
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Draw each scene with its answers; several scenes get numbered files
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Replace existing files
    #[arg(long)]
    overwrite: bool,
    /// How long to wait for each reply
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = humantime::parse_duration)]
    timeout: Duration,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Text,
    Json,
    Csv,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    tracing_subscriber::fmt()
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        .with_env_filter(EnvFilter::try_from_default_env().unwrap_or_else(|_| "warn".into()))
        .init();
    bus::forward_to_tracing();
    match run(&arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        // Whoever reads the results has seen enough.
        Err(Failure::Print(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            ExitCode::SUCCESS
        }
        Err(failure) => {
            eprintln!("plan: {failure}");
            ExitCode::FAILURE
        }
    }
}

#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error(transparent)]
    Map(#[from] MapError),
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error(transparent)]
    Connect(#[from] bus::ConnectError),
    #[error(transparent)]
    Call(#[from] CallError),
    #[error("can't read {}: {cause}", path.display())]
    Read { path: PathBuf, cause: io::Error },
    #[error("can't write {}: {cause}", path.display())]
    Draw { path: PathBuf, cause: io::Error },
    #[error("{} exists; --overwrite replaces it", .0.display())]
    Exists(PathBuf),
    #[error("can't print: {0}")]
    Print(#[from] io::Error),
}

/// Whether every scene has a trajectory.
fn run(arguments: &Arguments) -> Result<bool, Failure> {
    let map = arguments.map.as_deref().map(map::read).transpose()?;
    let mut session = Session {
        arguments,
        map,
        planner: match arguments.local {
            true => {
                let config = arguments.config.as_deref().map(Config::read).transpose()?;
                Planner::Local { caps: config.unwrap_or_default().caps, sequence: 0 }
            }
            false => {
                let domain = arguments.domain.clone().unwrap_or_default();
                let connected = Client::connect(&domain, Wait::Hybrid);
                // Whoever came alone leaves nothing behind.
                Planner::Running(Box::new(connected.inspect_err(|_| domain.tidy())?))
            }
        },
        out: BufWriter::new(io::stdout().lock()),
        scenes: 0,
        refused: 0,
    };
    if arguments.format == Format::Csv {
        writeln!(session.out, "{}", output::CSV_HEAD)?;
    }
    for path in &arguments.scenes {
        if path == Path::new("-") {
            for line in io::stdin().lock().lines() {
                let unreadable = |cause| Failure::Read { path: path.clone(), cause };
                let line = line.map_err(unreadable)?;
                if !line.trim().is_empty() {
                    let name = format!("line {}", session.scenes + 1);
                    session.scene(&name, &line)?;
                }
            }
        } else {
            let text = fs::read_to_string(path)
                .map_err(|cause| Failure::Read { path: path.clone(), cause })?;
            session.scene(&path.display().to_string(), &text)?;
        }
    }
    session.out.flush()?;
    Ok(session.refused == 0)
}

enum Planner {
    Local { caps: Caps, sequence: u64 },
    Running(Box<Client>),
}

impl Planner {
    fn reply(&mut self, scene: &SceneRequest, timeout: Duration) -> Result<Reply, CallError> {
        match self {
            Self::Running(client) => match client.call(scene, timeout) {
                // What can't be said on the bus is refused as the planner would.
                Err(CallError::Scene(refusal)) => Ok(refusal_to(scene.id, refusal)),
                done => done,
            },
            Self::Local { caps, sequence } => {
                let key = RequestKey { client: 0, sequence: *sequence };
                *sequence += 1;
                let content = RequestContent::Scene(scene.clone());
                Ok(answer::reply_to(&Request { key, sent_ns: 0, content }, caps))
            }
        }
    }
}

fn refusal_to(id: Option<u64>, refusal: schemas::message::Refusal) -> Reply {
    Reply { key: RequestKey::default(), id, answers: Err(refusal) }
}

struct Session<'a> {
    arguments: &'a Arguments,
    map: Option<FreeSpace>,
    planner: Planner,
    out: BufWriter<io::StdoutLock<'a>>,
    scenes: usize,
    refused: usize,
}

impl Session<'_> {
    fn scene(&mut self, name: &str, text: &str) -> Result<(), Failure> {
        self.scenes += 1;
        let scene = match &self.map {
            Some(map) => map::read_scene(text, map),
            None => json::read_scene(text),
        };
        let (scene, reply) = match scene {
            Ok(scene) => {
                let reply = self.planner.reply(&scene, self.arguments.timeout)?;
                (Some(scene), reply)
            }
            Err(unreadable) => (None, refusal_to(unreadable.id, unreadable.refusal)),
        };
        if !reply.answers.iter().flatten().any(Result::is_ok) {
            self.refused += 1;
        }
        match (self.arguments.format, &scene) {
            (Format::Text, scene) => {
                output::write_text(&mut self.out, name, scene.as_ref(), &reply)?;
            }
            (Format::Csv, scene) => {
                if let Some(scene) = scene {
                    output::write_csv(&mut self.out, self.scenes, scene, &reply)?;
                }
                // Rows have no room for a refusal.
                for refusal in refusals(&reply) {
                    eprintln!("plan: {name}: {}", output::refused(refusal));
                }
            }
            (Format::Json, _) => {
                json::write_reply(&reply, &mut self.out)?;
                writeln!(self.out)?;
            }
        }
        if let Some(scene) = &scene {
            self.draw(scene, &reply)?;
        }
        // Whoever sends line by line wants the answers so.
        Ok(self.out.flush()?)
    }

    fn draw(&self, scene: &SceneRequest, reply: &Reply) -> Result<(), Failure> {
        let Some(path) = &self.arguments.svg else { return Ok(()) };
        let path = numbered(path, self.scenes);
        let picture = plan::picture::draw(scene, reply);
        let failed = |cause: io::Error| match cause.kind() {
            io::ErrorKind::AlreadyExists => Failure::Exists(path.clone()),
            _ => Failure::Draw { path: path.clone(), cause },
        };
        let mut options = File::options();
        match self.arguments.overwrite {
            true => options.write(true).create(true).truncate(true),
            false => options.write(true).create_new(true),
        };
        let mut file = options.open(&path).map_err(failed)?;
        file.write_all(picture.as_bytes()).map_err(failed)
    }
}

/// The first picture has the name given, the others a number before its extension.
fn numbered(path: &Path, number: usize) -> PathBuf {
    if number == 1 {
        return path.to_owned();
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
    path.with_file_name(format!("{stem}-{number}{extension}"))
}

fn refusals(reply: &Reply) -> Vec<&schemas::message::Refusal> {
    match &reply.answers {
        Err(refusal) => vec![refusal],
        Ok(answers) => answers.iter().filter_map(|answer| answer.as_ref().err()).collect(),
    }
}
