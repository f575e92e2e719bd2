//! A run of the command: every scene is planned and its reply printed.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use answer::Answerer;
use bus::{CallError, Client, ConnectError, Domain, Wait};
use configuration::{Config, ConfigError};
use floor_plan::{FloorPlan, MapError};
use program::{Exit, PrintError, warn};
use render::picture::Look;
use render::{csv, table};
use schemas::json::{self, UnreadableScene};
use schemas::message::{
    FreeSpace, Refusal, Reply, Request, RequestContent, RequestKey, SceneRequest, Solid,
};

use crate::arguments::{Arguments, Format, Unknown};
use crate::pictures::{PictureError, Pictures};
use crate::stdin::Stdin;
use crate::stream::{MOST_BYTES, SceneText, Scenes};
use crate::{grey, map_scene, mesh_scene};

#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Map(#[from] MapError),
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error(transparent)]
    Connect(#[from] bus::ConnectError),
    #[error(transparent)]
    Call(#[from] CallError),
    #[error(transparent)]
    Picture(#[from] PictureError),
    // Not transparent: `program::main` looks for it among the sources.
    #[error("{0}")]
    Print(#[from] PrintError),
    #[error("can't read {}: {cause}", path.display())]
    Read { path: PathBuf, cause: io::Error },
    #[error("no scene on stdin")]
    NoScene,
}

/// Plans all scenes, once it is clear that their pictures can be written.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Failure> {
    let pictures = arguments.svg.clone().map(|path| Pictures::new(path, arguments.overwrite));
    if let Some(pictures) = &pictures {
        pictures.check(&arguments.scenes)?;
    }
    let map = arguments.map.as_deref().map(|path| Map::read(path, arguments));
    let map = map.transpose()?;
    let planner = match Planner::new(arguments) {
        Ok(planner) => planner,
        Err(failure) => match asked_to_end(arguments) {
            Some(signal) => return Ok(Exit::interrupted_by(signal)),
            None => return Err(failure),
        },
    };
    let out = BufWriter::new(io::stdout().lock());
    let mut session = Session { arguments, map, planner, pictures, out, scenes: 0, refused: 0 };
    match session.run() {
        Ok(()) if session.refused == 0 => Ok(Exit::Done),
        Ok(()) => Ok(Exit::Failure),
        Err(failure) => match asked_to_end(arguments) {
            Some(signal) => Ok(Exit::interrupted_by(signal)),
            None => Err(failure),
        },
    }
}

/// What answers.
enum Planner {
    /// This process.
    Local { answerer: Box<Answerer>, sequence: u64 },
    /// The planner of a domain. Signals no longer end this process but set a flag, so that
    /// nothing is left in shared memory.
    Running(Box<Client>),
}

impl Planner {
    fn new(arguments: &Arguments) -> Result<Self, Failure> {
        if arguments.local {
            let config = arguments.config.as_deref().map(Config::read).transpose()?;
            let answerer = Box::new(Answerer::new(&config.unwrap_or_default().caps));
            return Ok(Self::Local { answerer, sequence: 0 });
        }
        let domain = arguments.domain.clone().unwrap_or_default();
        Ok(Self::Running(Box::new(connect(&domain, arguments.wait)?)))
    }

    fn reply(&mut self, scene: &SceneRequest, arguments: &Arguments) -> Result<Reply, CallError> {
        if asked_to_end(arguments).is_some() {
            return Err(CallError::Interrupted);
        }
        match self {
            Self::Running(client) => match call(client, scene, arguments.timeout) {
                // A scene that doesn't fit the wire is refused as the planner would.
                Err(CallError::Scene(refusal)) => Ok(refusal_to(scene.id, refusal)),
                done => done,
            },
            Self::Local { answerer, sequence } => {
                let key = RequestKey { client: 0, sequence: *sequence };
                *sequence += 1;
                let content = RequestContent::Scene(scene.clone());
                Ok(answerer.reply_to(&Request { key, sent_ns: 0, content }))
            }
        }
    }
}

/// The signal that asked this process to end. Where it takes part in no domain, signals end it at
/// once.
fn asked_to_end(arguments: &Arguments) -> Option<i32> {
    if arguments.local { None } else { bus::termination_signal() }
}

/// Connects to the planner of a domain, if need be as soon as it has started.
pub(crate) fn connect(domain: &Domain, wait: Duration) -> Result<Client, Failure> {
    match Client::connect_within(domain, Wait::Hybrid, wait) {
        Err(ConnectError::NoPlanner { .. }) if bus::terminated() => {
            Err(CallError::Interrupted.into())
        }
        done => Ok(done?),
    }
}

/// A map is sent once, and named from then on.
fn call(client: &Client, scene: &SceneRequest, limit: Duration) -> Result<Reply, CallError> {
    match scene.free_space.named {
        Some(_) if scene.free_space.solids.is_some() => client.call_named(scene, limit),
        _ => client.call(scene, limit),
    }
}

fn refusal_to(id: Option<u64>, refusal: Refusal) -> Reply {
    Reply { key: RequestKey::default(), id, answers: Err(refusal) }
}

/// The free space of all scenes.
struct Map {
    plan: FloorPlan,
    free_space: FreeSpace,
    /// For pictures.
    unknown: Vec<Solid>,
}

impl Map {
    fn read(path: &Path, arguments: &Arguments) -> Result<Self, MapError> {
        let plan = floor_plan::read(path, arguments.unknown.into())?;
        let unknown = arguments.svg.as_ref().map(|_| plan.unknown()).unwrap_or_default();
        let mut free_space = plan.free_space();
        free_space.named = Some(free_space.digest());
        Ok(Self { free_space, unknown, plan })
    }
}

struct Session<'a> {
    arguments: &'a Arguments,
    map: Option<Map>,
    planner: Planner,
    pictures: Option<Pictures>,
    out: BufWriter<io::StdoutLock<'a>>,
    scenes: usize,
    refused: usize,
}

impl Session<'_> {
    fn run(&mut self) -> Result<(), Failure> {
        if self.arguments.format == Format::Csv {
            writeln!(self.out, "{}", csv::HEADER).map_err(PrintError)?;
        }
        let arguments = self.arguments;
        for path in &arguments.scenes {
            let unreadable = |cause| Failure::Read { path: path.clone(), cause };
            if path == Path::new("-") {
                self.stdin()?;
            } else {
                let text = read_file(path).map_err(unreadable)?;
                let scene = self.read(&text, path.parent().unwrap_or(Path::new("")));
                self.scene(&path.display().to_string(), scene)?;
            }
        }
        Ok(self.out.flush().map_err(PrintError)?)
    }

    /// Plans the scenes on stdin, each as soon as it is complete.
    fn stdin(&mut self) -> Result<(), Failure> {
        let unreadable = |cause| Failure::Read { path: "stdin".into(), cause };
        // In this process, signals end it anyway.
        let running = matches!(self.planner, Planner::Running(_));
        let stdin = BufReader::new(Stdin::new(move || running && bus::terminated()));
        let mut scenes = Scenes::new(stdin, MOST_BYTES);
        let before = self.scenes;
        while let Some(scene) = scenes.next().map_err(unreadable)? {
            if let Some(lines) = scenes.skipped() {
                let (first, last) = (lines.start(), lines.end());
                warn(format_args!(
                    "plan: skipped lines {first} to {last} of stdin: they follow invalid JSON"
                ));
            }
            let number = self.scenes + 1;
            let SceneText { line, text, fault } = scene;
            let mut read = self.read(&text, Path::new(""));
            if let Some(fault) = fault {
                let (id, field) = match read {
                    Ok(scene) => (scene.id, None),
                    Err(unreadable) => (unreadable.id, unreadable.refusal.field),
                };
                let refusal = Refusal::invalid(field.unwrap_or("scene".into()), fault.to_string());
                read = Err(UnreadableScene { id, refusal });
            }
            self.scene(&format!("scene {number} (line {line})"), read)?;
        }
        if self.scenes == before { Err(Failure::NoScene) } else { Ok(()) }
    }

    fn read(&self, text: &str, folder: &Path) -> Result<SceneRequest, UnreadableScene> {
        let text = mesh_scene::with_boxes(text, folder)?;
        match &self.map {
            Some(map) => map_scene::read_scene(&text, &map.free_space),
            None => json::read_scene(&text),
        }
    }

    /// Plans a scene, prints the reply and draws both.
    fn scene(
        &mut self,
        name: &str,
        scene: Result<SceneRequest, UnreadableScene>,
    ) -> Result<(), Failure> {
        self.scenes += 1;
        let (scene, reply) = match scene {
            Ok(scene) => {
                let reply = self.planner.reply(&scene, self.arguments)?;
                (Some(scene), reply)
            }
            Err(unreadable) => (None, refusal_to(unreadable.id, unreadable.refusal)),
        };
        if !reply.answers.iter().flatten().any(Result::is_ok) {
            self.refused += 1;
        }
        self.print(name, scene.as_ref(), &reply).map_err(PrintError)?;
        if let (Some(map), Some(scene)) = (&self.map, &scene)
            && self.arguments.unknown == Unknown::Occupied
            && let Some(grey) = grey::passed_over(&map.plan, scene, &reply)
        {
            let id = reply.id.map_or(String::new(), |id| format!(" (id {id})"));
            warn(format_args!("plan: note: {name}{id}: {grey}"));
        }
        if let (Some(pictures), Some(scene)) = (&self.pictures, &scene) {
            let unknown = self.map.as_ref().map_or(&[][..], |map| &map.unknown);
            let look = Look { mesh: self.arguments.svg_mesh, unknown, ..Look::default() };
            pictures.draw(self.scenes, scene, &reply, look)?;
        }
        Ok(())
    }

    fn print(&mut self, name: &str, scene: Option<&SceneRequest>, reply: &Reply) -> io::Result<()> {
        match self.arguments.format {
            Format::Text => table::write(&mut self.out, name, scene, reply)?,
            Format::Json => {
                json::write_reply(reply, &mut self.out)?;
                writeln!(self.out)?;
            }
            Format::Csv => {
                if let Some(scene) = scene {
                    csv::write(&mut self.out, self.scenes, scene, reply)?;
                }
                warn_of_refusals(name, reply);
            }
        }
        // Whoever sends scene by scene waits for each reply.
        self.out.flush()
    }
}

/// Prints refusals to stderr: rows of samples have no room for them.
fn warn_of_refusals(name: &str, reply: &Reply) {
    let id = reply.id.map_or(String::new(), |id| format!(" (id {id})"));
    match &reply.answers {
        Err(refusal) => warn(format_args!("plan: {name}{id}: {}", table::refused(refusal))),
        Ok(answers) => {
            for (index, answer) in answers.iter().enumerate() {
                if let Err(refusal) = answer {
                    let refused = table::refused(refusal);
                    warn(format_args!("plan: {name}{id}: answer {index}: {refused}"));
                }
            }
        }
    }
}

/// The text of a file with one scene.
fn read_file(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    File::open(path)?.take(MOST_BYTES as u64 + 1).read_to_string(&mut text)?;
    if text.len() > MOST_BYTES {
        let reason = format!("longer than {MOST_BYTES} bytes, the most for one scene");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, reason));
    }
    Ok(text)
}
