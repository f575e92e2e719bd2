//! `plan`: scenes on stdin, rows, pictures, and how it is interrupted.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};

use integration_tests::{Ended, LONG, Signal, TestDomain, kill_process, program, root, scene_text};
use serde_json::Value;

fn scene_path(name: &str) -> String {
    root().join("recordings/scenes").join(name).to_str().unwrap().to_owned()
}

/// `plan --local` with these arguments.
fn plan(test: &TestDomain, arguments: &[&str]) -> Ended {
    test.run("plan", &[&["--local"], arguments].concat())
}

/// The replies to scenes on stdin, and what is said of them.
fn replies(test: &TestDomain, stdin: &str) -> (Vec<Value>, Ended) {
    let ended = test.start("plan", &["--local", "--format", "json", "-"], Some(stdin)).wait();
    let lines = ended.stdout.lines().map(|line| serde_json::from_str(line).unwrap());
    (lines.collect(), ended)
}

/// A small scene with this id.
fn numbered(id: u64) -> Value {
    let mut scene: Value = serde_json::from_str(&scene_text("disassemble-channels.json")).unwrap();
    scene["id"] = id.into();
    scene
}

fn ids(replies: &[Value]) -> Vec<Option<u64>> {
    replies.iter().map(|reply| reply["id"].as_u64()).collect()
}

#[test]
fn scenes_on_stdin_are_answered_in_order_however_they_are_laid_out() {
    let test = TestDomain::new();
    let pretty = |id| serde_json::to_string_pretty(&numbered(id)).unwrap();
    let [five, three, eight, one] = [5, 3, 8, 1].map(numbered);
    for stdin in [
        format!("{five}\n\n{three}\n{eight}\r\n{one}"),
        format!("{five}{three} {eight}\t{one}\n"),
        [5, 3, 8, 1].map(pretty).join("\n"),
        format!("\n{}{three}\n{}\n{one}\n", pretty(5), pretty(8)),
    ] {
        let (replies, ended) = replies(&test, &stdin);
        assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""), "{stdin}");
        assert_eq!(ids(&replies), [5, 3, 8, 1].map(Some), "{stdin}");
        assert!(replies.iter().all(|reply| reply["trajectories"].is_array()));
    }
}

#[test]
fn a_scene_file_can_be_piped_in() {
    let test = TestDomain::new();
    let text = scene_text("disassemble.json");
    assert!(text.lines().count() > 1, "else this shows nothing");
    let (_, piped) = replies(&test, &text);
    let named = plan(&test, &["--format", "json", &scene_path("disassemble.json")]);
    assert_eq!(piped, named);
}

#[test]
fn invalid_json_is_refused_by_line_and_column_and_the_next_is_planned() {
    let test = TestDomain::new();
    let stdin = format!(
        "{}\n{{ \"id\": 2, nonsense }}\n{}\n{{\n  \"id\": 4,,\n  \"task\": \"drive\"\n}}\n{:#}\n",
        numbered(1),
        numbered(3),
        numbered(5)
    );
    let (replies, ended) = replies(&test, &stdin);
    assert_eq!(ended.code, Some(1), "two are refused");
    assert_eq!(ids(&replies), [1, 2, 3, 4, 5].map(Some));
    let message = |index: usize| replies[index]["error"]["message"].as_str().unwrap_or_default();
    assert_eq!(message(1), "invalid JSON at line 2, column 12: key must be a string");
    assert_eq!(message(3), "invalid JSON at line 5, column 11: key must be a string");
    assert!([0, 2, 4].iter().all(|good| replies[*good]["trajectories"].is_array()));
    let skipped = "plan: skipped lines 6 to 7 of stdin: they follow invalid JSON\n";
    assert_eq!(ended.stderr, skipped);
}

#[test]
fn a_refused_scene_is_named_once() {
    let test = TestDomain::new();
    let stdin = format!("{}\n{{ nonsense }}\n", numbered(1));
    let line = "invalid_scene: invalid JSON at line 2, column 3: key must be a string";
    let table = test.start("plan", &["--local", "-"], Some(&stdin)).wait();
    assert!(table.stdout.contains(line), "{}", table.stdout);
    assert_eq!(table.stdout.matches("scene 2").count(), 1, "{}", table.stdout);
    let rows = test.start("plan", &["--local", "--format", "csv", "-"], Some(&stdin)).wait();
    assert_eq!(rows.stderr, format!("plan: scene 2 (line 2): refused, {line}\n"));
}

#[test]
fn a_stdin_without_a_scene_is_an_error() {
    let test = TestDomain::new();
    for stdin in ["", " \n\n"] {
        let (replies, ended) = replies(&test, stdin);
        assert!(replies.is_empty());
        assert_eq!((ended.code, ended.stderr.as_str()), (Some(1), "plan: no scene on stdin\n"));
    }
}

/// A running `plan` whose stdin is open.
struct Piped {
    child: Child,
    lines: Receiver<String>,
}

impl Piped {
    fn start(test: &TestDomain, arguments: &[&str]) -> Self {
        let mut child = Command::new(program("plan"))
            .env(bus::ROOT_VARIABLE, test.root())
            .args(arguments)
            .args(["--format", "json", "-"])
            .current_dir(test.path(""))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (sender, lines) = channel();
        let stdout = BufReader::new(child.stdout.take().unwrap());
        std::thread::spawn(move || {
            stdout.lines().map_while(Result::ok).try_for_each(|line| sender.send(line))
        });
        Self { child, lines }
    }

    /// Sends a text that completes a scene; its reply.
    #[track_caller]
    fn ask(&mut self, text: &str) -> Value {
        let stdin = self.child.stdin.as_mut().unwrap();
        stdin.write_all(text.as_bytes()).unwrap();
        stdin.flush().unwrap();
        let line = self.lines.recv_timeout(LONG).expect("the reply comes while stdin is open");
        serde_json::from_str(&line).unwrap()
    }
}

#[test]
fn each_reply_comes_before_stdin_ends() {
    let test = TestDomain::new();
    let mut plan = Piped::start(&test, &["--local"]);
    // Without a line end: the last bracket completes a scene.
    assert_eq!(plan.ask(&format!("{:#}", numbered(1)))["id"], 1);
    assert_eq!(plan.ask(&format!("\n{}", numbered(2)))["id"], 2);
    let refused = plan.ask("\n{ \"id\": 3, nonsense");
    assert_eq!((&refused["id"], &refused["error"]["code"]), (&3.into(), &"invalid_scene".into()));
    assert_eq!(plan.ask(&format!(" }}\n{}", numbered(4)))["id"], 4);
    drop(plan.child.stdin.take());
    assert_eq!(plan.child.wait().unwrap().code(), Some(1));
}

#[test]
fn a_signal_ends_it_while_it_waits_for_scenes() {
    for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
        let test = TestDomain::new();
        let _planner = test.planner(&[]);
        let name = test.domain().to_string();
        let mut running = Piped::start(&test, &["--domain", &name]);
        assert_eq!(running.ask(&numbered(1).to_string())["id"], 1);
        kill_process(&running.child, signal);
        let code = running.child.wait().unwrap().code();
        assert_eq!(code, Some(128 + signal.as_raw()), "{signal:?}");

        let mut local = Piped::start(&test, &["--local"]);
        assert_eq!(local.ask(&numbered(1).to_string())["id"], 1);
        kill_process(&local.child, signal);
        let ended = local.child.wait().unwrap();
        assert_eq!(ended.signal(), Some(signal.as_raw()), "nothing is left behind that way");
    }
}

#[test]
fn a_signal_ends_it_while_it_waits_for_a_reply() {
    let test = TestDomain::new();
    let planner = test.planner(&[]);
    let name = test.domain().to_string();
    let arguments = ["--domain", &name, "--timeout", "1h"];
    let mut waiting = Piped::start(&test, &arguments);
    assert_eq!(waiting.ask(&numbered(1).to_string())["id"], 1);
    // Frozen, the planner takes requests and answers none.
    planner.signal(Signal::STOP);
    waiting.child.stdin.as_mut().unwrap().write_all(numbered(2).to_string().as_bytes()).unwrap();
    std::thread::sleep(std::time::Duration::from_millis(50));
    kill_process(&waiting.child, Signal::INT);
    assert_eq!(waiting.child.wait().unwrap().code(), Some(130));
    planner.signal(Signal::CONT);
}

#[test]
fn csv_has_a_row_for_each_sample() {
    let test = TestDomain::new();
    test.write("bad.json", "{}");
    let good = scene_path("disassemble-channels.json");
    let ended = plan(&test, &["--format", "csv", "bad.json", &good]);
    // Rows have no room for a refusal: it goes to stderr.
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.starts_with("plan: bad.json: refused, invalid_scene"), "{}", ended.stderr);
    let mut rows = ended.stdout.lines();
    assert_eq!(rows.next(), Some("scene,id,answer,t,x,y,z,heading,vx,vy,vz,yaw_rate"));
    let rows: Vec<Vec<f64>> =
        rows.map(|row| row.split(',').map(|value| value.parse().unwrap()).collect()).collect();
    let json = plan(&test, &["--format", "json", &good]).stdout;
    let reply: Value = serde_json::from_str(&json).unwrap();
    let samples = reply["trajectories"][0]["samples"].as_array().unwrap();
    assert_eq!(rows.len(), samples.len());
    for (row, sample) in rows.iter().zip(samples) {
        let number = |value: &Value| value.as_f64().unwrap();
        let (position, velocity) = (&sample["position"], &sample["velocity"]);
        // Assembly in two dimensions lives in (x, z).
        let expected = [
            2.0,
            9.0,
            0.0,
            number(&sample["t"]),
            number(&position[0]),
            0.0,
            number(&position[1]),
            number(&sample["heading"]),
            number(&velocity[0]),
            0.0,
            number(&velocity[1]),
            number(&sample["yaw_rate"]),
        ];
        assert_eq!(row.as_slice(), expected);
    }
}

#[test]
fn the_scenes_of_a_csv_can_be_told_apart() {
    let test = TestDomain::new();
    let mut unnumbered = numbered(0);
    unnumbered.as_object_mut().unwrap().remove("id");
    let mut refused = numbered(4);
    refused["limits"]["speed"] = (-1).into();
    let mut several = numbered(5);
    several["clearance"] = serde_json::json!({ "each": [0.2, 7, "safest"] });
    let stdin = format!("{}\n{unnumbered}\n{refused}\n{several}\n", numbered(3));
    let ended = test.start("plan", &["--local", "--format", "csv", "-"], Some(&stdin)).wait();
    assert_eq!(ended.code, Some(1));
    let mut rows = ended.stdout.lines();
    let columns = rows.next().unwrap().split(',').count();
    let mut scenes: Vec<_> = rows
        .map(|row| {
            let fields: Vec<_> = row.split(',').collect();
            assert_eq!(fields.len(), columns, "{row}");
            fields[..3].join(",")
        })
        .collect();
    scenes.dedup();
    assert_eq!(scenes, ["1,3,0", "2,,0", "4,5,0", "4,5,2"]);
    // Refusals go to stderr: every row is a sample.
    let said: Vec<_> = ended.stderr.lines().collect();
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said[0].starts_with("plan: scene 3 (line 3) (id 4): refused, invalid_scene: "));
    assert!(said[1].starts_with("plan: scene 4 (line 4) (id 5): answer 1: refused, gap_out_"));
}

#[test]
fn pictures_are_written_but_replace_nothing() {
    let test = TestDomain::new();
    let [one, two] = ["disassemble.json", "assemble.json"].map(scene_path);
    let arguments = ["--svg", "picture.svg", one.as_str(), two.as_str()];
    let drawn = plan(&test, &arguments);
    assert_eq!((drawn.code, drawn.stderr.as_str()), (Some(0), ""));
    assert!(test.path("picture.svg").exists() && test.path("picture-2.svg").exists());

    test.write("picture.svg", "precious");
    let refused = plan(&test, &arguments);
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains("picture.svg exists; --overwrite replaces it"), "{refused:?}");
    assert_eq!(std::fs::read_to_string(test.path("picture.svg")).unwrap(), "precious");

    let replaced = plan(&test, &[&arguments[..], &["--overwrite"]].concat());
    assert_eq!(replaced.code, Some(0));
    assert_ne!(std::fs::read_to_string(test.path("picture.svg")).unwrap(), "precious");
}

#[test]
fn pictures_are_checked_before_anything_is_planned() {
    let test = TestDomain::new();
    let [one, two] = ["disassemble.json", "assemble.json"].map(scene_path);
    test.write("b-2.svg", "precious");
    std::fs::create_dir(test.path("folder.svg")).unwrap();
    let copy = test.write("copy.json", &scene_text("disassemble.json"));
    for (arguments, says) in [
        (&["--svg", "b.svg", &one, &two][..], "b-2.svg exists; --overwrite replaces it"),
        (&["--svg", "nowhere/b.svg", &one], "can't write nowhere/b.svg: No such file"),
        (&["--svg", "b-2.svg/c.svg", &one], "can't write b-2.svg/c.svg: Not a directory"),
        (&["--svg", "folder.svg", &one, "--overwrite"], "folder.svg is a folder"),
        (&["--svg", "copy.json", "copy.json", "--overwrite"], "would replace a scene"),
        (&["--svg", "b-2.svg", "-"], "b-2.svg exists"),
    ] {
        let refused = plan(&test, arguments);
        // Not even a header is printed.
        assert_eq!((refused.code, refused.stdout.as_str()), (Some(1), ""), "{arguments:?}");
        assert!(refused.stderr.contains(says), "{arguments:?}: {}", refused.stderr);
    }
    assert_eq!(std::fs::read_to_string(test.path("b-2.svg")).unwrap(), "precious");
    assert_eq!(std::fs::read_to_string(copy).unwrap(), scene_text("disassemble.json"));
    assert!(!test.path("b.svg").exists());
}
