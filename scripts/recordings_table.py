#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Table of what hrp-diagnose said about real recordings, beside plain least squares. Used by diagnose_recordings.sh."""
import argparse
import json
import pathlib

BEGIN, END = "<!-- table: begin (scripts/diagnose_recordings.sh) -->", "<!-- table: end -->"


def read_json(path):
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return {}


def number(value):
    return f"{value:.3g}" if isinstance(value, (int, float)) else "-"


def place(where):
    return ", ".join(str(v) for v in (where or {}).values())


def parameters(finding):
    out = []
    for name, p in (finding.get("parameters") or {}).items():
        value, interval = p.get("value"), p.get("ci95")
        text = f"{name} {number(value)}" if isinstance(value, (int, float)) else f"{name} {value}"
        if isinstance(value, (int, float)) and isinstance(interval, list) and len(interval) == 2:
            text += f" [{number(interval[0])}, {number(interval[1])}]"
        out.append((text + " " + str(p.get("unit", ""))).strip())
    return "; ".join(out)


def unknown(item):
    if not item.get("where"):
        return "*a model of the drives, nothing in it certain*"
    depends = ", ".join(map(str, item.get("depends_on") or []))
    return f"*unknown at {place(item['where'])}" + (f", depends on {depends}*" if depends else "*")


def found(report):
    lines = [f"{f.get('effect', '?').replace('_', ' ')} at {place(f.get('where'))}: {parameters(f)}"
             for f in report.get("findings") or []]
    lines += [unknown(u) for u in report.get("unexplained") or []]
    return "<br>".join(lines) or "-"


def row(folder, out):
    name = pathlib.Path(folder).resolve().name
    report, run = read_json(out / name / "report.json"), read_json(out / name / "run.json")
    baseline = (read_json(out / name / "baseline.json").get("fit") or {})
    fit = report.get("fit") or {}
    which = "validate" if fit.get("validate") or baseline.get("validate") else "train"
    mine, plain = fit.get(which) or {}, baseline.get(which) or {}
    verdict = report.get("verdict") or f"no answer (exit status {run.get('status')})"
    return [name, verdict, found(report), which, number(mine.get("before")), number(mine.get("after")), number(plain.get("after")),
            number(run.get("seconds"))]


def make_table(rows):
    head = ["recording", "verdict", "what was found", "judged on", "nominal", "tool", "least squares", "s"]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(cell.replace("|", "/") for cell in r) + " |" for r in rows])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--page", type=pathlib.Path)
    args = parser.parse_args()
    table = make_table([row(folder, args.out) for folder in args.folders])
    print(table)
    if args.page:
        text = args.page.read_text()
        before, rest = text.split(BEGIN)
        args.page.write_text(before + BEGIN + "\n" + table + "\n" + END + rest.split(END)[1])


if __name__ == "__main__":
    main()
