//! The rows that `replay show` lists: one for each answer.

use std::io::{self, Write};

use comparison::exchanges::Asked;
use render::table;
use schemas::message::{ErrorCode, RequestContent, RequestKey, Task, Trajectory};
use serde_json::json;

/// An answer, or a request that has none.
#[derive(Debug, Clone, Default)]
pub(crate) struct Row {
    /// Counts the requests, from 0.
    pub(crate) request: u64,
    pub(crate) key: RequestKey,
    pub(crate) id: Option<u64>,
    /// `None` if the request can't be read.
    pub(crate) task: Option<Task>,
    /// `None` if the request as a whole is refused, or has no whole reply.
    pub(crate) answer: Option<usize>,
    /// Why there is no motion, if that is known.
    pub(crate) error: Option<ErrorCode>,
    pub(crate) motion: Option<Motion>,
    /// From sending the request to sending the end of the reply, seconds.
    pub(crate) took: Option<f64>,
}

/// The numbers of a trajectory.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion {
    pub(crate) length: f64,
    pub(crate) clearance: f64,
    pub(crate) free_clearance: Option<f64>,
    pub(crate) bound: Option<f64>,
    pub(crate) duration: f64,
    pub(crate) legs: usize,
    pub(crate) samples: usize,
}

impl From<&Trajectory> for Motion {
    fn from(trajectory: &Trajectory) -> Self {
        Self {
            length: trajectory.length,
            clearance: trajectory.clearance.value,
            free_clearance: trajectory.free_clearance,
            bound: trajectory.bound,
            duration: trajectory.duration,
            legs: trajectory.legs.len(),
            samples: trajectory.samples.len(),
        }
    }
}

/// The rows of a request.
pub(crate) fn rows(asked: &Asked) -> Vec<Row> {
    let Asked { index, request, reply, replied_ns, lacks_free_space: _, uploads: _ } = asked;
    let (id, task) = match &request.content {
        RequestContent::Scene(scene) => (scene.id, Some(scene.task)),
        RequestContent::Unreadable { .. } => (reply.as_ref().and_then(|reply| reply.id), None),
    };
    let took_ns = replied_ns.and_then(|replied| replied.checked_sub(request.sent_ns));
    let took = took_ns.map(|ns| ns as f64 * 1e-9);
    let row = Row { request: *index, key: request.key, id, task, took, ..Row::default() };
    match reply.as_ref().map(|reply| &reply.answers) {
        None => vec![row],
        Some(Err(refusal)) => vec![Row { error: Some(refusal.code), ..row }],
        Some(Ok(answers)) => {
            let each = answers.iter().enumerate().map(|(index, answer)| Row {
                answer: Some(index),
                error: answer.as_ref().err().map(|refusal| refusal.code),
                motion: answer.as_ref().ok().map(Motion::from),
                ..row.clone()
            });
            each.collect()
        }
    }
}

impl Row {
    /// `planned`, the code of a refusal, or `no reply`.
    fn outcome(&self) -> &'static str {
        match (self.error, self.motion) {
            (Some(code), _) => code.name(),
            (None, Some(_)) => "planned",
            (None, None) => "no reply",
        }
    }
}

pub(crate) fn text(rows: &[Row], out: &mut impl Write) -> io::Result<()> {
    let mut table = table::table(&[
        "request",
        "id",
        "task",
        "answer",
        "outcome",
        "length",
        "clearance",
        "duration",
        "took",
    ]);
    for row in rows {
        let number = |number: Option<f64>, decimals: usize, unit: &str| {
            number.map_or("-".to_owned(), |number| format!("{number:.decimals$} {unit}"))
        };
        let motion = row.motion;
        table.add_row([
            row.request.to_string(),
            row.id.map_or("-".to_owned(), |id| id.to_string()),
            row.task.map_or("unreadable", Task::name).to_owned(),
            row.answer.map_or("-".to_owned(), |answer| answer.to_string()),
            row.outcome().to_owned(),
            number(motion.map(|motion| motion.length), 6, "m"),
            number(motion.map(|motion| motion.clearance), 6, "m"),
            number(motion.map(|motion| motion.duration), 3, "s"),
            number(row.took.map(|took| took * 1e3), 3, "ms"),
        ]);
    }
    table.lines().try_for_each(|line| writeln!(out, "{}", line.trim_end()))
}

/// An object on each line.
pub(crate) fn json(rows: &[Row], out: &mut impl Write) -> io::Result<()> {
    for row in rows {
        let finite = |number: f64| number.is_finite().then_some(number);
        let motion = row.motion;
        let value = json!({
            "request": row.request,
            "key": row.key.to_string(),
            "id": row.id,
            "task": row.task.map(Task::name),
            "answer": row.answer,
            "outcome": row.outcome(),
            "length": motion.map(|motion| motion.length),
            "clearance": motion.and_then(|motion| finite(motion.clearance)),
            "free_clearance": motion.and_then(|motion| finite(motion.free_clearance?)),
            "bound": motion.and_then(|motion| motion.bound),
            "duration": motion.map(|motion| motion.duration),
            "legs": motion.map(|motion| motion.legs),
            "samples": motion.map(|motion| motion.samples),
            "took": row.took,
        });
        writeln!(out, "{value}")?;
    }
    Ok(())
}

pub(crate) fn csv(rows: &[Row], out: &mut impl Write) -> io::Result<()> {
    fn cell<T: ToString>(value: Option<T>) -> String {
        value.map_or(String::new(), |value| value.to_string())
    }
    writeln!(
        out,
        "request,key,id,task,answer,outcome,length,clearance,free_clearance,bound,duration,legs,\
         samples,took"
    )?;
    for row in rows {
        let motion = row.motion;
        let cells = [
            row.request.to_string(),
            row.key.to_string(),
            cell(row.id),
            cell(row.task),
            cell(row.answer),
            row.outcome().to_owned(),
            cell(motion.map(|motion| motion.length)),
            cell(motion.map(|motion| motion.clearance)),
            cell(motion.and_then(|motion| motion.free_clearance)),
            cell(motion.and_then(|motion| motion.bound)),
            cell(motion.map(|motion| motion.duration)),
            cell(motion.map(|motion| motion.legs)),
            cell(motion.map(|motion| motion.samples)),
            cell(row.took),
        ];
        writeln!(out, "{}", cells.join(","))?;
    }
    Ok(())
}
