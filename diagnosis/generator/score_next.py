#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Counts a trial of scripts/prove_next.sh: what one round of proposed motions decides, against one of multisines.

score_next.py DIR           the table, and DIR/next.json
score_next.py DIR --open    names of the cases that need another round, one a line
"""
import argparse
import csv
import json
import math
import pathlib
import statistics
import xml.etree.ElementTree

import score_dirty
import score_judge

KINDS = ("proposed", "multisines")
FLOOR = 0.002  # of a value: no report's half width is smaller


def judge(truth, report):
    """Twins that are still listed are no decision; in a dirty world every effect of a tenth of its joint's mismatch counts."""
    if not report:
        return "no answer"  # refused, none in time, or the hidden robot could not play the motion
    return score_dirty.Tally(truth, report).word() if score_dirty.is_dirty(truth) else score_judge.judge(truth, report)[0]


def is_right(truth, report):
    return judge(truth, report) == "right"


def count_named(case, kind):
    """Of a dirty world: effects of a tenth of their joint's mismatch that are named by family, and all of them."""
    if not score_dirty.is_dirty(case["truth"]):
        return 0, 0
    tally = score_dirty.Tally(case["truth"], case[kind] or None)
    return len(tally.named), len(tally.weighty)


def list_real(truth):
    return truth["hidden"] + truth.get("background", [])


def count_wrong(truth, report):
    """Certain or supported findings of effects that are not there."""
    claims = [f for f in (report or {}).get("findings") or [] if score_dirty.is_claim(f)]
    real = list_real(truth)
    places = lambda h: score_dirty.place_of(h)
    return sum(not any(h["effect"] == e and score_dirty.same_place(places(h), p) for h in real
                       for e, p in score_dirty.options(f)) for f in claims)


def list_half_widths(truth, report):
    """Half of the 95 % interval of every parameter of a finding that is there, by effect, place and parameter."""
    widths = {}
    for finding in (report or {}).get("findings") or []:
        place = score_dirty.place_of(finding)
        if not any(h["effect"] == finding["effect"] and score_dirty.same_place(score_dirty.place_of(h), place) for h in list_real(truth)):
            continue
        for name, said in finding["parameters"].items():
            if said.get("ci95"):
                widths[finding["effect"], place, name] = score_dirty.find_width(said)
    return widths


def read_case(root, name):
    truth = score_judge.read_json(root / "first/truths" / f"{name}.json")
    case = {"name": name, "truth": truth}
    for kind in ("first",) + KINDS:
        answer = root / kind / "answers" / name
        case[kind] = (score_judge.read_json(answer / "report.json") or {}) if (answer / "run.json").exists() else None
    case["made"] = {kind: (root / kind / "cases" / name / "experiment.yaml").exists() for kind in KINDS}
    case["next"] = score_judge.read_json(root / "first/answers" / name / "next/next.json") or {}
    return case


def is_open(case):
    if any(h["effect"] in score_judge.UNKNOWN for h in case["truth"]["hidden"]):
        return False
    several = len(case["next"].get("explanations", [])) > 1
    return case["first"] is not None and bool(case["next"].get("motions")) and (several or not is_right(case["truth"], case["first"]))


def find_size(value):
    return max(map(abs, value)) if isinstance(value, list) else abs(value)


def list_least(proposal):
    """Half widths that no motion lowers, as the proposal says, by label and parameter."""
    return {(i["effect"], i["parameter"]): i.get("least_half_width", 0.0) for motion in proposal.get("motions", [])[:1] for i in motion.get("intervals", [])}


def list_wide(report, proposal):
    """Parameters whose interval can be halved: wider than twice the floor of all reports, and than twice what no motion lowers."""
    least = list_least(proposal)

    def is_wide(finding, name, said):
        place = score_dirty.place_of(finding)
        floor = max(FLOOR * find_size(said["value"]), least.get((f"{finding['effect']}@{place[1]}", name), 0.0))
        return said.get("ci95") and score_dirty.find_width(said) > 2 * floor

    return {(f["effect"], score_dirty.place_of(f), name) for f in (report or {}).get("findings") or []
            for name, said in f["parameters"].items() if is_wide(f, name, said)}


def find_ratios(case, kind, wide=False):
    before, after = (list_half_widths(case["truth"], case[k]) for k in ("first", kind))
    keys = [key for key in before if key in after and before[key] > 0 and math.isfinite(after[key])]
    kept = list_wide(case["first"], case["next"]) if wide else keys
    return [after[key] / before[key] for key in keys if key in kept]


def read_ranges(urdf):
    """Lowest and highest position of every joint that has limits."""
    limits = ((joint.get("name"), joint.find("limit")) for joint in xml.etree.ElementTree.parse(urdf).getroot().iter("joint"))
    return {name: (float(limit.get("lower")), float(limit.get("upper"))) for name, limit in limits
            if limit is not None and limit.get("lower") and limit.get("upper")}


def list_passed(root, case, kind):
    """Recordings of added motions in which a joint passes what its URDF allows."""
    folder, passed = root / kind / "cases" / case["name"], []
    paths = sorted(folder.glob("next_*.csv"))
    ranges = read_ranges(folder / "robot.urdf") if paths else {}
    columns = [(f"/joint_states/{name}/position", ends) for name, ends in ranges.items()]
    for path in paths:
        rows = list(csv.DictReader(path.read_text().splitlines()))
        if any(row.get(column) and not ends[0] <= float(row[column]) <= ends[1] for row in rows for column, ends in columns):
            passed.append(path.name)
    return passed


def summarise(root, cases):
    opened = [c for c in cases if is_open(c) and all(c[k] is not None for k in KINDS)]
    named = [count_named(c, "first") for c in opened]
    out = {"cases": len(cases), "open": sum(map(is_open, cases)), "answered": len(opened),
           "first_right": sum(is_right(c["truth"], c["first"]) for c in opened),
           "first_wrong_names": sum(count_wrong(c["truth"], c["first"]) for c in opened),
           "first_named": sum(of for of, _ in named),
           "weighty": sum(of_all for _, of_all in named)}
    for kind in KINDS:
        ratios = [r for c in opened for r in find_ratios(c, kind)]
        wide = [r for c in opened for r in find_ratios(c, kind, wide=True)]
        out[kind] = {"right": sum(is_right(c["truth"], c[kind]) for c in opened),
                     "wrong_names": sum(count_wrong(c["truth"], c[kind]) for c in opened),
                     "median_interval_ratio": statistics.median(ratios) if ratios else None, "intervals": len(ratios),
                     "named": sum(count_named(c, kind)[0] for c in opened),
                     "median_wide_ratio": statistics.median(wide) if wide else None, "wide_intervals": len(wide)}
    # The hidden robot falls or throws a joint off its command at once: no recording comes of it.
    out["not_played"] = [c["name"] for c in opened if not c["made"]["proposed"]]
    out["loads"] = sum(bool(m.get("loads")) for c in opened for m in c["next"]["motions"])
    out["limits_passed"] = {kind: [name for c in opened for name in list_passed(root, c, kind)] for kind in KINDS}
    return out, opened


def print_table(out, opened):
    number = lambda x: "-" if x is None else f"{x:.2f}"
    n = out["answered"]
    print(f"{out['cases']} cases, {out['open']} open after the first recordings, {n} of them answered after both rounds\n")
    print("| | first recordings | + proposed motions | + multisines as long | bar |\n|---|---|---|---|---|")
    a, b = out["proposed"], out["multisines"]
    print(f"| open cases answered rightly | {out['first_right']} of {n} | {a['right']} of {n} | {b['right']} of {n} | 80 % |")
    if out["weighty"]:
        print(f"| dirty worlds: effects of a tenth named | {out['first_named']} of {out['weighty']} | {a['named']} | {b['named']} | 90 % |")
    print(f"| median of intervals, against before | 1 | {number(a['median_interval_ratio'])} ({a['intervals']}) | {number(b['median_interval_ratio'])} ({b['intervals']}) | 0.5 |")
    print(f"| of those that can be halved | 1 | {number(a['median_wide_ratio'])} ({a['wide_intervals']}) | {number(b['median_wide_ratio'])} ({b['wide_intervals']}) | 0.5 |")
    print(f"| wrong names | {out['first_wrong_names']} | {a['wrong_names']} | {b['wrong_names']} | not more |")
    print(f"| motions in which a limit was passed | | {len(out['limits_passed']['proposed'])} | {len(out['limits_passed']['multisines'])} | 0 |")
    print(f"| falls, and motions that could not be played | | {len(out['not_played'])} | {sum(not c['made']['multisines'] for c in opened)} | 0 |\n")
    print(f"{out['loads']} of {sum(len(c['next']['motions']) for c in opened)} proposed motions ask for a load by hand\n")
    for c in opened:
        words = [judge(c["truth"], c[k]) for k in ("first",) + KINDS]
        print(c["name"], "+".join(h["effect"] for h in c["truth"]["hidden"]) + ":", " | ".join(words))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--open", action="store_true")
    args = parser.parse_args()
    cases = [read_case(args.folder, path.stem) for path in sorted((args.folder / "first/truths").glob("*.json"))]
    if args.open:
        print("\n".join(c["name"] for c in cases if is_open(c)))
        return
    out, opened = summarise(args.folder, cases)
    (args.folder / "next.json").write_text(json.dumps(out, indent=1) + "\n")
    print_table(out, opened)


if __name__ == "__main__":
    main()
