// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/torque/load.h"

#include <algorithm>

#include "diagnosis/data/low_pass.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {
namespace {

constexpr long kDriveColumns = 6;  // of make_drive_columns()

bool has_link_encoder(const Recording& recording, const JointSpec& joint) {
  return recording.has(kLinkSide + joint.name + "/position");
}

struct LoadFit {
  Eigen::VectorXd theta;  // of the columns
  double left = 0.0;      // [(N m)^2] sum of squares
};

// Least squares of effort - tau on the training recordings, with the present r.load.
LoadFit fit_loads(const TorqueWork& w, int j) {
  Eigen::MatrixXd xx = Eigen::MatrixXd::Zero(kDriveColumns, kDriveColumns);
  LoadFit fit{Eigen::VectorXd::Zero(kDriveColumns), 0.0};
  Eigen::VectorXd xy = fit.theta;
  for (const TorqueRecording& r : w.data.recordings) {
    const long inner = r.q.rows() - 2 * r.trim;
    if (!r.train || inner <= 0) continue;
    Eigen::MatrixXd x = make_drive_columns(w.data, r, j).middleRows(r.trim, inner);
    Eigen::VectorXd y = (r.effort.col(j) - r.tau.col(j)).segment(r.trim, inner);
    if (r.known.size() > 0) {
      const Eigen::ArrayXd known = r.known.col(j).segment(r.trim, inner).cast<double>();
      x.array().colwise() *= known;
      y.array() *= known;
    }
    xx += x.transpose() * x;
    xy += x.transpose() * y;
    fit.left += y.squaredNorm();
  }
  fit.theta = xx.completeOrthogonalDecomposition().solve(xy);
  fit.left -= xy.dot(fit.theta);
  return fit;
}

// Squares that fit_loads leaves, each joint's over the squares of its effort.
double calc_all_left(const TorqueWork& w) {
  double left = 0.0;
  for (int j = 0; j < w.e.num_joints(); ++j) {
    double efforts = 0.0;
    for (const TorqueRecording& r : w.data.recordings) efforts += r.train ? r.effort.col(j).squaredNorm() : 0.0;
    if (w.data.is_judged(j) && efforts > 0.0) left += fit_loads(w, j).left / efforts;
  }
  return left;
}

void read_link_motion(const TorqueWork& w, TorqueRecording* r) {
  const Recording& in = w.e.recordings[r->index];
  r->link_q = r->q;
  r->link_v = r->v;
  r->link_a = r->a;
  for (int j = 0; j < w.e.num_joints(); ++j) {
    if (!has_link_encoder(in, w.e.robot.tree.joint(j))) continue;
    r->link_q.col(j) = read_link_angle(w.e, j, *r, w.data.cutoff);
    r->link_v.col(j) = differentiate(r->link_q.col(j), r->step);
    r->link_a.col(j) = differentiate(r->link_v.col(j), r->step);
  }
  for (Eigen::MatrixXd* m : {&r->filter_gap, &r->sharp_q, &r->sharp_v, &r->sharp_a}) m->resize(0, 0);
  r->tau = r->load = calc_efforts(add_by_hand(w.plant, in.spec), r->link_q, r->link_v, r->link_a);
}

// Friction that bends before it slips reverses slowly. For such a joint the smoothed speed predicts the effort better.
// Returns the fit with the chosen speed.
LoadFit choose_speed(TorqueWork* w, int j) {
  std::vector<Eigen::VectorXd> sharp;
  LoadFit with_sharp = fit_loads(*w, j);
  for (TorqueRecording& r : w->data.recordings) {
    sharp.push_back(r.speed.col(j));
    r.speed.col(j) = r.v.col(j);
  }
  LoadFit with_smooth = fit_loads(*w, j);
  if (with_smooth.left < kNearlyAll * with_sharp.left) return with_smooth;
  for (size_t r = 0; r < sharp.size(); ++r) w->data.recordings[r].speed.col(j) = sharp[r];
  return with_sharp;
}

// Chooses the load of a joint, see TorqueData::loaded_by_drive; `bodies`: the fit with the bodies' torque. The load of
// a drive is its effort as the regressors predict it. The recorded effort is the left side of the equation; as a
// regressor it would explain its own errors.
void choose_load(TorqueWork* w, int j, const LoadFit& bodies) {
  if (!w->e.robot.tree.joint(j).actuated) return;
  for (TorqueRecording& r : w->data.recordings) r.load.col(j) += make_drive_columns(w->data, r, j) * bodies.theta;
  // A smaller difference decides nothing.
  const bool by_drive = fit_loads(*w, j).left < (1.0 - kKnown) * bodies.left;
  w->data.loaded_by_drive[static_cast<size_t>(j)] = by_drive;
  for (TorqueRecording& r : w->data.recordings) {
    if (!by_drive) r.load.col(j) = r.tau.col(j);
  }
}

}  // namespace

Eigen::MatrixXd make_drive_columns(const TorqueData& data, const TorqueRecording& r, int j) {
  const Eigen::VectorXd sign = data.calc_sign(r, j);
  Eigen::MatrixXd x(r.q.rows(), kDriveColumns);
  x << r.a.col(j), r.v.col(j), low_pass(sign, r.step, data.cutoff),
      low_pass(sign.cwiseProduct(r.load.col(j).cwiseAbs()), r.step, data.cutoff), r.q.col(j),
      Eigen::VectorXd::Ones(r.q.rows());
  return x;
}

void choose_encoders(TorqueWork* w) {
  const auto has_any = [&](const Recording& r) {
    return std::any_of(w->e.robot.tree.links.begin() + 1, w->e.robot.tree.links.end(),
                       [&](const LinkSpec& link) { return has_link_encoder(r, link.joint); });
  };
  if (w->bodies || !w->data.feet.empty() || !std::all_of(w->e.recordings.begin(), w->e.recordings.end(), has_any))
    return;
  const double by_drives = calc_all_left(*w);
  std::vector<TorqueRecording> of_drives = w->data.recordings;
  for (TorqueRecording& r : w->data.recordings) read_link_motion(*w, &r);
  if (calc_all_left(*w) > (1.0 - kMinor) * by_drives) w->data.recordings = std::move(of_drives);
}

void choose_speed_and_load(TorqueWork* w, int j) { choose_load(w, j, choose_speed(w, j)); }

}  // namespace hrp::diagnosis
