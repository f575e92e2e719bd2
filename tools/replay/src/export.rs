//! `replay export`: recordings for viewers and other programs.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use comparison::describe::counted;
use comparison::exchanges::Asked;
use comparison::named::NamedFreeSpaces;
use program::warn;
use recording::{ForeignChannel, ForeignChannelId, Options, Writer};
use render::csv;
use schemas::message::{Reply, Request, RequestContent, SceneRequest};
use viewing::{Shown, TopicSchema, ViewMessage, ViewOptions};

use crate::arguments::Export;
use crate::copying::{self, Messages, Picked};
use crate::findings::Findings;
use crate::output::{self, OutputError};
use crate::reading;

/// Runs the command; the inner result is that of printing.
pub(crate) fn run(
    arguments: &Export,
    findings: &mut Findings,
    out: &mut impl Write,
) -> Result<io::Result<()>, Box<dyn Error>> {
    let outputs = [&arguments.output, &arguments.csv, &arguments.ros];
    let outputs: Vec<&Path> = outputs.into_iter().flatten().map(PathBuf::as_path).collect();
    for (index, path) in outputs.iter().enumerate() {
        output::check(path, arguments.overwrite, &[&arguments.file])?;
        if outputs[..index].contains(path) {
            return Err(format!("{} is to be written twice", path.display()).into());
        }
    }
    // What is wrong with the recording is told once, by the second reading.
    let copied = arguments.output.as_deref().map(|to| copy(arguments, to)).transpose()?.flatten();
    let begun = arguments.output.as_deref().filter(|_| copied.is_some());
    match Exported::all(arguments, copied, findings) {
        Ok(Some(exported)) => exported.finish(arguments, out),
        Ok(None) => {
            warn(format_args!(
                "replay: {} has no such request with a reply; nothing written",
                arguments.file.display()
            ));
            findings.failure = true;
            begun.into_iter().for_each(copying::discard);
            Ok(Ok(()))
        }
        Err(error) => {
            begun.into_iter().for_each(copying::discard);
            Err(error)
        }
    }
}

fn is_wanted(arguments: &Export, index: u64, request: &Request) -> bool {
    let Export { request: numbers, id, task, .. } = arguments;
    let scene = match &request.content {
        RequestContent::Scene(scene) => Some(scene),
        RequestContent::Unreadable { .. } => None,
    };
    let its_id = scene.and_then(|scene| scene.id);
    let its_task = scene.map(|scene| scene.task);
    (numbers.is_empty() || numbers.contains(&index))
        && (id.is_empty() || its_id.is_some_and(|its| id.contains(&its)))
        && (task.is_empty() || its_task.is_some_and(|its| task.contains(&its)))
}

/// Copies the messages of the requests that are wanted; `None` if there are none.
fn copy(arguments: &Export, to: &Path) -> Result<Option<Writer>, Box<dyn Error>> {
    let Export { file, request, id, task, overwrite, .. } = arguments;
    let is_whole = request.is_empty() && id.is_empty() && task.is_empty();
    let named = |error| format!("{}: {error}", file.display());
    let mut messages = Messages::open(file).map_err(named)?;
    let wanted = |index: u64, request: &Request| is_wanted(arguments, index, request);
    let mut picked = Picked::new(&wanted);
    let mut writer: Option<Writer> = None;
    while let Some((record, lost)) = messages.next() {
        let asides = messages.asides();
        let mut record = Some(record);
        if !is_whole {
            // They bring the free spaces that they name.
            picked.learn(asides.clone());
            record = record.and_then(|record| picked.pick(record));
        }
        let Some(record) = record else { continue };
        let writer = match &mut writer {
            Some(writer) => writer,
            empty => {
                let (overwrite, compression) = (*overwrite, messages.compression());
                let description = messages.description();
                let options = Options { overwrite, compression, description, ..Options::default() };
                empty.insert(Writer::create(to, options)?)
            }
        };
        if is_whole {
            writer.lost(lost);
            asides.iter().try_for_each(|aside| writer.write_aside(aside))?;
        }
        copying::write(writer, &record)?;
    }
    if let Some(writer) = writer.as_mut().filter(|_| is_whole) {
        messages.asides().iter().try_for_each(|aside| writer.write_aside(aside))?;
        writer.lost(messages.lost_at_end());
    }
    Ok(writer)
}

/// What is being written.
struct Exported<'a> {
    arguments: &'a Export,
    options: ViewOptions,
    view: Option<View>,
    csv: Option<BufWriter<File>>,
    ros: Option<BufWriter<File>>,
    requests: u64,
    samples: u64,
    motions: u64,
    /// When the last motion ends; nanoseconds since the Unix epoch.
    end_ns: u64,
    /// Requests whose motions begin before that.
    overlapping: u64,
}

/// A recording with messages for viewers.
struct View {
    writer: Writer,
    channels: BTreeMap<String, ForeignChannelId>,
    messages: u64,
}

impl<'a> Exported<'a> {
    /// Writes all that is wanted; `None` if that is nothing.
    fn all(
        arguments: &'a Export,
        copied: Option<Writer>,
        findings: &mut Findings,
    ) -> Result<Option<Self>, Box<dyn Error>> {
        let mut exported: Option<Self> = None;
        let view = |writer| View { writer, channels: BTreeMap::new(), messages: 0 };
        let mut view = copied.map(view);
        let mut named = NamedFreeSpaces::default();
        let mut failed: Option<Box<dyn Error>> = None;
        reading::whole(&arguments.file, findings, |mut asked| {
            asked.uploads.iter_mut().for_each(|upload| named.resolve(upload));
            named.resolve(&mut asked.request);
            let Asked { index, request, reply: Some(reply), replied_ns: Some(replied_ns), .. } =
                &asked
            else {
                return ControlFlow::Continue(());
            };
            if !is_wanted(arguments, *index, request) {
                return ControlFlow::Continue(());
            }
            let none = SceneRequest::empty();
            let scene = match &request.content {
                RequestContent::Scene(scene) => scene,
                RequestContent::Unreadable { .. } => &none,
            };
            let exported = match &mut exported {
                Some(exported) => Ok(exported),
                empty => Self::begin(arguments, view.take()).map(|new| empty.insert(new)),
            };
            let took = replied_ns.checked_sub(request.sent_ns).map(|ns| ns as f64 * 1e-9);
            let times = (*replied_ns, took);
            let done = exported.map_err(Into::into);
            match done.and_then(|exported| exported.add(*index, scene, reply, times)) {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    failed = Some(error);
                    ControlFlow::Break(())
                }
            }
        });
        failed.map_or(Ok(exported), Err)
    }

    fn begin(arguments: &'a Export, view: Option<View>) -> Result<Self, OutputError> {
        let create = |path: &Option<PathBuf>| {
            let path = path.as_deref();
            path.map(|path| output::create(path, arguments.overwrite).map(BufWriter::new))
                .transpose()
        };
        let mut csv = create(&arguments.csv)?;
        if let (Some(file), Some(path)) = (&mut csv, &arguments.csv) {
            writeln!(file, "{}", csv::HEADER).map_err(|cause| OutputError::write(path, cause))?;
        }
        let options = ViewOptions { frame: arguments.frame.clone(), grid: arguments.grid };
        let ros = create(&arguments.ros)?;
        let (requests, samples, motions, end_ns, overlapping) = (0, 0, 0, 0, 0);
        Ok(Self {
            arguments,
            options,
            view,
            csv,
            ros,
            requests,
            samples,
            motions,
            end_ns,
            overlapping,
        })
    }

    /// Adds a request with its reply, when that was sent, and how long it took.
    fn add(
        &mut self,
        index: u64,
        scene: &SceneRequest,
        reply: &Reply,
        (replied_ns, planning_time): (u64, Option<f64>),
    ) -> Result<(), Box<dyn Error>> {
        let begin_ns = match self.arguments.apart {
            true => replied_ns.max(self.end_ns),
            false => replied_ns,
        };
        let shown = Shown { index, scene, reply, begin_ns, planning_time };
        self.overlapping += u64::from(begin_ns < self.end_ns);
        self.end_ns = self.end_ns.max(begin_ns.saturating_add(shown.duration_ns()));
        self.requests += 1;
        if let Some(view) = &mut self.view {
            for message in viewing::messages(&shown, &self.options)? {
                view.write(&message)?;
            }
        }
        if let (Some(file), Some(path)) = (&mut self.csv, &self.arguments.csv) {
            let number = usize::try_from(index)?;
            csv::write(file, number, scene, reply)
                .map_err(|cause| OutputError::write(path, cause))?;
            let motions = reply.answers.iter().flatten().flatten();
            self.samples += motions.map(|motion| motion.samples.len() as u64).sum::<u64>();
        }
        if let (Some(file), Some(path)) = (&mut self.ros, &self.arguments.ros) {
            for motion in viewing::ros_answers(&shown, &self.options.frame) {
                writeln!(file, "{motion}").map_err(|cause| OutputError::write(path, cause))?;
                self.motions += 1;
            }
        }
        Ok(())
    }

    /// Ends the files and prints what is in them; the inner result is that of printing.
    fn finish(
        self,
        arguments: &Export,
        out: &mut impl Write,
    ) -> Result<io::Result<()>, Box<dyn Error>> {
        let Self { view, csv, ros, requests, samples, motions, overlapping, .. } = self;
        if overlapping > 0 && view.is_some() {
            warn(format_args!(
                "replay: the motions of {} begin before those before them have ended; --apart shows \
                 one after the other",
                counted(overlapping, "request")
            ));
        }
        let mut lines = Vec::new();
        if let (Some(View { writer, messages, .. }), Some(path)) = (view, &arguments.output) {
            writer.finish()?;
            let path = path.display();
            let messages = counted(messages, "message");
            lines.push(format!("{path}: {}, {messages} for viewers", counted(requests, "request")));
        }
        let files = [
            (csv, &arguments.csv, counted(samples, "sample")),
            (ros, &arguments.ros, counted(motions, "motion")),
        ];
        for (file, path, holds) in files {
            if let (Some(mut file), Some(path)) = (file, path) {
                file.flush().map_err(|cause| OutputError::write(path, cause))?;
                let requests = counted(requests, "request");
                lines.push(format!("{}: {requests}, {holds}", path.display()));
            }
        }
        Ok(lines.iter().try_for_each(|line| writeln!(out, "{line}")))
    }
}

impl View {
    fn write(&mut self, message: &ViewMessage) -> Result<(), recording::WriteError> {
        let ViewMessage { topic, kind, log_ns, bytes } = message;
        let channel = match self.channels.get(topic) {
            Some(channel) => *channel,
            None => {
                let TopicSchema { name, encoding, data, messages } = kind.schema();
                let channel = ForeignChannel {
                    topic,
                    encoding: &messages,
                    schema: &name,
                    schema_encoding: &encoding,
                    schema_data: &data,
                };
                let channel = self.writer.add_channel(&channel)?;
                *self.channels.entry(topic.clone()).or_insert(channel)
            }
        };
        self.messages += 1;
        self.writer.write_foreign(channel, bytes, *log_ns)
    }
}
