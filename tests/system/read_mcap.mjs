// Prints what a second independent reader sees in a recording, in the form of read_mcap.py.

import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

// Packages are those of the folder given, not of this one.
const [file, folder] = process.argv.slice(2);
const { resolve } = createRequire(pathToFileURL(`${folder}/`));
const load = (name) => import(pathToFileURL(resolve(name)));
const { McapStreamReader } = await load("@mcap/core");
const { loadDecompressHandlers } = await load("@mcap/support");

const check = (holds, what) => {
  if (!holds) throw new Error(JSON.stringify(what, (_, it) => (typeof it === "bigint" ? `${it}` : it)));
};
const decompressHandlers = await loadDecompressHandlers();
const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
reader.append(readFileSync(file));
const [schemas, channels, hashes] = [new Set(), new Map(), new Map()];
const lines = [];
let counts;
for (let record; (record = reader.nextRecord()); ) {
  switch (record.type) {
    case "Header":
      check(record.profile === "planning", record.profile);
      break;
    case "Schema":
      check(["bincode", "jsonschema"].includes(record.encoding) && record.data.length > 0, record);
      schemas.add(record.id);
      break;
    case "Channel":
      check(["bincode", "json"].includes(record.messageEncoding), record);
      check(schemas.has(record.schemaId), record);
      channels.set(record.id, record);
      break;
    case "Message": {
      const { topic, messageEncoding } = channels.get(record.channelId);
      if (messageEncoding === "json") break;
      const { data, sequence, logTime, publishTime } = record;
      const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
      const [client, number] = [view.getBigUint64(0, true), view.getBigUint64(8, true)];
      lines.push([topic, sequence, logTime, publishTime, client, number, data.length].join(" "));
      if (!hashes.has(topic)) hashes.set(topic, createHash("sha256"));
      hashes.get(topic).update(data);
      break;
    }
    case "Metadata":
      if (record.name === "clearway.recording") counts = record.metadata;
  }
}
check(reader.done(), "the file goes on");
for (const topic of [...hashes.keys()].sort()) {
  lines.push(`${topic} ${hashes.get(topic).digest("hex")}`);
}
lines.push(["recorded", "lost", "gaps"].map((name) => counts.get(name)).join(" "));
console.log(lines.join("\n"));
