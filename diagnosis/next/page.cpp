// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/page.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/page/style.h"
#include "diagnosis/page/text.h"
#include "diagnosis/report/print_json.h"

namespace hrp::diagnosis {
namespace {

using html::escape;
using html::format_number;
using nlohmann::json;

constexpr double kWidth = 640, kHeight = 220, kLeft = 60, kTop = 18, kBottom = 34;

// Colours by explanation that differ in light and dark mode.
const char* get_colour(size_t i) {
  static const char* const colours[] = {"#0b8", "#d62", "#58d", "#c3a", "#990", "#777", "#a53", "#399", "#63c"};
  return colours[i % 9];
}

struct Range {
  double low = 1e300, high = -1e300;
  void add(double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  double place(double v) const { return high > low ? (v - low) / (high - low) : 0.5; }
};

std::string make_curve(const std::vector<double>& x, const std::vector<double>& y, const Range& rx, const Range& ry,
                       size_t colour) {
  std::string points;
  for (size_t k = 0; k < std::min(x.size(), y.size()); ++k) {
    points += format_number(kLeft + rx.place(x[k]) * (kWidth - kLeft - 8), 5) + "," +
              format_number(kTop + (1.0 - ry.place(y[k])) * (kHeight - kTop - kBottom), 5) + " ";
  }
  return "<polyline fill='none' stroke='" + std::string(get_colour(colour)) + "' stroke-width='" +
         (colour == 0 ? "2.4" : "1.3") + "' points='" + points + "'/>";
}

std::string make_text(double x, double y, const std::string& text, const char* anchor) {
  return "<text x='" + format_number(x, 5) + "' y='" + format_number(y, 5) + "' text-anchor='" + anchor + "'>" +
         escape(text) + "</text>";
}

using Curves = std::vector<std::vector<double>>;

std::string make_plot(const std::vector<double>& time, const Curves& curves, const std::string& title) {
  Range x, y;
  for (double t : time) x.add(t);
  for (const auto& curve : curves) {
    for (double v : curve) y.add(v);
  }
  std::string out = "<svg viewBox='0 0 640 220' role='img' aria-label='" + escape(title) + "'>";
  for (size_t i = curves.size(); i-- > 0;) out += make_curve(time, curves[i], x, y, i);
  out += make_text(kLeft - 5, kTop + 6, format_number(y.high, 3), "end") +
         make_text(kLeft - 5, kHeight - kBottom, format_number(y.low, 3), "end");
  out += make_text(kLeft, kHeight - 14, format_number(x.low, 3), "middle") +
         make_text(kWidth - 12, kHeight - 14, format_number(x.high, 3) + " s", "end");
  return out + make_text(kLeft, 11, title, "start") + "</svg>";
}

// Differences of all predictions from the first one.
Curves subtract_first(Curves curves) {
  const std::vector<double> first = curves.front();
  for (auto& curve : curves) {
    for (size_t k = 0; k < std::min(curve.size(), first.size()); ++k) curve[k] -= first[k];
  }
  return curves;
}

// True if the curves cannot be distinguished by eye.
bool coincide(const Curves& curves) {
  Range whole, apart;
  for (double v : curves.front()) whole.add(v);
  for (const auto& curve : subtract_first(curves)) {
    for (double v : curve) apart.add(v);
  }
  return curves.size() > 1 && apart.high - apart.low < kDetail * (whole.high - whole.low);
}

std::string make_overlay(const json& overlay, const json& explanations) {
  const std::vector<double> time = html::get_numbers(overlay, "time");
  Curves curves;
  for (const json& curve : html::get_list(overlay, "curves")) curves.push_back(curve.get<std::vector<double>>());
  if (time.size() < 2 || curves.empty()) return "";
  const std::string signal = html::get_text(overlay, "signal"), unit = " [" + html::get_text(overlay, "unit") + "]";
  std::string out = make_plot(time, curves, signal + unit);
  if (coincide(curves)) out += make_plot(time, subtract_first(curves), "difference from the first explanation" + unit);
  out += "<p class='small'>";
  const json& own = html::get_list(overlay, "labels");
  const json& labels = own.empty() ? explanations : own;
  for (size_t i = 0; i < curves.size() && i < labels.size(); ++i)
    out += "<span style='color:" + std::string(get_colour(i)) + "'>&#9632;</span> " +
           escape(labels[i].get<std::string>()) + " &nbsp; ";
  return out + "</p>";
}

std::string percent(double share) {
  return share > 0.99 ? "over 99 %" : format_number(std::round(100.0 * share), 3) + " %";
}

std::string make_expected(const json& motion, const std::string& scale) {
  std::string rows;
  for (const json& one : html::get_list(motion, "expected")) {
    rows += "<tr><td>" + escape(html::get_text(one, "against")) + "</td><td class='num'>" +
            percent(html::get_number(one, "probability", 0.0)) + "</td><td class='num'>" +
            format_number(html::get_number(one, "difference", 0.0), 3) + " " + escape(scale) + "</td></tr>";
  }
  if (rows.empty()) return "";
  return "<table><tr><th>Is it this instead?</th><th>chance that this motion decides</th><th>difference that stays "
         "after fitting</th></tr>" +
         rows + "</table>";
}

std::string make_intervals(const json& motion) {
  std::string rows;
  for (const json& one : html::get_list(motion, "intervals")) {
    const std::string unit = " " + escape(html::get_text(one, "unit"));
    rows += "<tr><td>" + escape(html::get_text(one, "effect")) + "</td><td>" +
            escape(html::get_text(one, "parameter")) + " " + format_number(html::get_number(one, "value", 0.0)) + unit +
            "</td><td class='num'>&plusmn; " + format_number(html::get_number(one, "half_width", 0.0), 2) +
            "</td><td class='num'>&plusmn; " + format_number(html::get_number(one, "expected_half_width", 0.0), 2) +
            "</td><td class='num'>&plusmn; " + format_number(html::get_number(one, "least_half_width", 0.0), 2) +
            "</td></tr>";
  }
  if (rows.empty()) return "";
  return "<table><tr><th>effect</th><th>value now</th><th>95 % interval now</th><th>expected after this "
         "motion</th><th>no motion gets below</th></tr>" +
         rows +
         "</table><p class='small'>The last column stays, however often a motion is repeated: masses and torque "
         "constants are known to 2 %, the time of an effort to half a "
         "sample; dry friction varies over the part of a turn that the limits leave unseen (those of the "
         "description, or <code>--limit</code>); two implementations of a law agree to 0.1 %.</p>";
}

std::string make_stop(const json& motion) {
  std::string text;
  for (const auto& [joint, most] : html::get_object(motion, "stop").items())
    text += (text.empty() ? "" : ", ") + escape(joint) + " " + format_number(most.get<double>(), 2);
  return text.empty()
             ? ""
             : "<p class='small'>Stop the robot when a joint is further from its command than [rad or m]: " + text +
                   ". No explanation goes that far. A recording that ends there is still of use.</p>";
}

// Steps for a person before and after the motion; empty if no load hangs on the robot.
std::string make_steps(const json& motion) {
  std::string hang;
  for (const json& load : html::get_list(motion, "loads"))
    hang += "<li>" + escape(html::get_text(load, "sentence")) + "</li>";
  if (hang.empty()) return "";
  return "<ol><li>Bring the robot to the motion's first posture, and let its drives hold it.</li>" + hang +
         "<li>Weigh the load to 1 % and measure its place to 5 mm. Fix it firmly, for example with a strap: it must "
         "not swing or slip. Another weight, "
         "or another place on the same link, will do if it is lighter; then change the line below.</li>"
         "<li>The load's own size was not looked at: see that it clears the robot and its surroundings on the whole "
         "way.</li>"
         "<li>Step back out of reach, one hand on the emergency stop. Play the motion and record it.</li>"
         "<li>Support the load, then take it off, before the drives are switched off.</li></ol>";
}

// The space that the motion needs. The tool knows the robot and the ground, and nothing else that stands around.
std::string make_ranges(const json& motion) {
  std::string text;
  for (const auto& [joint, range] : html::get_object(motion, "ranges").items())
    text += (text.empty() ? "" : ", ") + escape(joint) + " " + format_number(range[0].get<double>(), 3) + " to " +
            format_number(range[1].get<double>(), 3);
  return text.empty() ? ""
                      : "<p>Keep this space free. Joints move over [rad or m]: " + text +
                            ". Smaller motions: <code>--limit reach=0.5</code>.</p>";
}

std::string make_motion(const json& motion, const json& next, size_t number) {
  const json& explanations = html::get_list(next, "explanations");
  const std::string scale = html::get_text(next, "scale");
  const std::string joints = html::join_values(html::get_list(motion, "joints"));
  const std::string steps = make_steps(motion);
  const bool held = html::get_text(motion, "role") == "validate";
  return "<h2>" + std::to_string(number) + ". " + (steps.empty() ? "" : "With a load. ") +
         escape(html::get_text(motion, "sentence")) + "</h2><p>Play <code>" + escape(html::get_text(motion, "file")) +
         "</code> (" + format_number(html::get_number(motion, "seconds", 0.0), 3) +
         " s) and record it. Moving: " + joints + ".</p>" + make_ranges(motion) + steps +
         "<p>Add the recording to the experiment" +
         (held ? "; it is held out: nothing is fitted to it, it judges" : "") + ":</p><pre>" +
         escape(html::get_text(motion, "line")) + "</pre>" + make_stop(motion) +
         make_overlay(html::get_object(motion, "overlay"), explanations) + make_expected(motion, scale) +
         make_intervals(motion);
}

std::string make_list(const json& next, const char* key, const char* title) {
  std::string items;
  for (const json& one : html::get_list(next, key)) items += "<li>" + escape(one.get<std::string>()) + "</li>";
  return items.empty() ? "" : "<h2>" + std::string(title) + "</h2><ul>" + items + "</ul>";
}

std::string make_lead(const json& next) {
  const std::string nothing = html::get_text(next, "nothing");
  if (!nothing.empty()) return "<p class='lead'>No motion is proposed. " + escape(nothing) + "</p>";
  const json& all = html::get_list(next, "explanations");
  if (next.value("unseen", false))
    return "<p class='lead'>The recordings show no mismatch, but not every joint moved. These motions would show "
           "friction that is hidden so far.</p>";
  if (all.size() < 2)
    return "<p class='lead'>Only one explanation fits the recordings. These motions make its values more certain.</p>";
  return "<p class='lead'>" + std::to_string(all.size()) +
         " explanations predict the recordings about as well. Play these motions, best first, to learn which one "
         "holds.</p>";
}

}  // namespace

std::string make_next_page(const nlohmann::ordered_json& given, const std::string& robot) {
  const json next = copy_json(given);
  std::string out =
      "<!doctype html><html lang='en'><meta charset='utf-8'><meta name='viewport' "
      "content='width=device-width'><title>Next experiment: " +
      escape(robot) + "</title><style>" + kReportStyle + "</style><main><p class='over'>Next experiment</p><h1>" +
      escape(robot) + "</h1>" + make_lead(next);
  size_t number = 0;
  for (const json& motion : html::get_list(next, "motions")) out += make_motion(motion, next, ++number);
  out +=
      make_list(next, "words", "Motions that would tell") + make_list(next, "untold", "What these motions do not tell");
  out += make_list(next, "rejected", "Not safe, therefore not proposed") +
         make_list(next, "remarks", "What was not checked");
  if (html::get_list(next, "motions").empty()) return out + "</main></html>\n";
  const std::string checked = html::get_text(next, "checked");
  return out + "<p class='small'>" +
         (checked.empty() ? "Every motion was simulated under the nominal model and under every explanation before it "
                            "was proposed: positions, speeds, efforts and "
                            "collisions stay within the limits. "
                          : escape(checked)) +
         "Start with somebody at the emergency stop.</p></main></html>\n";
}

}  // namespace hrp::diagnosis
