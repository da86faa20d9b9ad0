// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/unseen_contact.h"

#include <cmath>
#include <vector>

#include "common/base/rounding.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {
namespace {

// Share of the weight on joint j that something outside carries, at the kept samples. Empty if gravity does not pull on
// the joint, or pulls in turn to both sides.
Eigen::VectorXd calc_carried(const TorqueWork& w, const TorqueRecording& r, long j) {
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(r.q.rows(), r.q.cols());
  const Eigen::VectorXd weight = calc_efforts(w.plant, r.q, none, none).col(j);
  const double low = weight.minCoeff(), high = weight.maxCoeff();
  if (!(low * high > 0.0) || std::min(std::abs(low), std::abs(high)) < kHalf * std::max(std::abs(low), std::abs(high)))
    return {};
  Eigen::VectorXd carried(r.kept());
  for (long k = 0; k < r.kept(); ++k) carried[k] = -r.missing(k, j) / weight[r.full_row(k)];
  return carried;
}

// By recording: see above. Empty if some recording has none.
std::vector<Eigen::VectorXd> list_carried(const TorqueWork& w, int j) {
  std::vector<Eigen::VectorXd> list;
  for (const TorqueRecording& r : w.data.recordings) {
    const bool known = w.closed[r.index][static_cast<size_t>(j)].empty() && r.kept() > 0;
    list.push_back(known ? calc_carried(w, r, j) : Eigen::VectorXd());
    if (list.back().size() == 0) return {};
  }
  return list;
}

// Up to a minority of its weight the robot flies: rails and cables rub with a tenth of it (odri_hopper: 1.1 to 2.4 of
// 21 N). A minor share of samples in flight may be where a spring is at rest.
bool is_ground(const std::vector<Eigen::VectorXd>& carried) {
  double n = 0.0, sum = 0.0, flies = 0.0, pulls = 0.0;
  for (const Eigen::VectorXd& c : carried) {
    n += static_cast<double>(c.size());
    sum += c.sum();
    flies += static_cast<double>((c.array().abs() < kMinority).count());
    pulls += static_cast<double>((c.array() < -kMinority).count());
  }
  return sum > kHalf * n && flies > kMinor * n && pulls < kMinor * n;
}

// Clears the use of all joints within the filter's reach of ground. Returns the number of samples that are left.
double clear_ground(const Eigen::VectorXd& carried, double cutoff, TorqueRecording* r) {
  // Twice the usual reach: the torque of landing is many times that of free motion, so the filter's skirts count.
  const long reach = 1 + std::lround(2.0 * kFilterReach / cutoff / r->step / static_cast<double>(r->stride));
  double left = 0.0;
  for (long k = 0; k < carried.size(); ++k) {
    const long from = std::max(0L, k - reach), to = std::min(carried.size(), k + reach + 1);
    const bool lands = (carried.segment(from, to - from).array() > kMinority).any();
    if (lands)
      r->use.row(k).setConstant(false);
    else
      left += 1.0;
  }
  return left;
}

}  // namespace

void leave_out_unseen_contact(TorqueWork* w) {
  if (w->bodies || !w->data.feet.empty()) return;
  for (int j = 0; j < w->e.num_joints(); ++j) {
    const JointSpec& joint = w->e.robot.tree.joint(j);
    if (joint.actuated || !w->data.is_judged(j)) continue;
    const std::vector<Eigen::VectorXd> carried = list_carried(*w, j);
    if (carried.empty() || !is_ground(carried)) continue;
    double left = 0.0, all = 0.0;
    for (size_t r = 0; r < carried.size(); ++r) {
      left += clear_ground(carried[r], w->data.cutoff, &w->data.recordings[r]);
      all += static_cast<double>(carried[r].size());
    }
    w->data.warnings.push_back("something that pushes and lets go carries what hangs on " + joint.name +
                               ", which has no drive: the robot hops or steps, and no force of its feet was recorded. "
                               "Only free motion is judged, " +
                               number(100.0 * left / all, 2) + " % of the samples");
    w->data.missing.push_back(
        "the forces on the feet (/wrench/<sensor>/force): without them nothing is judged while a foot is on the "
        "ground");
    return;
  }
}

}  // namespace hrp::diagnosis
