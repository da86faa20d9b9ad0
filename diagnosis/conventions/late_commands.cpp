// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/late_commands.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/effect_info.h"
#include "diagnosis/conventions/list_fit.h"
#include "diagnosis/data/command_reader.h"
#include "diagnosis/data/smooth.h"
#include "diagnosis/data/stretches.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/model.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/findings/finding_head.h"
#include "diagnosis/measurement/load_or_unit.h"
#include "diagnosis/measurement/torque/effort.h"
#include "diagnosis/measurement/torque/term_rows.h"
#include "diagnosis/measurement/velocity_log.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {
namespace {

constexpr int kSteps = 20;  // delays to try up to the longest: 5 ms
constexpr double kFilters[] = {0.005, 0.01, 0.015,
                               0.02,  0.03, 0.04};  // [s] time constants to try, as firmware has them
constexpr long kSigned = kNuisance - 1;             // all but the constant: friction and rotor are not negative

// Mean square that friction, a rotor and a constant leave of a joint's missing torque. No coefficient of the first
// three is negative.
double calc_left(const UnitRows& rows) {
  const Eigen::VectorXd missing = rows.effort - rows.tau;
  double least = 1e300;
  for (int set = 0; set < 1 << kSigned; ++set) {
    std::vector<Eigen::Index> columns;
    for (int c = 0; c < kSigned; ++c) {
      if (set >> c & 1) columns.push_back(c);
    }
    columns.push_back(kSigned);
    const Eigen::MatrixXd X = rows.nuisance(Eigen::all, columns);
    const Eigen::VectorXd theta = X.colPivHouseholderQr().solve(missing);
    if ((theta.head(theta.size() - 1).array() < 0.0).any()) continue;
    least = std::min(least, (missing - X * theta).squaredNorm() / static_cast<double>(missing.size()));
  }
  return least;
}

// What is left at the joints that the servo's law drives: sum of logarithms, with their number and independent samples.
struct LeftByDrives {
  double logs = 0.0, samples = 0.0;
  int joints = 0;

  double calc_share(const LeftByDrives& of) const {
    return joints > 0 && joints == of.joints ? std::exp((logs - of.logs) / joints) : 1.0;
  }
};

LeftByDrives find_left(const Experiment& e) {
  LeftByDrives left;
  const TorqueData data = make_torque_data(e);
  for (size_t j = 0; j < data.source.size() && !data.recordings.empty(); ++j) {
    if (data.source[j] != EffortSource::kServoLaw) continue;
    const UnitRows rows = collect_efforts(data, static_cast<int>(j));
    if (rows.tau.size() <= rows.nuisance.cols()) continue;
    left.logs += std::log(std::max(1e-300, calc_left(rows)));
    ++left.joints;
    left.samples += static_cast<double>(rows.tau.size()) / kPerPeriod;
  }
  return left;
}

bool is_of_law(const Experiment& e) {
  for (int j = 0; j < e.num_joints() && e.scenario.drive == "servo"; ++j) {
    const bool driven = e.robot.tree.joint(j).actuated;
    if (driven && find_effort_source(e, static_cast<size_t>(j)) == EffortSource::kServoLaw) return true;
  }
  return false;
}

bool has_rates(const Experiment& e) {
  return std::any_of(e.recordings.begin(), e.recordings.end(), [](const Recording& r) {
    return std::any_of(r.joints.begin(), r.joints.end(), [](const JointColumns& j) { return !j.command_rate.empty(); });
  });
}

bool has_damping(const Experiment& e) {
  const Plant plant = make_plant(e, {});
  return std::any_of(plant.laws.begin(), plant.laws.end(),
                     [](const JointLaws& laws) { return laws.kp > 0.0 && laws.kd > 0.0; });
}

// Central differences: commands have no noise.
std::vector<double> differentiate(const std::vector<double>& time, const std::vector<double>& y) {
  std::vector<double> rate(y.size(), 0.0);
  for (size_t k = 0; k < y.size(); ++k) {
    const size_t a = k > 0 ? k - 1 : 0, b = std::min(y.size() - 1, k + 1);
    if (b > a) rate[k] = (y[b] - y[a]) / (time[b] - time[a]);
  }
  return rate;
}

// The recording with commands that were logged `delay` later, as long as there are any.
Recording advance(const Recording& logged, double delay) {
  const auto end =
      std::upper_bound(logged.time.begin(), logged.time.end(), logged.time.back() - delay) - logged.time.begin();
  Recording out = cut_recording(logged, 0, static_cast<size_t>(std::max<std::ptrdiff_t>(1, end)));
  out.spec.name = logged.spec.name;
  for (size_t j = 0; j < out.joints.size(); ++j) {
    const JointColumns& in = logged.joints[j];
    for (size_t k = 0; k < out.size(); ++k) {
      if (!in.command.empty()) out.joints[j].command[k] = interpolate(logged.time, in.command, out.time[k] + delay, k);
      if (!in.command_rate.empty())
        out.joints[j].command_rate[k] = interpolate(logged.time, in.command_rate, out.time[k] + delay, k);
    }
  }
  return out;
}

LateCommands make_delay(double delay) {
  LateCommands late;
  late.delay = delay;
  return late;
}

// Of the velocity with which servos damp; 0: as it was logged.
LateCommands make_filter(double time) {
  LateCommands late;
  late.damps_late = true;
  late.filter = time;
  return late;
}

LateCommands make_rate() {
  LateCommands rate;
  rate.of_rate = true;
  return rate;
}

// The delay that leaves least, between the delays that are tried (parabola); its standard deviation from the curvature.
// Without a delay at which less than half is left, 0.
LateCommands find_delay(const Experiment& e, const LeftByDrives& logged) {
  std::vector<double> share{1.0};
  for (int i = 1; i <= kSteps; ++i)
    share.push_back(find_left(convert_commands(e, make_delay(i * kLongest / kSteps))).calc_share(logged));
  const auto best = std::min_element(share.begin(), share.end()) - share.begin();
  if (best == 0 || best == kSteps || !(share[static_cast<size_t>(best)] < kHalf)) return {};
  const auto b = static_cast<size_t>(best);
  const double step = kLongest / kSteps, bend = share[b - 1] + share[b + 1] - 2.0 * share[b];
  LateCommands late =
      make_delay(step * (static_cast<double>(best) + calc_vertex(share[b - 1], share[b], share[b + 1])));
  // Least squares: what is left grows by its n-th part at one standard deviation. Bounds of friction and rotor bend the
  // curve, so that a parabola tells no more than a quarter of a step.
  late.std = step * std::hypot(kPart, std::sqrt(2.0 * share[b] / (bend * std::max(1.0, logged.samples))));
  return late;
}

// True if the servo's law is all that is known of some drive, and a velocity that it may damp with is late.
bool has_late_damping(const Experiment& e) {
  const Plant plant = make_plant(e, {});
  const std::vector<VelocityReading> velocity = find_velocity_readings(e);
  for (size_t j = 0; j < velocity.size(); ++j) {
    if (velocity[j].is_late() && plant.laws[j].kd > 0.0 && find_effort_source(e, j) == EffortSource::kServoLaw)
      return true;
  }
  return false;
}

// The velocity of a joint behind a filter 1 / (T s + 1).
std::vector<double> filter_velocity(const Recording& r, const JointColumns& joint, double time) {
  std::vector<double> rate =
      joint.has(Quantity::kVelocity) ? fill_gaps(joint.signal[1]) : differentiate(r.time, fill_gaps(joint.signal[0]));
  for (size_t k = 1; k < rate.size(); ++k)
    rate[k] = rate[k - 1] + (1.0 - std::exp((r.time[k - 1] - r.time[k]) / time)) * (rate[k] - rate[k - 1]);
  return rate;
}

// The filter that leaves least of those that are tried; 0 if it does not leave less than half of what the sharp
// velocity does.
double find_filter(const Experiment& e, const LeftByDrives& sharp) {
  double least = kHalf, best = 0.0;
  for (double time : kFilters) {
    const double share = find_left(convert_commands(e, make_filter(time))).calc_share(sharp);
    if (share < least) {
      least = share;
      best = time;
    }
  }
  return best;
}

// Which of the two explains more with physical sizes of everything else: no rotor is below zero. In N m, because the
// efforts by the two laws differ in size.
LateCommands find_late_damping(const Experiment& e, const LeftByDrives& sharp, int jobs) {
  const bool logged = has_late_damping(e);
  const double filter = logged || !has_damping(e) ? 0.0 : find_filter(e, sharp);
  if (!logged && filter == 0.0) return {};
  const LateCommands late = make_filter(filter);
  const double gain =
      compare_torques(fit_list(convert_commands(e, late), jobs), fit_list(e, jobs)) - (logged ? 0.0 : kWholeGain);
  return gain > kWholeGain ? late : LateCommands{};
}

LateCommands find_moved_commands(const Experiment& e, const LeftByDrives& logged, int jobs) {
  LateCommands late = find_delay(e, logged), rate;
  rate.of_rate =
      !has_rates(e) && has_damping(e) && find_left(convert_commands(e, make_rate())).calc_share(logged) < kHalf;
  if (!late.any() && !rate.any()) return {};
  const ListFit as_logged = fit_list(e, jobs);
  // In N m: efforts by a servo's law grow with the delay, and friction explains the growth.
  const auto judge = [&](const LateCommands& c) {
    return c.any() ? compare_torques(fit_list(convert_commands(e, c), jobs), as_logged) : 0.0;
  };
  const double of_delay = judge(late) - kWholeGain, of_rate = judge(rate);
  if (std::max(of_delay, of_rate) < kWholeGain) return {};
  rate.delay = late.delay;
  rate.std = late.std;
  LateCommands best = of_rate >= of_delay ? rate : late;
  best.either = std::min(of_delay, of_rate) > kLargely * std::max(of_delay, of_rate);
  return best;
}

}  // namespace

LateCommands find_late_commands(const Experiment& e, int jobs) {
  if (!is_of_law(e)) return {};
  const LeftByDrives left = find_left(e);
  const LateCommands damping = find_late_damping(e, left, jobs), moved = find_moved_commands(e, left, jobs);
  if (!damping.any()) return moved;
  const Experiment damped = convert_commands(e, damping);
  // Late commands and rates that were not logged leave a rotor below zero, too.
  if (moved.any() && compare_torques(fit_list(convert_commands(e, moved), jobs), fit_list(damped, jobs)) > 0.0)
    return moved;
  LateCommands out = find_moved_commands(damped, find_left(damped), jobs);
  out.damps_late = true;
  out.filter = damping.filter;
  return out;
}

Experiment convert_commands(Experiment e, const LateCommands& late) {
  for (Recording& r : e.recordings) {
    for (size_t j = 0; j < r.joints.size() && late.damps_late; ++j) {
      const JointColumns& joint = r.joints[j];
      if (late.filter > 0.0 && joint.has(Quantity::kPosition))
        r.other[name_servo_rate(j)] = filter_velocity(r, joint, late.filter);
      else if (joint.has(Quantity::kVelocity))
        r.other[name_servo_rate(j)] = joint.signal[static_cast<size_t>(Quantity::kVelocity)];
    }
    if (!late.is_of_commands()) continue;
    if (!late.of_rate) {
      r = advance(r, late.delay);
      continue;
    }
    for (JointColumns& joint : r.joints) {
      if (joint.command.empty()) continue;
      joint.command_rate = differentiate(r.time, joint.command);
      joint.separate_rate = true;
    }
  }
  return e;
}

std::string describe(const LateCommands& late) {
  const std::string how = late.filter > 0.0 ? "behind a filter of about " + number(1e3 * late.filter, 2) + " ms"
                                            : "as they were logged, late";
  std::string damping =
      late.damps_late ? "the servos damp with the velocities " + how + "; the simulator's servo has no such filter"
                      : "";
  if (!late.is_of_commands()) return damping;
  const std::string rate =
      "the servos damp the error of the velocity, kd (r' - q'), but no commanded velocity was logged";
  const std::string log = "the log of the commands is " + number(1e3 * late.delay, 3) + " +- " +
                          number(1e3 * kNinetyFive * late.std, 2) + " ms late: the servos acted on them before";
  const std::string first = late.of_rate ? rate + "; it is taken from the commanded positions" : log;
  return (damping.empty() ? "" : damping + ". ") + first +
         (late.either ? ". Hardly told from this: " + (late.of_rate ? log : rate) : "");
}

Json make_late_finding(const Experiment& e, const LateCommands& late) {
  if (!late.is_of_commands() || (late.of_rate && !late.either)) return nullptr;
  // A log that writes values one cycle late is off by a period.
  const bool sure = !late.either && late.delay - kNinetyFive * late.std > e.sample_time;
  const Json delay = make_value(round_to(late.delay, 4), round_to(late.std, 3), "s");
  Json f = make_finding_head(get_late_reading(), {{"sensor", "/joint_commands"}}, {{"delay", delay}},
                             sure ? Grade::kSupported : Grade::kAmbiguous, 1.0);
  if (late.either) f["probability"] = kHalf;
  f["of_log"] = true;
  f["statement"] = "/joint_commands: " + describe(late) + ".";
  f["alternatives"] = Json::array();
  return f;
}

}  // namespace hrp::diagnosis
