// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/report.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "common/base/write_file.h"
#include "diagnosis/identification/html.h"

namespace hrp::identification {

std::string write_identified_scenario(const Identification& r, const std::string& folder) {
  YAML::Node node = YAML::Load(r.scenario.text);
  node["robot"] = r.scenario.robot;
  node.remove("recordings");
  node.remove("foot_bush");
  const std::vector<Vector3d> centres = BushObserver(r.scenario).bush_centres();
  for (size_t f = 0; f < r.fit.feet.size(); ++f) {
    YAML::Node bush = node["foot_bush"][r.scenario.feet[f]];
    const auto old = r.scenario.foot_bush.find(r.scenario.feet[f]);
    const FootBushSpec place = old != r.scenario.foot_bush.end() ? old->second : FootBushSpec{};
    // Where nothing is known of the vertical: 3e5 N/m, 1 kN s/m are assumptions.
    const bool known = f < r.vertical.stiffness.size();
    bush["kz"] = known ? r.vertical.stiffness[f].value : place.kz > 0 ? place.kz : 3e5;
    bush["cz"] = known && r.vertical.damping[f].value > 0 ? r.vertical.damping[f].value : place.cz > 0 ? place.cz : 1e3;
    bush["upper_mass_ratio"] = place.upper_mass_ratio;
    for (int i = 0; i < 3; ++i) bush["center"].push_back(centres[f][i]);
    const BushParameters &roll = r.fit.feet[f][0], &pitch = r.fit.feet[f][1];
    bush["k_roll"] = roll.K.value;
    bush["k_pitch"] = pitch.K.value;
    bush["c_roll"] = roll.C.value;
    bush["c_pitch"] = pitch.C.value;
    bush["offset_roll"] = roll.O.value;
    bush["offset_pitch"] = pitch.O.value;
    const double hardness = 0.5 * (roll.cubic.value / roll.K.value + pitch.cubic.value / pitch.K.value);
    if (hardness > 0.0) bush["hardening_angle"] = 1.0 / std::sqrt(hardness);
    for (int a = 0; a < kAxes && r.fit.law == BushLaw::kHysteresis; ++a) {
      const double H = r.fit.feet[f][static_cast<size_t>(a)].hysteresis.value;
      YAML::Node law = node["joint_laws"][r.scenario.feet[f] + "_bush_" + kAxisNames[a]]["hysteresis"];
      law["stiffness"] = H / r.fit.yield.value;
      law["yield_angle"] = r.fit.yield.value;
    }
  }
  std::string path = (std::filesystem::path(folder) / "identified.yaml").string();
  const std::string head =
      std::string("# The bush as identified by hrp-identify-foot") + (r.simulated ? " from simulated data" : "");
  write_file(path, head + "\n" + YAML::Dump(node) + "\n");
  return path;
}

std::string make_text(const Identification& r) {
  std::string text;
  for (size_t f = 0; f < r.fit.feet.size(); ++f) {
    for (int a = 0; a < kAxes; ++a) {
      const BushParameters& p = r.fit.feet[f][static_cast<size_t>(a)];
      text += format("%-16s %-5s  K %8.2f (%.2f %%)  C %7.3f (%.2f %%)  O %8.4f (%.2f %%)\n",
                     r.scenario.feet[f].c_str(), kAxisNames[a], p.K.value, 100 * p.K.relative_std(), p.C.value,
                     100 * p.C.relative_std(), p.O.value, 100 * p.O.relative_std());
    }
  }
  double worst = 0.0;
  for (const ValidationError& e : r.cross) worst = std::max(worst, e.relative());
  for (size_t f = 0; f < r.vertical.stiffness.size(); ++f) {
    const Estimate &k = r.vertical.stiffness[f], &c = r.vertical.damping[f];
    text += format("%-16s vertical  kz %.4g (%.2f %%)  cz %.4g (%.1f %%)\n", r.scenario.feet[f].c_str(), k.value,
                   100 * k.relative_std(), c.value, 100 * c.relative_std());
  }
  text += format("law: %s (error on motions left out: linear %.4f, hardening %.4f, hysteresis %.4f N m)\n",
                 kLawNames[static_cast<int>(r.choice.law)], r.choice.error[0], r.choice.error[1], r.choice.error[2]);
  text += format("cross-validation: worst mean error %.2f %% of the largest torque; condition number %.1f\n",
                 100 * worst, r.fit.condition);
  text += make_body_text(r);
  for (const std::string& note : r.notes) text += note + "\n";
  return text;
}

namespace {

const char* const kStyle =
    "body{font:15px/1.5 sans-serif;max-width:80em;margin:2em auto;padding:0 1em;color:#222;background:#fff}"
    "table{border-collapse:collapse;margin:.5em 0}td,th{border:1px solid #bbb;padding:.2em .6em;text-align:right}"
    "th{background:#f0f0f0}td:first-child,th:first-child{text-align:left}small{color:#555}.bad{background:#fdd}"
    ".row{display:flex;flex-wrap:wrap;gap:1em;align-items:flex-start}.row svg{max-width:38em;height:auto}"
    "figure{margin:0}figcaption{max-width:24em;color:#555}summary{font-size:1.15em;font-weight:bold;margin:.8em 0}"
    "svg text{fill:#333}";

std::string make_summary(const Identification& r) {
  double worst = 0.0;
  for (const ValidationError& e : r.cross) worst = std::max(worst, e.relative());
  std::string html = "<ul>";
  html += format("<li>Law chosen: <strong>%s</strong>.</li>", kLawNames[static_cast<int>(r.choice.law)]);
  html += format(
      "<li>Each motion predicted by a fit that has not seen it: mean error at most %.2f %% of the largest torque, both "
      "axes, on two feet and on one (table 3).</li>",
      100.0 * worst);
  const Estimate* bias = r.fit.accelerometer_bias;
  html += format(
      "<li>Found beside it: accelerometer bias x %.4f &plusmn; %.4f, y %.4f &plusmn; %.4f, z %.3f &plusmn; %.3f "
      "m/s&sup2;; the gyroscope is late by %.2f &plusmn; %.2f ms.</li>",
      bias[0].value, bias[0].std, bias[1].value, bias[1].std, bias[2].value, bias[2].std, 1e3 * r.fit.delay.value,
      1e3 * r.fit.delay.std);
  for (const std::string& note : r.notes) html += "<li>" + escape_xml(note) + "</li>";
  return html + "</ul>";
}

}  // namespace

void write_report(const Identification& r, const std::string& path) {
  std::ostringstream page;
  page << "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Viscoelasticity of the soles</title>"
       << "<style>" << kStyle << "</style></head><body><h1>Viscoelasticity of the soles</h1>"
       << (r.simulated ? "<p><strong>All data in this report are simulated.</strong> " : "<p>")
       << "Identified after Mikami et al. 2014 from joint encoders, force sensors and the chest IMU, with the soles "
          "that "
          "stand as base: torque = K angle + C rate + O.</p>"
       << make_summary(r) << make_tables(r) << make_figures(r) << make_body_section(r) << "</body></html>\n";
  write_file(path, page.str());
}

}  // namespace hrp::identification
