# SPDX-License-Identifier: BSD-3-Clause
"""Judges one answer of hrp-diagnose against its truth: what counts as right, wrong and missed."""
import json
import math

import score_dirty

PLACE_KEYS = ("joint", "link", "foot", "sensor", "ground")
# True of the simulated transmission, but not what defines the effect (design: backlash {gap}).
NOT_SCORED = {"backlash": {"stiffness", "damping", "rotor_inertia"}, "foot_compliance": {"center"}}
UNKNOWN = {"mechanical_stop", "position_dependent_friction", "friction_drift", "periodic_disturbance",
           "quadratic_drag", "joint_coupling", "intermittent_slip", "cubic_spring", "magnetic_detent",
           "thermal_torque_loss", "sprung_mass", "gust", "cable", "sticky_sole", "hip_bend"}
# Acts on a body, so every joint that carries the body shows it.
ON_BODY = {"sprung_mass", "gust", "cable", "sticky_sole", "hip_bend"}
# Unlisted physics that a finding may list among its alternatives, though no scenario can hold it.
LISTED_AS = {"hip_bend": "link_bending"}


def read_json(path):
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return None


def place_of(entry):
    where = entry.get("where", entry)
    for key in PLACE_KEYS:
        if isinstance(where, dict) and key in where:
            return key, where[key]
    return "", ""


def same_place(truth, found):
    """A sensor may be named as a whole or by its quantity; the ground needs no name."""
    kind, name = truth
    other_kind, other = found
    if kind == "ground":
        return other_kind in ("ground", "foot", "")
    if kind != other_kind:
        return False
    return name == other or (kind == "sensor" and (name.startswith(other + "/") or other.startswith(name + "/")))


def names(finding):
    """The finding and, where the tool says it cannot tell twins apart, its alternatives."""
    options = [finding] + list(finding.get("alternatives") or [])
    return [(o.get("effect", ""), place_of(o) if place_of(o)[0] else place_of(finding)) for o in options]


def lists_unlisted(hidden, finding):
    """Whether a finding lists the hidden physics at its place: links behind a joint are named after it."""
    twin = LISTED_AS.get(hidden["effect"])
    return any(effect == twin and place[1].lower().startswith(place_of(hidden)[1].lower())
               for effect, place in names(finding)[1:])


def judge(truth, report):
    """Outcome of one case: word, matched pairs (hidden, finding), hidden left over, findings left over."""
    hidden = truth["hidden"]
    if report is None:
        return "no answer", [], hidden, []
    listed = [h for h in hidden if h["effect"] not in UNKNOWN]
    bent = [f for f in report.get("findings") or [] for h in hidden if lists_unlisted(h, f)]
    left, pairs, twins = list(report.get("findings") or []), [], False
    missing = []
    for h in listed:
        match = None
        for f in left:
            options = names(f)
            hits = [i for i, (e, p) in enumerate(options) if e == h["effect"] and same_place(place_of(h), p)]
            if hits:
                match, twins = f, twins or hits[0] > 0
                break
        if match is None:
            missing.append(h)
        else:
            left.remove(match)
            pairs.append((h, match))
    if any(h["effect"] in UNKNOWN for h in hidden):
        if bent:
            left.remove(bent[0])
            return "extra finding" if left else "right among twins", pairs, missing, left
        return judge_unknown(hidden, report, left), pairs, missing, left
    if not hidden:
        return ("right" if not left and report.get("verdict") == "no_mismatch" else
                "false finding" if left else "false alarm"), pairs, missing, left
    if missing:
        wrong_place = any(f.get("effect") == h["effect"] for f in left for h in missing)
        word = "wrong place" if wrong_place else "wrong cause" if left else "partly" if pairs else "missed"
    else:
        word = "extra finding" if left else "right among twins" if twins else "right"
    return word, pairs, missing, left


def judge_unknown(hidden, report, left):
    if left:
        return "wrong cause"
    if report.get("verdict") == "no_mismatch":
        return "missed"
    joints = {h.get("joint") for h in hidden} | {h.get("other") for h in hidden}
    places = [place_of(u)[1] for u in report.get("unexplained") or []]
    if any(h["effect"] in ON_BODY for h in hidden):
        return "right" if places else "wrong place"
    return "right" if any(p in joints for p in places) else "wrong place"


def flatten(value):
    return [float(v) for v in value] if isinstance(value, list) else [float(value)]


def compare_parameters(hidden, finding):
    """Rows (effect, parameter, truth, value, relative error, inside the interval or None)."""
    rows = []
    if finding.get("effect") != hidden["effect"]:
        return rows
    for key, true_value in hidden.items():
        said = (finding.get("parameters") or {}).get(key)
        if said is None or key in NOT_SCORED.get(hidden["effect"], ()) or isinstance(true_value, str):
            continue
        truth, value = flatten(true_value), flatten(said["value"])
        if len(truth) != len(value):
            continue
        if key == "phase":
            value = [t + math.remainder(v - t, 2 * math.pi) for v, t in zip(value, truth)]
        size = math.sqrt(sum(t * t for t in truth)) or 1.0
        error = math.sqrt(sum((v - t) ** 2 for v, t in zip(value, truth))) / (math.pi if key == "phase" else size)
        rows.append((hidden["effect"], key, truth, value, error, inside(said, truth, value)))
    return rows


def inside(said, truth, value):
    interval = said.get("ci95")
    if not interval:
        return None
    pairs = interval if isinstance(interval[0], list) else [interval]
    if len(pairs) != len(truth):
        return None
    raw = flatten(said["value"])
    # An angle was unwound towards the truth; its interval moves along.
    return all(lo + v - r <= t <= hi + v - r for (lo, hi), t, v, r in zip(pairs, truth, value, raw))


class Case:
    def __init__(self, name, truth, report, run):
        self.name, self.truth, self.report, self.run = name, truth, report, run or {}
        self.word, self.pairs, self.missing, self.extra = judge(truth, report)
        self.dirty = score_dirty.Tally(truth, report) if score_dirty.is_dirty(truth) else None
        if self.dirty:
            self.word, self.pairs, self.missing, self.extra = self.dirty.word(), [], [], []
        self.parameters = [row for h, f in self.pairs for row in compare_parameters(h, f)]
        self.right = self.word in ("right", "right among twins")

        self.unlisted = any(h["effect"] in UNKNOWN for h in truth["hidden"])

    def family(self):
        return self.truth.get("family", "?")

    def fit(self, when):
        value = (((self.report or {}).get("fit") or {}).get("validate") or {}).get(when)
        return value if isinstance(value, (int, float)) else None

    def labels(self):
        """(true label, found label) for the confusion matrix, one entry for each thing hidden or found."""
        found = [(h["effect"], f.get("effect", "?")) for h, f in self.pairs]
        verdict = "no answer" if self.report is None else self.report.get("verdict", "?")
        rest = [f.get("effect", "?") for f in self.extra]
        hidden = [h for h in self.truth["hidden"] if h["effect"] in UNKNOWN] + self.missing
        for h in hidden:
            label = "(unlisted) " + h["effect"] if h["effect"] in UNKNOWN else h["effect"]
            found.append((label, rest.pop(0) if rest else "(" + verdict + ")"))
        if not self.truth["hidden"] and not rest:
            found.append(("(nothing)", "(" + verdict + ")"))
        return found + [("(nothing)", r) for r in rest]
