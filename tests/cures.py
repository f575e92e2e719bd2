#!/usr/bin/env python3
"""Takes each cure of a hazard of iceoryx2 away, and tells whether its test fails then.

    tests/cures.py [NAME...]      # a minute or more each; exit code 1 if a test passes without its cure
    tests/cures.py --list         # the table of docs/upstream.md

Works in this working tree, whose files must be committed, and puts them back.
"""

import argparse
import itertools
import os
import pathlib
import signal
import subprocess
import sys

ROOT = pathlib.Path(__file__).parents[1]
BUS = "services/bus/src/"

# Where tests are: what cargo is to build.
LIBRARY = ["-p", "clearway-bus", "--lib"]
TESTS = ["-p", "clearway-bus", "--test", "bus"]
SYSTEM = ["--workspace", "--test", "system"]  # its programs have the features of the whole workspace

# Name; the hazard; the cure; what is changed: file, text, other text; where the test is, and its name.
CURES = [
    (
        "key",
        "a reply reaches a later client in the same place",
        "client and number of the request in every header, compared",
        [(BUS + "client/pending.rs", "        self.key == RequestKey {", "        true || self.key == RequestKey {")],
        LIBRARY,
        "a_reply_to_an_earlier_client_is_dropped",
    ),
    (
        "first-id",
        "the same, and its end",
        "a random number of request ids is used up at the start",
        [(BUS + "client.rs", "for _ in 0..nonce % FIRST_IDS {", "for _ in 0..nonce % FIRST_IDS * 0 {")],
        LIBRARY,
        "different_first_ids_keep_it_from_arriving",
    ),
    (
        "wake-up",
        "a wake-up is slept over",
        "rings are taken until there are none, then a last look, then sleep",
        [
            (BUS + "wait.rs", "    silence(bell);\n    for most in [NAP, NET] {", "    for most in [NET] {"),
            (BUS + "wait.rs", "        if rung {\n", "        if rung {\n            let _ = bell.try_wait(|_| {});\n"),
        ],
        LIBRARY,
        "no_wake_up_is_slept_over",
    ),
    (
        "nap",
        "a bell counts as rung while nothing can be read: it wakes nobody",
        "the first sleep is a short one",
        [(BUS + "wait.rs", "for most in [NAP, NET] {", "for most in [NET] {")],
        LIBRARY,
        "a_bell_that_counts_as_rung_is_not_slept_on",
    ),
    (
        "send",
        "a client that reads nothing blocks the server",
        "sending never waits: what finds no room is kept and tried again",
        [(BUS + "ports.rs", "BackpressureAction::DiscardDataAndFail", "BackpressureAction::Retry")],
        TESTS,
        "a_client_that_takes_nothing_holds_nobody_up",
    ),
    (
        "closed",
        "parts to a client that has left vanish silently",
        "the connection is looked at before each part",
        [(BUS + "server/reply.rs", "if !self.active.is_connected() {", "if false {")],
        LIBRARY,
        "a_client_that_has_left_is_not_written_to",
    ),
    (
        "death",
        "a connection to a killed server stays open",
        "who waits clears the dead away",
        [(BUS + "client/pending.rs", "self.connection.node.sweep();", "();")],
        TESTS,
        "a_call_notices_within_its_limit_that_the_planner_was_killed",
    ),
    (
        "second",
        "several servers all get every request",
        "one server only",
        [(BUS + "ports.rs", ".max_servers(1)", ".max_servers(2)")],
        TESTS,
        "a_second_planner_is_refused",
    ),
    (
        "tap",
        "a recorder that hangs blocks the server",
        "the tap overwrites its oldest messages, and numbers them",
        [(BUS + "ports.rs", "        .enable_safe_overflow(true)\n        .max_publishers(1)\n        .max_subscribers(options.max_recorders)", "        .enable_safe_overflow(false)\n        .max_publishers(1)\n        .max_subscribers(options.max_recorders)")],
        TESTS,
        "a_recorder_that_hangs_slows_nobody",
    ),
    (
        "heartbeat",
        "a loss at the end of the tap does not show",
        "a heartbeat with the next number",
        [(BUS + "tap.rs", "let is_due = self.listened_to();", "let is_due = false;")],
        TESTS,
        "the_heartbeat_shows_a_loss_at_the_end",
    ),
    (
        "signals",
        "SIGTERM is forgotten by the library's handler, or ends the process with its files",
        "signal-hook, a flag that stays",
        [(BUS + "wait.rs", "for signal in [SIGINT, SIGTERM, SIGHUP] {", "for signal in [SIGINT, SIGHUP] {")],
        TESTS,
        "signals_end_a_planner_and_nothing_is_left",
    ),
    (
        "layout",
        "the same name and size with other fields connects silently",
        "a hash of the layout in the type's name",
        [(BUS + "headers.rs", '"clearway::{}#{:016x}", $name, $hash', '"clearway::{}#{:016x}", $name, $hash - $hash')],
        TESTS,
        "a_client_of_another_layout_does_not_connect",
    ),
    (
        "remains",
        "programs that are killed while they start leave files for ever",
        "locks say who lives; the living remove what the dead made",
        [(BUS + "janitor.rs", "for name in site::names(directory) {", "for name in site::names(directory).take(0) {")],
        TESTS,
        "what_killed_clients_leave_is_removed_by_the_living",
    ),
    (
        "farewell",
        "requests whose client leaves before they are taken keep its memory for ever",
        "who leaves waits until the planner, whichever serves by then, has taken them",
        [(BUS + "client.rs", "if !self.dropped.load(Ordering::Relaxed) {", "if true {")],
        TESTS,
        "a_client_leaves_nothing_at_a_planner_that_took_over",
    ),
    (
        "dead",
        "the same for clients that die",
        "the planner takes their requests before it clears them away",
        [(BUS + "server.rs", "self.node.sweep_after(|| self.inbox.take_all());", "self.node.sweep_after(|| {});")],
        TESTS,
        "a_client_killed_before_its_request_is_taken_leaves_nothing",
    ),
    (
        "held",
        "what is held of a client that has left may be lost track of",
        "clients are told that they may leave when what they dropped is dropped by the planner, too",
        [(BUS + "server/inbox.rs", "self.farewells.push(active);", "drop(active);")],
        TESTS,
        "a_client_leaves_when_nothing_of_it_is_held",
    ),
    (
        "lost",
        "clients that leave while the planner is held up are never given back, all the same",
        "where there are many, the planner opens its ports anew",
        [(BUS + "server.rs", "if before.min(lost) < enough {", "if true {")],
        TESTS,
        "clients_that_leave_unseen_do_not_wear_a_planner_out",
    ),
    (
        "turns",
        "clients are served in the order of their places: the last may starve",
        "under load, all requests that wait are taken before the next is answered",
        [(BUS + "server/inbox.rs", "if self.backlog.is_empty() && self.busy {", "if false {")],
        TESTS,
        "a_client_that_keeps_asking_starves_nobody",
    ),
    (
        "umask",
        "binding a socket changes the umask of the whole process for a moment",
        "directories get their mode explicitly",
        [(BUS + "root.rs", "directory.set_permissions(Permissions::from_mode(0o700))?;", "();")],
        LIBRARY,
        "a_directory_made_under_a_narrow_umask_is_opened_to_its_owner",
    ),
    (
        "log",
        "a warning of 10 kB",
        "texts are cut",
        [(BUS + "log.rs", "let room = self.1 - self.0.len();", "let room = text.len();")],
        LIBRARY,
        "long_texts_are_cut",
    ),
    (
        "count",
        "a false count of elements is a SIGSEGV",
        "what lies beyond the first segment is copied by the system, which reports a fault",
        [(BUS + "server/copy.rs", "if payload.len() <= SURE {", "if payload.len() <= usize::MAX {")],
        SYSTEM,
        "a_false_count_of_elements_is_refused_without_harm",
    ),
]


def changed(changes):
    """Changes the files, and gives what they were."""
    before = {}
    for name, text, other in changes:
        path = ROOT / name
        content = path.read_text()
        before.setdefault(path, content)
        if text not in content:
            raise SystemExit(f"{name} no longer has {text!r}")
        path.write_text(content.replace(text, other))
    return before


def run(tests, test):
    environment = os.environ | {"BUS_STRESS": "60", "RUST_BACKTRACE": "0"}
    build = ["cargo", "test", "--quiet", *tests, "--no-run"]
    built = subprocess.run(build, cwd=ROOT, env=environment, capture_output=True, text=True)
    if built.returncode != 0:
        return "does not build:\n" + built.stderr
    # The test itself is a child of cargo, and has children.
    command = ["cargo", "test", "--quiet", *tests, "--", test]
    with subprocess.Popen(
        command,
        cwd=ROOT,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    ) as running:
        try:
            said, _ = running.communicate(timeout=180)
        except subprocess.TimeoutExpired:
            return "failed: it hangs"
        finally:
            if running.returncode is None:
                os.killpg(running.pid, signal.SIGKILL)
    # Filters that match nothing pass.
    if running.returncode == 0:
        return "passed" if " 1 passed" in said else "there is no such test"
    return "failed: " + reason(said)


def reason(said):
    """What the test said first of its failure."""
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    after = [line for before, line in itertools.pairwise(lines) if "panicked at" in before]
    return (after or lines)[0]


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("names", nargs="*", choices=[cure[0] for cure in CURES] + [[]])
    arguments.add_argument("--list", action="store_true", help="print the table")
    arguments = arguments.parse_args()
    if arguments.list:
        for name, hazard, cure, _, _, test in CURES:
            print(f"| `{name}` | {hazard} | {cure} | `{test}` |")
        return
    dirty = subprocess.run(["git", "status", "--porcelain", BUS], cwd=ROOT, capture_output=True, text=True).stdout
    if dirty:
        raise SystemExit(f"not committed:\n{dirty}")
    useless = 0
    for name, _, _, changes, tests, test in CURES:
        if arguments.names and name not in arguments.names:
            continue
        before = changed(changes)
        try:
            result = run(tests, test)
        finally:
            for path, content in before.items():
                path.write_text(content)
        useless += not result.startswith("failed")
        print(f"without {name}: {test} {result}", flush=True)
    sys.exit(1 if useless else 0)


if __name__ == "__main__":
    main()
