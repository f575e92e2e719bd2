//! Recordings to try the program on.

use std::path::{Path, PathBuf};
use std::process::Command;

use answer::Caps;
use assert_cmd::cargo::cargo_bin;
use recording::{Options, Writer};
use schemas::json;
use schemas::message::{Reply, ReplyPart, Request, RequestContent, RequestKey, SceneRequest};

pub(crate) fn request(client: u64, sequence: u64) -> Request {
    let scene = include_str!("../../../../recordings/scenes/disassemble-channels.json");
    let Ok(mut scene) = json::read_scene(scene) else { panic!("the scene is readable") };
    scene.id = Some(sequence);
    let content = RequestContent::Scene(scene);
    Request { key: RequestKey { client, sequence }, sent_ns: 1_000 * sequence, content }
}

/// A part for each answer.
pub(crate) fn parts(reply: Reply) -> Vec<ReplyPart> {
    let answers = reply.answers.as_ref().map_or(0, |answers| answers.len() as u32);
    let contents = reply.answers.unwrap_or_else(|refusal| vec![Err(refusal)]);
    let last = contents.len() - 1;
    let part = |(part, content)| ReplyPart {
        key: reply.key,
        id: reply.id,
        sent_ns: 5_000,
        part: part as u32,
        last: part == last,
        answer: part as u32,
        answers,
        content,
    };
    contents.into_iter().enumerate().map(part).collect()
}

/// Records three requests by `client` with the planner's replies, as `change` makes them;
/// it returns whether to record the part at all.
pub(crate) fn record(path: &Path, client: u64, change: impl Fn(&mut ReplyPart) -> bool) {
    let mut writer = Writer::create(path, Options::default()).unwrap();
    for sequence in 0..3 {
        let request = request(client, sequence);
        writer.write_request(&request, 10_000 + sequence).unwrap();
        for mut part in parts(answer::reply_to(&request, &Caps::default())) {
            if change(&mut part) {
                writer.write_reply(&part, 20_000 + sequence).unwrap();
            }
        }
        writer.flush().unwrap();
    }
    writer.finish().unwrap();
}

pub(crate) fn samples(part: &mut ReplyPart) -> &mut [schemas::message::Sample] {
    &mut part.content.as_mut().unwrap().samples
}

/// A folder with recordings.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn with(name: &str, change: impl Fn(&mut ReplyPart) -> bool) -> Self {
        let folder = Self::new();
        record(&folder.path(name), 7, change);
        folder
    }

    /// Exit code, standard output and standard error of `replay`.
    pub(crate) fn run(&self, arguments: &[&str]) -> (i32, String, String) {
        let output = Command::new(cargo_bin!("replay"))
            .args(arguments)
            .current_dir(self.0.path())
            .output()
            .unwrap();
        let [out, error] =
            [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        (output.status.code().expect("no signal ends it"), out, error)
    }

    #[track_caller]
    pub(crate) fn check(&self, arguments: &[&str], code: i32, out: &str, error: &str) {
        let found = self.run(arguments);
        assert_eq!(found.0, code, "{found:?}");
        assert!(found.1.contains(out), "{found:?}");
        assert!(found.2.contains(error), "{found:?}");
    }
}

pub(crate) fn keep(_: &mut ReplyPart) -> bool {
    true
}

/// Records a request that makes a free space known, and one that only names it. The scene of the
/// first without the name, and the reply to the second.
pub(crate) fn record_named(path: impl AsRef<Path>) -> (SceneRequest, Reply) {
    let mut writer = Writer::create(path, Options::default()).unwrap();
    let mut first = request(7, 0);
    let RequestContent::Scene(scene) = &mut first.content else { unreachable!() };
    let whole = scene.clone();
    scene.free_space.named = Some(scene.free_space.digest());
    let mut second = request(7, 1);
    second.content = RequestContent::Scene(scene.with_name_alone());
    let mut answerer = answer::Answerer::new(&Caps::default());
    let replies = [&first, &second].map(|request| {
        writer.write_request(request, 1).unwrap();
        let reply = answerer.reply_to(request);
        for part in parts(reply.clone()) {
            writer.write_reply(&part, 2).unwrap();
        }
        reply
    });
    writer.finish().unwrap();
    let [_, reply] = replies;
    (whole, reply)
}
