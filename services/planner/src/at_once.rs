//! Replies that the sequencer writes itself, as long as that is quick.

use answer::{StopFlag, StopReason};
use bus::{ReplyError, ReplySink};
use schemas::convert::{CellWriter, PartSink};
use schemas::wire::ReplyHeader;

use crate::statistics::Counted;

/// A reply that is written at once, as long as it is not handed over.
pub(crate) struct Sink<'a, F> {
    pub(crate) sink: Counted<'a, ReplySink<'a>>,
    pub(crate) stop: &'a StopFlag,
    pub(crate) meanwhile: &'a F,
}

/// Why it is not written at once.
pub(crate) enum Ended {
    HandedOver,
    Failed(ReplyError),
}

impl<F: Fn()> PartSink for Sink<'_, F> {
    type Error = Ended;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Ended> {
        // Long replies take long to write.
        if self.sink.sink.written() > 0 {
            (self.meanwhile)();
        }
        if self.stop.reason() == Some(StopReason::HandedOver) {
            return Err(Ended::HandedOver);
        }
        self.sink.part(header, cells, fill).map_err(Ended::Failed)
    }
}
