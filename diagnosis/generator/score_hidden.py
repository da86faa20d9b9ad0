#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""score_hidden.py DIR: counts a trial of scripts/prove_on_recordings.sh. Prints a table and writes DIR/hidden.json.

DIR/answers/NAME is the answer to the recordings as they are, DIR/answers/NAME-NN the answer with the effect of
DIR/cases/NAME-NN/truth.json in addition. What the machine has by itself is not known. So an answer is judged by what it says
more than the first one:
  named     the effect, or its family, at its place: as supported, or as ambiguous
  value     of that very effect: the first answer's value with the added one is inside the 95 % intervals of both
  wrong     supported findings of other families or places that the first answer neither has nor lists
"""
import json
import math
import pathlib
import sys

from score_dirty import OF, find_width, is_claim, options, place_of, same_place

NEUTRAL = {"scale": 1.0}
ANYWHERE = "base_tilt"  # shows at every joint


def load(path):
    return json.loads(path.read_text()) if path.exists() else None


def is_family(effect, place, hidden):
    return OF.get(effect) == OF.get(hidden["effect"]) and (hidden["effect"] == ANYWHERE or same_place(place, place_of(hidden)))


def find_grade(report, hidden):
    """"supported" or "ambiguous" by the best finding that names the effect or its family at its place; "" without one."""
    grades = {"supported" if is_claim(f) else "ambiguous" for f in report["findings"] if any(is_family(*o, hidden) for o in options(f))}
    return "supported" if "supported" in grades else "ambiguous" if grades else ""


def find_said(report, hidden):
    """(parameter, what is said of it) of a finding of that very effect at its place; None without one."""
    for f in report["findings"]:
        if f["effect"] == hidden["effect"] and same_place(place_of(f), place_of(hidden)):
            return next(((name, said) for name, said in f["parameters"].items() if name in hidden), None)
    return None


def is_value_right(before, after, hidden):
    """None where that very effect is not named."""
    said = find_said(after, hidden)
    if said is None or hidden["effect"] == ANYWHERE:
        return None
    name, now = said
    first = find_said(before, hidden)
    start = first[1]["value"] if first else NEUTRAL.get(name, 0.0)
    expected = start * hidden[name] if name in NEUTRAL else start + hidden[name]
    return abs(now["value"] - expected) <= math.hypot(find_width(now), find_width(first[1]) if first else 0.0)


def list_wrong(before, after, hidden):
    known = [o for f in before["findings"] for o in options(f)] + [(m["effect"], place_of(m)) for m in before.get("model", [])]
    is_known = lambda effect, place: any(OF.get(e) == OF.get(effect) and same_place(p, place) for e, p in known)
    return [f["effect"] + " at " + "/".join(map(str, f["where"].values())) for f in after["findings"]
            if is_claim(f) and not any(is_family(*o, hidden) or is_known(*o) for o in options(f))]


def judge(root, case):
    hidden = load(case / "truth.json")["hidden"][0]
    name = case.name.rsplit("-", 1)[0]
    before, after = (load(root / "answers" / n / "report.json") for n in (name, case.name))
    row = {"case": case.name, "hidden": hidden}
    if not before or not after or after["verdict"] == "not_judged":
        return {**row, "grade": "no answer", "value": None, "wrong": []}
    return {**row, "grade": find_grade(after, hidden), "value": is_value_right(before, after, hidden), "wrong": list_wrong(before, after, hidden)}


def describe(hidden):
    place = place_of(hidden)
    sizes = ", ".join(f"{k} {v:.3g}" for k, v in hidden.items() if isinstance(v, float))
    return f"{hidden['effect']} at {place[1]}: {sizes}"


def print_table(rows):
    print("| recording | added | named | value | wrong |\n|---|---|---|---|---|")
    for r in rows:
        value = {None: "-", True: "inside", False: "outside"}[r["value"]]
        print(f"| {r['case']} | {describe(r['hidden'])} | {r['grade'] or 'no'} | {value} | {'; '.join(r['wrong']) or '-'} |")
    answered = [r for r in rows if r["grade"] != "no answer"]
    valued = [r for r in answered if r["value"] is not None]
    count = lambda word: sum(r["grade"] == word for r in answered)
    print(f"\n{len(answered)} of {len(rows)} answered; named {count('supported') + count('ambiguous')}, of these supported {count('supported')}; "
          f"values inside {sum(r['value'] for r in valued)} of {len(valued)}; answers with a wrong claim {sum(bool(r['wrong']) for r in answered)}")


def main(root):
    rows = [judge(root, case) for case in sorted((root / "cases").iterdir())]
    (root / "hidden.json").write_text(json.dumps(rows, indent=1) + "\n")
    print_table(rows)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
