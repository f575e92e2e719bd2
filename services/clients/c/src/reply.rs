//! Replies for C.

use std::ffi::{CString, c_char};
use std::ptr;

use clearway_client::message::{self, Curve, Direction, ExceededLimit, Vector};

use crate::error::{Error, call, free, given};
use crate::values::{
    AxisBox, Exceeds, Exit, Leg, LegKind, Limit, Rung, Sample, Samples, Status, Summary,
};

/// A reply: an answer for each clearance asked for.
#[derive(Debug)]
pub struct Reply(clearway_client::Reply);

/// A planned and sampled motion, of a reply.
#[derive(Debug)]
pub struct Trajectory {
    // Pointers to it are pointers to what `clearway_client` has.
    _nothing: [u8; 0],
}

/// What a pointer from C points to.
unsafe fn seen<'a>(trajectory: *const Trajectory) -> Option<&'a clearway_client::Trajectory> {
    // SAFETY: it is NULL, or comes from `clearway_reply_trajectory`, of a reply that is alive.
    unsafe { trajectory.cast::<clearway_client::Trajectory>().as_ref() }
}

const _: () = {
    use clearway_client::Sample as Planned;
    use std::mem::offset_of;
    assert!(size_of::<Sample>() == size_of::<Planned>());
    assert!(align_of::<Sample>() == align_of::<Planned>());
    assert!(offset_of!(Sample, position) == offset_of!(Planned, position));
    assert!(offset_of!(Sample, heading) == offset_of!(Planned, heading));
    assert!(offset_of!(Sample, velocity) == offset_of!(Planned, velocity));
    assert!(offset_of!(Sample, yaw_rate) == offset_of!(Planned, yaw_rate));
};

impl Reply {
    pub(crate) fn new(reply: clearway_client::Reply) -> Self {
        Self(reply)
    }
}

/// How many answers a reply has, one for each clearance asked for; 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_reply_answers(reply: *const Reply) -> usize {
    // SAFETY: as the header says.
    unsafe { reply.as_ref() }.map_or(0, |reply| reply.0.answers().len())
}

/// Whether all samples are where the planner wrote them, in shared memory. A client with many replies
/// alive copies the later ones, so that the planner has room to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_reply_is_shared(reply: *const Reply) -> bool {
    // SAFETY: as the header says.
    unsafe { reply.as_ref() }.is_some_and(|reply| reply.0.is_shared())
}

/// The scene's id, if it has one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_reply_id(reply: *const Reply, id: *mut u64) -> bool {
    // SAFETY: as the header says.
    let found = unsafe { reply.as_ref() }.and_then(|reply| reply.0.id());
    let (Some(found), false) = (found, id.is_null()) else { return false };
    // SAFETY: it is not NULL and points to where the caller wants it.
    unsafe { id.write(found) };
    true
}

/// The trajectory of an answer; CLEARWAY_STATUS_REFUSED if the answer is a refusal.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_reply_trajectory(
    reply: *const Reply,
    answer: usize,
    trajectory: *mut *const Trajectory,
    error: *mut *mut Error,
) -> Status {
    // SAFETY: as the header says.
    unsafe {
        call(error, || {
            let answers = given(reply, "reply")?.0.answers();
            let found = answers.get(answer).ok_or_else(|| {
                Error::invalid(&format!("answer is {answer}, of {}", answers.len()))
            })?;
            let found = found.as_ref().map_err(|refused| Error::from(refused.clone()))?;
            if trajectory.is_null() {
                return Err(Error::invalid("trajectory is NULL"));
            }
            trajectory.write(ptr::from_ref(found).cast());
            Ok(())
        })
    }
}

/// The reply as `plan --format json` prints it, to be freed with clearway_text_free; NULL for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_reply_json(reply: *const Reply) -> *mut c_char {
    // SAFETY: as the header says.
    let json = unsafe { reply.as_ref() }.and_then(|reply| CString::new(reply.0.to_json()).ok());
    json.map_or(ptr::null_mut(), CString::into_raw)
}

/// Frees a text.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_text_free(text: *mut c_char) {
    if !text.is_null() {
        // SAFETY: as the header says.
        drop(unsafe { CString::from_raw(text) });
    }
}

/// Frees a reply, and with it its trajectories and their samples.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_reply_free(reply: *mut Reply) {
    // SAFETY: as the header says.
    unsafe { free(reply) };
}

/// What a trajectory says beside its lists. `trajectory` must not be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_trajectory_summary(trajectory: *const Trajectory) -> Summary {
    // SAFETY: as the header says.
    let trajectory = unsafe { seen(trajectory) }.expect("`trajectory` is not NULL");
    let message::Clearance { value, at, wall } = *trajectory.clearance();
    Summary {
        length: trajectory.length(),
        duration: trajectory.duration(),
        clearance: value,
        clearance_at: at,
        clearance_wall: wall.padded(),
        bound: trajectory.bound().unwrap_or(f64::NAN),
        free_clearance: trajectory.free_clearance().unwrap_or(f64::NAN),
        dimension: trajectory.dimension() as u32,
        complete: trajectory.is_complete(),
        exit: trajectory.exit().map_or(Exit::None, exit_of),
        stops: trajectory.stops().map_or(-1, |stops| stops as i64),
        exceeds: exceeds_of(trajectory.exceeds()),
    }
}

/// How many blocks of samples a trajectory has; 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_trajectory_blocks(trajectory: *const Trajectory) -> usize {
    // SAFETY: as the header says.
    unsafe { seen(trajectory) }.map_or(0, |trajectory| trajectory.blocks().len())
}

/// The samples of a block, where the planner wrote them; they go on in the next block. None if there
/// is no such block.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_trajectory_block(
    trajectory: *const Trajectory,
    block: usize,
) -> Samples {
    // SAFETY: as the header says.
    let trajectory = unsafe { seen(trajectory) };
    let block = trajectory.and_then(|trajectory| trajectory.blocks().get(block));
    let samples = block.map_or(&[][..], |block| block.samples());
    Samples { data: samples.as_ptr().cast(), count: samples.len() }
}

/// How many legs a trajectory has; 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_trajectory_legs(trajectory: *const Trajectory) -> usize {
    // SAFETY: as the header says.
    unsafe { seen(trajectory) }.map_or(0, |trajectory| trajectory.legs().len())
}

/// A leg of a trajectory; false if there is no such leg.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_trajectory_leg(
    trajectory: *const Trajectory,
    index: usize,
    leg: *mut Leg,
) -> bool {
    // SAFETY: as the header says.
    let trajectory = unsafe { seen(trajectory) };
    let found = trajectory.and_then(|trajectory| trajectory.legs().get(index));
    let (Some(found), false) = (found, leg.is_null()) else { return false };
    // SAFETY: it is not NULL and points to where the caller wants it.
    unsafe { leg.write(leg_of(found)) };
    true
}

/// The channels travelled, as indices into those of the scene, in travel order: `*count` of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_trajectory_route(
    trajectory: *const Trajectory,
    count: *mut usize,
) -> *const u64 {
    // SAFETY: as the header says.
    let route = unsafe { seen(trajectory) }.map_or(&[][..], |trajectory| trajectory.route());
    if !count.is_null() {
        // SAFETY: it points to where the caller wants it.
        unsafe { count.write(route.len()) };
    }
    route.as_ptr()
}

/// The gaps used, metres, junction by junction in travel order: `*count` of them, `*each` for every
/// junction.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_trajectory_gaps(
    trajectory: *const Trajectory,
    count: *mut usize,
    each: *mut usize,
) -> *const f64 {
    // SAFETY: as the header says.
    let trajectory = unsafe { seen(trajectory) };
    let (gaps, per_junction) = trajectory.map_or((&[][..], 0), |trajectory| trajectory.gaps());
    for (place, number) in [(count, gaps.len()), (each, per_junction)] {
        if !place.is_null() {
            // SAFETY: it points to where the caller wants it.
            unsafe { place.write(number) };
        }
    }
    gaps.as_ptr()
}

/// How many channels the planner made for a trajectory, which its route counts; 0 if the scene has
/// them, and for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_trajectory_channels(trajectory: *const Trajectory) -> usize {
    // SAFETY: as the header says.
    unsafe { seen(trajectory) }.map_or(0, |trajectory| trajectory.channels().len())
}

/// A channel that the planner made; false if there is no such channel.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_trajectory_channel(
    trajectory: *const Trajectory,
    index: usize,
    channel: *mut AxisBox,
) -> bool {
    // SAFETY: as the header says.
    let trajectory = unsafe { seen(trajectory) };
    let found = trajectory.and_then(|trajectory| trajectory.channels().get(index));
    let (Some(found), false) = (found, channel.is_null()) else { return false };
    let message::AxisBox { min, max } = found;
    // SAFETY: it is not NULL and points to where the caller wants it.
    unsafe { channel.write(AxisBox { min: min.padded(), max: max.padded() }) };
    true
}

fn exit_of(exit: Direction) -> Exit {
    match exit {
        Direction::PlusX => Exit::PlusX,
        Direction::MinusX => Exit::MinusX,
        Direction::PlusY => Exit::PlusY,
        Direction::MinusY => Exit::MinusY,
        Direction::PlusZ => Exit::PlusZ,
        Direction::MinusZ => Exit::MinusZ,
    }
}

fn exceeds_of(exceeds: Option<message::Exceeds>) -> Exceeds {
    let Some(message::Exceeds { limit, joints, jump }) = exceeds else {
        return Exceeds { limit: Limit::None, joints: 0, jump: 0.0 };
    };
    let limit = match limit {
        ExceededLimit::YawAcceleration => Limit::YawAcceleration,
    };
    Exceeds { limit, joints, jump }
}

fn rung_of(rung: message::Rung) -> Rung {
    match rung {
        message::Rung::Taut => Rung::Taut,
        message::Rung::Radius => Rung::Radius,
        message::Rung::Aligned => Rung::Aligned,
        message::Rung::Reverse => Rung::Reverse,
        message::Rung::Lattice => Rung::Lattice,
    }
}

fn leg_of(leg: &message::Leg) -> Leg {
    let message::Leg { curve, length, clearance, junction, rule, reverse, rung } = *leg;
    let at = |point: Vector| point.padded();
    let all = Leg {
        kind: LegKind::Line,
        reverse,
        table: rule.map_or(0, |rule| rule.table),
        number: rule.map_or(0, |rule| rule.number),
        rung: rung.map_or(Rung::None, rung_of),
        junction: junction.map_or(-1, |junction| junction as i64),
        length,
        clearance,
        point: [0.0; 3],
        to: [0.0; 3],
        radius: 0.0,
        start: 0.0,
        heading: 0.0,
        sweep: 0.0,
        curvatures: [0.0; 2],
    };
    match curve {
        Curve::Line { from, to, heading, turned } => {
            Leg { point: at(from), to: at(to), heading, sweep: turned, ..all }
        }
        Curve::Arc { center, radius, start_angle: start, sweep } => {
            Leg { kind: LegKind::Arc, point: at(center), radius, start, sweep, ..all }
        }
        Curve::Turn { position, from_heading: start, to_heading: heading, sweep } => {
            Leg { kind: LegKind::Turn, point: at(position), start, heading, sweep, ..all }
        }
        Curve::Clothoid {
            from,
            to,
            from_heading: start,
            to_heading: heading,
            curvatures,
            length: _,
        } => {
            let (point, to) = (at(from), at(to));
            Leg { kind: LegKind::Clothoid, point, to, start, heading, curvatures, ..all }
        }
    }
}
