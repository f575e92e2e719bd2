//! The crate for users, against real planners.

use std::pin::pin;
use std::sync::Arc;
use std::task::{Context, Poll, Wake, Waker};
use std::thread::Thread;
use std::time::Duration;

use clearway_client::{CallError, Client, ConnectError, Error, Reply, Scene};
use integration_tests::load::{endless, short};
use integration_tests::{LONG, OFFICE, TestDomain, scene_files, scene_text, wait_for};
use schemas::message::{ErrorCode, Sampling, SceneRequest};

fn client(test: &TestDomain) -> Client {
    Client::connect(&test.domain()).unwrap()
}

/// A scene whose reply has so many samples.
fn sampled(samples: u64) -> Scene {
    let sampling = Some(Sampling::Count(samples));
    Scene::new(SceneRequest { sampling, ..short(1) }).unwrap()
}

fn count(reply: &Reply) -> usize {
    reply.trajectories().unwrap().iter().map(|trajectory| trajectory.samples().count()).sum()
}

#[test]
fn every_scene_is_answered_as_without_a_bus() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = client(&test);
    let files = scene_files();
    let paths: Vec<_> = files.iter().map(|path| path.to_str().unwrap()).collect();
    let local = test.run("plan", &[&["--local", "--format", "json"], paths.as_slice()].concat());
    let texts = files.iter().map(|path| std::fs::read_to_string(path).unwrap());
    let scenes: Vec<_> = texts.map(|text| Scene::from_json(&text).unwrap()).collect();
    let replies = client.plan_many(&scenes, LONG);
    let lines: String =
        replies.iter().map(|reply| reply.as_ref().unwrap().to_json() + "\n").collect();
    assert!(lines == local.stdout, "the same replies to {paths:?}");

    // Those that are mostly refused, line by line.
    for name in ["refusals.jsonl", "no-route.jsonl", "drives.jsonl"] {
        let text = scene_text(name);
        let arguments = ["--local", "--format", "json", "-"];
        let local = test.start("plan", &arguments, Some(&text)).wait();
        let replies = text.lines().map(|line| {
            let scene = Scene::from_json(line).map_err(Error::from);
            match scene.and_then(|scene| client.plan(&scene, LONG)) {
                Ok(reply) => reply.to_json(),
                Err(Error::Refused(refused)) => refused.refusal().message.clone(),
                Err(error) => panic!("{error}"),
            }
        });
        for (reply, line) in replies.zip(local.stdout.lines()) {
            let expected: serde_json::Value = serde_json::from_str(line).unwrap();
            match expected["error"]["message"].as_str() {
                Some(message) => assert_eq!(reply, message),
                None => assert_eq!(reply, line),
            }
        }
    }
}

#[test]
fn long_replies_to_many_requests_are_all_taken() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = client(&test);
    // The first takes longer than a reply that nobody takes is kept.
    let slow = Scene::new(SceneRequest { deadline: Some(0.4), ..endless(1) }).unwrap();
    let scenes = [slow, sampled(20_000), sampled(20_000), sampled(20_000), sampled(20_000)];
    let replies = client.plan_many(&scenes, LONG);
    for reply in &replies[1..] {
        assert!(count(reply.as_ref().unwrap()) >= 20_000);
    }
    let late = client.plan_many(&[Scene::new(endless(1)).unwrap()], Duration::from_millis(30));
    assert!(matches!(late[0], Err(Error::Call(CallError::TimedOut { .. }))), "{late:?}");
}

#[test]
fn samples_lie_in_shared_memory_and_outlive_client_and_planner() {
    let test = TestDomain::new();
    let planner = test.planner(&[]);
    let client = client(&test);
    // Three parts.
    let reply = client.plan(&sampled(1_200), LONG).unwrap();
    let again = client.plan(&sampled(1_200), LONG).unwrap().to_message();
    assert!(reply.is_shared());
    let blocks = reply.trajectories().unwrap()[0].blocks().len();
    assert!(blocks >= 3, "{blocks} parts");
    drop(client);
    assert_eq!(planner.stop().code, Some(0));
    let kept = std::thread::spawn(move || (reply.to_message().answers, reply)).join().unwrap();
    assert!(kept.0 == again.answers, "what is kept stays as it was");
}

#[test]
fn kept_replies_never_starve_the_client() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = client(&test);
    let mut kept: Vec<_> = (0..30).map(|_| client.plan(&sampled(300), LONG).unwrap()).collect();
    let shared = kept.iter().filter(|reply| reply.is_shared()).count();
    assert_eq!(shared, 7, "one part each, and room for one more");
    assert!(kept.iter().all(|reply| reply.to_message().answers == kept[0].to_message().answers));
    kept.clear();
    assert!(client.plan(&sampled(300), LONG).unwrap().is_shared(), "there is room again");
    // Longer than what can be kept.
    let reply = client.plan(&sampled(10_000), LONG).unwrap();
    assert!(!reply.is_shared());
    assert!(count(&reply) >= 10_000);
}

#[test]
fn a_killed_planner_is_an_error_and_the_next_is_found() {
    let test = TestDomain::new();
    let planner = test.planner(&["--unsupervised"]);
    let client = client(&test);
    assert!(client.plan(&sampled(2), LONG).is_ok());
    let mut pending = client.start(&Scene::new(endless(1)).unwrap()).unwrap();
    assert!(pending.poll().unwrap().is_none());
    planner.kill();
    let lost = pending.wait(LONG).unwrap_err();
    assert!(matches!(lost, Error::Call(CallError::PlannerLost)), "{lost}");
    drop(pending);
    let gone = client.plan(&sampled(2), LONG).unwrap_err();
    assert!(matches!(gone, Error::Connect(ConnectError::NoPlanner { .. })), "{gone}");
    let _planner = test.planner(&[]);
    assert!(client.plan(&sampled(2), LONG).is_ok());
}

#[test]
fn a_planner_that_is_started_again_is_found_by_an_idle_client() {
    let test = TestDomain::new();
    let planner = test.planner(&[]);
    let client = client(&test);
    let kept = client.plan(&sampled(300), LONG).unwrap();
    let before = kept.to_message();
    assert_eq!(planner.stop().code, Some(0));
    let _planner = test.planner(&[]);
    assert!(client.plan(&sampled(300), LONG).unwrap().to_message().answers == before.answers);
    assert!(kept.to_message() == before, "what the one before wrote is still there");
}

#[test]
fn requests_that_are_dropped_or_late_are_cancelled() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = client(&test);
    let hog = Scene::new(endless(1)).unwrap();
    for _ in 0..20 {
        drop(client.start(&hog).unwrap());
    }
    let limit = Duration::from_millis(30);
    let late = client.plan(&hog, limit).unwrap_err();
    assert!(matches!(late, Error::Call(CallError::TimedOut { limit: l, .. }) if l == limit));
    // The planner has time for others, at once.
    assert!(client.plan(&sampled(2), LONG).is_ok());
    let status = || bus::StatusReader::connect(&test.domain()).unwrap().wait(LONG).unwrap();
    wait_for("the planner to be idle", || {
        let status = schemas::status::Status::from_json(&status()).unwrap();
        (status.workers.planning == 0 && status.queue.requests == 0).then_some(())
    });
}

#[test]
fn threads_share_a_client() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = client(&test);
    let expected = client.plan(&sampled(500), LONG).unwrap().to_message().answers;
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..50 {
                    let reply = client.plan(&sampled(500), LONG).unwrap();
                    assert!(reply.to_message().answers == expected);
                }
            });
        }
    });
}

#[test]
fn a_named_free_space_is_sent_to_planners_that_do_not_know_it() {
    let test = TestDomain::new();
    let planner = test.planner(&[]);
    let client = client(&test);
    let scene = Scene::from_json(&scene_text("drive-office-boxes.json")).unwrap();
    let named = scene.with_name().unwrap();
    let expected = client.plan(&scene, LONG).unwrap().to_message().answers;
    for _ in 0..2 {
        assert!(client.plan(&named, LONG).unwrap().to_message().answers == expected);
    }
    assert_eq!(planner.stop().code, Some(0));
    let _planner = test.planner(&[]);
    assert!(client.plan(&named, LONG).unwrap().to_message().answers == expected);
}

#[test]
fn refusals_are_errors_with_their_numbers() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = client(&test);
    let wide = scene_text("disassemble-channels.json").replace("4.5,", "1.5,");
    let refused = Scene::from_json(&wide).map_err(Error::from);
    let refused = refused.and_then(|scene| client.plan(&scene, LONG)).unwrap_err();
    let Error::Refused(refused) = refused else { panic!("{refused}") };
    assert_eq!(refused.code(), ErrorCode::BodyOutsideFreeSpace);
    assert!(refused.refusal().needs.is_some() && refused.refusal().has.is_some());
    assert!(refused.to_string().starts_with("body_outside_free_space: "), "{refused}");
    let unreadable = Scene::from_json("{}").unwrap_err();
    assert_eq!(unreadable.code(), ErrorCode::InvalidScene);
    let office = Scene::from_json(&scene_text(OFFICE)).map_err(Error::from);
    assert!(matches!(office.and_then(|scene| client.plan(&scene, LONG)), Err(Error::Refused(_))));
}

struct Unpark(Thread);

impl Wake for Unpark {
    fn wake(self: Arc<Self>) {
        self.0.unpark();
    }
}

/// The smallest executor.
fn block_on<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    let waker = Waker::from(Arc::new(Unpark(std::thread::current())));
    loop {
        match future.as_mut().poll(&mut Context::from_waker(&waker)) {
            Poll::Ready(output) => return output,
            Poll::Pending => std::thread::park(),
        }
    }
}

#[test]
fn any_executor_waits_for_replies() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = client(&test);
    let expected = client.plan(&sampled(1_000), LONG).unwrap().to_message().answers;
    for _ in 0..200 {
        let reply = block_on(client.plan_async(&sampled(1_000), LONG)).unwrap();
        assert!(reply.to_message().answers == expected);
    }
    let hog = Scene::new(endless(1)).unwrap();
    let limit = Duration::from_millis(30);
    let late = block_on(client.plan_async(&hog, limit)).unwrap_err();
    assert!(matches!(late, Error::Call(CallError::TimedOut { .. })), "{late}");
    drop(client.plan_async(&hog, LONG));
    assert!(block_on(client.plan_async(&sampled(2), LONG)).is_ok());
}
