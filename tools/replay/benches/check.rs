//! What `replay check` takes: requests a second on one core and how much of that is planning, a
//! large recording with the memory it needs, and a page with 1,000 differences in a browser.
//!
//! `cargo bench -p clearway-replay --bench check [-- MEGABYTES]`; `CLEARWAY_CHROMIUM` names the
//! browser.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use answer::{Answerer, Caps};
use comparison::check::check;
use comparison::exchanges::{self, Exchange};
use comparison::tolerance::Tolerance;
use recording::{Options, Writer};
use schemas::message::{ReplyPart, Request, RequestKey};

fn main() {
    // Cargo's own arguments begin with dashes.
    let given = std::env::args().skip(1).find_map(|argument| argument.parse::<u64>().ok());
    let megabytes = given.unwrap_or(500);
    rates();
    let folder = tempfile::tempdir().expect("a folder for recordings");
    large(folder.path(), megabytes);
    page(folder.path());
}

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../recordings").join(name)
}

fn exchanges_of(name: &str) -> Vec<Exchange> {
    let mut all = Vec::new();
    let contents = exchanges::read(&golden(name), |_| {}, |exchange| all.push(exchange));
    assert!(contents.error.is_none(), "golden recordings are whole");
    all
}

/// Requests a second on one core.
fn rates() {
    println!("{:<18}{:>10}{:>12}{:>10}", "recording", "a second", "each", "planning");
    for name in
        ["disassembly.mcap", "driving.mcap", "free-space.mcap", "no-route.mcap", "routes.mcap"]
    {
        let mut answerer = Answerer::new(&Caps::default());
        let (mut requests, mut planning) = (0, Duration::ZERO);
        let began = Instant::now();
        while began.elapsed() < Duration::from_secs(2) {
            let plan = |request: &Request| {
                let began = Instant::now();
                let reply = answerer.reply_to(request);
                planning += began.elapsed();
                reply
            };
            let checked = check(&[golden(name)], &Tolerance::EXACT, plan, |_| {});
            assert_eq!(checked.counts().different, 0);
            requests += checked.cases.len();
        }
        let took = began.elapsed();
        let each = took / requests as u32;
        let rate = requests as f64 / took.as_secs_f64();
        let share = 100.0 * planning.as_secs_f64() / took.as_secs_f64();
        println!("{name:<18}{rate:>10.0}{each:>12.1?}{share:>8.0} %");
    }
}

/// The requests of a recording again and again until there are enough bytes, or answers.
fn repeat(
    path: &Path,
    name: &str,
    enough: impl Fn(&Writer, u64) -> bool,
    change: fn(&mut Exchange),
) {
    let all = exchanges_of(name);
    let mut writer = Writer::create(path, Options::default()).expect("it is new");
    let (mut sequence, mut all_answers) = (0, 0);
    while !enough(&writer, all_answers) {
        let exchange = &all[sequence as usize % all.len()];
        let Exchange { index, request, reply, .. } = exchange;
        let mut copy = Exchange {
            index: *index,
            request: request.clone(),
            reply: reply.clone(),
            uploads: Vec::new(),
        };
        change(&mut copy);
        let key = RequestKey { client: 1, sequence };
        writer.write_request(&Request { key, ..copy.request }, sequence).expect("there is room");
        let answers = copy.reply.answers.expect("golden motions are answers");
        let count = answers.len() as u32;
        all_answers += u64::from(count);
        for (index, content) in answers.into_iter().enumerate() {
            let (part, last) = (index as u32, index as u32 + 1 == count);
            let (id, answer) = (copy.reply.id, part);
            let part =
                ReplyPart { key, id, sent_ns: 0, part, last, answer, answers: count, content };
            writer.write_reply(&part, sequence).expect("there is room");
        }
        sequence += 1;
    }
    writer.finish().expect("there is room");
}

/// A large recording, checked by the program.
fn large(folder: &Path, megabytes: u64) {
    for part in [10, 1] {
        let path = folder.join("large.mcap");
        let bytes = megabytes * 1_000_000 / part;
        repeat(&path, "driving.mcap", |writer, _| writer.written() >= bytes, |_| {});
        let mut child = Command::new(env!("CARGO_BIN_EXE_replay"))
            .arg("check")
            .arg(&path)
            .stdout(Stdio::piped())
            .spawn()
            .expect("it runs");
        let began = Instant::now();
        let (status, mut peak) = (format!("/proc/{}/status", child.id()), String::new());
        while child.try_wait().expect("it is ours").is_none() {
            let text = fs::read_to_string(&status).unwrap_or_default();
            let line = text.lines().find(|line| line.starts_with("VmHWM:"));
            peak = line.map_or(peak, |line| line["VmHWM:".len()..].trim().to_owned());
            thread::sleep(Duration::from_millis(10));
        }
        let took = began.elapsed();
        let said = child.wait_with_output().expect("it is ours").stdout;
        let said = String::from_utf8_lossy(&said);
        let said = said.trim().rsplit(": ").next().unwrap_or_default().to_owned();
        println!("{} MB: {said} in {took:.1?}, at most {peak} of memory", bytes / 1_000_000);
        fs::remove_file(&path).expect("it is ours");
    }
}

/// A page with 1,000 differences, in a browser.
fn page(folder: &Path) {
    repeat(
        &folder.join("moved.mcap"),
        "disassembly.mcap",
        |_, answers| answers >= 1_000,
        |exchange| {
            for motion in exchange.reply.answers.iter_mut().flatten().flatten() {
                motion.samples.iter_mut().for_each(|sample| sample.position[1] += 0.01);
            }
        },
    );
    let began = Instant::now();
    let done = Command::new(env!("CARGO_BIN_EXE_replay"))
        .args(["check", "moved.mcap", "--html", "page.html"])
        .current_dir(folder)
        .output()
        .expect("it runs");
    assert_eq!(done.status.code(), Some(4), "everything has moved");
    let bytes = fs::metadata(folder.join("page.html")).expect("it was written").len();
    println!("page: {:.1} MB, written in {:.1?}", bytes as f64 * 1e-6, began.elapsed());
    let browser = std::env::var("CLEARWAY_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    // The page tells itself when it is there: printing all of it would take longer.
    let tell = "<script>addEventListener('load', () => {
        document.documentElement.textContent = performance.now();
    });</script></html>";
    let page = fs::read_to_string(folder.join("page.html")).expect("it was written");
    fs::write(folder.join("page.html"), page.replace("</html>", tell)).expect("there is room");
    for _ in 0..3 {
        let done = Command::new(&browser)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"])
            .arg(folder.join("page.html"))
            .output();
        let Ok(done) = done else { return println!("no browser {browser:?} here") };
        let said = String::from_utf8_lossy(&done.stdout).into_owned();
        let number = said.split(['<', '>']).find_map(|text| text.trim().parse::<f64>().ok());
        let took = number.unwrap_or_else(|| panic!("no time in {said:.200}"));
        println!("opened in {:.2} s", took * 1e-3);
    }
}
