//! A request is stopped while it is being answered.

use std::cell::Cell;
use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use answer::{Caps, StopFlag, StopReason, Workspace};
use schemas::convert::{self, CellWriter, PartSink, write_scene};
use schemas::json::read_scene;
use schemas::message::{
    Choice, ClearanceWish, ErrorCode, Gap, Refusal, ReplyPart, RequestKey, SceneRequest,
};
use schemas::wire::ReplyHeader;

/// All parts, until the client leaves.
#[derive(Default)]
struct Parts {
    parts: Vec<ReplyPart>,
    left: bool,
    /// Told of every part.
    written: Option<Sender<()>>,
}

#[derive(Debug, PartialEq)]
struct ClientLeft;

impl PartSink for Parts {
    type Error = ClientLeft;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), ClientLeft> {
        if self.left {
            return Err(ClientLeft);
        }
        let mut payload = vec![0; cells];
        fill(&mut CellWriter::new(&mut payload));
        self.parts.push(convert::read_part(header, &payload).unwrap());
        if let Some(written) = &self.written {
            // Nobody listens any more once the request is stopped.
            let _ = written.send(());
        }
        Ok(())
    }
}

/// A robot among pillars that is asked for so many gaps, each of which takes a route of its own.
fn pillars(answers: u32) -> SceneRequest {
    let mut solids = Vec::new();
    for row in 0..12 {
        for column in 0..12 {
            let (x, y) = (3.0 * f64::from(column) + 2.0, 3.0 * f64::from(row) + 2.0);
            let at = x + 0.125 * f64::from((3 * row + column) % 5);
            let (max_x, max_y) = (at + 1.0, y + 1.0);
            solids.push(format!(r#"{{"box": {{"min": [{at}, {y}], "max": [{max_x}, {max_y}]}}}}"#));
        }
    }
    let solids = solids.join(", ");
    let scene = read_scene(&format!(
        r#"{{ "task": "drive",
              "free_space": {{ "solids": [{solids}],
                               "bounds": {{ "min": [0, 0], "max": [40, 40] }} }},
              "body": {{ "footprint": {{ "width": 0.5, "length": 0.75 }} }},
              "start": {{ "position": [1, 1], "heading": 0 }},
              "goal": {{ "position": [39, 39] }}, "clearance": "safest",
              "sampling": {{ "count": 2 }} }}"#
    ));
    let gap = |index| Choice::Gap(Gap::Uniform(0.1 + 1e-6 * f64::from(index)));
    let clearance = ClearanceWish::Each((0..answers).map(gap).collect());
    SceneRequest { clearance, ..scene.unwrap() }
}

/// Nothing but the flag ends a request.
fn endless() -> Workspace {
    Workspace::new(Caps { steps: 1 << 53, ..Caps::default() }, 0)
}

/// Answers the scene and stops it after two answers. The codes of all, and how long it went
/// on after the flag was set.
fn stopped(scene: &SceneRequest, reason: StopReason) -> (Vec<Option<ErrorCode>>, Duration) {
    let mut cells = Vec::new();
    let header = write_scene(scene, RequestKey::default(), 0, &mut cells).unwrap();
    let (written, parts) = channel();
    let mut sink = Parts { written: Some(written), ..Parts::default() };
    let flag = StopFlag::new();
    let took = thread::scope(|scope| {
        let flag = &flag;
        let stopping = scope.spawn(move || {
            parts.iter().take(2).count();
            flag.stop(reason);
            Instant::now()
        });
        endless().answer(&header, &cells, flag, &mut sink).unwrap();
        let ended = Instant::now();
        ended.duration_since(stopping.join().unwrap())
    });
    assert!(sink.parts.last().unwrap().last, "the reply is whole");
    (codes(&sink.parts), took)
}

fn codes(parts: &[ReplyPart]) -> Vec<Option<ErrorCode>> {
    let code = |refusal: &Refusal| refusal.code;
    parts.iter().map(|part| part.content.as_ref().err().map(code)).collect()
}

#[track_caller]
fn check_stopped(reason: StopReason, code: ErrorCode) {
    // Some milliseconds each: minutes in all.
    let (codes, took) = stopped(&pillars(10_000), reason);
    assert_eq!(codes.len(), 10_000);
    let found = codes.iter().take_while(|code| code.is_none()).count();
    assert!((2..1_000).contains(&found), "{found} answers were found");
    assert!(codes[found..].iter().all(|refused| *refused == Some(code)));
    // Less than a millisecond, and writing 10,000 refusals, where nothing else runs.
    assert!(took < Duration::from_secs(5), "it went on for {took:?}");
}

#[test]
fn answers_found_before_the_deadline_stand() {
    check_stopped(StopReason::Deadline, ErrorCode::DeadlineExceeded);
}

#[test]
fn shutdown_refuses_what_is_left() {
    check_stopped(StopReason::Shutdown, ErrorCode::Overloaded);
}

#[test]
fn client_that_left_ends_the_reply_with_the_sinks_error() {
    let flag = StopFlag::new();
    flag.stop(StopReason::ClientLeft);
    let mut cells = Vec::new();
    let header = write_scene(&pillars(3), RequestKey::default(), 0, &mut cells).unwrap();
    let mut sink = Parts { left: true, ..Parts::default() };
    let answered = endless().answer(&header, &cells, &flag, &mut sink);
    assert_eq!(answered, Err(ClientLeft));
}

#[test]
fn request_stopped_beforehand_is_refused_as_a_whole() {
    for (reason, code) in [
        (StopReason::Deadline, ErrorCode::DeadlineExceeded),
        (StopReason::Shutdown, ErrorCode::Overloaded),
    ] {
        let flag = StopFlag::new();
        flag.stop(reason);
        let mut cells = Vec::new();
        let header = write_scene(&pillars(3), RequestKey::default(), 0, &mut cells).unwrap();
        let mut sink = Parts::default();
        endless().answer(&header, &cells, &flag, &mut sink).unwrap();
        assert_eq!(codes(&sink.parts), [Some(code)]);
        assert_eq!((sink.parts[0].answers, sink.parts[0].last), (0, true));
    }
}

/// A client that has left is noticed while the request is planned, not with the next part only.
#[test]
fn what_nobody_wants_is_not_planned() {
    let mut cells = Vec::new();
    let header = write_scene(&pillars(10_000), RequestKey::default(), 0, &mut cells).unwrap();
    let called = Cell::new(0);
    let (flag, mut sink) = (StopFlag::new(), Parts::default());
    let meanwhile = || {
        called.set(called.get() + 1);
        if called.get() == 3 {
            flag.stop(StopReason::ClientLeft);
        }
    };
    endless().answer_while(&header, &cells, (&flag, &meanwhile), &mut sink).unwrap();
    assert_eq!(flag.reason(), Some(StopReason::ClientLeft));
    let found = codes(&sink.parts).iter().filter(|code| code.is_none()).count();
    assert!(found < 100, "{found} answers were found");
}
