//! The golden recordings: each holds the replies to some scenes.

use std::fs;
use std::path::Path;

use comparison::compare::{Outcome, compare};
use comparison::exchanges;
use comparison::tolerance::Tolerance;
use integration_tests::{TestDomain, root, scene_text};
use schemas::json;
use schemas::message::{RequestContent, Sampling, SceneRequest};

use crate::Error;

/// A golden recording.
pub(crate) struct Golden {
    /// Where it is in the repository.
    pub(crate) path: String,
    /// Its requests, in order.
    requests: Vec<Source>,
    /// How many samples its motions have where scenes ask for no number, if not as they ask.
    samples: Option<u64>,
}

/// Where requests come from; files in `recordings/scenes`.
#[derive(Clone, Copy)]
enum Source {
    /// A scene.
    Scene(&'static str),
    /// A scene on each line.
    Lines(&'static str),
    /// The scene on one line, from 1.
    Line(&'static str, usize),
}

use Source::{Line, Lines, Scene};

/// Recordings of several scenes, as their scenes are.
const OF_SEVERAL: &[(&str, &[Source])] = &[
    (
        "disassembly",
        &[Scene("disassemble.json"), Scene("disassemble-channels.json"), Scene("assemble.json")],
    ),
    ("driving", &[Scene("drive-a.json"), Scene("drive-b.json"), Lines("drives.jsonl")]),
    (
        "free-space",
        &[
            Scene("disassemble-solids.json"),
            Scene("disassemble-space.json"),
            Scene("drive-office-boxes.json"),
        ],
    ),
    ("refusals", &[Lines("refusals.jsonl")]),
    ("no-route", &[Lines("no-route.jsonl")]),
    ("routes", &[Lines("routes.jsonl")]),
    ("corners", &[Lines("corners.jsonl")]),
    ("shortest", &[Lines("shortest.jsonl")]),
    ("unions", &[Lines("unions.jsonl")]),
];

/// Samples of each motion in recordings of one scene: what else is in a reply is not thinned.
const SAMPLES: u64 = 20;

/// Every golden recording: those of several scenes, and one of each of their scenes.
pub(crate) fn all() -> Vec<Golden> {
    let mut all = Vec::new();
    for (name, requests) in OF_SEVERAL {
        let path = format!("recordings/{name}.mcap");
        all.push(Golden { path, requests: requests.to_vec(), samples: None });
    }
    for source in OF_SEVERAL.iter().flat_map(|(_, requests)| *requests) {
        let mut add = |name: String, source| {
            let path = format!("recordings/each/{name}.mcap");
            all.push(Golden { path, requests: vec![source], samples: Some(SAMPLES) });
        };
        match *source {
            Scene(file) => add(file.trim_end_matches(".json").to_owned(), *source),
            Lines(file) => {
                let name = file.trim_end_matches(".jsonl");
                let lines = lines(file).len();
                (1..=lines).for_each(|line| add(format!("{name}-{line}"), Line(file, line)));
            }
            Line(..) => unreachable!("none of them is one"),
        }
    }
    all
}

/// The scenes of a file, one on each line.
fn lines(name: &str) -> Vec<String> {
    let text = scene_text(name);
    text.lines().filter(|line| !line.trim().is_empty()).map(str::to_owned).collect()
}

impl Golden {
    /// Why the recording has to be made again, if it has to.
    pub(crate) fn difference(&self) -> Result<Option<String>, Error> {
        self.difference_in(&root().join(&self.path))
    }

    fn difference_in(&self, path: &Path) -> Result<Option<String>, Error> {
        if !path.exists() {
            return Ok(Some("it is missing".to_owned()));
        }
        let wanted = self.scenes()?;
        let mut found = Vec::new();
        let contents = exchanges::read(path, |_| {}, |exchange| found.push(exchange));
        if let Some(error) = contents.error {
            return Ok(Some(error.to_string()));
        }
        found.sort_by_key(|exchange| exchange.index);
        let (requests, replies, wanted_count) = (contents.requests, found.len(), wanted.len());
        if (requests, replies) != (wanted_count as u64, wanted_count) {
            return Ok(Some(format!(
                "it has {requests} requests and {replies} whole replies, but there are \
                 {wanted_count} scenes"
            )));
        }
        for (exchange, scene) in found.iter().zip(&wanted) {
            let index = exchange.index;
            match &exchange.request.content {
                RequestContent::Scene(recorded) if recorded == scene => {}
                _ => {
                    return Ok(Some(format!(
                        "request {index} is not the scene in recordings/scenes"
                    )));
                }
            }
            let planned = answer::reply_to(&exchange.request, &answer::Caps::default());
            match compare(&exchange.reply, &planned, &Tolerance::EXACT).outcome {
                Outcome::Equal { .. } => {}
                Outcome::NotRepeatable => {
                    return Ok(Some(format!("the reply to request {index} can't be repeated")));
                }
                Outcome::Different(difference) => {
                    return Ok(Some(format!("the reply to request {index} differs: {difference}")));
                }
            }
        }
        Ok(None)
    }

    /// The scenes that its clients send.
    fn scenes(&self) -> Result<Vec<SceneRequest>, Error> {
        let mut scenes = Vec::new();
        for source in &self.requests {
            let mut read = |name: &str, read: Result<SceneRequest, json::UnreadableScene>| {
                let unreadable = |error: json::UnreadableScene| Error::Content {
                    path: file(name).into(),
                    reason: error.refusal.message,
                };
                let mut scene = read.map_err(unreadable)?;
                let asks_for_some = matches!(scene.sampling, Some(Sampling::Count(_)));
                if let Some(samples) = self.samples.filter(|_| !asks_for_some) {
                    scene.sampling = Some(Sampling::Count(samples));
                }
                scenes.push(scene);
                Ok::<_, Error>(())
            };
            match *source {
                Scene(name) => read(name, json::read_scene(&scene_text(name)))?,
                Lines(name) => {
                    for line in lines(name) {
                        read(name, json::read_scene(&line))?;
                    }
                }
                Line(name, line) => read(name, json::read_scene(&lines(name)[line - 1]))?,
            }
        }
        Ok(scenes)
    }

    /// Records it: a planner, a recorder and clients in a domain of their own.
    pub(crate) fn make(&self) -> Result<(), Error> {
        let test = TestDomain::new();
        let planner = test.planner(&[]);
        let compression = if self.samples.is_some() { "zstd" } else { "none" };
        let recorder = test.recorder("golden.mcap", &["--compression", compression]);
        for scene in self.scenes()? {
            drop(test.plan_lines(&json::scene_to_json(&scene)));
        }
        recorder.stop();
        planner.stop();
        let made = test.path("golden.mcap");
        match self.difference_in(&made)? {
            None => copy(&made, &root().join(&self.path)),
            Some(reason) => Err(Error::Content { path: self.path.clone().into(), reason }),
        }
    }
}

fn file(name: &str) -> String {
    format!("recordings/scenes/{name}")
}

fn copy(from: &Path, to: &Path) -> Result<(), Error> {
    let folder = to.parent().map_or(Ok(()), fs::create_dir_all);
    let copied = folder.and_then(|()| fs::copy(from, to));
    copied.map(drop).map_err(|cause| Error::Write { path: to.to_owned(), cause })
}
