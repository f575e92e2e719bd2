//! Command-line arguments.

use std::path::PathBuf;
use std::time::Duration;

use bus::Domain;
use clap::{Parser, ValueEnum};

/// Plans scenes and prints the replies, in order
#[derive(Debug, Parser)]
#[command(
    name = "plan",
    version = program::VERSION,
    after_help = "\
Examples:
  plan recordings/scenes/disassemble.json
  plan --map office.yaml drive-office.json
  plan --local --format json scene.json | jq .trajectories[0].length
  generate-scenes | plan --format csv - > samples.csv
  plan --wait 10s scene.json
  plan --list

stdin (`-`) holds JSON objects one after another, on one line each or spread over several; each
is answered as soon as it is complete. After invalid JSON, reading goes on at the next line that
is not indented. A stdin without a scene is an error.

A body or a solid can be a rectilinear mesh: {\"mesh\": \"part.stl\", \"unit\": \"mm\"} stands for the boxes
inside. The file is named from the scene's folder, or from the current one for stdin; the unit is m (the
default), mm or in.

CSV has a row for each sample, in SI units, with the columns
  scene,id,answer,t,x,y,z,heading,vx,vy,vz,yaw_rate
scene counts from 1, id is the scene's own (empty if it has none), answer counts from 0.
Refusals have no rows; they go to stderr.

Domains are found under CLEARWAY_ROOT; by default, under clearway in XDG_RUNTIME_DIR, or
/tmp/clearway-UID.

Results go to stdout, diagnostics to stderr.
Exit codes: 0 every scene has a trajectory, 1 a scene was refused or something failed, 2 usage,
129 SIGHUP, 130 SIGINT (Ctrl-C), 143 SIGTERM."
)]
pub(crate) struct Arguments {
    /// Scene files; `-` reads any number of scenes from stdin
    #[arg(required_unless_present_any = ["list", "status", "ping"], value_name = "SCENE.json")]
    pub(crate) scenes: Vec<PathBuf>,
    /// List this user's domains: planner, clients, recorders, and where their files are
    #[arg(long, conflicts_with_all = [
        "scenes", "domain", "map", "local", "svg", "overwrite", "timeout", "wait",
    ])]
    pub(crate) list: bool,
    /// Print what the planner says of itself: requests, refusals, queue, workers, cache, latency
    #[arg(long, conflicts_with_all = ["scenes", "list", "ping", "map", "local", "svg", "overwrite"])]
    pub(crate) status: bool,
    /// Ask the planner for a small trajectory ten times, and print how long that takes
    #[arg(long, conflicts_with_all = ["scenes", "list", "map", "local", "svg", "overwrite"])]
    pub(crate) ping: bool,
    /// The planner's domain
    #[arg(long, value_name = "NAME")]
    pub(crate) domain: Option<Domain>,
    /// How long to wait for a planner to start
    #[arg(
        long,
        value_name = "TIME",
        default_value = "0s",
        value_parser = program::time,
        conflicts_with = "local"
    )]
    pub(crate) wait: Duration,
    /// Floor plan in the ROS map server's format: the free space of every scene, which then
    /// must not have its own
    #[arg(long, value_name = "FILE.yaml")]
    pub(crate) map: Option<PathBuf>,
    /// What the floor plan's unknown cells are
    #[arg(long, value_enum, value_name = "STATE", default_value_t = Unknown::Occupied, requires = "map")]
    pub(crate) unknown: Unknown,
    /// Plan in this process, without a planner; the replies are the same
    #[arg(long)]
    pub(crate) local: bool,
    /// The planner's configuration: its table `caps` bounds what a request may cost; other settings
    /// don't change replies
    #[arg(long, value_name = "FILE", requires = "local")]
    pub(crate) config: Option<PathBuf>,
    /// Print tables, one JSON object per line, or rows of samples
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
    /// Draw each scene with its answers; of several scenes, all but the first get a number:
    /// FILE.svg, FILE-2.svg, ...
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) svg: Option<PathBuf>,
    /// Draw the channels that the planner made in floor plans, too
    #[arg(long, requires = "svg")]
    pub(crate) svg_mesh: bool,
    /// Replace existing files
    #[arg(long)]
    pub(crate) overwrite: bool,
    /// How long to wait for each reply
    #[arg(
        long,
        value_name = "TIME",
        default_value = "10s",
        value_parser = program::time,
        conflicts_with = "local"
    )]
    pub(crate) timeout: Duration,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    Text,
    Json,
    Csv,
}

/// What `--unknown` says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Unknown {
    Occupied,
    Free,
}

impl From<Unknown> for floor_plan::UnknownCells {
    fn from(unknown: Unknown) -> Self {
        match unknown {
            Unknown::Occupied => Self::Occupied,
            Unknown::Free => Self::Free,
        }
    }
}
