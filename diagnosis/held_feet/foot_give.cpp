// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/held_feet/foot_give.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/quantile.h"
#include "diagnosis/data/smooth.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis::held_feet {
namespace {

constexpr double kBlock = 0.1;  // [s] longer than what is left of a height stays alike
constexpr double kZero = 0.02;  // [rad or m] standard deviation of an encoder's zero

// Samples of a loaded foot. Columns of x: 1 for each recording, -F_z, dz/dq of every joint.
struct Heights {
  std::vector<double> z;
  std::vector<Eigen::VectorXd> x;
  std::vector<int> block, part;
  long recordings = 0, joints = 0;
};

void add_recording(const Experiment& e, const LoadedFoot& foot, const Recording& r, long column, Heights* out) {
  const auto columns = find_wrench_columns(r, foot.sensor);
  std::vector<std::vector<double>> q, force;
  for (const JointColumns& joint : r.joints) q.push_back(fill_gaps(joint.signal[0]));
  for (size_t i = 0; i < 3; ++i) force.push_back(fill_gaps(*columns[i]));
  Model model(e.robot.tree, e.scenario.gravity_W);
  Data data(model);
  State state = make_state(model);
  Eigen::MatrixXd J(6, model.nv());
  std::vector<double> z, fz;
  std::vector<Eigen::VectorXd> slopes;
  for (size_t k = 0; k < r.size(); ++k) {
    for (size_t j = 0; j < q.size(); ++j) state.q(static_cast<long>(j)) = q[j][k];
    update_kinematics(model, state, &data);
    calc_frame_jacobian(model, data, foot.frame, J);
    const Transform X_WF = calc_frame_pose(model, data, foot.frame);
    const Vector3d F(force[0][k], force[1][k], force[2][k]);
    z.push_back(X_WF.p.z());
    fz.push_back(foot.world ? F.z() : (X_WF.R * F).z());
    slopes.push_back(J.row(5));
  }
  const double loaded = kMuch * find_median(fz);
  for (size_t k = 0; k < z.size(); ++k) {
    if (!(fz[k] > loaded) || loaded <= 0.0) continue;
    Eigen::VectorXd x = Eigen::VectorXd::Zero(out->recordings + 1 + out->joints);
    x[column] = 1.0;
    x[out->recordings] = -fz[k];
    x.tail(out->joints) = slopes[k];
    out->z.push_back(z[k]);
    out->x.push_back(x);
    const double at = r.time[k] - r.time[0];
    out->block.push_back(static_cast<int>(column) * 1000000 + static_cast<int>(at / kBlock));
    out->part.push_back(static_cast<int>(column) * kStretches +
                        std::min(kStretches - 1, static_cast<int>(kStretches * at / r.duration())));
  }
}

// The compliance and its standard deviation from the scatter between blocks; `use` by sample.
struct Slope {
  double value = 0.0, std = 1e300;
  Eigen::VectorXd left;  // by sample, of all
};

Slope fit(const Heights& h, const std::vector<char>& use, double noise) {
  const long n = h.recordings + 1 + h.joints;
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n, n), S = G;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (size_t k = 0; k < h.z.size(); ++k) {
    if (use[k]) {
      G += h.x[k] * h.x[k].transpose();
      b += h.z[k] * h.x[k];
    }
  }
  for (long j = 0; j < h.joints; ++j) G(n - 1 - j, n - 1 - j) += std::pow(noise / kZero, 2);
  const auto solver = G.completeOrthogonalDecomposition();
  const Eigen::VectorXd theta = solver.solve(b);
  Slope out{theta[h.recordings], 1e300, Eigen::VectorXd(static_cast<long>(h.z.size()))};
  Eigen::VectorXd score = Eigen::VectorXd::Zero(n);
  for (size_t k = 0; k < h.z.size(); ++k) {
    out.left[static_cast<long>(k)] = h.z[k] - h.x[k].dot(theta);
    if (use[k]) score += out.left[static_cast<long>(k)] * h.x[k];
    if (k + 1 == h.z.size() || h.block[k + 1] != h.block[k]) {
      S += score * score.transpose();
      score.setZero();
    }
  }
  const Eigen::MatrixXd inverse = solver.pseudoInverse();
  out.std = std::sqrt(std::max(0.0, (inverse * S * inverse)(h.recordings, h.recordings)));
  return out;
}

// Samples that are no spikes: what is left within kOutlier robust deviations, in three passes.
std::vector<char> find_sound(const Heights& h, double* noise) {
  std::vector<char> use(h.z.size(), 1);
  for (int pass = 0; pass < 3; ++pass) {
    const Slope slope = fit(h, use, *noise);
    std::vector<double> size;
    for (long k = 0; k < slope.left.size(); ++k) {
      if (use[static_cast<size_t>(k)]) size.push_back(std::abs(slope.left[k]));
    }
    *noise = std::max(1e-9, find_deviation(size));
    for (size_t k = 0; k < use.size(); ++k) use[k] = std::abs(slope.left[static_cast<long>(k)]) < kOutlier * *noise;
  }
  return use;
}

double calc_rms(const Eigen::VectorXd& left, const std::vector<char>& use) {
  double sum = 0.0, n = 0.0;
  for (long k = 0; k < left.size(); ++k) {
    if (use[static_cast<size_t>(k)]) {
      sum += left[k] * left[k];
      n += 1.0;
    }
  }
  return std::sqrt(sum / std::max(1.0, n));
}

// Spread of the height about its mean in each recording.
double calc_spread(const Heights& h, const std::vector<char>& use) {
  Heights plain = h;
  for (Eigen::VectorXd& x : plain.x) x.tail(1 + h.joints).setZero();
  return calc_rms(fit(plain, use, 1e-3).left, use);
}

bool is_same_in_parts(const Heights& h, const std::vector<char>& use, double noise, const Slope& whole) {
  for (int part = 0; part < h.recordings * kStretches; ++part) {
    std::vector<char> own = use;
    for (size_t k = 0; k < own.size(); ++k) own[k] = own[k] && h.part[k] == part;
    const Slope here = fit(h, own, noise);
    if (std::count(own.begin(), own.end(), 1) < 50 || here.std > std::abs(whole.value)) continue;  // tells nothing
    if (std::abs(here.value - whole.value) > 3.0 * std::hypot(here.std, whole.std)) return false;
  }
  return true;
}

}  // namespace

std::vector<FootGive> find_foot_gives(const Experiment& e, const std::vector<LoadedFoot>& feet) {
  std::vector<FootGive> found;
  std::vector<const Recording*> measured;
  for (const Recording& r : e.recordings) {
    const bool all =
        std::all_of(r.joints.begin(), r.joints.end(), [](const JointColumns& j) { return j.has(Quantity::kPosition); });
    if (all) measured.push_back(&r);
  }
  for (size_t f = 0; f < feet.size() && !measured.empty(); ++f) {
    Heights h;
    h.recordings = static_cast<long>(measured.size());
    h.joints = e.num_joints();
    for (size_t r = 0; r < measured.size(); ++r) add_recording(e, feet[f], *measured[r], static_cast<long>(r), &h);
    if (h.z.size() < 200) continue;
    double noise = 1e-3;
    const std::vector<char> use = find_sound(h, &noise);
    const Slope slope = fit(h, use, noise);
    FootGive give{f,
                  slope.value,
                  slope.std,
                  calc_spread(h, use),
                  calc_rms(slope.left, use),
                  is_same_in_parts(h, use, noise, slope),
                  {}};
    Eigen::VectorXd lever = Eigen::VectorXd::Zero(h.joints);
    for (const Eigen::VectorXd& x : h.x) lever += x.tail(h.joints).cwiseAbs2() / static_cast<double>(h.x.size());
    for (double square : lever) give.lever.push_back(std::sqrt(square));
    const bool explains = std::pow(give.after / std::max(1e-12, give.before), 2) < kMostly;
    if (slope.value > kSignificantInRobot * slope.std && explains) found.push_back(give);
  }
  return found;
}

}  // namespace hrp::diagnosis::held_feet
