//! Whole replies from their parts.

use thiserror::Error;

use super::{Answer, Reply, ReplyPart, RequestKey, Sample, Trajectory};
use super::{AxisBox, Leg};

/// Puts one reply together from its parts, which must arrive in order.
///
/// Memory is allocated for what has arrived, not for what a part announces, and only up to
/// the limit of [`ReplyAssembler::with_most_bytes`]. A part that is refused leaves the
/// assembler as it was.
#[derive(Debug)]
pub struct ReplyAssembler {
    most_bytes: usize,
    bytes: usize,
    parts: u32,
    complete: bool,
    head: Option<Head>,
    answers: Vec<Answer>,
}

/// What all parts of a reply share.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Head {
    key: RequestKey,
    id: Option<u64>,
    answers: u32,
}

/// Why a part does not continue a reply.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum AssembleError {
    /// It belongs to another request.
    #[error("expected a part of the reply to {expected}, not of the reply to {found}")]
    Key {
        /// The request of the parts before.
        expected: RequestKey,
        /// The part's request.
        found: RequestKey,
    },
    /// It is not the next part.
    #[error("part {expected} of the reply is missing: part {found} arrived instead")]
    Part {
        /// The part that comes next.
        expected: u32,
        /// The part that arrived.
        found: u32,
    },
    /// The last part has already arrived.
    #[error("part {found} arrived after part {last}, the last of the reply")]
    AfterLast {
        /// The last part.
        last: u32,
        /// The part that arrived.
        found: u32,
    },
    /// It belongs to an answer that is neither the current one nor the next, or that
    /// the reply does not have.
    #[error("part {part} belongs to answer {found}, expected {expected} of {answers}")]
    Answer {
        /// The part that arrived.
        part: u32,
        /// The answer that comes next.
        expected: u32,
        /// The part's answer.
        found: u32,
        /// How many answers the reply has.
        answers: u32,
    },
    /// The reply ends too early.
    #[error("part {part} is the last, but only {found} of {expected} answers have arrived")]
    MissingAnswers {
        /// The part that arrived.
        part: u32,
        /// How many answers the reply has.
        expected: u32,
        /// How many have arrived.
        found: u32,
    },
    /// It contradicts the parts before in a field that they share.
    #[error("part {part}: {field} is {found}, expected {expected}")]
    Disagrees {
        /// The part that arrived.
        part: u32,
        /// The field's name.
        field: &'static str,
        /// The value expected.
        expected: String,
        /// The value in this part.
        found: String,
    },
    /// The reply takes more memory than allowed.
    #[error("the reply takes {needs} bytes with part {part}, but at most {most} are allowed")]
    TooLarge {
        /// The part that arrived.
        part: u32,
        /// Bytes with this part.
        needs: usize,
        /// Bytes allowed.
        most: usize,
    },
}

impl Default for ReplyAssembler {
    fn default() -> Self {
        Self::with_most_bytes(Self::MOST_BYTES)
    }
}

impl ReplyAssembler {
    /// The default limit: 4 GiB, some fifty trajectories with a million samples each.
    pub const MOST_BYTES: usize = 4 << 30;

    /// An assembler for one reply of at most `most_bytes` in memory.
    pub fn with_most_bytes(most_bytes: usize) -> Self {
        Self { most_bytes, bytes: 0, parts: 0, complete: false, head: None, answers: Vec::new() }
    }

    /// How many parts have arrived, which is the number of the next part.
    pub fn parts(&self) -> u32 {
        self.parts
    }

    /// Adds the next part; returns the reply after the last.
    pub fn push(&mut self, part: ReplyPart) -> Result<Option<Reply>, AssembleError> {
        let number = part.part;
        let head = Head { key: part.key, id: part.id, answers: part.answers };
        let disagrees = |field, expected, found| {
            Err(AssembleError::Disagrees { part: number, field, expected, found })
        };
        if let Some(first) = self.head {
            if head.key != first.key {
                return Err(AssembleError::Key { expected: first.key, found: head.key });
            }
            if self.complete {
                return Err(AssembleError::AfterLast { last: self.parts - 1, found: number });
            }
        }
        if number != self.parts {
            return Err(AssembleError::Part { expected: self.parts, found: number });
        }
        if let Some(first) = self.head {
            if head.id != first.id {
                return disagrees("id", or_none(first.id), or_none(head.id));
            }
            if head.answers != first.answers {
                let (expected, found) = (first.answers.to_string(), head.answers.to_string());
                return disagrees("answers", expected, found);
            }
        }

        let needs = self.bytes.saturating_add(size(&part.content));
        if needs > self.most_bytes {
            return Err(AssembleError::TooLarge { part: number, needs, most: self.most_bytes });
        }

        if head.answers == 0 {
            return self.refuse(head, part);
        }
        let begun = self.answers.len() as u32;
        let continues = begun > 0 && part.answer == begun - 1;
        if part.answer >= head.answers || !(continues || part.answer == begun) {
            let (expected, found, answers) = (begun, part.answer, head.answers);
            return Err(AssembleError::Answer { part: number, expected, found, answers });
        }
        let come = part.answer + 1;
        if part.last && come != head.answers {
            let expected = head.answers;
            return Err(AssembleError::MissingAnswers { part: number, expected, found: come });
        }
        if continues {
            let last = self.answers.last_mut().expect("an answer was begun");
            match (last, part.content) {
                (Ok(trajectory), Ok(more)) => {
                    if let Some((field, expected, found)) = disagreement(trajectory, &more) {
                        return disagrees(field, expected, found);
                    }
                    trajectory.gaps.extend(more.gaps);
                    trajectory.route.extend(more.route);
                    trajectory.channels.extend(more.channels);
                    trajectory.legs.extend(more.legs);
                    trajectory.samples.extend(more.samples);
                }
                (last, content) => {
                    return disagrees("content", kind(last).into(), kind(&content).into());
                }
            }
        } else {
            self.answers.push(part.content);
        }
        self.advance(head, needs, part.last);
        Ok(part.last.then(|| Reply {
            key: head.key,
            id: head.id,
            answers: Ok(std::mem::take(&mut self.answers)),
        }))
    }

    /// The only part of a reply that refuses the whole request.
    fn refuse(&mut self, head: Head, part: ReplyPart) -> Result<Option<Reply>, AssembleError> {
        let disagrees = |field, expected: &str, found: String| {
            let (part, expected) = (part.part, expected.to_owned());
            Err(AssembleError::Disagrees { part, field, expected, found })
        };
        if part.answer != 0 {
            let (expected, found, answers) = (0, part.answer, 0);
            return Err(AssembleError::Answer { part: part.part, expected, found, answers });
        }
        if !part.last {
            return disagrees("last", "true", part.last.to_string());
        }
        match part.content {
            Ok(_) => disagrees("content", "a refusal", kind(&part.content).into()),
            Err(refusal) => {
                self.advance(head, size_of::<Answer>(), true);
                Ok(Some(Reply { key: head.key, id: head.id, answers: Err(refusal) }))
            }
        }
    }

    fn advance(&mut self, head: Head, bytes: usize, complete: bool) {
        self.head = Some(head);
        self.bytes = bytes;
        self.parts += 1;
        self.complete = complete;
    }
}

fn kind(answer: &Answer) -> &'static str {
    match answer {
        Ok(_) => "a trajectory",
        Err(_) => "a refusal",
    }
}

/// Bytes that an answer takes in memory.
fn size(answer: &Answer) -> usize {
    let lists = match answer {
        Ok(trajectory) => {
            size_of_val::<[f64]>(&trajectory.gaps)
                + size_of_val::<[u64]>(&trajectory.route)
                + size_of_val::<[AxisBox]>(&trajectory.channels)
                + size_of_val::<[Leg]>(&trajectory.legs)
                + size_of_val::<[Sample]>(&trajectory.samples)
        }
        Err(refusal) => {
            refusal.message.len()
                + refusal.field.as_deref().map_or(0, str::len)
                + refusal.setting.as_deref().map_or(0, str::len)
        }
    };
    size_of::<Answer>() + lists
}

fn or_none(value: Option<impl std::fmt::Display>) -> String {
    value.map_or_else(|| "none".to_owned(), |value| value.to_string())
}

/// The first number that two parts of one trajectory do not share bit for bit.
fn disagreement(first: &Trajectory, more: &Trajectory) -> Option<(&'static str, String, String)> {
    let integer = |field, first: u32, more: u32| {
        (first != more).then(|| (field, first.to_string(), more.to_string()))
    };
    let number = |field, first: f64, more: f64| {
        (first.to_bits() != more.to_bits()).then(|| (field, first.to_string(), more.to_string()))
    };
    let optional = |field, first: Option<f64>, more: Option<f64>| {
        let differ = first.map(f64::to_bits) != more.map(f64::to_bits);
        differ.then(|| (field, or_none(first), or_none(more)))
    };
    let wall = |vector: &Trajectory| vector.clearance.wall.padded().map(f64::to_bits);
    integer("dimension", first.dimension, more.dimension)
        .or_else(|| integer("gaps_per_junction", first.gaps_per_junction, more.gaps_per_junction))
        .or_else(|| {
            let differ = first.exit != more.exit;
            differ.then(|| ("exit", or_none(first.exit), or_none(more.exit)))
        })
        .or_else(|| number("length", first.length, more.length))
        .or_else(|| optional("bound", first.bound, more.bound))
        .or_else(|| {
            let differ = first.complete != more.complete;
            differ.then(|| ("complete", first.complete.to_string(), more.complete.to_string()))
        })
        .or_else(|| number("duration", first.duration, more.duration))
        .or_else(|| optional("free_clearance", first.free_clearance, more.free_clearance))
        .or_else(|| number("clearance.value", first.clearance.value, more.clearance.value))
        .or_else(|| number("clearance.at", first.clearance.at, more.clearance.at))
        .or_else(|| {
            let (one, other) = (first.clearance.wall, more.clearance.wall);
            let differ = wall(first) != wall(more) || one.dimension() != other.dimension();
            differ.then(|| ("clearance.wall", format!("{one:?}"), format!("{other:?}")))
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::{ErrorCode, Refusal};

    const KEY: RequestKey = RequestKey { client: 7, sequence: 3 };

    fn samples(times: std::ops::Range<u32>) -> Trajectory {
        let samples = times.map(|t| Sample { t: t.into(), ..Sample::default() }).collect();
        Trajectory { dimension: 2, length: 1.5, samples, ..Trajectory::default() }
    }

    fn part(part: u32, answer: u32, answers: u32, content: Answer) -> ReplyPart {
        let last = answers == 0;
        ReplyPart { key: KEY, id: Some(9), sent_ns: 1, part, last, answer, answers, content }
    }

    fn last(mut part: ReplyPart) -> ReplyPart {
        part.last = true;
        part
    }

    fn refusal() -> Refusal {
        Refusal::new(ErrorCode::NoRoute, "no route")
    }

    fn push_all(
        parts: impl IntoIterator<Item = ReplyPart>,
    ) -> Result<Option<Reply>, AssembleError> {
        let mut assembler = ReplyAssembler::default();
        let mut reply = None;
        for part in parts {
            assert_eq!(reply, None, "a part follows the last");
            reply = assembler.push(part)?;
        }
        Ok(reply)
    }

    #[track_caller]
    fn check_error(parts: impl IntoIterator<Item = ReplyPart>, expected: &str) {
        assert_eq!(push_all(parts).unwrap_err().to_string(), expected);
    }

    #[test]
    fn lists_of_the_same_answer_continue() {
        let reply = push_all([
            part(0, 0, 3, Ok(samples(0..4))),
            part(1, 0, 3, Ok(samples(4..6))),
            part(2, 1, 3, Err(refusal())),
            last(part(3, 2, 3, Ok(samples(0..1)))),
        ]);
        let answers = Ok(vec![Ok(samples(0..6)), Err(refusal()), Ok(samples(0..1))]);
        assert_eq!(reply, Ok(Some(Reply { key: KEY, id: Some(9), answers })));
    }

    #[test]
    fn a_refused_request_is_one_part() {
        let reply = push_all([part(0, 0, 0, Err(refusal()))]);
        assert_eq!(reply, Ok(Some(Reply { key: KEY, id: Some(9), answers: Err(refusal()) })));
    }

    #[test]
    fn a_reply_without_its_last_part_is_not_whole() {
        assert_eq!(push_all([part(0, 0, 1, Ok(samples(0..4)))]), Ok(None));
    }

    #[test]
    fn missing_and_repeated_parts_are_named() {
        let first = || part(0, 0, 2, Ok(samples(0..4)));
        check_error(
            [part(1, 0, 2, Ok(samples(0..4)))],
            "part 0 of the reply is missing: part 1 arrived instead",
        );
        let third = part(2, 1, 2, Ok(samples(0..4)));
        check_error([first(), third], "part 1 of the reply is missing: part 2 arrived instead");
        check_error([first(), first()], "part 1 of the reply is missing: part 0 arrived instead");
    }

    #[test]
    fn a_refused_part_changes_nothing() {
        let mut assembler = ReplyAssembler::default();
        assert_eq!(assembler.push(part(0, 0, 1, Ok(samples(0..2)))), Ok(None));
        assert!(assembler.push(part(2, 0, 1, Ok(samples(4..6)))).is_err());
        assert_eq!(assembler.parts(), 1);
        let reply = assembler.push(last(part(1, 0, 1, Ok(samples(2..3))))).unwrap().unwrap();
        assert_eq!(reply.answers, Ok(vec![Ok(samples(0..3))]));
        let after = assembler.push(part(2, 0, 1, Ok(samples(3..4)))).unwrap_err();
        assert_eq!(after, AssembleError::AfterLast { last: 1, found: 2 });
    }

    #[test]
    fn another_requests_part_is_refused() {
        let mut other = part(1, 0, 1, Ok(samples(0..1)));
        other.key.sequence = 4;
        check_error(
            [part(0, 0, 1, Ok(samples(0..1))), other],
            "expected a part of the reply to 0000000000000007/3, not of the reply to \
             0000000000000007/4",
        );
    }

    #[test]
    fn answers_come_in_order_and_all_of_them() {
        let first = || part(0, 0, 3, Ok(samples(0..1)));
        check_error(
            [part(0, 1, 3, Ok(samples(0..1)))],
            "part 0 belongs to answer 1, expected 0 of 3",
        );
        check_error(
            [first(), part(1, 2, 3, Ok(samples(0..1)))],
            "part 1 belongs to answer 2, expected 1 of 3",
        );
        check_error(
            [first(), last(part(1, 1, 3, Ok(samples(0..1))))],
            "part 1 is the last, but only 2 of 3 answers have arrived",
        );
        check_error(
            [part(0, 0, 1, Ok(samples(0..1))), part(1, 1, 1, Ok(samples(0..1)))],
            "part 1 belongs to answer 1, expected 1 of 1",
        );
    }

    #[test]
    fn what_parts_share_must_agree() {
        let first = || part(0, 0, 2, Ok(samples(0..1)));
        let mut longer = samples(1..2);
        longer.length = 1.75;
        check_error([first(), part(1, 0, 2, Ok(longer))], "part 1: length is 1.75, expected 1.5");
        check_error(
            [first(), part(1, 0, 3, Ok(samples(1..2)))],
            "part 1: answers is 3, expected 2",
        );
        check_error(
            [first(), part(1, 0, 2, Err(refusal()))],
            "part 1: content is a refusal, expected a trajectory",
        );
        let mut unnamed = part(1, 0, 2, Ok(samples(1..2)));
        unnamed.id = None;
        check_error([first(), unnamed], "part 1: id is none, expected 9");
    }

    #[test]
    fn a_trajectory_can_not_refuse_the_request() {
        check_error(
            [part(0, 0, 0, Ok(samples(0..1)))],
            "part 0: content is a trajectory, expected a refusal",
        );
    }

    #[test]
    fn memory_is_bounded() {
        let mut assembler = ReplyAssembler::with_most_bytes(2000);
        assert_eq!(assembler.push(part(0, 0, u32::MAX, Ok(samples(0..10)))), Ok(None));
        let error = assembler.push(part(1, 1, u32::MAX, Ok(samples(0..20)))).unwrap_err();
        assert!(matches!(error, AssembleError::TooLarge { part: 1, needs, most: 2000 }
            if needs > 30 * size_of::<Sample>()));
    }
}
