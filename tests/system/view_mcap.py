"""Prints as JSON what an independent reader sees of the messages for viewers: for each topic its
schema, how many messages it has, and what they say."""

import json
import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


def seen(schema, message):
    match schema:
        case "foxglove.PosesInFrame":
            poses = message.poses
            return message.frame_id, [[p.position.x, p.position.y, p.position.z] for p in poses]
        case "foxglove.FrameTransforms":
            (to,) = message.transforms
            at, turn = to.translation, to.rotation
            stamp = to.timestamp.seconds * 10**9 + to.timestamp.nanos
            return to.child_frame_id, stamp, [at.x, at.y, at.z, turn.z, turn.w]
        case "foxglove.SceneUpdate":
            return {e.id: [len(l.points) for l in e.lines] for e in message.entities}
        case "foxglove.Grid":
            assert message.row_stride * (len(message.data) // message.row_stride) == len(message.data)
            return message.column_count, message.cell_size.x, message.data.count(1), len(message.data)
        case _:
            return message


topics, last = {}, 0
with open(sys.argv[1], "rb") as file:
    decoders = DecoderFactory()
    for schema, channel, record in make_reader(file, validate_crcs=True).iter_messages():
        assert record.log_time >= last, "the index is in order of time"
        last = record.log_time
        if not channel.topic.startswith("/viewing/"):
            continue
        if channel.message_encoding == "json":
            assert json.loads(schema.data)["title"] == schema.name and schema.encoding == "jsonschema"
            decode = json.loads
        else:
            decode = decoders.decoder_for(channel.message_encoding, schema)
        topic = topics.setdefault(channel.topic, {"schema": schema.name, "messages": []})
        topic["messages"].append([record.log_time, seen(schema.name, decode(record.data))])
print(json.dumps(topics))
