#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tables of what hrp-diagnose said about real recordings, beside other models. Used by diagnose_recordings.sh."""
import argparse
import json
import pathlib
import re

BEGIN, END = "<!-- table: begin (scripts/diagnose_recordings.sh) -->", "<!-- table: end -->"

MODELS = ["nominal", "least squares", "ticked", "friction model", "published", "tool"]


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
        text = f"{name} [{', '.join(map(number, value))}]" if isinstance(value, list) else f"{name} {number(value)}"
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
    groups = {}
    for f in report.get("findings") or []:
        groups.setdefault((f.get("grade", "certain"), f.get("effect", "?")), []).append(f)
    lines = []
    for (grade, effect), members in groups.items():
        name = f"{effect.replace('_', ' ')} ({grade})"
        if len(members) > 2:
            lines.append(f"{name} at {len(members)} places: {value_range(members)}")
        else:
            lines += [f"{name} at {place(f.get('where'))}: {parameters(f)}" for f in members]
    lines += [unknown(u) for u in report.get("unexplained") or [] if not groups]
    return "<br>".join(lines) or "-"


def value_range(members):
    values = []
    for f in members:
        for p in (f.get("parameters") or {}).values():
            if isinstance(p.get("value"), (int, float)):
                values.append((p["value"], p.get("unit", "")))
            break
    if not values:
        return "-"
    return f"{number(min(values)[0])} to {number(max(values)[0])} {values[0][1]}".strip()


def row(folder, out):
    name = pathlib.Path(folder).resolve().name
    report, run = read_json(out / name / "report.json"), read_json(out / name / "run.json")
    fit = report.get("fit") or {}
    verdict = report.get("verdict") or f"no answer (exit status {run.get('status')})"
    mine = fit.get("validate") or fit.get("train") or {}
    return [name, verdict, found(report), f"{number(mine.get('before'))} to {number(mine.get('after'))}", number(run.get("seconds"))]


def floor_share(path):
    """Mean share of the effort's spread that the plain baseline leaves; it prints 'of its torque A -> B missing'."""
    try:
        left = [float(x) for x in re.findall(r"of its torque [\d.]+ -> ([\d.]+) missing", path.read_text())]
    except OSError:
        return None
    return sum(left) / len(left) if left else None


def comparison(folder, out):
    name = pathlib.Path(folder).resolve().name
    models = read_json(out / name / "baseline.json").get("models") or {}
    if not models:
        return []
    rows = []
    for kind, unit in (("position", "rad"), ("effort", "N m")):
        cells = [number(((models.get(m) or {}).get(kind) or {}).get("all")) for m in MODELS]
        rows.append([name, f"{kind} [{unit}]"] + cells + [number(floor_share(out / name / "floor.txt")) if kind == "effort" else "-"])
    return rows


TICKED = [("viscous_friction", "coefficient", "damping", "N m s/rad"), ("coulomb_friction", "level", "friction loss", "N m"),
          ("rotor_inertia", "inertia", "armature", "kg m^2")]


def ticked_values(joints):
    """Smallest and largest value of each ticked parameter over the joints."""
    out = []
    for effect, parameter, name, unit in TICKED:
        values = [j[effect][parameter] for j in joints.values() if effect in j]
        if values:
            low, high = number(min(values)), number(max(values))
            out.append(f"{name} {low if low == high else f'{low} to {high}'} {unit}")
    return "; ".join(out) or "-"


def answers(folder, out):
    name = pathlib.Path(folder).resolve().name
    baseline = read_json(out / name / "baseline.json")
    other = baseline.get("answers")
    if not other:
        return []
    errors = baseline.get("friction_models") or {}
    tried = ", ".join(f"{model.split(':')[0]} {number(error)}" for model, error in errors.items())
    chosen = (other.get("friction model") or {}).get("model", "-")
    return [[name, ticked_values(other["ticked"]["joints"]), tried or "-", chosen]]


def make_table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(cell.replace("|", "/") for cell in r) + " |" for r in rows])


def make_tables(folders, out):
    head = ["recording", "verdict", "what was found", "its own measure, nominal to tool", "s"]
    compared = ["recording", "error"] + MODELS + ["plain baseline, share"]
    asked = ["recording", "ticked parameters", "position error of M1 to M5 [rad]", "friction model that is chosen"]
    return "\n\n".join([make_table(head, [row(f, out) for f in folders]),
                        make_table(compared, [r for f in folders for r in comparison(f, out)]),
                        make_table(asked, [r for f in folders for r in answers(f, out)])])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--page", type=pathlib.Path)
    args = parser.parse_args()
    table = make_tables(args.folders, args.out)
    print(table)
    if args.page:
        text = args.page.read_text()
        before, rest = text.split(BEGIN)
        args.page.write_text(before + BEGIN + "\n" + table + "\n" + END + rest.split(END)[1])


if __name__ == "__main__":
    main()
