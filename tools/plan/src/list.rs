//! `plan --list`: the domains of this user.

use std::io::{self, Write};
use std::path::PathBuf;

use bus::{Domain, DomainError, DomainStatus};
use program::{Exit, PrintError};
use serde::Serialize;

use crate::arguments::Format;

#[derive(Debug, thiserror::Error)]
pub(crate) enum ListFailure {
    #[error(transparent)]
    Domain(#[from] DomainError),
    // Not transparent: `program::main` looks for it among the sources.
    #[error("{0}")]
    Print(#[from] PrintError),
    #[error("--list has no CSV form; use --format text or json")]
    Csv,
}

/// A domain, as JSON.
#[derive(Serialize)]
struct Row<'a> {
    domain: &'a str,
    planner: Option<PlannerRow>,
    clients: usize,
    recorders: usize,
    directory: &'a PathBuf,
    prefix: &'a str,
}

#[derive(Serialize)]
struct PlannerRow {
    pid: u32,
    alive: bool,
}

/// Prints the domains.
pub(crate) fn run(format: Format) -> Result<Exit, ListFailure> {
    let found = bus::domains()?;
    let mut out = io::stdout().lock();
    let printed = match format {
        Format::Csv => return Err(ListFailure::Csv),
        Format::Json => json(&mut out, &found),
        Format::Text if found.is_empty() => {
            writeln!(out, "no domain is in use under {}", Domain::default().root()?.display())
        }
        Format::Text => text(&mut out, &found),
    };
    printed.map_err(PrintError)?;
    Ok(Exit::Done)
}

fn json(out: &mut impl Write, found: &[DomainStatus]) -> io::Result<()> {
    for status in found {
        let planner =
            status.planner.map(|found| PlannerRow { pid: found.process, alive: found.lives });
        let DomainStatus { domain, clients, recorders, directory, prefix, .. } = status;
        let (domain, clients, recorders) = (domain.name(), *clients, *recorders);
        let row = Row { domain, planner, clients, recorders, directory, prefix };
        writeln!(out, "{}", serde_json::to_string(&row)?)?;
    }
    Ok(())
}

fn text(out: &mut impl Write, found: &[DomainStatus]) -> io::Result<()> {
    let width = found.iter().map(|status| status.domain.name().len()).max().unwrap_or(0).max(6);
    writeln!(
        out,
        "{:width$}  {:14}  {:7}  {:9}  files",
        "domain", "planner", "clients", "recorders"
    )?;
    for status in found {
        let planner = match status.planner {
            None => "none".to_owned(),
            Some(planner) if planner.lives => planner.process.to_string(),
            Some(planner) => format!("{} (dead)", planner.process),
        };
        let DomainStatus { domain, clients, recorders, directory, prefix, .. } = status;
        let directory = directory.display();
        writeln!(
            out,
            "{:width$}  {planner:14}  {clients:7}  {recorders:9}  {directory}, /dev/shm/{prefix}*",
            domain.name()
        )?;
    }
    Ok(())
}
