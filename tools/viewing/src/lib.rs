//! Requests and replies as messages that viewers know: Foxglove's, which rerun reads as well, and
//! JSON with a schema for plots; and the same in the form of ROS messages.
//!
//! Everything is in one frame, right-handed with z up: driving scenes in (x, y), assembly scenes
//! of two dimensions in (x, z), those of three in (x, y, z). Metres, radians, seconds.

mod descriptions;
mod grid;
mod motion;
mod place;
mod plots;
mod ros;
mod scene;
mod topics;

pub use descriptions::TopicSchema;
pub use grid::{GridError, MOST_CELLS};
pub use ros::answers as ros_answers;
pub use topics::{Kind, ViewMessage};

use schemas::message::{Reply, SceneRequest, Trajectory};

/// A request and its reply, and where they stand in time.
#[derive(Debug, Clone, Copy)]
pub struct Shown<'a> {
    /// Counts the recording's requests, from 0.
    pub index: u64,
    /// What was asked.
    pub scene: &'a SceneRequest,
    /// What was answered.
    pub reply: &'a Reply,
    /// When its motions begin; nanoseconds since the Unix epoch.
    pub begin_ns: u64,
    /// From sending the request to sending the last part of its reply, seconds.
    pub planning_time: Option<f64>,
}

impl Shown<'_> {
    /// The motions, each with the number of its answer.
    fn motions(&self) -> impl Iterator<Item = (usize, &Trajectory)> {
        let answers = self.reply.answers.iter().flatten().enumerate();
        answers.filter_map(|(index, answer)| Some((index, answer.as_ref().ok()?)))
    }

    /// How long its longest motion takes, nanoseconds.
    pub fn duration_ns(&self) -> u64 {
        self.motions().map(|(_, motion)| nanoseconds(motion.duration)).max().unwrap_or(0)
    }

    /// The time after seconds of motion.
    fn after(&self, seconds: f64) -> u64 {
        self.begin_ns.saturating_add(nanoseconds(seconds))
    }
}

/// How requests and replies are shown.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewOptions {
    /// The name of the frame that everything is in.
    pub frame: String,
    /// The cells of floor plans made from walls, metres; without, there are none.
    pub grid: Option<f64>,
}

/// The messages that show a request and its reply.
pub fn messages(shown: &Shown, options: &ViewOptions) -> Result<Vec<ViewMessage>, GridError> {
    let mut messages = vec![plots::request(shown), scene::update(shown, &options.frame)];
    if let Some(cell) = options.grid {
        messages.extend(grid::message(shown, &options.frame, cell)?);
    }
    for (answer, motion) in shown.motions() {
        messages.push(motion::path(shown, &options.frame, answer, motion));
        messages.extend(motion::transforms(shown, &options.frame, answer, motion));
        messages.extend(plots::motion(shown, answer, motion));
    }
    Ok(messages)
}

/// Seconds as nanoseconds; what is not a time is none.
fn nanoseconds(seconds: f64) -> u64 {
    // Saturates.
    (seconds * 1e9).round() as u64
}
