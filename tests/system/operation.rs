//! What operators rely on: logs that programs read, a service manager's messages, and a /dev/shm
//! that fills up.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixDatagram;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use integration_tests::{
    Ended, LONG, Process, Signal, TestDomain, kill_pid, program, scene, scene_text, serving,
    wait_for,
};
use schemas::json::scene_to_json;
use schemas::message::{Choice, ClearanceWish, Gap, Sampling, SceneRequest};
use serde_json::Value;

fn objects(text: &str) -> Vec<Value> {
    let object = |line: &str| {
        assert!(line.len() < 1000, "{line}");
        let object: Value = serde_json::from_str(line).unwrap_or_else(|_| panic!("{line}"));
        assert!(object["timestamp"].is_string() && object["target"].is_string(), "{line}");
        object
    };
    text.lines().map(object).collect()
}

#[test]
fn json_logs_are_objects_to_the_last_line() {
    let test = TestDomain::new();
    let name = test.domain().to_string();
    let arguments = ["--domain", &name, "--log-format", "json"];
    for level in ["info", "debug"] {
        let mut planner = Command::new(program("planner"));
        planner.args(arguments).env("RUST_LOG", level);
        let mut planner = test.start_command("planner", planner, None);
        planner.wait_until_it_says("\"message\":\"ready\"");
        test.left();
        let scene = test.write("scene.json", &scene_text("disassemble-channels.json"));
        let recorder = test.recorder("run.mcap", &["--overwrite", "--log-format", "json"]);
        assert_eq!(test.plan(&[scene.to_str().unwrap()]).code, Some(0));
        let ended = recorder.stop();
        assert_eq!(objects(&ended.stderr)[0]["message"], "recording");
        assert!(ended.stdout.ends_with("3 messages recorded, 0 lost\n"), "{ended:?}");

        let second = test.run("planner", &arguments);
        assert_eq!(second.code, Some(1));
        let said = objects(&second.stderr);
        let message = format!("another planner serves domain {name}");
        assert!(said.iter().any(|object| object["message"] == *message), "{said:?}");
        let ended = planner.stop();
        let said = objects(&ended.stderr);
        let ready = said.iter().find(|object| object["message"] == "ready").unwrap();
        assert_eq!((&ready["domain"], &ready["level"]), (&name.clone().into(), &"INFO".into()));
        let done = said.iter().find(|object| object["message"] == "done").unwrap();
        assert_eq!(done["requests"], 1);
        // The library's own lines are for developers.
        let of_the_library = said.iter().any(|object| object["target"] == "iceoryx2");
        assert!(!of_the_library || level == "debug", "{said:?}");
    }
    let wrong = test.run("planner", &["--log-format", "xml"]);
    assert_eq!(wrong.code, Some(2));
    assert!(wrong.stderr.contains("it is either text or json"), "{}", wrong.stderr);
}

#[test]
fn a_service_manager_hears_of_readiness_life_and_end() {
    let test = TestDomain::new();
    let manager = UnixDatagram::bind(test.path("manager")).unwrap();
    manager.set_read_timeout(Some(LONG)).unwrap();
    let hear = || {
        let mut buffer = [0; 512];
        let length = manager.recv(&mut buffer).unwrap();
        String::from_utf8(buffer[..length].to_vec()).unwrap()
    };
    let hear_until = |wanted: &str| while !hear().lines().any(|line| line == wanted) {};
    let mut command = Command::new(program("planner"));
    command.args(["--domain", test.domain().name()]).env_remove("RUST_LOG");
    command.env("NOTIFY_SOCKET", test.path("manager")).env("WATCHDOG_USEC", "100000");
    let planner = test.start_command("planner", command, None);
    let first = hear();
    assert_eq!(first, format!("READY=1\nSTATUS=serving domain {}\n", test.domain()));
    test.left();
    hear_until("WATCHDOG=1");

    // One that is stuck says nothing.
    let process = serving(&test);
    kill_pid(process, Signal::STOP);
    wait_for("it to stop", || {
        let status = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
        status.contains(") T ").then_some(())
    });
    manager.set_nonblocking(true).unwrap();
    while manager.recv(&mut [0; 512]).is_ok() {}
    std::thread::sleep(Duration::from_millis(300));
    assert!(manager.recv(&mut [0; 512]).is_err(), "it is stopped");
    manager.set_nonblocking(false).unwrap();

    kill_pid(process, Signal::KILL);
    hear_until("STATUS=starting again after SIGKILL");
    hear_until("READY=1");
    hear_until("WATCHDOG=1");
    planner.signal(Signal::TERM);
    hear_until("STOPPING=1");
    let ended = planner.wait();
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(test.left().is_empty(), "{:?}", test.left());
}

/// A planner whose /dev/shm is its own, of this size; none where that is forbidden.
fn planner_with_memory(test: &TestDomain, size: &str, arguments: &[&str]) -> Option<Process> {
    let mount = format!("mount -t tmpfs -o size={size} tmpfs /dev/shm");
    let unshare = |script: &str| {
        let mut command = Command::new("unshare");
        command.args(["-m", "sh", "-c", script, "sh"]);
        command
    };
    if !unshare(&mount).output().is_ok_and(|tried| tried.status.success()) {
        println!("SKIPPED: a /dev/shm of one's own takes root");
        return None;
    }
    test.write(
        "planner.toml",
        "max_clients = 4\nrequests_per_client = 1\nmax_recorders = 1\ntap_buffer = 16",
    );
    let mut command = unshare(&format!("{mount} && exec \"$@\""));
    command.arg(program("planner")).args(["--domain", test.domain().name()]);
    command.args(["--config", "planner.toml"]).args(arguments).env_remove("RUST_LOG");
    Some(test.start_command("planner", command, None))
}

/// A command with the /dev/shm of this planner.
fn beside(test: &TestDomain, planner: &Process, arguments: &[&str]) -> Command {
    let mut command = Command::new("nsenter");
    command.args(["-m", "-t", &planner.id().to_string()]).args(arguments);
    command.env(bus::ROOT_VARIABLE, test.root()).env_remove("RUST_LOG");
    command
}

fn fill(test: &TestDomain, planner: &Process) {
    let fill = "cat /dev/zero > /dev/shm/fill 2>/dev/null; test -s /dev/shm/fill";
    assert!(beside(test, planner, &["sh", "-c", fill]).status().unwrap().success());
}

/// Sends scenes to a planner as they come.
struct Plan {
    child: Child,
    replies: BufReader<std::process::ChildStdout>,
}

impl Plan {
    fn start(test: &TestDomain, planner: &Process) -> Self {
        let plan = program("plan");
        let name = test.domain().to_string();
        let arguments = ["--domain", &name, "--timeout", "60s", "--format", "json", "-"];
        let mut command =
            beside(test, planner, &[&[plan.to_str().unwrap()], &arguments[..]].concat());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let replies = BufReader::new(child.stdout.take().unwrap());
        Self { child, replies }
    }

    fn ask(&mut self, scene: &SceneRequest) -> String {
        let scene = scene_to_json(scene).replace('\n', " ");
        writeln!(self.child.stdin.as_mut().unwrap(), "{scene}").unwrap();
        let mut reply = String::new();
        self.replies.read_line(&mut reply).unwrap();
        reply
    }

    fn end(self) -> Ended {
        let ended = self.child.wait_with_output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Ended { code: ended.status.code(), stdout: text(ended.stdout), stderr: text(ended.stderr) }
    }
}

fn short() -> SceneRequest {
    SceneRequest { sampling: Some(Sampling::Count(2)), ..scene("disassemble-channels.json") }
}

/// A reply of 1.4 MB.
fn long_reply() -> SceneRequest {
    SceneRequest { sampling: Some(Sampling::Count(20_000)), ..short() }
}

/// More than a client has memory for from the start.
fn long_request() -> SceneRequest {
    let gap = |index| Choice::Gap(Gap::Uniform(0.01 + 1e-5 * f64::from(index)));
    SceneRequest { clearance: ClearanceWish::Each((0..2000).map(gap).collect()), ..short() }
}

#[test]
fn reserved_memory_does_not_run_out() {
    let test = TestDomain::new();
    let Some(mut planner) = planner_with_memory(&test, "16m", &["--reserve"]) else { return };
    planner.wait_until_it_says("ready");
    let mut plan = Plan::start(&test, &planner);
    assert!(plan.ask(&short()).contains("trajectories"));
    fill(&test, &planner);
    for _ in 0..3 {
        assert!(plan.ask(&long_reply()).contains("trajectories"));
    }
    // What clients lack they are told.
    let late = Plan::start(&test, &planner).end();
    assert_eq!(late.code, Some(1), "{late:?}");
    let said = "/dev/shm has 0 bytes free, connecting to the planner needs 147456";
    assert!(late.stderr.contains(said), "{late:?}");
    plan.ask(&long_request());
    let ended = plan.end();
    assert_eq!(ended.code, Some(1), "{ended:?}");
    let said = "/dev/shm has 0 bytes free, this request needs ";
    assert!(ended.stderr.contains(said), "{ended:?}");
    let ended = planner.stop();
    assert_eq!(ended.code, Some(0));
    assert!(!ended.stderr.contains("died"), "{}", ended.stderr);
}

#[test]
fn a_planner_without_memory_says_why_it_dies_and_comes_back() {
    let test = TestDomain::new();
    let Some(mut planner) = planner_with_memory(&test, "16m", &[]) else { return };
    planner.wait_until_it_says("ready");
    let mut plan = Plan::start(&test, &planner);
    assert!(plan.ask(&short()).contains("trajectories"));
    fill(&test, &planner);
    plan.ask(&long_reply());
    let ended = plan.end();
    assert_eq!(ended.code, Some(1), "{ended:?}");
    assert!(ended.stderr.contains("planner_lost"), "{ended:?}");
    planner.wait_until_it_says("SIGBUS: no shared memory was left");
    planner.wait_until_it_says("bytes free, these settings can need");
    planner.wait_until_it_says("can't start again yet");
    let removed = beside(&test, &planner, &["rm", "/dev/shm/fill"]).status().unwrap();
    assert!(removed.success());
    wait_for("another", || (planner.stderr().matches(" ready ").count() == 2).then_some(()));
    let mut plan = Plan::start(&test, &planner);
    assert!(plan.ask(&long_reply()).contains("trajectories"));
    drop(plan.child.stdin.take());
    assert_eq!(plan.end().code, Some(0));
    assert_eq!(planner.stop().code, Some(0));
}

#[test]
fn too_little_memory_is_refused_at_the_start() {
    let test = TestDomain::new();
    let Some(planner) = planner_with_memory(&test, "1m", &["--reserve"]) else { return };
    let ended = planner.wait();
    assert_eq!(ended.code, Some(1));
    let said = "bytes free, these settings can need ";
    assert!(ended.stderr.contains(said), "{}", ended.stderr);
}
