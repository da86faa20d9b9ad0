// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/findings.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace hrp::diagnosis::standing {

namespace {

constexpr double kLaws = 1e-3;  // share to which one's laws and integrator agree with another's

// A value with a deviation of chance, and an unknown that is not chance but anywhere between two ends, the same every
// time: the interval holds what chance says about each end. So ranges add, not squares.
Json make_bounded(double value, double chance, double one_end, double other_end, const char* unit) {
  const double reach = std::max(std::abs(one_end - value), std::abs(other_end - value));
  return make_value(value, chance + reach / kNinetyFive, unit);
}

// Values a bush's coefficients stand for: k = 1 / a, c = b / a, by first-order propagation of chance. Ground and sole
// give in series with the bush, by anything up to `contact`, so that a is what was seen less that.
void add_bush_axis(const Effect& e, const Eigen::VectorXd& std, size_t at, const char* axis, double contact,
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

Json make_bush(const StandProblem& p, const Effect& e, const Eigen::VectorXd& std, size_t foot) {
  const size_t size = get_row(e).step.size(), at = foot * size;
  const bool hard = size > kFootParameters;
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

Json make_payload(const Effect& e, const Eigen::VectorXd& std) {
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

Json make_spring(const Effect& e, const Eigen::VectorXd& std) {
  Json out;
  out["stiffness"] = make_value(e.p[0], std(0), "N m/rad");
  const double rest = -e.p[1] / e.p[0];
  out["rest"] = make_value(rest, std::hypot(std(1), rest * std(0)) / e.p[0], "rad");
  return out;
}

Json make_stribeck(const Effect& e, const Eigen::VectorXd& std) {
  Json out;
  out["coulomb"] = make_value(e.p[0], std(0), "N m");
  out["static"] = make_value(e.p[0] + e.p[1], std::hypot(std(0), std(1)), "N m");
  out["stribeck_velocity"] = make_value(e.p[2], std(2), "rad/s");
  out["viscous"] = make_value(e.p[3], std(3), "N m s/rad");
  return out;
}

Json make_cogging(const Effect& e, const Eigen::VectorXd& std) {
  const double phase = std::atan2(e.p[1], e.p[0]);
  const double amplitude = std::hypot(e.p[0], e.p[1]), s = std::max(std(0), std(1));
  Json out;
  out["amplitude"] = make_value(amplitude, s, "N m");
  out["periods"] = make_value(e.p[2], std(2), "1/rad");
  out["phase"] = make_value(phase < 0 ? phase + 2 * M_PI : phase, s / std::max(1e-9, amplitude), "rad");
  return out;
}

// Where no torque held the link at both ends the gap may be any that lets it go where it was seen.
Json make_backlash(const Effect& e, const Eigen::VectorXd& std) {
  Json out;
  out["gap"] = make_value(e.p[3] > 0 ? e.p[3] : e.p[0], std(0), "rad");
  if (e.p[3] > 0) {
    const double rest = std::max(0.0, kMostPlay - e.p[3]);
    out["gap"]["std"] = rest / std::sqrt(12), out["gap"]["ci95"] = {0.95 * e.p[3], e.p[3] + rest};
  }
  return out;
}

Json make_elasticity(const Effect& e, const Eigen::VectorXd& std) {
  Json out;
  out["stiffness"] = make_value(1 / e.p[0], std(0) / (e.p[0] * e.p[0]), "N m/rad");
  out["rotor_inertia"] = make_value(e.p[1], std(1), "kg m^2");
  return out;
}

// Effects whose coefficients are not their parameters.
using Make = Json (*)(const Effect&, const Eigen::VectorXd&);
const std::map<EffectId, Make> kOwn{{EffectId::kPayload, &make_payload},     {EffectId::kSpring, &make_spring},
                                    {EffectId::kStribeck, &make_stribeck},   {EffectId::kCogging, &make_cogging},
                                    {EffectId::kBacklash, &make_backlash},   {EffectId::kElasticity, &make_elasticity}};

const char* find_suffix(Reading reading) {
  switch (reading) {
    case Reading::kPosition: return "/position";
    case Reading::kVelocity: return "/velocity";
    case Reading::kEffort: return "/effort";
    case Reading::kForce: return "/force";
    case Reading::kTorque: return "/torque";
    case Reading::kOrientation: return "/orientation";
    case Reading::kAngularVelocity: return "/angular_velocity";
    case Reading::kAcceleration: return "/linear_acceleration";
    default: return "";
  }
}

}  // namespace

std::pair<std::string, std::string> find_place(const StandProblem& p, const Effect& e) {
  const auto i = static_cast<size_t>(e.place.index);
  if (is_joint(e)) return {"joint", p.tree.joint(e.place.index).name};
  if (is_joint_sensor(e)) {
    return {"sensor", "/joint_states/" + p.tree.joint(e.place.index).name + find_suffix(e.place.reading)};
  }
  if (is_link(e)) return {"link", p.tree.links[i].name};
  if (is_foot(e)) return {"foot", "all"};
  if (is_wrench(e)) return {"sensor", "/wrench/" + p.feet[i].sensor + find_suffix(e.place.reading)};
  if (is_imu(e)) return {"sensor", "/imu/" + p.imu + find_suffix(e.place.reading)};
  return {"ground", "ground"};
}

Json make_parameters(const StandProblem& p, const Effect& e, const Eigen::VectorXd& fitted, size_t foot) {
  Eigen::VectorXd std = fitted;
  for (long i = 0; i < std.size(); ++i) std(i) = std::hypot(std(i), kLaws * e.p[static_cast<size_t>(i)]);
  if (is_foot(e)) return make_bush(p, e, std, foot);
  const auto own = kOwn.find(e.id);
  if (own != kOwn.end()) return own->second(e, std);
  Json out;
  const std::vector<EffectParameter>& all = get_effect(e.id).parameters;
  const auto unit = [&](size_t i) { return all[i].unit.empty() ? get_unit(e.place.reading) : all[i].unit.c_str(); };
  if (all[0].axis >= 0 && e.p.size() == 3) {
    out[all[0].name] = make_vector(e.p, std::vector<double>(std.data(), std.data() + std.size()), unit(0));
    return out;
  }
  for (size_t i = 0; i < e.p.size(); ++i) out[all[i].name] = make_value(e.p[i], std(static_cast<long>(i)), unit(i));
  return out;
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
