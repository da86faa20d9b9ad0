// SPDX-License-Identifier: BSD-3-Clause
// node read_conversions.mjs FOXGLOVE.mcap BAG.mcap
// What `hrp-log foxglove` and `hrp-log rosbag` write, read with Foxglove's own libraries: @mcap/core reads the files, every
// schema of foxglove.* asks for what @foxglove/schemas asks for, and @foxglove/rosmsg2-serialization decodes every
// message of ROS 2 by the definition that the file carries.
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import * as official from "@foxglove/schemas/jsonschema.js";
import { McapIndexedReader } from "@mcap/core";
import { decompress as unzstd } from "fzstd";
import { open } from "node:fs/promises";

const [foxglovePath, bagPath] = process.argv.slice(2);

function fail(text) {
  console.error(`read_conversions: ${text}`);
  process.exit(1);
}

async function openFile(path) {
  const file = await open(path);
  const { size } = await file.stat();
  const readable = {
    size: async () => BigInt(size),
    read: async (offset, length) => {
      const bytes = new Uint8Array(Number(length));
      await file.read(bytes, 0, Number(length), Number(offset));
      return bytes;
    },
  };
  return McapIndexedReader.Initialize({ readable, decompressHandlers: { zstd: (bytes, size) => unzstd(bytes, new Uint8Array(Number(size))) } });
}

// Ours has what theirs requires and nothing that theirs does not know, of the same kinds.
function compare(ours, theirs, where) {
  const kind = theirs.oneOf ? "integer" : theirs.type;  // an enumeration is a list of constants
  if (ours.type !== kind) fail(`${where}: ${ours.type}, theirs ${kind}`);
  if (kind === "array") compare(ours.items, theirs.items, `${where}[]`);
  if (kind !== "object") return;
  if (ours.title !== theirs.title) fail(`${where}: title ${ours.title}, theirs ${theirs.title}`);
  for (const key of theirs.required ?? []) if (!(key in ours.properties)) fail(`${where}.${key} is missing`);
  for (const [key, value] of Object.entries(ours.properties)) {
    if (!(key in theirs.properties)) fail(`${where}.${key}: they do not know it`);
    compare(value, theirs.properties[key], `${where}.${key}`);
  }
}

async function readAll(path) {
  const reader = await openFile(path);
  const decoders = new Map();
  const counts = { json: 0, ros2msg: 0 };
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    const text = new TextDecoder();
    if (schema.encoding === "jsonschema") {
      if (!decoders.has(schema.id)) compare(JSON.parse(text.decode(schema.data)), official[schema.name.replace("foxglove.", "")], schema.name);
      decoders.set(schema.id, true);
      JSON.parse(text.decode(message.data));
      ++counts.json;
    } else if (schema.encoding === "ros2msg") {
      if (!decoders.has(schema.id)) decoders.set(schema.id, new MessageReader(parse(text.decode(schema.data), { ros2: true })));
      const value = decoders.get(schema.id).readMessage(message.data);
      const stamp = value.header?.stamp ?? value.clock;
      if (stamp && BigInt(stamp.sec) * 1000000000n + BigInt(stamp.nsec ?? stamp.nanosec) !== message.logTime) fail(`${channel.topic}: stamp ${JSON.stringify(stamp)}, log time ${message.logTime}`);
      ++counts.ros2msg;
    }
  }
  let attachments = 0;
  for await (const attachment of reader.readAttachments()) attachments += attachment.data.byteLength > 0 ? 1 : 0;
  return { counts, attachments, profile: reader.header.profile, channels: [...reader.channelsById.values()] };
}

const foxglove = await readAll(foxglovePath);
if (!foxglove.counts.json || !foxglove.counts.ros2msg || foxglove.attachments !== 2) fail(`${foxglovePath}: ${JSON.stringify(foxglove.counts)}, ${foxglove.attachments} attachments`);
const bag = await readAll(bagPath);
if (bag.profile !== "ros2" || bag.counts.json || bag.counts.ros2msg < 100) fail(`${bagPath}: profile ${bag.profile}, ${JSON.stringify(bag.counts)}`);
for (const channel of bag.channels) {
  if (!channel.metadata.get("offered_qos_profiles")) fail(`${channel.topic} has no quality of service`);
}
console.log(`${foxglove.counts.json} JSON messages and ${foxglove.counts.ros2msg + bag.counts.ros2msg} of ROS 2 read by Foxglove's libraries`);
