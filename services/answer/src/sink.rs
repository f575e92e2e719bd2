//! One type for every sink, so that planning is compiled once, in this crate: a generic sink
//! would have it compiled again in each crate that brings one.

use schemas::convert::{CellWriter, PartSink};
use schemas::wire::ReplyHeader;

/// The sink took no part; [`with_any_sink`] has its error.
#[derive(Debug)]
pub(crate) struct SinkFailed;

/// A sink behind a pointer.
pub(crate) struct AnySink<'a>(&'a mut dyn DynSink);

trait DynSink {
    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: &mut dyn FnMut(&mut CellWriter),
    ) -> Result<(), SinkFailed>;
}

/// A sink and the error that it returned.
struct Kept<'a, S: PartSink> {
    sink: &'a mut S,
    error: Option<S::Error>,
}

impl<S: PartSink> DynSink for Kept<'_, S> {
    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: &mut dyn FnMut(&mut CellWriter),
    ) -> Result<(), SinkFailed> {
        self.sink.part(header, cells, |writer| fill(writer)).map_err(|error| {
            self.error = Some(error);
            SinkFailed
        })
    }
}

impl PartSink for AnySink<'_> {
    type Error = SinkFailed;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), SinkFailed> {
        let mut fill = Some(fill);
        self.0.part(header, cells, &mut |writer| {
            if let Some(fill) = fill.take() {
                fill(writer);
            }
        })
    }
}

/// Writes to `sink` until it fails.
pub(crate) fn with_any_sink<S: PartSink>(
    sink: &mut S,
    write: impl FnOnce(&mut AnySink<'_>) -> Result<(), SinkFailed>,
) -> Result<(), S::Error> {
    let mut kept = Kept { sink, error: None };
    // Whoever writes passes the failure on; the error itself is here.
    let _ = write(&mut AnySink(&mut kept));
    kept.error.map_or(Ok(()), Err)
}
