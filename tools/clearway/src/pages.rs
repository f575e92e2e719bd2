//! Man pages.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use clap::Command;
use clap_mangen::Man;
use roff::{Roff, roman};

/// A page can't be written.
#[derive(Debug, thiserror::Error)]
#[error("can't write {}: {cause}", path.display())]
pub(crate) struct PageError {
    path: PathBuf,
    cause: io::Error,
}

/// Writes a page for each of these commands, and for each of their subcommands.
pub(crate) fn write(
    commands: impl Iterator<Item = Command>,
    folder: &Path,
) -> Result<(), PageError> {
    let failed = |path: &Path, cause| PageError { path: path.to_owned(), cause };
    fs::create_dir_all(folder).map_err(|cause| failed(folder, cause))?;
    for command in commands {
        let mut command = command.disable_help_subcommand(true);
        command.build();
        let mut open = vec![command];
        while let Some(command) = open.pop() {
            open.extend(command.get_subcommands().cloned());
            let name = command.get_display_name().unwrap_or_else(|| command.get_name());
            let path = folder.join(format!("{name}.1"));
            File::create(&path)
                .and_then(|file| {
                    let mut file = BufWriter::new(file);
                    page(&command, &mut file)?;
                    file.flush()
                })
                .map_err(|cause| failed(&path, cause))?;
        }
    }
    Ok(())
}

fn page(command: &Command, out: &mut dyn Write) -> io::Result<()> {
    let today = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    let day = today.split('T').next().unwrap_or_default();
    let man = Man::new(command.clone()).date(day).manual("Clearway");
    man.render_title(out)?;
    man.render_name_section(out)?;
    man.render_synopsis_section(out)?;
    man.render_description_section(out)?;
    let mut options = Vec::new();
    man.render_options_section(&mut options)?;
    // Readers warn of breaks beside an empty line.
    let options = String::from_utf8_lossy(&options).replace(".br\n\n.br\n", "\n");
    out.write_all(options.as_bytes())?;
    if command.has_subcommands() {
        man.render_subcommands_section(out)?;
    }
    if let Some(text) = command.get_after_help() {
        notes(&text.to_string()).to_writer(out)?;
    }
    match command.get_version() {
        Some(_) => man.render_version_section(out),
        None => Ok(()),
    }
}

/// What stands below the arguments in `--help`: text is filled, and indented lines stay as they are.
fn notes(text: &str) -> Roff {
    const EXIT_CODES: &str = "Exit codes:";
    let mut roff = Roff::new();
    let mut kept = false;
    let mut section = "";
    let mut keep = |roff: &mut Roff, keeps: bool| {
        if keeps != kept {
            roff.control(if keeps { "nf" } else { "fi" }, []);
            kept = keeps;
        }
    };
    let mut is_apart = false;
    for line in text.lines() {
        let title = match line {
            _ if line.starts_with(EXIT_CODES) => "EXIT STATUS",
            "Examples:" => "EXAMPLES",
            // The text goes on after the examples.
            _ if !["NOTES", "EXIT STATUS"].contains(&section)
                && !line.is_empty()
                && !line.starts_with(' ') =>
            {
                "NOTES"
            }
            _ => "",
        };
        if !title.is_empty() {
            keep(&mut roff, false);
            roff.control("SH", [title]);
            (section, is_apart) = (title, false);
        }
        match line.strip_prefix(EXIT_CODES).unwrap_or(line) {
            "Examples:" => {}
            line if line.trim().is_empty() => is_apart = title.is_empty(),
            line => {
                let indented = line.strip_prefix("  ");
                if std::mem::take(&mut is_apart) {
                    keep(&mut roff, false);
                    roff.control("PP", []);
                }
                keep(&mut roff, indented.is_some());
                roff.text([roman(indented.unwrap_or(line.trim()).trim_end())]);
            }
        }
    }
    keep(&mut roff, false);
    roff
}
