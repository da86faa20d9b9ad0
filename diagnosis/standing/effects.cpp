// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/effects.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/standing/layout.h"

namespace hrp::diagnosis::standing {
namespace {

using I = StandId;

constexpr double kWider = 3;        // a gap is tried from there on: what nothing stops may go further than it was seen
constexpr double kSeen = 2;         // noise deviations from which on a sample shows something
constexpr double kPlumb = 0.02;     // [rad] as well as a robot's base knows where down is
constexpr double kLoopStep = 2e-4;  // [s] of a drive; as large as the timing that fixed bases are granted
constexpr double kMostStamping = 2e-3;  // [s] slower logs are stamped well within their step

const std::vector<StandInfo>& list_infos() {
  static const std::vector<double> foot_step{1e-5, 1e-5, 1e-5, 1e-5, 1e-8, 1e-3, 1e-3, 1e-3, 0.01, 0.01};
  static const std::vector<double> hard_step{1e-5, 1e-5, 1e-5, 1e-5, 1e-8, 1e-3, 1e-3, 1e-3, 0.01, 0.01, 10};
  static const std::vector<StandInfo> infos{
      {I::kViscous, "viscous_friction", {"coefficient"}, {"N m s/rad"}, {0}, {0.1}, true},
      {I::kCoulomb, "coulomb_friction", {"level", "asymmetry"}, {"N m", "1"}, {0, 0}, {0.1, 0.02}, true},
      {I::kStribeck, "stribeck_friction", {}, {}, {0, 0, 0.1, 0}, {0.1, 0.1, 1e-3, 0.1}, true},
      {I::kLoadFriction, "load_dependent_friction", {"ratio"}, {"1"}, {0}, {0.01}, true},
      {I::kRotorInertia, "rotor_inertia", {"inertia"}, {"kg m^2"}, {0}, {0.01}, true},
      {I::kSpring, "parallel_spring", {"stiffness", ""}, {"N m/rad", "N m"}, {0, 0}, {1, 0.1}, true},
      {I::kTorqueConstant, "torque_constant_error", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kSaturation, "torque_saturation", {"limit"}, {"N m"}, {1e300}, {0.01}, false},
      {I::kCogging, "cogging", {}, {}, {0, 0, 1}, {0.1, 0.1, 0.01}, false},
      {I::kHysteresis, "hysteresis", {"stiffness", "yield_angle"}, {"N m/rad", "rad"}, {0, 0.02}, {1, 1e-4}, true},
      {I::kCommandDelay, "command_delay", {"delay"}, {"s"}, {0}, {1e-3}, true},
      {I::kActuatorLag, "actuator_lag", {"time_constant"}, {"s"}, {0}, {1e-3}, true},
      {I::kElasticity, "joint_elasticity", {}, {}, {0, 0}, {1e-6, 0.01}, true},
      {I::kBacklash, "backlash", {}, {}, {0, 0, 0, 0}, {1e-3, 0.01, 1e-6, 0}, true},
      {I::kJointOffset, "joint_offset", {"offset"}, {"rad"}, {0}, {1e-3}, false},
      {I::kPayload, "payload", {"mass", "", "", ""}, {"kg", "", "", ""}, {0, 0, 0, 0}, {0.1, 0.01, 0.01, 0.01}, true},
      {I::kMassError, "mass_error", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kComError, "com_error", {"offset"}, {"m"}, {0, 0, 0}, {1e-3, 1e-3, 1e-3}, false},
      {I::kExternalForce, "external_force", {"force"}, {"N"}, {0, 0, 0}, {1, 1, 1}, false},
      {I::kFootCompliance, "foot_compliance", {}, {}, std::vector<double>(kFootParameters, 0), foot_step, false},
      {I::kFootHardening, "foot_hardening", {}, {}, std::vector<double>(kFootParameters + 1, 0), hard_step, false},
      {I::kGroundSlope, "ground_slope", {"roll", "pitch"}, {"rad", "rad"}, {0, 0}, {1e-3, 1e-3}, false},
      {I::kGroundFriction, "ground_friction", {"coefficient"}, {"1"}, {0}, {0}, false},
      {I::kForceBias, "sensor_bias", {"value"}, {"N"}, {0, 0, 0}, {0.1, 0.1, 0.1}, false},
      {I::kTorqueBias, "sensor_bias", {"value"}, {"N m"}, {0, 0, 0}, {0.01, 0.01, 0.01}, false},
      {I::kForceScale, "sensor_scale", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kTorqueScale, "sensor_scale", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kWrenchDelay, "sensor_delay", {"delay"}, {"s"}, {0}, {1e-2}, true},
      {I::kWrenchMisalignment, "sensor_misalignment", {"rpy"}, {"rad"}, {0, 0, 0}, {1e-3, 1e-3, 1e-3}, false},
      {I::kWrenchSkew, "clock_skew", {"skew"}, {"1"}, {0}, {3e-3}, false},
      {I::kGyroBias, "sensor_bias", {"value"}, {"rad/s"}, {0, 0, 0}, {1e-3, 1e-3, 1e-3}, false},
      {I::kAccelerometerBias, "sensor_bias", {"value"}, {"m/s^2"}, {0, 0, 0}, {1e-2, 1e-2, 1e-2}, false},
      {I::kGyroScale, "sensor_scale", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kAccelerometerScale, "sensor_scale", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kImuDelay, "sensor_delay", {"delay"}, {"s"}, {0}, {1e-2}, true},
      {I::kImuMisalignment, "sensor_misalignment", {"rpy"}, {"rad"}, {0, 0, 0}, {1e-3, 1e-3, 1e-3}, false},
      {I::kImuSkew, "clock_skew", {"skew"}, {"1"}, {0}, {3e-3}, false},
      {I::kEffortBias, "sensor_bias", {"value"}, {"N m"}, {0}, {0.1}, false},
      {I::kEffortScale, "sensor_scale", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kEffortDelay, "sensor_delay", {"delay"}, {"s"}, {0}, {1e-2}, true},
      {I::kVelocityBias, "sensor_bias", {"value"}, {"rad/s"}, {0}, {1e-3}, false},
      {I::kVelocityScale, "sensor_scale", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kVelocityDelay, "sensor_delay", {"delay"}, {"s"}, {0}, {1e-2}, true},
      {I::kPositionBias, "sensor_bias", {"value"}, {"rad"}, {0}, {1e-3}, false},
      {I::kPositionScale, "sensor_scale", {"scale"}, {"1"}, {1}, {1e-3}, false},
      {I::kPositionDelay, "sensor_delay", {"delay"}, {"s"}, {0}, {1e-2}, true}};
  return infos;
}

class Lister {
 public:
  Lister(const StandProblem& problem, const StandHypothesis& base, const StandHints& hints)
      : p_(problem), base_(base), hints_(hints) {}

  void add(StandId id, int place, const std::vector<std::pair<size_t, double>>& starts = {}) {
    for (const StandEffect& e : base_) {
      if (e.id == id && e.place == place) return;
      if (is_foot(id) && is_foot(e.id)) return;
    }
    StandEffect effect{id, place, {}};
    const StandInfo& info = get_stand_info(id);
    for (size_t f = 0; f < (is_foot(id) ? p_.feet.size() : 1); ++f) {
      effect.p.insert(effect.p.end(), info.neutral.begin(), info.neutral.end());
    }
    for (const auto& [at, value] : starts) effect.p[at] = value;
    list.push_back(effect);
  }

  void add_joint(int j) {
    const auto i = static_cast<size_t>(j);
    for (StandId id : {I::kJointOffset, I::kPositionScale, I::kPositionDelay}) add(id, j);
    if (hints_.play[i] > 0) add(I::kBacklash, j, {{0, kWider * hints_.play[i]}});
    if (p_.velocity[i]) {
      for (StandId id : {I::kVelocityBias, I::kVelocityScale, I::kVelocityDelay}) add(id, j);
    }
    if (!p_.is_driven(i)) return;
    for (StandId id : {I::kViscous, I::kCoulomb, I::kLoadFriction, I::kRotorInertia, I::kSpring, I::kTorqueConstant,
                       I::kActuatorLag}) {
      add(id, j);
    }
    for (double yield : {0.01, 0.04}) add(I::kHysteresis, j, {{1, yield}});  // [rad]
    for (double periods : hints_.ripples[i]) add(I::kCogging, j, {{2, periods}});
    add(I::kElasticity, j);
    for (double v : {0.03, 0.08, 0.2}) add(I::kStribeck, j, {{2, v}});  // [rad/s]
    if (p_.command[i]) add(I::kCommandDelay, j);
    if (!p_.effort[i]) return;
    add_limits(j);
    for (StandId id : {I::kEffortBias, I::kEffortScale, I::kEffortDelay}) add(id, j);
    if (p_.command[i]) add(I::kPositionBias, j);  // else nothing tells it from an offset that the servo sees
  }

  std::vector<StandEffect> list;

 private:
  // Limits within what the drive was asked for.
  void add_limits(int j) {
    double most = 0;
    for (const StandRecording& r : p_.recordings) {
      for (double u : r.effort[static_cast<size_t>(j)].value) most = std::max(most, std::abs(u));
    }
    for (double share : {0.95, 0.8, 0.6, 0.4}) add(I::kSaturation, j, {{0, share * most}});
  }

  const StandProblem& p_;
  const StandHypothesis& base_;
  const StandHints& hints_;
};

}  // namespace

const StandInfo& get_stand_info(StandId id) {
  for (const StandInfo& info : list_infos()) {
    if (info.id == id) return info;
  }
  return list_infos()[0];
}

std::vector<StandEffect> list_candidates(const StandProblem& p, const StandHypothesis& base, const StandHints& hints) {
  Lister lister(p, base, hints);
  for (int j = 0; j < p.tree.num_joints(); ++j) lister.add_joint(j);
  for (int link = 0; link < static_cast<int>(p.tree.links.size()); ++link) {
    if (p.tree.links[static_cast<size_t>(link)].inertia.mass < 1e-6) continue;
    for (StandId id : {I::kMassError, I::kComError, I::kPayload, I::kExternalForce}) lister.add(id, link);
  }
  const bool flat = std::all_of(p.feet.begin(), p.feet.end(), [](const auto& f) { return f.kind == SoleKind::kFlat; });
  if (flat) {
    for (StandId id : {I::kFootCompliance, I::kFootHardening, I::kGroundSlope}) lister.add(id, 0);
  }
  if (hints.slip_ratio > 0) lister.add(I::kGroundFriction, 0, {{0, hints.slip_ratio}});
  const int feet = static_cast<int>(p.feet.size());
  for (int foot = 0; foot < feet; ++foot) {
    for (StandId id : {I::kForceBias, I::kTorqueBias, I::kForceScale, I::kTorqueScale, I::kWrenchSkew}) {
      lister.add(id, foot);
    }
    for (int part = 0; part < 3; ++part) {
      for (StandId id : {I::kWrenchDelay, I::kWrenchMisalignment}) lister.add(id, foot + part * feet);
    }
  }
  for (double skew : {-0.03, -0.01, 0.01, 0.03}) {  // over 10 s the clocks part too far for a slope at none
    lister.add(I::kImuSkew, 0, {{0, skew}});
    for (int foot = 0; foot < feet; ++foot) lister.add(I::kWrenchSkew, foot, {{0, skew}});
  }
  for (StandId id : {I::kGyroBias, I::kAccelerometerBias, I::kGyroScale, I::kAccelerometerScale, I::kImuSkew}) {
    lister.add(id, 0);
  }
  for (int part = 0; part < 4; ++part) {
    if (!p.attitude && part == 1) continue;  // there is no attitude that could be wrong
    for (StandId id : {I::kImuDelay, I::kImuMisalignment}) lister.add(id, part);
  }
  return lister.list;
}

namespace {

const ServoGains& find_servo(const StandProblem& problem, int joint) {
  const Scenario& scenario = problem.experiment->scenario;
  const auto at = scenario.servo_joints.find(problem.tree.joint(joint).name);
  return at == scenario.servo_joints.end() ? scenario.servo_default : at->second;
}

// [s] Where in its own step a log puts the stamps of velocities and efforts is no fault: a step, of fast logs.
double find_stamping(const StandProblem& problem) {
  double step = kLoopStep;
  for (const StandRecording& r : problem.recordings) {
    const double all = r.time.back() - r.time.front();
    step = std::max(step, std::min(kMostStamping, 1.2 * all / static_cast<double>(r.time.size() - 1)));
  }
  return step;
}

// [N m] Of the equation of a joint's effort; 0 where it is not known yet.
double find_noise(const StandProblem& problem, int joint) {
  return problem.noise.empty() ? 0 : problem.noise[find_drive(problem, static_cast<size_t>(joint))];
}

// [m] Twice the edge of a cube of the link's mass, half as dense as water: its centre of mass is not further off, and
// half of that is a deviation of how far off it is. Upright robots hardly tell how high it is: then this does.
double find_size(const StandProblem& problem, int link) {
  return 2 * std::cbrt(problem.tree.links[static_cast<size_t>(link)].inertia.mass / 500);
}

// Effects that multiply something: of one number, none when it is 1.
bool is_factor(StandId id) { return get_stand_info(id).neutral == std::vector<double>{1}; }

}  // namespace

bool is_sensible(const StandProblem& problem, const StandEffect& e) {
  const StandInfo& info = get_stand_info(e.id);
  for (double v : e.p) {
    if (!std::isfinite(v)) return false;
  }
  if (info.positive && e.p[0] <= info.neutral[0]) return false;
  if (is_foot(e.id)) {
    const size_t size = info.step.size();
    for (size_t at = 0; at < e.p.size(); at += size) {
      if (e.p[at] <= 0 || e.p[at + 2] <= 0) return false;
      if (size > kFootParameters && e.p[at + kFootParameters] <= 0) return false;
    }
    return true;
  }
  if (is_factor(e.id)) return e.p[0] > 0.1 && e.p[0] < 5;
  switch (e.id) {
    case I::kEffortDelay:
    case I::kVelocityDelay:
    case I::kPositionDelay:
      return e.p[0] > find_stamping(problem);
    case I::kCoulomb:
      return std::abs(e.p[1]) < 1;
    case I::kStribeck:
      return e.p[1] > 0 && e.p[2] > 0.005 && e.p[2] < 1;
    case I::kHysteresis:
      return e.p[1] > 1e-3 && e.p[1] < 0.5;
    case I::kSaturation:  // of a drive that gives less than can be seen nothing tells what takes the rest
      return e.p[0] > kSeen * find_noise(problem, e.place);
    case I::kBacklash:  // a gap below what encoders resolve is none
      return e.p[0] > 1e-4;
    case I::kComError:
      return Vector3d(e.p[0], e.p[1], e.p[2]).norm() < find_size(problem, e.place);
    case I::kLoadFriction:
      return e.p[0] < 1;
    default:
      break;
  }
  return true;
}

bool are_sensible(const StandProblem& problem, const StandHypothesis& hypothesis) {
  return std::all_of(hypothesis.begin(), hypothesis.end(),
                     [&](const StandEffect& e) { return is_sensible(problem, e); });
}

std::vector<StandEffect> list_richer(const StandProblem& p, const StandEffect& e) {
  std::vector<StandEffect> out;
  if (e.id == StandId::kCoulomb) {
    for (double v : {0.03, 0.1, 0.3}) out.push_back({StandId::kStribeck, e.place, {0.7 * e.p[0], 0.5 * e.p[0], v, 0}});
  }
  if (e.id == StandId::kFootCompliance) {
    StandEffect hard{StandId::kFootHardening, e.place, {}};
    for (size_t f = 0; f < p.feet.size(); ++f) {
      const auto begin = e.p.begin() + static_cast<long>(f * kFootParameters);
      hard.p.insert(hard.p.end(), begin, begin + kFootParameters);
      hard.p.push_back(0);
    }
    out.push_back(hard);
  }
  return out;
}

bool starts_away(const StandEffect& e) {
  const bool skew = e.id == StandId::kImuSkew || e.id == StandId::kWrenchSkew;
  return e.id == StandId::kGroundFriction || e.id == StandId::kSaturation || e.id == StandId::kBacklash ||
         (skew && e.p[0] != 0);
}

bool adds_noise(StandId id) {
  if (is_factor(id)) return id != I::kPositionScale;
  return id == I::kViscous || id == I::kRotorInertia || id == I::kActuatorLag || id == I::kElasticity ||
         id == I::kPayload || id == I::kComError || is_foot(id);
}

bool is_vector(StandId id) {
  return id == I::kGroundSlope || (get_stand_info(id).parameters.size() == 1 && get_stand_info(id).neutral.size() == 3);
}

StandEffect make_soft_soles(const StandProblem& problem) {
  return {I::kFootCompliance, 0, std::vector<double>(kFootParameters * problem.feet.size(), 0.0)};
}

bool is_main(StandId id, size_t parameter) {
  if (is_foot(id)) {
    const size_t at = parameter % get_stand_info(id).step.size();
    return at == 0 || at == 2;  // stiffness of roll and pitch
  }
  return parameter == 0 || id == StandId::kCogging || (!is_joint(id) && id != StandId::kPayload);
}

double find_give(const StandFoot& foot, int axis) {
  const Vector3d half = 0.5 * foot.size;
  if (half.head<2>().maxCoeff() > 100) return kContact;  // [m] no sole was described
  return kContact * std::pow(half.head<2>().maxCoeff() / (axis == 0 ? half.y() : half.x()), 2);
}

double find_sinking(const StandFoot& foot) {
  const double half = 0.5 * foot.size.head<2>().maxCoeff();
  return half > 100 ? 0 : kContact * half * half;
}

double find_bound(const StandProblem& problem, const StandEffect& e, size_t parameter) {
  if (is_foot(e.id)) {
    const size_t size = get_stand_info(e.id).step.size(), at = parameter % size;
    return at == 0 || at == 2 ? find_give(problem.feet[parameter / size], at == 0 ? 0 : 1) : 0;
  }
  if (e.id != StandId::kElasticity || parameter != 0) return 0;
  for (const StandFoot& foot : problem.feet) {
    Matrix3d R_LF = Matrix3d::Identity();  // foot in the link at hand, joints straight
    for (int link = foot.link; link > 0; link = problem.tree.links[static_cast<size_t>(link)].parent) {
      const JointSpec& joint = problem.tree.links[static_cast<size_t>(link)].joint;
      const Vector3d axis = (R_LF.transpose() * joint.axis_F).cwiseAbs();
      if (link == e.place + 1) return axis.x() * find_give(foot, 0) + axis.y() * find_give(foot, 1);
      R_LF = joint.X_PF.R * R_LF;
    }
  }
  return 0;
}

double find_doubt(const StandProblem& problem, const StandEffect& e) {
  if (!is_link(e.id)) return 0;
  double most = 0;
  for (const LinkSpec& link : problem.tree.links) most = std::max(most, link.inertia.mass);
  double doubt = std::log(most / std::max(1e-6, problem.tree.links[static_cast<size_t>(e.place)].inertia.mass));
  if (e.id == StandId::kExternalForce) {
    // Of pulls from anywhere the share that is plumb within an angle is half its square; weight is plumb by itself.
    const Vector3d force(e.p[0], e.p[1], e.p[2]);
    const double angle = std::max(kPlumb, force.head<2>().norm() / std::max(1e-9, force.norm()));
    doubt -= std::log(0.5 * angle * angle);
  }
  return doubt;
}

double find_prior(const StandProblem& problem, const StandEffect& e, size_t parameter) {
  if (e.id == StandId::kComError) return 0.5 * find_size(problem, e.place);
  // [rad/(N m)] Teeth bend less than the servo that drives them gives, or it would ring.
  if (e.id == StandId::kBacklash && parameter == 2) return 0.3 / std::max(1.0, find_servo(problem, e.place).kp);
  if (!is_foot(e.id)) return 0;
  const size_t size = get_stand_info(e.id).step.size(), at = parameter % size;
  const StandFoot& foot = problem.feet[parameter / size];
  if (at == 5 || at == 6) return 0.02;  // [m] "near the sole's centre"
  if (at == 7) return 0.01;             // [m] half the height of a sole or so
  // [N m] The foot's weight acts where the model has it; how much of it is above the bush is not known.
  if (at == 8 || at == 9) return foot.mass * 9.81 * (0.5 * (foot.com - foot.bush).head<2>().norm() + 0.005);
  return 0;
}

}  // namespace hrp::diagnosis::standing
