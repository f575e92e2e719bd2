//! The messages' headers as iceoryx2 sees them. The type names carry the layout's
//! hash: the same name and size with different fields would connect silently.

use std::fmt::Debug;
use std::sync::LazyLock;

use iceoryx2::prelude::ZeroCopySend;
use schemas::{topic, wire};

macro_rules! header {
    ($(#[$doc:meta])* $name:ident, $wire:ty) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, Default)]
        #[repr(transparent)]
        pub(crate) struct $name(pub(crate) $wire);

        #[expect(unsafe_code, reason = "vouches for plain memory: repr(C), no pointers, Pod")]
        // SAFETY: a transparent wrapper of a `Pod` type that is `repr(C)`.
        unsafe impl ZeroCopySend for $name {
            unsafe fn type_name() -> &'static str {
                static NAME: LazyLock<String> = LazyLock::new(|| {
                    format!("clearway::{}#{:016x}", stringify!($name), topic::layout_hash())
                });
                &NAME
            }
        }
    };
}

header!(
    /// [`wire::RequestHeader`]
    RequestHeader,
    wire::RequestHeader
);
header!(
    /// [`wire::ReplyHeader`]
    ReplyHeader,
    wire::ReplyHeader
);
header!(
    /// [`wire::TapHeader`]
    TapHeader,
    wire::TapHeader
);
