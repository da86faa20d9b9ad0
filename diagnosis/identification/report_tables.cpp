// SPDX-License-Identifier: BSD-3-Clause
// The report's tables.
#include <algorithm>
#include <cmath>

#include "diagnosis/identification/html.h"

namespace hrp::identification {
namespace {

constexpr double kLimit = 0.01;  // of the largest torque: what a validation should stay below

// What the scenario says of a bush, where the data were simulated: roll, then pitch.
const FootBushSpec* find_truth(const Identification& r, size_t foot) {
  const auto found = r.scenario.foot_bush.find(r.scenario.feet[foot]);
  return r.simulated && found != r.scenario.foot_bush.end() ? &found->second : nullptr;
}

std::string make_value(const Estimate& e, const double* truth) {
  std::string cell = format("<td>%.5g &plusmn; %.2g<br><small>%.2f %%", e.value, e.std, 100.0 * e.relative_std());
  if (truth != nullptr)
    cell += format("; truth %.4g: %+.2f %%, %+.1f &sigma;", *truth, 100.0 * (e.value / *truth - 1.0),
                   (e.value - *truth) / e.std);
  return cell + "</small></td>";
}

std::string make_motions(const Identification& r) {
  std::string html =
      "<h2>Motions</h2><table><tr><th>motion</th><th>support</th><th>used to</th><th>largest change of the soles' "
      "distance</th><th>of the yaw between them</th></tr>";
  for (const MotionTrack& track : r.tracks) {
    html += "<tr><td>" + escape_xml(track.name) + "</td><td>" + escape_xml(describe_support(r, track)) + "</td><td>" +
            (is_fitted(r, track) ? "fit" : "validate") + "</td>" +
            format("<td%s>%.2f mm</td><td>%.2f mrad</td></tr>", has_slipped(track) ? " class=\"bad\"" : "",
                   1e3 * track.slip, 1e3 * track.turn);
  }
  return html + "</table>";
}

std::string make_selection(const Identification& r) {
  std::string html =
      "<h2>Model selection</h2><p>The law that predicts motions best that were left out of the fit; another than the "
      "linear one must lower the error by a tenth, and its term must be four standard deviations from zero.</p>"
      "<table><tr><th>law</th><th>error [N m]</th><th>its term over its std</th><th></th></tr>";
  for (int i = 0; i < kLaws; ++i) {
    html += format("<tr><td>%s</td><td>%.4f</td>", kLawNames[i], r.choice.error[i]) +
            (i == 0 ? "<td></td>" : format("<td>%.1f</td>", r.choice.significance[i])) +
            (static_cast<int>(r.choice.law) == i ? "<td><strong>chosen</strong></td></tr>" : "<td></td></tr>");
  }
  return html + "</table>";
}

// The additional term of a law that is not linear.
std::string make_term(const Identification& r, size_t f, int a) {
  const BushParameters& p = r.fit.feet[f][static_cast<size_t>(a)];
  if (r.fit.law == BushLaw::kHardening) {
    const FootBushSpec* t = find_truth(r, f);
    const double h = std::sqrt(p.K.value / std::max(p.cubic.value, 1e-9));
    return make_value({h, 0.5 * h * p.cubic.relative_std()},
                      t != nullptr && t->hardening_angle > 0 ? &t->hardening_angle : nullptr);
  }
  const std::string joint = r.scenario.feet[f] + "_bush_" + kAxisNames[a];
  const double truth =
      sum_laws(r.scenario, joint, "hysteresis", "stiffness") * sum_laws(r.scenario, joint, "hysteresis", "yield_angle");
  return make_value(p.hysteresis, r.simulated && truth > 0.0 ? &truth : nullptr);
}

std::string make_table_1(const Identification& r) {
  const bool more = r.fit.law != BushLaw::kLinear;
  std::string html =
      "<h2>Table 1: stiffness, damping, offset of each foot and axis</h2><p>Value &plusmn; standard deviation, below "
      "it "
      "the relative standard deviation" +
      std::string(r.simulated ? ", the simulated truth and the error" : "") +
      ".</p><table><tr><th>foot, axis</th><th>K [N m/rad]</th><th>C [N m s/rad]</th><th>O [N m]</th>" +
      (!more                              ? ""
       : r.fit.law == BushLaw::kHardening ? "<th>hardening angle [rad]</th>"
                                          : "<th>hysteresis, largest torque [N m]</th>") +
      "</tr>";
  for (size_t f = 0; f < r.fit.feet.size(); ++f) {
    const FootBushSpec* t = find_truth(r, f);
    for (int a = 0; a < kAxes; ++a) {
      const BushParameters& p = r.fit.feet[f][static_cast<size_t>(a)];
      const double truth[3] = {t ? (a ? t->k_pitch : t->k_roll) : 0, t ? (a ? t->c_pitch : t->c_roll) : 0,
                               t ? (a ? t->offset_pitch : t->offset_roll) : 0};
      const Estimate* estimates[3] = {&p.K, &p.C, &p.O};
      html += "<tr><td>" + escape_xml(r.scenario.feet[f]) + ", " + kAxisNames[a] + "</td>";
      for (int i = 0; i < 3; ++i) html += make_value(*estimates[i], t != nullptr ? &truth[i] : nullptr);
      html += (more ? make_term(r, f, a) : "") + "</tr>";
    }
  }
  html += "</table>";
  if (r.fit.law == BushLaw::kHysteresis)
    html += format("<p>Yield angle %.2f &plusmn; %.2f mrad, all bushes.</p>", 1e3 * r.fit.yield.value,
                   1e3 * r.fit.yield.std);
  return html;
}

std::string make_vertical(const Identification& r) {
  if (r.vertical.stiffness.empty()) return "<p>Vertical stiffness: these motions do not show it.</p>";
  std::string html =
      "<h2>Vertical stiffness and damping, from accelerometer and chain</h2><table><tr><th>foot</th><th>kz [N/m]</th>"
      "<th>cz [N s/m]</th></tr>";
  for (size_t f = 0; f < r.vertical.stiffness.size(); ++f) {
    const FootBushSpec* t = find_truth(r, f);
    html += "<tr><td>" + escape_xml(r.scenario.feet[f]) + "</td>" +
            make_value(r.vertical.stiffness[f], t != nullptr ? &t->kz : nullptr) +
            make_value(r.vertical.damping[f], t != nullptr ? &t->cz : nullptr) + "</tr>";
  }
  return html + "</table>";
}

// One line a motion, a column for each foot and axis.
std::string make_errors(const std::string& title, const std::vector<ValidationError>& errors, const Identification& r) {
  std::string html = "<h2>" + title +
                     "</h2><p>Mean error of the torque while the foot stands [N m], the largest torque of that motion "
                     "[N m], and their ratio.</p><table><tr><th>motion</th>";
  for (const std::string& foot : r.scenario.feet) {
    for (const char* axis : kAxisNames) html += "<th>" + escape_xml(foot) + ", " + axis + "</th>";
  }
  html += "</tr>";
  for (const MotionTrack& track : r.tracks) {
    std::string cells;
    bool any = false;
    for (size_t f = 0; f < r.scenario.feet.size(); ++f) {
      for (int a = 0; a < kAxes; ++a) {
        const auto e = std::find_if(errors.begin(), errors.end(), [&](const ValidationError& v) {
          return v.motion == track.name && v.foot == f && v.axis == a;
        });
        any = any || e != errors.end();
        cells += e == errors.end()
                     ? "<td><small>does not stand</small></td>"
                     : format("<td%s>%.4f of %.1f: %.2f %%</td>", e->relative() > kLimit ? " class=\"bad\"" : "",
                              e->mean, e->largest, 100.0 * e->relative());
      }
    }
    if (any) html += "<tr><td>" + escape_xml(track.name) + "</td>" + cells + "</tr>";
  }
  return html + "</table>";
}

}  // namespace

bool is_fitted(const Identification& r, const MotionTrack& track) {
  return std::any_of(r.direct.begin(), r.direct.end(),
                     [&](const ValidationError& e) { return e.motion == track.name; });
}

std::string describe_support(const Identification& r, const MotionTrack& track) {
  const double time = track.period * static_cast<double>(track.time.size());
  std::string text;
  bool all = true, alone = false;
  for (size_t f = 0; f < track.stands.size(); ++f) {
    const double stood = track.calc_standing_time(f);
    all = all && stood > time - 1e-6;
    alone = alone || stood < 0.5 * time;
    text += (text.empty() ? "" : ", ") + r.scenario.feet[f] + format(" stands %.1f s", stood);
  }
  if (all) return "both feet";
  return (alone ? "single support: " : "not all the time: ") + text + format(" of %.1f s", time);
}

std::string make_tables(const Identification& r) {
  return make_table_1(r) + make_selection(r) + make_errors("Table 2: direct validation", r.direct, r) +
         make_errors("Table 3: cross-validation, each motion predicted by a fit that has not seen it", r.cross, r) +
         make_vertical(r) + make_motions(r);
}

}  // namespace hrp::identification
