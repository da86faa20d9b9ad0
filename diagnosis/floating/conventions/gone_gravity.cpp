// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/gone_gravity.h"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "common/multibody/kinematics.h"
#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/log/body_motion.h"

namespace hrp::diagnosis::floating {
namespace {

// Means over a log: what an accelerometer reads, in its axes, and where up is there.
struct Mean {
  Vector3d reading{0, 0, 0}, up{0, 0, 0};
  double square = 0.0, count = 0.0, seconds = 0.0;
};

// An attitude tells where up is. Else the base's own axis does: what it leans turns little of the vertical part.
Vector3d find_up(const BodyMotion& motion, size_t k) {
  return motion.has_attitude() ? motion.find_up(k) : Vector3d::UnitZ();
}

Mean calc_mean(const LeggedLog& log, size_t imu) {
  Mean out;
  for (const Clip& clip : log.clips) {
    BodyMotion motion(log, clip);
    for (size_t k = clip.edge; k + clip.edge < clip.size(); k += kStride) {
      motion.update(k);
      const Vector3d f = get_values(clip.imus[imu].accelerometer, k);
      const Matrix3d R_BI = get_pose(motion.data(), log.imus[imu].link).R * log.imus[imu].R_LI;
      out.reading += f;
      out.up += R_BI.transpose() * find_up(motion, k);
      out.square += f.squaredNorm();
      out.count += 1.0;
      out.seconds += static_cast<double>(kStride) * clip.step;
    }
  }
  if (out.count > 0.0) {
    out.reading /= out.count;
    out.up.normalize();
  }
  return out;
}

// Whether nothing is read of how gravity turns in the sensor's axes: the slope of the one over the other is 1 where a
// constant is missing, and 0 where gravity is. Steps pass in a second, so that means over as long hold little else. A
// body that hardly leans does not tell: then the constant is the smaller claim.
bool follows_up(const LeggedLog& log, size_t imu, const Mean& mean, double g) {
  std::vector<std::pair<Vector3d, Vector3d>> steps;  // read, turned
  double same = 0.0, square = 0.0;
  for (const Clip& clip : log.clips) {
    BodyMotion motion(log, clip);
    if (!motion.has_attitude()) return false;
    const auto span = static_cast<size_t>(std::lround(kStepTakes / clip.step));
    for (size_t begin = clip.edge; begin + span + clip.edge < clip.size(); begin += span) {
      Vector3d read = Vector3d::Zero(), turned = Vector3d::Zero();
      for (size_t k = begin; k < begin + span; k += kStride) {
        motion.update(k);
        const Matrix3d R_BI = get_pose(motion.data(), log.imus[imu].link).R * log.imus[imu].R_LI;
        read += get_values(clip.imus[imu].accelerometer, k) - mean.reading;
        turned += g * (R_BI.transpose() * motion.find_up(k) - mean.up);
      }
      same += read.dot(turned);
      square += turned.squaredNorm();
      steps.emplace_back(read, turned);
    }
  }
  if (square == 0.0) return false;
  double scatter = 0.0;
  for (const auto& [read, turned] : steps) scatter += std::pow((read - same / square * turned).dot(turned), 2);
  return std::abs(same / square) + kUnlikely * std::sqrt(scatter) / square < kHalf;
}

const std::vector<double>* find_column(const Recording& r, const std::string& name) {
  const auto at = r.other.find(name);
  return at == r.other.end() ? nullptr : &at->second;
}

// The attitudes of a sensor's axes, or none: its own, else the base's where it sits on the base.
struct Attitudes {
  const std::vector<double>* wxyz[4] = {nullptr, nullptr, nullptr, nullptr};
  Matrix3d R = Matrix3d::Identity();  // from the sensor's axes to those that turn
  bool any() const { return wxyz[0] && wxyz[1] && wxyz[2] && wxyz[3]; }
  Vector3d find_up(size_t k) const {
    const Eigen::Quaterniond q((*wxyz[0])[k], (*wxyz[1])[k], (*wxyz[2])[k], (*wxyz[3])[k]);
    return R.transpose() * (q.normalized().conjugate() * Vector3d::UnitZ());
  }
};

Attitudes find_attitudes(const Recording& r, const std::string& base, const Matrix3d& R) {
  Attitudes out;
  for (int i = 0; i < 4; ++i) out.wxyz[i] = find_column(r, base + "/orientation/" + "wxyz"[i]);
  out.R = R;
  return out;
}

}  // namespace

// No unit leaves so little of gravity as its noise and zero: in g, a tenth is left.
std::vector<GoneGravity> find_gone_gravity(const Experiment& e) {
  if (!e.scenario.floating_base || e.num_joints() == 0 || e.scenario.feet.empty()) return {};
  const LeggedLog log = make_legged_log(e, Half::kEven);
  const double g = e.scenario.gravity_W.norm();
  std::vector<GoneGravity> out;
  for (size_t i = 0; i < log.imus.size(); ++i) {
    if (!log.imus[i].accelerometer) continue;
    const Mean mean = calc_mean(log, i);  // bodies that fall so long have fallen 40 m
    if (mean.seconds < kFewestBlocks * kBlock || mean.square == 0.0 || mean.reading.norm() > kMinor * g) continue;
    const bool base = log.imus[i].attitude || (log.base_pose && log.imus[i].link == 0);
    // A walk that begins and ends upright has no mean acceleration across up.
    const Vector3d across = mean.reading - mean.up * mean.up.dot(mean.reading);
    out.push_back({"/imu/" + log.imus[i].name + "/linear_acceleration", g * mean.up - across, mean.reading.norm(),
                   base && follows_up(log, i, mean, g), log.imus[i].R_LI});
  }
  return out;
}

Experiment return_gravity(Experiment e, const std::vector<GoneGravity>& gone) {
  const double g = e.scenario.gravity_W.norm();
  for (const GoneGravity& one : gone) {
    for (Recording& r : e.recordings) {
      Attitudes at = find_attitudes(r, one.sensor.substr(0, one.sensor.rfind('/')), Matrix3d::Identity());
      if (!at.any()) at = find_attitudes(r, "/base/pose", one.R_LI);
      const bool follows = one.follows && at.any();
      for (size_t k = 0; k < r.time.size(); ++k) {
        const Vector3d more = follows ? Vector3d(g * at.find_up(k)) : one.value;
        for (int a = 0; a < 3; ++a) {
          const auto column = r.other.find(one.sensor + "/" + "xyz"[a]);
          if (column != r.other.end()) column->second[k] += more(a);
        }
      }
    }
  }
  return e;
}

}  // namespace hrp::diagnosis::floating
