//! Requests as they lie in shared memory or in a recording, up to their replies.

use std::cell::RefCell;
use std::convert::Infallible;

use answer::Workspace;
use schemas::codec;
use schemas::convert::{self, CellWriter, PartSink};
use schemas::message::{Reply, ReplyAssembler, ReplyPart, Request, RequestContent, RequestKey};
use schemas::wire::{ReplyHeader, RequestHeader};

use crate::limits::small_caps;
use crate::memory::split;
use crate::reply::check_reply;

thread_local! {
    /// A planner's memory, which outlives its requests.
    static WORKSPACE: RefCell<Workspace> = RefCell::new(Workspace::new(small_caps(), 1 << 20));
}

/// A request's header, then its cells.
pub fn border(bytes: &[u8]) {
    let (header, cells) = split(bytes, size_of::<RequestHeader>());
    let header: RequestHeader = bytemuck::pod_read_unaligned(&header);
    let cells: Vec<u64> = bytemuck::pod_collect_to_vec(&cells);
    let header_words: Vec<u64> = bytemuck::pod_collect_to_vec(bytemuck::bytes_of(&header));
    let key = RequestKey { client: header.client, sequence: header.sequence };
    let content = RequestContent::Unreadable { header: header_words, cells: cells.clone() };
    let alone = answer::reply_to(&Request { key, sent_ns: header.sent_ns, content }, &small_caps());
    check_reply(&alone);
    let mut collect = Collect::default();
    WORKSPACE.with_borrow_mut(|workspace| {
        let Ok(()) = workspace.answer(&header, &cells, &answer::StopFlag::new(), &mut collect);
    });
    let served = collect.reply.expect("the last part says that it is the last");
    check_same("the requests before it", &alone, &served);
    // What the recorder makes of it replays the same.
    let recorded = convert::read_request(&header, &cells);
    let replayed = answer::reply_to(&recorded, &small_caps());
    check_same("recording it", &alone, &replayed);
}

/// A message of a recording: 0 and a request, or anything else and a part of a reply.
pub fn message(bytes: &[u8]) {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    if *kind == 0 {
        let Ok(request) = codec::decode::<Request>(bytes) else { return };
        let again = codec::encode(&request);
        let back = codec::decode::<Request>(&again).expect("what was written can be read");
        assert_eq!(codec::encode(&back), again);
        check_reply(&answer::reply_to(&request, &small_caps()));
    } else {
        let Ok(part) = codec::decode::<ReplyPart>(bytes) else { return };
        let again = codec::encode(&part);
        let back = codec::decode::<ReplyPart>(&again).expect("what was written can be read");
        assert_eq!(codec::encode(&back), again);
        let _ = ReplyAssembler::default().push(part);
    }
}

fn check_same(cause: &str, alone: &Reply, other: &Reply) {
    // Equal NaNs are not equal as numbers, but as text.
    let same = alone == other || format!("{alone:?}") == format!("{other:?}");
    assert!(same, "{cause} changed the reply:\n{alone:?}\n{other:?}");
}

/// Takes the parts of a reply as a client would.
#[derive(Default)]
struct Collect {
    assembler: ReplyAssembler,
    cells: Vec<u64>,
    reply: Option<Reply>,
}

impl PartSink for Collect {
    type Error = Infallible;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Infallible> {
        self.cells.clear();
        self.cells.resize(cells, 0);
        fill(&mut CellWriter::new(&mut self.cells));
        let part = convert::read_part(header, &self.cells).expect("clients can read it");
        assert!(self.reply.is_none(), "a part after the last one");
        self.reply = self.assembler.push(part).expect("the parts are in order");
        Ok(())
    }
}
