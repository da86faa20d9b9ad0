// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/safety.h"

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"
#include "common/base/rounding.h"

namespace hrp::diagnosis {
namespace {

constexpr double kCollisionPeriod = 0.02;  // [s] between poses of the collision check
constexpr double kClear = 0.02;            // [m] least clearance of a hanging robot above the ground

double find_radius(const CollisionShape& shape) {
  switch (shape.kind) {
    case ShapeKind::kBox: return 0.5 * shape.size.norm();
    case ShapeKind::kCylinder: return std::hypot(shape.size.x(), 0.5 * shape.size.y());
    default: return shape.size.x();
  }
}

// Height [m] of the lowest point of the moving links, with each shape replaced by a sphere around it.
double find_lowest(const RobotDescription& robot, const Data& data) {
  double lowest = 1e300;
  for (const CollisionShape& shape : robot.shapes) {
    if (shape.link == 0 || shape.kind == ShapeKind::kMesh) continue;
    const Vector3d center_W = get_pose(data, shape.link) * shape.X_LG.p;
    lowest = std::min(lowest, center_W.z() - find_radius(shape));
  }
  return lowest;
}

// What is wrong with position, speed and effort of a joint; empty if nothing is.
std::string find_fault_at(const double* x, const JointLimits& limits) {
  if (!(x[0] >= limits.hard_lower && x[0] <= limits.hard_upper)) return " reaches " + number(x[0], 3);
  if (!(std::abs(x[1]) <= kSpeedMargin * limits.speed)) return " gets as fast as " + number(std::abs(x[1]), 3);
  if (!(std::abs(x[2]) <= limits.effort)) return " needs an effort of " + number(std::abs(x[2]), 3);
  return "";
}

void raise_to_distance(const Recording& recording, const std::vector<double>& readings, size_t first,
                       std::vector<double>* leave) {
  const size_t n = leave->size();
  for (size_t k = first; k < recording.size(); ++k) {
    for (size_t j = 0; j < n; ++j)
      (*leave)[j] =
          std::max((*leave)[j], std::abs(readings[(k * n + j) * kQuantities] - recording.joints[j].command[k]));
  }
}

}  // namespace

Safety::Safety(const Experiment& experiment, const Limits& limits)
    : experiment_(experiment), limits_(limits), scenario_(experiment.scenario), remarks_(limits.remarks) {
  scenario_.self_collision = true;
  model_ = std::make_unique<Model>(experiment.robot.tree, scenario_.gravity_W);
  if (experiment.robot.shapes.empty()) {
    remarks_.push_back("the URDF has no collision shapes: collisions of the robot with itself are not checked");
    return;
  }
  try {
    world_ = std::make_unique<CollisionWorld>(experiment.robot, scenario_);
  } catch (const InputError& error) {
    remarks_.push_back(std::string("collisions are not checked: ") + error.what());
  }
}

std::string Safety::find_fault(const TrialMotion& motion, const Hypothesis& hypothesis, std::vector<double>* leave,
                               std::vector<char>* faulty) {
  std::vector<double> readings;
  if (!simulate_trial(motion, hypothesis, &readings)) return "the simulated robot leaves all bounds";
  return find_fault_of(motion, readings, leave, faulty);
}

std::string Safety::find_fault_of(const TrialMotion& motion, const std::vector<double>& readings,
                                  std::vector<double>* leave, std::vector<char>* faulty) {
  const size_t first = motion.problem.smooth[0].start, rows = motion.experiment.recordings[0].size();
  const std::string fault = find_joint_fault(readings, first, rows, faulty);
  const std::vector<double>& time = motion.experiment.recordings[0].time;
  if (leave) raise_to_distance(motion.experiment.recordings[0], readings, first, leave);
  return fault.empty() ? find_contact(readings, first, rows, time[1] - time[0]) : fault;
}

std::string Safety::find_joint_fault(const std::vector<double>& readings, size_t first, size_t rows,
                                     std::vector<char>* faulty) const {
  const size_t n = limits_.joints.size();
  std::string found;
  for (size_t k = first; k < rows; ++k) {
    for (size_t j = 0; j < n; ++j) {
      const double* x = &readings[(k * n + j) * kQuantities];
      const std::string fault = find_fault_at(x, limits_.joints[j]);
      if (fault.empty()) continue;
      if (found.empty()) found = experiment_.robot.tree.joint(static_cast<int>(j)).name + fault;
      if (!faulty) return found;
      (*faulty)[j] = 1;
    }
  }
  return found;
}

std::string Safety::find_contact(const std::vector<double>& readings, size_t first, size_t rows, double period) {
  const size_t n = limits_.joints.size();
  if (!world_) return "";
  const size_t stride = std::max<size_t>(1, static_cast<size_t>(std::lround(kCollisionPeriod / period)));
  State state = world_->start_state();
  Data data(*model_);
  update_kinematics(*model_, state, &data);
  const bool high = scenario_.ground.present && find_lowest(experiment_.robot, data) > scenario_.ground.height + kClear;
  const double least = scenario_.ground.height + std::max(kClear, limits_.ground);
  for (size_t k = first; k < rows; k += stride) {
    for (size_t j = 0; j < n; ++j) state.q[static_cast<long>(j)] = readings[(k * n + j) * kQuantities];
    for (const ContactPair& pair : world_->calc_contacts(state)) {
      const auto name = [&](int link) {
        return link >= 0 ? experiment_.robot.tree.links[static_cast<size_t>(link)].name
                         : std::string(link == kGround ? "the ground" : "an obstacle");
      };
      return name(pair.body_a) + " touches " + name(pair.body_b);
    }
    update_kinematics(*model_, state, &data);
    if (high && find_lowest(experiment_.robot, data) < least) return "the robot comes near the ground";
  }
  return "";
}

}  // namespace hrp::diagnosis
