// Reads the messages for viewers with @mcap/core and protobufjs, holds them against the JSON Schemas
// of @foxglove/schemas, and prints how many there are of each topic.
import fs from "node:fs/promises";
import { McapIndexedReader } from "@mcap/core";
import * as published from "@foxglove/schemas/jsonschema.js";
import protobuf from "protobufjs";
import descriptor from "protobufjs/ext/descriptor.js";

const file = await fs.open(process.argv[2]);
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length));
    await file.read(bytes, 0, bytes.length, Number(offset));
    return bytes;
  },
};
const reader = await McapIndexedReader.Initialize({ readable });

// Every field that is published is there and of its type. Times are written otherwise in protobuf.
function check(schema, value, path) {
  if (schema.title === "time" || schema.title === "duration" || value === undefined) return;
  const type = schema.type === "object" ? "object" : schema.type === "string" ? "string" : undefined;
  if (type && typeof value !== type && schema.contentEncoding === undefined)
    throw Error(`${path} is ${typeof value}, not ${type}`);
  for (const [name, field] of Object.entries(schema.properties ?? {})) {
    const camel = name.replace(/_([a-z])/g, (_, letter) => letter.toUpperCase());
    if (!(camel in value)) throw Error(`${path}.${name} is missing`);
    const items = field.type === "array" && Array.isArray(value[camel]) ? value[camel] : [];
    items.forEach((item, at) => check(field.items, item, `${path}.${name}[${at}]`));
    if (field.type === "object" && value[camel] !== null) check(field, value[camel], `${path}.${name}`);
  }
}

const types = new Map();
const counts = {};
for await (const { channelId, data } of reader.readMessages()) {
  const { topic, schemaId } = reader.channelsById.get(channelId);
  if (!topic.startsWith("/viewing/")) continue;
  counts[topic] = (counts[topic] ?? 0) + 1;
  const { name, encoding, data: schema } = reader.schemasById.get(schemaId);
  if (encoding !== "protobuf") {
    JSON.parse(new TextDecoder().decode(data));
    continue;
  }
  if (!types.has(name)) {
    const files = descriptor.FileDescriptorSet.decode(schema);
    types.set(name, protobuf.Root.fromDescriptor(files).lookupType(name));
  }
  const type = types.get(name);
  const message = type.toObject(type.decode(data), { defaults: true });
  check(published[name.replace("foxglove.", "")], message, name);
}
console.log(JSON.stringify(counts));
