//! The version before the current one, [`wire::previous`], as a planner serves it.
//!
//! Serving it costs the current version nothing but a look at a second queue. To stop, delete
//! this file and what the compiler then points at.

use schemas::wire::{self, previous};

use crate::headers::{Version, header, type_name};

header!(
    /// [`previous::RequestHeader`]
    RequestHeader,
    previous::RequestHeader,
    type_name!("RequestHeader", previous::LAYOUT_HASH)
);
header!(
    /// [`previous::ReplyHeader`]
    ReplyHeader,
    previous::ReplyHeader,
    type_name!("ReplyHeader", previous::LAYOUT_HASH)
);

/// The version of [`previous`].
#[derive(Debug)]
pub(crate) struct Previous;

impl Version for Previous {
    const PLAN: &'static str = previous::PLAN;
    type Request = RequestHeader;
    type Reply = ReplyHeader;

    fn upgrade(header: &previous::RequestHeader) -> wire::RequestHeader {
        previous::upgrade_request(header)
    }
}
