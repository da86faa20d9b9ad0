#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""make_terrain.py FOLDER: writes the surfaces of this folder, made up for examples and tests."""
import math
import pathlib
import struct
import sys
import zlib

SPACING = 0.05  # [m]


def find_wave(x, y):
    """Level where the robot starts; beyond, waves of up to 5 mm [m]."""
    grow = min(1.0, max(0.0, (x - 0.3) / 0.4))
    return 0.005 * grow * math.sin(2 * math.pi * x / 0.9) * math.cos(2 * math.pi * y / 1.3)


def write_waves(path):
    """8 m x 4 m, a height every 0.05 m: rows from y = 2 m down, columns from x = -4 m up."""
    rows = [[find_wave(-4 + SPACING * j, 2 - SPACING * i) for j in range(161)] for i in range(81)]
    lines = [",".join(f"{height:.6f}".replace("-0.000000", "0").replace("0.000000", "0") for height in row) for row in rows]
    path.write_text("# Heights [m], 0.05 m apart; the first line has the largest y.\n" + "\n".join(lines) + "\n")


def write_hills(path):
    """A grey image of 16 bits, 81 x 81: three hills."""
    def height(x, y):
        hills = [(-0.8, 0.5, 1.0), (0.9, 0.8, 0.7), (0.2, -0.9, 0.5)]
        return min(1.0, sum(h * math.exp(-((x - a) ** 2 + (y - b) ** 2) / 0.3) for a, b, h in hills))

    raw = b"".join(b"\0" + b"".join(struct.pack(">H", round(65535 * height(-2 + SPACING * j, 2 - SPACING * i))) for j in range(81))
                   for i in range(81))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", 81, 81, 16, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b""))


def write_stairs(path):
    """Three steps up along x from x = 0, each 0.3 m deep, 0.15 m high, 2 m wide: a closed body."""
    outline = [(0.0, 0.0)]
    for k in range(3):
        outline += [(0.3 * k, 0.15 * (k + 1)), (0.3 * (k + 1), 0.15 * (k + 1))]
    outline.append((0.9, 0.0))
    n = len(outline)
    text = "# Three steps [m]. Triangles are counter-clockwise seen from outside.\n"
    for y in (-1.0, 1.0):
        text += "".join(f"v {x:g} {y:g} {z:g}\n" for x, z in outline)
    for k in range(n):
        a, b = k + 1, (k + 1) % n + 1
        text += f"f {a} {b + n} {a + n}\nf {a} {b} {b + n}\n"
    # The ends, as columns from the ground up to each tread.
    for end in (0, n):
        for k in range(3):
            low, high = 2 * k + 2, 2 * k + 3
            text += f"f {end + low} {end + high} {end + n}\n" if end else f"f {high} {low} {n}\n"
        for k in range(3):
            below = 1 if k == 0 else 2 * k + 1
            text += f"f {end + below} {end + 2 * k + 2} {end + n}\n" if end else f"f {2 * k + 2} {below} {n}\n"
    path.write_text(text)


def main():
    folder = pathlib.Path(sys.argv[1])
    write_waves(folder / "waves.csv")
    write_hills(folder / "hills.png")
    write_stairs(folder / "stairs.obj")


if __name__ == "__main__":
    sys.exit(main())
