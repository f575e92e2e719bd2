//! The messages' headers as iceoryx2 sees them, in each version served.
//!
//! A type name carries the layout's hash: the same name and size with other fields would
//! connect silently.

use std::fmt::Debug;

use iceoryx2::prelude::ZeroCopySend;
use schemas::{topic, wire};

/// A version of the messages that the planner serves.
pub(crate) trait Version: Debug + 'static {
    /// The name of its service.
    const PLAN: &'static str;
    type Request: UserHeader;
    type Reply: UserHeader;

    /// A request's header in the current version.
    fn upgrade(header: &<Self::Request as UserHeader>::Plain) -> wire::RequestHeader;
}

/// A header and what it holds.
pub(crate) trait UserHeader: Debug + Default + ZeroCopySend + 'static {
    type Plain;

    fn plain(&self) -> &Self::Plain;
    fn set(&mut self, plain: Self::Plain);
}

macro_rules! header {
    ($(#[$doc:meta])* $name:ident, $plain:ty, $type_name:expr) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, Default)]
        #[repr(transparent)]
        pub(crate) struct $name($plain);

        impl crate::headers::UserHeader for $name {
            type Plain = $plain;

            fn plain(&self) -> &$plain {
                &self.0
            }

            fn set(&mut self, plain: $plain) {
                self.0 = plain;
            }
        }

        #[expect(unsafe_code, reason = "vouches for plain memory: repr(C), no pointers, Pod")]
        // SAFETY: a transparent wrapper of a `Pod` type that is `repr(C)`.
        unsafe impl iceoryx2::prelude::ZeroCopySend for $name {
            unsafe fn type_name() -> &'static str {
                $type_name
            }
        }
    };
}

pub(crate) use header;

/// The type name of a header in a layout.
macro_rules! type_name {
    ($name:literal, $hash:expr) => {{
        static NAME: std::sync::LazyLock<String> =
            std::sync::LazyLock::new(|| format!("clearway::{}#{:016x}", $name, $hash));
        &NAME
    }};
}

pub(crate) use type_name;

header!(
    /// [`wire::RequestHeader`]
    RequestHeader,
    wire::RequestHeader,
    type_name!("RequestHeader", wire::layout_hash())
);
header!(
    /// [`wire::ReplyHeader`]
    ReplyHeader,
    wire::ReplyHeader,
    type_name!("ReplyHeader", wire::layout_hash())
);
header!(
    /// [`wire::TapHeader`]
    TapHeader,
    wire::TapHeader,
    type_name!("TapHeader", wire::layout_hash())
);

/// The version of [`wire`].
#[derive(Debug)]
pub(crate) struct Current;

impl Version for Current {
    const PLAN: &'static str = topic::PLAN;
    type Request = RequestHeader;
    type Reply = ReplyHeader;

    fn upgrade(header: &wire::RequestHeader) -> wire::RequestHeader {
        *header
    }
}
