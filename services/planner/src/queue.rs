//! Requests that wait for a worker.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Instant;

use answer::StopFlag;
use schemas::wire::RequestHeader;

/// A request to be planned by a worker.
#[derive(Debug)]
pub(crate) struct Job {
    /// Its number among all requests that this planner has taken.
    pub(crate) ticket: u64,
    pub(crate) header: RequestHeader,
    pub(crate) cells: Vec<u64>,
    pub(crate) stop: Arc<StopFlag>,
    pub(crate) deadline: Option<Instant>,
    /// Parts of the reply that are written already.
    pub(crate) written: usize,
}

impl Job {
    fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice())
    }
}

/// How much may wait.
#[derive(Debug, Clone, Copy)]
pub(crate) struct QueueLimits {
    pub(crate) requests: usize,
    pub(crate) bytes: usize,
}

/// What waits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Waiting {
    pub(crate) requests: usize,
    pub(crate) bytes: usize,
}

/// Requests of several clients, which take turns. Those of one client stay in order.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    /// No list is empty.
    clients: VecDeque<(u64, VecDeque<Job>)>,
    waiting: Waiting,
}

impl Queue {
    pub(crate) fn waiting(&self) -> Waiting {
        self.waiting
    }

    /// Whether one more request fits. One that is larger than all that may wait has to be alone.
    pub(crate) fn has_room(&self, bytes: usize, limits: QueueLimits) -> bool {
        let Waiting { requests, bytes: waiting } = self.waiting;
        requests == 0
            || (requests < limits.requests && waiting.saturating_add(bytes) <= limits.bytes)
    }

    pub(crate) fn push(&mut self, job: Job) {
        self.waiting.requests += 1;
        self.waiting.bytes += job.bytes();
        let client = job.header.client;
        match self.clients.iter_mut().find(|(other, _)| *other == client) {
            Some((_, jobs)) => jobs.push_back(job),
            None => self.clients.push_back((client, VecDeque::from([job]))),
        }
    }

    /// The next request, of the client whose turn it is.
    pub(crate) fn pop(&mut self) -> Option<Job> {
        let (client, mut jobs) = self.clients.pop_front()?;
        let job = jobs.pop_front()?;
        if !jobs.is_empty() {
            self.clients.push_back((client, jobs));
        }
        self.count_out(&job);
        Some(job)
    }

    /// Takes out the request with this ticket, if it still waits.
    pub(crate) fn remove(&mut self, ticket: u64) -> Option<Job> {
        let found = self.clients.iter().enumerate().find_map(|(place, (_, jobs))| {
            Some((place, jobs.iter().position(|job| job.ticket == ticket)?))
        });
        let (place, at) = found?;
        let job = self.clients[place].1.remove(at)?;
        if self.clients[place].1.is_empty() {
            self.clients.remove(place);
        }
        self.count_out(&job);
        Some(job)
    }

    fn count_out(&mut self, job: &Job) {
        self.waiting.requests -= 1;
        self.waiting.bytes -= job.bytes();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn job(ticket: u64, client: u64, cells: usize) -> Job {
        Job {
            ticket,
            header: RequestHeader { client, ..RequestHeader::default() },
            cells: vec![0; cells],
            stop: Arc::default(),
            deadline: None,
            written: 0,
        }
    }

    #[test]
    fn clients_take_turns() {
        let mut queue = Queue::default();
        for (ticket, client) in [(0, 7), (1, 7), (2, 7), (3, 8), (4, 9), (5, 8)] {
            queue.push(job(ticket, client, 0));
        }
        let order: Vec<_> = std::iter::from_fn(|| queue.pop()).map(|job| job.ticket).collect();
        assert_eq!(order, [0, 3, 4, 1, 5, 2]);
    }

    #[test]
    fn bounds_are_kept_but_for_a_request_that_is_alone() {
        let limits = QueueLimits { requests: 2, bytes: 80 };
        let mut queue = Queue::default();
        assert!(queue.has_room(1000, limits));
        queue.push(job(0, 1, 8));
        assert!(queue.has_room(16, limits));
        assert!(!queue.has_room(24, limits));
        queue.push(job(1, 1, 2));
        assert!(!queue.has_room(0, limits));
    }

    #[derive(Debug, Clone)]
    enum Step {
        Push { client: u64, cells: usize },
        Pop,
        Remove(u64),
    }

    fn step() -> impl Strategy<Value = Step> {
        prop_oneof![
            3 => (0..4_u64, 0..5_usize).prop_map(|(client, cells)| Step::Push { client, cells }),
            2 => Just(Step::Pop),
            1 => (0..60_u64).prop_map(Step::Remove),
        ]
    }

    proptest! {
        /// Against a plain list: what waits is what was put in and not taken out, each client's
        /// requests come out in order, and no client is served twice while another, which waited
        /// all the time, is not served at all.
        #[test]
        fn nothing_is_lost_and_nobody_starves(steps in proptest::collection::vec(step(), 0..80)) {
            let mut queue = Queue::default();
            let mut list: Vec<(u64, u64, usize)> = Vec::new();
            let mut passed_over: Vec<(u64, usize)> = Vec::new();
            for (ticket, step) in (0..).zip(steps) {
                match step {
                    Step::Push { client, cells } => {
                        queue.push(job(ticket, client, cells));
                        list.push((ticket, client, cells));
                    }
                    Step::Pop => {
                        let popped = queue.pop().map(|job| (job.ticket, job.header.client));
                        prop_assert_eq!(popped.is_none(), list.is_empty());
                        let Some((ticket, client)) = popped else { continue };
                        let first = list.iter().position(|entry| entry.1 == client).unwrap();
                        prop_assert_eq!(list.remove(first).0, ticket);
                        passed_over.retain(|(other, _)| {
                            *other != client && list.iter().any(|entry| entry.1 == *other)
                        });
                        for (_, other, _) in &list {
                            if *other != client && !passed_over.iter().any(|(known, _)| known == other) {
                                passed_over.push((*other, 0));
                            }
                        }
                        for (_, times) in &mut passed_over {
                            *times += 1;
                            prop_assert!(*times <= 3, "there are four clients");
                        }
                    }
                    Step::Remove(ticket) => {
                        let place = list.iter().position(|entry| entry.0 == ticket);
                        prop_assert_eq!(queue.remove(ticket).is_some(), place.is_some());
                        place.map(|place| list.remove(place));
                        passed_over
                            .retain(|(client, _)| list.iter().any(|entry| entry.1 == *client));
                    }
                }
                let bytes = list.iter().map(|entry| entry.2 * 8).sum();
                prop_assert_eq!(queue.waiting(), Waiting { requests: list.len(), bytes });
            }
        }
    }
}
