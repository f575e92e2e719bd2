//! `replay show`: what was asked and answered.

pub(crate) mod filter;
pub(crate) mod rows;

use std::error::Error;
use std::io::{self, Write};
use std::ops::ControlFlow;

use comparison::exchanges::Asked;
use comparison::named::NamedFreeSpaces;
use program::warn;
use render::{csv, picture, table};
use schemas::json;
use schemas::message::{RequestContent, SceneRequest};

use crate::arguments::{Show, TableFormat};
use crate::findings::Findings;
use crate::{output, reading};
use filter::Refused;
use rows::Row;

/// Runs the command; the inner result is that of printing.
pub(crate) fn run(
    arguments: &Show,
    findings: &mut Findings,
    out: &mut impl Write,
) -> Result<io::Result<()>, Box<dyn Error>> {
    match (arguments.request, arguments.reply) {
        (Some(index), _) | (_, Some(index)) => one(arguments, index, findings, out),
        (None, None) if arguments.svg.is_some() => {
            Err("--svg draws one request: --request N or --reply N says which".into())
        }
        (None, None) => Ok(list(arguments, findings, out)),
    }
}

/// The table.
fn list(arguments: &Show, findings: &mut Findings, out: &mut impl Write) -> io::Result<()> {
    let mut listed: Vec<Row> = Vec::new();
    reading::whole(&arguments.file, findings, |asked| {
        listed.extend(rows::rows(&asked).into_iter().filter(|row| is_wanted(arguments, row)));
        ControlFlow::Continue(())
    });
    // They come in the order in which their replies ended.
    listed.sort_by_key(|row| (row.request, row.answer));
    match arguments.format {
        TableFormat::Text => rows::text(&listed, out),
        TableFormat::Json => rows::json(&listed, out),
        TableFormat::Csv => rows::csv(&listed, out),
    }
}

fn is_wanted(arguments: &Show, row: &Row) -> bool {
    let Show { id, task, error, conditions, .. } = arguments;
    let among = |ids: &[u64]| ids.is_empty() || row.id.is_some_and(|id| ids.contains(&id));
    let refused = match error {
        None => true,
        Some(Refused::Any) => row.error.is_some(),
        Some(Refused::With(code)) => row.error == Some(*code),
    };
    among(id)
        && (task.is_empty() || row.task.is_some_and(|its| task.contains(&its)))
        && refused
        && conditions.iter().all(|condition| condition.holds(row))
}

/// One request or its reply.
fn one(
    arguments: &Show,
    wanted: u64,
    findings: &mut Findings,
    out: &mut impl Write,
) -> Result<io::Result<()>, Box<dyn Error>> {
    let file = arguments.file.display();
    if let Some(path) = &arguments.svg {
        output::check(path, arguments.overwrite, &[&arguments.file])?;
    }
    let (mut named, mut found) = (NamedFreeSpaces::default(), None);
    // What is wrong elsewhere in the file does not concern this request.
    let mut elsewhere = Findings::default();
    let contents = reading::whole(&arguments.file, &mut elsewhere, |mut asked| {
        asked.uploads.iter_mut().for_each(|upload| named.resolve(upload));
        named.resolve(&mut asked.request);
        if asked.index != wanted {
            return ControlFlow::Continue(());
        }
        found = Some(asked);
        ControlFlow::Break(())
    });
    let Some(Asked { request, reply, .. }) = found else {
        findings.add(&contents);
        findings.failure = true;
        match contents.requests {
            0 => warn(format_args!("replay: {file} has no requests")),
            count => warn(format_args!(
                "replay: {file} has the requests 0 to {}, not {wanted}",
                count - 1
            )),
        }
        return Ok(Ok(()));
    };
    let scene = match &request.content {
        RequestContent::Scene(scene) => Some(scene),
        RequestContent::Unreadable { .. } => None,
    };
    let unreadable = || format!("{file}: request {wanted} is not a scene that can be read");
    if let Some(path) = &arguments.svg {
        let scene = scene.ok_or_else(unreadable)?;
        let reply =
            reply.ok_or_else(|| format!("{file}: request {wanted} has no reply to draw"))?;
        output::write(path, &picture::draw(scene, &reply), arguments.overwrite)?;
        return Ok(Ok(()));
    }
    if arguments.request.is_some() {
        let scene = scene.ok_or_else(unreadable)?;
        return Ok(writeln!(out, "{}", json::scene_to_json(scene)));
    }
    let Some(reply) = reply else {
        findings.loss = true;
        warn(format_args!("replay: {file}: request {wanted} has no whole reply"));
        return Ok(Ok(()));
    };
    let name = format!("request {wanted}");
    Ok(match arguments.format {
        TableFormat::Text => table::write(out, &name, scene, &reply),
        TableFormat::Json => writeln!(out, "{}", json::reply_to_json(&reply)),
        TableFormat::Csv => {
            let none = SceneRequest::empty();
            writeln!(out, "{}", csv::HEADER)
                .and_then(|()| csv::write(out, 1, scene.unwrap_or(&none), &reply))
        }
    })
}
