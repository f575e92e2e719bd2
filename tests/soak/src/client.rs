//! A client: one process that asks, changes its mind, reads slowly and writes nonsense, until it
//! is killed or asked to end.

use std::error::Error;
use std::io::Write;
use std::time::{Duration, Instant};

use answer::Caps;
use bus::{CallError, Client, ConnectError, Domain, Pending, Wait};
use fastrand::Rng;
use integration_tests::load::{long, short};
use integration_tests::raw::{ELEMENTS, End, Memory, RawClient};
use schemas::message::{
    Answer, Body, ErrorCode, Refusal, Reply, Request, RequestContent, RequestKey, Sampling,
    SceneRequest,
};

use crate::account::{Event, Line};

type Answers = Result<Vec<Answer>, Refusal>;

/// Nothing takes so long unless it hangs.
const LIMIT: Duration = Duration::from_secs(60);

/// Nonsense written by one peer before it leaves.
const PAYLOADS: u32 = 20;

/// The scenes it asks for, and what is right.
struct Scenes {
    quick: (SceneRequest, Answers),
    longer: (SceneRequest, Answers),
    /// Some seconds.
    slow: SceneRequest,
    /// A reply of megabytes.
    large: SceneRequest,
    nonsense: Memory,
}

/// One that is connected, and says what it does.
struct Asking<'a> {
    client: Client,
    scenes: &'a Scenes,
    domain: &'a Domain,
    rng: &'a mut Rng,
    sent: &'a mut u64,
}

pub(crate) fn run(domain: &Domain, seed: u64) -> Result<(), Box<dyn Error>> {
    let scenes = Scenes::new();
    let (mut rng, mut sent) = (Rng::with_seed(seed), 0);
    while !bus::terminated() {
        let how = *rng.choice(&[Wait::Event, Wait::Hybrid]).expect("two");
        let client = match Client::connect_within(domain, how, LIMIT) {
            Ok(client) => client,
            // Those that were killed keep their places for a moment, and planners start anew.
            Err(ConnectError::Full { .. } | ConnectError::Service { .. }) => {
                std::thread::sleep(Duration::from_millis(20));
                continue;
            }
            Err(_) if bus::terminated() => return Ok(()),
            Err(error) => return Err(error.into()),
        };
        let (rng, sent) = (&mut rng, &mut sent);
        let mut asking = Asking { client, scenes: &scenes, domain, rng, sent };
        for _ in 0..asking.rng.u32(1..300) {
            if bus::terminated() {
                return Ok(());
            }
            asking.act()?;
            std::thread::sleep(Duration::from_micros(asking.rng.u64(..20_000)));
        }
    }
    Ok(())
}

impl Scenes {
    fn new() -> Self {
        let right = |scene: SceneRequest| {
            let content = RequestContent::Scene(scene.clone());
            let request = Request { key: RequestKey::default(), sent_ns: 0, content };
            (scene, answer::reply_to(&request, &Caps::default()).answers)
        };
        let sampling = Some(Sampling::Count(60_000));
        Self {
            quick: right(short(1)),
            longer: right(long(2, 2)),
            slow: long(3, 5_000),
            large: SceneRequest { sampling, ..short(4) },
            nonsense: Memory::of(&long(5, 1)),
        }
    }
}

impl Asking<'_> {
    fn act(&mut self) -> Result<(), Box<dyn Error>> {
        match self.rng.u8(..100) {
            0..75 => self.ask(&self.scenes.quick),
            75..80 => self.ask(&self.scenes.longer),
            80..85 => self.ask_in_time(),
            85..91 => self.drop_early(),
            91..94 => self.read_slowly(),
            94..98 => self.ask_for_the_impossible(),
            _ => self.write_nonsense(),
        }
    }

    /// Sends a request and lets `then` see to its reply.
    fn send(
        &mut self,
        scene: &SceneRequest,
        then: impl FnOnce(&mut Pending, &mut Rng) -> Event,
    ) -> Result<(), Box<dyn Error>> {
        *self.sent += 1;
        let number = *self.sent;
        say(number, Event::Sent)?;
        let event = match self.client.send(scene) {
            Ok(mut pending) => then(&mut pending, self.rng),
            // Those that were dropped count until the planner has seen it.
            Err(CallError::TooManyRequests { .. } | CallError::Send(_)) => Event::Unsent,
            Err(error) => Event::Wrong(error.to_string()),
        };
        say(number, event)?;
        Ok(())
    }

    fn ask(&mut self, (scene, right): &(SceneRequest, Answers)) -> Result<(), Box<dyn Error>> {
        self.send(scene, |pending, _| {
            let reply = pending.wait(Instant::now() + LIMIT);
            outcome(reply, |answers| answers == right)
        })
    }

    fn ask_in_time(&mut self) -> Result<(), Box<dyn Error>> {
        let deadline = Some(0.03 * self.rng.f64());
        let scene = SceneRequest { deadline, ..self.scenes.slow.clone() };
        self.send(&scene, |pending, _| {
            let late = |answers: &Answers| {
                let refusals = match answers {
                    Ok(answers) => {
                        answers.iter().filter_map(|answer| answer.as_ref().err()).collect()
                    }
                    Err(refusal) => vec![refusal],
                };
                refusals.iter().all(|refusal| refusal.code == ErrorCode::DeadlineExceeded)
            };
            outcome(pending.wait(Instant::now() + LIMIT), late)
        })
    }

    fn drop_early(&mut self) -> Result<(), Box<dyn Error>> {
        let scenes = self.scenes;
        self.send(&scenes.slow, |_, rng| {
            std::thread::sleep(Duration::from_micros(rng.u64(..30_000)));
            Event::Cancelled
        })
    }

    fn read_slowly(&mut self) -> Result<(), Box<dyn Error>> {
        let scenes = self.scenes;
        self.send(&scenes.large, |pending, rng| {
            std::thread::sleep(Duration::from_millis(rng.u64(..300)));
            outcome(pending.wait(Instant::now() + LIMIT), |answers| answers.is_ok())
        })
    }

    fn ask_for_the_impossible(&mut self) -> Result<(), Box<dyn Error>> {
        let scene = SceneRequest { body: Body::Polygon(Vec::new()), ..short(6) };
        self.send(&scene, |pending, _| {
            outcome(pending.wait(Instant::now() + LIMIT), |answers| answers.is_err())
        })
    }

    fn write_nonsense(&mut self) -> Result<(), Box<dyn Error>> {
        let Some(peer) = RawClient::connect(self.domain) else { return Ok(()) };
        for _ in 0..PAYLOADS {
            let mut memory = self.scenes.nonsense.clone();
            let changes = self.rng.bool();
            if !changes {
                memory.spoil(self.rng);
            }
            // What nonsense asks for may make sense.
            memory.header.deadline = 0.01;
            memory.header.given |= schemas::wire::given::DEADLINE;
            let (lies, elements) = (self.rng.u8(..20) == 0, self.rng.u64(..) >> self.rng.u8(..64));
            *self.sent += 1;
            let number = *self.sent;
            say(number, Event::Sent)?;
            let pending = peer.send(&memory, |own| {
                if lies {
                    own[ELEMENTS] = elements;
                }
            });
            let event = match pending {
                None => Event::Unsent,
                Some(pending) => {
                    let end = pending.end(LIMIT, || {
                        if changes {
                            pending.scribble(self.rng);
                        }
                    });
                    match end {
                        End::Whole => Event::Answered,
                        End::Dropped => Event::Lost,
                        End::Open => Event::Wrong("no reply to nonsense".to_owned()),
                    }
                }
            };
            say(number, event)?;
        }
        Ok(())
    }
}

/// What became of a request that was waited for.
fn outcome(reply: Result<Reply, CallError>, is_right: impl FnOnce(&Answers) -> bool) -> Event {
    match reply {
        Ok(Reply { answers: Err(refusal), .. }) if refusal.code == ErrorCode::Overloaded => {
            Event::Refused(refusal.code.name().to_owned())
        }
        Ok(Reply { answers, .. }) if !is_right(&answers) => {
            Event::Wrong(format!("{answers:?}").chars().take(300).collect())
        }
        Ok(Reply { answers: Ok(_), .. }) => Event::Answered,
        Ok(Reply { answers: Err(refusal), .. }) => Event::Refused(refusal.code.name().to_owned()),
        Err(CallError::PlannerLost) => Event::Lost,
        Err(CallError::GivenUp) => Event::GivenUp,
        Err(CallError::Interrupted) => Event::Cancelled,
        Err(error) => Event::Wrong(error.to_string()),
    }
}

fn say(number: u64, event: Event) -> std::io::Result<()> {
    // In one piece, so that who is killed leaves whole lines.
    let line = format!("{}\n", Line { number, event });
    std::io::stdout().write_all(line.as_bytes())
}
