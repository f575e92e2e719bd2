//! One command for all programs, completions that complete, and pages that can be read.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn clearway(arguments: &[&str]) -> Output {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("clearway"));
    command.args(arguments).output().expect("it runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("it is UTF-8")
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

const PROGRAMS: [&str; 6] = ["clearway", "demo", "plan", "planner", "recorder", "replay"];

#[test]
fn its_commands_do_what_the_programs_do() {
    let scene = root().join("recordings/scenes/disassemble.json");
    let scene = scene.to_str().expect("it is UTF-8");
    let planned = clearway(&["plan", "--local", "--format", "json", scene]);
    assert_eq!(planned.status.code(), Some(0), "{}", text(&planned.stderr));
    assert!(text(&planned.stdout).starts_with("{\"id\":7,\"trajectories\":"));
    let golden = root().join("recordings/disassembly.mcap");
    let checked = clearway(&["replay", "check", golden.to_str().expect("it is UTF-8")]);
    assert_eq!(checked.status.code(), Some(0), "{}", text(&checked.stderr));
}

#[test]
fn exit_codes_and_errors_are_those_of_the_programs() {
    let missing = clearway(&["plan", "--local", "nowhere.json"]);
    assert_eq!(missing.status.code(), Some(1));
    assert!(text(&missing.stderr).starts_with("plan: can't read nowhere.json"));
    for (wrong, said) in [
        (&[][..], "Usage: clearway <COMMAND>"),
        (&["fly"], "unrecognized subcommand 'fly'"),
        (&["plan"], "Usage: clearway plan"),
        (&["completions", "cmd"], "invalid value 'cmd'"),
        (&["completions", "bash", "ls"], "invalid value 'ls'"),
        (&["man"], "<FOLDER>"),
    ] {
        let ended = clearway(wrong);
        assert_eq!(
            (ended.status.code(), text(&ended.stdout)),
            (Some(2), String::new()),
            "{wrong:?}"
        );
        assert!(text(&ended.stderr).contains(said), "{wrong:?}: {}", text(&ended.stderr));
    }
}

/// What bash offers for the last of these words.
fn offered(program: &str, words: &[&str]) -> Vec<String> {
    let script = text(&clearway(&["completions", "bash", program]).stdout);
    let folder = tempfile::tempdir().expect("there is room");
    let path = folder.path().join(program);
    fs::write(&path, script).expect("there is room");
    // As readline does it when Tab is pressed.
    let ask = r#"
        source "$1"; shift
        function=$(complete -p "$1" | sed 's/.*-F \([^ ]*\).*/\1/')
        COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMP_LINE="$*"; COMP_POINT=${#COMP_LINE}
        "$function" "$1" "${@: -1}" "${@: -2:1}"
        printf '%s\n' "${COMPREPLY[@]}""#;
    let mut bash = Command::new("bash");
    bash.args(["--norc", "--noprofile", "-c", ask, "bash"]).arg(&path).arg(program).args(words);
    let ended = bash.current_dir(root()).output().expect("bash runs");
    assert!(ended.status.success(), "{}", text(&ended.stderr));
    text(&ended.stdout).lines().map(str::to_owned).collect()
}

#[test]
fn bash_completes() {
    assert_eq!(offered("clearway", &["pl"]), ["plan", "planner"]);
    assert_eq!(offered("clearway", &["replay", "ch"]), ["check"]);
    assert_eq!(offered("clearway", &["plan", "--form"]), ["--format"]);
    assert_eq!(offered("clearway", &["plan", "--format", ""]), ["text", "json", "csv"]);
    assert_eq!(offered("plan", &["--sv"]), ["--svg", "--svg-mesh"]);
    // Files are offered by bash itself, as the script says.
    assert_eq!(offered("plan", &["recordings/"]), [""]);
    assert!(text(&clearway(&["completions", "bash", "plan"]).stdout).contains("-o default plan"));
    assert_eq!(offered("recorder", &["--compression", "z"]), ["zstd"]);
    assert_eq!(offered("planner", &["--met"]), ["--metrics"]);
    assert_eq!(offered("replay", &["reco"]), ["recover"]);
}

#[test]
fn every_shell_has_a_script_for_every_program() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        for program in PROGRAMS {
            let made = clearway(&["completions", shell, program]);
            assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
            assert!(text(&made.stdout).contains("help"), "{shell} {program}");
        }
    }
}

/// Formats a page with what is there: its text, and what was wrong with it.
fn read_page(page: &Path) -> Option<(String, String)> {
    let mandoc = Command::new("mandoc").args(["-T", "utf8", "-W", "warning"]).arg(page).output();
    if let Ok(read) = mandoc {
        return Some((text(&read.stdout), text(&read.stderr)));
    }
    let mut man = Command::new("man");
    man.args(["--warnings", "-l"]).arg(page).env("MANPAGER", "cat").env("MANROFFOPT", "-c");
    man.output().ok().map(|read| (text(&read.stdout), text(&read.stderr)))
}

#[test]
fn pages_can_be_read_without_warnings() {
    let folder = tempfile::tempdir().expect("there is room");
    let made = clearway(&["man", folder.path().to_str().expect("it is UTF-8")]);
    assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    let pages: Vec<_> = fs::read_dir(folder.path()).expect("it was made").collect();
    assert!(pages.len() > 25, "{pages:?}");
    for page in pages {
        let page = page.expect("it can be read").path();
        let Some((shown, wrong)) = read_page(&page) else {
            eprintln!("SKIPPED: neither mandoc nor man is there");
            return;
        };
        assert_eq!(wrong, "", "{}", page.display());
        // Bold is printed as letters struck twice.
        let plain: String = shown
            .split_inclusive('\u{8}')
            .map(|part| part.strip_suffix('\u{8}').map_or(part, |part| &part[..part.len() - 1]))
            .collect();
        let name = page.file_stem().and_then(|name| name.to_str()).expect("it is UTF-8");
        assert!(plain.contains(name) && plain.contains("SYNOPSIS"), "{plain}");
    }
    let (shown, _) = read_page(&folder.path().join("plan.1")).expect("it was read before");
    assert!(shown.contains("plan recordings/scenes/disassemble.json"), "{shown}");
}

#[test]
fn a_folder_that_cannot_be_written_is_a_failure() {
    let ended = clearway(&["man", "/dev/null/man"]);
    assert_eq!(ended.status.code(), Some(1));
    assert!(text(&ended.stderr).contains("clearway: can't write /dev/null/man"));
}
