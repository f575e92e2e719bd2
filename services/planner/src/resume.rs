//! Going on with a reply whose beginning was written before.

use std::cell::Cell;

use answer::{StopFlag, StopReason};
use schemas::convert::{CellWriter, PartSink};
use schemas::wire::ReplyHeader;

/// A sink that takes only what is not written yet: the same request gives the same parts.
#[derive(Debug)]
pub(crate) struct Resumed<'a, S> {
    pub(crate) sink: S,
    /// Parts that are written already, and not gone through again.
    pub(crate) left: &'a Cell<usize>,
}

impl<S: PartSink> PartSink for Resumed<'_, S> {
    type Error = S::Error;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), S::Error> {
        match self.left.get().checked_sub(1) {
            None => self.sink.part(header, cells, fill),
            Some(left) => {
                self.left.set(left);
                // Lists go on from where the part before has left them.
                fill(&mut CellWriter::new(&mut vec![0; cells]));
                Ok(())
            }
        }
    }
}

/// Passes the reason to stop on to `stop`, once the parts written before are gone through, which
/// takes a few milliseconds: only then it is known which answers are to be refused.
pub(crate) fn stop_after(left: &Cell<usize>, reason: StopReason, stop: &StopFlag) -> bool {
    let is_time = left.get() == 0 || reason == StopReason::ClientLeft;
    if is_time {
        stop.stop(reason);
    }
    is_time
}
