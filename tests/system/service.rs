//! Many clients at one planner: who waits for whom, deadlines, cancelling, overload, the end.

use std::thread;
use std::time::{Duration, Instant};

use bus::{CallError, Client, Pending, StatusReader, TapEvent, TapMessage, TapReader, Wait};
use integration_tests::load::{ENDLESS, endless, long, short, slow};
use integration_tests::{LONG, Process, Signal, TestDomain, wait_for};
use schemas::message::{
    Choice, ClearanceWish, ErrorCode, Gap, Refusal, Reply, Request, RequestContent, RequestKey,
    SceneRequest,
};
use schemas::status::Status;

/// A second.
fn second(id: u64) -> SceneRequest {
    SceneRequest { clearance: long(id, 100).clearance, ..slow(id) }
}

fn planner(test: &TestDomain, settings: &str) -> Process {
    // Some clients here take nothing of their replies.
    test.write("planner.toml", &format!("patience = 60\n{settings}"));
    test.planner(&["--config", "planner.toml"])
}

fn client(test: &TestDomain) -> Client {
    Client::connect(&test.domain(), Wait::Hybrid).unwrap()
}

/// What a scene is answered without a bus.
fn expected(key: RequestKey, scene: &SceneRequest) -> Reply {
    let content = RequestContent::Scene(scene.clone());
    answer::reply_to(&Request { key, sent_ns: 0, content }, &answer::Caps::default())
}

/// Waits until the first part of a reply is there: the request is being planned.
fn wait_until_begun(pending: &mut Pending) {
    let part = pending.wait_part(Instant::now() + LONG).unwrap();
    assert!(part.content.is_ok(), "{:?}", part.content);
}

fn code(reply: &Reply) -> Option<ErrorCode> {
    reply.answers.as_ref().err().map(|refusal| refusal.code)
}

#[test]
fn long_requests_do_not_hold_up_short_ones() {
    for workers in [1, 2] {
        let test = TestDomain::new();
        let _planner = planner(&test, &format!("workers = {workers}"));
        let clients = [(); 3].map(|()| client(&test));
        let mut hogs: Vec<_> =
            clients.iter().map(|client| client.send(&endless(1)).unwrap()).collect();
        hogs.iter_mut().for_each(wait_until_begun);
        let quick = client(&test);
        let mut times: Vec<_> = (0..200)
            .map(|id| {
                let begun = Instant::now();
                let reply = quick.call(&short(id), LONG).unwrap();
                assert!(reply == expected(reply.key, &short(id)));
                begun.elapsed()
            })
            .collect();
        times.sort_unstable();
        println!("{workers} workers: median {:?}, most {:?}", times[100], times[199]);
        // Neither short ones nor those of some milliseconds wait for the end of long ones.
        let middling = long(7, 3);
        let reply = quick.call(&middling, LONG).unwrap();
        assert!(reply == expected(reply.key, &middling));
    }
}

/// Replies are the same bits whoever plans them.
#[test]
fn replies_do_not_depend_on_the_number_of_workers() {
    let scenes: Vec<_> = (0..6).map(|id| long(id, 2 + id as u32)).collect();
    let replies: Vec<Vec<Reply>> = [1, 4]
        .map(|workers| {
            let test = TestDomain::new();
            let _planner = planner(&test, &format!("workers = {workers}"));
            thread::scope(|scope| {
                let calls: Vec<_> = scenes
                    .iter()
                    .map(|scene| scope.spawn(|| client(&test).call(scene, LONG).unwrap()))
                    .collect();
                calls.into_iter().map(|call| call.join().unwrap()).collect()
            })
        })
        .into();
    for (replies, scene) in replies.iter().flatten().zip(scenes.iter().cycle()) {
        assert!(*replies == expected(replies.key, scene));
    }
}

#[test]
fn a_deadline_holds_while_planning_and_in_the_queue() {
    let test = TestDomain::new();
    let _planner = planner(&test, "workers = 1");
    let late = client(&test);
    let mut late_one = endless(1);
    late_one.deadline = Some(0.1);
    let begun = Instant::now();
    let reply = late.call(&late_one, LONG).unwrap();
    // Answers that were found stand, the others are refused; all, if there are none.
    let refusal = match reply.answers {
        Ok(answers) => {
            assert_eq!(answers.len(), ENDLESS as usize);
            answers.last().unwrap().clone().unwrap_err()
        }
        Err(refusal) => refusal,
    };
    assert_eq!(refusal.code, ErrorCode::DeadlineExceeded);
    assert!(begun.elapsed() >= Duration::from_millis(100));

    // All that can be in hand is, so the next waits.
    let clients = [(); 4].map(|()| client(&test));
    let mut hogs: Vec<_> = clients.iter().map(|client| client.send(&endless(1)).unwrap()).collect();
    hogs.iter_mut().for_each(wait_until_begun);
    let mut queued = slow(2);
    queued.deadline = Some(0.05);
    let begun = Instant::now();
    let reply = late.call(&queued, LONG).unwrap();
    let took = begun.elapsed();
    assert_eq!(code(&reply), Some(ErrorCode::DeadlineExceeded), "{reply:?}");
    println!("refused {took:?} after it was sent, due after 50 ms");
    assert!(took >= Duration::from_millis(50));

    // One whose first answers were given at once gets the rest refused.
    let gap = |index: u32| Choice::Gap(Gap::Uniform(0.01 + 1e-5 * f64::from(index)));
    let clearance = ClearanceWish::Each((0..ENDLESS).map(gap).collect());
    let many = SceneRequest { clearance, ..short(3) };
    let expected = expected(RequestKey::default(), &many).answers.unwrap();
    let begun = SceneRequest { deadline: Some(0.05), ..many };
    let answers = late.call(&begun, LONG).unwrap().answers.unwrap();
    let found = answers.iter().take_while(|answer| answer.is_ok()).count();
    println!("{found} answers at once");
    assert!(0 < found && found < answers.len() && answers.len() == expected.len());
    assert!(answers[..found] == expected[..found]);
    let late = |refusal: &Refusal| refusal.code == ErrorCode::DeadlineExceeded;
    assert!(answers[found..].iter().all(|answer| answer.as_ref().is_err_and(late)));
}

/// A request whose client has dropped it, left or died makes room for the next.
#[test]
fn what_nobody_waits_for_is_cancelled() {
    let test = TestDomain::new();
    let _planner = planner(&test, "workers = 1\nqueue = 1");
    let clients = [(); 4].map(|()| client(&test));
    let fill = || {
        let mut hogs: Vec<_> =
            clients.iter().map(|client| client.send(&endless(1)).unwrap()).collect();
        hogs.iter_mut().for_each(wait_until_begun);
        hogs
    };
    let hogs = fill();
    let waiting = client(&test);
    let in_line = waiting.send(&slow(2)).unwrap();
    let another = client(&test);
    // It waits in the queue.
    thread::sleep(Duration::from_millis(200));
    let overloaded = another.call(&slow(3), LONG).unwrap();
    assert_eq!(code(&overloaded), Some(ErrorCode::Overloaded));
    let refusal = overloaded.answers.unwrap_err();
    assert!(refusal.message.contains("`queue`"), "{}", refusal.message);
    assert_eq!((refusal.has, refusal.most), (Some(1.0), Some(1.0)));

    // One that is dropped in the queue leaves its place to another.
    drop(in_line);
    let dropped = Instant::now();
    let mut in_line = wait_for("room", || {
        let mut pending = another.send(&slow(4)).unwrap();
        // Refused at once, or it waits.
        let refused = pending.wait(Instant::now() + Duration::from_millis(50));
        refused.is_err().then_some(pending)
    });
    println!("room at most {:?} after a request was dropped", dropped.elapsed());
    drop(hogs);
    let begun = Instant::now();
    let reply = in_line.wait(Instant::now() + LONG).unwrap();
    assert!(reply == expected(reply.key, &slow(4)));
    println!("answered {:?} after the others were dropped", begun.elapsed());
}

#[test]
fn a_client_that_dies_makes_room() {
    let test = TestDomain::new();
    let _planner = planner(&test, "workers = 1\nqueue = 1");
    let scene = test.write("long.json", &schemas::json::scene_to_json(&endless(1)));
    let scene = scene.to_str().unwrap().to_owned();
    let name = test.domain().to_string();
    let arguments = ["--domain", name.as_str(), "--timeout", "60s", &scene];
    let dying: Vec<_> = (0..4).map(|_| test.start("plan", &arguments, None)).collect();
    let status = StatusReader::connect(&test.domain()).unwrap();
    wait_for("four requests being planned", || {
        let status = Status::from_json(&status.receive()?).unwrap();
        (status.workers.planning == 4).then_some(())
    });
    let waiting = client(&test);
    let mut in_line = waiting.send(&slow(3)).unwrap();
    let early = in_line.wait(Instant::now() + Duration::from_millis(200));
    assert!(matches!(early, Err(CallError::TimedOut { .. })), "{early:?}");
    dying.into_iter().for_each(|process| drop(process.kill()));
    let begun = Instant::now();
    let reply = in_line.wait(Instant::now() + LONG).unwrap();
    println!("answered {:?} after they were killed", begun.elapsed());
    assert!(reply == expected(reply.key, &slow(3)));
}

/// What is recorded is what was planned from, though the client changes it meanwhile; here, that
/// the tap has every request and reply of many clients exactly once.
#[test]
fn the_tap_has_what_was_answered() {
    let test = TestDomain::new();
    let _planner = planner(&test, "workers = 2\ntap_buffer = 4096");
    let mut tap = TapReader::connect(&test.domain()).unwrap();
    let mut replies: Vec<Reply> = thread::scope(|scope| {
        let calls: Vec<_> = (0..6)
            .map(|id| {
                let test = &test;
                scope.spawn(move || {
                    let client = client(test);
                    let scenes = [short(id), long(id, 1 + id as u32), short(id + 10)];
                    scenes.map(|scene| client.call(&scene, LONG).unwrap())
                })
            })
            .collect();
        calls.into_iter().flat_map(|call| call.join().unwrap()).collect()
    });
    let mut open = std::collections::BTreeMap::new();
    let mut seen = Vec::new();
    while seen.len() < replies.len() {
        match wait_for("the tap", || tap.receive()) {
            TapEvent::Message(TapMessage::Request(request)) => {
                let key = (request.key.client, request.key.sequence);
                let before = open.insert(key, schemas::message::ReplyAssembler::default());
                assert!(before.is_none(), "twice");
            }
            TapEvent::Message(TapMessage::Reply(part)) => {
                let key = (part.key.client, part.key.sequence);
                let reply = open.get_mut(&key).expect("the request comes first").push(part);
                seen.extend(reply.expect("parts in order, each once"));
            }
            other => panic!("{other:?}"),
        }
    }
    let by_key = |reply: &Reply| (reply.key.client, reply.key.sequence);
    seen.sort_by_key(by_key);
    replies.sort_by_key(by_key);
    assert!(seen == replies);
}

#[test]
fn a_planner_that_is_asked_to_end_answers_what_it_has() {
    let test = TestDomain::new();
    let planner = planner(&test, "grace = 30");
    let asking = client(&test);
    let mut pending = asking.send(&second(1)).unwrap();
    wait_until_begun(&mut pending);
    drop(pending);
    let mut pending = asking.send(&second(2)).unwrap();
    thread::sleep(Duration::from_millis(20));
    planner.signal(Signal::TERM);
    thread::sleep(Duration::from_millis(20));
    let other = Client::connect(&test.domain(), Wait::Hybrid);
    if let Ok(other) = &other {
        match other.call(&short(3), LONG) {
            Ok(reply) => assert_eq!(code(&reply), Some(ErrorCode::Overloaded)),
            Err(error) => assert!(matches!(error, CallError::PlannerLost), "{error}"),
        }
    }
    let reply = pending.wait(Instant::now() + LONG).unwrap();
    assert!(reply == expected(reply.key, &second(2)));
    drop(pending);
    drop((asking, other));
    let ended = planner.wait();
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(test.left().is_empty(), "{:?}", test.left());
}

#[test]
fn a_planner_ends_when_its_grace_is_over() {
    let test = TestDomain::new();
    let planner = planner(&test, "grace = 0.2");
    let clients = [(); 6].map(|()| client(&test));
    let mut hogs: Vec<_> = clients.iter().map(|client| client.send(&endless(1)).unwrap()).collect();
    wait_until_begun(&mut hogs[0]);
    planner.signal(Signal::TERM);
    let begun = Instant::now();
    let ends: Vec<_> =
        hogs.iter_mut().skip(1).map(|pending| pending.wait(Instant::now() + LONG)).collect();
    for end in ends {
        match end {
            // Some answers were found, or none.
            Ok(Reply { answers: Ok(answers), .. }) => {
                assert_eq!(
                    answers.last().unwrap().as_ref().unwrap_err().code,
                    ErrorCode::Overloaded
                );
            }
            Ok(Reply { answers: Err(refusal), .. }) => {
                assert_eq!(refusal.code, ErrorCode::Overloaded);
            }
            Err(error) => assert!(matches!(error, CallError::PlannerLost), "{error}"),
        }
    }
    drop(hogs);
    drop(clients);
    let ended = planner.wait();
    println!("ended {:?} after the signal", begun.elapsed());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(test.left().is_empty(), "{:?}", test.left());
}

#[test]
fn a_planner_says_how_it_is() {
    let test = TestDomain::new();
    let mut planner = test.planner(&["--metrics", "0"]);
    planner.wait_until_it_says("metrics at /metrics");
    let name = test.domain().name().to_owned();
    let ping = test.run("plan", &["--domain", &name, "--ping", "--format", "json"]);
    assert_eq!(ping.code, Some(0), "{ping:?}");
    assert!(ping.stdout.starts_with("{\"pings\":10,\"least\":"), "{ping:?}");
    let reply = client(&test).call(&SceneRequest { goal: None, ..slow(1) }, LONG).unwrap();
    assert_eq!(code(&reply), Some(ErrorCode::InvalidScene));
    let counted = wait_for("the counts", || {
        let ended = test.run("plan", &["--domain", &name, "--status", "--format", "json"]);
        let status = Status::from_json(&ended.stdout).unwrap();
        (status.answered == 11).then_some(status)
    });
    assert_eq!((counted.requests, counted.undelivered), (11, 0));
    assert_eq!(counted.refused, [("invalid_scene".to_owned(), 1)].into());
    assert_eq!(counted.latency.count, 11);
    let text = test.run("plan", &["--domain", &name, "--status"]).stdout;
    assert!(text.contains("11 taken, 11 answered") && text.contains("1 invalid_scene"), "{text}");
    let csv = test.run("plan", &["--domain", &name, "--status", "--format", "csv"]);
    assert_eq!(csv.code, Some(1), "{csv:?}");
}
