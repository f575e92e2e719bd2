//! Recordings: all traffic between clients and planner, in bus order, as MCAP files.
//!
//! A recording has the profile `planning` and two channels, `/planner/request` and
//! `/planner/reply`, whose messages are [`schemas::codec`]'s bytes. The channels'
//! metadata (`schema_version`) gives the messages' version, and the schema records
//! describe them in words. Files of older versions are read; newer ones are refused.
//!
//! Messages lie in chunks, each with a checksum and behind a mark with the recording's random
//! number. [`Writer`] closes a chunk at every [`Writer::flush`], so a killed recorder loses only
//! what came after the last one. [`Reader`] checks all checksums and says what none covers, and
//! [`recover`] copies what they vouch for in a damaged file.
//!
//! MCAP tools read these files; this is the only crate that names the `mcap` crate.
//!
//! ```
//! use recording::{Message, Options, Reader, Writer};
//! use schemas::message::{Request, RequestContent, RequestKey, SceneRequest};
//!
//! let request = Request {
//!     key: RequestKey { client: 7, sequence: 0 },
//!     sent_ns: 1_000,
//!     content: RequestContent::Scene(SceneRequest::empty()),
//! };
//! let mut bytes = Vec::new();
//! let mut writer = Writer::new(&mut bytes, Options::default())?;
//! writer.write_request(&request, 1_500)?;
//! writer.finish()?;
//!
//! let mut reader = Reader::new(&bytes[..])?;
//! let record = reader.next().expect("one message")?;
//! assert_eq!(record.message, Message::Request(request));
//! assert_eq!((record.publish_ns, record.log_ns), (1_000, 1_500));
//! assert!(reader.next().is_none());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod channels;
mod chunk;
mod coverage;
mod error;
mod fields;
mod file;
mod format;
mod gaps;
mod mark;
mod options;
mod parts;
mod read;
mod record;
mod recover;
mod series;
mod source;
mod summary;
#[cfg(test)]
mod tests;
mod uploads;
mod write;
mod write_error;

pub use coverage::Coverage;
pub use error::{Damage, ReadError};
pub use file::NewFile;
pub use format::{CHUNK_BYTES, FLUSH_INTERVAL, MOST_MESSAGE_BYTES};
pub use options::{Compression, Options};
pub use parts::Dropped;
pub use read::Reader;
pub use record::{Aside, Foreign, Heartbeat, Message, Record};
pub use recover::{RecoverError, Recovered, recover};
pub use series::{
    CONTINUED_KEY, CONTINUES_KEY, FILE_KEY, Finished, PartHead, SERIES_KEY, Series, Split,
    TOPICS_KEY,
};
pub use summary::Summary;
pub use uploads::Uploads;
pub use write::{ForeignChannel, ForeignChannelId, Writer};
pub use write_error::{Trouble, WriteError};
