//! Planners and clients in processes of their own, which can be killed.
//!
//! They are this test program again: [`run`] plays the part that the environment names.

use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use bus::{Domain, Server, ServerOptions, TapReader, Wait, Woken};
use rustix::process::{Pid, Signal, kill_process};

use crate::support::*;
use crate::version_1::OldClient;

/// A process that is killed when this is dropped.
pub(crate) struct Process(Child);

impl Process {
    /// Starts a process that plays `part`, and waits until it has said that it is ready.
    pub(crate) fn start(part: &str, domain: &TestDomain) -> Self {
        Self::start_by(Command::new("env"), part, domain)
    }

    /// Does so by way of a program that runs the one it is given.
    pub(crate) fn start_by(by: Command, part: &str, domain: &TestDomain) -> Self {
        let mut process = Self::begin_by(by, part, domain);
        let child = &mut process.0;
        let mut output = child.stdout.take().unwrap();
        let mut said = Vec::new();
        let mut byte = [0];
        while !said.ends_with(b"ready\n") {
            assert_eq!(output.read(&mut byte).unwrap(), 1, "{part} failed to start");
            said.push(byte[0]);
        }
        child.stdout = Some(output);
        domain.note();
        process
    }

    /// Starts a process that plays `part`, and does not wait.
    pub(crate) fn begin(part: &str, domain: &TestDomain) -> Self {
        Self::begin_by(Command::new("env"), part, domain)
    }

    fn begin_by(mut by: Command, part: &str, domain: &TestDomain) -> Self {
        let child = by
            .arg(std::env::current_exe().unwrap())
            .args(["--exact", "process::run", "--ignored", "--nocapture"])
            .env("BUS_PART", part)
            .env("CLEARWAY_ROOT", domain.root())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        Self(child)
    }

    pub(crate) fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.0), signal).unwrap();
    }

    /// Ends it as a crash would.
    pub(crate) fn kill(mut self) {
        self.signal(Signal::KILL);
        self.0.wait().unwrap();
    }

    /// Waits until it ends by itself; whether that was in time and in order.
    pub(crate) fn ends_within(mut self, limit: Duration) -> bool {
        let until = Instant::now() + limit;
        while Instant::now() < until {
            if let Some(status) = self.0.try_wait().unwrap() {
                return status.success();
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        false
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The parts.
#[test]
#[ignore = "for other tests to start"]
fn run() {
    let Ok(part) = std::env::var("BUS_PART") else { return };
    let domain = Domain::new("test").unwrap();
    let ready = || println!("\nready");
    let client = || connect(&domain, Wait::Event);
    match part.as_str() {
        "planner" | "polling planner" | "planner that answers nothing" => {
            let wait = if part == "polling planner" { Wait::Poll } else { Wait::Hybrid };
            let mut server =
                Server::open(&domain, &ServerOptions { wait, ..ServerOptions::default() }).unwrap();
            ready();
            let mut open = OpenReplies::default();
            while server.wait(open.next_try()) == Woken::Look {
                while let Some(mut incoming) = server.receive() {
                    if part == "planner that answers nothing" {
                        std::thread::sleep(Duration::from_secs(60));
                    }
                    incoming.copy(usize::MAX, &mut Vec::new()).unwrap();
                    let answered = answer(&incoming.header(), &mut incoming);
                    open.add(incoming, answered);
                }
                open.flush(|_| {});
            }
        }
        "client that asks and hangs" | "client that asks twice and hangs" => {
            let client = client();
            let times = if part == "client that asks and hangs" { 1 } else { 2 };
            let _open: Vec<_> =
                (0..times).map(|_| client.send(&scene(1, 100_000)).unwrap()).collect();
            ready();
            std::thread::sleep(Duration::from_secs(60));
        }
        "client that comes and goes" => {
            ready();
            loop {
                client().call(&scene(1, 1), LONG).unwrap();
            }
        }
        "client that waits" => {
            let client = client();
            let mut pending = client.send(&scene(1, 1)).unwrap();
            ready();
            let _ = pending.wait(Instant::now() + Duration::from_secs(60));
        }
        "client of version 1" => {
            let client = OldClient::connect(bare_node(&domain.root().unwrap()), 77);
            ready();
            for id in 0..200 {
                let reply = client.call(&scene(id, 2_000));
                assert_eq!(reply.content, Ok(trajectory(id, 2_000)));
            }
        }
        "recorder" => {
            let mut tap = TapReader::connect(&domain).unwrap();
            ready();
            while !tap.terminated() {
                tap.receive();
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        part => panic!("no part {part}"),
    }
}
