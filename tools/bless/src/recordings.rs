//! The golden recordings: each holds the replies to some scenes.

use std::fs;
use std::path::Path;

use comparison::compare::{Outcome, compare};
use comparison::exchanges;
use comparison::tolerance::Tolerance;
use integration_tests::{TestDomain, root, scene_text};
use schemas::json;
use schemas::message::{RequestContent, SceneRequest};

use crate::Error;

/// A golden recording.
pub(crate) struct Golden {
    /// Where it is in the repository.
    pub(crate) path: &'static str,
    /// Its requests, in order.
    requests: &'static [Source],
}

/// Where requests come from; files in `recordings/scenes`.
enum Source {
    /// A scene.
    Scene(&'static str),
    /// A scene on each line.
    Lines(&'static str),
}

use Source::{Lines, Scene};

/// Every golden recording.
pub(crate) const RECORDINGS: &[Golden] = &[
    Golden {
        path: "recordings/disassembly.mcap",
        requests: &[
            Scene("disassemble.json"),
            Scene("disassemble-channels.json"),
            Scene("assemble.json"),
        ],
    },
    Golden {
        path: "recordings/driving.mcap",
        requests: &[Scene("drive-a.json"), Scene("drive-b.json"), Lines("drives.jsonl")],
    },
    Golden {
        path: "recordings/free-space.mcap",
        requests: &[
            Scene("disassemble-solids.json"),
            Scene("disassemble-space.json"),
            Scene("drive-office-boxes.json"),
        ],
    },
    Golden { path: "recordings/refusals.mcap", requests: &[Lines("refusals.jsonl")] },
    Golden { path: "recordings/no-route.mcap", requests: &[Lines("no-route.jsonl")] },
    Golden { path: "recordings/routes.mcap", requests: &[Lines("routes.jsonl")] },
];

impl Golden {
    /// Why the recording has to be made again, if it has to.
    pub(crate) fn difference(&self) -> Result<Option<String>, Error> {
        self.difference_in(&root().join(self.path))
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
        for source in self.requests {
            let mut read = |name: &str, read: Result<SceneRequest, json::UnreadableScene>| {
                let unreadable = |error: json::UnreadableScene| Error::Content {
                    path: file(name).into(),
                    reason: error.refusal.message,
                };
                read.map_err(unreadable).map(|scene| scenes.push(scene))
            };
            match source {
                Scene(name) => read(name, json::read_scene(&scene_text(name)))?,
                Lines(name) => {
                    for line in scene_text(name).lines().filter(|line| !line.trim().is_empty()) {
                        read(name, json::read_scene(line))?;
                    }
                }
            }
        }
        Ok(scenes)
    }

    /// Records it: a planner, a recorder and clients in a domain of their own.
    pub(crate) fn make(&self) -> Result<(), Error> {
        let test = TestDomain::new();
        let planner = test.planner(&[]);
        let recorder = test.recorder("golden.mcap", &[]);
        for source in self.requests {
            let path = |name| root().join(file(name)).display().to_string();
            match source {
                Scene(name) => drop(test.plan(&["--format", "json", &path(name)])),
                Lines(name) => drop(test.plan_lines(&scene_text(name))),
            }
        }
        recorder.stop();
        planner.stop();
        let made = test.path("golden.mcap");
        match self.difference_in(&made)? {
            None => copy(&made, &root().join(self.path)),
            Some(reason) => Err(Error::Content { path: self.path.into(), reason }),
        }
    }
}

fn file(name: &str) -> String {
    format!("recordings/scenes/{name}")
}

fn copy(from: &Path, to: &Path) -> Result<(), Error> {
    fs::copy(from, to).map(drop).map_err(|cause| Error::Write { path: to.to_owned(), cause })
}
