//! Domains: who is in them, whose they are, and waiting for a planner.

use std::io::{BufRead, BufReader};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use integration_tests::{Signal, TestDomain, kill_process, program, root, scene_text};
use serde_json::{Value, json};

/// What `plan --list` says, as JSON.
fn listed(test: &TestDomain) -> Vec<Value> {
    let ended = test.run("plan", &["--list", "--format", "json"]);
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
    ended.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn scene_path() -> String {
    root().join("recordings/scenes/disassemble-channels.json").display().to_string()
}

#[test]
fn a_list_says_who_is_in_which_domain() {
    let test = TestDomain::new();
    assert_eq!(listed(&test), [Value::Null; 0]);
    let none = test.run("plan", &["--list"]);
    assert_eq!(none.stdout, format!("no domain is in use under {}\n", test.root().display()));

    let planner = test.planner(&[]);
    let _recorder = test.recorder("run.mcap", &[]);
    let _clients = [test.connect(), test.connect()];
    let status = listed(&test).remove(0);
    assert_eq!(status["domain"], json!(test.domain().name()));
    assert_eq!(status["planner"], json!({"pid": planner.id(), "alive": true}));
    assert_eq!((&status["clients"], &status["recorders"]), (&json!(2), &json!(1)));
    let directory = Path::new(status["directory"].as_str().unwrap());
    assert!(directory.starts_with(test.root()) && directory.exists(), "{status}");
    let text = test.run("plan", &["--list"]).stdout;
    let row = text.lines().nth(1).unwrap();
    assert!(row.starts_with(test.domain().name()), "{text}");
    assert!(row.contains(&format!("/dev/shm/{}*", status["prefix"].as_str().unwrap())), "{text}");

    let process = planner.id();
    planner.kill();
    assert_eq!(listed(&test)[0]["planner"], json!({"pid": process, "alive": false}));
}

#[test]
fn clients_may_start_first() {
    let test = TestDomain::new();
    let name = test.domain().to_string();
    let arguments = ["--domain", &name, "--wait", "60s", "--format", "json", &scene_path()];
    let waiting = [(); 2].map(|()| test.start("plan", &arguments, None));
    std::thread::sleep(Duration::from_millis(300));
    let _planner = test.planner(&[]);
    for plan in waiting {
        let ended = plan.wait();
        assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
        assert!(ended.stdout.contains("trajectories"), "{}", ended.stdout);
    }
}

#[test]
fn a_wait_for_a_planner_ends_in_time_and_by_signals() {
    let test = TestDomain::new();
    let ended = test.plan(&["--wait", "200ms", &scene_path()]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.contains("no planner runs in domain"), "{}", ended.stderr);
    let name = test.domain().to_string();
    let waiting = test.start("plan", &["--domain", &name, "--wait", "1h", &scene_path()], None);
    std::thread::sleep(Duration::from_millis(300));
    waiting.signal(Signal::INT);
    assert_eq!(waiting.wait().code, Some(130));
    assert!(test.left().is_empty(), "{:?}", test.left());
}

#[test]
fn clients_that_are_killed_while_they_start_leave_no_files_and_no_warnings() {
    let test = TestDomain::new();
    let planner = test.planner(&[]);
    let name = test.domain().to_string();
    for step in 0..40 {
        let plan = test.start("plan", &["--domain", &name, &scene_path()], None);
        std::thread::sleep(Duration::from_micros(300 * step));
        plan.kill();
    }
    let ended = planner.stop();
    assert_eq!(ended.code, Some(0));
    assert!(!ended.stderr.contains("iceoryx2"), "{}", ended.stderr);
    assert!(test.left().is_empty(), "{:?}", test.left());
}

#[test]
fn the_root_is_the_users_runtime_directory_or_in_tmp() {
    let runtime = tempfile::tempdir_in("/tmp").unwrap();
    let user = std::fs::metadata("/proc/self").unwrap().uid();
    let fallback = format!("/tmp/clearway-{user}");
    let in_runtime = runtime.path().join("clearway").display().to_string();
    for (mode, set, expected) in
        [(0o700, true, &in_runtime), (0o755, true, &fallback), (0o700, false, &fallback)]
    {
        std::fs::set_permissions(runtime.path(), std::fs::Permissions::from_mode(mode)).unwrap();
        let mut plan = Command::new(program("plan"));
        plan.args(["--domain", "it-nowhere", &scene_path()]).env_remove("CLEARWAY_ROOT");
        match set {
            true => plan.env("XDG_RUNTIME_DIR", runtime.path()),
            false => plan.env_remove("XDG_RUNTIME_DIR"),
        };
        let ended = plan.output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr);
        assert!(said.contains(&format!("domain it-nowhere under {expected} ")), "{said}");
        // A directory that nobody has chosen goes with the last.
        assert!(!Path::new(&in_runtime).exists());
    }
}

/// A user that exists everywhere, and owns nothing.
const NOBODY: u32 = 65534;

/// Programs that anybody can run, and a scene that anybody can read.
struct Shared(tempfile::TempDir);

impl Shared {
    fn new() -> Self {
        let directory = tempfile::tempdir_in("/tmp").unwrap();
        let open = |path: &Path| {
            std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).unwrap();
        };
        open(directory.path());
        for name in ["planner", "plan"] {
            let shared = directory.path().join(name);
            // A copy only where it must be: programs with what debuggers need are large.
            if std::fs::hard_link(program(name), &shared).is_err() {
                std::fs::copy(program(name), &shared).unwrap();
            }
            open(&shared);
        }
        let scene = directory.path().join("scene.json");
        std::fs::write(&scene, scene_text("disassemble-channels.json")).unwrap();
        open(&scene);
        Self(directory)
    }

    /// A program, run by a user who has chosen no directory.
    fn command(&self, name: &str, user: u32) -> Command {
        let mut command = Command::new(self.0.path().join(name));
        command.env_remove("CLEARWAY_ROOT").env_remove("XDG_RUNTIME_DIR").env_remove("RUST_LOG");
        command.uid(user).gid(user).current_dir("/").stdin(Stdio::null());
        command
    }

    fn planner(&self, domain: &str, user: u32) -> Running {
        let mut command = self.command("planner", user);
        let mut child = command.args(["--domain", domain]).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = String::new();
        BufReader::new(child.stderr.as_mut().unwrap()).read_line(&mut said).unwrap();
        assert!(said.contains("ready"), "{said}");
        Running(child)
    }

    fn plan(&self, arguments: &[&str], user: u32) -> std::process::Output {
        self.command("plan", user).args(arguments).output().unwrap()
    }

    fn scene(&self) -> String {
        self.0.path().join("scene.json").display().to_string()
    }
}

/// A process that ends with this.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        kill_process(&self.0, Signal::TERM);
        let _ = self.0.wait();
    }
}

fn in_memory(prefix: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir("/dev/shm").unwrap().map(|entry| entry.unwrap());
    let named = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(prefix));
    named.map(|entry| entry.path()).collect()
}

#[test]
fn users_have_domains_of_their_own() {
    if std::fs::metadata("/proc/self").unwrap().uid() != 0 {
        println!("SKIPPED: only root can start programs as another user");
        return;
    }
    let shared = Shared::new();
    let domain = format!("it-users-{}", std::process::id());
    let planners = [0, NOBODY].map(|user| shared.planner(&domain, user));
    let mut prefixes = Vec::new();
    for user in [0, NOBODY] {
        let ended = shared.plan(&["--domain", &domain, &shared.scene()], user);
        assert!(ended.status.success(), "{user}: {ended:?}");
        let listed = shared.plan(&["--list", "--format", "json"], user);
        let listed = String::from_utf8(listed.stdout).unwrap();
        let rows: Vec<Value> =
            listed.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let row = rows.iter().find(|row| row["domain"] == json!(domain)).unwrap();
        let directory = row["directory"].as_str().unwrap();
        assert!(directory.starts_with(&format!("/tmp/clearway-{user}/")), "{directory}");
        prefixes.push(row["prefix"].as_str().unwrap().to_owned());
    }
    assert_ne!(prefixes[0], prefixes[1]);

    // What is the first's, the second can't open.
    let files = in_memory(&prefixes[0]);
    assert!(files.len() > 5, "{files:?}");
    for path in &files {
        let read = Command::new("cat").arg(path).uid(NOBODY).gid(NOBODY).output().unwrap();
        assert!(!read.status.success(), "{} can be read", path.display());
    }
    let mut into = shared.command("plan", NOBODY);
    let into = into.env("CLEARWAY_ROOT", "/tmp/clearway-0").args(["--domain", &domain]);
    let ended = into.arg(shared.scene()).output().unwrap();
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{said}");
    assert!(said.contains("it belongs to the user with id 0"), "{said}");

    drop(planners);
    for prefix in prefixes {
        assert_eq!(in_memory(&prefix), Vec::<PathBuf>::new());
    }
    for user in [0, NOBODY] {
        assert!(!Path::new(&format!("/tmp/clearway-{user}/{domain}.toml")).exists());
    }
}
