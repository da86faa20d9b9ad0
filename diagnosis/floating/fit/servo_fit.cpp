// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/fit/servo_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr size_t kBlocks = 60;  // stretches whose samples count as one: what a law leaves is correlated

struct Normal {
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();  // sum z x^T
  Eigen::Vector2d b = Eigen::Vector2d::Zero();  // sum z y
  size_t count = 0;
};

template <typename Use>
void walk(const ServoSamples& s, const Use& use) {
  for (size_t k = 1; k + 1 < s.effort.size(); ++k) {
    const Eigen::Vector2d z = 0.5 * (s.error[k - 1] + s.error[k + 1]);
    if (z.allFinite() && s.error[k].allFinite() && std::isfinite(s.effort[k])) use(k, z);
  }
}

Normal sum_up(const std::vector<ServoSamples>& list) {
  Normal n;
  for (const ServoSamples& s : list) {
    walk(s, [&](size_t k, const Eigen::Vector2d& z) {
      n.A += z * s.error[k].transpose();
      n.b += z * s.effort[k];
      ++n.count;
    });
  }
  return n;
}

// Sandwich: scores summed over blocks.
Eigen::Matrix2d calc_covariance(const std::vector<ServoSamples>& list, const Normal& n, const Eigen::Vector2d& x,
                                size_t block) {
  Eigen::Matrix2d meat = Eigen::Matrix2d::Zero();
  for (const ServoSamples& s : list) {
    Eigen::Vector2d score = Eigen::Vector2d::Zero();
    size_t last = 0;
    walk(s, [&](size_t k, const Eigen::Vector2d& z) {
      if (k / block != last) {
        meat += score * score.transpose();
        score.setZero();
        last = k / block;
      }
      score += z * (s.effort[k] - s.error[k].dot(x));
    });
    meat += score * score.transpose();
  }
  const Eigen::Matrix2d inverse = n.A.inverse();
  return inverse * meat * inverse.transpose();
}

double calc_share(const std::vector<ServoSamples>& list, const Eigen::Vector2d& x) {
  double left = 0, all = 0;
  for (const ServoSamples& s : list) {
    walk(s, [&](size_t k, const Eigen::Vector2d&) {
      const double y = s.effort[k], r = y - s.error[k].dot(x);
      left += r * r;
      all += y * y;
    });
  }
  return all > 0 ? 1 - left / all : 0;
}

// Velocity as recorded, else by central differences.
double find_rate(const Recording& r, const JointColumns& joint, size_t k) {
  if (joint.has(Quantity::kVelocity)) return joint.signal[1][k];
  if (k == 0 || k + 1 >= r.size()) return std::nan("");
  return (joint.signal[0][k + 1] - joint.signal[0][k - 1]) / (r.time[k + 1] - r.time[k - 1]);
}

ServoSamples make_samples(const Recording& r, const JointColumns& joint) {
  ServoSamples s;
  for (size_t k = 0; k < r.size(); ++k) {
    s.error.emplace_back(joint.command[k] - joint.signal[0][k], joint.command_rate[k] - find_rate(r, joint, k));
    s.effort.push_back(joint.signal[2][k]);
  }
  return s;
}

Finding make_finding(const std::string& joint, const ServoFit& fit) {
  Finding f;
  f.effect = "joint_servo";
  f.family = "gain";
  f.where = {{"joint", joint}};
  f.grade = Grade::kSupported;
  f.parameters = {make_one("kp", "N m/rad", fit.kp, fit.kp_std), make_one("kd", "N m s/rad", fit.kd, fit.kd_std)};
  f.share = fit.share;
  f.probability = kSurest;
  f.statement = format(
      "%s: the joint does not follow its command exactly. A servo moves it: effort = kp (command - position) + kd "
      "(its rate - velocity), kp %.4g +- %.2g N m/rad, kd %.3g +- %.2g N m s/rad. That is %.1f %% of the held-out "
      "effort.",
      joint.c_str(), fit.kp, kNinetyFive * fit.kp_std, fit.kd, kNinetyFive * fit.kd_std, 100 * fit.share);
  return f;
}

}  // namespace

ServoFit fit_servo(const std::vector<ServoSamples>& train, const std::vector<ServoSamples>& held) {
  ServoFit fit;
  const Normal n = sum_up(train);
  if (n.count < kLeastServoSamples || !(std::abs(n.A.determinant()) > 0)) return fit;
  const Eigen::Vector2d x = n.A.inverse() * n.b;
  const Eigen::Matrix2d C = calc_covariance(train, n, x, std::max<size_t>(1, n.count / kBlocks));
  fit.kp = x(0);
  fit.kd = std::max(0.0, x(1));
  fit.kp_std = std::sqrt(std::max(0.0, C(0, 0)));
  fit.kd_std = std::sqrt(std::max(0.0, C(1, 1)));
  fit.share = calc_share(held.empty() ? train : held, x);
  fit.found = x.allFinite() && fit.kp > kNoChance * fit.kp_std && fit.share > kNearlyAll;
  return fit;
}

std::vector<Finding> find_servos(const Experiment& e) {
  std::vector<Finding> out;
  if (!e.scenario.perfect_joints || e.scenario.drive != "servo") return out;
  for (int j = 0; j < e.num_joints(); ++j) {
    std::vector<ServoSamples> train, held;
    for (const Recording& r : e.recordings) {
      const JointColumns& joint = r.joints[static_cast<size_t>(j)];
      if (joint.command.empty() || joint.command_rate.empty() || !joint.has(Quantity::kPosition) ||
          !joint.has(Quantity::kEffort))
        continue;
      (r.spec.train ? train : held).push_back(make_samples(r, joint));
    }
    const ServoFit fit = fit_servo(train, held);
    if (fit.found) out.push_back(make_finding(e.robot.tree.joint(j).name, fit));
  }
  return out;
}

}  // namespace hrp::diagnosis::floating
