// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/standing_legs.h"

#include <algorithm>

#include "common/multibody/kinematics.h"
#include "common/spatial/transform.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr size_t kPairs = 3;  // feet of which two may stand at any moment: trots, ambles, crawls

// A foot's place and how it moves against the base, base axes.
struct FootMotion {
  Vector3d p, v, w;
};

FootMotion find_motion(const Foot& foot, BodyMotion* motion) {
  const Data& data = motion->data();
  FootMotion out;
  out.p = get_pose(data, foot.link) * foot.p_LC;
  const Vector6d V = calc_point_velocity(data, foot.link, out.p);
  const Vector6d V_base = get_velocity(data, 0);
  out.w = V.head<3>() - V_base.head<3>();
  out.v = V.tail<3>() - V_base.tail<3>() - V_base.head<3>().cross(out.p);
  return out;
}

StandingFeet stand_on_sole(const Foot& foot, BodyMotion* motion) {
  const FootMotion at = find_motion(foot, motion);
  return {Matrix3d::Identity(), Matrix3d::Identity(), -at.w, get_pose(motion->data(), foot.link).R.col(2), at.p};
}

// w x d + dd/dt = 0, but for balls that roll over the ground by the difference of their turning.
StandingFeet stand_on_balls(const Foot& a, const Foot& b, BodyMotion* motion) {
  const FootMotion at = find_motion(a, motion), to = find_motion(b, motion);
  const Vector3d d = to.p - at.p, up = -(at.p + to.p).normalized();
  const Vector3d rolls = (b.radius * to.w - a.radius * at.w).cross(up);
  StandingFeet out;
  out.A = -skew(d.normalized());
  out.turn = (rolls - (to.v - at.v)) / d.norm();
  out.B.setZero();
  out.B.row(0) = d.normalized().transpose();
  out.level = Vector3d((b.radius - a.radius) / d.norm(), 0.0, 0.0);
  out.below = at.p + to.p;
  return out;
}

}  // namespace

std::vector<StandingFeet> list_standing_feet(const LeggedLog& log, BodyMotion* motion) {
  std::vector<StandingFeet> out;
  for (const Foot& foot : log.feet) {
    if (foot.flat) out.push_back(stand_on_sole(foot, motion));
  }
  if (!out.empty() || log.feet.size() < kPairs) return out;
  for (size_t a = 0; a < log.feet.size(); ++a) {
    for (size_t b = a + 1; b < log.feet.size(); ++b) out.push_back(stand_on_balls(log.feet[a], log.feet[b], motion));
  }
  return out;
}

void forget_up(std::vector<StandingFeet>* feet) {
  for (StandingFeet& f : *feet) {
    f.B.setZero();
    f.level.setZero();
    f.below.setZero();
  }
}

double calc_left(const std::vector<StandingFeet>& feet, const Vector3d& rate, const Vector3d& up) {
  double least = 1e300;
  for (const StandingFeet& f : feet) {
    const double turn = (f.A * rate - f.turn).squaredNorm() / (kRateOfSoles * kRateOfSoles);
    const double tilt =
        up.dot(f.below) > 0.0 ? 1.0 : (f.B * up - f.level).squaredNorm();  // feet are not above the body
    least = std::min(least, turn + tilt / (kTiltOfSoles * kTiltOfSoles));
  }
  return least;
}

}  // namespace hrp::diagnosis::floating
