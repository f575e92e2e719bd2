//! Replies, part by part.

use super::cells::{CellReader, CellWriter, Malformed};
use super::codes;
use crate::message::{
    AxisBox, Clearance, Curve, Direction, ErrorCode, ExceededLimit, Exceeds, Leg, Refusal,
    ReplyPart, RequestKey, Rule, Rung, Sample, Trajectory, Vector,
};
use crate::wire::{self, LEG_CELLS, PART_CELLS, ReplyHeader, SAMPLE_CELLS, present, reported};

/// Takes the parts of a reply: shared memory, or a list in this process.
pub trait PartSink {
    /// Why a part could not be passed on.
    type Error;

    /// Passes on one part: `fill` writes its payload of `cells` cells.
    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Self::Error>;
}

/// The states of a motion, which are computed where they will be read.
pub trait Samples {
    /// How many are left.
    fn left(&self) -> usize;

    /// Writes the next `count` of them.
    fn write(&mut self, count: usize, writer: &mut CellWriter);
}

impl<I: ExactSizeIterator<Item = wire::Sample>> Samples for I {
    fn left(&self) -> usize {
        self.len()
    }

    fn write(&mut self, count: usize, writer: &mut CellWriter) {
        self.take(count).for_each(|sample| writer.push_pod(&sample));
    }
}

/// Writes a trajectory as parts, straight into the sink's memory.
#[derive(Debug)]
pub struct TrajectoryWriter<Gaps, Route, Channels, Legs, States> {
    /// The gaps used, junction by junction; metres.
    pub gaps: Gaps,
    /// Indices of the channels travelled.
    pub route: Route,
    /// The channels if the planner made them, each with the scene's dimension.
    pub channels: Channels,
    /// The pieces of the path.
    pub legs: Legs,
    /// The states of the motion.
    pub samples: States,
}

impl<Gaps, Route, Channels, Legs, States> TrajectoryWriter<Gaps, Route, Channels, Legs, States>
where
    Gaps: ExactSizeIterator<Item = f64>,
    Route: ExactSizeIterator<Item = u64>,
    Channels: ExactSizeIterator<Item = AxisBox>,
    Legs: ExactSizeIterator<Item = wire::Leg>,
    States: Samples,
{
    /// Writes all parts. `header` brings the fields that all parts share and counts the
    /// parts in `header.part`; `final_answer` says whether the reply ends here.
    pub fn write<S: PartSink>(
        mut self,
        header: &mut ReplyHeader,
        final_answer: bool,
        sink: &mut S,
    ) -> Result<(), S::Error> {
        let channel_cells = 2 * header.dimension as usize;
        header.kind = 0;
        header.refusal = 0;
        loop {
            let mut room = PART_CELLS;
            // A list is begun only when the lists before it are complete.
            let mut take = |left: usize, size: usize| {
                let taken = left.min(room / size);
                room = if taken < left { 0 } else { room - taken * size };
                taken as u32
            };
            header.gaps = take(self.gaps.len(), 1);
            header.route = take(self.route.len(), 1);
            header.channels = take(self.channels.len(), channel_cells);
            header.legs = take(self.legs.len(), LEG_CELLS);
            header.samples = take(self.samples.left(), SAMPLE_CELLS);
            let complete = header.samples as usize == self.samples.left()
                && header.legs as usize == self.legs.len()
                && header.channels as usize == self.channels.len()
                && header.route as usize == self.route.len()
                && header.gaps as usize == self.gaps.len();
            header.last = u32::from(complete && final_answer);
            let cells = header.gaps as usize
                + header.route as usize
                + header.channels as usize * channel_cells
                + header.legs as usize * LEG_CELLS
                + header.samples as usize * SAMPLE_CELLS;
            let head = *header;
            sink.part(&head, cells, |writer| {
                self.gaps.by_ref().take(head.gaps as usize).for_each(|gap| writer.push_f64(gap));
                self.route.by_ref().take(head.route as usize).for_each(|at| writer.push(at));
                for channel in self.channels.by_ref().take(head.channels as usize) {
                    for corner in [&channel.min, &channel.max] {
                        corner.as_slice().iter().for_each(|value| writer.push_f64(*value));
                    }
                }
                self.legs.by_ref().take(head.legs as usize).for_each(|leg| writer.push_pod(&leg));
                self.samples.write(head.samples as usize, writer);
            })?;
            header.part += 1;
            if complete {
                return Ok(());
            }
        }
    }
}

/// Longest message, field or setting of a refusal that is passed on, bytes. A field can
/// quote the request, at any length.
const MOST_TEXT: usize = 2048;

/// Writes a refusal as one part; `header` as in [`TrajectoryWriter::write`].
pub fn write_refusal<S: PartSink>(
    refusal: &Refusal,
    header: &mut ReplyHeader,
    final_answer: bool,
    sink: &mut S,
) -> Result<(), S::Error> {
    let message = cut(&refusal.message);
    let field = refusal.field.as_deref().map(cut);
    let setting = refusal.setting.as_deref().map(cut);
    let texts = [message, field.unwrap_or(""), setting.unwrap_or("")];
    let cells = 9 + texts.len() + texts.iter().map(|text| text.len().div_ceil(8)).sum::<usize>();
    (header.gaps, header.route, header.channels, header.legs, header.samples) = (0, 0, 0, 0, 0);
    header.kind = 1;
    header.given &= reported::ID;
    header.refusal = cells as u32;
    header.last = u32::from(final_answer);
    sink.part(header, cells, |writer| {
        let numbers = [refusal.needs, refusal.has, refusal.least, refusal.most, refusal.heading];
        let mut bits = 0;
        bits |= refusal.junction.map_or(0, |_| present::JUNCTION);
        bits |= refusal.axis.map_or(0, |_| present::AXIS);
        bits |= field.map_or(0, |_| present::FIELD);
        bits |= setting.map_or(0, |_| present::SETTING);
        for (index, number) in numbers.iter().enumerate() {
            bits |= number.map_or(0, |_| present::NUMBERS << index);
        }
        writer.push(codes::code(ErrorCode::ALL, refusal.code).into());
        writer.push(bits);
        writer.push(refusal.junction.unwrap_or(0));
        writer.push(refusal.axis.unwrap_or(0).into());
        numbers.iter().for_each(|number| writer.push_f64(number.unwrap_or(0.0)));
        texts.iter().for_each(|text| writer.push(text.len() as u64));
        texts.iter().for_each(|text| push_text(writer, text));
    })?;
    header.part += 1;
    Ok(())
}

fn cut(text: &str) -> &str {
    &text[..text.floor_char_boundary(MOST_TEXT)]
}

fn push_text(writer: &mut CellWriter, text: &str) {
    for chunk in text.as_bytes().chunks(8) {
        let mut bytes = [0; 8];
        bytes[..chunk.len()].copy_from_slice(chunk);
        writer.push(u64::from_ne_bytes(bytes));
    }
}

/// Reads one part of a reply from memory.
pub fn read_part(header: &ReplyHeader, cells: &[u64]) -> Result<ReplyPart, Malformed> {
    let (mut part, samples) = read_part_in_place(header, cells)?;
    if let Ok(trajectory) = &mut part.content {
        trajectory.samples = samples.to_vec();
    }
    Ok(part)
}

/// The same but for the samples, which stay where they are: at the end of the cells.
pub fn read_part_in_place<'a>(
    header: &ReplyHeader,
    cells: &'a [u64],
) -> Result<(ReplyPart, &'a [Sample]), Malformed> {
    if header.version != wire::VERSION {
        let (code, greatest) = (header.version.into(), wire::VERSION.into());
        return Err(Malformed::UnknownCode { what: "version", code, greatest });
    }
    if header.given & !reported::ALL != 0 {
        let (code, greatest) = (header.given.into(), reported::ALL.into());
        return Err(Malformed::UnknownCode { what: "given", code, greatest });
    }
    let mut cells = CellReader::new(cells);
    let (content, samples) = match header.kind {
        0 => {
            let (trajectory, samples) = read_trajectory(header, &mut cells)?;
            (Ok(trajectory), samples)
        }
        1 => (Err(read_refusal(header, &mut cells)?), &[][..]),
        code => {
            let code = code.into();
            return Err(Malformed::UnknownCode { what: "kind", code, greatest: 1 });
        }
    };
    cells.end()?;
    let part = ReplyPart {
        key: RequestKey { client: header.client, sequence: header.sequence },
        id: (header.given & reported::ID != 0).then_some(header.id),
        sent_ns: header.sent_ns,
        part: header.part,
        last: codes::value("last", &[false, true], header.last.into())?,
        answer: header.answer,
        answers: header.answers,
        content,
    };
    Ok((part, samples))
}

/// A trajectory without its samples, and these.
fn read_trajectory<'a>(
    header: &ReplyHeader,
    cells: &mut CellReader<'a>,
) -> Result<(Trajectory, &'a [Sample]), Malformed> {
    let dimension = header.dimension as usize;
    if !(2..=3).contains(&dimension) {
        let code = dimension as u64;
        return Err(Malformed::UnknownCode { what: "dimension", code, greatest: 3 });
    }
    let point = |values: &[f64]| Vector::new(&values[..dimension]).expect("two or three numbers");
    let has = |bit: u32| header.given & bit != 0;
    let gaps = cells.take("gaps", header.gaps.into(), 1)?;
    let route = cells.take("route", header.route.into(), 1)?;
    let channels = cells.take("channels", header.channels.into(), 2 * dimension)?;
    let legs = cells.take("legs", header.legs.into(), LEG_CELLS)?;
    let samples = cells.take("samples", header.samples.into(), SAMPLE_CELLS)?;
    let channels = channels.chunks_exact(2 * dimension).map(|cells| {
        let (min, max) = bytemuck::cast_slice(cells).split_at(dimension);
        AxisBox { min: point(min), max: point(max) }
    });
    let trajectory = Trajectory {
        dimension: header.dimension,
        gaps_per_junction: header.gaps_per_junction,
        exit: read_exit(header.exit)?,
        length: header.length,
        bound: has(reported::BOUND).then_some(header.bound),
        complete: !has(reported::INCOMPLETE),
        duration: header.duration,
        clearance: Clearance {
            value: header.clearance,
            at: header.clearance_at,
            wall: point(&header.wall),
        },
        free_clearance: has(reported::FREE_CLEARANCE).then_some(header.free_clearance),
        gaps: bytemuck::cast_slice(gaps).to_vec(),
        route: route.to_vec(),
        channels: channels.collect(),
        legs: legs
            .chunks_exact(LEG_CELLS)
            .map(|cells| {
                read_leg(&bytemuck::pod_read_unaligned(bytemuck::cast_slice(cells)), point)
            })
            .collect::<Result<_, _>>()?,
        samples: Vec::new(),
        exceeds: match has(reported::EXCEEDS) {
            true => Some(Exceeds {
                limit: codes::value("exceeds", ExceededLimit::ALL, header.exceeds.into())?,
                joints: header.exceeds_joints.into(),
                jump: header.exceeds_jump,
            }),
            false => None,
        },
        stops: has(reported::STOPS).then_some(header.stops),
    };
    Ok((trajectory, bytemuck::cast_slice(samples)))
}

fn read_exit(exit: u32) -> Result<Option<Direction>, Malformed> {
    match exit {
        0 => Ok(None),
        code => codes::value("exit", Direction::ALL, u64::from(code) - 1).map(Some),
    }
}

/// What a trajectory says beside its lists, its length and its clearance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certificate {
    /// See [`Trajectory::bound`].
    pub bound: Option<f64>,
    /// See [`Trajectory::free_clearance`].
    pub free_clearance: Option<f64>,
    /// See [`Trajectory::complete`].
    pub complete: bool,
}

impl wire::ReplyHeader {
    /// Sets the fields of the next trajectory's certificate.
    pub fn set_certificate(&mut self, certificate: Certificate) {
        let Certificate { bound, free_clearance, complete } = certificate;
        self.given &= reported::ID | reported::EXCEEDS | reported::STOPS;
        self.given |= bound.map_or(0, |_| reported::BOUND);
        self.given |= free_clearance.map_or(0, |_| reported::FREE_CLEARANCE);
        self.given |= if complete { 0 } else { reported::INCOMPLETE };
        self.bound = bound.unwrap_or(0.0);
        self.free_clearance = free_clearance.unwrap_or(0.0);
    }

    /// Sets the limit that the next trajectory does not obey.
    pub fn set_exceeds(&mut self, exceeds: Option<Exceeds>) {
        self.given &= !reported::EXCEEDS;
        if let Some(Exceeds { limit, joints, jump }) = exceeds {
            self.given |= reported::EXCEEDS;
            self.exceeds = codes::code(ExceededLimit::ALL, limit);
            self.exceeds_joints = u32::try_from(joints).unwrap_or(u32::MAX);
            self.exceeds_jump = jump;
        }
    }

    /// Sets at how many joints the next trajectory stops because no smooth corner fits.
    pub fn set_stops(&mut self, stops: Option<u64>) {
        self.given &= !reported::STOPS;
        if let Some(stops) = stops {
            self.given |= reported::STOPS;
            self.stops = stops;
        }
    }

    /// The code of a way out for [`ReplyHeader::exit`].
    pub fn exit_code(exit: Option<Direction>) -> u32 {
        exit.map_or(0, |exit| 1 + codes::code(Direction::ALL, exit))
    }
}

impl wire::Leg {
    /// The code of a rung for [`wire::Leg::rung`].
    pub fn rung_code(rung: Option<Rung>) -> u8 {
        rung.map_or(0, |rung| 1 + codes::code(Rung::ALL, rung) as u8)
    }
}

fn read_leg(leg: &wire::Leg, point: impl Fn(&[f64]) -> Vector) -> Result<Leg, Malformed> {
    let curve = match leg.kind {
        0 => Curve::Line {
            from: point(&leg.point),
            to: point(&leg.to),
            heading: leg.heading,
            turned: leg.sweep,
        },
        1 => Curve::Arc {
            center: point(&leg.point),
            radius: leg.radius,
            start_angle: leg.start,
            sweep: leg.sweep,
        },
        2 => Curve::Turn {
            position: point(&leg.point),
            from_heading: leg.start,
            to_heading: leg.heading,
            sweep: leg.sweep,
        },
        3 => Curve::Clothoid {
            from: point(&leg.point),
            to: point(&leg.to),
            from_heading: leg.start,
            to_heading: leg.heading,
            curvatures: [leg.radius, leg.sweep],
            length: leg.length,
        },
        code => {
            let code = code.into();
            return Err(Malformed::UnknownCode { what: "leg", code, greatest: 3 });
        }
    };
    let rung = match leg.rung {
        0 => None,
        code => Some(codes::value("rung", Rung::ALL, u64::from(code) - 1)?),
    };
    Ok(Leg {
        curve,
        length: leg.length,
        clearance: leg.clearance,
        junction: (leg.junction != u64::MAX).then_some(leg.junction),
        rule: (leg.table != 0).then_some(Rule { table: leg.table, number: leg.number }),
        reverse: codes::value("reverse", &[false, true], leg.reverse.into())?,
        rung,
    })
}

fn read_refusal(header: &ReplyHeader, cells: &mut CellReader) -> Result<Refusal, Malformed> {
    let mut cells = CellReader::new(cells.take("refusal", header.refusal.into(), 1)?);
    let code = codes::value("error code", ErrorCode::ALL, cells.next("refusal")?)?;
    let bits = cells.next("refusal")?;
    if bits & !present::ALL != 0 {
        let (code, greatest) = (bits, present::ALL);
        return Err(Malformed::UnknownCode { what: "present", code, greatest });
    }
    let junction = cells.next("refusal")?;
    let axis = cells.next("refusal")?;
    let numbers = cells.take("refusal", 5, 1)?;
    let number = |index: usize| {
        (bits & (present::NUMBERS << index) != 0).then(|| f64::from_bits(numbers[index]))
    };
    let lengths = cells.take("refusal", 3, 1)?;
    let message = read_text("message", lengths[0], &mut cells)?;
    let field = read_text("field", lengths[1], &mut cells)?;
    let setting = read_text("setting", lengths[2], &mut cells)?;
    cells.end()?;
    Ok(Refusal {
        code,
        message,
        field: (bits & present::FIELD != 0).then_some(field),
        junction: (bits & present::JUNCTION != 0).then_some(junction),
        axis: match bits & present::AXIS != 0 {
            true => Some(codes::value("axis", &[0, 1, 2], axis)?),
            false => None,
        },
        needs: number(0),
        has: number(1),
        least: number(2),
        most: number(3),
        heading: number(4),
        setting: (bits & present::SETTING != 0).then_some(setting),
    })
}

fn read_text(what: &'static str, bytes: u64, cells: &mut CellReader) -> Result<String, Malformed> {
    let taken = cells.take(what, bytes.div_ceil(8), 1)?;
    let text = &bytemuck::cast_slice(taken)[..bytes as usize];
    match std::str::from_utf8(text) {
        Ok(text) => Ok(text.to_owned()),
        Err(error) => Err(Malformed::NotText { what, at: error.valid_up_to() as u64 }),
    }
}
