// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/page/page.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "common/base/join_words.h"
#include "common/base/write_file.h"
#include "diagnosis/page/by_joint.h"
#include "diagnosis/page/checks.h"
#include "diagnosis/page/lead.h"
#include "diagnosis/page/plots.h"
#include "diagnosis/page/style.h"
#include "diagnosis/page/text.h"

namespace hrp::diagnosis {
namespace {

using namespace html;
std::string make_section(const char* id, const std::string& title, const std::string& body) {
  if (body.empty()) return "";
  return "<section aria-labelledby='" + std::string(id) + "'><h2 id='" + id + "'>" + title + "</h2>" + body +
         "</section>\n";
}

std::string make_row(const std::vector<std::string>& cells) {
  std::string out = "<tr>";
  for (const std::string& c : cells) out += "<td>" + c + "</td>";
  return out + "</tr>";
}

std::string make_header(const json& report, const json& series) {
  const VerdictWords& words = find_verdict_words(get_text(report, "verdict"));
  const std::string name = shorten_path(get_text(series, "experiment")), robot = get_text(series, "robot");
  std::string out =
      "<header><p class='over'>Simulation against recording" + (robot.empty() ? "" : ": " + escape(robot)) + "</p>";
  out += "<h1><span class='badge " + escape(get_text(report, "verdict")) + "'>" + words.badge + "</span> " +
         escape(name) + "</h1>";
  return out + make_lead(report) + "</header>\n";
}

std::string format_probability(double p) {
  if (!std::isfinite(p)) return "-";
  const std::string text = p < 0.001 ? "below 0.001" : format_number(p, 3);
  return "<span class='num'><span class='meter' style='--p:" + format_number(std::clamp(p, 0.0, 1.0), 3) + "'></span>" +
         text + "</span>";
}

// One row, or one for each axis where value and interval are lists.
std::string make_parameter_rows(const std::string& effect, const std::string& place, const std::string& name,
                                const json& p) {
  const json& value = get(p, "value");
  if (value.is_array()) {
    std::string out;
    for (std::size_t i = 0; i < value.size(); ++i) {
      json part{{"value", value[i]}, {"unit", get(p, "unit")}};
      for (const char* key : {"std", "ci95"}) {
        if (get(p, key).is_array() && i < get(p, key).size()) part[key] = get(p, key)[i];
      }
      out += make_parameter_rows(effect, place,
                                 name + " " + (value.size() == 3 ? std::string(1, "xyz"[i]) : std::to_string(i)), part);
    }
    return out;
  }
  const std::vector<double> ci = get_numbers(p, "ci95");
  const double v = get_number(p, "value"), low = ci.size() == 2 ? ci[0] : kNone, high = ci.size() == 2 ? ci[1] : kNone;
  const std::string unit = get_text(p, "unit");
  return make_row({escape(effect), escape(place), escape(name),
                   "<b>" + format_value(value) + "</b>" + (unit == "1" ? "" : " " + escape(typeset(unit))),
                   ci.size() == 2 ? format_number(low) + " to " + format_number(high) : "-",
                   make_interval_svg(v, low, high)});
}

std::string make_finding_card(const json& f, const std::string& effect, const std::string& place) {
  const std::string grade = get_text(f, "grade");
  std::string out = "<article class='card" + std::string(grade == "ambiguous" ? " warn" : "") + "'><h3>" +
                    escape(effect) + "<span class='place'>" + escape(place) + "</span></h3><p>" +
                    escape(typeset(get_text(f, "statement"))) + "</p><p class='small'>" +
                    (grade.empty() ? "" : "<b>" + escape(grade) + "</b>, ") + "probability " +
                    format_probability(get_number(f, "probability")) + "</p>";
  std::string others;
  for (const json& a : get_list(f, "alternatives")) {
    others += "<li>" + escape(describe_effect(get_text(a, "effect"))) + ", " + escape(describe_place(get(a, "where"))) +
              ": " + escape(describe_parameters(a)) +
              ". To tell them apart: " + escape(get_text(a, "motion_that_would_tell")) + ".</li>";
  }
  if (!others.empty())
    out += "<p class='small'>These recordings cannot tell it from:</p><ul class='small'>" + others + "</ul>";
  return out + "</article>";
}

// What each finding takes away of its place's mismatch, largest first.
std::string make_shares(const json& report) {
  std::string rows;
  for (const json& f : get_list(report, "findings")) {
    const double share = get_number(f, "share");
    if (!std::isfinite(share)) continue;
    rows += make_row({escape(describe_effect(get_text(f, "effect"))), escape(describe_place(get(f, "where"))),
                      escape(get_text(f, "grade")), format_probability(share)});
  }
  return make_table({"finding", "where", "grade", "takes away of its place's mismatch"}, rows);
}

std::string make_remaining(const json& report) {
  std::string rows;
  for (const json& r : get_list(report, "remaining")) {
    const std::string on = join_values(get_list(r, "depends_on"));
    const std::string unit = " " + escape(get_text(r, "unit"));
    rows += make_row({escape(describe_place(get(r, "where"))), format_number(get_number(r, "before"), 3) + unit,
                      format_number(get_number(r, "after"), 3) + unit, format_probability(get_number(r, "share")),
                      on.empty() ? "-" : on});
  }
  if (rows.empty()) return "";
  const double ceiling = get_number(report, "ceiling"), explained = get_number(report, "explained");
  return "<p>The findings take away " + format_number(100.0 * explained, 3) +
         " % of the mismatch on held-out recordings. At most " + format_number(100.0 * ceiling, 3) +
         " % can be predicted from what was recorded.</p>" +
         make_table({"where", "before", "after", "left", "follows"}, rows);
}

std::string make_joint_rows(const JointTable& table) {
  std::string out;
  for (size_t j = 0; j < table.joints.size(); ++j) {
    std::vector<std::string> cells{escape(table.joints[j])};
    for (const JointTable::Cell& cell : table.cells[j]) {
      cells.push_back(join_words(
          cell,
          [](const auto& entry) {
            return "<span class='" + std::string(entry.ambiguous ? "unsure" : "num") + "'>" + escape(entry.text) +
                   "</span>";
          },
          "<br>"));
    }
    out += make_row(cells);
  }
  return out;
}

std::string make_findings(const json& report) {
  std::string cards, rows;
  for (const json& f : get_list(report, "findings")) {
    const std::string effect = describe_effect(get_text(f, "effect")), place = describe_place(get(f, "where"));
    cards += make_finding_card(f, effect, place);
    for (const auto& [name, p] : get_object(f, "parameters").items()) {
      rows += make_parameter_rows(effect, place, name, p);
    }
  }
  if (cards.empty()) return "";
  std::string each = "<div class='cards'>" + cards + "</div>" +
                     make_table({"effect", "where", "parameter", "value", "95 % interval", "against zero"}, rows);
  const JointTable table = make_joint_table(report);
  if (table.joints.empty()) return each;
  std::vector<std::string> head;
  for (const std::string& name : table.head) head.push_back(escape(name));
  return "<p>Values with 95 % intervals, joint by joint. <span class='unsure'>Grey and slanted: ambiguous.</span></p>" +
         make_table(head, make_joint_rows(table)) +
         "<details><summary>Every finding, and what it cannot be told from</summary>" + each + "</details>";
}

std::string make_unexplained(const json& report) {
  std::string out;
  for (const json& u : get_list(report, "unexplained")) {
    const std::string on = join_values(get_list(u, "depends_on"));
    out += "<article class='card warn'><h3>Something unknown<span class='place'>" +
           escape(describe_place(get(u, "where"))) + "</span></h3><p>" + escape(typeset(get_text(u, "statement"))) +
           "</p>" + (on.empty() ? "" : "<p class='small'>Depends on: " + on + ".</p>") + "</article>";
  }
  return out.empty() ? "" : "<div class='cards'>" + out + "</div>";
}

std::string format_intervals(const json& list) {
  std::string out;
  int shown = 0;
  for (const json& i : list.is_array() ? list : json::array()) {
    if (!i.is_array() || i.size() != 2) continue;
    if (++shown > 4) return out + ", and " + std::to_string(list.size() - 4) + " more";
    out += (out.empty() ? "" : ", ") + format_value(i[0], 4) + " to " + format_value(i[1], 4);
  }
  return out.empty() ? "-" : out + " s";
}

// One row a signal: where it is worst, and in how many recordings it shows. The worst dozen first, the rest folded
// away.
std::string make_mismatch_table(const json& report) {
  std::vector<const json*> worst;
  std::map<std::string, std::set<std::string>> recordings;
  for (const json& m : get_list(report, "mismatch")) {
    const std::string signal = get_text(m, "signal");
    recordings[signal].insert(get_text(m, "recording"));
    const auto same =
        std::find_if(worst.begin(), worst.end(), [&](const json* w) { return get_text(*w, "signal") == signal; });
    if (same == worst.end())
      worst.push_back(&m);
    else if (get_number(m, "score", 0) > get_number(**same, "score", 0))
      *same = &m;
  }
  std::string first, rest;
  for (std::size_t i = 0; i < worst.size(); ++i) {
    const json& m = *worst[i];
    const std::string signal = get_text(m, "signal");
    (i < 12 ? first : rest) +=
        make_row({"<code>" + escape(signal) + "</code>", format_number(get_number(m, "score"), 3),
                  escape(get_text(m, "recording")), format_intervals(get(m, "intervals")),
                  escape(get_text(m, "regime")), std::to_string(recordings[signal].size())});
  }
  const std::vector<std::string> head{"signal", "worst score [noise]", "in", "when", "regime", "recordings"};
  if (rest.empty()) return make_table(head, first);
  return make_table(head, first) + "<details><summary>" + std::to_string(worst.size() - 12) +
         " more signals</summary>" + make_table(head, rest) + "</details>";
}

std::string make_legend() {
  std::string out = "<p class='legend' aria-hidden='true'><span>1 x noise</span>";
  for (int i = 1; i <= 9; ++i)
    out += "<svg viewBox='0 0 20 12' class='swatch'><rect class='heat h" + std::to_string(i) +
           "' width='20' height='12'/></svg>";
  return out + "<span>100 x noise</span></p>";
}

std::string make_maps(const json& series) {
  std::string out;
  for (const json& r : get_list(series, "recordings")) {
    const std::string before = make_map_svg(r, get(series, "signals"), "before");
    if (before.empty()) continue;
    const std::string role = get_text(r, "role");
    out += "<details" + std::string(out.empty() ? " open" : "") + "><summary>" + escape(get_text(r, "file")) +
           (role.empty() ? ""
                         : " <span class='small'>(" + escape(role == "validate" ? "held out" : "used for fitting") +
                               ")</span>") +
           "</summary><div class='wide map' tabindex='0'><h4>with the nominal model</h4>" + before;
    const std::string after = make_map_svg(r, get(series, "signals"), "after");
    out += (after.empty() ? "" : "<h4>with what was found</h4>" + after) + "</div></details>";
  }
  if (out.empty()) return "";
  return "<p>Each row is a signal, each column a stretch of time; the stronger the colour, the further the recording "
         "is from the prediction, "
         "in units of that signal's noise. Strips above mark what the robot was doing.</p>" +
         make_legend() + out;
}

std::string make_rivals(const json& series) {
  std::string rows;
  for (const json& r : get_list(series, "rivals")) {
    const json& chosen = get(r, "chosen");
    const bool won = chosen.is_boolean() && chosen.get<bool>();
    rows += std::string(won ? "<tr class='won'>" : "<tr>") + "<td>" + escape(describe_effect(get_text(r, "effect"))) +
            (won ? " <b>chosen</b>" : "") + "</td><td>" + escape(describe_place(get(r, "where"))) + "</td><td>" +
            format_probability(get_number(r, "probability")) + "</td><td>" +
            format_number(get_number(r, "validate_score"), 4) + "</td><td>" + escape(get_text(r, "why")) + "</td></tr>";
  }
  return make_table({"explanation", "where", "probability", "held-out error [noise]", "why"}, rows);
}

std::string format_si(const json& signal, const char* key) {
  const double value = get_number(signal, key);
  return std::isfinite(value) ? format_number(value, 3) + " " + escape(get_text(signal, "unit")) : "-";
}

std::string make_per_signal(const json& fit) {
  std::string rows;
  for (const auto& [name, s] : get_object(fit, "per_signal").items()) {
    rows += make_row({"<code>" + escape(name) + "</code>", format_number(get_number(s, "before"), 3),
                      format_number(get_number(s, "after"), 3), format_si(s, "rms_before"), format_si(s, "rms_after")});
  }
  const std::string table = make_table({"signal", "before", "after", "rms before", "rms after"}, rows);
  return table.empty()
             ? ""
             : "<details><summary>Every signal (error over the recording's own standard deviation)</summary>" + table +
                   "</details>";
}

std::string make_prediction_note(const json& report, const json& series) {
  const json& p = get(report, "prediction").is_object() ? get(report, "prediction") : get(series, "prediction");
  const std::string method = get_text(p, "method");
  if (method.empty()) return "";
  const double horizon = get_number(p, "horizon");
  return "<p class='small'>Predicted: " + escape(method) +
         (horizon > 0.0 ? ", horizon " + format_number(horizon) + " s" : "") + ".</p>";
}

std::string make_traces(const json& series, const char* role) {
  std::string out;
  for (const json& r : get_list(series, "recordings")) {
    if (get_text(r, "role") != role) continue;
    std::string plots;
    for (const json& t : get_list(r, "traces")) plots += make_trace_svg(t, get(series, "signals"));
    if (!plots.empty()) out += "<h4>" + escape(get_text(r, "file")) + "</h4><div class='plots'>" + plots + "</div>";
  }
  return out;
}

// Efforts of the worst joints along the recorded motion; nothing is simulated, so nothing drifts.
std::string make_torque_traces(const json& series) {
  const json& torque = get_object(series, "torque_traces");
  std::string plots;
  for (const json& t : get_list(torque, "traces")) plots += make_trace_svg(t, get(torque, "signals"));
  return plots.empty() ? ""
                       : "<h3>Torque along the recorded motion, " + escape(get_text(torque, "recording")) +
                             "</h3><div class='plots'>" + plots + "</div>";
}

std::string make_show(const json& report, const json& series) {
  const json& fit = get(report, "fit");
  std::string out;
  for (const auto& [key, words] : {std::pair{"validate", "Held-out recordings, never used for fitting"},
                                   std::pair{"train", "Recordings used for fitting"}}) {
    const double before = get_number(get(fit, key), "before"), after = get_number(get(fit, key), "after");
    if (std::isfinite(before) || std::isfinite(after))
      out += "<h3>" + std::string(words) + "</h3><div class='bars'>" + make_fit_svg(before, after, words) + "</div>";
  }
  out += make_prediction_note(report, series);
  const std::string held = make_torque_traces(series) + make_traces(series, "validate"),
                    train = make_traces(series, "train");
  if (!held.empty() || !train.empty()) {
    out +=
        "<p class='key'><span class='line recorded'></span> recorded <span class='line before'></span> nominal model "
        "<span class='line after'></span> with what was found</p>";
  }
  out += held;
  if (!train.empty())
    out += "<details><summary>The same on recordings used for fitting</summary>" + train + "</details>";
  return out + make_per_signal(fit);
}

std::string make_clouds(const json& series) {
  std::string out;
  for (const json& c : get_list(series, "clouds")) {
    const std::string svg = make_cloud_svg(c);
    if (!svg.empty())
      out += "<figure><figcaption>" + escape(get_text(c, "title")) + "</figcaption>" + svg + "</figure>";
  }
  return out.empty() ? "" : "<div class='plots'>" + out + "</div>";
}

std::string make_updated(const json& series) {
  const json& updated = get(series, "updated");
  const std::string text = get_text(updated, "text"), command = get_text(updated, "command");
  std::string out;
  if (updated.contains("limp"))
    out += "<p>It replays nothing: <code>drive: effort</code> has no servo. Run it with your own controller.</p>";
  else if (!command.empty())
    out += "<p>Run it:</p><pre tabindex='0'>" + escape(command) + "</pre>";
  if (!text.empty())
    out += "<details><summary>" + escape(get_text(updated, "scenario", "scenario")) + "</summary><pre tabindex='0'>" +
           escape(text) + "</pre></details>";
  return out;
}

std::string make_limits(const json& report, const json& series) {
  std::string rows, notes;
  for (const json& n : get_list(report, "not_identifiable")) {
    const std::string place = describe_place(get(n, "where"));
    rows += make_row({escape(describe_effect(get_text(n, "effect"))) + (place.empty() ? "" : ", " + escape(place)),
                      escape(get_text(n, "why")), escape(get_text(n, "motion_that_would_tell"))});
  }
  for (const json& n : get_list(series, "notes")) notes += "<li>" + format_value(n) + "</li>";
  return make_table({"effect", "why these data cannot tell", "a motion that would"}, rows) +
         (notes.empty() ? "" : "<ul>" + notes + "</ul>");
}

}  // namespace

std::string make_html_report(const json& report, const json& series) {
  const std::string name = shorten_path(get_text(series, "experiment", "recordings"));
  std::string out =
      "<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>\n<meta name='viewport' "
      "content='width=device-width, initial-scale=1'>\n";
  out += "<title>" + escape(std::string(find_verdict_words(get_text(report, "verdict")).badge) + ": " + name) +
         "</title>\n<style>" + kReportStyle + "</style>\n</head>\n<body>\n<main>\n";
  out += make_header(report, series);
  out += make_section("found", "What was found", make_findings(report));
  out += make_section("shares", "What each finding takes away", make_waterfall(report) + make_shares(report));
  out += make_section("each", "What each recording alone asks for", make_per_recording(report));
  out += make_section("remaining", "What remains", make_remaining(report) + make_on_all(report));
  out += make_section("unknown", "What stays unexplained", make_unexplained(report));
  out += make_section("checks", "Checks of the recordings", make_checks_section(report));
  out += make_section("where", "Where and when", make_maps(series) + make_mismatch_table(report));
  out += make_section("law", "What it depends on", make_clouds(series));
  out += make_section("rivals", "Other explanations, and why they lost", make_rivals(series));
  out += make_section("show", "Before and after", make_show(report, series));
  out += make_section("updated", "The updated scenario", make_updated(series));
  out += make_section("limits", "What the data cannot tell", make_limits(report, series));
  return out + "</main>\n</body>\n</html>\n";
}

void write_html_report(const json& report, const json& series, const std::string& path) {
  write_file(path, make_html_report(report, series));
}

}  // namespace hrp::diagnosis
