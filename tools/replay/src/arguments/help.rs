//! Examples and explanations below the options.

/// What all commands share.
macro_rules! exit_codes {
    ($done:literal, $failure:literal, $others:literal) => {
        concat!(
            "\
Results go to stdout, diagnostics to stderr.
Exit codes:
  0  ",
            $done,
            "
  1  failure: a file can't be read",
            $failure,
            "
  2  usage: wrong arguments
  3  data was lost: the recorder missed messages, a request lacks its whole reply or a reply
     its request, or the recording is cut off (its recorder was killed); `recover`: something is
     missing, or was kept without a checksum
",
            $others
        )
    };
}

pub(super) const EXIT_CODES: &str = exit_codes!(
    "done; all replies compared are equal",
    " or is damaged, or there was nothing to compare",
    "  4  regression: replies differ
  129, 130, 143  a signal came (SIGHUP, SIGINT, SIGTERM) while a planner was asked
If several apply, the first of 4, 1, 3 counts."
);

/// Of commands that compare nothing.
pub(super) const COPY_EXIT_CODES: &str =
    exit_codes!("done", ", is damaged or can't be written", "If both apply, 1 counts.");

pub(super) const EXAMPLES: &str = "\
Examples:
  replay check recordings/              check all *.mcap in a folder and below
  replay check run.mcap --tolerance 1e-9
  replay check recordings/ --format junit > report.xml
  replay info run.mcap --format json
  replay show run.mcap --task drive --where 'clearance<0.1'
  replay show run.mcap --request 3 | plan -
  replay diff before.mcap after.mcap
  replay bless recordings/ --only moved
  replay extract run.mcap --failing -o failing.mcap
  replay export run.mcap -o view.mcap   for Foxglove, Lichtblick, rerun
  replay recover killed.mcap.part -o whole.mcap
";

pub(super) const COMPARED: &str = "\
Codes, fields and numbers are compared. Messages are for people: replies whose refusals are
only worded differently are equal, and counted. Replies that depend on load (too late,
overloaded) are not compared.
";

pub(super) const CHECKED: &str = "\
Examples:
  replay check recordings/                         all *.mcap in a folder and below
  replay check run.mcap --tolerance position=1mm,heading=0.1deg,time=1ms
  replay check run.mcap --with limits.speed=0.8    what another speed would change
  replay check recordings/ --format junit > report.xml
  replay check recordings/ --html report.html
  replay check recordings/ --via-bus               what the running planner replies
";

pub(super) const PAIRED: &str = "\
Requests are paired by the ids of their scenes. Those without id are paired if they are equal, or
else by their order within their client: the first client to appear in A is the first of B. Of
several with the same id, the n-th belongs to the n-th.
";

pub(super) const TOLERANCES: &str = "\
Tolerances: a number for everything, in metres, radians and seconds, or a list of
  position (m, mm, um), heading (rad, deg), time (s, ms), length, clearance, gap (m, mm),
  speed (m/s, mm/s), yaw_rate (rad/s, deg/s), refusal (numbers of refusals, no unit)
What is not listed must be equal bit for bit. For points and velocities, the distance counts. The
file replay.toml beside a recording says the same, for what the command line does not:
  [tolerance]
  position = \"1mm\"
";

pub(super) const BLESSED: &str = "\
Examples:
  replay bless recordings/
  replay bless recordings/ --only moved --only id=7

Every reply that is not equal bit for bit is accepted, or of these those that --only names. Requests
and other replies stay byte for byte; a recording of an older version becomes one of the newest. A
recording is replaced only if git has it as it is, unless --uncommitted says that it may be lost.
";

pub(super) const EXTRACTED: &str = "\
Examples:
  replay extract run.mcap --failing -o failing.mcap
  replay extract run.mcap --request 3 --id 17 -o some.mcap

A request for a free space by its name alone gets the free space, so that it can be planned alone.
";

pub(super) const MERGED: &str = "\
Example:
  replay merge monday.mcap tuesday.mcap -o week.mcap

A request that is in two of them is an error: its replies could not be told apart.
";

pub(super) const PLAYED: &str = "\
Examples:
  replay play run.mcap                        as it was
  replay play run.mcap --rate 2 --loop        twice as fast, until Ctrl-C
  replay play run.mcap --rate max --clients 8

Each client sends all requests, in the order of the file and at their recorded times; one whose
reply takes longer sends the next late. Replies are not compared: replay check --via-bus does that.
";

pub(super) const SHOWN: &str = "\
Examples:
  replay show run.mcap
  replay show run.mcap --error --task drive
  replay show run.mcap --where 'clearance<0.1' --where 'took>=50ms'
  replay show run.mcap --request 3 | plan -
  replay show run.mcap --reply 3 --format csv > samples.csv
  replay show run.mcap --request 3 --svg scene.svg

There is a row for each answer. Numbers that --where compares:
  request           of the request, from 0, in the order of the file
  id                of the scene
  answer            of the answer to its request, from 0
  length, clearance, free_clearance, bound
                    metres, or with a unit: 5mm
  duration, took    seconds, or with a unit: 50ms. took is the time from sending the request
                    to sending the last part of the reply
  legs, samples     how many
An answer that has no such number is not listed. Operators: < <= > >= = !=

A request for a free space by its name alone is printed with the free space, if the recording has
it. A free-standing scene gives the same reply.
";

pub(super) const EXPORTED: &str = "\
Examples:
  replay export run.mcap -o view.mcap              for Foxglove, Lichtblick and rerun
  replay export run.mcap -o view.mcap --apart      one motion after the other
  replay export run.mcap -o view.mcap --grid 5cm   and walls as floor plans
  replay export run.mcap --csv samples.csv --ros answers.jsonl --task drive

OUT.mcap has the recorded messages, and for each request that has its reply:
  /viewing/scene        foxglove.SceneUpdate: walls, channels, bodies, paths, least clearances
  /viewing/grid         foxglove.Grid, with --grid, of scenes in two dimensions: occupied is 1 or 0
  /viewing/request      JSON: planning time, and each answer's outcome, length, clearance
  /viewing/N/path       foxglove.PosesInFrame: the samples of answer N
  /viewing/N/motion     JSON at each sample: speed, heading, yaw rate, clearance of its leg
  /viewing/transforms   foxglove.FrameTransforms at each sample: the frame body/N
Motions begin when their reply was sent, or with --apart not before the one before has ended.
The file is a recording still, for replay check too.
";
