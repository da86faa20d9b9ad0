// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/zero_search.h"

#include <cmath>
#include <limits>

#include "common/base/diagnostics.h"
#include "diagnosis/conventions/list_fit.h"
#include "diagnosis/estimate/odds.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

[[noreturn]] void fail_turned(const Experiment& e, const JointZero& zero) {
  const std::string column = e.signal_name(zero.joint, Quantity::kPosition);
  refuse_input(e.recordings.front().find_place(column),
               "with its effort fits the model with the other sign only: is the axis of " +
                   e.robot.tree.joint(zero.joint).name + ", or of all others, turned in the model?");
}

// What a leaves of what b leaves, squares, geometric mean over the joints; infinite if they judge others.
double calc_mean_ratio(const ListFit& a, const ListFit& b) {
  if (a.cross.size() != b.cross.size() || a.cross.empty()) return std::numeric_limits<double>::infinity();
  double sum = 0.0;
  for (size_t i = 0; i < a.cross.size(); ++i) sum += std::log(a.cross[i] / b.cross[i]);
  return std::exp(sum / static_cast<double>(a.cross.size()));
}

// Zeros moved by ever smaller steps while more is explained: friction near rest draws those of plain least squares
// aside.
ListFit polish_zeros(const Experiment& e, int jobs, ListFit best, std::vector<JointZero>* zeros) {
  for (double step : {0.02, 0.01, 0.005, 0.0025}) {
    for (size_t i = 0; i < zeros->size(); ++i) {
      for (double sign : {1.0, -1.0}) {
        std::vector<JointZero> moved = *zeros;
        moved[i].offset += sign * step;
        const ListFit other = fit_list(convert_zeros(e, moved), jobs);
        if (compare(other, best) > 0.0) {
          best = other;
          *zeros = moved;
        }
      }
    }
  }
  return best;
}

}  // namespace

std::vector<JointZero> find_zeros(const Experiment& e, int jobs) {
  const TorqueData data = make_torque_data(e);
  if (data.recordings.empty()) return {};
  JointZeros found = find_joint_zeros(data);
  // Zeros that hang an arm down explain efforts that are no torques better than the model's, but not well.
  if (found.joints.empty() || found.left > kNearlyAll || found.of_effort > kMuch) return {};
  const double cost = kOneValue * static_cast<double>(found.joints.size());
  const ListFit without = fit_list(make_torque_design(TorqueData(data)), jobs);
  const bool most = found.joints.size() == 1 && !found.joints[0].turned && found.left < kDetail;
  const ListFit first = fit_list(convert_zeros(e, found.joints), jobs);
  // Hundredths of a radian cannot save zeros beside which other effects explain all but a trace of what these leave.
  if (!most && calc_mean_ratio(without, first) < kDetail) return {};
  const double gain = compare(polish_zeros(e, jobs, first, &found.joints), without);
  // Beside a load a zero is one more effect, however much of the load it would do. If other effects explain everything
  // at the logged zeros, a zero alone has to do so, too. Forces and masses, a dozen numbers, may explain some more.
  const ListFit by_zero = most ? fit_list(convert_zeros(e, found.joints), jobs, Of::kJoints) : ListFit{};
  const bool alone = most && compare(by_zero, without) > -kOverwhelming && (by_zero.is_exact() || !without.is_exact());
  if (!alone && gain < cost + kWholeGain) return {};
  for (const JointZero& zero : found.joints) {
    if (zero.turned) fail_turned(e, zero);
  }
  return found.joints;
}

}  // namespace hrp::diagnosis
