// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/effort_units.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/conventions/loaded_units.h"
#include "diagnosis/data/servo_gains.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/measurement/effort_limits.h"
#include "diagnosis/measurement/load_or_unit.h"
#include "diagnosis/model/nominal.h"

namespace hrp::diagnosis {
namespace {

// |ln| of a scale below one that joints do not share: a heavy load may explain less.
const double kLoad = std::log(kTenTimes);
constexpr long kFewest = kRowsPerColumn * (kNuisance + 1);  // samples: tau stands beside them

// [|ln|] Widest bracket that tells a scale. At kFactor, effort and tau have a correlation of 0.6 beside friction and
// rotor: along a few slow recordings, friction over position follows the small torque of a wrist by a third, with
// either sign and a factor of a thousand.
double find_widest(double scale) {
  return std::min(kBracket * std::max(kFactor, std::abs(std::log(std::abs(scale)))), kFactor);
}

double calc_variance(const Eigen::VectorXd& y) { return (y.array() - y.mean()).square().mean(); }

// True if the motion moves the torque enough beside friction, rotor and springs, which leave `variance` of it: a unit
// that rests on a small part of the torque is off where masses and lengths of the model are off by as much.
bool is_moved(double variance, const UnitRows& rows) { return variance > kMuch * kMuch * calc_variance(rows.tau); }

// True if an effort that opposes tau has its sign turned: friction, too, would drive the joint. Where there is hardly
// any friction, as in a torque sensor behind the gear, the effort must be near -tau. Otherwise a load on the far side
// of the joint turns the torque itself.
bool is_turned(const UnitRows& rows, double scale) {
  Eigen::MatrixXd X(rows.tau.size(), rows.nuisance.cols() + 1);
  X << rows.nuisance, rows.tau;
  const Eigen::VectorXd theta = X.colPivHouseholderQr().solve(rows.effort);
  const auto v = rows.nuisance.col(kSpeed);
  const Eigen::VectorXd friction = theta[kSpeed] * v + theta[kDry] * rows.nuisance.col(kDry);
  // Wrong masses look like less friction than that.
  if (friction.squaredNorm() / static_cast<double>(friction.size()) > kMuch * kMuch * calc_variance(rows.effort))
    return friction.dot(v) < 0.0;
  return std::abs(std::log(-scale)) < std::log(1.0 + kMuch);  // masses of a model are not further off
}

// The share of the effort that a torque explains by chance is that of its regressors in independent samples: few
// samples count only for what they explain beyond it (adjusted coefficient of determination). Zero if none is left.
double discount_chance(double share, const UnitRows& rows, long regressors) {
  if (rows.tau.size() >= kFewest) return share;
  const double samples = static_cast<double>(rows.tau.size()) / kPerPeriod,
               free = samples - static_cast<double>(regressors);
  return free > 0.0 ? std::max(0.0, 1.0 - (1.0 - share) * (samples - 1.0) / free) : 0.0;
}

// The bracket of effort and tau beside these regressors. Empty without samples, if they explain tau, or if it is too
// wide.
std::optional<EffortUnit> find_bracket(const TorqueData& data, const UnitRows& rows, const Eigen::MatrixXd& beside,
                                       int joint) {
  if (rows.tau.size() == 0) return std::nullopt;
  const Eigen::VectorXd tau = take_out(beside, rows.tau), effort = take_out(beside, rows.effort);
  const double tt = tau.squaredNorm(), te = tau.dot(effort), ee = effort.squaredNorm();
  const bool told = is_moved(tt / static_cast<double>(tau.size()), rows);
  if (!told || ee <= 0.0 || te == 0.0) return std::nullopt;
  EffortUnit unit;
  unit.joint = joint;
  unit.low = te / ee;
  unit.high = tt / te;  // with opposite biases
  unit.scale = std::copysign(std::sqrt(unit.low * unit.high), te);
  const double share = discount_chance(unit.low / unit.high, rows, beside.cols() + 1);
  const double width = share > 0.0 ? -std::log(share) : 1e300;
  if (unit.scale < 0.0 && !is_turned(rows, unit.scale) && may_be_load(data, {joint})) return std::nullopt;
  if (width > find_widest(unit.scale)) return std::nullopt;
  return unit;
}

// The bracket if the joint has no rotor. Empty if there is none, or if the effort opposes the torque.
std::optional<EffortUnit> find_without_rotor(const TorqueData& data, const UnitRows& rows, int joint) {
  Eigen::MatrixXd no_rotor(rows.nuisance.rows(), kRotor + 1);
  no_rotor << rows.nuisance.leftCols(kRotor), rows.nuisance.rightCols(1);
  std::optional<EffortUnit> least = find_bracket(data, rows, no_rotor, joint);
  if (!least || least->scale <= 0.0) return std::nullopt;
  least->at_least = true;
  return least;
}

// The joint's bracket. Empty if friction and rotor explain tau, or if the bracket is too wide. Where weight does not
// tell tau from the rotor's torque, as on a slide or an upright axis: the rotor only adds to the bodies' inertia.
// Efforts that are much less than the bodies alone take are in another unit, whatever the rotor.
std::optional<EffortUnit> find_unit(const TorqueData& data, int joint) {
  const UnitRows rows = collect_efforts(data, joint);
  const std::optional<EffortUnit> unit = find_bracket(data, rows, rows.nuisance, joint);
  if (unit) return unit;
  const std::optional<EffortUnit> least = find_without_rotor(data, rows, joint);
  return least && std::log(least->low) > kFactor ? least : std::nullopt;
}

// True if the effort is what the bodies alone take. The limit of |ln| counts as one where a rotor may be part of it.
// Units differ by factors of up to a hundred either way. One in 23 of these lies as near to one by chance, so a torque
// has odds of 20 to 1.
bool is_torque_of_bodies(const TorqueData& data, int joint) {
  const std::optional<EffortUnit> least = find_unit_without_rotor(data, joint);
  return least && std::abs(std::log(least->scale)) < kMinority;
}

bool is_wide(const EffortUnit& u) { return std::log(u.high / u.low) > kMuch; }

// Efforts that are much less than the bodies take: no load and no wrong mass makes them so.
bool is_large(const EffortUnit& u) { return std::log(u.low) > kFactor; }

// [|ln|] beyond which scales below one are a unit: loads of joints differ by more than a tenth; where scales differ by
// more, no load may explain the efforts as well.
double find_least(const TorqueData& data, const std::vector<EffortUnit>& units) {
  double low = 1e300, high = -1e300;
  std::vector<int> joints;
  for (const EffortUnit& u : units) {
    low = std::min(low, std::log(u.scale));
    high = std::max(high, std::log(u.scale));
    joints.push_back(u.joint);
  }
  if (units.size() > 1 && high - low < kDetail) return kFactor;
  return high - low > kMuch || may_be_load(data, joints) ? kLoad : kFactor;
}

// True if all scales are further from one than a wrong model could make them. Wide brackets decide only if no other
// exists.
bool are_far(const TorqueData& data, std::vector<EffortUnit> units) {
  if (!std::all_of(units.begin(), units.end(), is_wide))
    units.erase(std::remove_if(units.begin(), units.end(), is_wide), units.end());
  const auto is_off = [](const EffortUnit& u) { return is_large(u) || std::log(u.scale) < -kFactor; };
  const auto large = std::count_if(units.begin(), units.end(), is_large),
             off = std::count_if(units.begin(), units.end(), is_off);
  const auto count = static_cast<long>(units.size());
  if (large == count) return true;
  // One log is in torques or is not, and drives differ: the units of some may lie near one.
  if (large > 0 && 2 * off >= count) return true;
  // Nearer to one, no load has to be asked for.
  if (off < count) return false;
  const double least = find_least(data, units);
  return std::all_of(units.begin(), units.end(), [&](const EffortUnit& u) {
    return is_large(u) || std::log(least < kLoad ? u.scale : u.high) < -least;
  });
}

bool are_bounds(const std::vector<EffortUnit>& units) {
  return std::all_of(units.begin(), units.end(), [](const EffortUnit& u) { return u.at_least; });
}

bool are_wide(const std::vector<EffortUnit>& units) { return std::all_of(units.begin(), units.end(), is_wide); }

// Mean scale (of logarithms) of the joints with narrow brackets, of wide ones and of lower bounds only if there is
// nothing else, in bounds that contain all of theirs: drives of one robot differ as much. Empty if they disagree.
std::optional<EffortUnit> find_common_unit(const std::vector<EffortUnit>& units) {
  double sum = 0.0, low = 1e300, high = -1e300, count = 0.0;
  const bool wide = are_wide(units);
  EffortUnit common{-1,
                    1.0,
                    1e300,
                    0.0,
                    true,
                    units.front().of_gains,
                    are_bounds(units),
                    units.front().of_load,
                    units.front().by_load};
  for (const EffortUnit& u : units) {
    if (is_wide(u) != wide || u.at_least != common.at_least) continue;
    const double log = std::log(u.scale);
    sum += log;
    count += 1.0;
    low = std::min(low, log);
    high = std::max(high, log);
    common.low = std::min(common.low, u.low);
    common.high = std::max(common.high, u.high);
  }
  if (count == 0.0 || high - low > kMuch) return std::nullopt;
  common.scale = std::exp(sum / count);
  return common;
}

bool is_known(const std::vector<EffortUnit>& units, int joint) {
  return std::any_of(units.begin(), units.end(), [&](const EffortUnit& u) { return u.joint == joint; });
}

// Joints without a result, or with a wide bracket or a lower bound that admits a sharp one, get the scale of the others
// if those agree.
void add_others(const TorqueData& data, std::vector<EffortUnit>* units) {
  std::optional<EffortUnit> common = find_common_unit(*units);
  if (!common) return;
  const bool sharp = !are_wide(*units);
  for (EffortUnit& u : *units) {
    const double above = std::log(common->scale / u.low), below = std::log(u.high / common->scale);
    const bool bounded = !common->at_least && u.at_least && above > 0.0;
    if (bounded || (sharp && is_wide(u) && std::min(above, below) > -kDetail)) {
      common->joint = u.joint;
      u = *common;
    }
  }
  const EffortSource source = data.source[static_cast<size_t>(units->front().joint)];
  for (size_t j = 0; j < data.source.size(); ++j) {
    common->joint = static_cast<int>(j);
    // without a drive, it has no effort in any unit
    const bool driven = data.experiment->robot.tree.joint(common->joint).actuated;
    if (driven && !is_known(*units, common->joint) && data.source[j] == source) units->push_back(*common);
  }
}

// True if y follows the torque closely enough for a unit (find_bracket()).
bool tells_loaded(const TorqueData& data, const LoadedUnit& u) {
  const double width = u.share > 0.0 ? -std::log(u.share) : 1e300;
  if (!is_moved(u.moved * u.moved, collect_efforts(data, u.joint))) return false;
  return u.scale > 0.0 && width <= find_widest(u.scale);
}

// Once efforts are no torques: units beside a load that all joints carry, and beside springs. Each looks like a larger
// unit of single joints. A joint whose unit shows with the load alone gets one, too.
void refine_beside_load(const TorqueData& data, std::vector<EffortUnit>* units) {
  std::vector<int> joints;
  const bool of_gains = units->front().of_gains;
  for (size_t j = 0; j < data.source.size(); ++j) {
    const bool same = data.source[j] == data.source[static_cast<size_t>(units->front().joint)] &&
                      data.experiment->robot.tree.joint(static_cast<int>(j)).actuated;
    if (same && !data.servo[j].follows && collect_efforts(data, static_cast<int>(j)).tau.size() >= kFewest)
      joints.push_back(static_cast<int>(j));
  }
  const LoadedUnits found = find_loaded_units(data, joints);
  for (const LoadedUnit& u : found.joints) {
    const auto known =
        std::find_if(units->begin(), units->end(), [&](const EffortUnit& other) { return other.joint == u.joint; });
    if (!tells_loaded(data, u)) {
      if (known != units->end()) units->erase(known);
      continue;
    }
    const double wide = kNinetyFive * std::hypot(u.std, kBlur * u.scale);
    EffortUnit unit{u.joint,        u.scale,    std::max(u.scale - wide, u.scale * u.scale / (u.scale + wide)),
                    u.scale + wide, false,      of_gains,
                    false,          found.blur, found.of_torque};
    if (known != units->end())
      *known = unit;
    else
      units->push_back(unit);
  }
}

// A log that is proportional to the servo's law tells its unit by the law, much better than by the torque of the
// motion.
void take_from_law(const ServoReading& log, EffortUnit* unit) {
  if (unit->of_gains || log.slope <= 0.0) return;
  const double scale = 1.0 / log.slope;
  if (!unit->by_others && std::abs(std::log(scale / unit->scale)) > kFactor) return;  // the gains may be wrong, too
  unit->scale = scale;
  unit->low = scale * (1.0 - kTrace);
  unit->high = scale * (1.0 + kTrace);
  unit->by_others = unit->at_least = false;
  unit->of_load = unit->by_load = 0.0;
}

// A drive that gives nothing for small efforts gives more for the others than its mean unit says.
void take_beside_dead_zone(const TorqueData& data, EffortUnit* unit) {
  if (unit->of_gains) return;
  const std::optional<double> scale = find_unit_beside_dead_zone(collect_efforts(data, unit->joint));
  if (!scale) return;
  unit->low *= *scale / unit->scale;
  unit->high *= *scale / unit->scale;
  unit->scale = *scale;
}

// Further from one than a wrong model could make it.
std::optional<double> take_far(double scale) {
  const bool far = scale != 0.0 && std::isfinite(scale) && std::abs(std::log(std::abs(scale))) > kFactor;
  return far ? std::optional<double>(scale) : std::nullopt;
}

void scale_gains(double scale, const std::string& joint, Scenario* scenario) {
  ServoGains gains = get_servo_gains(*scenario, joint);
  gains.kp *= scale;
  gains.kd *= scale;
  scenario->servo_joints[joint] = gains;
}

}  // namespace

std::vector<EffortUnit> find_effort_units(const TorqueData& data) {
  std::vector<EffortUnit> units;
  if (data.recordings.empty()) return units;
  const bool servo = !is_effort_driven(*data.experiment);
  for (size_t j = 0; j < data.source.size(); ++j) {
    // A log that follows the servo's law is compared with it (servo_law.h).
    const bool of_gains = servo && data.source[j] == EffortSource::kServoLaw;
    if (!of_gains && (data.source[j] != EffortSource::kRecorded || data.servo[j].follows)) continue;
    std::optional<EffortUnit> unit = find_unit(data, static_cast<int>(j));
    if (!unit) continue;
    if (unit->scale < 0.0 && servo) return {};
    if (unit->scale < 0.0) return {*unit};
    unit->of_gains = of_gains;
    units.push_back(*unit);
  }
  if (!are_far(data, units)) return {};
  if (!units.empty()) refine_beside_load(data, &units);
  if (units.empty()) return {};
  for (EffortUnit& u : units) take_beside_dead_zone(data, &u);
  add_others(data, &units);
  for (EffortUnit& u : units) take_from_law(data.servo[static_cast<size_t>(u.joint)], &u);
  // Beside other joints' units, a log that is proportional to the law has one, too.
  for (size_t j = 0; j < data.servo.size(); ++j) {
    if (is_known(units, static_cast<int>(j)) || data.servo[j].follows || data.servo[j].slope <= 0.0) continue;
    units.push_back({static_cast<int>(j), 1.0, 1.0, 1.0, true, false, false, 0.0});
    take_from_law(data.servo[j], &units.back());
  }
  return units;
}

bool is_load_or_unit(const EffortUnit& unit) { return unit.by_load > kPart; }

bool tells_unit(const TorqueData& data, int joint) {
  return data.servo[static_cast<size_t>(joint)].follows || find_unit(data, joint).has_value() ||
         is_torque_of_bodies(data, joint);
}

std::optional<EffortUnit> find_unit_without_rotor(const TorqueData& data, int joint) {
  return find_without_rotor(data, collect_efforts(data, joint), joint);
}

std::optional<double> find_unit_without_friction(const TorqueData& data, int joint) {
  const UnitRows rows = collect_efforts(data, joint);
  if (rows.tau.size() < 2 * kNuisance) return std::nullopt;  // fewer fit by chance
  // The torque is what is known worst, as an acceleration is.
  Eigen::MatrixXd unit(rows.tau.size(), 2), friction(rows.tau.size(), 4);
  unit << rows.effort, rows.nuisance.col(kSpeed);
  friction << unit, rows.nuisance.col(kDry), rows.nuisance.col(kConstant);
  if (take_out(unit, rows.tau).squaredNorm() > (1.0 + kPart) * take_out(friction, rows.tau).squaredNorm())
    return std::nullopt;
  return take_far(unit.colPivHouseholderQr().solve(rows.tau)[0]);
}

std::optional<double> find_unit_without_constant(const TorqueData& data, int joint) {
  const UnitRows rows = collect_efforts(data, joint);
  if (rows.tau.size() < 2 * kNuisance) return std::nullopt;
  Eigen::MatrixXd unit(rows.tau.size(), kNuisance);
  unit << rows.tau, rows.nuisance.leftCols(kNuisance - 1);
  const double with_constant = take_out(rows.nuisance, rows.effort - rows.tau).squaredNorm();
  if (take_out(unit, rows.effort).squaredNorm() > (1.0 + kPart) * with_constant) return std::nullopt;
  return take_far(1.0 / unit.colPivHouseholderQr().solve(rows.effort)[0]);
}

Experiment convert_efforts(Experiment e, const std::vector<EffortUnit>& units) {
  for (const EffortUnit& unit : units) {
    const auto j = static_cast<size_t>(unit.joint);
    if (unit.of_gains) {
      scale_gains(unit.scale, e.robot.tree.joint(unit.joint).name, &e.scenario);
      continue;
    }
    for (Recording& r : e.recordings) {
      for (double& y : r.joints[j].signal[static_cast<int>(Quantity::kEffort)]) y *= unit.scale;
    }
    e.joint_noise[j][static_cast<size_t>(Quantity::kEffort)].sigma *= unit.scale;
  }
  return e;
}

}  // namespace hrp::diagnosis
