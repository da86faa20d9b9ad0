// SPDX-License-Identifier: BSD-3-Clause
// Depth as colours: near is bright, far is dark, in nearly equal steps of lightness.
const stops = [[255, 238, 150], [243, 160, 90], [196, 84, 112], [112, 48, 128], [26, 20, 66]];
const levels = 256;

// Red, green, blue of each level, from near to far.
const colors = Array.from({ length: levels }, (_, level) => {
  const at = (level / (levels - 1)) * (stops.length - 1);
  const low = Math.min(Math.floor(at), stops.length - 2);
  return stops[low].map((from, i) => Math.round(from + (at - low) * (stops[low + 1][i] - from)));
});

// 1, 2 or 5 times a power of ten, not below the largest depth that is seen: a scale that seldom changes.
export function chooseRange(depths) {
  let largest = 0;
  for (const depth of depths) if (depth > largest && depth < Infinity) largest = depth;
  if (largest === 0) return 1;
  const power = 10 ** Math.floor(Math.log10(largest));
  return +([1, 2, 5, 10].find((factor) => factor * power >= largest * 0.999999) * power).toPrecision(1);
}

// `depths` and `range` in metres. Nothing in sight is transparent, farther than the range is the darkest.
export function paintDepth(depths, range, rgba) {
  for (let i = 0; i < depths.length; ++i) {
    if (!Number.isFinite(depths[i])) {
      rgba.fill(0, 4 * i, 4 * i + 4);
      continue;
    }
    const level = Math.min(Math.max(Math.round((depths[i] / range) * (levels - 1)), 0), levels - 1);
    rgba.set(colors[level], 4 * i);
    rgba[4 * i + 3] = 255;
  }
}

export function paintColor(rgb, rgba) {
  for (let from = 0, to = 0; from + 2 < rgb.length; from += 3, to += 4) {
    rgba[to] = rgb[from];
    rgba[to + 1] = rgb[from + 1];
    rgba[to + 2] = rgb[from + 2];
    rgba[to + 3] = 255;
  }
}
