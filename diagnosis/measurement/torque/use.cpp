// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/torque/use.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "common/base/rounding.h"
#include "diagnosis/data/low_pass.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/ripple.h"

namespace hrp::diagnosis {
namespace {

// Torque of the joint's laws, from its description and the experiment, at the kept samples [N m].
Eigen::VectorXd calc_stated(const TorqueWork& w, const TorqueRecording& r, int j) {
  const JointLaws& laws = w.plant.laws[static_cast<size_t>(j)];
  const Eigen::VectorXd sign = w.data.calc_sign(r, j);
  Eigen::VectorXd friction = Eigen::VectorXd::Zero(r.v.rows());
  for (long k = 0; k < friction.size() && laws.has_friction(); ++k)
    friction[k] =
        sign[k] * calc_friction_level(laws, std::abs(r.speed(k, j)), r.load(k, j), sign[k] > 0.0 ? 1.0 : -1.0);
  Eigen::VectorXd stated = w.data.condition(r, friction);
  for (long k = 0; k < stated.size(); ++k) {
    const long row = r.full_row(k);
    stated[k] += calc_taken_torque(laws, r.q(row, j) - laws.joint_offset, r.v(row, j), r.a(row, j));
  }
  return stated;
}

// Full grid: true where every joint's position and this joint's effort were recorded.
Flags find_read(const TorqueWork& w, const TorqueRecording& r, size_t joint) {
  const Recording& in = w.e.recordings[r.index];
  Flags read = Flags::Constant(r.q.rows(), true);
  for (size_t j = 0; j < in.joints.size(); ++j) {
    const std::vector<double>& effort = in.joints[j].signal[static_cast<int>(Quantity::kEffort)];
    if (in.joints[j].has(Quantity::kPosition))
      mark_gaps(in.time, in.joints[j].signal[0], r, w.e.sample_time, w.data.cutoff, &read);
    if (j == joint && w.data.source[j] == EffortSource::kRecorded)
      mark_gaps(in.time, effort, r, w.e.sample_time, w.data.cutoff, &read);
  }
  return read;
}

// Full grid: true where all torques on the joint are known.
Flags find_known(const TorqueWork& w, const TorqueRecording& r, long j) {
  const RecordingSpec& spec = w.e.recordings[r.index].spec;
  const JointSpec& joint = w.e.robot.tree.joint(static_cast<int>(j));
  const bool pushed = has(spec.unknown_force, joint.name);
  // from the equation of a foot, not measured
  const bool followed = !w.closed[r.index][static_cast<size_t>(j)].empty();
  if (pushed || followed) return Flags::Constant(r.q.rows(), false);
  Flags known = find_read(w, r, static_cast<size_t>(j));
  if (r.known.size() > 0) known = known && r.known.col(j);
  if (w.data.feet.empty()) return known;
  known = known && !w.sudden[r.index];
  return joint.actuated ? Flags(known && !find_clipped(r.effort.col(j))) : known;
}

// Kept samples within the filter's reach of a recorded effort at its limit.
Flags find_limited(const TorqueWork& w, const TorqueRecording& r, int j) {
  const Recording& in = w.e.recordings[r.index];
  const std::vector<double>& log = in.joints[static_cast<size_t>(j)].signal[static_cast<int>(Quantity::kEffort)];
  const double limit = (1.0 - kMinor) * w.plant.laws[static_cast<size_t>(j)].effort_limit;
  if (log.empty() || !std::isfinite(limit)) return Flags::Constant(r.kept(), false);
  const Eigen::VectorXd size = resample(in.time, log, r.begin, r.step, r.q.rows()).cwiseAbs();
  return find_largest_near(size, r, w.data.cutoff).array() > limit;
}

}  // namespace

Eigen::VectorXd find_largest_near(const Eigen::VectorXd& full, const TorqueRecording& r, double cutoff) {
  const long reach = std::lround(kFilterReach / cutoff / r.step);
  Eigen::VectorXd largest(r.kept());
  for (long k = 0; k < largest.size(); ++k) {
    const long from = std::max(0L, r.full_row(k) - reach), to = std::min(full.size(), r.full_row(k) + reach + 1);
    largest[k] = full.segment(from, to - from).maxCoeff<Eigen::PropagateNumbers>();
  }
  return largest;
}

void make_missing_torque(TorqueWork* w, TorqueRecording* r) {
  const long kept = std::max(0L, (r->q.rows() - 2 * r->trim + r->stride - 1) / r->stride), n = r->q.cols();
  r->missing.setZero(kept, n);
  r->use.setConstant(kept, n, false);
  const Flags frozen = w->data.feet.empty() ? find_frozen(*r, w->still[r->index]) : Flags::Constant(r->q.rows(), false);
  if (frozen.any()) {
    long first = 0;
    while (!frozen[first]) ++first;
    w->data.frozen.push_back(r->index);
    w->data.warnings.push_back(
        w->e.recordings[r->index].spec.name + ": no joint moves although efforts change, from about " +
        number(r->begin + r->step * static_cast<double>(first), 3) + " s: this stretch is left out");
  }
  for (long j = 0; j < n; ++j) {
    const Eigen::VectorXd stated = calc_stated(*w, *r, static_cast<int>(j));
    const Flags moving = find_moving(r->v.col(j), w->data.slow[static_cast<size_t>(j)], r->step, w->data.cutoff);
    const Flags known = find_known(*w, *r, j);
    for (long k = 0; k < kept; ++k) {
      const long row = r->full_row(k);
      r->missing(k, j) = r->effort(row, j) - r->tau(row, j) - stated[k];
      r->use(k, j) = w->data.is_judged(static_cast<int>(j)) && !frozen[row] && moving[row] && known[row];
    }
  }
}

void leave_out_limits(TorqueWork* w, int j) {
  if (w->data.source[static_cast<size_t>(j)] != EffortSource::kRecorded) return;
  std::vector<Flags> limited;
  double used = 0.0, left = 0.0;
  for (const TorqueRecording& r : w->data.recordings) {
    limited.push_back(find_limited(*w, r, j));
    if (!r.train) continue;
    used += static_cast<double>(r.use.col(j).count());
    left += static_cast<double>((r.use.col(j) && !limited.back()).count());
  }
  for (size_t r = 0; r < limited.size() && left > kPart * used; ++r)
    w->data.recordings[r].use.col(j) = w->data.recordings[r].use.col(j) && !limited[r];
}

void take_out_log_ripple(TorqueWork* w, int j) {
  if (w->data.source[static_cast<size_t>(j)] != EffortSource::kRecorded) return;
  const std::optional<LogRipple> ripple = find_log_ripple(w->data, j);
  if (!ripple) return;
  // A bias that was taken out of the log contains the ripple's mean.
  const double mean = w->data.servo[static_cast<size_t>(j)].is_biased() ? ripple->mean : 0.0;
  for (TorqueRecording& r : w->data.recordings) {
    const Eigen::VectorXd torque = low_pass(ripple->calc(r.q.col(j)).array() - mean, r.step, w->data.cutoff);
    r.effort.col(j) -= torque;
    for (long k = 0; k < r.kept(); ++k) r.missing(k, j) -= torque[r.full_row(k)];
  }
}

}  // namespace hrp::diagnosis
