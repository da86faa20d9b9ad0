// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/stance_trial.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/multibody/kinematics.h"
#include "common/robot/sole.h"
#include "common/scene/ground_contact.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/model/tree.h"
#include "diagnosis/standing/sole.h"
#include "servers/console/trial/trial.h"

namespace hrp::diagnosis {
namespace {

// [s] At rest before the motion. A stiff robot that is put down on ground that slopes by one degree rocks for 1.5 s.
constexpr double kRest = 2.0;
constexpr double kSettled = 1.6;        // [s] start of the checks; the robot is put down at 0
constexpr double kLeastMargin = 0.005;  // [m] from the edge, of a robot that stands near it at rest
constexpr double kLean = 0.3;           // [rad] of the base; a motion over fixed soles leans less
constexpr double kWindow = 0.02;        // [s] over which forces are averaged (light soles chatter), and between checks

class StanceController : public Controller {
 public:
  StanceController(const Experiment& e, const Commands& commands, const Robot& robot) : commands_(commands) {
    for (int j = 0; j < e.num_joints(); ++j) joints_.push_back(robot.find_joint(e.robot.tree.joint(j).name));
  }

  JointCommand control(const SensorData& sensors, const Robot& robot) override {
    JointCommand command;
    command.q = robot.initial_q;
    command.qd = Eigen::VectorXd::Zero(command.q.size());
    const double period = commands_.time[1] - commands_.time[0];
    const double at =
        std::clamp((sensors.time + robot.period - kRest) / period, 0.0, static_cast<double>(commands_.time.size() - 1));
    const size_t k = std::min(static_cast<size_t>(at), commands_.time.size() - 2);
    const double share = at - static_cast<double>(k);
    for (size_t j = 0; j < joints_.size(); ++j) {
      if (joints_[j] < 0) continue;
      command.q[joints_[j]] = (1.0 - share) * commands_.position[j][k] + share * commands_.position[j][k + 1];
      command.qd[joints_[j]] = (1.0 - share) * commands_.velocity[j][k] + share * commands_.velocity[j][k + 1];
    }
    return command;
  }

 private:
  Commands commands_;
  std::vector<int> joints_;
};

// Support polygon, counter-clockwise: hull of all points of these feet's soles that are on the ground.
std::vector<Vector3d> find_stand(const RobotDescription& robot, const State& state, const GroundPlane& ground,
                                 const std::vector<int>& feet) {
  Model model(robot.tree);
  Data data(model);
  update_kinematics(model, state, &data);
  std::vector<PointForce> points;
  double lowest = 1e300;
  for (const Sole& sole : make_soles(robot)) {
    if (std::none_of(feet.begin(), feet.end(), [&](int link) { return is_above(robot.tree, link, sole.link); }))
      continue;
    for (const SolePoint& point : sole.points) {
      points.emplace_back();
      points.back().p_WC = get_pose(data, sole.link) * point.p_LQ - Vector3d(0, 0, point.radius);
      lowest = std::min(lowest, points.back().p_WC.z());
    }
  }
  PairForce all;
  for (const PointForce& point : points) {
    if (point.p_WC.z() < lowest + standing::kLevel) all.points.push_back(point);
  }
  return calc_support_polygon({all}, ground);
}

// Distance [m] from the nearest edge, negative outside.
double calc_distance(const std::vector<Vector3d>& hull, const Vector3d& p) {
  double least = 1e300;
  for (size_t i = 0; i < hull.size(); ++i) {
    const Vector3d a = hull[i], along = hull[(i + 1) % hull.size()] - a, to = p - a;
    least =
        std::min(least, (along.x() * to.y() - along.y() * to.x()) / std::max(1e-9, std::hypot(along.x(), along.y())));
  }
  return hull.size() < 3 ? -1.0 : least;
}

class Watch {
 public:
  Watch(const Experiment& e, const Limits& limits, const Scenario& scenario, const Trial& trial, bool walks)
      : e_(e),
        limits_(limits),
        walks_(walks),
        ground_(make_ground_plane(scenario.ground)),
        gravity_(scenario.gravity_W.norm()),
        stretch_(std::max(1, static_cast<int>(std::lround(kStretch / scenario.time_step)))) {
    const TreeSpec& tree = trial.robot().tree;
    for (int j = 0; j < e.num_joints(); ++j) joints_.push_back(tree.find_joint(e.robot.tree.joint(j).name));
    for (const std::string& foot : scenario.feet)
      feet_.push_back(tree.frames[static_cast<size_t>(tree.find_frame(foot))].link);
    for (const LinkSpec& link : tree.links) weight_ += gravity_ * link.inertia.mass;
  }

  // Called after every step.
  void add_forces(const Trial& trial) {
    const ContactForces& now = trial.engine().contact_forces();
    forces_.insert(forces_.end(), now.begin(), now.end());
    loads_.resize(trial.engine().foot_forces().size(), 0.0);
    for (size_t f = 0; f < loads_.size(); ++f) loads_[f] += trial.engine().foot_forces()[f];
    ++steps_;
  }

  // Called at the end of a window.
  void look(Trial& trial, StanceRun* run) {
    const State& state = trial.engine().state();
    if (trial.time() >= kSettled) {
      if (walks_ || hull_.empty()) hull_ = find_stand(trial.robot(), state, ground_, walks_ ? list_carrying() : feet_);
      look_at_balance(state, trial.time() < kRest, run);
      if (run->fault.empty()) look_at_contacts(trial, run);
    }
    forces_.clear();
    loads_.clear();
    steps_ = 0;
  }

  void look_at_joints(const Trial& trial, StanceRun* run) const {
    const SensorSample& sample = trial.engine().sensors();
    for (size_t j = 0; j < joints_.size(); ++j) {
      const JointLimits& limits = limits_.joints[j];
      const double q = sample.q[joints_[j]], qd = sample.qd[joints_[j]], effort = sample.effort[joints_[j]];
      const std::string& name = e_.robot.tree.joint(static_cast<int>(j)).name;
      run->leave[j] = std::max(run->leave[j], std::abs(q - trial.command().q[trial.controlled().find_joint(name)]));
      if (!(q >= limits.hard_lower && q <= limits.hard_upper)) run->fault = name + " reaches " + number(q, 3);
      if (!(std::abs(qd) <= kSpeedMargin * limits.speed))
        run->fault = name + " gets as fast as " + number(std::abs(qd), 3);
      if (!(std::abs(effort) <= limits.effort))
        run->fault = name + " needs an effort of " + number(std::abs(effort), 3);
    }
  }

  // Adds readings and stores their mean at the end of a stretch.
  void read(const Trial& trial, StanceRun* run) {
    const SensorSample& sample = trial.engine().sensors();
    std::vector<double> now;
    for (int j : joints_) {
      now.push_back(sample.q[j]);
      now.push_back(sample.effort[j]);
    }
    for (const WrenchSample& wrench : sample.wrenches) {
      now.insert(now.end(), wrench.force.data(), wrench.force.data() + 3);
      now.insert(now.end(), wrench.torque.data(), wrench.torque.data() + 3);
    }
    sums_.resize(now.size(), 0.0);
    for (size_t c = 0; c < now.size(); ++c) sums_[c] += now[c];
    if (++summed_ < stretch_) return;
    for (double& sum : sums_) run->readings.push_back(sum / stretch_);
    sums_.clear();
    summed_ = 0;
  }

 private:
  bool carries(size_t foot) const { return loads_[foot] > kDetail * weight_ * static_cast<double>(steps_); }

  std::vector<int> list_carrying() const {
    std::vector<int> links;
    for (size_t f = 0; f < loads_.size(); ++f) {
      if (carries(f)) links.push_back(feet_[f]);
    }
    return links;
  }

  void look_at_balance(const State& state, bool rests, StanceRun* run) {
    const double lean = std::acos(std::clamp((state.R_WB * Vector3d::UnitZ()).z(), -1.0, 1.0));
    if (!(lean < kLean)) run->fault = "the robot falls";
    for (size_t f = 0; f < loads_.size() && !walks_; ++f) {
      if (run->fault.empty() && !carries(f)) run->fault = "a foot comes off the ground";
    }
    if (!run->fault.empty()) return;
    const std::optional<Vector3d> zmp = calc_ground_zmp(forces_, ground_);
    const double distance = zmp ? calc_distance(hull_, *zmp) : -1.0;
    run->margin = std::min(run->margin, distance);
    if (rests) least_ = std::min(least_, kRestShare * distance);
    if (distance < std::max(kLeastMargin, least_))
      run->fault = "the zero-moment point comes within " + number(distance, 2) + " m of the soles' edge";
  }

  static void look_at_contacts(Trial& trial, StanceRun* run) {
    for (const ContactPair& pair : trial.calc_contacts()) {
      if (pair.body_b == kGround) continue;
      run->fault = trial.robot().tree.links[static_cast<size_t>(pair.body_a)].name + " touches something";
    }
  }

  const Experiment& e_;
  const Limits& limits_;
  bool walks_;
  GroundPlane ground_;
  double gravity_, weight_ = 0.0;
  std::vector<int> joints_, feet_;  // links of the feet
  std::vector<Vector3d> hull_;
  ContactForces forces_;       // of all steps of the window
  std::vector<double> loads_;  // [N] by foot, summed over the window
  int steps_ = 0;
  std::vector<double> sums_;   // of readings
  int summed_ = 0, stretch_;   // [steps]
  double least_ = kZmpMargin;  // [m] that the zero-moment point has to keep
};

Scenario make_stance_scenario(const Experiment& e, Scenario scenario, double end, const Limits& limits) {
  scenario.self_collision = true;
  scenario.duration = kRest + end;
  scenario.controller = {};
  for (int j = 0; j < e.num_joints(); ++j)
    scenario.initial_joints[e.robot.tree.joint(j).name] = limits.joints[static_cast<size_t>(j)].start;
  return scenario;
}

}  // namespace

StanceRun run_stance(const Experiment& experiment, const Scenario& given, const Commands& commands,
                     const Limits& limits, bool walks) {
  const Scenario scenario = make_stance_scenario(experiment, given, commands.time.back(), limits);
  Trial trial(scenario,
              [&](const Robot& robot) { return std::make_unique<StanceController>(experiment, commands, robot); });
  StanceRun run;
  run.leave.assign(limits.joints.size(), 0.0);
  Watch watch(experiment, limits, scenario, trial, walks);
  const long steps = std::lround(scenario.duration / scenario.time_step);
  const long window = std::max<long>(1, std::lround(kWindow / scenario.time_step));
  for (long k = 0; k < steps && run.fault.empty(); ++k) {
    if (!trial.step()) run.fault = "the simulated robot leaves all bounds";
    if (!run.fault.empty()) break;
    watch.add_forces(trial);
    if ((k + 1) % window == 0) watch.look(trial, &run);
    if (trial.time() >= kRest) watch.read(trial, &run);
    if ((k + 1) % scenario.control_period == 0 && trial.time() >= kSettled) watch.look_at_joints(trial, &run);
  }
  return run;
}

}  // namespace hrp::diagnosis
