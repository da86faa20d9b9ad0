#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Scores the answers of hrp-diagnose against the truths of hrp-make-cases, in text and as a web page.

Knows nothing of either program: reads ANSWERS/NAME/report.json (and run.json: exit status, seconds) and
TRUTHS/NAME.json. Only the Python standard library."""
import argparse
import collections
import html
import json
import pathlib
import sys

import proof_figures
import score_dirty
from score_dirty import share
from score_judge import UNKNOWN, Case, place_of, read_json


def load(args):
    cases = []
    for path in sorted(pathlib.Path(args.truths).glob("*.json")):
        folder = pathlib.Path(args.answers) / path.stem
        cases.append(Case(path.stem, read_json(path), read_json(folder / "report.json"), read_json(folder / "run.json")))
    return cases


def median(values):
    values = sorted(values)
    return values[len(values) // 2] if values else float("nan")


def table_families(cases):
    by = collections.OrderedDict()
    for c in cases:
        by.setdefault(c.family(), []).append(c)
    rows = []
    for family, members in sorted(by.items()):
        words = collections.Counter(c.word for c in members)
        rows.append([family, len(members), share(sum(c.right for c in members), len(members)),
                     ", ".join(f"{n} {w}" for w, n in words.most_common())])
    return ["family", "cases", "right", "outcomes"], rows


def table_effects(cases):
    by = {}
    for c in cases:
        for h in c.truth["hidden"]:
            by.setdefault(h["effect"], []).append(any(h is p for p, _ in c.pairs) or (h["effect"] in UNKNOWN and c.right))
    return (["effect", "times hidden", "named in its place"],
            [[e, len(v), share(sum(v), len(v))] for e, v in sorted(by.items())])


def table_confusion(cases):
    counts = collections.Counter(label for c in cases for label in c.labels())
    rows = []
    for truth in sorted({t for t, _ in counts}):
        found = [(f, n) for (t, f), n in counts.items() if t == truth]
        rows.append([truth, ", ".join(f"{f} {n}" for f, n in sorted(found, key=lambda x: (-x[1], x[0])))])
    return ["hidden", "named"], rows


def table_parameters(cases):
    by = {}
    for c in cases:
        for effect, key, _, _, error, within in c.parameters:
            by.setdefault((effect, key), []).append((error, within))
    rows = []
    for (effect, key), values in sorted(by.items()):
        known = [w for _, w in values if w is not None]
        good = sum(e <= 0.05 or bool(w) for e, w in values)
        rows.append([effect, key, len(values), f"{100 * median([e for e, _ in values]):.2f} %",
                     f"{100 * max(e for e, _ in values):.1f} %", share(sum(known), len(known)), share(good, len(values))])
    return ["effect", "parameter", "n", "median error", "largest", "inside 95 % interval", "within 5 % or interval"], rows


def table_fit(cases):
    rows = []
    for c in cases:
        hidden = " + ".join(h["effect"] + " " + str(place_of(h)[1]) for h in c.truth["hidden"]) or "nothing"
        said = " + ".join(f.get("effect", "?") + " " + str(place_of(f)[1]) for f in (c.report or {}).get("findings") or [])
        rows.append([c.name, c.family(), hidden, (c.report or {}).get("verdict", "none"), said or "-", c.word,
                     number(c.fit("before")), number(c.fit("after")), number(c.run.get("seconds"))])
    return ["case", "family", "hidden", "verdict", "named", "outcome", "before", "after", "s"], rows


def number(value):
    return f"{value:.3g}" if isinstance(value, (int, float)) else "-"


def summary(cases):
    dirty = [c for c in cases if c.dirty]
    clean = [c for c in cases if not c.dirty]
    return ((summary_clean(clean) if clean else []) + (score_dirty.summary([c.dirty for c in dirty]) if dirty else []) +
            summary_runs(cases))


def summary_clean(cases):
    count = lambda c: len({h["effect"] for h in c.truth["hidden"]})
    listed = [c for c in cases if c.truth["hidden"] and not c.unlisted]
    single = [c for c in listed if count(c) == 1 and "pair" not in c.family()]
    pair = [c for c in listed if "pair" in c.family()]
    triple = [c for c in listed if "triple" in c.family()]
    none = [c for c in cases if not c.truth["hidden"]]
    unknown = [c for c in cases if c.unlisted]
    rows = [row for c in cases for row in c.parameters]
    known = [w for *_, w in rows if w is not None]
    fits = [c.fit("after") for c in listed if c.fit("after") is not None]
    wrong = ("wrong cause", "wrong place", "extra finding", "false finding")
    yes = lambda some: share(sum(c.right for c in some), len(some))
    return [
        ["single effects named in the right place, nothing else named (bar: 95 %)", yes(single)],
        ["pairs (bar: 85 %)", yes(pair)],
        ["triples", yes(triple)],
        ["nothing hidden, nothing found (bar: all)", yes(none)],
        ["physics outside the list: place given, no cause named (bar: all)", yes(unknown)],
        ["... of these with a wrong cause named (bar: none)", share(sum(c.word == "wrong cause" for c in unknown), len(unknown))],
        ["cases of any kind with something named that is not there", share(sum(c.word in wrong for c in cases), len(cases))],
        ["parameters within 5 % or inside their interval", share(sum(r[4] <= 0.05 or bool(r[5]) for r in rows), len(rows))],
        ["parameters inside their 95 % interval (bar: 95 in 100)", share(sum(known), len(known))],
        ["held-out fit at most 1.2 noise floors (listed effects)", share(sum(f <= 1.2 for f in fits), len(fits))]]


def summary_runs(cases):
    seconds = [c.run["seconds"] for c in cases if isinstance(c.run.get("seconds"), (int, float))]
    return [
        ["median seconds a case; longest", f"{number(median(seconds))}; {number(max(seconds, default=None))}"],
        ["runs without an answer", share(sum(c.report is None for c in cases), len(cases))]]


def sections(cases):
    clean, dirty = [c for c in cases if not c.dirty], [c.dirty for c in cases if c.dirty]
    out = [("Summary", (["question", "answer"], summary(cases))), ("By family", table_families(cases))]
    if clean:
        out += [("By effect", table_effects(clean)), ("What was hidden and what was named", table_confusion(clean)),
                ("Parameters", table_parameters(clean))]
    if dirty:
        out += [("Dirty worlds: effects", score_dirty.table_effects(dirty)),
                ("Dirty worlds: values", score_dirty.table_intervals(dirty))]
    return out + [("Every case", table_fit(cases))]


def print_table(head, rows):
    cells = [[str(c) for c in row] for row in [head] + rows]
    widths = [min(60, max(len(r[i]) for r in cells)) for i in range(len(head))]
    for i, row in enumerate(cells):
        print("  " + "  ".join(c.ljust(w) for c, w in zip(row, widths)).rstrip())
        if i == 0:
            print("  " + "  ".join("-" * w for w in widths))


def describe_miss(case):
    if case.dirty:
        return score_dirty.describe(case.name, case.dirty)
    lines = [f"{case.name}: {case.word}"]
    lines += ["  hidden: " + json.dumps(h) for h in case.truth["hidden"]] or ["  hidden: nothing"]
    if case.report is None:
        return lines + [f"  no report; exit status {case.run.get('status')}: {case.run.get('tail', '')}"]
    lines.append(f"  verdict: {case.report.get('verdict')}")
    for f in case.report.get("findings") or []:
        values = {k: v.get("value") for k, v in (f.get("parameters") or {}).items()}
        lines.append(f"  named: {f.get('effect')} at {place_of(f)[1]} p={f.get('probability')} {json.dumps(values)}")
    for u in case.report.get("unexplained") or []:
        lines.append(f"  unexplained: {json.dumps(u.get('where'))} depends on {u.get('depends_on')}: {u.get('statement', '')}")
    for n in case.report.get("not_identifiable") or []:
        lines.append(f"  cannot tell: {n.get('effect')}: {n.get('why', '')}")
    return lines


STYLE = """:root{color-scheme:light dark}body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:78rem;padding:0 1rem}
table{border-collapse:collapse;margin:.5rem 0 1.5rem;font-size:14px}th,td{text-align:left;padding:.25rem .7rem;
border-bottom:1px solid #8884;vertical-align:top}th{position:sticky;top:0;background:Canvas}pre{white-space:pre-wrap;
border-left:3px solid #c60;padding-left:.8rem}.wide{overflow-x:auto}code{overflow-wrap:anywhere}"""


def html_table(head, rows):
    cell = lambda tag, row: "".join(f"<{tag}>{html.escape(str(c))}</{tag}>" for c in row)
    return ("<div class=wide><table><thead><tr>" + cell("th", head) + "</tr></thead><tbody>" +
            "".join("<tr>" + cell("td", row) + "</tr>" for row in rows) + "</tbody></table></div>")


def make_page(cases, title, notes):
    parts = ["<!DOCTYPE html><html lang=en><head><meta charset=utf-8><meta name=viewport content='width=device-width'>",
             f"<title>{html.escape(title)}</title><style>{STYLE}</style></head><body><h1>{html.escape(title)}</h1>"]
    parts += [f"<p><code>{html.escape(note)}</code></p>" for note in notes]
    pictures = proof_figures.make_figures(cases, [c for c in cases if not c.dirty])
    for name, (head, rows) in sections(cases):
        parts.append(f"<h2>{html.escape(name)}</h2>{pictures.get(name, '')}{html_table(head, rows)}")
    parts.append("<h2>Every miss</h2>")
    misses = [c for c in cases if not c.right]
    parts += [f"<pre>{html.escape(chr(10).join(describe_miss(c)))}</pre>" for c in misses] or ["<p>None.</p>"]
    return "".join(parts) + "</body></html>\n"


README_BEGIN, README_END = "<!-- proof: begin", "<!-- proof: end -->"


def make_readme_block(cases, notes):
    """The last run's summary and families as Markdown, as they came."""
    lines = [README_BEGIN + " (scripts/prove_concealed.sh --readme docs/diagnosis_proof.md) -->", "| question | answer |", "|---|---|"]
    lines += [f"| {q} | {a} |" for q, a in summary(cases)]
    lines += ["", "| family | cases | right | outcomes |", "|---|---|---|---|"]
    lines += ["| " + " | ".join(str(x) for x in row) + " |" for row in table_families(cases)[1]]
    return "\n".join(lines + ["", "; ".join(notes) + ".", README_END])


def write_readme(path, cases, notes):
    text = path.read_text()
    # The page's own words also name the marks: only a mark that begins a line is one.
    begin = text.find("\n" + README_BEGIN) + 1
    end = text.find("\n" + README_END, begin) + 1
    if begin <= 0 or end < begin:
        sys.exit(f"{path}: has no block from '{README_BEGIN} ... -->' to '{README_END}'")
    path.write_text(text[:begin] + make_readme_block(cases, notes) + text[end + len(README_END):])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--truths", required=True)
    parser.add_argument("--answers", required=True)
    parser.add_argument("--html")
    parser.add_argument("--json", help="the summary for programs")
    parser.add_argument("--readme", help="file whose proof block is rewritten")
    parser.add_argument("--note", action="append", default=[])
    args = parser.parse_args()
    cases = load(args)
    if not cases:
        sys.exit("no truths found in " + args.truths)
    for name, (head, rows) in sections(cases):
        print(f"\n{name}")
        print_table(head, rows)
    print("\nEvery miss")
    for case in cases:
        if not case.right or case.dirty:
            print("\n".join("  " + line for line in describe_miss(case)))
    if args.html:
        pathlib.Path(args.html).write_text(make_page(cases, "Proof on concealed cases", args.note))
    if args.readme:
        write_readme(pathlib.Path(args.readme), cases, args.note)
    if args.json:
        pathlib.Path(args.json).write_text(json.dumps({"summary": summary(cases), "outcomes": {c.name: c.word for c in cases}}, indent=1) + "\n")


if __name__ == "__main__":
    main()
