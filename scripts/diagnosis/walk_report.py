# SPDX-License-Identifier: BSD-3-Clause
"""A recorded walk beside the walks that the nominal and the updated model make: numbers for report.json and the terminal,
pictures for report.html."""
import html
import math
import pathlib

import walk_figures as figures

BEGIN, END = "<!-- resimulated -->", "<!-- /resimulated -->"
# What a row of the table says: of the run, of each foot.
ROWS = (("landings", "landings", ""), ("peak", "peak at landing", "N"), ("dip", "dip after it", "N"),
        ("single_support", "plateau, single support", "N"), ("double_support", "plateau, double support", "N"),
        ("swing", "in swing", "N"), ("rms_above_25_hz", "above 25 Hz, rms", "N"))


def make_walk(recorded, nominal, updated):
    """The part `walk` of resimulated.json: the same numbers of all three, and how far each run is from the recording."""
    tables = {"recording": recorded, "nominal": nominal, "updated": updated}
    for table in tables.values():
        figures.add_attitude(table)
    known = recorded if figures.list_feet(recorded) else updated
    weight = figures.find_weight(known, figures.list_feet(known))
    numbers = {which: figures.measure(table, weight) for which, table in tables.items()}
    add_power(numbers)
    return {"weight": weight, "numbers": numbers, "differences": list_differences(recorded, nominal, updated)}


def add_power(numbers):
    """Power above 25 Hz over the recording's, by foot."""
    for which in ("nominal", "updated"):
        for foot, values in numbers[which]["feet"].items():
            there = numbers["recording"]["feet"].get(foot, {}).get("rms_above_25_hz")
            here = values["rms_above_25_hz"]
            values["power_over_recording"] = (here / there) ** 2 if there and figures.is_number(here) else None


def list_differences(recorded, nominal, updated):
    out = []
    for kind, column, unit in figures.list_compared(recorded):
        row = {"kind": kind, "signal": column, "unit": unit}
        for which, table in (("nominal", nominal), ("updated", updated)):
            row[which] = figures.calc_rms_difference(recorded, table, column, min(recorded["time"][-1], table["time"][-1]))
        out.append(row)
    return out


def form(value, unit=""):
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "-"
    return f"{value:.3g}{' ' + unit if unit else ''}" if abs(value) < 1000 else f"{value:.0f}{' ' + unit if unit else ''}"


def form_fall(run):
    if run["fall"] is not None:
        return f"{run['fall']:.2f} s"
    return "not recorded" if run["largest_lean"] is None else "none"


def list_rows(walk):
    """[[name, recording, nominal, updated]] as text."""
    numbers = walk["numbers"]
    runs = [numbers[which] for which in ("recording", "nominal", "updated")]
    rows = [["falls at"] + [form_fall(run) for run in runs],
            ["largest lean of the trunk"] + [form(run["largest_lean"], "rad") for run in runs]]
    for foot in numbers["updated"]["feet"]:
        for key, name, unit in ROWS:
            rows.append([f"{foot}: {name}"] + [form(run["feet"].get(foot, {}).get(key), unit) for run in runs])
        rows.append([f"{foot}: power above 25 Hz over the recording's", "1"] + [form(run["feet"][foot]["power_over_recording"]) for run in runs[1:]])
    for row in walk["differences"]:
        rows.append([f"rms difference of {row['signal']}", "0"] + [form(row[w], row["unit"]) for w in ("nominal", "updated")])
    return rows


def print_rows(rows):
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    return "\n".join("  ".join(cell.ljust(widths[0]) if k == 0 else cell.rjust(max(12, widths[k])) for k, cell in enumerate(row)).rstrip() for row in rows)


def say_walk(result):
    head = [["", "recording", "nominal", "updated"]]
    return print_rows(head + list_rows(result["walk"]))


def until_fall(table):
    fall = figures.find_fall(table)
    if fall is None:
        return table
    last = next(i for i, t in enumerate(table["time"]) if t >= fall) + 1
    return {name: values[:last] for name, values in table.items()}


def draw_all(recorded, nominal, updated):
    """[SVG] as in the papers' figures 3 to 9; a run ends where the robot has fallen."""
    tables = {"recording": recorded, "nominal": until_fall(nominal), "updated": until_fall(updated)}
    end, out = recorded["time"][-1], []
    for kind, column, unit in figures.list_compared(recorded):
        curves = [(css, tables[which]["time"], tables[which][column]) for which, css in figures.CURVES if column in tables[which]]
        title = f"{kind}, {column.split('/')[2]}, {'about ' + column[-1] if 'torque' in kind else 'z'}" if "/" in column else column
        out.append(figures.draw(title, unit, curves, end))
    return out


def make_section(result, pictures):
    how = {"closed loop": f"with {html.escape(str(result.get('controller')))} in the loop"}.get(result["loop"], "with the recording's commands")
    rows = "".join("<tr><td>" + "</td><td>".join(html.escape(cell) for cell in row) + "</td></tr>" for row in list_rows(result["walk"]))
    shift = result.get("shift", 0.0)
    late = f" The recording began {shift:.3g} s after the controller." if shift else ""
    notes = "".join(f"<li>{html.escape(note)}</li>" for note in result.get("notes", []))
    return (f"{BEGIN}<section aria-labelledby='resimulated'><h2 id='resimulated'>Simulated again</h2>"
            f"<p>{html.escape(pathlib.Path(result['recording']).name)} simulated again {how}: the nominal model and the updated one.{late}</p>"
            + (f"<ul>{notes}</ul>" if notes else "") +
            "<p class='key'><span class='line recorded'></span>recording<span class='line before'></span>nominal"
            "<span class='line after'></span>with what was found</p>"
            "<div class='plots'>" + "".join(f"<figure>{svg}</figure>" for svg in pictures) + "</div>"
            "<div class='wide' tabindex='0'><table><thead><tr><th scope='col'></th><th scope='col'>recording</th><th scope='col'>nominal</th>"
            f"<th scope='col'>updated</th></tr></thead><tbody>{rows}</tbody></table></div></section>{END}\n")


def put_section(page, section):
    """Before the page's end; what an earlier run put there goes."""
    text = page.read_text()
    if BEGIN in text and END in text:
        text = text[:text.index(BEGIN)] + text[text.index(END) + len(END):].lstrip("\n")
    at = text.find("<section aria-labelledby='updated'")
    at = at if at >= 0 else text.rfind("</main>")
    page.write_text(text[:at] + section + text[at:])
