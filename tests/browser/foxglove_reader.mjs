// SPDX-License-Identifier: BSD-3-Clause
// Foxglove's own client, with its own decoders.
import { parseIDL } from "@foxglove/omgidl-parser";
import { MessageReader } from "@foxglove/omgidl-serialization";
import { parse as parseRos } from "@foxglove/rosmsg";
import { MessageReader as RosReader } from "@foxglove/rosmsg2-serialization";
import foxglove from "@foxglove/ws-protocol";
import WebSocket from "ws";

const { FoxgloveClient } = foxglove;

function makeDecoder({ schemaEncoding, schemaName, schema }) {
  if (schemaEncoding === "jsonschema") return { readMessage: (data) => JSON.parse(new TextDecoder().decode(data)) };
  if (schemaEncoding === "ros2msg") return new RosReader(parseRos(schema, { ros2: true }));
  return new MessageReader(schemaName, parseIDL(schema));
}

// A client that decodes what it gets by what the server said of it.
export class Reader {
  constructor(url, protocol) {
    const socket = new WebSocket(url, [protocol]);
    Object.assign(this, { channels: new Map(), messages: [], statuses: [], decoders: new Map(), subscriptions: new Map() });
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.client = new FoxgloveClient({ ws: socket });
    this.client.on("serverInfo", (info) => { this.info = info; });
    this.client.on("status", (status) => this.statuses.push(status));
    this.client.on("error", (error) => { this.error = error; });
    this.client.on("close", () => { this.closed = true; });
    this.client.on("advertise", (channels) => channels.forEach((channel) => this.channels.set(channel.topic, channel)));
    this.client.on("message", (message) => this.take(message));
  }

  subscribe(topic) {
    const channel = this.channels.get(topic);
    const id = this.client.subscribe(channel.id);
    this.decoders.set(id, { topic, reader: makeDecoder(channel) });
    this.subscriptions.set(topic, id);
  }

  take({ subscriptionId, timestamp, data }) {
    const { topic, reader } = this.decoders.get(subscriptionId);
    this.messages.push({ topic, timestamp, message: reader.readMessage(data) });
  }

  of(topic) {
    return this.messages.filter((each) => each.topic === topic);
  }
}
