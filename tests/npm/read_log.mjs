// SPDX-License-Identifier: BSD-3-Clause
// node read_log.mjs HRP_LOG LOG.mcap
// Reads every message of a log with other people's reader (@mcap/core) and decoders (@foxglove/omgidl-*), from nothing
// but the log itself, and demands the values that our own reader prints ("hrp-log cat --json").
import { parseIDL } from "@foxglove/omgidl-parser";
import { MessageReader } from "@foxglove/omgidl-serialization";
import lz4 from "@foxglove/wasm-lz4";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { spawn } from "node:child_process";
import { open } from "node:fs/promises";
import { createReadStream } from "node:fs";
import { createInterface } from "node:readline";
import { decompress as unzstd } from "fzstd";

const [hrpLog, path] = process.argv.slice(2);
await lz4.isLoaded;
const decompressHandlers = {
  zstd: (bytes, size) => unzstd(bytes, new Uint8Array(Number(size))),
  lz4: (bytes, size) => lz4(bytes, Number(size)),
};

function fail(text) {
  console.error(`read_log: ${text}`);
  process.exit(1);
}

// What our JSON says for a value: not-a-number and infinities are strings, enums are names, 64-bit numbers are numbers.
function differs(ours, theirs, enumNames, where) {
  if (theirs instanceof Object && ArrayBuffer.isView(theirs)) theirs = Array.from(theirs);
  if (Array.isArray(theirs)) {
    if (!Array.isArray(ours) || ours.length !== theirs.length) return `${where}: another number of elements`;
    for (let i = 0; i < ours.length; ++i) {
      const text = differs(ours[i], theirs[i], enumNames, `${where}[${i}]`);
      if (text) return text;
    }
    return null;
  }
  if (theirs !== null && typeof theirs === "object") {
    const keys = Object.keys(theirs);
    if (keys.join() !== Object.keys(ours).join()) return `${where}: fields ${keys} against ours ${Object.keys(ours)}`;
    for (const key of keys) {
      const text = differs(ours[key], theirs[key], enumNames, `${where}.${key}`);
      if (text) return text;
    }
    return null;
  }
  // A hash is 16 hexadecimal digits in our JSON: a number would lose its last bits.
  if (typeof theirs === "bigint" && /^[0-9a-f]{16}$/.test(ours)) ours = BigInt(`0x${ours}`) === theirs ? Number(theirs) : NaN;
  if (typeof theirs === "bigint") theirs = Number(theirs);
  if (typeof theirs === "number" && typeof ours === "string") {
    if (enumNames.get(ours) === theirs) return null;
    ours = { nan: NaN, inf: Infinity, "-inf": -Infinity }[ours];
  }
  return Object.is(ours, theirs) ? null : `${where}: ours ${ours}, theirs ${theirs}`;
}

function collectEnums(definitions) {
  const names = new Map();
  for (const definition of definitions) {
    for (const entry of definition.aggregatedKind === "module" ? definition.definitions : []) {
      if (entry.isConstant) names.set(entry.name, entry.value);
    }
  }
  return names;
}

const decoders = new Map();
function decoderOf(reader, channel) {
  if (!decoders.has(channel.id)) {
    const schema = reader.schemasById.get(channel.schemaId);
    if (schema.encoding !== "omgidl" || channel.messageEncoding !== "cdr") fail(`${channel.topic}: other encodings`);
    const definitions = parseIDL(new TextDecoder().decode(schema.data));
    decoders.set(channel.id, {
      reader: new MessageReader(schema.name, definitions),
      enumNames: collectEnums(definitions),
    });
  }
  return decoders.get(channel.id);
}

async function readIndexed() {
  const file = await open(path);
  const readable = {
    size: async () => BigInt((await file.stat()).size),
    read: async (offset, length) => {
      const bytes = new Uint8Array(Number(length));
      const { bytesRead } = await file.read(bytes, 0, bytes.length, Number(offset));
      if (bytesRead !== bytes.length) throw new Error("the file ends early");
      return bytes;
    },
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  if (reader.statistics === undefined || reader.chunkIndexes.length === 0) fail("no index in the file");
  const messages = new Map(); // topic -> sequence -> decoded
  let count = 0;
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    const decoder = decoderOf(reader, channel);
    const value = decoder.reader.readMessage(message.data);
    messages.set(`${channel.topic} ${message.sequence}`, { value, message, enumNames: decoder.enumNames });
    ++count;
  }
  if (BigInt(count) !== reader.statistics.messageCount) fail(`${count} messages, statistics say otherwise`);
  await file.close();
  return messages;
}

// The other reader of @mcap/core, which needs no index and checks every checksum.
async function countStreamed() {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  let count = 0;
  for await (const part of createReadStream(path)) {
    reader.append(part);
    for (let record; (record = reader.nextRecord()); ) count += record.type === "Message" ? 1 : 0;
  }
  if (!reader.done()) fail("the streaming reader does not find the end of the file");
  return count;
}

const theirs = await readIndexed();
const streamed = await countStreamed();
const cat = spawn(hrpLog, ["cat", path, "--json"], { stdio: ["ignore", "pipe", "inherit"] });
let count = 0;
for await (const line of createInterface({ input: cat.stdout })) {
  const ours = JSON.parse(line);
  const found = theirs.get(`${ours.topic} ${ours.step}`);
  if (!found) fail(`${ours.topic}, step ${ours.step}: they do not have it`);
  const text = differs(ours.message, found.value, found.enumNames, `${ours.topic}, step ${ours.step}`);
  if (text) fail(text);
  if (Number(found.message.logTime) !== Math.round(ours.time * 1e9)) fail(`${ours.topic}, step ${ours.step}: log time`);
  ++count;
}
if (count === 0 || count !== theirs.size || count !== streamed) {
  fail(`${count} messages by our reader, ${theirs.size} by the indexed one, ${streamed} by the streaming one`);
}
console.log(`${path}: ${count} messages, the same values in both readers`);
