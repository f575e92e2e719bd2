//! Replies, with their samples where the planner wrote them.

use std::sync::Arc;

use bus::Loan;
use schemas::json;
use schemas::message::{self, AxisBox, Clearance, Direction, Exceeds, Leg, RequestKey, Sample};
use schemas::wire::SAMPLE_CELLS;

use crate::error::Refused;

/// A reply: an answer for each clearance asked for.
#[derive(Debug)]
pub struct Reply {
    pub(crate) key: RequestKey,
    pub(crate) id: Option<u64>,
    pub(crate) answers: Vec<Answer>,
}

/// The answer for one clearance asked for.
pub type Answer = Result<Trajectory, Refused>;

/// A planned and sampled motion.
#[derive(Debug)]
pub struct Trajectory {
    /// All of it but the samples.
    pub(crate) said: message::Trajectory,
    pub(crate) blocks: Vec<Block>,
}

/// Samples that follow each other, of one part of the reply.
#[derive(Debug, Clone)]
pub struct Block {
    place: Place,
}

#[derive(Debug, Clone)]
enum Place {
    /// In shared memory, at the end of the part: so many.
    Lent(Arc<Loan>, usize),
    Copied(Arc<[Sample]>),
}

impl Reply {
    /// The scene's id.
    pub fn id(&self) -> Option<u64> {
        self.id
    }

    /// An answer for each clearance asked for, in that order.
    pub fn answers(&self) -> &[Answer] {
        &self.answers
    }

    /// The trajectories, one for each clearance asked for.
    ///
    /// # Errors
    ///
    /// The first refusal, if an answer is one; [`Reply::answers`] has the others.
    pub fn trajectories(&self) -> Result<Vec<&Trajectory>, Refused> {
        self.answers.iter().map(|answer| answer.as_ref().map_err(Clone::clone)).collect()
    }

    /// Whether all samples are where the planner wrote them. A client that keeps many replies has
    /// copies of the later ones, so that the planner has room to write.
    pub fn is_shared(&self) -> bool {
        let trajectories = self.answers.iter().flatten();
        trajectories.flat_map(Trajectory::blocks).all(Block::is_shared)
    }

    /// A copy as a message.
    pub fn to_message(&self) -> message::Reply {
        let copy = |answer: &Answer| match answer {
            Ok(trajectory) => Ok(trajectory.to_message()),
            Err(refused) => Err(refused.refusal().clone()),
        };
        let answers = Ok(self.answers.iter().map(copy).collect());
        message::Reply { key: self.key, id: self.id, answers }
    }

    /// As `plan --format json` prints it, without a line end.
    pub fn to_json(&self) -> String {
        json::reply_to_json(&self.to_message())
    }
}

/// A reply whose samples are in this process, such as one from a recording; a refusal of the whole
/// request is the error.
impl TryFrom<message::Reply> for Reply {
    type Error = Refused;

    fn try_from(reply: message::Reply) -> Result<Self, Refused> {
        let message::Reply { key, id, answers } = reply;
        let answers = answers?.into_iter().map(|answer| {
            let mut said = answer?;
            let samples = std::mem::take(&mut said.samples);
            let blocks =
                if samples.is_empty() { Vec::new() } else { vec![Block::copied(&samples)] };
            Ok(Trajectory { said, blocks })
        });
        Ok(Self { key, id, answers: answers.collect() })
    }
}

impl Trajectory {
    /// Arc length, metres.
    pub fn length(&self) -> f64 {
        self.said.length
    }

    /// Seconds.
    pub fn duration(&self) -> f64 {
        self.said.duration
    }

    /// How close the body comes to the walls, and where.
    pub fn clearance(&self) -> &Clearance {
        &self.said.clearance
    }

    /// The free clearance, metres, where it is reported; infinite without walls.
    pub fn free_clearance(&self) -> Option<f64> {
        self.said.free_clearance
    }

    /// Length of the shortest curve with the same free clearance, metres, where it is reported: no
    /// drive is shorter.
    pub fn bound(&self) -> Option<f64> {
        self.said.bound
    }

    /// Whether the search ended by itself and not because its budget was spent.
    pub fn is_complete(&self) -> bool {
        self.said.complete
    }

    /// The limit that the motion does not obey, where the request says how corners are passed or asks
    /// for a full report.
    pub fn exceeds(&self) -> Option<Exceeds> {
        self.said.exceeds
    }

    /// Where the request asks for smooth corners: at how many joints of legs the body stops because
    /// no smooth corner fits.
    pub fn stops(&self) -> Option<u64> {
        self.said.stops
    }

    /// The way out that was taken, if the request gave several.
    pub fn exit(&self) -> Option<Direction> {
        self.said.exit
    }

    /// How many coordinates positions have: 2 or 3. Those of [`Sample`]s are padded with zeros.
    pub fn dimension(&self) -> usize {
        self.said.dimension as usize
    }

    /// The gaps used, junction by junction in travel order, with so many numbers for each: metres.
    pub fn gaps(&self) -> (&[f64], usize) {
        (&self.said.gaps, self.said.gaps_per_junction as usize)
    }

    /// Indices of the channels travelled, in travel order.
    pub fn route(&self) -> &[u64] {
        &self.said.route
    }

    /// The channels, if the planner made them.
    pub fn channels(&self) -> &[AxisBox] {
        &self.said.channels
    }

    /// The pieces of the path.
    pub fn legs(&self) -> &[Leg] {
        &self.said.legs
    }

    /// The samples, part by part.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// All samples in turn.
    pub fn samples(&self) -> impl Iterator<Item = &Sample> {
        self.blocks.iter().flat_map(Block::samples)
    }

    fn to_message(&self) -> message::Trajectory {
        let samples = self.samples().copied().collect();
        message::Trajectory { samples, ..self.said.clone() }
    }
}

impl Block {
    pub(crate) fn lent(loan: Loan, samples: usize) -> Self {
        Self { place: Place::Lent(Arc::new(loan), samples) }
    }

    pub(crate) fn copied(samples: &[Sample]) -> Self {
        Self { place: Place::Copied(samples.into()) }
    }

    /// The samples.
    pub fn samples(&self) -> &[Sample] {
        match &self.place {
            Place::Lent(loan, count) => {
                let cells = loan.cells();
                bytemuck::cast_slice(&cells[cells.len() - count * SAMPLE_CELLS..])
            }
            Place::Copied(samples) => samples,
        }
    }

    /// Whether they are where the planner wrote them, in shared memory.
    pub fn is_shared(&self) -> bool {
        matches!(self.place, Place::Lent(..))
    }
}
