// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/motions.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "common/base/format.h"
#include "common/spatial/minimum_jerk.h"
#include "controller/motion/leg.h"

namespace hrp::identification {
namespace {

constexpr double kFade = 2.0;        // [s]
constexpr double kFrame = 0.01;      // [s] of the motion file
constexpr double kPushSlice = 0.05;  // [s] a hand's force is constant this long
// [s] a hand on the trunk: the pelvis goes over one foot, the other rises. It does not come down again: a sole that
// lands on the simulator's floor of 1e9 N/m chatters, which an accelerometer read every 5 ms takes for 0.2 m/s^2.
constexpr double kShift[2] = {0.5, 3.0}, kRise[2] = {3.0, 4.5};
constexpr double kLift = 0.04;  // [m]
// [N/m], [N s/m] horizontal, of one arm that is not held stiff; the hand carries nothing. It holds the trunk on its yaw
// axis.
constexpr double kHandStiffness = 800.0, kHandDamping = 80.0, kHandHeight = 0.13;
constexpr double kHip = 0.06, kAnkleOffset = 0.035, kAnkleHeight = 0.105;            // [m] models/hrp2p_like
const LegGeometry kLegs[2] = {{0.3, 0.3, -kAnkleOffset}, {0.3, 0.3, kAnkleOffset}};  // right, left
const char* const kSides[2] = {"R", "L"};
const char* const kLegJoints[6] = {"HIP_Y", "HIP_R", "HIP_P", "KNEE", "ANKLE_P", "ANKLE_R"};

double sum_waves(const Waves& waves, double t, double duration) {
  const double fade = calc_minimum_jerk(t / kFade) * calc_minimum_jerk((duration - t) / kFade);
  double sum = 0.0;
  for (const Wave& w : waves) sum += w.amplitude * std::sin(2.0 * M_PI * w.frequency * t + w.phase);
  return fade * sum;
}

double calc_ramp(const double (&when)[2], double t) { return calc_minimum_jerk((t - when[0]) / (when[1] - when[0])); }

// [m] the pelvis stands over the ankle of the foot that stays.
double calc_shift(const MotionPlan& plan) {
  return plan.lifted < 0 ? 0.0 : (plan.lifted == 0 ? 1.0 : -1.0) * (kHip + kAnkleOffset + plan.width);
}

// Half-sitting (hip -26, knee 50, ankle -24 degrees): pelvis over the ankles, forward and up.
Vector3d calc_half_sitting() {
  const double hip = -26.0 * M_PI / 180.0, shank = 24.0 * M_PI / 180.0;
  return {0.3 * std::sin(hip) + 0.3 * std::sin(shank), 0.0, 0.3 * std::cos(hip) + 0.3 * std::cos(shank)};
}

// Pose of the foot above its bush against the hip.
Transform calc_foot(const MotionPlan& plan, int side, double t) {
  const double sign = side == 0 ? -1.0 : 1.0;
  const auto at = [&](const Waves& waves) { return sum_waves(waves, t, plan.duration); };
  Transform X_GB;
  X_GB.R = make_rotation_from_rpy({at(plan.lean[0]), at(plan.lean[1]), at(plan.turn)});
  X_GB.p = calc_half_sitting() + Vector3d(at(plan.pelvis[0]), at(plan.pelvis[1]), at(plan.pelvis[2]));
  X_GB.p.y() += calc_shift(plan) * calc_ramp(kShift, t);
  Transform X_GF;  // turned about the bush's centre, on the floor under the ankle
  X_GF.R = make_rotation_from_rpy({at(plan.foot[side][0]), at(plan.foot[side][1]), 0.0});
  X_GF.p = Vector3d(-sign * plan.stride, sign * (kHip + kAnkleOffset + plan.width), -kAnkleHeight) +
           X_GF.R * Vector3d(0, 0, kAnkleHeight);
  if (side == plan.lifted) X_GF.p.z() += kLift * calc_ramp(kRise, t);
  Transform X_BH;
  X_BH.p.y() = sign * kHip;
  return (X_GB * X_BH).inverse() * X_GF;
}

YAML::Node make_vector(double x, double y, double z) {
  YAML::Node node;
  for (double value : {x, y, z}) node.push_back(value);
  node.SetStyle(YAML::EmitterStyle::Flow);
  return node;
}

YAML::Node load_base(const Scenario& base) {
  YAML::Node node = YAML::Load(base.text);
  node["robot"] = base.robot;
  node.remove("controller");
  node.remove("recordings");
  return node;
}

const std::map<std::string, double>& get_arms() {
  static const std::map<std::string, double> arms = {{"R_SHOULDER_P", 0.261799}, {"R_SHOULDER_R", -0.174533},
                                                     {"R_ELBOW", -0.523599},     {"L_SHOULDER_P", 0.261799},
                                                     {"L_SHOULDER_R", 0.174533}, {"L_ELBOW", -0.523599}};
  return arms;
}

std::string write_scenario(const YAML::Node& node, const std::string& name, const std::string& folder) {
  std::string path = (std::filesystem::path(folder) / (name + ".yaml")).string();
  std::ofstream file(path);
  file << "# Simulated: made by hrp-identify-foot\n" << node << "\n";
  if (!file) throw std::runtime_error(path + ": cannot be written");
  return path;
}

void put_start(const Motion& motion, YAML::Node* node) {
  for (size_t j = 0; j < motion.joints.size(); ++j) {
    (*node)["initial"]["joints"][motion.joints[j]] = motion.positions(static_cast<Eigen::Index>(j), 0);
  }
}

void put_pushes(const MotionPlan& plan, YAML::Node* node) {
  if (plan.push[0].empty() && plan.push[1].empty()) return;
  for (int k = 0; (k + 1) * kPushSlice <= plan.duration; ++k) {
    const double t = (k + 0.5) * kPushSlice;
    YAML::Node push;
    push["link"] = "WAIST_P_LINK";
    push["force"] =
        make_vector(sum_waves(plan.push[0], t, plan.duration), sum_waves(plan.push[1], t, plan.duration), 0.0);
    push["start"] = k * kPushSlice;
    push["duration"] = kPushSlice;
    (*node)["pushes"]["hand" + std::to_string(k)] = push;
  }
}

// A hand that comes along to the foot that stays, and sways.
void put_hand(const MotionPlan& plan, YAML::Node* node) {
  if (plan.lifted < 0) return;
  YAML::Node hand;
  hand["link"] = "WAIST_P_LINK";
  hand["xyz"] = make_vector(0.0, 0.0, kHandHeight);
  hand["stiffness"] = make_vector(kHandStiffness, kHandStiffness, 0.0);
  hand["damping"] = make_vector(kHandDamping, kHandDamping, 0.0);
  const double path[][2] = {{kShift[0], 0.0}, {kShift[1], calc_shift(plan)}};
  for (const auto& [time, y] : path) {
    YAML::Node point;
    point["time"] = time;
    point["xyz"] = make_vector(0.0, y, 0.0);
    hand["path"].push_back(point);
  }
  for (int axis = 0; axis < 2; ++axis) {
    for (const Wave& w : plan.hand[axis]) {
      YAML::Node wave;
      wave["amplitude"] = make_vector(axis == 0 ? w.amplitude : 0.0, axis == 1 ? w.amplitude : 0.0, 0.0);
      wave["frequency"] = w.frequency;
      wave["phase"] = w.phase;
      wave["start"] = kRise[1];
      wave["duration"] = plan.duration - kRise[1];
      wave["fade"] = kFade;
      hand["waves"].push_back(wave);
    }
  }
  (*node)["hands"]["person"] = hand;
}

YAML::Node make_played(const Motion& motion, const std::string& name, const std::string& meaning, const Scenario& base,
                       const std::string& folder) {
  const std::string csv = (std::filesystem::absolute(folder) / (name + "_motion.csv")).string();
  std::ofstream file(csv);
  file << "# " << name << ": " << meaning << ". [s], [rad]\ntime";
  for (const std::string& joint : motion.joints) file << "," << joint;
  for (Eigen::Index k = 0; k < motion.positions.cols(); ++k) {
    file << format("\n%.3f", motion.times[static_cast<size_t>(k)]);
    for (double q : motion.positions.col(k)) file << format(",%.9f", q);
  }
  file << "\n";
  if (!file) throw std::runtime_error(csv + ": cannot be written");
  YAML::Node node = load_base(base);
  node.remove("initial");
  put_start(motion, &node);
  node["controller"]["motion"] = csv;
  return node;
}

}  // namespace

Motion make_motion(const MotionPlan& plan) {
  Motion motion;
  std::map<std::string, Waves> upper = plan.upper;
  for (const auto& [joint, rest] : get_arms()) upper[joint];
  for (const char* side : kSides) {
    for (const char* joint : kLegJoints) motion.joints.push_back(std::string(side) + "_" + joint);
  }
  for (const auto& [joint, waves] : upper) motion.joints.push_back(joint);
  const int frames = static_cast<int>(std::lround(plan.duration / kFrame)) + 1;
  motion.positions.resize(static_cast<Eigen::Index>(motion.joints.size()), frames);
  for (int k = 0; k < frames; ++k) {
    const double t = k * kFrame;
    motion.times.push_back(t);
    for (int side = 0; side < 2; ++side) {
      const auto angles = solve_leg(kLegs[side], calc_foot(plan, side, t));
      if (!angles) throw std::runtime_error(plan.name + ": a leg does not reach at " + std::to_string(t) + " s");
      motion.positions.col(k).segment<6>(6 * side) = *angles;
    }
    Eigen::Index row = 12;
    for (const auto& [joint, waves] : upper) {
      const auto arm = get_arms().find(joint);
      motion.positions(row++, k) = (arm == get_arms().end() ? 0.0 : arm->second) + sum_waves(waves, t, plan.duration);
    }
  }
  return motion;
}

std::string write_motion(const MotionPlan& plan, const Scenario& base, const std::string& folder) {
  YAML::Node node = make_played(make_motion(plan), plan.name, plan.meaning, base, folder);
  put_pushes(plan, &node);
  put_hand(plan, &node);
  node["steps"]["duration"] = plan.duration;
  node["seed"] = base.seed + plan.seed;
  return write_scenario(node, plan.name, folder);
}

std::string write_motion(const Motion& motion, const std::string& name, const std::string& meaning,
                         unsigned long long seed, const Scenario& base, const std::string& folder) {
  YAML::Node node = make_played(motion, name, meaning, base, folder);
  node["steps"]["duration"] = motion.duration();
  node["seed"] = base.seed + seed;
  return write_scenario(node, name, folder);
}

std::string write_robot(const Scenario& base, Rubber rubber, const std::string& folder) {
  YAML::Node node = YAML::Load(base.text);
  node["robot"] = base.robot;
  for (const std::string& foot : base.feet) {
    if (rubber == Rubber::kHardening) node["foot_bush"][foot]["hardening_angle"] = kHardeningAngle;
    for (const char* axis : {"_bush_roll", "_bush_pitch"}) {
      if (rubber != Rubber::kHysteresis) continue;
      YAML::Node law = node["joint_laws"][foot + axis]["hysteresis"];
      law["stiffness"] = kHysteresisStiffness;
      law["yield_angle"] = kYieldAngle;
    }
  }
  return write_scenario(node, "robot", folder);
}

std::string write_hanging(const Scenario& base, const std::string& folder) {
  YAML::Node node = load_base(base);
  node.remove("initial");
  MotionPlan still;
  still.duration = kFrame;
  put_start(make_motion(still), &node);
  node["base"] = "fixed";
  node["initial"]["position"] = make_vector(0.0, 0.0, 1.0);
  node["controller"]["type"] = "hold";
  node["steps"]["duration"] = 12.0;
  return write_scenario(node, "hanging", folder);
}

}  // namespace hrp::identification
