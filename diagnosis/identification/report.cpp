// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/report.h"

#include <cmath>
#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <yaml-cpp/yaml.h>

#include "common/plot/svg_plot.h"
#include "common/robot/sole.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::identification {
namespace {

std::string print(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

std::string escape(const std::string& text) {
  std::string out;
  for (char c : text) out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

// What the scenario says of a bush, where the data were simulated: roll, then pitch.
const FootBushSpec* find_truth(const Identification& result, size_t foot) {
  const auto found = result.scenario.foot_bush.find(result.scenario.feet[foot]);
  return result.simulated && found != result.scenario.foot_bush.end() ? &found->second : nullptr;
}

std::string make_cell(const Estimate& e, const double* truth) {
  std::string cell = print("<td>%.4g</td><td>%.4g</td><td>%.2f %%</td>", e.value, e.std, 100.0 * e.relative_std());
  cell += truth == nullptr ? "<td></td>" : print("<td>%.4g (%+.2f %%, %+.1f &sigma;)</td>", *truth, 100.0 * (e.value / *truth - 1.0), (e.value - *truth) / e.std);
  return cell;
}

std::string make_table_1(const Identification& r) {
  std::string html = "<h2>Table 1: stiffness, damping, offset of each foot and axis</h2><table><tr><th>foot</th><th>axis</th>"
                     "<th></th><th>value</th><th>std</th><th>relative std</th><th>simulated truth (error)</th></tr>";
  for (size_t f = 0; f < r.fit.feet.size(); ++f) {
    const FootBushSpec* t = find_truth(r, f);
    for (int a = 0; a < kAxes; ++a) {
      const BushParameters& p = r.fit.feet[f][static_cast<size_t>(a)];
      const double truth[3] = {t ? (a ? t->k_pitch : t->k_roll) : 0, t ? (a ? t->c_pitch : t->c_roll) : 0, t ? (a ? t->offset_pitch : t->offset_roll) : 0};
      const Estimate* estimates[3] = {&p.K, &p.C, &p.O};
      const char* const names[3] = {"K [N m/rad]", "C [N m s/rad]", "O [N m]"};
      for (int i = 0; i < 3; ++i) {
        html += "<tr><td>" + escape(r.scenario.feet[f]) + "</td><td>" + kAxisNames[a] + "</td><td>" + names[i] + "</td>" +
                make_cell(*estimates[i], t != nullptr ? &truth[i] : nullptr) + "</tr>";
      }
      if (r.fit.law == BushLaw::kHardening) {
        html += "<tr><td>" + escape(r.scenario.feet[f]) + "</td><td>" + kAxisNames[a] + "</td><td>hardening angle [rad]</td>";
        const double h = std::sqrt(p.K.value / std::max(p.cubic.value, 1e-9));
        html += make_cell({h, 0.5 * h * p.cubic.relative_std()}, t != nullptr && t->hardening_angle > 0 ? &t->hardening_angle : nullptr) + "</tr>";
      }
    }
  }
  html += "</table>";
  for (size_t f = 0; f < r.compliance.size(); ++f) {
    const Estimate& c = r.compliance[f];
    html += print("<p>Vertical stiffness, foot %zu, from the closed chain of both legs: %.3g &plusmn; %.2g N/m.</p>", f + 1, 1.0 / c.value, c.std / (c.value * c.value));
  }
  return html;
}

std::string make_errors(const std::string& title, const std::vector<ValidationError>& errors, const Identification& r) {
  std::string html = "<h2>" + title + "</h2><table><tr><th>motion</th><th>foot</th><th>axis</th><th>mean error [N m]</th><th>largest torque [N m]</th><th>relative</th></tr>";
  for (const ValidationError& e : errors) {
    html += "<tr><td>" + escape(e.motion) + "</td><td>" + escape(r.scenario.feet[e.foot]) + "</td><td>" + kAxisNames[e.axis] + "</td>" +
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
  const auto at = [&](double x, double y) { return print("%.1f,%.1f ", 20 + scale * (box.max().y() - y), 20 + scale * (box.max().x() - x)); };
  const Eigen::Vector2d size = box.sizes() * scale;
  std::string svg = print("<svg width=\"%.0f\" height=\"%.0f\" role=\"img\" aria-label=\"centre of pressure\">", size.y() + 40, size.x() + 40);
  svg += print("<rect x=\"20\" y=\"20\" width=\"%.1f\" height=\"%.1f\" fill=\"none\" stroke=\"gray\" stroke-width=\"2\"/>", size.y(), size.x());
  for (const MotionTrack& track : r.tracks) {
    if (!track.loaded[foot]) continue;
    svg += "<polyline fill=\"none\" stroke=\"steelblue\" stroke-width=\"0.7\" points=\"";
    for (Eigen::Index k = 0; k < track.time.size(); k += 5) svg += at(track.feet[foot].zmp(0, k), track.feet[foot].zmp(1, k));
    svg += "\"/>";
  }
  return "<figure>" + svg + "</svg><figcaption>" + escape(r.scenario.feet[foot]) + ", toes up; the outline is the sole</figcaption></figure>";
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
      const Vector3d centre = bush != r.scenario.foot_bush.end() && bush->second.center ? *bush->second.center : sole.p_LR;
      html += make_zmp(r, sole, centre, f);
    }
  }
  html += "</div><h2>Figures 6 to 13: bush angles; torque reconstructed and sensed</h2>";
  for (const MotionTrack& track : r.tracks) {
    html += "<h3>" + escape(track.name) + "</h3><div class=\"row\">";
    const std::vector<double> time = to_list(track.time);
    Plot angles{track.name + ": angles of the bush", "time [s]", "angle [mrad]", {}};
    for (size_t f = 0; f < track.feet.size(); ++f) {
      for (int a = 0; a < kAxes; ++a) angles.series.push_back({(f == 0 ? "1 " : "2 ") + std::string(kAxisNames[a]), time, to_list(1e3 * track.feet[f].angle[a])});
    }
    html += make_svg(angles);
    for (size_t f = 0; f < track.feet.size(); ++f) {
      for (int a = 0; a < kAxes; ++a) {
        const Plot plot{r.scenario.feet[f] + ", " + kAxisNames[a], "time [s]", "torque [N m]",
                        {{"sensed", time, to_list(track.feet[f].torque[a])}, {"reconstructed", time, to_list(predict_torque(r.fit, track, f, a))}}};
        html += make_svg(plot);
      }
    }
    html += "</div>";
  }
  return html;
}

}  // namespace

Identification identify(const Scenario& scenario, const std::vector<MotionTrack>& tracks, const std::vector<bool>& train,
                        const std::vector<SensorZero>& zeros, const std::vector<MotionTrack>& resting) {
  Identification r;
  r.scenario = scenario;
  r.tracks = tracks;
  r.train = train;
  const std::vector<Vector3d> arms = BushObserver(scenario).bush_centres();
  std::vector<MotionTrack> fitted, unseen;
  for (size_t i = 0; i < tracks.size(); ++i) {
    if (has_slipped(tracks[i])) r.notes.push_back(tracks[i].name + print(": a sole slipped (%.1f mm, %.1f mrad): left out", 1e3 * tracks[i].slip, 1e3 * tracks[i].turn));
    (train[i] ? fitted : unseen).push_back(tracks[i]);
  }
  FitOptions options;
  if (!resting.empty()) options.noise = calc_angle_noise(resting[0]);
  r.choice = choose_law(fitted, zeros, arms);
  options.law = r.choice.law;
  r.fit = fit_bush(fitted, zeros, arms, options);
  r.direct = validate(r.fit, fitted);
  for (size_t i = 0; i < fitted.size() && fitted.size() > 1; ++i) {
    std::vector<MotionTrack> others = fitted;
    others.erase(others.begin() + static_cast<long>(i));
    for (const ValidationError& e : validate(fit_bush(others, zeros, arms, options), {fitted[i]})) r.cross.push_back(e);
  }
  for (const ValidationError& e : validate(r.fit, unseen)) r.cross.push_back(e);
  r.compliance = fit_vertical_compliance(fitted);
  for (const std::string& name : r.fit.constrained) r.notes.push_back(name + " would have been negative and is held at zero");
  return r;
}

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
    // Vertical damping does not show in these motions: 1 kN s/m is an assumption where the scenario has none.
    bush["kz"] = f < r.compliance.size() ? 1.0 / r.compliance[f].value : place.kz > 0 ? place.kz : 3e5;
    bush["cz"] = place.cz > 0 ? place.cz : 1e3;
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
  }
  const std::string path = (std::filesystem::path(folder) / "identified.yaml").string();
  std::ofstream file(path);
  file << "# The bush as identified by hrp-identify-foot" << (r.simulated ? " from simulated data" : "") << "\n" << node << "\n";
  if (!file) throw std::runtime_error(path + ": cannot be written");
  return path;
}

std::string make_text(const Identification& r) {
  std::string text;
  for (size_t f = 0; f < r.fit.feet.size(); ++f) {
    for (int a = 0; a < kAxes; ++a) {
      const BushParameters& p = r.fit.feet[f][static_cast<size_t>(a)];
      text += print("%-16s %-5s  K %8.2f (%.2f %%)  C %7.3f (%.2f %%)  O %8.4f (%.2f %%)\n", r.scenario.feet[f].c_str(), kAxisNames[a], p.K.value,
                    100 * p.K.relative_std(), p.C.value, 100 * p.C.relative_std(), p.O.value, 100 * p.O.relative_std());
    }
  }
  double worst = 0.0;
  for (const ValidationError& e : r.cross) worst = std::max(worst, e.relative());
  text += print("law: %s (error on motions left out: linear %.4f, hardening %.4f N m)\n", r.choice.law == BushLaw::kLinear ? "linear" : "hardening",
                r.choice.linear_error, r.choice.hardening_error);
  text += print("cross-validation: worst mean error %.2f %% of the largest torque; condition number %.1f\n", 100 * worst, r.fit.condition);
  for (const std::string& note : r.notes) text += note + "\n";
  return text;
}

void write_report(const Identification& r, const std::string& path) {
  std::ofstream file(path);
  file << "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Viscoelasticity of the soles</title><style>"
          "body{font:15px/1.5 sans-serif;max-width:75em;margin:2em auto;padding:0 1em}table{border-collapse:collapse}"
          "td,th{border:1px solid #999;padding:.2em .6em;text-align:right}.row{display:flex;flex-wrap:wrap;gap:1em}"
          ".row svg{max-width:36em}</style></head><body><h1>Viscoelasticity of the soles</h1>";
  file << (r.simulated ? "<p><strong>All data in this report are simulated.</strong> " : "<p>");
  file << "Identified from joint encoders, force sensors and the chest IMU, with the grounded sole as base: torque = K angle + C rate + O.</p><pre>"
       << escape(make_text(r)) << "</pre>";
  file << print("<p>Accelerometer bias found beside them: x %.4f &plusmn; %.4f, y %.4f &plusmn; %.4f m/s&sup2;.</p>", r.fit.accelerometer_bias.x(),
                r.fit.accelerometer_bias_std.x(), r.fit.accelerometer_bias.y(), r.fit.accelerometer_bias_std.y());
  file << print("<p>Model selection: a hardening bush has %.4f N m on motions left out, a linear one %.4f N m; its cubic term is %.1f standard deviations from zero. Chosen: %s.</p>",
                r.choice.hardening_error, r.choice.linear_error, r.choice.significance, r.choice.law == BushLaw::kLinear ? "linear" : "hardening");
  file << make_table_1(r) << make_errors("Table 2: direct validation", r.direct, r)
       << make_errors("Table 3: cross-validation (each motion predicted by a fit that has not seen it)", r.cross, r) << make_figures(r)
       << "</body></html>\n";
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace hrp::identification
