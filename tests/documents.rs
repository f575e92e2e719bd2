//! The documents: their links lead somewhere, and the tests that they name exist.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use configuration::Config;
use integration_tests::{program, root};

/// The repository's Markdown files.
fn documents() -> Vec<PathBuf> {
    let mut files = Vec::new();
    for folder in ["", "docs", "recordings"] {
        let entries = fs::read_dir(root().join(folder)).expect("the folder can be read");
        let paths = entries.map(|entry| entry.expect("the folder can be read").path());
        files.extend(paths.filter(|path| path.extension().is_some_and(|end| end == "md")));
    }
    files.sort();
    assert!(files.len() > 6, "there are more documents than {files:?}");
    files
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The lines outside of code blocks, with their numbers.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut in_code = false;
    let lines = text.lines().enumerate().filter(move |(_, line)| {
        let fence = line.trim_start().starts_with("```");
        in_code ^= fence;
        !in_code && !fence
    });
    lines.map(|(index, line)| (index + 1, line))
}

/// A link: where it stands, its text, and where it leads.
struct Link {
    place: String,
    text: String,
    target: PathBuf,
    anchor: Option<String>,
}

/// The links to other places in the repository.
fn links() -> Vec<Link> {
    let mut links = Vec::new();
    for path in documents() {
        for (number, line) in prose(&read(&path)) {
            let mut parts = line.split("](").peekable();
            while let Some(before) = parts.next() {
                let Some(target) = parts.peek().and_then(|after| after.split(')').next()) else {
                    continue;
                };
                if target.contains("://") {
                    continue;
                }
                let (file, anchor) = match target.split_once('#') {
                    Some((file, anchor)) => (file, Some(anchor.to_owned())),
                    None => (target, None),
                };
                let folder = path.parent().expect("a file lies in a folder");
                let target = if file.is_empty() { path.clone() } else { folder.join(file) };
                let text = before.rsplit('[').next().unwrap_or_default().to_owned();
                links.push(Link {
                    place: format!("{}:{number}", path.display()),
                    text,
                    target,
                    anchor,
                });
            }
        }
    }
    assert!(links.len() > 50, "there are more links than these {}", links.len());
    links
}

/// What a heading is called in a link.
fn anchor_of(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn links_lead_somewhere() {
    for Link { place, target, anchor, .. } in links() {
        assert!(target.exists(), "{place}: there is no {}", target.display());
        let Some(anchor) = anchor else { continue };
        let text = read(&target);
        let headings = prose(&text).filter(|(_, line)| line.starts_with('#'));
        let anchors: BTreeSet<_> =
            headings.map(|(_, line)| anchor_of(line.trim_start_matches('#'))).collect();
        assert!(anchors.contains(&anchor), "{place}: {} has no {anchor}", target.display());
    }
}

#[test]
fn named_tests_exist() {
    let mut count = 0;
    for Link { place, text, target, .. } in links() {
        let name = text.strip_prefix('`').and_then(|text| text.strip_suffix('`'));
        let is_code = target.extension().is_some_and(|end| end == "rs");
        let Some(name) = name.filter(|_| is_code) else { continue };
        let is_test = read(&target).contains(&format!("fn {name}("));
        assert!(is_test, "{place}: there is no {name} in {}", target.display());
        count += 1;
    }
    assert!(count > 50, "the documents name more tests than {count}");
}

#[test]
fn units_start_programs_with_flags_that_they_have() {
    for unit in ["planner", "recorder"] {
        let text = read(&root().join(format!("docs/clearway-{unit}.service")));
        let start = text.lines().find_map(|line| line.strip_prefix("ExecStart=")).expect("one");
        assert!(start.contains(&format!("/usr/local/bin/{unit} ")), "{start}");
        let help = Command::new(program(unit)).arg("--help").output().expect("it runs");
        let help = String::from_utf8(help.stdout).expect("text");
        let flags: Vec<_> = start.split_whitespace().filter(|word| word.starts_with("-")).collect();
        assert!(flags.len() > 1, "{start}");
        for flag in flags.into_iter().filter(|flag| *flag != "-c" && *flag != "-u") {
            let has = |end| help.contains(&format!("{flag}{end}"));
            assert!(has(" <") || has(", --"), "{unit} has no {flag}");
        }
    }
}

#[test]
fn settings_for_containers_fit_their_memory() {
    let text = read(&root().join("docs/deploy.md"));
    let (_, rest) = text.split_once("```toml\n").expect("settings");
    let (settings, _) = rest.split_once("```").expect("they end");
    let file = tempfile::NamedTempFile::new().expect("the system has room for files");
    fs::write(file.path(), settings).expect("it can be written");
    let config = Config::read(file.path()).expect("settings");
    assert_ne!(config, Config::default());
    let needs = bus::most_memory(&planner::options::server_options(&config));
    assert!(needs <= 48 << 20, "{needs} bytes leave less than 16 MiB of 64");
    let all = bus::most_memory(&planner::options::server_options(&Config::default()));
    assert_eq!(all / 1_000_000, 118, "what the page says of the defaults");
}
