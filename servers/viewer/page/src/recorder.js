// SPDX-License-Identifier: BSD-3-Clause
// A video of the picture, made by the browser itself: what is drawn from start() to stop(), in wall-clock time.
const kinds = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];
const pictures = 30;  // a second, at most
const bitsPerSecond = 6e6;

export class Recorder {
  // `stage`: it draws on its canvas when something has changed.
  constructor(stage) {
    this.stage = stage;
    this.kind = typeof MediaRecorder === "undefined" ? undefined : kinds.find((kind) => MediaRecorder.isTypeSupported(kind));
  }

  get isPossible() { return this.kind !== undefined && typeof this.stage.canvas.captureStream === "function"; }
  get isOn() { return this.recorder !== undefined; }

  start() {
    const chunks = [];
    this.stage.setBackdrop(true);
    this.stream = this.stage.canvas.captureStream(pictures);
    this.recorder = new MediaRecorder(this.stream, { mimeType: this.kind, videoBitsPerSecond: bitsPerSecond });
    this.recorder.ondataavailable = (event) => chunks.push(event.data);
    this.done = new Promise((resolve, reject) => {
      this.recorder.onstop = () => resolve(new Blob(chunks, { type: this.kind.split(";")[0] }));
      this.recorder.onerror = (event) => reject(event.error);
    });
    this.recorder.start(1000);
    this.stage.dirty = true;  // a picture that stands still is a video, too
  }

  // The video.
  async stop() {
    this.recorder.stop();
    const video = await this.done;
    for (const track of this.stream.getTracks()) track.stop();
    this.stage.setBackdrop(false);
    this.recorder = undefined;
    return video;
  }
}

export function saveAs(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
