// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/gear_ratios.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/measurement/motion_rows.h"
#include "diagnosis/simulation/bodies.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {
namespace {

// |ln| of the largest ratio that is tried. Beyond it, angles of a joint that moves leave its limits
// (data/plausibility.h).
const double kLargest = std::log(kTenTimes);

// Another ratio of one joint.
struct Trial {
  int joint = 0;
  double log = 0.0;  // ln of the ratio
  bool of_motor = false;
};

Eigen::MatrixXd calc_torques(const Plant& plant, const SampledMotion& rows, const Trial& t) {
  const double by = std::exp(-t.log);
  Eigen::MatrixXd q = rows.q, v = rows.v, a = rows.a;
  q.col(t.joint) *= by;
  v.col(t.joint) *= by;
  a.col(t.joint) *= by;
  return calc_efforts(plant, q, v, a);
}

// What is left with these torques. An effort of the motor is compared with the motor's part of them.
double calc_left(const SampledMotion& rows, const Trial& t, Eigen::MatrixXd tau) {
  if (t.of_motor) tau.col(t.joint) *= std::exp(-t.log);
  return rows.calc_left(rows.effort - tau);
}

double calc_left(const Plant& plant, const SampledMotion& rows, const Trial& t) {
  return calc_left(rows, t, calc_torques(plant, rows, t));
}

// Moves the ratio by ever smaller steps while less is left.
double refine(const Plant& plant, const SampledMotion& rows, Trial* t) {
  double least = calc_left(plant, rows, *t), step = kDetail;
  for (int i = 0; i < kHalvings; ++i) {
    step *= kHalf;
    for (double sign : {1.0, -1.0}) {
      Trial other = *t;
      other.log += sign * step;
      const double left = calc_left(plant, rows, other);
      if (left < least) {
        least = left;
        *t = other;
      }
    }
  }
  return least;
}

// The best ratio of a joint, and what is left with it. The torques of an angle serve both meanings of the effort.
double find_best(const Plant& plant, const SampledMotion& rows, Trial* best) {
  const int joint = best->joint;
  Trial of[2];  // of the link, of the motor
  double least[2] = {HUGE_VAL, HUGE_VAL};
  for (double log = -kLargest; log <= kLargest + kDetail; log += kDetail) {
    const Eigen::MatrixXd tau = calc_torques(plant, rows, {joint, log, false});
    for (const int i : {0, 1}) {
      const Trial t{joint, log, i == 1};
      const double left = calc_left(rows, t, tau);
      if (left < least[i]) {
        least[i] = left;
        of[i] = t;
      }
    }
  }
  *best = least[1] < least[0] ? of[1] : of[0];
  return refine(plant, rows, best);
}

// Training recordings that tell something; halves of a single one.
std::vector<SampledMotion> list_pieces(const TorqueData& data) {
  const std::vector<size_t> recordings = list_unloaded_training(data);
  std::vector<SampledMotion> pieces;
  for (size_t r : recordings) {
    if (recordings.size() > 1) {
      pieces.push_back(take_rows(data, {r}));
      continue;
    }
    pieces.push_back(take_rows(data, {r}, 0.0, kHalf));
    pieces.push_back(take_rows(data, {r}, kHalf, 1.0));
  }
  const auto tells_nothing = [](const SampledMotion& rows) { return rows.tell_nothing(); };
  pieces.erase(std::remove_if(pieces.begin(), pieces.end(), tells_nothing), pieces.end());
  return pieces;
}

// Fills in the deviation between recordings, halves of one recording, and whether they agree.
void judge_pieces(const TorqueData& data, const Plant& plant, const Trial& found, GearRatio* ratio) {
  double sum = 0.0, squares = 0.0, n = 0.0;
  bool same = true;
  for (const SampledMotion& rows : list_pieces(data)) {
    Trial own{found.joint, found.log, found.of_motor};
    const double least = refine(plant, rows, &own);
    same = same && own.log * found.log > 0.0 && least < calc_left(plant, rows, {found.joint, 0.0, false});
    sum += own.log;
    squares += own.log * own.log;
    n += 1.0;
  }
  const double spread = n > 1.0 ? std::sqrt(std::max(0.0, squares - sum * sum / n) / (n - 1.0)) : 0.0;
  ratio->std = ratio->ratio * std::max(kMinor / kNinetyFive / 2.0, spread / std::sqrt(std::max(1.0, n)));
  ratio->agreed = same && n > 1.0 && spread < kPart * std::abs(found.log);
}

bool may_have(const TorqueData& data, int joint) {
  const JointSpec& spec = data.experiment->robot.tree.joint(joint);
  return spec.actuated && data.is_judged(joint);
}

// Slope of one series over another through their means of each recording.
struct Slope {
  double aa = 0.0, ab = 0.0;
  double get() const { return aa > 0.0 ? ab / aa : 0.0; }
  void add(const std::vector<double>& a, const std::vector<double>& b);
};

void Slope::add(const std::vector<double>& a, const std::vector<double>& b) {
  double ma = 0.0, mb = 0.0, n = 0.0;
  for (size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    if (std::isfinite(a[k]) && std::isfinite(b[k])) {
      ma += a[k];
      mb += b[k];
      n += 1.0;
    }
  }
  for (size_t k = 0; k < std::min(a.size(), b.size()) && n > 0.0; ++k) {
    if (!std::isfinite(a[k]) || !std::isfinite(b[k])) continue;
    aa += (a[k] - ma / n) * (a[k] - ma / n);
    ab += (a[k] - ma / n) * (b[k] - mb / n);
  }
}

// True if a column is in the recorded unit of the positions, as `slope` of it over the positions says.
bool is_in_same_unit(double slope, double ratio) {
  return !(slope > 0.0) || std::abs(std::log(slope)) < kHalf * std::abs(std::log(ratio));
}

std::vector<double> calc_rate(const Recording& r, const std::vector<double>& q) {
  std::vector<double> rate(q.size(), NAN);
  for (size_t k = 1; k + 1 < q.size(); ++k) rate[k] = (q[k + 1] - q[k - 1]) / (r.time[k + 1] - r.time[k - 1]);
  return rate;
}

void divide(double by, std::vector<double>* values) {
  for (double& x : *values) x /= by;
}

}  // namespace

std::vector<GearRatio> list_gear_ratios(const TorqueData& data) {
  std::vector<GearRatio> out;
  if (data.experiment->scenario.floating_base) return out;
  const SampledMotion rows = take_rows(data, list_unloaded_training(data));
  if (rows.tell_nothing()) return out;
  const Plant plant = make_plant(*data.experiment, {});
  for (int j = 0; j < static_cast<int>(data.source.size()); ++j) {
    if (!may_have(data, j)) continue;
    const double nominal = calc_left(plant, rows, {j, 0.0, false});
    Trial best{j, 0.0, false};
    const double least = find_best(plant, rows, &best);
    if (!(least < kNearlyAll * nominal) || std::abs(best.log) < kMinor) continue;
    if (std::abs(best.log) > kLargest) continue;  // the end of what is tried is no best ratio
    GearRatio ratio{j, std::exp(best.log), 0.0, best.of_motor, least / nominal, false};
    judge_pieces(data, plant, best, &ratio);
    out.push_back(ratio);
  }
  std::sort(out.begin(), out.end(), [](const GearRatio& a, const GearRatio& b) { return a.left < b.left; });
  return out;
}

Experiment convert_ratio(Experiment e, const GearRatio& ratio) {
  const auto j = static_cast<size_t>(ratio.joint);
  Slope velocity, command;  // of all recordings: one in which the joint rests tells no unit
  for (const Recording& r : e.recordings) {
    const JointColumns& joint = r.joints[j];
    const std::vector<double>& q = joint.signal[static_cast<int>(Quantity::kPosition)];
    velocity.add(calc_rate(r, q), joint.signal[static_cast<int>(Quantity::kVelocity)]);
    command.add(q, joint.command);
  }
  for (Recording& r : e.recordings) {
    JointColumns& joint = r.joints[j];
    std::vector<double>&q = joint.signal[static_cast<int>(Quantity::kPosition)],
    &v = joint.signal[static_cast<int>(Quantity::kVelocity)];
    if (is_in_same_unit(velocity.get(), ratio.ratio)) divide(ratio.ratio, &v);
    if (is_in_same_unit(command.get(), ratio.ratio)) {
      divide(ratio.ratio, &joint.command);
      divide(ratio.ratio, &joint.command_rate);
    }
    divide(ratio.ratio, &q);
    if (ratio.of_motor) divide(1.0 / ratio.ratio, &joint.signal[static_cast<int>(Quantity::kEffort)]);
  }
  e.joint_noise[j][static_cast<size_t>(Quantity::kPosition)].sigma /= ratio.ratio;
  e.joint_noise[j][static_cast<size_t>(Quantity::kVelocity)].sigma /= ratio.ratio;
  if (ratio.of_motor) e.joint_noise[j][static_cast<size_t>(Quantity::kEffort)].sigma *= ratio.ratio;
  return e;
}

}  // namespace hrp::diagnosis
