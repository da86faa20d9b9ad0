// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/findings.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis::standing {

namespace {

// An estimate with a statistical standard deviation `chance` and a systematic error. The true value is anywhere between
// two ends, the same in every recording. Therefore the interval adds the range and the deviation linearly, not in
// quadrature.
Estimate make_bounded(const std::string& name, double value, double chance, double one_end, double other_end,
                      const char* unit) {
  const double reach = std::max(std::abs(one_end - value), std::abs(other_end - value));
  return make_one(name, unit, value, chance + reach / kNinetyFive);
}

// Stiffness k = 1 / a and damping c = b / a of one axis of a bush, with first-order error propagation. Ground and sole
// are in series with the bush and have a compliance of up to `contact`. So the bush's own a is the observed one minus 0
// to `contact`.
void add_bush_axis(const Effect& e, const Eigen::VectorXd& std, size_t at, const char* axis, double contact,
                   std::vector<Estimate>* out) {
  const double seen = e.p[at], series = std::min(contact, 0.5 * seen), a = seen - 0.5 * series;
  const double sa = std(static_cast<long>(at)), b = e.p[at + 1], sb = std(static_cast<long>(at) + 1);
  // The bush rotates only by the rest of the tilt. Its damping then seems too small by the same ratio.
  const auto damping = [&](double own) { return b * seen / (own * own); };
  const double chance = std::hypot(sb * seen / (a * a), 2 * damping(a) * sa / a);
  const double stiff = seen - series;
  out->push_back(make_bounded(std::string("k_") + axis, 1 / a, sa / (a * a), 1 / seen, 1 / stiff, "N m/rad"));
  out->push_back(
      make_bounded(std::string("c_") + axis, damping(a), chance, damping(seen), damping(stiff), "N m s/rad"));
}

std::vector<Estimate> make_bush(const StandProblem& p, const Effect& e, const Eigen::VectorXd& std, size_t foot) {
  const size_t size = get_row(e).step.size(), at = foot * size;
  const bool hard = size > kFootParameters;
  std::vector<Estimate> out;
  const double seen = e.p[at + 4], sink = std::min(find_sinking(p.feet[foot]), 0.5 * seen), a = seen - 0.5 * sink;
  const double s = std(static_cast<long>(at) + 4);
  const bool told = a > 3 * (s + 0.5 * sink / kNinetyFive);  // if false, the compression of the foot is not determined
  if (told) out.push_back(make_bounded("kz", 1 / a, s / (a * a), 1 / seen, 1 / (seen - sink), "N/m"));
  add_bush_axis(e, std, at, "roll", find_give(p.feet[foot], 0), &out);
  add_bush_axis(e, std, at + 2, "pitch", find_give(p.feet[foot], 1), &out);
  if (hard) {
    // tilt = -M/k - h tilt^3: stiffness k (1 + (tilt / angle)^2) with angle = 1 / sqrt(h).
    const double h = e.p[at + kFootParameters], sh = std(static_cast<long>(at + kFootParameters));
    out.push_back(make_one("hardening_angle", "rad", 1 / std::sqrt(h), 0.5 * sh / (h * std::sqrt(h))));
  }
  return out;
}

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

std::vector<Estimate> make_parameters(const StandProblem& p, const Effect& e, const Eigen::VectorXd& fitted,
                                      size_t foot) {
  Eigen::VectorXd std = fitted;
  for (long i = 0; i < std.size(); ++i) std(i) = std::hypot(std(i), kAgreement * e.p[static_cast<size_t>(i)]);
  if (is_foot(e)) return make_bush(p, e, std, foot);
  const StandRow& row = get_row(e);
  std::vector<double> values = e.p;
  if (row.to_table) row.to_table(&values, &std);
  std::vector<Estimate> out;
  const std::vector<EffectParameter>& all = get_effect(e.id).parameters;
  for (size_t i = 0; i < values.size(); ++i) {
    const std::string unit = all[i].unit.empty() ? get_unit(e.place.reading) : all[i].unit;
    const bool vector = all[i].axis >= 0 && values.size() > 2;
    if (std::isnan(values[i]) || (vector && all[i].axis > 0)) continue;
    if (vector)
      out.push_back({all[i].name, unit, {&values[i], &values[i] + 3}, {std.data() + i, std.data() + i + 3}, true});
    else
      out.push_back(make_one(all[i].name, unit, values[i], std(static_cast<long>(i))));
  }
  if (row.loose && e.p[3] > 0) {  // bounds for any gap in which the link can move as observed
    const double rest = std::max(0.0, kMostPlay - e.p[3]);
    out[0].std = {rest / std::sqrt(12)};
    out[0].ends = {{0.95 * e.p[3], e.p[3] + rest}};
  }
  return out;
}

std::string describe_values(const std::vector<Estimate>& parameters) {
  std::string out;
  for (const Estimate& p : parameters) {
    out += (out.empty() ? "" : ", ") + p.name + " ";
    if (p.vector) {
      out += "(";
      for (size_t i = 0; i < p.value.size(); ++i) out += (i ? ", " : "") + number(p.value[i], 3);
      out += ")";
    } else if (!p.ends.empty() && p.ends[0].second - p.value[0] > 3 * p.std[0]) {
      out += "at least " + number(p.value[0], 3);  // a one-sided interval
    } else {
      out += number(p.value[0], 3) + " +- " + number(kNinetyFive * p.std[0], 2);
    }
    if (p.unit != "1") out += " " + p.unit;
  }
  return out;
}

}  // namespace hrp::diagnosis::standing
