// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/page/fit_words.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "common/base/ends_with.h"

namespace hrp::diagnosis::html {
namespace {

constexpr double kFallen = 0.9;  // of an error: what falls by less is not told
constexpr double kLittle = 0.5;  // of the mismatch: where less can be predicted, the share of all of it is told, too

// "hip" of "/joint_states/hip/effort".
std::string get_joint(const std::string& signal) {
  const size_t end = signal.rfind('/'), begin = signal.rfind('/', end - 1);
  return signal.substr(begin + 1, end - begin - 1);
}

// Whether it is an effort whose unit the motion does not tell.
bool is_untold(const json& report, const std::string& signal) {
  const json& joints = get_list(report, "untold_units");
  return std::any_of(joints.begin(), joints.end(),
                     [&](const json& joint) { return ends_with(signal, "/" + print_place(joint) + "/effort"); });
}

// Efforts of joints whose unit is unknown, where the log of another joint is no torque: milliamperes would count as
// newton metres.
std::set<std::string> list_untold_efforts(const json& report, const json& signals) {
  std::set<std::string> untold;
  const json& findings = get_list(report, "findings");
  if (std::none_of(findings.begin(), findings.end(), [](const json& f) { return get(f, "of_log") == json(true); }))
    return untold;
  for (const auto& item : signals.items()) {
    if (is_untold(report, item.key())) untold.insert(item.key());
  }
  return untold;
}

struct Squares {
  double before = 0.0, after = 0.0, n = 0.0;
};

// " from 10.5 to 5.63 N".
std::string make_change(double before, double after, const std::string& unit) {
  return " from " + format_number(before, 3) + " to " + format_number(after, 3) + " " + typeset(unit);
}

// Sums over the signals whose names end so, by unit.
std::map<std::string, Squares> sum_squares(const json& report, const json& signals, const std::string& suffix,
                                           const std::set<std::string>& left_out) {
  std::map<std::string, Squares> by_unit;
  for (const auto& [name, fit] : signals.items()) {
    const double before = get_number(fit, "rms_before"), after = get_number(fit, "rms_after");
    if (!std::isfinite(before + after) || !ends_with(name, suffix) || left_out.count(name) > 0) continue;
    Squares& s = by_unit[is_untold(report, name) ? "(unit of the log)" : get_text(fit, "unit")];
    s.before += before * before;
    s.after += after * after;
    s.n += 1.0;
  }
  return by_unit;
}

// Signals of a robot on its feet are compared by equations: "/wrench/l_sole/force (weight)". Those whose error falls by
// a tenth at least, most first: "weight from 10.5 to 5.63 N".
std::vector<std::string> list_falling_equations(const json& signals) {
  constexpr size_t kMost = 3;
  std::vector<std::pair<double, std::string>> falls;
  for (const auto& [name, fit] : signals.items()) {
    const double before = get_number(fit, "rms_before"), after = get_number(fit, "rms_after");
    const size_t open = name.find(" (");
    if (open == std::string::npos || !(after < kFallen * before)) continue;
    const std::string equation = name.substr(open + 2, name.size() - open - 3), signal = name.substr(0, open);
    const std::string words = ends_with(signal, "/effort") ? "effort of " + get_joint(signal) : equation;
    falls.emplace_back(after / before, words + make_change(before, after, get_text(fit, "unit")));
  }
  std::stable_sort(falls.begin(), falls.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> out;
  for (size_t i = 0; i < std::min(kMost, falls.size()); ++i) out.push_back(falls[i].second);
  return out;
}

}  // namespace

// Root mean squares over all signals of a kind, in SI units: what a user compares with his own machine.
std::string make_errors_sentence(const json& report) {
  const std::vector<std::pair<const char*, const char*>> kinds = {
      {"/position", "positions"}, {"/effort", "efforts"}, {"/linear_acceleration", "accelerations"}};
  const json& signals = get_object(get(report, "fit"), "per_signal");
  const std::set<std::string> untold = list_untold_efforts(report, signals);
  std::string falls, rises;
  for (const auto& [suffix, word] : kinds) {
    for (const auto& [unit, s] : sum_squares(report, signals, suffix, untold)) {
      std::string& text = s.after > s.before ? rises : falls;
      text += (text.empty() ? "" : ", ") + std::string(word) +
              make_change(std::sqrt(s.before / s.n), std::sqrt(s.after / s.n), unit);
    }
  }
  for (const std::string& equation : list_falling_equations(signals)) falls += (falls.empty() ? "" : ", ") + equation;
  if (falls.empty() && rises.empty()) return "";
  const bool held = get(get(report, "fit"), "held_out") == json(true);
  const std::string errors = std::string(held ? "Held-out" : "Root mean square") + " errors ";
  if (falls.empty()) return errors + "rise: " + rises + ".";
  return errors + "fall: " + falls + (rises.empty() ? "" : "; they rise: " + rises) + ".";
}

// How much is explained, beside what can be predicted at all: only where a ceiling was measured.
std::string make_ceiling_sentence(const json& report) {
  const double ceiling = get_number(report, "ceiling", 0.0), explained = get_number(report, "explained", 0.0);
  if (ceiling <= 0.0 || get_list(report, "remaining").empty()) return "";
  const std::string all =
      "Over all signals, that is " + format_number(std::round(100.0 * explained), 3) + " % of the mismatch";
  constexpr double kAll = 0.9995;  // as rounded in the report
  if (ceiling > kAll) return all + ".";
  if (explained > kAll * ceiling) return all + "; a free model of the recorded signals predicts no more.";
  // Where little can be predicted, a large share of it is still little.
  return (ceiling < kLittle ? all + ", and " : "That is ") + format_number(std::round(100.0 * explained / ceiling), 3) +
         " % of what a free model of the recorded signals predicts.";
}

std::string make_noise_sentence(const json& report) {
  const json &fit = get(report, "fit"), &held = get(fit, "validate");
  const double before = get_number(held, "before"), after = get_number(held, "after");
  if (!std::isfinite(before) || !std::isfinite(after)) return "";
  const bool same = format_number(before, 3) == format_number(after, 3);
  const std::string verdict = get_text(report, "verdict");
  if (verdict == "no_mismatch" || (verdict == "explained" && same)) {
    return "On the held-out recordings the prediction error is " + format_number(after, 3) +
           " times the noise (1 is as good as it gets).";
  }
  if (get_text(fit, "over") == "spread") {
    return "Along recordings never used for fitting, the missing torque falls from " +
           format_number(100.0 * before, 3) + " to " + format_number(100.0 * after, 3) + " % of the effort's spread.";
  }
  if (same) {
    return "Over all signals together, the prediction error on recordings never used for fitting stays " +
           format_number(after, 3) + " times the noise: most of it is in signals that no finding touches.";
  }
  return "On recordings never used for fitting the prediction error goes from " + format_number(before, 3) + " to " +
         format_number(after, 3) + " times the noise (1 is as good as it gets).";
}

}  // namespace hrp::diagnosis::html
