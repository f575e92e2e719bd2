//! Replies, part by part, into shared memory or into a list.

use std::convert::Infallible;
use std::f64::consts::PI;

use planning::clearance::Clearance;
use planning::geometry::{self, Vector};
use planning::motion::{self, Curve, Leg, wrapped};
use planning::trajectory::{Sampler, State};
use schemas::convert::{self, CellWriter, PartSink, Samples, TrajectoryWriter};
use schemas::message::{self, AxisBox, Refusal, Reply, ReplyAssembler, ReplyPart, RequestKey};
use schemas::wire::{self, ReplyHeader, reported};

use crate::base_frame::Teller;

/// A reply on its way: counts parts and answers.
pub(crate) struct Parts<'a, S> {
    header: ReplyHeader,
    sink: &'a mut S,
}

impl<'a, S: PartSink> Parts<'a, S> {
    /// A reply with this many answers; 0 where the request as a whole is refused.
    pub(crate) fn new(key: RequestKey, id: Option<u64>, answers: u32, sink: &'a mut S) -> Self {
        let header = ReplyHeader {
            version: wire::VERSION,
            dimension: 2,
            client: key.client,
            sequence: key.sequence,
            id: id.unwrap_or(0),
            given: if id.is_some() { reported::ID } else { 0 },
            answers,
            ..ReplyHeader::default()
        };
        Self { header, sink }
    }

    /// The next answer is a refusal.
    pub(crate) fn refuse(&mut self, refusal: &Refusal, last: bool) -> Result<(), S::Error> {
        convert::write_refusal(refusal, &mut self.header, last, self.sink)?;
        self.header.answer += 1;
        Ok(())
    }

    /// The next answer is a trajectory; `fill` sets the fields that all its parts share.
    pub(crate) fn trajectory(
        &mut self,
        fill: impl FnOnce(&mut ReplyHeader),
        lists: TrajectoryWriter<
            impl ExactSizeIterator<Item = f64>,
            impl ExactSizeIterator<Item = u64>,
            impl ExactSizeIterator<Item = AxisBox>,
            impl ExactSizeIterator<Item = wire::Leg>,
            impl Samples,
        >,
        last: bool,
    ) -> Result<(), S::Error> {
        fill(&mut self.header);
        lists.write(&mut self.header, last, self.sink)?;
        self.header.answer += 1;
        Ok(())
    }
}

/// A leg as it lies in memory.
pub(crate) fn leg<const D: usize>(leg: &Leg<D>, clearance: f64) -> wire::Leg {
    let mut cells = wire::Leg {
        table: leg.rule.map_or(0, |rule| rule.table.into()),
        number: leg.rule.map_or(0, |rule| rule.number.into()),
        junction: leg.junction.map_or(u64::MAX, |junction| junction as u64),
        length: leg.curve.length(),
        clearance,
        rung: wire::Leg::rung_code(leg.rung.map(rung)),
        // Translated parts have no front. A line on which the robot turns is as its heading, which
        // is that at its end.
        reverse: u8::from(leg.rung.is_some() && leg.curve.ends_in_reverse()),
        ..wire::Leg::default()
    };
    match &leg.curve {
        Curve::Line { from, to, heading, turned } => {
            cells.kind = 0;
            (cells.point, cells.to) = (padded(from), padded(to));
            (cells.heading, cells.sweep) = (*heading, *turned);
        }
        Curve::Arc { center, radius, start_angle, sweep, .. } => {
            cells.kind = 1;
            cells.point = padded(center);
            (cells.radius, cells.start, cells.sweep) = (*radius, *start_angle, *sweep);
        }
        Curve::Clothoid { from, to, from_heading, curvatures, reverse, .. } => {
            cells.kind = 3;
            (cells.point, cells.to) = (padded(from), padded(to));
            // A translated part heads nowhere; what is told is its direction of travel.
            let is_turned = *reverse && cells.reverse == 0;
            let turned = if is_turned { PI } else { 0.0 };
            cells.start = wrapped(from_heading + turned);
            cells.heading = wrapped(leg.curve.end_heading() + turned);
            [cells.radius, cells.sweep] = *curvatures;
        }
        Curve::Turn { position, from_heading, sweep } => {
            cells.kind = 2;
            cells.point = padded(position);
            (cells.start, cells.sweep) = (*from_heading, *sweep);
            cells.heading = wrapped(from_heading + sweep);
        }
    }
    cells
}

fn rung(rung: motion::Rung) -> message::Rung {
    match rung {
        motion::Rung::Taut => message::Rung::Taut,
        motion::Rung::Radius => message::Rung::Radius,
        motion::Rung::Aligned => message::Rung::Aligned,
        motion::Rung::Reverse => message::Rung::Reverse,
        motion::Rung::Lattice => message::Rung::Lattice,
    }
}

/// The states of a motion, if any are wanted, written from within: several times faster
/// than one by one.
pub(crate) struct States<'a, const D: usize> {
    sampler: Option<Sampler<'a, D>>,
    teller: Option<Teller<'a, D>>,
}

impl<'a, const D: usize> States<'a, D> {
    pub(crate) fn new(sampler: Option<Sampler<'a, D>>) -> Self {
        Self { sampler, teller: None }
    }

    /// The same, told in another frame.
    pub(crate) fn told_by(self, teller: Option<Teller<'a, D>>) -> Self {
        Self { teller, ..self }
    }
}

impl<const D: usize> Samples for States<'_, D> {
    fn left(&self) -> usize {
        self.sampler.as_ref().map_or(0, Sampler::len)
    }

    fn write(&mut self, count: usize, writer: &mut CellWriter) {
        let Some(states) = &mut self.sampler else { return };
        match &mut self.teller {
            None => states.for_next(count, |state| writer.push_pod(&sample(&state))),
            Some(teller) => {
                states.for_next(count, |state| writer.push_pod(&sample(&teller.tell(state))))
            }
        }
    }
}

/// A state of the motion as it lies in memory.
#[inline]
fn sample<const D: usize>(state: &State<D>) -> wire::Sample {
    wire::Sample {
        t: state.time,
        position: padded(&state.position),
        heading: state.heading,
        velocity: padded(&state.velocity),
        yaw_rate: state.yaw_rate,
    }
}

/// Channels as the reply names them.
pub(crate) fn boxes<const D: usize>(
    boxes: &[geometry::AxisBox<D>],
) -> impl ExactSizeIterator<Item = AxisBox> {
    let corner = |corner: Vector<D>| message::Vector::new(corner.as_slice()).unwrap_or_default();
    boxes.iter().map(move |sides| AxisBox { min: corner(sides.min()), max: corner(sides.max()) })
}

/// Sets the clearance of a trajectory; infinite where there are no walls.
pub(crate) fn clearance<const D: usize>(header: &mut ReplyHeader, near: Option<&Clearance<D>>) {
    (header.clearance, header.clearance_at, header.wall) = match near {
        Some(near) => (near.value, near.at, padded(&near.wall)),
        None => (f64::INFINITY, 0.0, [0.0; 3]),
    };
}

#[inline]
fn padded<const D: usize>(vector: &Vector<D>) -> [f64; 3] {
    let mut values = [0.0; 3];
    values[..D].copy_from_slice(vector.as_slice());
    values
}

/// Puts a reply together in this process.
pub(crate) struct Collect {
    assembler: ReplyAssembler,
    cells: Vec<u64>,
    reply: Option<Reply>,
}

impl Default for Collect {
    fn default() -> Self {
        // What this process writes itself is bounded by what was asked of it.
        let assembler = ReplyAssembler::with_most_bytes(usize::MAX);
        Self { assembler, cells: Vec::new(), reply: None }
    }
}

impl PartSink for Collect {
    type Error = Infallible;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Infallible> {
        let part = read_back(&mut self.cells, header, cells, fill);
        self.reply = self.assembler.push(part).expect("parts written in order");
        Ok(())
    }
}

/// Has a part written to `memory`, and reads it as its client would.
fn read_back(
    memory: &mut Vec<u64>,
    header: &ReplyHeader,
    cells: usize,
    fill: impl FnOnce(&mut CellWriter),
) -> ReplyPart {
    memory.clear();
    memory.resize(cells, 0);
    fill(&mut CellWriter::new(memory));
    convert::read_part(header, memory).expect("what was just written")
}

/// Keeps the parts of a reply.
#[derive(Default)]
pub(crate) struct Keep {
    cells: Vec<u64>,
    pub(crate) parts: Vec<ReplyPart>,
}

impl PartSink for Keep {
    type Error = Infallible;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Infallible> {
        self.parts.push(read_back(&mut self.cells, header, cells, fill));
        Ok(())
    }
}

impl Collect {
    pub(crate) fn reply(self) -> Reply {
        self.reply.expect("every request has an answer, and the last part says so")
    }
}
