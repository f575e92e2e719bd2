//! What became of each request, as its client says line by line.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::io::BufRead;
use std::ops::AddAssign;
use std::str::FromStr;

/// What a client says of a request: `sent 7`, and later `refused 7 too_costly`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Line {
    pub(crate) number: u64,
    pub(crate) event: Event,
}

/// What happens to a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Event {
    /// It is about to be sent.
    Sent,
    /// It could not be sent: no planner, or too many requests are open.
    Unsent,
    /// Its reply is whole, and right where that was compared.
    Answered,
    /// It was refused with this code.
    Refused(String),
    /// Its client dropped it.
    Cancelled,
    /// The planner gave its reply up: nobody took it.
    GivenUp,
    /// Its planner died.
    Lost,
    /// What must not be.
    Wrong(String),
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (word, detail) = match &self.event {
            Event::Sent => ("sent", ""),
            Event::Unsent => ("unsent", ""),
            Event::Answered => ("answered", ""),
            Event::Refused(code) => ("refused", code.as_str()),
            Event::Cancelled => ("cancelled", ""),
            Event::GivenUp => ("given_up", ""),
            Event::Lost => ("lost", ""),
            Event::Wrong(what) => ("wrong", what.as_str()),
        };
        write!(f, "{word} {} {}", self.number, detail.replace('\n', " "))
    }
}

impl FromStr for Line {
    type Err = String;

    fn from_str(line: &str) -> Result<Self, String> {
        let mut words = line.splitn(3, ' ');
        let mut next = || words.next().ok_or_else(|| line.to_owned());
        let (word, number, detail) = (next()?, next()?, next()?.to_owned());
        let event = match word {
            "sent" => Event::Sent,
            "unsent" => Event::Unsent,
            "answered" => Event::Answered,
            "refused" => Event::Refused(detail),
            "cancelled" => Event::Cancelled,
            "given_up" => Event::GivenUp,
            "lost" => Event::Lost,
            "wrong" => Event::Wrong(detail),
            _ => return Err(line.to_owned()),
        };
        Ok(Self { number: number.parse().map_err(|_| line.to_owned())?, event })
    }
}

/// Requests by what became of them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Account {
    pub(crate) sent: u64,
    pub(crate) answered: u64,
    pub(crate) refused: BTreeMap<String, u64>,
    pub(crate) cancelled: u64,
    pub(crate) given_up: u64,
    pub(crate) lost: u64,
    /// Open when their client was killed.
    pub(crate) gone: u64,
    /// What must not be, the first few.
    pub(crate) faults: Vec<String>,
}

/// Faults that are kept.
const FAULTS: usize = 20;

impl Account {
    /// Reads all that a client says, until it ends.
    pub(crate) fn read(says: impl BufRead, most_open: usize) -> (Self, Open) {
        let mut account = Self::default();
        let mut open = BTreeSet::new();
        for line in says.lines() {
            // A killed client may leave half a line.
            let Ok(Line { number, event }) = line.unwrap_or_default().parse() else { continue };
            let was_open = match event {
                Event::Sent => open.insert(number),
                _ => open.remove(&number),
            };
            if !was_open {
                account.fault(format!("request {number} is {event:?}, and was not open"));
            }
            match event {
                Event::Sent => account.sent += 1,
                Event::Unsent => account.sent -= 1,
                Event::Answered => account.answered += 1,
                Event::Refused(code) => *account.refused.entry(code).or_default() += 1,
                Event::Cancelled => account.cancelled += 1,
                Event::GivenUp => account.given_up += 1,
                Event::Lost => account.lost += 1,
                Event::Wrong(what) => account.fault(format!("request {number}: {what}")),
            }
            if open.len() > most_open {
                account.fault(format!("{} requests are open", open.len()));
            }
        }
        (account, Open(open.len() as u64))
    }

    pub(crate) fn fault(&mut self, what: String) {
        if self.faults.len() < FAULTS {
            self.faults.push(what);
        }
    }

    /// Requests of a client that has ended, killed or not.
    pub(crate) fn close(&mut self, Open(open): Open, killed: bool) {
        if killed {
            self.gone += open;
        } else if open > 0 {
            self.fault(format!("{open} requests have no end"));
        }
    }

    pub(crate) fn refusals(&self) -> u64 {
        self.refused.values().sum()
    }

    /// Requests that came to an end.
    pub(crate) fn ended(&self) -> u64 {
        let Self { sent: _, answered, refused: _, cancelled, given_up, lost, gone, faults: _ } =
            self;
        answered + self.refusals() + cancelled + given_up + lost + gone
    }
}

/// Requests that a client left open when it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Open(u64);

impl AddAssign for Account {
    fn add_assign(&mut self, other: Self) {
        let Self { sent, answered, refused, cancelled, given_up, lost, gone, faults } = other;
        self.sent += sent;
        self.answered += answered;
        for (code, count) in refused {
            *self.refused.entry(code).or_default() += count;
        }
        self.cancelled += cancelled;
        self.given_up += given_up;
        self.lost += lost;
        self.gone += gone;
        faults.into_iter().for_each(|fault| self.fault(fault));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn read(says: &str) -> (Account, Open) {
        Account::read(says.as_bytes(), 2)
    }

    #[test]
    fn lines_are_read_as_they_are_written() {
        for event in [
            Event::Sent,
            Event::Refused("too_costly".into()),
            Event::Wrong("two words".into()),
            Event::GivenUp,
        ] {
            let line = Line { number: 7, event };
            assert_eq!(line.to_string().parse(), Ok(line));
        }
    }

    #[test]
    fn each_request_has_one_end() {
        let (mut account, open) =
            read("sent 1 \nanswered 1 \nsent 2 \nrefused 2 no_route\nsent 3 \nsent 4 \nca");
        assert_eq!((account.sent, open), (4, Open(2)));
        account.close(open, true);
        assert_eq!((account.ended(), account.gone), (4, 2));
        assert!(account.faults.is_empty());
    }

    #[test]
    fn a_request_without_end_or_with_two_is_a_fault() {
        let (mut account, open) = read("sent 1 \n");
        account.close(open, false);
        assert_eq!(account.faults.len(), 1);
        assert_eq!(read("sent 1 \nanswered 1 \nanswered 1 \n").0.faults.len(), 1);
        assert_eq!(read("sent 1 \nsent 2 \nsent 3 \n").0.faults.len(), 1);
        assert_eq!(read("sent 1 \nwrong 1 other bytes\n").0.faults.len(), 1);
    }
}
