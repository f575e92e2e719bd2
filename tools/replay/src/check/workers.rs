//! Plans recorded requests again on all cores.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, sync_channel};
use std::sync::{Mutex, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use answer::{Answerer, Caps};
use bus::Client;
use comparison::check::Case;
use comparison::exchanges::Exchange;
use comparison::tolerance::Tolerance;
use schemas::message::{ErrorCode, Refusal, Reply, Request, RequestContent};

use crate::arguments::Bus;
use crate::html::{self, Details};
use crate::running;

/// An exchange to plan again.
pub(super) struct Task {
    /// The recording.
    pub(super) file: usize,
    /// Counts the recording's exchanges.
    pub(super) order: usize,
    pub(super) exchange: Exchange,
    /// What to plan instead of what was asked.
    pub(super) changed: Option<Request>,
    pub(super) tolerance: Tolerance,
    /// What it may cost.
    pub(super) caps: Caps,
}

/// What became of it.
pub(super) struct Done {
    pub(super) file: usize,
    pub(super) order: usize,
    /// How the replies compare, or why there is none to compare.
    pub(super) case: Result<(Case, Details), NoReply>,
}

/// A request without a reply to compare.
pub(super) struct NoReply {
    pub(super) index: u64,
    pub(super) said: String,
}

/// How requests are planned again.
pub(super) struct Settings<'a> {
    /// The running planner that is asked; without, requests are planned in this process.
    pub(super) bus: Option<&'a Bus>,
    pub(super) jobs: usize,
    /// Whether answers that are not equal are drawn.
    pub(super) draw: bool,
}

/// Runs `read`, which hands over exchanges, with workers that plan them; returns what became of
/// them, in the order of their recordings.
///
/// Memory: two exchanges for each worker, and what became of all.
pub(super) fn run(settings: &Settings, read: impl FnOnce(&mut dyn FnMut(Task))) -> Vec<Done> {
    // Waits for a worker when there is work enough: a large recording is not taken in whole.
    let (give, take) = sync_channel::<Task>(settings.jobs);
    let (report, reports) = mpsc::channel();
    let take = Mutex::new(take);
    thread::scope(|scope| {
        for _ in 0..settings.jobs {
            let (take, report) = (&take, report.clone());
            scope.spawn(move || work(settings, take, &report));
        }
        drop(report);
        read(&mut |task| give.send(task).expect("workers outlive the work"));
        drop(give);
        let mut done: Vec<Done> = reports.iter().collect();
        done.sort_by_key(|done| (done.file, done.order));
        done
    })
}

fn work(settings: &Settings, take: &Mutex<Receiver<Task>>, report: &Sender<Done>) {
    let mut planner = Planner::new(settings);
    loop {
        let next = take.lock().expect("nobody panics with it").recv();
        let Ok(Task { file, order, exchange, changed, tolerance, caps }) = next else { return };
        let request = changed.as_ref().unwrap_or(&exchange.request);
        let began = Instant::now();
        let planned = planner.reply(file, &caps, request);
        let case = match planned {
            Ok(planned) => {
                let case = Case::new(&exchange, (&planned, began.elapsed()), &tolerance);
                let replies = [&exchange.reply, &planned];
                let details = match settings.draw {
                    true => html::details(&request.content, replies, &case.comparison),
                    false => Details::new(),
                };
                Ok((case, details))
            }
            Err(said) => Err(NoReply { index: exchange.index, said }),
        };
        report.send(Done { file, order, case }).expect("somebody waits for it");
    }
}

/// What answers.
enum Planner {
    /// This process, for the recording with this number.
    Here(Option<(usize, Box<Answerer>)>),
    Running(Result<Box<Client>, String>, Duration),
}

impl Planner {
    fn new(settings: &Settings) -> Self {
        match settings.bus {
            None => Self::Here(None),
            Some(bus) => {
                let client = running::connect(bus).map(Box::new);
                Self::Running(client.map_err(|error| error.to_string()), bus.timeout)
            }
        }
    }

    fn reply(&mut self, file: usize, caps: &Caps, request: &Request) -> Result<Reply, String> {
        match self {
            Self::Here(answerer) => {
                let known = answerer.take().filter(|(its, _)| *its == file);
                let new = || (file, Box::new(Answerer::new(caps)));
                let (_, answerer) = answerer.insert(known.unwrap_or_else(new));
                Ok(plan(caps, answerer, request))
            }
            Self::Running(Ok(client), limit) => running::reply_to(client, request, *limit),
            Self::Running(Err(said), _) => Err(said.clone()),
        }
    }
}

/// Plans a request as the planner would. A panic is a reply, as it is in the planner.
fn plan(caps: &Caps, answerer: &mut Answerer, request: &Request) -> Reply {
    let answered = catch_unwind(AssertUnwindSafe(|| match names_its_free_space(request) {
        // Which worker has seen which name is chance: nobody may remember one.
        true => answer::reply_to(request, caps),
        false => answerer.reply_to(request),
    }));
    answered.unwrap_or_else(|_| {
        *answerer = Answerer::new(caps);
        let id = match &request.content {
            RequestContent::Scene(scene) => scene.id,
            RequestContent::Unreadable { .. } => None,
        };
        let refusal = Refusal::new(ErrorCode::Internal, "planning failed; this is a bug");
        Reply { key: request.key, id, answers: Err(refusal) }
    })
}

fn names_its_free_space(request: &Request) -> bool {
    match &request.content {
        RequestContent::Scene(scene) => scene.free_space.named.is_some(),
        // It may.
        RequestContent::Unreadable { .. } => true,
    }
}
