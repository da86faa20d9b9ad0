// SPDX-License-Identifier: BSD-3-Clause
// The WebSocket to the server: JSON messages with an `op`, and answers to questions by their id. Comes back by itself.

// A binary message: the length of a JSON text, the text, and what belongs to it as `bytes`.
function readBinary(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const message = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return { ...message, bytes: new Uint8Array(buffer, 4 + length) };
}

export class ServerConnection {
  // `take` is called with each message, `lost` when the server has gone.
  constructor(take, lost) {
    Object.assign(this, { take, lost, waiting: new Map(), nextId: 1 });
    this.connect();
  }

  connect() {
    const url = new URL("ws", location.href);
    url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    url.search = location.search;
    this.socket = new WebSocket(url);
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = ({ data }) => this.handle(typeof data === "string" ? JSON.parse(data) : readBinary(data));
    this.socket.onclose = () => {
      for (const done of this.waiting.values()) done({ error: "the connection was lost" });
      this.waiting.clear();
      this.lost();
      setTimeout(() => this.connect(), 1000);
    };
  }

  handle(message) {
    const done = this.waiting.get(message.id);
    if (done && (message.op === "series" || message.op === "error")) {
      this.waiting.delete(message.id);
      done(message.op === "error" ? { error: message.message } : message);
      return;
    }
    this.take(message);
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  ask(message) {
    if (this.socket.readyState !== WebSocket.OPEN) return Promise.resolve({ error: "not connected" });
    const id = this.nextId++;
    return new Promise((done) => {
      this.waiting.set(id, done);
      this.send({ ...message, id });
    });
  }
}
