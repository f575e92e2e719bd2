//! What describes the messages of each kind.

use foxglove::messages::{FrameTransforms, Grid, PosesInFrame, SceneUpdate};
use foxglove::{Encode, Schema};

use crate::plots;
use crate::topics::Kind;

/// What describes the messages of a topic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicSchema {
    /// Its name.
    pub name: String,
    /// How it is written: `protobuf` or `jsonschema`.
    pub encoding: String,
    /// The schema.
    pub data: Vec<u8>,
    /// How messages are written: `protobuf` or `json`.
    pub messages: String,
}

impl Kind {
    /// What describes messages of the kind.
    pub fn schema(self) -> TopicSchema {
        match self {
            Self::Scene => published::<SceneUpdate>(),
            Self::Path => published::<PosesInFrame>(),
            Self::Transforms => published::<FrameTransforms>(),
            Self::Grid => published::<Grid>(),
            Self::Motion => own("clearway.Motion", &plots::motion_schema()),
            Self::Request => own("clearway.Answers", &plots::request_schema()),
        }
    }
}

fn published<M: Encode>() -> TopicSchema {
    let Schema { name, encoding, data } = M::get_schema().expect("published messages have one");
    let messages = M::get_message_encoding();
    TopicSchema { name, encoding, data: data.into_owned(), messages }
}

fn own(name: &str, schema: &serde_json::Value) -> TopicSchema {
    TopicSchema {
        name: name.to_owned(),
        encoding: "jsonschema".to_owned(),
        data: schema.to_string().into_bytes(),
        messages: "json".to_owned(),
    }
}
