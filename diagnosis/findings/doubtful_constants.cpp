// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/doubtful_constants.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/effect_info.h"
#include "common/multibody/tree_mass.h"
#include "diagnosis/data/servo_gains.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/findings/finding_head.h"
#include "diagnosis/findings/grading.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

// A mass or its place, or an IMU that is turned, and gravity with it.
bool may_weigh(const Json& finding) {
  const std::string family = finding.value("family", "");
  return family == get_family_name(EffectFamily::kMass) ||
         (family == get_family_name(EffectFamily::kSensorGeometry) &&
          finding["where"].value("sensor", "").rfind("/imu/", 0) == 0);
}

bool is_constant_torque(const Json& finding) {
  const EffectInfo* info = find_effect(finding.value("effect", ""));
  return info && info->place == PlaceKind::kJoint && info->family == EffectFamily::kZero && info->linear;
}

// Value and standard deviation of a finding's only parameter; {0, 0} if it has others.
std::pair<double, double> read_constant(const Json& finding) {
  const Json& parameters = finding["parameters"];
  if (parameters.size() != 1 || !parameters.begin().value().contains("std") ||
      !parameters.begin().value()["value"].is_number())
    return {0.0, 0.0};
  return {parameters.begin().value()["value"], parameters.begin().value()["std"]};
}

// Masses, their places and turned IMUs that ambiguous findings may be, as alternatives. What several of them may be is
// listed once.
std::vector<Json> list_masses(const Json& findings) {
  std::vector<Json> masses;
  const auto add = [&](const Json& mass) {
    const auto is_same = [&](const Json& m) { return is_same_effect(m, mass); };
    if (may_weigh(mass) && std::none_of(masses.begin(), masses.end(), is_same)) masses.push_back(mass);
  };
  for (const Json& f : findings) {
    if (!is_ambiguous(f)) continue;
    if (may_weigh(f)) add(state_as_alternative(f));
    for (const Json& a : f.value("alternatives", Json::array())) add(a);
  }
  return masses;
}

// [m] How far a foot's sensor can be from a joint's axis: along the links. 0 if the joint does not carry it.
double calc_leg(const TreeSpec& tree, const FrameSpec& sensor, int link) {
  double length = sensor.X_LF.p.norm();
  for (int i = sensor.link; i > 0; i = tree.links[static_cast<size_t>(i)].parent) {
    if (i == link) return length;
    length += tree.links[static_cast<size_t>(i)].joint.X_PF.p.norm();
  }
  return 0.0;
}

// [N] The smallest zero of a foot's force that is this torque [N m] at a joint; 0 if the joint does not carry the foot,
// or if it is larger than zeros are.
double find_zero(const Experiment& e, const WrenchSpec& sensor, const std::string& joint, double torque) {
  const TreeSpec& tree = e.robot.tree;
  const int frame = tree.find_frame(sensor.link);
  if (frame < 0) return 0.0;
  const double leg = calc_leg(tree, tree.frames[static_cast<size_t>(frame)], tree.find_joint(joint) + 1);
  // Six-axis sensors drift by about a percent of their range, which for a robot's foot is about the robot's weight.
  return torque <= kTrace * calc_mass(tree) * e.scenario.gravity_W.norm() * leg ? torque / leg : 0.0;
}

// A foot in the air tells its sensor's zero.
bool lifts(const Experiment& e, const std::string& sensor) {
  double least = HUGE_VAL, most = 0.0;
  for (const Recording& r : e.recordings) {
    const auto column = r.other.find("/wrench/" + sensor + "/force/z");
    if (column == r.other.end()) return true;  // not read at all
    for (double f : column->second) {
      if (std::isfinite(f)) {
        least = std::min(least, std::abs(f));
        most = std::max(most, std::abs(f));
      }
    }
  }
  return least < kDetail * most;  // in the air
}

}  // namespace

void doubt_constants_of_masses(const Experiment& experiment, Json* report) {
  if (!experiment.scenario.floating_base) return;
  Json& findings = (*report)["findings"];
  const std::vector<Json> masses = list_masses(findings);
  if (masses.empty()) return;
  for (Json& f : findings) {
    if (!is_constant_torque(f) || f.value("grade", "") != get_grade_name(Grade::kSupported)) continue;
    make_ambiguous(&f);
    f["statement"] =
        f.value("statement", "") + " It may be the weight of what is not where the model or an IMU has it.";
    for (const Json& mass : masses) f["alternatives"].push_back(mass);
  }
}

void doubt_constants_of_feet(const Experiment& e, Json* report) {
  if (!e.scenario.floating_base) return;
  for (Json& f : (*report)["findings"]) {
    if (!is_constant_torque(f) || f.value("grade", "") == get_grade_name(Grade::kCertain)) continue;
    for (const WrenchSpec& sensor : e.scenario.sensors.wrenches) {
      const double zero = find_zero(e, sensor, f["where"]["joint"], std::abs(read_constant(f).first));
      if (!(zero > 0.0) || lifts(e, sensor.name)) continue;
      make_ambiguous(&f);
      f["statement"] = f.value("statement", "") + " A zero of " + number(zero, 2) + " N of /wrench/" + sensor.name +
                       " would do the same.";
      f["alternatives"].push_back(state_alternative(get_effect_of(PlaceKind::kSensor, EffectFamily::kZero),
                                                    {{"sensor", "/wrench/" + sensor.name + "/force"}}, Json::object(),
                                                    "that foot lifted once"));
    }
  }
}

void doubt_constants_of_commands(const Experiment& e, Json* report) {
  Json& findings = (*report)["findings"];
  for (int j = 0; j < e.num_joints() && e.scenario.drive == "servo"; ++j) {
    const std::string joint = e.robot.tree.joint(j).name;
    const double kp = get_servo_gains(e.scenario, joint).kp;
    Json *of_log = nullptr, *of_joint = nullptr;
    for (Json& f : findings) {
      if (f["effect"] == get_effect_of(PlaceKind::kSensor, EffectFamily::kZero).name &&
          f["where"].value("sensor", "") == e.signal_name(j, Quantity::kEffort))
        of_log = &f;
      if (is_constant_torque(f) && f["where"].value("joint", "") == joint) of_joint = &f;
    }
    if (!of_log || !of_joint || !(kp > 0.0)) continue;
    const auto [bias, bias_std] = read_constant(*of_log);
    const auto [torque, torque_std] = read_constant(*of_joint);
    if (!(bias * torque < 0.0) || std::abs(bias + torque) > kNinetyFive * std::hypot(bias_std, torque_std)) continue;
    for (Json* f : {of_log, of_joint}) {
      make_ambiguous(f);
      (*f)["statement"] = f->value("statement", "") + " Or the zero of the commands is " + number(bias / kp, 3) +
                          " off that of the positions: then there is neither this nor the opposite " +
                          (f == of_log ? "torque." : "zero of the log.");
    }
    (*of_log)["alternatives"].push_back(state_as_alternative(*of_joint));
    (*of_joint)["alternatives"].push_back(state_as_alternative(*of_log));
  }
}

}  // namespace hrp::diagnosis
