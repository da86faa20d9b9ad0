// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/page/checks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/join_words.h"

namespace hrp::diagnosis::html {
namespace {

std::string cell(const std::string& text) { return "<td>" + text + "</td>"; }

std::string make_recordings(const json& checks) {
  std::string rows;
  for (const json& r : get_list(checks, "recordings")) {
    const std::size_t gaps = get_list(r, "gaps").size(), held = get_list(r, "held").size();
    rows += "<tr>" + cell(escape(get_text(r, "file"))) +
            cell(get_text(r, "role") == "validate" ? "held out" : "used for fitting") +
            cell(format_number(get_number(r, "duration"), 4) + " s") +
            cell(format_number(get_number(r, "rate"), 4) + " Hz") +
            cell(gaps == 0 ? "none" : format_number(get_number(r, "lost"), 3) + " s") +
            cell(held == 0 ? "none" : std::to_string(held) + (held == 1 ? " signal" : " signals")) + "</tr>";
  }
  return make_table({"recording", "role", "length", "rate", "gaps", "held samples"}, rows);
}

// "0.12 N m", "weak: from 0.4 N m on", "hidden by rotor inertia".
std::string describe_tell(const json& tell) {
  const std::string verdict = get_text(tell, "verdict"), unit = get_text(tell, "unit");
  std::string least = format_number(get_number(tell, "least"), 2) + (unit == "1" ? "" : " " + escape(typeset(unit)));
  if (verdict == "clear") return least;
  if (verdict == "weak") return least + " <span class='small'>(weak)</span>";
  std::string by = get_text(tell, "hidden_by");
  std::replace(by.begin(), by.end(), '_', ' ');
  return "<b>hidden</b> <span class='small'>by " + escape(by) + "</span>";
}

std::string make_joints(const json& checks) {
  std::string rows;
  std::vector<std::string> head{"joint", "travel", "speed", "acceleration", "load"};
  for (const json& j : get_list(checks, "joints")) {
    const std::vector<double> load = get_numbers(j, "load");
    const std::string unit = escape(get_text(j, "unit", "rad"));
    rows += "<tr>" + cell(escape(get_text(j, "joint"))) + cell(format_number(get_number(j, "travel"), 3) + " " + unit) +
            cell(format_number(get_number(j, "speed"), 3) + " " + unit + "/s") +
            cell(format_number(get_number(j, "acceleration"), 3) + " " + unit + "/s²") +
            cell(load.size() == 2
                     ? format_number(load[0], 3) + " to " + format_number(load[1], 3) + (unit == "m" ? " N" : " N m")
                     : "-");
    for (const json& t : get_list(j, "tells")) {
      if (head.size() < 5 + get_list(j, "tells").size())
        head.push_back("least " + escape(describe_effect(get_text(t, "effect"))));
      rows += cell(describe_tell(t));
    }
    rows += "</tr>";
  }
  if (rows.empty()) return "";
  return "<p>Speed and acceleration are exceeded 5 % of the time. The right columns say how small an effect may be and "
         "still "
         "show in these motions.</p>" +
         make_table(head, rows);
}

struct Step {
  std::string label;
  double share = 0.0;
};

// Findings by what they take away; beyond the largest dozen together.
std::vector<Step> find_steps(const json& report) {
  constexpr std::size_t kMost = 12;  // steps that fit beside each other
  std::vector<Step> steps;
  for (const json& f : get_list(report, "findings")) {
    const double weight = get_number(f, "weight");
    if (std::isfinite(weight) && weight > 0.0)
      steps.push_back({describe_effect(get_text(f, "effect")) + ", " + describe_place(get(f, "where")), weight});
  }
  std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.share > b.share; });
  if (steps.size() <= kMost) return steps;
  Step rest{std::to_string(steps.size() - kMost) + " smaller findings", 0.0};
  for (std::size_t i = kMost; i < steps.size(); ++i) rest.share += steps[i].share;
  steps.resize(kMost);
  steps.push_back(rest);
  return steps;
}

std::string bar(double y, double from, double to, const char* css, const std::string& label, const std::string& value) {
  const double left = 300 + 460 * std::clamp(from, 0.0, 1.0), right = 300 + 460 * std::clamp(to, 0.0, 1.0);
  return "<text x='292' y='" + format_number(y + 13) + "' text-anchor='end'>" + escape(label) + "</text><rect class='" +
         css + "' x='" + format_number(left, 5) + "' y='" + format_number(y + 2) + "' height='14' width='" +
         format_number(std::max(1.0, right - left), 5) + "'/><text x='" + format_number(std::max(left, right) + 6, 5) +
         "' y='" + format_number(y + 13) + "'>" + value + "</text>";
}

std::string percent(double share) { return format_number(100.0 * share, 3) + " %"; }

// Values of one parameter by recording on a common scale.
std::string make_dots(const json& item) {
  double low = 0.0, high = 0.0;
  const json& each = get_list(item, "each");
  for (const json& r : each) {
    const std::vector<double> ci = get_numbers(r, "ci95");
    const double value = get_number(r, "value");
    for (double v : {value, ci.size() == 2 ? std::clamp(ci[0], value - 3.0 * std::abs(value), value) : value,
                     ci.size() == 2 ? std::clamp(ci[1], value, value + 3.0 * std::abs(value)) : value}) {
      if (std::isfinite(v)) {
        low = std::min(low, v);
        high = std::max(high, v);
      }
    }
  }
  if (!(high > low)) return "";
  const auto x = [&](double v) { return 10 + 300 * (std::clamp(v, low, high) - low) / (high - low); };
  const double height = 6.0 + 12.0 * static_cast<double>(each.size());
  std::string out = "<svg style='width:320px;height:" + format_number(height) + "px' viewBox='0 0 320 " +
                    format_number(height) + "' role='img' aria-label='value by recording'><line class='grid' x1='" +
                    format_number(x(0), 5) + "' x2='" + format_number(x(0), 5) + "' y1='0' y2='" +
                    format_number(height) + "'/>";
  double y = 9.0;
  for (const json& r : each) {
    const std::vector<double> ci = get_numbers(r, "ci95");
    const double value = get_number(r, "value");
    if (!std::isfinite(value)) continue;
    if (ci.size() == 2)
      out += "<line class='span' x1='" + format_number(x(ci[0]), 5) + "' x2='" + format_number(x(ci[1]), 5) + "' y1='" +
             format_number(y) + "' y2='" + format_number(y) + "'/>";
    out += "<circle class='value' cx='" + format_number(x(value), 5) + "' cy='" + format_number(y) +
           "' r='3.5'><title>" + escape(get_text(r, "recording")) + ": " + format_number(value, 3) +
           "</title></circle>";
    y += 12.0;
  }
  return out + "</svg>";
}

}  // namespace

std::string make_checks_section(const json& report) {
  const json& checks = get(report, "checks");
  std::string remarks;
  for (const json& r : get_list(checks, "remarks")) remarks += "<li>" + format_value(r) + "</li>";
  return make_recordings(checks) + make_joints(checks) + (remarks.empty() ? "" : "<ul>" + remarks + "</ul>");
}

std::string make_on_all(const json& report) {
  const json& all = get(report, "on_all");
  std::string rows;
  for (const json& j : get_list(all, "joints")) {
    const std::string unit = " " + escape(get_text(j, "unit"));
    rows += "<tr>" + cell(escape(get_text(j, "joint"))) + cell(format_number(get_number(j, "before"), 3) + unit) +
            cell(format_number(get_number(j, "after"), 3) + unit) + "</tr>";
  }
  return rows.empty()
             ? ""
             : "<h3>On all recordings</h3><p>The search worked on " + format_number(get_number(all, "searched"), 4) +
                   " s; this is the missing torque over all " + format_number(get_number(all, "seconds"), 5) +
                   " s.</p>" + make_table({"joint", "before", "after"}, rows);
}

std::string make_per_recording(const json& report) {
  std::string rows;
  for (const json& item : get_list(report, "per_recording")) {
    const std::string values = join_words(get_list(item, "each"), [](const json& r) {
      return escape(get_text(r, "recording")) + " " + format_number(get_number(r, "value"), 3);
    });
    rows += "<tr>" + cell(escape(describe_effect(get_text(item, "effect")))) +
            cell(escape(describe_place(get(item, "where")))) +
            cell(escape(get_text(item, "parameter")) + " [" + escape(get_text(item, "unit")) + "]") +
            cell(make_dots(item) + "<span class='small'>" + values + "</span>") +
            cell(get_text(item, "verdict") == "agree" ? "agree" : "<b>differ</b>") + "</tr>";
  }
  return rows.empty() ? ""
                      : "<p>The same model fitted to each recording alone. Dots from top to bottom in the order of the "
                        "recordings, with 95 % intervals; the line is zero.</p>" +
                            make_table({"effect", "where", "parameter", "by recording", "recordings"}, rows);
}

std::string make_waterfall(const json& report) {
  const std::vector<Step> steps = find_steps(report);
  if (steps.empty()) return "";
  // Of findings that act on the same readings; with more, the weights only rank the findings
  constexpr double kOverlap = 0.1;
  const double all =
      std::accumulate(steps.begin(), steps.end(), 0.0, [](double sum, const Step& s) { return sum + s.share; });
  const double explained = get_number(report, "explained", all), details = explained - all;
  if (details < -kOverlap) return "";
  const double height = 20.0 * static_cast<double>(steps.size() + 3) + 6;
  std::string out =
      "<div class='wide' tabindex='0'><svg viewBox='0 0 900 " + format_number(height) +
      "' style='min-width:640px;width:100%' role='img' aria-label='What each finding takes away of the mismatch'>";
  double left = 1.0, y = 2.0;
  out += bar(y, 0.0, 1.0, "bar before", "mismatch of the nominal model", "100 %");
  for (const Step& s : steps) {
    y += 20.0;
    out += bar(y, std::max(0.0, left - s.share), left, "bar after", s.label, "-" + percent(s.share));
    left -= s.share;
  }
  if (std::abs(details) > 0.01) {
    y += 20.0;
    out += details > 0.0 ? bar(y, 1.0 - explained, left, "bar after", "details of the model that are no findings",
                               "-" + percent(details))
                         : bar(y, left, 1.0 - explained, "bar before", "what findings share, and was counted twice",
                               "+" + percent(-details));
  }
  return out +
         bar(y + 20.0, 0.0, 1.0 - explained, "bar before", "left on held-out recordings", percent(1.0 - explained)) +
         "</svg></div>";
}

}  // namespace hrp::diagnosis::html
