# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the proof's page, as SVG. Only the Python standard library."""
import collections
import html
import math

GOOD, TWIN, QUIET, BAD = "#2f8f4e", "#7fb77e", "#c9a227", "#c0392b"
# Quiet: the tool did not say enough. Bad: it said something that is not so.
COLOURS = {"right": GOOD, "right among twins": TWIN, "missed": QUIET, "partly": QUIET, "no answer": QUIET,
           "false alarm": QUIET, "wrong place": BAD, "wrong cause": BAD, "extra finding": BAD, "false finding": BAD}


def svg(width, height, parts):
    return (f'<svg viewBox="0 0 {width} {height}" width="{width}" style="max-width:100%;font:12px system-ui;fill:currentColor"'
            f' role="img">' + "".join(parts) + "</svg>")


def text(x, y, words, anchor="start", extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {extra}>{html.escape(str(words))}</text>'


def bar(x, y, w, h, colour, title):
    return f'<rect x="{x:.1f}" y="{y:.1f}" width="{w:.1f}" height="{h:.1f}" fill="{colour}"><title>{html.escape(title)}</title></rect>'


def draw_families(cases):
    """One bar a family, a piece an outcome."""
    families = collections.OrderedDict()
    for c in sorted(cases, key=lambda c: c.family()):
        families.setdefault(c.family(), collections.Counter())[c.word] += 1
    most = max(sum(f.values()) for f in families.values())
    scale, parts, y = 480 / most, [], 6
    for family, words in families.items():
        parts.append(text(150, y + 13, family, "end"))
        x = 158
        for word in sorted(words, key=lambda w: list(COLOURS).index(w) if w in COLOURS else 99):
            parts.append(bar(x, y, words[word] * scale - 1, 17, COLOURS.get(word, "#888"), f"{words[word]} {word}"))
            x += words[word] * scale
        parts.append(text(x + 6, y + 13, f"{words['right'] + words['right among twins']} of {sum(words.values())}"))
        y += 23
    for x, colour, word in ((158, GOOD, "right"), (230, QUIET, "said too little"), (350, BAD, "named what is not there")):
        parts += [bar(x, y + 4, 11, 11, colour, word), text(x + 16, y + 14, word)]
    return svg(720, y + 24, parts)


def draw_confusion(cases):
    """Hidden (rows) against named (columns); the larger the share of the row, the darker."""
    counts = collections.Counter(label for c in cases for label in c.labels())
    rows = sorted({t for t, _ in counts})
    columns = sorted({f for _, f in counts}, key=lambda f: (f.startswith("("), f))
    cell, left, top, parts = 17, 210, 150, []
    for i, name in enumerate(columns):
        x = left + i * cell + 12
        parts.append(text(x, top - 6, name, "start", f'transform="rotate(-60 {x} {top - 6})"'))
    for r, name in enumerate(rows):
        y, total = top + r * cell, sum(n for (t, _), n in counts.items() if t == name)
        parts.append(text(left - 6, y + 13, name, "end"))
        for i, found in enumerate(columns):
            n = counts[(name, found)]
            if not n:
                continue
            fine = name == found or (name.startswith("(unlisted)") and found in ("(unexplained)", "(partly_explained)")) or \
                (name == "(nothing)" and found == "(no_mismatch)")
            colour = GOOD if fine else QUIET if found.startswith("(") else BAD
            parts.append(f'<g opacity="{0.35 + 0.65 * n / total:.2f}">' +
                         bar(left + i * cell, y, cell - 1, cell - 1, colour, f"{name}: {found} {n}") + "</g>")
            parts.append(text(left + i * cell + 8, y + 12, n, "middle", 'font-size="10"'))
    return svg(left + len(columns) * cell + 120, top + len(rows) * cell + 8, parts)


def draw_parameters(cases):
    """Relative error of every parameter on a logarithmic scale; hollow: outside its interval."""
    rows = collections.OrderedDict()
    for c in cases:
        for effect, key, _, _, error, within in c.parameters:
            rows.setdefault(f"{effect} {key}", []).append((error, within, c.name))
    if not rows:
        return ""
    place = lambda e: 260 + 90 * (math.log10(min(max(e, 1e-5), 1)) + 5)
    parts, height = [], 30 + 17 * len(rows)
    for power in range(-5, 1):
        x = place(10.0 ** power)
        parts += [f'<path d="M{x} 8V{height - 18}" stroke="currentColor" opacity=".15"/>',
                  text(x, height - 4, f"{100 * 10.0 ** power:g} %", "middle")]
    x = place(0.05)
    parts.append(f'<path d="M{x} 8V{height - 18}" stroke="{BAD}" stroke-dasharray="3 3"/>')
    for i, (name, values) in enumerate(sorted(rows.items())):
        y = 18 + 17 * i
        parts.append(text(250, y + 4, name, "end"))
        for error, within, case in values:
            fill = "none" if within is False else GOOD
            parts.append(f'<circle cx="{place(error):.1f}" cy="{y}" r="4" fill="{fill}" stroke="{BAD if within is False else GOOD}">'
                         f"<title>{case}: {100 * error:.2g} %{', outside its interval' if within is False else ''}</title></circle>")
    return svg(740, height, parts)


def draw_fits(cases):
    """Held-out error before and after, in noise floors: below the dashed line is 1.2 and better."""
    points = [(c.fit("before"), c.fit("after"), c) for c in cases]
    points = [p for p in points if p[0] is not None and p[1] is not None and p[0] > 0 and p[1] > 0]
    if not points:
        return ""
    top = max(2, math.ceil(math.log10(max(p[0] for p in points))))
    step = 300 / (top + 0.5)
    place = lambda v: step * (math.log10(min(max(v, 0.4), 10.0 ** top)) + 0.4)
    parts = [f'<path d="M50 20V320H350" stroke="currentColor" fill="none" opacity=".5"/>',
             f'<path d="M50 {320 - place(1.2):.1f}H350" stroke="{GOOD}" stroke-dasharray="4 3"/>']
    for power in range(top + 1):
        at = place(10.0 ** power)
        parts += [text(50 + at, 336, f"{10 ** power:g}", "middle"), text(44, 324 - at, f"{10 ** power:g}", "end")]
    parts += [text(200, 354, "before [noise floors]", "middle"), text(54, 14, "after [noise floors]")]
    for before, after, c in points:
        parts.append(f'<circle cx="{50 + place(before):.1f}" cy="{320 - place(after):.1f}" r="4" fill="{COLOURS.get(c.word, "#888")}"'
                     f' opacity=".8"><title>{html.escape(c.name + ": " + c.word)}</title></circle>')
    return svg(420, 360, parts)


def make_figures(cases, clean):
    """Section's name -> picture."""
    pictures = {"By family": draw_families(cases), "Every case": draw_fits(cases)}
    if clean:
        pictures |= {"What was hidden and what was named": draw_confusion(clean), "Parameters": draw_parameters(clean)}
    return pictures
