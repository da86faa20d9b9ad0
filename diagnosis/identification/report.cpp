// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/report.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "common/plot/svg_plot.h"
#include "common/robot/sole.h"
#include "diagnosis/identification/html.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::identification {
namespace {

// What the scenario says of a bush, where the data were simulated: roll, then pitch.
const FootBushSpec* find_truth(const Identification& result, size_t foot) {
  const auto found = result.scenario.foot_bush.find(result.scenario.feet[foot]);
  return result.simulated && found != result.scenario.foot_bush.end() ? &found->second : nullptr;
}

std::string make_vertical(const Identification& r) {
  if (r.vertical.stiffness.empty()) return "<p>Vertical stiffness: these motions do not show it.</p>";
  std::string html =
      "<h2>Vertical stiffness and damping, from accelerometer and closed chain</h2><table><tr><th>foot</th><th></th>"
      "<th>value</th><th>std</th><th>relative std</th><th>simulated truth (error)</th></tr>";
  for (size_t f = 0; f < r.vertical.stiffness.size(); ++f) {
    const FootBushSpec* t = find_truth(r, f);
    const std::string head = "<tr><td>" + escape(r.scenario.feet[f]) + "</td><td>";
    html += head + "kz [N/m]</td>" + make_cell(r.vertical.stiffness[f], t != nullptr ? &t->kz : nullptr) + "</tr>";
    html += head + "cz [N s/m]</td>" + make_cell(r.vertical.damping[f], t != nullptr ? &t->cz : nullptr) + "</tr>";
  }
  return html + "</table>";
}

std::string make_table_1(const Identification& r) {
  std::string html =
      "<h2>Table 1: stiffness, damping, offset of each foot and axis</h2><table><tr><th>foot</th><th>axis</th>"
      "<th></th><th>value</th><th>std</th><th>relative std</th><th>simulated truth (error)</th></tr>";
  for (size_t f = 0; f < r.fit.feet.size(); ++f) {
    const FootBushSpec* t = find_truth(r, f);
    for (int a = 0; a < kAxes; ++a) {
      const BushParameters& p = r.fit.feet[f][static_cast<size_t>(a)];
      const double truth[3] = {t ? (a ? t->k_pitch : t->k_roll) : 0, t ? (a ? t->c_pitch : t->c_roll) : 0,
                               t ? (a ? t->offset_pitch : t->offset_roll) : 0};
      const Estimate* estimates[3] = {&p.K, &p.C, &p.O};
      const char* const names[3] = {"K [N m/rad]", "C [N m s/rad]", "O [N m]"};
      for (int i = 0; i < 3; ++i) {
        html += "<tr><td>" + escape(r.scenario.feet[f]) + "</td><td>" + kAxisNames[a] + "</td><td>" + names[i] +
                "</td>" + make_cell(*estimates[i], t != nullptr ? &truth[i] : nullptr) + "</tr>";
      }
      if (r.fit.law == BushLaw::kHysteresis) {
        html += "<tr><td>" + escape(r.scenario.feet[f]) + "</td><td>" + kAxisNames[a] +
                "</td><td>hysteresis, largest torque [N m]</td>" + make_cell(p.hysteresis, nullptr) + "</tr>";
      }
      if (r.fit.law == BushLaw::kHardening) {
        html += "<tr><td>" + escape(r.scenario.feet[f]) + "</td><td>" + kAxisNames[a] +
                "</td><td>hardening angle [rad]</td>";
        const double h = std::sqrt(p.K.value / std::max(p.cubic.value, 1e-9));
        html += make_cell({h, 0.5 * h * p.cubic.relative_std()},
                          t != nullptr && t->hardening_angle > 0 ? &t->hardening_angle : nullptr) +
                "</tr>";
      }
    }
  }
  html += "</table>";
  return html + make_vertical(r);
}

std::string make_errors(const std::string& title, const std::vector<ValidationError>& errors, const Identification& r) {
  std::string html = "<h2>" + title +
                     "</h2><table><tr><th>motion</th><th>foot</th><th>axis</th><th>mean error [N m]</th><th>largest "
                     "torque [N m]</th><th>relative</th></tr>";
  for (const ValidationError& e : errors) {
    html += "<tr><td>" + escape(e.motion) + "</td><td>" + escape(r.scenario.feet[e.foot]) + "</td><td>" +
            kAxisNames[e.axis] + "</td>" +
            print("<td>%.4f</td><td>%.2f</td><td>%.2f %%</td></tr>", e.mean, e.largest, 100.0 * e.relative());
  }
  return html + "</table>";
}

std::vector<double> to_list(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }

// Figure 4: centre of pressure over the sole's outline; not a function of anything, so not a line plot.
std::string make_zmp(const Identification& r, const Sole& sole, const Vector3d& centre, size_t foot) {
  Eigen::AlignedBox2d box;
  for (const SolePoint& p : sole.points) box.extend(Eigen::Vector2d((p.p_LQ - centre).head<2>()));
  const double scale = 1400.0;  // pixels a metre
  const auto at = [&](double x, double y) {
    return print("%.1f,%.1f ", 20 + scale * (box.max().y() - y), 20 + scale * (box.max().x() - x));
  };
  const Eigen::Vector2d size = box.sizes() * scale;
  std::string svg = print("<svg width=\"%.0f\" height=\"%.0f\" role=\"img\" aria-label=\"centre of pressure\">",
                          size.y() + 40, size.x() + 40);
  svg +=
      print("<rect x=\"20\" y=\"20\" width=\"%.1f\" height=\"%.1f\" fill=\"none\" stroke=\"gray\" stroke-width=\"2\"/>",
            size.y(), size.x());
  for (const MotionTrack& track : r.tracks) {
    for (const auto& [first, end] : find_stretches(track.stands[foot])) {
      svg += "<polyline fill=\"none\" stroke=\"steelblue\" stroke-width=\"0.7\" points=\"";
      for (Eigen::Index k = first; k < end; k += 5) svg += at(track.feet[foot].zmp(0, k), track.feet[foot].zmp(1, k));
      svg += "\"/>";
    }
  }
  return "<figure>" + svg + "</svg><figcaption>" + escape(r.scenario.feet[foot]) +
         ", toes up; the outline is the sole</figcaption></figure>";
}

std::string make_figures(const Identification& r) {
  Scenario plain = r.scenario;
  plain.foot_bush.clear();
  const RobotDescription robot = load_robot(plain);
  std::string html = "<h2>Figure 4: centre of pressure in the support polygon, all motions</h2><div class=\"row\">";
  for (size_t f = 0; f < r.scenario.feet.size(); ++f) {
    for (const Sole& sole : make_soles(robot)) {
      if (sole.link != robot.tree.find_link(r.scenario.feet[f])) continue;
      const auto bush = r.scenario.foot_bush.find(r.scenario.feet[f]);
      const Vector3d centre =
          bush != r.scenario.foot_bush.end() && bush->second.center ? *bush->second.center : sole.p_LR;
      html += make_zmp(r, sole, centre, f);
    }
  }
  html += "</div><h2>Figures 6 to 13: bush angles; torque reconstructed and sensed</h2>";
  for (const MotionTrack& track : r.tracks) {
    html += "<h3>" + escape(track.name) + "</h3><div class=\"row\">";
    const std::vector<double> time = to_list(track.time);
    Plot angles{track.name + ": angles of the bush", "time [s]", "angle [mrad]", {}};
    for (size_t f = 0; f < track.feet.size(); ++f) {
      for (int a = 0; a < kAxes; ++a)
        angles.series.push_back(
            {(f == 0 ? "1 " : "2 ") + std::string(kAxisNames[a]), time, to_list(1e3 * track.feet[f].angle[a])});
    }
    html += make_svg(angles);
    for (size_t f = 0; f < track.feet.size(); ++f) {
      for (int a = 0; a < kAxes; ++a) {
        const Plot plot{r.scenario.feet[f] + ", " + kAxisNames[a],
                        "time [s]",
                        "torque [N m]",
                        {{"sensed", time, to_list(track.feet[f].torque[a])},
                         {"reconstructed", time, to_list(predict_torque(r.fit, track, f, a))}}};
        html += make_svg(plot);
      }
    }
    html += "</div>";
  }
  return html;
}

}  // namespace

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
  const std::string path = (std::filesystem::path(folder) / "identified.yaml").string();
  std::ofstream file(path);
  file << "# The bush as identified by hrp-identify-foot" << (r.simulated ? " from simulated data" : "") << "\n"
       << node << "\n";
  if (!file) throw std::runtime_error(path + ": cannot be written");
  return path;
}

std::string make_text(const Identification& r) {
  std::string text;
  for (size_t f = 0; f < r.fit.feet.size(); ++f) {
    for (int a = 0; a < kAxes; ++a) {
      const BushParameters& p = r.fit.feet[f][static_cast<size_t>(a)];
      text += print("%-16s %-5s  K %8.2f (%.2f %%)  C %7.3f (%.2f %%)  O %8.4f (%.2f %%)\n", r.scenario.feet[f].c_str(),
                    kAxisNames[a], p.K.value, 100 * p.K.relative_std(), p.C.value, 100 * p.C.relative_std(), p.O.value,
                    100 * p.O.relative_std());
    }
  }
  double worst = 0.0;
  for (const ValidationError& e : r.cross) worst = std::max(worst, e.relative());
  for (size_t f = 0; f < r.vertical.stiffness.size(); ++f) {
    const Estimate &k = r.vertical.stiffness[f], &c = r.vertical.damping[f];
    text += print("%-16s vertical  kz %.4g (%.2f %%)  cz %.4g (%.1f %%)\n", r.scenario.feet[f].c_str(), k.value,
                  100 * k.relative_std(), c.value, 100 * c.relative_std());
  }
  text += print("law: %s (error on motions left out: linear %.4f, hardening %.4f, hysteresis %.4f N m)\n",
                kLawNames[static_cast<int>(r.choice.law)], r.choice.error[0], r.choice.error[1], r.choice.error[2]);
  text += print("cross-validation: worst mean error %.2f %% of the largest torque; condition number %.1f\n",
                100 * worst, r.fit.condition);
  text += make_body_text(r);
  for (const std::string& note : r.notes) text += note + "\n";
  return text;
}

void write_report(const Identification& r, const std::string& path) {
  std::ofstream file(path);
  file << "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Viscoelasticity of the "
          "soles</title><style>"
          "body{font:15px/1.5 sans-serif;max-width:75em;margin:2em auto;padding:0 1em}table{border-collapse:collapse}"
          "td,th{border:1px solid #999;padding:.2em .6em;text-align:right}.row{display:flex;flex-wrap:wrap;gap:1em}"
          ".row svg{max-width:36em;height:auto}pre{white-space:pre-wrap}</style></head><body><h1>Viscoelasticity of "
          "the soles</h1>";
  file << (r.simulated ? "<p><strong>All data in this report are simulated.</strong> " : "<p>");
  file << "Identified from joint encoders, force sensors and the chest IMU, with the grounded sole as base: torque = K "
          "angle + C rate + O.</p><pre>"
       << escape(make_text(r)) << "</pre>";
  const Estimate* bias = r.fit.accelerometer_bias;
  file << print(
      "<p>Found beside them: accelerometer bias x %.4f &plusmn; %.4f, y %.4f &plusmn; %.4f, z %.3f &plusmn; %.3f "
      "m/s&sup2;; the gyroscope is late by %.2f &plusmn; %.2f ms.</p>",
      bias[0].value, bias[0].std, bias[1].value, bias[1].std, bias[2].value, bias[2].std, 1e3 * r.fit.delay.value,
      1e3 * r.fit.delay.std);
  file << print(
      "<p>Model selection, error on motions left out: linear %.4f, hardening %.4f (its term %.1f standard deviations "
      "from zero), hysteresis %.4f N m (%.1f). Chosen: %s.</p>",
      r.choice.error[0], r.choice.error[1], r.choice.significance[1], r.choice.error[2], r.choice.significance[2],
      kLawNames[static_cast<int>(r.choice.law)]);
  if (r.fit.law == BushLaw::kHysteresis)
    file << print("<p>Yield angle %.2f &plusmn; %.2f mrad.</p>", 1e3 * r.fit.yield.value, 1e3 * r.fit.yield.std);
  file << make_table_1(r) << make_errors("Table 2: direct validation", r.direct, r)
       << make_errors("Table 3: cross-validation (each motion predicted by a fit that has not seen it)", r.cross, r)
       << make_body_section(r) << make_figures(r) << "</body></html>\n";
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace hrp::identification
