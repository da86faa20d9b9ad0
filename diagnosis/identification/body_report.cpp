// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "diagnosis/identification/html.h"

namespace hrp::identification {

std::string make_cell(const Estimate& e, const double* truth) {
  std::string cell = format("<td>%.4g</td><td>%.4g</td><td>%.2f %%</td>", e.value, e.std, 100.0 * e.relative_std());
  cell += truth == nullptr ? "<td></td>"
                           : format("<td>%.4g (%+.2f %%, %+.1f &sigma;)</td>", *truth, 100.0 * (e.value / *truth - 1.0),
                                    (e.value - *truth) / e.std);
  return cell;
}

double sum_laws(const Scenario& scenario, const std::string& joint, const char* effect, const char* parameter) {
  double sum = 0.0;
  const auto laws = scenario.joint_laws.find(joint);
  if (laws == scenario.joint_laws.end()) return sum;
  for (const StatedEffect& law : laws->second) {
    if (law.effect == effect && law.parameters.count(parameter) > 0) sum += law.parameters.at(parameter);
  }
  return sum;
}

namespace {

std::string make_parameters(const Identification& r, const BodyRig& rig) {
  const Eigen::VectorXd truth = r.body->T * make_inertial_parameters(rig.model);
  std::string html =
      "<h3>Inertial base parameters, without joint torques [M14 eq. "
      "2]</h3><table><tr><th>link</th><th>value</th><th>std</th>"
      "<th>relative std</th><th>simulated truth (error)</th><th>description</th><th>nearest bodies</th></tr>";
  for (size_t i = 0; i < r.body->parameters.size(); ++i) {
    const BodyParameter& p = r.body->parameters[i];
    if (!p.is_shown()) continue;
    const double t = truth[static_cast<Eigen::Index>(i)];
    html += "<tr><td>" + escape_xml(p.name) + "</td>" + make_cell(p.estimate, r.simulated ? &t : nullptr) +
            format("<td>%.4g</td><td>%.4g</td></tr>", p.described, p.physical);
  }
  return html + "</table>";
}

std::string make_joints(const Identification& r, const BodyRig& rig) {
  static const char* const kNames[kJointParameters] = {"rotor inertia [kg m&sup2;]", "viscous friction [N m s/rad]",
                                                       "Coulomb friction [N m]"};
  if (r.body->joints.empty())
    return "<p>No efforts were recorded, or no joint moved enough: joint parameters are not identified.</p>";
  const Eigen::VectorXd model = make_joint_parameters(rig.model);
  std::string html =
      "<details><summary>Joint parameters [M14 eq. "
      "3]</summary><table><tr><th>joint</th><th></th><th>value</th><th>std</th><th>relative "
      "std</th><th>simulated truth (error)</th></tr>";
  for (const JointEstimate& joint : r.body->joints) {
    const double laws[kJointParameters] = {0.0, sum_laws(r.scenario, joint.name, "viscous_friction", "coefficient"),
                                           sum_laws(r.scenario, joint.name, "coulomb_friction", "level")};
    for (int i = 0; i < kJointParameters; ++i) {
      const double truth = model[kJointParameters * joint.joint + i] + laws[i];
      html += "<tr><td>" + escape_xml(joint.name) + "</td><td>" + kNames[i] + "</td>" +
              make_cell(joint.values[i], r.simulated ? &truth : nullptr) + "</tr>";
    }
  }
  return html + "</table></details>";
}

std::string make_body_errors(const Identification& r) {
  std::string html =
      "<h3>Validation: mean error of the base's moments [N m] and forces "
      "[N]</h3><table><tr><th>motion</th><th></th><th>largest change</th>"
      "<th>description</th><th>identified</th><th>nearest bodies</th><th>over the largest change</th></tr>";
  for (const BodyError& e : r.body->errors) {
    html +=
        "<tr><td>" + escape_xml(e.motion) + "</td><td>" + (e.fitted ? "fitted" : "not seen") + "</td>" +
        format(
            "<td>%.2f, %.2f</td><td>%.3f, %.3f</td><td>%.3f, %.3f</td><td>%.3f, %.3f</td><td>%.2f %%, %.2f "
            "%%</td></tr>",
            e.largest[0], e.largest[1], e.described[0], e.described[1], e.estimated[0], e.estimated[1], e.physical[0],
            e.physical[1], 100.0 * e.physical[0] / e.largest[0], 100.0 * e.physical[1] / e.largest[1]);
  }
  return html + "</table>";
}

}  // namespace

std::string make_body_section(const Identification& r) {
  if (!r.body) return "";
  const BodyRig rig(r.scenario);
  const auto shown = std::count_if(r.body->parameters.begin(), r.body->parameters.end(),
                                   [](const BodyParameter& p) { return p.is_shown(); });
  return "<h2>Inertial and joint parameters of everything above the ankles</h2>" +
         format(
             "<p>%ld of %ld base parameters are shown by these motions (relative standard deviation below %.0f %%); m "
             "is mass [kg], m x and so on "
             "mass times place [kg m], I inertia about the link's origin [kg m&sup2;]; a + stands for links after it, "
             "too. The nearest bodies are "
             "parameters of all links with positive mass and positive pseudo-inertia (smallest eigenvalue %.1e of the "
             "largest).%s</p>",
             static_cast<long>(shown), static_cast<long>(r.body->parameters.size()), 100.0 * kShown,
             r.body->smallest_eigenvalue,
             r.simulated ? " The description it starts from is a wrong one: every body stretched, moved and made "
                           "denser by about a tenth at random."
                         : "") +
         make_parameters(r, rig) + make_body_errors(r) + make_joints(r, rig);
}

std::string make_body_text(const Identification& r) {
  if (!r.body) return "";
  double worst[2] = {};
  for (const BodyError& e : r.body->errors) {
    for (int g = 0; g < 2; ++g) worst[g] = std::max(worst[g], e.fitted ? 0.0 : e.physical[g] / e.largest[g]);
  }
  const Estimate& mass = r.body->parameters.front().estimate;
  return format(
      "body above the ankles: %.3f kg (%.3f %%); %zu joints; worst mean error on motions not seen: moments %.2f %%, "
      "forces %.2f %% of the largest change\n",
      mass.value, 100.0 * mass.relative_std(), r.body->joints.size(), 100.0 * worst[0], 100.0 * worst[1]);
}

}  // namespace hrp::identification
