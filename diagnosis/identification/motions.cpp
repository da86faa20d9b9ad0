// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/motions.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>

#include "controller/motion/leg.h"
#include "diagnosis/identification/bush_angles.h"

namespace hrp::identification {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kFade = 2.0;                                              // [s]
constexpr double kFrame = 0.01;                                            // [s] of the motion file
constexpr double kPushSlice = 0.05;                                        // [s] a hand's force is constant this long
constexpr double kHip = 0.06, kAnkleOffset = 0.035, kAnkleHeight = 0.105;  // [m] models/hrp2p_like
const LegGeometry kLegs[2] = {{0.3, 0.3, -kAnkleOffset}, {0.3, 0.3, kAnkleOffset}};  // right, left
const char* const kSides[2] = {"R", "L"};
const char* const kLegJoints[6] = {"HIP_Y", "HIP_R", "HIP_P", "KNEE", "ANKLE_P", "ANKLE_R"};

double calc_ramp(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

double sum_waves(const Waves& waves, double t, double duration) {
  const double fade = calc_ramp(t / kFade) * calc_ramp((duration - t) / kFade);
  double sum = 0.0;
  for (const Wave& w : waves) sum += w.amplitude * std::sin(2.0 * kPi * w.frequency * t + w.phase);
  return fade * sum;
}

// Half-sitting (hip -26, knee 50, ankle -24 degrees): pelvis over the ankles, forward and up.
Vector3d calc_half_sitting() {
  const double hip = -26.0 * kPi / 180.0, shank = 24.0 * kPi / 180.0;
  return {0.3 * std::sin(hip) + 0.3 * std::sin(shank), 0.0, 0.3 * std::cos(hip) + 0.3 * std::cos(shank)};
}

// Pose of the foot above its bush against the hip.
Transform calc_foot(const MotionPlan& plan, int side, double t) {
  const double sign = side == 0 ? -1.0 : 1.0;
  const auto at = [&](const Waves& waves) { return sum_waves(waves, t, plan.duration); };
  Transform X_GB;
  X_GB.R = make_rotation_from_rpy({at(plan.lean[0]), at(plan.lean[1]), at(plan.turn)});
  X_GB.p = calc_half_sitting() + Vector3d(at(plan.pelvis[0]), at(plan.pelvis[1]), at(plan.pelvis[2]));
  Transform X_GF;  // turned about the bush's centre, on the floor under the ankle
  X_GF.R = make_rotation_from_rpy({at(plan.foot[side][0]), at(plan.foot[side][1]), 0.0});
  X_GF.p = Vector3d(-sign * plan.stride, sign * (kHip + kAnkleOffset + plan.width), -kAnkleHeight) +
           X_GF.R * Vector3d(0, 0, kAnkleHeight);
  Transform X_BH;
  X_BH.p.y() = sign * kHip;
  return (X_GB * X_BH).inverse() * X_GF;
}

Waves both(double a1, double f1, double a2, double f2, double phase) {
  return {{a1, f1, phase}, {a2, f2, 2.0 * phase + 0.5}};
}

// What makes every motion tell stiffness apart from damping on all four axes: the feet turn against their soles, slowly
// and quickly, right and left against each other, so that the robot as a whole hardly moves.
void add_foot_waves(int number, double amplitude, MotionPlan* plan) {
  const double shift = 0.7 * number;
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1.0 : -1.0;
    plan->foot[side][0] = both(sign * 0.8 * amplitude, 0.31 + 0.017 * number, sign * 0.4 * amplitude, 1.13, shift);
    plan->foot[side][1] =
        both(sign * 0.8 * amplitude, 0.23 + 0.013 * number, sign * 0.4 * amplitude, 0.97, shift + 1.0);
  }
  // Pelvis and chest turn left and right, one radian in all: tells the accelerometer's bias from offsets of the bush,
  // the better the longer they stay turned (hence the third harmonic). The waist ends at 0.785 rad.
  const double sign = number % 2 == 0 ? 1.0 : -1.0, once = 1.0 / plan->duration;
  plan->upper["WAIST_Y"] = {{0.84 * sign, once, 0.0}, {0.17 * sign, 3.0 * once, 0.0}};
  plan->turn = {{0.28 * sign, once, 0.0}, {0.056 * sign, 3.0 * once, 0.0}};
}

void add_tilts(std::vector<MotionPlan>* plans) {
  const char* const stances[] = {"regular", "sideways", "forward"};
  for (int i = 0; i < 6; ++i) {
    MotionPlan plan;
    plan.name = "tilt" + std::to_string(i + 1);
    plan.meaning =
        std::string("chest tilts at 0.1 Hz, ") + stances[i / 2] + " stance" + (i % 2 ? ", with vertical sway" : "");
    plan.width = i / 2 == 1 ? 0.05 : 0.0;
    plan.stride = i / 2 == 2 ? 0.04 : 0.0;
    plan.lean[0] = {{i / 2 == 2 ? 0.01 : 0.02, 0.1, 0.4 * i}};
    plan.lean[1] = {{0.03, 0.1, 1.3 + 0.3 * i}};
    plan.pelvis[0] = {{0.006, 0.1, 0.5 * i}};
    plan.pelvis[1] = {{i / 2 == 2 ? 0.008 : 0.012, 0.1, 1.0 + 0.5 * i}};
    if (i % 2) plan.pelvis[2] = {{0.015, 0.3, 0.0}};
    add_foot_waves(i, i / 2 == 2 ? 0.017 : 0.02, &plan);
    plans->push_back(plan);
  }
}

// The hand is a force that changes with time. On one foot alone this robot's rubber does not hold it (K < m g h): what
// comes nearest is most of the weight on one foot.
void add_sways(std::vector<MotionPlan>* plans) {
  const char* const meanings[] = {"hand sways forward and back", "hand sways sideways", "hand sways around",
                                  "hand sways, most weight on the right foot",
                                  "hand sways, most weight on the left foot"};
  for (int i = 0; i < 5; ++i) {
    MotionPlan plan;
    plan.name = "sway" + std::to_string(i + 1);
    plan.meaning = meanings[i];
    if (i != 1) plan.push[0] = {{i >= 2 ? 2.5 : 4.0, 0.17 + 0.01 * i, 0.3 * i}, {1.5, 0.81, 0.0}};
    if (i != 0)
      plan.push[1] = {{i == 1 ? 12.0 : (i == 2 ? 8.0 : 6.0), 0.21 + 0.02 * i, 0.0}, {i >= 2 ? 3.0 : 5.0, 0.71, 0.4}};
    if (i >= 3) plan.pelvis[1] = {{i == 3 ? -0.02 : 0.02, 0.025, 0.0}};
    add_foot_waves(6 + i, i == 1 ? 0.02 : 0.017, &plan);
    plans->push_back(plan);
  }
}

void add_rest(std::vector<MotionPlan>* plans) {
  for (int i = 0; i < 2; ++i) {
    MotionPlan plan;
    plan.name = "sweep" + std::to_string(i + 1);
    plan.meaning = "random sweep of the upper body";
    std::mt19937_64 random(static_cast<unsigned long long>(i) + 7);
    const auto draw = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
    add_foot_waves(11 + i, 0.018, &plan);
    for (const char* joint : {"R_SHOULDER_P", "L_SHOULDER_P", "R_ELBOW", "L_ELBOW", "NECK_Y", "WAIST_P"}) {
      const double size = std::string(joint) == "WAIST_P" ? 0.015 : 0.2;
      plan.upper[joint] = {{size * (0.5 + 0.5 * draw()), 0.1 + 0.2 * draw(), 6.0 * draw()},
                           {0.3 * size * draw(), 0.3 + 0.4 * draw(), 6.0 * draw()}};
    }
    plans->push_back(plan);
  }
  MotionPlan squat;
  squat.name = "squat";
  squat.meaning = "pelvis down 6 cm and up";
  squat.pelvis[2] = {{-0.03, 0.1, 0.0}, {-0.02, 0.2, 0.0}};
  add_foot_waves(13, 0.018, &squat);
  plans->push_back(squat);
  MotionPlan bounce;  // beyond the paper: only quick changes of load show the vertical stiffness to an accelerometer
  bounce.name = "bounce";
  bounce.meaning = "pelvis bounces at 1.9 and 4.6 Hz: vertical stiffness";
  bounce.pelvis[2] = {{0.003, 1.9, 0.0}, {0.001, 4.6, 1.0}};
  add_foot_waves(14, 0.01, &bounce);
  plans->push_back(bounce);
}

// All joints of the upper body at once, each with two waves of its own: tells link from link, and friction from
// inertia.
void add_swings(std::vector<MotionPlan>* plans) {
  const char* const arm[] = {"SHOULDER_P", "SHOULDER_R", "SHOULDER_Y", "ELBOW", "WRIST_Y", "WRIST_P"};
  for (int i = 0; i < 3; ++i) {
    MotionPlan plan;
    plan.name = "swing" + std::to_string(i + 1);
    plan.meaning = "arms, neck and trunk swing at random";
    std::mt19937_64 random(static_cast<unsigned long long>(i) + 31);
    const auto draw = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
    const auto make = [&](double size) -> Waves {
      return {{size * (0.6 + 0.4 * draw()), 0.15 + 0.2 * draw(), 6.0 * draw()},
              {0.4 * size * (0.6 + 0.4 * draw()), 0.5 + 0.5 * draw(), 6.0 * draw()}};
    };
    add_foot_waves(15 + i, 0.016, &plan);
    plan.lean[0] = make(0.005);
    plan.lean[1] = make(0.008);
    plan.upper["WAIST_P"] = make(0.012);
    plan.upper["NECK_Y"] = make(0.5);
    plan.upper["NECK_P"] = make(0.3);
    for (const char* side : kSides) {
      for (const char* joint : arm) plan.upper[std::string(side) + "_" + joint] = make(joint[0] == 'W' ? 0.5 : 0.2);
    }
    plans->push_back(plan);
  }
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
  const std::string path = (std::filesystem::path(folder) / (name + ".yaml")).string();
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

}  // namespace

std::vector<MotionPlan> make_plans(double scale) {
  std::vector<MotionPlan> plans;
  add_tilts(&plans);
  add_sways(&plans);
  add_rest(&plans);
  add_swings(&plans);
  for (MotionPlan& plan : plans) plan.duration *= scale;
  return plans;
}

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
  const Motion motion = make_motion(plan);
  const std::string csv = (std::filesystem::absolute(folder) / (plan.name + "_motion.csv")).string();
  std::ofstream file(csv);
  file << "# " << plan.name << ": " << plan.meaning << ". [s], [rad]\ntime";
  for (const std::string& joint : motion.joints) file << "," << joint;
  char text[32];
  for (Eigen::Index k = 0; k < motion.positions.cols(); ++k) {
    std::snprintf(text, sizeof text, "\n%.3f", motion.times[static_cast<size_t>(k)]);
    file << text;
    for (double q : motion.positions.col(k)) {
      std::snprintf(text, sizeof text, ",%.9f", q);
      file << text;
    }
  }
  file << "\n";
  if (!file) throw std::runtime_error(csv + ": cannot be written");
  YAML::Node node = load_base(base);
  node.remove("initial");
  put_start(motion, &node);
  put_pushes(plan, &node);
  node["controller"]["motion"] = csv;
  node["steps"]["duration"] = plan.duration;
  return write_scenario(node, plan.name, folder);
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

MotionCheck check_motion(const std::string& scenario_path) {
  const Scenario scenario = without_sensor_errors(load_scenario(scenario_path));
  const BushObserver observer(scenario);
  const MotionTrack track = observer.observe(run_in_process(scenario), std::vector<SensorZero>(scenario.feet.size()));
  MotionCheck check;
  check.margin = check.smallest_load = 1e9;
  // Sole of models/hrp2p_like against the ankle: toe 0.135 m, heel 0.105 m, half width 0.068 m.
  for (size_t f = 0; f < track.feet.size(); ++f) {
    const BushTrack& foot = track.feet[f];
    check.smallest_load = std::min(check.smallest_load, foot.load.minCoeff());
    check.margin = std::min({check.margin, 0.135 - foot.zmp.row(0).maxCoeff(), 0.105 + foot.zmp.row(0).minCoeff(),
                             0.068 - foot.zmp.row(1).cwiseAbs().maxCoeff()});
    for (int a = 0; a < kAxes; ++a) {
      Eigen::MatrixXd X(track.time.size(), 3);
      X << foot.angle[a], foot.rate[a], Eigen::VectorXd::Ones(track.time.size());
      const Eigen::MatrixXd scaled = X * X.colwise().norm().cwiseInverse().asDiagonal();
      const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(scaled).singularValues();
      check.condition = std::max(check.condition, values[0] / std::max(values[2], 1e-12));
      for (int p = 0; p < 2; ++p) {
        check.information[f][a][p] = (X.col(p).array() - X.col(p).mean()).square().sum() * track.period;
      }
    }
  }
  return check;
}

MotionPlan improve_plan(const MotionPlan& plan, const Scenario& base, const std::string& folder, int tries,
                        MotionCheck* check) {
  MotionPlan best = plan;
  *check = check_motion(write_motion(plan, base, folder));
  std::mt19937_64 random(11);
  const auto draw = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  // What the least known stiffness and damping would gain: information, balanced by the square of a usual rate 5 rad/s.
  const auto rate = [](const MotionCheck& c) {
    double least = 1e9;
    for (const auto& foot : c.information) {
      for (const auto& axis : foot) least = std::min({least, axis[0], axis[1] / 25.0});
    }
    return c.ok() ? least / c.condition : -1.0;
  };
  for (int k = 0; k < tries; ++k) {
    MotionPlan other = best;
    other.name = plan.name + "_try";
    const double gain[2] = {0.7 + 0.8 * draw(), 0.7 + 0.8 * draw()},
                 tempo[2] = {0.7 + 0.8 * draw(), 0.7 + 0.8 * draw()};
    for (int a = 0; a < 2; ++a) {
      for (auto& foot : other.foot) {
        for (Wave& wave : foot[a]) {
          wave.amplitude *= gain[a];
          wave.frequency *= tempo[a];
        }
      }
    }
    const MotionCheck result = check_motion(write_motion(other, base, folder));
    if (rate(result) <= rate(*check)) continue;
    best = other;
    best.name = plan.name;
    *check = result;
  }
  return best;
}

}  // namespace hrp::identification
