// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/findings.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace hrp::diagnosis::standing {

namespace {

std::string find_wrench_part(const StandProblem& p, const StandEffect& e) {
  const std::string wrench = "/wrench/" + p.feet[static_cast<size_t>(e.place) % p.feet.size()].sensor;
  const size_t part = static_cast<size_t>(e.place) / p.feet.size();
  if (part == 1 || e.id == StandId::kForceBias || e.id == StandId::kForceScale) return wrench + "/force";
  if (part == 2 || e.id == StandId::kTorqueBias || e.id == StandId::kTorqueScale) return wrench + "/torque";
  return wrench;
}

std::string find_imu_part(const StandProblem& p, const StandEffect& e) {
  const std::string imu = "/imu/" + p.imu;
  if (e.place == 1) return imu + "/orientation";
  if (e.place == 2 || e.id == StandId::kGyroBias || e.id == StandId::kGyroScale) return imu + "/angular_velocity";
  const bool accelerometer = e.id == StandId::kAccelerometerBias || e.id == StandId::kAccelerometerScale;
  return imu + (e.place == 3 || accelerometer ? "/linear_acceleration" : "");
}

constexpr double kLaws = 1e-3;  // share to which one's laws and integrator agree with another's

// A value with a deviation of chance, and an unknown that is not chance but anywhere between two ends, the same every
// time: the interval holds what chance says about each end. So ranges add, not squares.
Json make_bounded(double value, double chance, double one_end, double other_end, const char* unit) {
  const double reach = std::max(std::abs(one_end - value), std::abs(other_end - value));
  return make_value(value, chance + reach / kNinetyFive, unit);
}

// Values a bush's coefficients stand for: k = 1 / a, c = b / a, by first-order propagation of chance. Ground and sole
// give in series with the bush, by anything up to `contact`, so that a is what was seen less that.
void add_bush_axis(const StandEffect& e, const Eigen::VectorXd& std, size_t at, const char* axis, double contact,
                   Json* out) {
  const double seen = e.p[at], series = std::min(contact, 0.5 * seen), a = seen - 0.5 * series;
  const double sa = std(static_cast<long>(at)), b = e.p[at + 1], sb = std(static_cast<long>(at) + 1);
  // The bush turns by the rest of the tilt only, so its damping seems smaller than it is by the same share.
  const auto damping = [&](double own) { return b * seen / (own * own); };
  const double chance = std::hypot(sb * seen / (a * a), 2 * damping(a) * sa / a);
  const double stiff = seen - series;
  (*out)[std::string("k_") + axis] = make_bounded(1 / a, sa / (a * a), 1 / seen, 1 / stiff, "N m/rad");
  (*out)[std::string("c_") + axis] = make_bounded(damping(a), chance, damping(seen), damping(stiff), "N m s/rad");
}

Json make_bush(const StandProblem& p, const StandEffect& e, const Eigen::VectorXd& std, size_t foot) {
  const bool hard = e.id == StandId::kFootHardening;
  const size_t at = foot * (kFootParameters + (hard ? 1 : 0));
  Json out;
  const double seen = e.p[at + 4], sink = std::min(find_sinking(p.feet[foot]), 0.5 * seen), a = seen - 0.5 * sink;
  const double s = std(static_cast<long>(at) + 4);
  const bool told = a > 3 * (s + 0.5 * sink / kNinetyFive);  // else the data do not say how far the foot sinks
  if (told) out["kz"] = make_bounded(1 / a, s / (a * a), 1 / seen, 1 / (seen - sink), "N/m");
  add_bush_axis(e, std, at, "roll", find_give(p.feet[foot], 0), &out);
  add_bush_axis(e, std, at + 2, "pitch", find_give(p.feet[foot], 1), &out);
  if (hard) {
    // tilt = -M/k - h tilt^3: stiffness k (1 + (tilt / angle)^2) with angle = 1 / sqrt(h).
    const double h = e.p[at + kFootParameters], sh = std(static_cast<long>(at + kFootParameters));
    out["hardening_angle"] = make_value(1 / std::sqrt(h), 0.5 * sh / (h * std::sqrt(h)), "rad");
  }
  return out;
}

Json make_payload(const StandEffect& e, const Eigen::VectorXd& std) {
  std::vector<double> value, deviation;
  for (long i = 1; i < 4; ++i) {  // written as mass x com
    const double c = e.p[static_cast<size_t>(i)] / e.p[0];
    value.push_back(c), deviation.push_back(std::hypot(std(i), c * std(0)) / e.p[0]);
  }
  Json out;
  out["mass"] = make_value(e.p[0], std(0), "kg");
  out["com"] = make_vector(value, deviation, "m");
  return out;
}

Json make_spring(const StandEffect& e, const Eigen::VectorXd& std) {
  Json out;
  out["stiffness"] = make_value(e.p[0], std(0), "N m/rad");
  const double rest = -e.p[1] / e.p[0];
  out["rest"] = make_value(rest, std::hypot(std(1), rest * std(0)) / e.p[0], "rad");
  return out;
}

Json make_stribeck(const StandEffect& e, const Eigen::VectorXd& std) {
  Json out;
  out["coulomb"] = make_value(e.p[0], std(0), "N m");
  out["static"] = make_value(e.p[0] + e.p[1], std::hypot(std(0), std(1)), "N m");
  out["stribeck_velocity"] = make_value(e.p[2], std(2), "rad/s");
  out["viscous"] = make_value(e.p[3], std(3), "N m s/rad");
  return out;
}

Json make_cogging(const StandEffect& e, const Eigen::VectorXd& std) {
  const double phase = std::atan2(e.p[1], e.p[0]);
  const double amplitude = std::hypot(e.p[0], e.p[1]), s = std::max(std(0), std(1));
  Json out;
  out["amplitude"] = make_value(amplitude, s, "N m");
  out["periods"] = make_value(e.p[2], std(2), "1/rad");
  out["phase"] = make_value(phase < 0 ? phase + 2 * M_PI : phase, s / std::max(1e-9, amplitude), "rad");
  return out;
}

// Where no torque held the link at both ends the gap may be any that lets it go where it was seen.
Json make_backlash(const StandEffect& e, const Eigen::VectorXd& std) {
  Json out;
  out["gap"] = make_value(e.p[3] > 0 ? e.p[3] : e.p[0], std(0), "rad");
  if (e.p[3] > 0) {
    const double rest = std::max(0.0, kMostPlay - e.p[3]);
    out["gap"]["std"] = rest / std::sqrt(12), out["gap"]["ci95"] = {0.95 * e.p[3], e.p[3] + rest};
  }
  return out;
}

Json make_elasticity(const StandEffect& e, const Eigen::VectorXd& std) {
  Json out;
  out["stiffness"] = make_value(1 / e.p[0], std(0) / (e.p[0] * e.p[0]), "N m/rad");
  out["rotor_inertia"] = make_value(e.p[1], std(1), "kg m^2");
  return out;
}

}  // namespace

std::pair<std::string, std::string> find_place(const StandProblem& p, const StandEffect& e) {
  if (is_joint(e.id)) return {"joint", p.tree.joint(e.place).name};
  if (is_joint_sensor(e.id)) {
    const bool effort = e.id <= StandId::kEffortDelay, velocity = !effort && e.id <= StandId::kVelocityDelay;
    const std::string part = effort ? "/effort" : velocity ? "/velocity" : "/position";
    return {"sensor", "/joint_states/" + p.tree.joint(e.place).name + part};
  }
  if (is_link(e.id)) return {"link", p.tree.links[static_cast<size_t>(e.place)].name};
  if (is_wrench(e.id)) return {"sensor", find_wrench_part(p, e)};
  if (is_imu(e.id)) return {"sensor", find_imu_part(p, e)};
  return {is_foot(e.id) ? "foot" : "ground", is_foot(e.id) ? "all" : "ground"};
}

Json make_parameters(const StandProblem& p, const StandEffect& e, const Eigen::VectorXd& fitted, size_t foot) {
  const StandInfo& info = get_stand_info(e.id);
  Eigen::VectorXd std = fitted;
  for (long i = 0; i < std.size(); ++i) std(i) = std::hypot(std(i), kLaws * e.p[static_cast<size_t>(i)]);
  switch (e.id) {
    case StandId::kFootCompliance:
    case StandId::kFootHardening:
      return make_bush(p, e, std, foot);
    case StandId::kPayload:
      return make_payload(e, std);
    case StandId::kSpring:
      return make_spring(e, std);
    case StandId::kStribeck:
      return make_stribeck(e, std);
    case StandId::kCogging:
      return make_cogging(e, std);
    case StandId::kBacklash:
      return make_backlash(e, std);
    case StandId::kElasticity:
      return make_elasticity(e, std);
    default:
      break;
  }
  Json out;
  if (info.parameters.size() == e.p.size()) {
    for (size_t i = 0; i < e.p.size(); ++i) {
      if (*info.parameters[i]) out[info.parameters[i]] = make_value(e.p[i], std(static_cast<long>(i)), info.units[i]);
    }
    return out;
  }
  out[info.parameters[0]] = make_vector(e.p, std::vector<double>(std.data(), std.data() + std.size()), info.units[0]);
  return out;
}

const char* find_phrase(StandId id) {
  static const std::map<StandId, const char*> phrases{
      {StandId::kViscous, "friction in proportion to speed is missing"},
      {StandId::kCoulomb, "dry friction is missing: the drive's effort jumps with the direction of motion"},
      {StandId::kRotorInertia,
       "the rotor's reflected inertia is missing: the effort left over follows the acceleration"},
      {StandId::kStribeck, "friction that falls with speed is missing: it sticks before it slides"},
      {StandId::kLoadFriction, "friction that grows with the load is missing"},
      {StandId::kSaturation, "the drive gives no more than a limit below the one that is stated"},
      {StandId::kCogging, "the torque ripples with the joint's position"},
      {StandId::kHysteresis, "the effort lags behind the motion by a yield angle, whatever the speed"},
      {StandId::kElasticity, "the transmission gives: the link lags behind the encoder in proportion to the torque"},
      {StandId::kBacklash, "the transmission is loose: the link changes sides when the torque changes sign"},
      {StandId::kSpring, "a spring acts across the joint"},
      {StandId::kTorqueConstant, "the true torque is a fixed multiple of the logged effort"},
      {StandId::kJointOffset, "the encoder's zero is off: feet that stand flat seem tilted, whatever the robot does"},
      {StandId::kCommandDelay, "commands reach the servo late"},
      {StandId::kActuatorLag, "the drive's torque lags behind what is logged"},
      {StandId::kPayload, "an unmodelled mass is carried"},
      {StandId::kMassError, "the link's mass is wrong by a factor"},
      {StandId::kComError, "the link's centre of mass is elsewhere"},
      {StandId::kExternalForce, "a constant force from outside pulls at it"},
      {StandId::kFootCompliance, "the sole gives: the foot tilts in proportion to the moment on it"},
      {StandId::kFootHardening, "the sole gives, and stiffens as it is bent"},
      {StandId::kGroundSlope, "the ground is not level"},
      {StandId::kGroundFriction, "the feet slip: the ground is more slippery than the model's"},
      {StandId::kForceBias, "the force reading is shifted by a constant"},
      {StandId::kTorqueBias, "the torque reading is shifted by a constant"},
      {StandId::kForceScale, "the force reading is scaled"},
      {StandId::kTorqueScale, "the torque reading is scaled"},
      {StandId::kWrenchDelay, "its readings come late"},
      {StandId::kWrenchMisalignment, "it is turned against its link"},
      {StandId::kWrenchSkew, "the force sensor's clock runs at another rate"},
      {StandId::kGyroBias, "the gyroscope is shifted by a constant"},
      {StandId::kAccelerometerBias, "the accelerometer is shifted by a constant"},
      {StandId::kGyroScale, "the gyroscope is scaled"},
      {StandId::kAccelerometerScale, "the accelerometer is scaled"},
      {StandId::kImuDelay, "its readings come late"},
      {StandId::kImuMisalignment, "it is turned against its link"},
      {StandId::kImuSkew, "the IMU's clock runs at another rate"},
      {StandId::kEffortBias, "the logged effort is shifted by a constant"},
      {StandId::kEffortScale, "the logged effort is scaled"},
      {StandId::kEffortDelay, "the logged effort comes late"},
      {StandId::kVelocityBias, "the logged velocity is shifted by a constant"},
      {StandId::kVelocityScale, "the logged velocity is scaled"},
      {StandId::kVelocityDelay, "the logged velocity comes late"},
      {StandId::kPositionBias, "the logged position is shifted by a constant that the servo does not see"},
      {StandId::kPositionScale, "the logged position is scaled"},
      {StandId::kPositionDelay, "the logged position comes late"}};
  return phrases.at(id);
}

std::string describe_values(const Json& parameters) {
  std::string out;
  for (const auto& [name, p] : parameters.items()) {
    out += (out.empty() ? "" : ", ") + name + " ";
    if (p["value"].is_array()) {
      out += "(";
      for (size_t i = 0; i < p["value"].size(); ++i) out += (i ? ", " : "") + number(p["value"][i].get<double>(), 3);
      out += ")";
    } else if (p["ci95"][1].get<double>() - p["value"].get<double>() > 3 * p["std"].get<double>()) {
      out += "at least " + number(p["value"].get<double>(), 3);  // an interval to one side
    } else {
      out += number(p["value"].get<double>(), 3) + " +- " + number(1.96 * p["std"].get<double>(), 2);
    }
    const std::string unit = p["unit"].get<std::string>();
    if (unit != "1") out += " " + unit;
  }
  return out;
}

}  // namespace hrp::diagnosis::standing
