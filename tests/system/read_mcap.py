"""Prints what an independent reader sees in a recording: a line for each message
(topic, sequence, log time, publish time, client, the client's sequence, bytes), then
the recorder's own counts."""

import struct
import sys

from mcap.records import Channel, Header, Message, Metadata, Schema
from mcap.stream_reader import StreamReader

schemas, channels = {}, {}
with open(sys.argv[1], "rb") as file:
    for record in StreamReader(file, validate_crcs=True).records:
        match record:
            case Header():
                assert record.profile == "planning", record.profile
            case Schema():
                assert record.encoding == "bincode" and record.data, record
                schemas[record.id] = record
            case Channel():
                assert record.message_encoding == "bincode", record
                assert record.schema_id in schemas, record
                channels[record.id] = record
            case Message():
                client, sequence = struct.unpack_from("<QQ", record.data)
                print(
                    channels[record.channel_id].topic, record.sequence, record.log_time,
                    record.publish_time, client, sequence, len(record.data),
                )
            case Metadata():
                counts = record.metadata
                print(counts["recorded"], counts["lost"], counts["gaps"])
