"""Prints what an independent reader sees in a recording: a line for each message
(topic, sequence, log time, publish time, client, the client's sequence, bytes), the
SHA-256 of each topic's messages one after the other, then the recorder's own counts."""

import hashlib
import struct
import sys

from mcap.records import Channel, Header, Message, Metadata, Schema
from mcap.stream_reader import StreamReader

schemas, channels, hashes = {}, {}, {}
with open(sys.argv[1], "rb") as file:
    for record in StreamReader(file, validate_crcs=True).records:
        match record:
            case Header():
                assert record.profile == "planning", record.profile
            case Schema():
                assert record.encoding in ("bincode", "jsonschema") and record.data, record
                schemas[record.id] = record
            case Channel():
                assert record.message_encoding in ("bincode", "json"), record
                assert record.schema_id in schemas, record
                channels[record.id] = record
            case Message():
                channel = channels[record.channel_id]
                if channel.message_encoding == "json":
                    continue
                client, sequence = struct.unpack_from("<QQ", record.data)
                print(
                    channel.topic, record.sequence, record.log_time,
                    record.publish_time, client, sequence, len(record.data),
                )
                hashes.setdefault(channel.topic, hashlib.sha256()).update(record.data)
            case Metadata(name="clearway.recording"):
                counts = record.metadata
for topic in sorted(hashes):
    print(topic, hashes[topic].hexdigest())
print(counts["recorded"], counts["lost"], counts["gaps"])
