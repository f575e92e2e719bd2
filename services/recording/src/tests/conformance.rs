//! Files of other writers: the variants of MCAP's conformance suite, generated here from the
//! specification.

use super::*;

/// What a writer may choose.
#[derive(Debug, Clone, Copy)]
struct Variant {
    /// None: messages outside of chunks.
    chunks: Option<&'static str>,
    message_indexes: bool,
    chunk_indexes: bool,
    statistics: bool,
    repeated_schemas: bool,
    repeated_channels: bool,
    summary_offsets: bool,
    /// Extra bytes at the end of records.
    padding: bool,
    chunk_checksums: bool,
    file_checksums: bool,
}

impl Variant {
    fn all() -> impl Iterator<Item = Self> {
        [None, Some(""), Some("lz4"), Some("zstd")].into_iter().flat_map(|chunks| {
            (0..1_u32 << 9).map(move |bits| {
                let has = |bit: u32| bits >> bit & 1 == 1;
                Self {
                    chunks,
                    message_indexes: has(0),
                    chunk_indexes: has(1),
                    statistics: has(2),
                    repeated_schemas: has(3),
                    repeated_channels: has(4),
                    summary_offsets: has(5),
                    padding: has(6),
                    chunk_checksums: has(7),
                    file_checksums: has(8),
                }
            })
        })
    }
}

#[derive(Default)]
struct Body(Vec<u8>);

impl Body {
    fn u16(mut self, value: u16) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    fn u32(mut self, value: u32) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    fn u64(mut self, value: u64) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    fn bytes(mut self, bytes: &[u8]) -> Self {
        self.0.extend(bytes);
        self
    }

    fn block(self, bytes: &[u8]) -> Self {
        self.u32(bytes.len() as u32).bytes(bytes)
    }

    fn record(self, opcode: u8, padding: bool) -> Vec<u8> {
        let Self(mut body) = self;
        if padding {
            body.extend([0xaa, 0x06, 0x05]);
        }
        let mut record = vec![opcode];
        record.extend((body.len() as u64).to_le_bytes());
        record.extend(body);
        record
    }
}

fn compress(method: &str, bytes: &[u8]) -> Vec<u8> {
    match method {
        "zstd" => zstd::encode_all(bytes, 3).unwrap(),
        "lz4" => {
            let mut encoder = lz4::EncoderBuilder::new().build(Vec::new()).unwrap();
            encoder.write_all(bytes).unwrap();
            let (compressed, ended) = encoder.finish();
            ended.unwrap();
            compressed
        }
        _ => bytes.to_vec(),
    }
}

/// Two requests in two chunks, with a message of another channel and metadata between.
fn generate(variant: Variant) -> Vec<u8> {
    let pad = variant.padding;
    let checksum = |wanted: bool, bytes: &[u8]| if wanted { crc32fast::hash(bytes) } else { 0 };
    let schema = Body::default()
        .u16(1)
        .block(schemas::codec::REQUEST_NAME.as_bytes())
        .block(topic::ENCODING.as_bytes())
        .block(b"words")
        .record(op::SCHEMA, pad);
    let version = Body::default().block(format::VERSION_KEY.as_bytes()).block(b"3");
    let channel = Body::default()
        .u16(1)
        .u16(1)
        .block(topic::REQUEST.as_bytes())
        .block(topic::ENCODING.as_bytes())
        .block(&version.0)
        .record(op::CHANNEL, pad);
    let other = Body::default()
        .u16(2)
        .u16(0)
        .block(b"/camera")
        .block(b"json")
        .block(b"")
        .record(op::CHANNEL, pad);
    let message = |channel: u16, sequence: u32, data: &[u8]| {
        let head =
            Body::default().u16(channel).u32(sequence).u64(9).u64(1_000 + u64::from(sequence));
        head.bytes(data).record(op::MESSAGE, false)
    };
    let first = message(1, 0, &schemas::codec::encode(&request(0)));
    let second = message(1, 1, &schemas::codec::encode(&request(1)));
    let groups = [
        [&schema[..], &channel, &other, &first].concat(),
        [&message(2, 0, b"{}")[..], &second].concat(),
    ];

    let mut file = mcap::MAGIC.to_vec();
    file.extend(Body::default().block(b"planning").block(b"a tool").record(op::HEADER, pad));
    let mut chunk_indexes = Vec::new();
    for records in &groups {
        let Some(method) = variant.chunks else {
            file.extend(records);
            continue;
        };
        let begin = file.len();
        let data = compress(method, records);
        let chunk = Body::default()
            .u64(9)
            .u64(9)
            .u64(records.len() as u64)
            .u32(checksum(variant.chunk_checksums, records))
            .block(method.as_bytes())
            .u64(data.len() as u64)
            .bytes(&data)
            .record(op::CHUNK, pad);
        file.extend(&chunk);
        if variant.message_indexes {
            let entries = Body::default().u64(9).u64(0);
            file.extend(Body::default().u16(1).block(&entries.0).record(op::MESSAGE_INDEX, pad));
        }
        let index = Body::default().u64(9).u64(9).u64(begin as u64).u64(chunk.len() as u64);
        let index = index.block(b"").u64(0).block(method.as_bytes());
        let index = index.u64(data.len() as u64).u64(records.len() as u64);
        chunk_indexes.push(index.record(op::CHUNK_INDEX, pad));
    }
    file.extend(Body::default().block(b"notes").block(b"").record(op::METADATA, pad));
    let checksum_of_data = checksum(variant.file_checksums, &file);
    file.extend(Body::default().u32(checksum_of_data).record(op::DATA_END, pad));

    let begin = file.len();
    let mut summary = Vec::new();
    let mut offsets = Vec::new();
    let mut group = |wanted: bool, opcode: u8, records: &[u8]| {
        if wanted && !records.is_empty() {
            let offset = Body::default().bytes(&[opcode]).u64((begin + summary.len()) as u64);
            offsets.extend(offset.u64(records.len() as u64).record(op::SUMMARY_OFFSET, pad));
            summary.extend_from_slice(records);
        }
    };
    group(variant.repeated_schemas, op::SCHEMA, &schema);
    group(variant.repeated_channels, op::CHANNEL, &[&channel[..], &other].concat());
    let counts = Body::default().u16(1).u64(2).u16(2).u64(1);
    let statistics = Body::default().u64(3).u16(1).u32(2).u32(0).u32(1).u32(2).u64(9).u64(9);
    group(
        variant.statistics,
        op::STATISTICS,
        &statistics.block(&counts.0).record(op::STATISTICS, pad),
    );
    group(variant.chunk_indexes, op::CHUNK_INDEX, &chunk_indexes.concat());
    let begin_of_offsets = begin + summary.len();
    let has_offsets = variant.summary_offsets && !offsets.is_empty();
    if has_offsets {
        summary.extend(offsets);
    }
    let place = |wanted: bool, at: usize| if wanted { at as u64 } else { 0 };
    let footer = Body::default()
        .u64(place(!summary.is_empty(), begin))
        .u64(place(has_offsets, begin_of_offsets));
    let mut head = vec![op::FOOTER];
    head.extend(20_u64.to_le_bytes());
    let covered = [&summary[..], &head, &footer.0].concat();
    let footer = footer.u32(checksum(variant.file_checksums, &covered));
    file.extend(summary);
    file.extend(footer.record(op::FOOTER, false));
    file.extend(mcap::MAGIC);
    file
}

fn expected(sequence: u64) -> Record {
    Record {
        message: Message::Request(request(sequence)),
        log_ns: 9,
        publish_ns: 1_000 + sequence,
        sequence: sequence as u32,
    }
}

#[test]
fn every_variant_is_read() {
    for variant in Variant::all() {
        let bytes = generate(variant);
        let mut reader =
            Reader::new(&bytes[..]).unwrap_or_else(|error| panic!("{variant:?}: {error}"));
        let records: Vec<_> = reader
            .by_ref()
            .collect::<Result<_, _>>()
            .unwrap_or_else(|error| panic!("{variant:?}: {error}"));
        assert_eq!(records, [expected(0), expected(1)], "{variant:?}");
        assert_eq!(reader.others().collect::<Vec<_>>(), [("/camera", 1)], "{variant:?}");
        let in_chunks = variant.chunks.is_some() && variant.chunk_checksums;
        let coverage = reader.coverage();
        assert_eq!(coverage.is_whole(), in_chunks || variant.file_checksums, "{variant:?}");
        assert!(coverage.bytes > 400 || variant.chunks.is_some(), "{coverage:?}");
    }
}

#[test]
fn every_variant_is_recovered_as_far_as_checksums_vouch_for_it() {
    for variant in Variant::all() {
        let bytes = generate(variant);
        let vouched = variant.file_checksums || variant.chunks.is_some() && variant.chunk_checksums;
        for unverified in [false, true] {
            let disk = Disk::new(usize::MAX);
            let create = |options| Writer::new(disk.clone(), options);
            let found = salvage(io::Cursor::new(&bytes), unverified, fixed(), create).unwrap();
            let expected = match found {
                None => {
                    assert!(!vouched && !unverified, "{variant:?}");
                    continue;
                }
                Some(found) => {
                    assert_eq!(found.unverified, if vouched { 0 } else { 2 }, "{variant:?}");
                    assert_eq!(found.is_incomplete(), !vouched, "{variant:?}");
                    [expected(0), expected(1)]
                }
            };
            assert_eq!(read(&disk.bytes()).0, expected, "{variant:?}");
            let bytes = disk.bytes();
            let mut reader = Reader::new(&bytes[..]).unwrap();
            assert_eq!(reader.by_ref().count(), 2);
            assert_eq!(reader.description().contains_key("unverified_parts"), !vouched);
        }
    }
}

#[test]
fn what_is_compressed_is_as_well_guarded() {
    for method in ["lz4", "zstd"] {
        let variant = Variant::all()
            .find(|variant| variant.chunks == Some(method) && variant.chunk_checksums)
            .unwrap();
        let whole = generate(variant);
        for at in 8..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 1 << (at % 8);
            for record in read(&bytes).0 {
                assert_eq!(record, expected(u64::from(record.sequence)), "{method}, byte {at}");
            }
        }
    }
}

#[test]
fn a_chunk_that_unpacks_to_more_than_it_claims_is_refused() {
    let variant = Variant::all()
        .find(|variant| variant.chunks == Some("zstd") && !variant.chunk_checksums)
        .unwrap();
    let mut bytes = generate(variant);
    let chunk = bytes.windows(4).position(|four| four == b"zstd").unwrap() - 32;
    bytes[chunk + 16..chunk + 24].copy_from_slice(&100_u64.to_le_bytes());
    check_refused(&bytes, "a chunk claims 100 bytes of records, it has 101");
    bytes[chunk + 16..chunk + 24].copy_from_slice(&(1_u64 << 40).to_le_bytes());
    check_refused(&bytes, "a chunk claims 1099511627776 bytes of records, the most is");
}
