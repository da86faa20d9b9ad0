# SPDX-License-Identifier: BSD-3-Clause
"""What the papers' figures 3 to 9 show of a walk, as numbers and as pictures: vertical force of each foot, roll and pitch
of the trunk, torque of the ankles. A table is {column: [values]} with `time` from 0 on, columns as in docs/diagnosis.md."""
import bisect
import html
import math
import statistics

LOADED = 0.05  # of the weight: below it a foot is in the air
LANDING = 0.25  # [s] after touch-down within which the force peaks, dips and settles, as in figure 11
BLOW = 0.1  # [s] of it within which the force peaks
AIRBORNE = 0.25  # [s] that a foot was in the air before what counts as a landing: what follows a first touch is its rebound
CORNER = 25.0  # [Hz] above a walk's own frequencies, below the contact's
FALLEN = math.radians(60.0)  # of the trunk against upright, as the simulator's fall watch has it
GRID = 200.0  # [Hz] on which tables of different rates are compared


def is_number(x):
    return x is not None and math.isfinite(x)


def resample(table, name, times):
    """Linear interpolation; NaN outside, and where the table has no numbers."""
    t, y, out = table["time"], table[name], []
    for x in times:
        k = bisect.bisect_right(t, x) - 1
        if k < 0 or x > t[-1]:
            out.append(math.nan)
        elif k + 1 >= len(t):
            out.append(y[k])
        else:
            s = (x - t[k]) / (t[k + 1] - t[k]) if t[k + 1] > t[k] else 0.0
            out.append(y[k] + s * (y[k + 1] - y[k]))
    return out


def make_grid(end):
    return [k / GRID for k in range(int(end * GRID) + 1)]


def list_imus(table):
    return sorted({n.split("/")[2] for n in table if n.startswith("/imu/") and n.endswith("/orientation/w")})


def calc_tilt(w, x, y, z):
    """Roll, pitch [rad] of R = Rz Ry Rx, and the angle of the body's z axis against the vertical."""
    n = math.sqrt(w * w + x * x + y * y + z * z)
    if not math.isfinite(n) or n < 1e-6:
        return math.nan, math.nan, math.nan
    w, x, y, z = w / n, x / n, y / n, z / n
    up = max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y)))
    return math.atan2(2.0 * (w * x + y * z), up), math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x)))), math.acos(up)


def add_attitude(table):
    """Columns roll, pitch, lean of the trunk, from the first IMU with an attitude, else from the base's pose."""
    prefixes = [f"/imu/{name}/orientation/" for name in list_imus(table)] + ["/base/pose/orientation/"]
    for prefix in prefixes:
        if all(prefix + axis in table for axis in "wxyz"):
            tilts = [calc_tilt(*q) for q in zip(*(table[prefix + axis] for axis in "wxyz"))]
            upright = next((i for i, t in enumerate(tilts) if is_number(t[2])), None)
            if upright is None:
                continue
            table["trunk roll"], table["trunk pitch"] = [t[0] for t in tilts], [t[1] for t in tilts]
            table["trunk lean"] = [t[2] for t in tilts]
            return


def list_feet(table):
    """Names of force sensors, by their columns of vertical force."""
    return sorted({n.split("/")[2] for n in table if n.startswith("/wrench/") and n.endswith("/force/z")})


def find_fall(table):
    """[s] at which the trunk leans by 60 degrees; None: it does not, or that was not recorded."""
    for t, lean in zip(table["time"], table.get("trunk lean", [])):
        if is_number(lean) and lean > FALLEN:
            return t
    return None


def calc_band_power(values):
    """Mean square above CORNER of equidistant samples at GRID: two first-order high-passes in a row."""
    k = math.tan(math.pi * CORNER / GRID)
    x = [v for v in values if math.isfinite(v)]
    for _ in range(2):
        y = [0.0] * len(x)
        for i in range(1, len(x)):
            y[i] = ((1.0 - k) * y[i - 1] + x[i] - x[i - 1]) / (1.0 + k)
        x = y
    return sum(v * v for v in x) / len(x) if x else math.nan


def find_landings(force, weight):
    """Indices at which a foot that was in the air for a while takes up load."""
    out, air = [], 0
    for i, f in enumerate(force):
        if not is_number(f) or f < LOADED * weight:
            air += 1
            continue
        if air >= AIRBORNE * GRID:
            out.append(i)
        air = 0
    return out


def measure_landing(force, begin):
    """(peak, dip) [N]: the greatest force of the blow, and the least one between it and the end of the window."""
    window = force[begin:begin + int(LANDING * GRID)]
    if len(window) < LANDING * GRID // 2 or not all(map(is_number, window)):
        return None
    crest = max(range(min(len(window), int(BLOW * GRID))), key=window.__getitem__)
    return window[crest], min(window[crest:])


def median(values):
    values = [v for v in values if is_number(v)]
    return statistics.median(values) if values else None


def measure_foot(force, other, weight):
    """Numbers of one foot's vertical force [N] at GRID; `other`: of the other feet together."""
    landings = [x for x in (measure_landing(force, i) for i in find_landings(force, weight)) if x]
    air = LOADED * weight
    pairs = [(f, o) for f, o in zip(force, other) if is_number(f) and is_number(o)]
    return {"landings": len(landings), "peak": median([p for p, _ in landings]), "dip": median([d for _, d in landings]),
            "single_support": median([f for f, o in pairs if f >= air and o < air]),
            "double_support": median([f for f, o in pairs if f >= air and o >= air]),
            "swing": median([f for f, o in pairs if f < air and o >= air]),
            "rms_above_25_hz": math.sqrt(calc_band_power(force)) if len(force) > 1 else None}


def find_weight(table, feet):
    """[N] that the feet carry together: the median over the recording."""
    return median([sum(row) for row in zip(*(table[f"/wrench/{f}/force/z"] for f in feet)) if all(map(is_number, row))]) or 1.0


def measure(table, weight):
    """Numbers of one table: of each foot, of the trunk; time of a fall."""
    fall = find_fall(table)
    end = fall if fall is not None else table["time"][-1]
    grid, feet = make_grid(end), list_feet(table)
    forces = {f: resample(table, f"/wrench/{f}/force/z", grid) for f in feet}
    out = {"fall": fall, "seconds": table["time"][-1], "feet": {}}
    for foot in feet:
        other = [sum(values) for values in zip(*(forces[o] for o in feet if o != foot))] or [0.0] * len(grid)
        out["feet"][foot] = measure_foot(forces[foot], other, weight)
    leans = [v for t, v in zip(table["time"], table.get("trunk lean", [])) if t <= end and is_number(v)]
    out["largest_lean"] = max(leans) if leans else None
    return out


def list_compared(recorded):
    """[(kind, column, unit)] of what the figures show, as far as it was recorded."""
    feet = list_feet(recorded)
    out = [("vertical force", f"/wrench/{f}/force/z", "N") for f in feet]
    out += [("trunk", name, "rad") for name in ("trunk roll", "trunk pitch") if name in recorded]
    out += [("ankle torque", f"/wrench/{f}/torque/{a}", "N m") for a in "yx" for f in feet if f"/wrench/{f}/torque/{a}" in recorded]
    return out


def calc_rms_difference(recorded, simulated, name, end):
    """Root mean square of recorded less simulated up to `end` [s]; None where the two have nothing in common."""
    if name not in simulated or end <= 0:
        return None
    grid = make_grid(end)
    pairs = zip(resample(recorded, name, grid), resample(simulated, name, grid))
    squares = [(a - b) ** 2 for a, b in pairs if math.isfinite(a - b)]
    return math.sqrt(sum(squares) / len(squares)) if squares else None


def find_shift(recorded, simulated, most):
    """[s] by which the recording's clock lags behind the simulation's: joints are nearest to each other there. 0 where
    too few joints are in both."""
    names = [n for n in recorded if n.startswith("/joint_states/") and n.endswith("/position") and n in simulated]
    moving = sorted(names, key=lambda n: -spread(recorded[n]))[:6]
    if not moving:
        return 0.0
    fall = find_fall(simulated)
    end = min(fall if fall is not None else math.inf, simulated["time"][-1])
    times = [k / 50.0 for k in range(int(recorded["time"][-1] * 50.0) + 1)]
    tracks = {n: resample(recorded, n, times) for n in moving}

    def miss(shift):
        total, count = 0.0, 0
        at = [t + shift for t in times]
        for n in moving:
            for a, b, t in zip(tracks[n], resample(simulated, n, at), at):
                if t <= end and math.isfinite(a - b):
                    total, count = total + (a - b) ** 2, count + 1
        # A shift that leaves little to compare proves nothing.
        return total / count if count > 0.5 * len(times) * len(moving) * min(1.0, end / times[-1]) else math.inf

    coarse = min((k / 20.0 for k in range(int(-most * 20), int(most * 20) + 1)), key=miss)
    return min((coarse + k / 200.0 for k in range(-10, 11)), key=miss)


def spread(values):
    values = [v for v in values if is_number(v)]
    return statistics.pstdev(values) if len(values) > 1 else 0.0


def shift_time(table, shift, end):
    """The same on a clock that began `shift` later; what was before, and what comes after `end` on it, is left out."""
    chosen = [i for i, t in enumerate(table["time"]) if -1e-9 <= t - shift <= end + 1e-9]
    first, last = (chosen[0], chosen[-1] + 1) if chosen else (0, 0)
    out = {name: values[first:last] for name, values in table.items()}
    out["time"] = [t - shift for t in out["time"]]
    return out


# Pictures, in the classes of the report's own curves (diagnosis/page/style.h).
WIDTH, HEIGHT, LEFT, TOP, BOTTOM = 560.0, 210.0, 62.0, 20.0, 34.0
MOST_POINTS = 700
CURVES = (("nominal", "before"), ("recording", "recorded"), ("updated", "after"))  # the last one on top


def find_ticks(low, high, count=5):
    raw = (high - low) / count
    base = 10.0 ** math.floor(math.log10(raw)) if raw > 0 else 1.0
    step = next(m * base for m in (1, 2, 5, 10) if m * base >= raw)
    first = math.ceil(low / step)
    return [k * step for k in range(first, int(math.floor(high / step)) + 1)]


def find_range(curves):
    """Of the recording, with room around it; runs that shoot far beyond it are cut off there."""
    values = {css: [v for _, v in points if math.isfinite(v)] for css, points in curves}
    everything = [v for ys in values.values() for v in ys]
    if not everything:
        return 0.0, 1.0
    low, high = min(everything), max(everything)
    if values.get("recorded"):
        room = max(0.6 * (max(values["recorded"]) - min(values["recorded"])), 0.05 * (high - low))
        low, high = max(low, min(values["recorded"]) - room), min(high, max(values["recorded"]) + room)
    return (low, high) if high > low else (low - 1.0, high + 1.0)


def draw(title, unit, curves, end):
    """SVG. curves: [(class, times, values)]."""
    curves = [(css, thin(times, values, end)) for css, times, values in curves]
    low, high = find_range(curves)
    x = lambda t: LEFT + (WIDTH - LEFT - 8) * t / end
    y = lambda v: TOP + (HEIGHT - TOP - BOTTOM) * (high - min(high, max(low, v))) / (high - low)
    out = [f"<svg viewBox='0 0 {WIDTH:g} {HEIGHT:g}' role='img' aria-label='{html.escape(title, quote=True)}'>"
           f"<text class='strong' x='{LEFT:g}' y='13'>{html.escape(title)} [{html.escape(unit)}]</text>"]
    for v in find_ticks(low, high):
        out.append(f"<line class='grid' x1='{LEFT:g}' y1='{y(v):.1f}' x2='{WIDTH - 8:g}' y2='{y(v):.1f}'/>"
                   f"<text x='{LEFT - 5:g}' y='{y(v) + 4:.1f}' text-anchor='end'>{v:g}</text>")
    for t in find_ticks(0.0, end, 8):
        out.append(f"<text x='{x(t):.1f}' y='{HEIGHT - BOTTOM + 16:g}' text-anchor='middle'>{t:g}</text>")
    out.append(f"<text x='{(LEFT + WIDTH) / 2:g}' y='{HEIGHT - 4:g}' text-anchor='middle'>time [s]</text>")
    for css, points in curves:
        if points:
            out.append(f"<polyline class='curve {css}' points='{' '.join(f'{x(t):.1f},{y(v):.1f}' for t, v in points)}'/>")
    return "".join(out) + "</svg>"


def thin(times, values, end):
    """At most MOST_POINTS, least and greatest of each piece, so that no peak is lost."""
    points = [(t, v) for t, v in zip(times, values) if 0.0 <= t <= end and math.isfinite(v)]
    size = max(1, math.ceil(2 * len(points) / MOST_POINTS))
    if size == 1:
        return points
    out = []
    for k in range(0, len(points), size):
        piece = points[k:k + size]
        out += sorted({min(piece, key=lambda p: p[1]), max(piece, key=lambda p: p[1])})
    return out
