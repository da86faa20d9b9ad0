// SPDX-License-Identifier: BSD-3-Clause
// Plays recordings: asks for the picture of a time, one question at a time, so that a slow machine shows fewer pictures
// and never lags behind.
export class Player {
  // `ask(time, steps)` sends the question.
  constructor(ask) {
    Object.assign(this, { ask, time: 0, end: 0, speed: 1, playing: false, pending: false, wanted: null });
  }

  seek(time, steps = 0) {
    const at = Math.min(Math.max(time, 0), this.end);
    if (this.pending) {
      this.wanted = { time: at, steps: (this.wanted?.steps ?? 0) + steps };
      return;
    }
    this.pending = true;
    this.time = at;
    this.ask(at, steps);
  }

  step(count) {
    this.playing = false;
    this.seek(this.wanted?.time ?? this.time, count);
  }

  // The server answered with the picture of `time`.
  took(time) {
    this.pending = false;
    this.time = time;
    if (!this.wanted) return;
    const { time: next, steps } = this.wanted;
    this.wanted = null;
    // Steps that were asked for meanwhile count from where we are now.
    this.seek(steps !== 0 ? time : next, steps);
  }

  toggle() {
    if (!this.playing && this.time >= this.end) this.time = 0;
    this.playing = !this.playing;
  }

  // `elapsed` [s] of wall clock since the last call.
  advance(elapsed) {
    if (!this.playing || this.pending) {
      this.owed = (this.owed ?? 0) + (this.playing ? elapsed : 0);
      return;
    }
    const next = this.time + (elapsed + (this.owed ?? 0)) * this.speed;
    this.owed = 0;
    if (next >= this.end) this.playing = false;
    this.seek(next);
  }

  reset(end) {
    Object.assign(this, { time: 0, end, playing: false, pending: false, wanted: null, owed: 0 });
  }
}
