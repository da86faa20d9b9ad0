# SPDX-License-Identifier: BSD-3-Clause
"""Counts of worlds like reality: every joint has friction and a rotor, a little follows no law of the list.

What is claimed is compared by family, by effect and by value. Only the Python standard library."""
import math

MATTERS = 0.1  # share of its joint's mismatch from which an effect has to be named
SEEN = 1.0     # torque over the noise of the joint's effort, below which no log shows an effect: a joint that stands still
FAMILIES = {
    "dry friction": ("coulomb_friction", "stribeck_friction", "load_dependent_friction", "backdriving_friction"),
    "speed-dependent loss": ("viscous_friction", "back_emf"),
    "reflected inertia": ("rotor_inertia", "inertia_error"),
    "mass and its place": ("payload", "mass_error", "com_error"),
    "gain": ("torque_constant_error", "servo_gain_error", "sensor_scale"),
    "timing": ("command_delay", "actuator_lag", "sensor_delay", "clock_skew"),
    "give and play": ("joint_elasticity", "backlash", "hysteresis", "foot_compliance", "foot_hardening"),
    "torque over position": ("parallel_spring", "cogging", "gravity_compensation"),
    "zero": ("joint_offset", "sensor_bias", "ground_slope", "external_force", "constant_torque", "base_tilt"),
    "limits": ("torque_saturation", "velocity_limit", "dead_zone"),
    "contact": ("ground_friction", "restitution"),
    "geometry of sensors": ("sensor_misalignment",)}
# What only a drive's effort or its command shows.
OF_DRIVES = ("dry friction", "speed-dependent loss", "reflected inertia", "gain", "torque over position", "limits")
OF = {effect: family for family, effects in FAMILIES.items() for effect in effects}
PLACES = ("joint", "link", "foot", "sensor", "ground")


def is_dirty(truth):
    return "background" in truth


def place_of(entry):
    """A reading of a joint is at that joint."""
    where = entry.get("where", entry)
    for key in PLACES:
        if isinstance(where, dict) and key in where:
            name = where[key]
            if key == "sensor" and name.startswith("/joint_states/"):
                return "joint", name.split("/")[2]
            return key, name
    return "", ""


def same_place(a, b):
    if "ground" in (a[0], b[0]):
        return a[0] == b[0]
    if a[0] == b[0] == "sensor":
        return a[1] == b[1] or a[1].startswith(b[1] + "/") or b[1].startswith(a[1] + "/")
    return a == b


def list_blind(truth):
    """Families of effects at joints of which no log tells: neither efforts nor commands were recorded."""
    return OF_DRIVES if {"/joint_states/*/effort", "/joint_commands/"} <= set(truth.get("missing") or []) else ()


def options(finding):
    """(effect, place) of a finding and of its alternatives."""
    own = place_of(finding)
    return [(finding.get("effect", ""), own)] + [
        (a.get("effect", ""), place_of(a) if place_of(a)[0] else own) for a in finding.get("alternatives") or []]


def is_claim(finding):
    return finding.get("grade", "certain") in ("certain", "supported")


def list_seen(said, axes):
    """The axes of a vector of which the report says that they show."""
    return [a for name, a in zip("xyz", axes) if name not in said.get("unseen", [])] if len(axes) == 3 else axes


def inside(said, truth):
    """Whether the 95 % interval holds the truth; None where there is no interval."""
    interval = said.get("ci95")
    if not interval:
        return None
    pairs = interval if isinstance(interval[0], list) else [interval]
    values = list_seen(said, truth) if isinstance(truth, list) else [truth]
    pairs = list_seen(said, pairs) if isinstance(truth, list) else pairs
    return len(pairs) == len(values) and all(lo <= t <= hi for (lo, hi), t in zip(pairs, values))


def find_width(said):
    """Half of the 95 % interval; of a vector, the longest axis."""
    interval = said.get("ci95") or [0, 0]
    return max((hi - lo) / 2 for lo, hi in (interval if isinstance(interval[0], list) else [interval]))


class Tally:
    def __init__(self, truth, report):
        self.truth, self.report = truth, report
        self.findings = list((report or {}).get("findings") or [])
        self.listed = truth["hidden"] + truth["background"]
        blind = list_blind(truth)
        self.weighty = [e for e in truth.get("influence", [])
                        if e["share"] >= MATTERS and not (place_of(e)[0] == "joint" and OF.get(e["effect"]) in blind)]
        self.named = [e for e in self.weighty if self.is_named(e, self.findings)]
        self.seen = [e for e in self.weighty if e.get("over_noise", SEEN) >= SEEN]
        self.named_seen = [e for e in self.seen if e in self.named]
        self.claims = [f for f in self.findings if is_claim(f)]
        self.claimed = [e for e in self.weighty if self.is_named(e, self.claims)]
        self.true_family = [f for f in self.claims if self.has(self.same_family(*options(f)[0]))]
        self.true_effect = [f for f in self.claims if any(self.has(self.same_effect(*o)) for o in options(f))]
        self.intervals = [row for f in self.claims for row in self.list_intervals(f)]
        self.ratio = self.find_ratio()

    @staticmethod
    def is_named(entry, findings):
        return any(OF.get(e, e) == OF.get(entry["effect"]) and same_place(p, place_of(entry))
                   for f in findings for e, p in options(f))

    def has(self, test):
        return any(test(h) for h in self.listed)

    @staticmethod
    def same_family(effect, place):
        return lambda h: OF.get(h["effect"], h["effect"]) == OF.get(effect, effect) and same_place(place_of(h), place)

    @staticmethod
    def same_effect(effect, place):
        return lambda h: h["effect"] == effect and same_place(place_of(h), place)

    def list_intervals(self, finding):
        """(effect, place, parameter, truth, value, relative error, half width, inside) of a finding whose very effect is there."""
        test = self.same_effect(*options(finding)[0])
        hidden = next((h for h in self.listed if test(h)), None)
        rows = []
        for key, said in (finding.get("parameters") or {}).items():
            if hidden is None or key not in hidden or key == "phase":
                continue
            true, value = hidden[key], said["value"]
            if isinstance(true, list):
                true, value = list_seen(said, true), list_seen(said, value)
            size = math.dist(true, [0] * len(true)) if isinstance(true, list) else abs(true)
            miss = math.dist(true, value) if isinstance(true, list) else abs(true - value)
            rows.append((hidden["effect"], place_of(hidden)[1], key, true, value, miss / (size or 1.0),
                         find_width(said) / (size or 1.0), inside(said, hidden[key])))
        return rows

    def find_ratio(self):
        """Held-out error over that of the true listed effects, both over the noise of each signal."""
        listed, signals = self.truth.get("listed_error"), ((self.report or {}).get("fit") or {}).get("per_signal") or {}
        both = [(listed[s], signals[s]["after"]) for s in listed or {} if s in signals]
        if not both:
            return None
        ours = sum((after * t["spread"] / t["noise"]) ** 2 for t, after in both)
        true = sum((t["error"] / t["noise"]) ** 2 for t, _ in both)
        return math.sqrt(ours / true)

    def word(self):
        if self.report is None:
            return "no answer"
        if len(self.true_family) < len(self.claims):
            return "extra finding"
        return "right" if len(self.named) == len(self.weighty) else "partly" if self.named else "missed"


def share(part, whole):
    return f"{part} of {whole}" + (f" ({100 * part / whole:.0f} %)" if whole else "")


def summary(tallies):
    every = lambda key: sum(len(getattr(t, key)) for t in tallies)
    known = [row[-1] for t in tallies for row in t.intervals if row[-1] is not None]
    ratios = sorted(t.ratio for t in tallies if t.ratio is not None)
    on_top = [h for t in tallies for h in t.truth["hidden"]]
    found = [h for t in tallies for h in t.truth["hidden"] if t.is_named(h, t.findings)]
    middle = f"; median ratio {ratios[len(ratios) // 2]:.2f}, largest {ratios[-1]:.2f}" if ratios else ""
    return [
        ["dirty worlds: effects of a tenth of a joint's mismatch named at their place, by family (bar: 90 %)",
         share(every("named"), every("weighty"))],
        ["... without those whose torque is below the noise of the joint's effort", share(every("named_seen"), every("seen"))],
        ["... of all in a supported or certain finding", share(every("claimed"), every("weighty"))],
        ["... effects on top, of any size, named at their place by family", share(len(found), len(on_top))],
        ["supported or certain findings whose family is there (bar: 95 %)", share(every("true_family"), every("claims"))],
        ["... whose effect, or a listed alternative, is there (bar: 90 %)", share(every("true_effect"), every("claims"))],
        ["intervals of supported findings that hold the truth (bar: 90 %)", share(sum(known), len(known))],
        ["held-out error at most 1.2 times that of the true listed effects",
         share(sum(r <= 1.2 for r in ratios), len(ratios)) + middle]]


def table_intervals(tallies):
    by = {}
    for t in tallies:
        for effect, _, key, _, _, error, width, within in t.intervals:
            by.setdefault((effect, key), []).append((error, width, within))
    rows = []
    for (effect, key), values in sorted(by.items()):
        errors, widths = sorted(v[0] for v in values), sorted(v[1] for v in values)
        known = [v[2] for v in values if v[2] is not None]
        rows.append([effect, key, len(values), f"{100 * errors[len(errors) // 2]:.1f} %", f"{100 * errors[-1]:.0f} %",
                     f"{100 * widths[len(widths) // 2]:.0f} %", share(sum(known), len(known))])
    return ["effect", "parameter", "n", "median error", "largest", "median half interval", "inside 95 % interval"], rows


def table_effects(tallies):
    by = {}
    for t in tallies:
        for e in t.weighty:
            by.setdefault(e["effect"], []).append((e in t.named, e in t.claimed))
    return (["effect of a tenth or more", "times", "named by family", "supported or certain"],
            [[e, len(v), share(sum(n for n, _ in v), len(v)), share(sum(c for _, c in v), len(v))]
             for e, v in sorted(by.items())])


def describe(name, tally):
    """What was missed and what was claimed that is not there, a line each."""
    verdict = (tally.report or {}).get("verdict", "no answer")
    top = ", ".join(f"{h['effect']} {place_of(h)[1]}" for h in tally.truth["hidden"]) or "nothing"
    ratio = "-" if tally.ratio is None else f"{tally.ratio:.2f}"
    lines = [f"{name}: {verdict}; on top: {top}; drive {tally.truth.get('drive')}; error ratio {ratio}"]
    for e in tally.weighty:
        if e not in tally.named:
            lines.append(f"  missed: {e['effect']} at {place_of(e)[1]}, share {e['share']:.2f}")
    for f in tally.claims:
        if f not in tally.true_effect:
            word = "effect" if f in tally.true_family else "family"
            lines.append(f"  wrong {word}: {f.get('effect')} at {place_of(f)[1]} ({f.get('grade')})")
    for effect, place, key, true, value, error, _, within in tally.intervals:
        if within is False:
            lines.append(f"  interval: {effect} {key} at {place}: {value}, true {true} ({100 * error:.0f} % off)")
    return lines
