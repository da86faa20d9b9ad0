// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/spring_contact.h"

#include <algorithm>
#include <cmath>

namespace hrp {
namespace {

constexpr int kMaxChanges = 6;            // of one point's regimes within a step
constexpr double kLimitTolerance = 1e-7;  // relative: sliding friction has settled

// Acceleration of a body as an impedance feels it (add_impedance_force): the part that vdot makes, and the part that
// velocities alone make, which is kept as an accelerometer measures it, without gravity. Zero for ground and obstacles.
struct BodyAcceleration {
  Vector3d alpha = Vector3d::Zero(), acc = Vector3d::Zero(), origin = Vector3d::Zero();
  Vector3d calc_at(const Vector3d& p) const { return acc + alpha.cross(p - origin); }
};

BodyAcceleration find_acceleration(const Data& data, const Vector3d& gravity_W, int body) {
  if (body < 0) return {};
  const LinkArticulated& A = data.articulated[static_cast<size_t>(body)];
  const LinkMotion& m = data.motion[static_cast<size_t>(body)];
  return {small::to_eigen(A.alpha) + small::to_eigen(m.alpha),
          small::to_eigen(A.acc) + small::to_eigen(m.acc) + gravity_W,
          small::to_eigen(data.kinematics[static_cast<size_t>(body)].p)};
}

inline void add_force(const Data& data, int body, const Vector3d& p, const Vector3d& f, LinkWrenches* wrenches) {
  if (body < 0) return;
  Vector6d& F = (*wrenches)[static_cast<size_t>(body)];
  F.head<3>() += (p - small::to_eigen(data.kinematics[static_cast<size_t>(body)].p)).cross(f);
  F.tail<3>() += f;
}

small::S3 make_square(const Vector3d& a) {
  return {a.x() * a.x(), a.x() * a.y(), a.x() * a.z(), a.y() * a.y(), a.y() * a.z(), a.z() * a.z()};
}

}  // namespace

// Of all points of a link: Z = [J H; H^T M]. J is symmetric but for rounding.
struct PointImpedances {
  small::M3 J{}, H{};
  small::S3 M{};
  bool any = false;

  // P^T z P with P = [-skew(r), 1], the map from the link's acceleration to the point's.
  void add(const small::S3& z, small::V3 r) {
    any = true;
    const small::M3 K{cross(r, small::V3{z.xx, z.xy, z.xz}), cross(r, small::V3{z.xy, z.yy, z.yz}),
                      cross(r, small::V3{z.xz, z.yz, z.zz})};
    J.x -= K.y * r.z - K.z * r.y;
    J.y -= K.z * r.x - K.x * r.z;
    J.z -= K.x * r.y - K.y * r.x;
    H.x += K.x;
    H.y += K.y;
    H.z += K.z;
    M = M + z;
  }

  LinkImpedance make(int link) const {
    LinkImpedance impedance;
    impedance.link = link;
    impedance.Z.topLeftCorner<3, 3>() = small::to_eigen(J);
    impedance.Z.topRightCorner<3, 3>() = small::to_eigen(H);
    impedance.Z.bottomLeftCorner<3, 3>() = small::to_eigen(H).transpose();
    impedance.Z.bottomRightCorner<3, 3>() << M.xx, M.xy, M.xz, M.xy, M.yy, M.yz, M.xz, M.yz, M.zz;
    return impedance;
  }
};

void SpringContact::start_regimes(const PairWork& pair) {
  for (int i = pair.first; i < pair.first + pair.count; ++i) {
    PointWork& point = points_[static_cast<size_t>(i)];
    if (!(point.depth > 0.0)) continue;
    point.normal = NormalRegime::kSpringDamper;
    point.tangent = TangentRegime::kStick;
    while (resolve_normal(point.v, &point)) {
    }
    point.changes = 0;
    if (horizon_ != 0.0 && !pair.coupled && !point.was_sliding) continue;
    const double limit = pair.friction * calc_pressing_force(point, point.v);
    const Vector3d trial = calc_trial(point, point.v);
    if (trial.norm() > limit) start_sliding(limit, trial, &point);
  }
}

// What a point needs in every solve is inline: calls cost a tenth of a step on many contacts.

// Spring and damper along the normal in the point's regime, at velocity v.
inline NormalForce SpringContact::calc_normal_force(const PointWork& point, const Vector3d& v) const {
  if (point.frozen) return point.fixed.normal;
  NormalForce force;
  if (point.normal == NormalRegime::kOpen) return force;
  const double pressing = -point.n.dot(v);
  force.spring = point.spring.force + point.spring.slope * horizon_ * pressing;
  if (point.normal == NormalRegime::kSpringDamper) force.damper = point.damping * (pressing + point.pressing_offset);
  return force;
}

inline double SpringContact::calc_pressing_force(const PointWork& point, const Vector3d& v) const {
  return std::max(0.0, calc_normal_force(point, v).sum());
}

// Tangential force before clipping [H03 eq. 5] at the end of the step.
inline Vector3d SpringContact::calc_trial(const PointWork& point, const Vector3d& v) const {
  const Vector3d tangential = remove_normal(point.n, v);
  return calc_tangential_force(point.law, point.slip + horizon_ * tangential, tangential);
}

inline PointForceParts SpringContact::calc_parts(const PointWork& point, const Vector3d& v) const {
  if (point.frozen) return point.fixed;
  PointForceParts parts;
  parts.clipped = point.tangent == TangentRegime::kSlide || point.normal == NormalRegime::kOpen;
  if (point.normal == NormalRegime::kOpen) return parts;
  parts.normal = calc_normal_force(point, v);
  const Vector3d trial = calc_trial(point, v);
  if (point.tangent == TangentRegime::kStick) {
    parts.friction = trial;
  } else {
    parts.friction =
        point.direction * point.limit + point.sideways * (trial - point.direction * point.direction.dot(trial));
  }
  return parts;
}

inline small::S3 SpringContact::calc_point_impedance(const PointWork& point) const {
  if (point.frozen) return {};
  const double along =
      dt_ * (point.spring.slope * horizon_ + (point.normal == NormalRegime::kSpringDamper ? point.damping : 0.0));
  const double across = dt_ * (point.law.tangential_stiffness * horizon_ + point.law.tangential_damping);
  const small::S3 nn = make_square(point.n);
  small::S3 tangential = small::S3{1, 0, 0, 1, 0, 1} - nn;
  if (point.tangent == TangentRegime::kSlide) {
    tangential = point.sideways * (tangential - make_square(point.direction));
  }
  return along * nn + across * tangential;
}

void SpringContact::add(const Data& data, LinkWrenches* wrenches, LinkImpedances* impedances) const {
  PointImpedances sum;
  for (size_t i = 0; i < pairs_.size(); ++i) {
    const PairWork& pair = pairs_[i];
    add_pair(pair, data, wrenches, &sum);
    if (i + 1 < pairs_.size() && pairs_[i + 1].body_a == pair.body_a) continue;
    if (sum.any) impedances->push_back(sum.make(pair.body_a));  // reserved by the caller
    sum = {};
  }
}

void SpringContact::add_pair(const PairWork& pair, const Data& data, LinkWrenches* wrenches,
                             PointImpedances* sum) const {
  const bool implicit = horizon_ != 0.0 && !pair.coupled;
  const small::V3 origin = data.kinematics[static_cast<size_t>(pair.body_a)].p;
  for (int i = pair.first; i < pair.first + pair.count; ++i) {
    const PointWork& point = points_[static_cast<size_t>(i)];
    if (point.normal == NormalRegime::kOpen) continue;
    const PointForceParts parts = calc_parts(point, point.v);
    const Vector3d f = point.n * parts.normal.sum() + parts.friction;
    add_force(data, pair.body_a, point.p, f, wrenches);
    add_force(data, pair.body_b, point.p, -f, wrenches);
    if (implicit) sum->add(calc_point_impedance(point), small::from_eigen(point.p) - origin);
  }
}

// A point never pulls along its normal: the damper ends where it would pull (one-sided), the contact where it would.
inline bool SpringContact::resolve_normal(const Vector3d& v, PointWork* point) const {
  if (point->normal == NormalRegime::kOpen) {
    // Not touching yet: closes within the step if it would be in the ground at its end.
    if (point->depth > 0.0 || !(point->depth - horizon_ * point->n.dot(v) > 0.0)) return false;
    point->normal = NormalRegime::kSpring;
    return true;
  }
  const NormalForce force = calc_normal_force(*point, v);
  if (force.spring < 0.0 || force.sum() < 0.0) {
    point->normal = NormalRegime::kOpen;
    return true;
  }
  if (law_.two_sided) return false;
  if (point->normal == NormalRegime::kSpringDamper && force.damper < 0.0) {
    point->normal = NormalRegime::kSpring;
    point->pressing_offset = 0.0;
    return true;
  }
  if (point->normal == NormalRegime::kSpring && point->n.dot(v) < 0.0 && point->damping > 0.0) {
    point->normal = NormalRegime::kSpringDamper;
    return true;
  }
  return false;
}

void SpringContact::start_sliding(double limit, const Vector3d& trial, PointWork* point) const {
  const double length = trial.norm();
  point->tangent = TangentRegime::kSlide;
  point->limit = limit;
  point->direction = trial / length;
  // Explicit forces are clipped as they are; the implicit step needs how the direction turns with the velocity.
  point->sideways = limit / length;
}

// [H03 eq. 6] at the end of the step. Linearised about the last answer: length fixed at the limit, direction turning
// with the velocity, so that the linear system stays symmetric.
inline bool SpringContact::resolve_tangent(const Vector3d& v, PointWork* point) const {
  if (point->normal == NormalRegime::kOpen) return false;
  const double limit = pairs_[static_cast<size_t>(point->pair)].friction * calc_pressing_force(*point, v);
  const Vector3d trial = calc_trial(*point, v);
  const double length = trial.norm();
  if (point->tangent == TangentRegime::kStick) {
    if (length <= limit * (1.0 + kLimitTolerance)) return false;
    start_sliding(limit, trial, point);
    return true;
  }
  if (length <= limit) {
    point->tangent = TangentRegime::kStick;
    return true;
  }
  const bool settled = std::abs(limit - point->limit) <= kLimitTolerance * limit &&
                       point->direction.dot(trial) >= length * (1.0 - kLimitTolerance);
  if (!settled) start_sliding(limit, trial, point);
  return !settled;
}

bool SpringContact::resolve(const Data& data) {
  if (horizon_ == 0.0) return false;
  bool changed = false;
  for (const PairWork& pair : pairs_) {
    if (pair.coupled) continue;
    const BodyAcceleration a = find_acceleration(data, gravity_W_, pair.body_a);
    for (int i = pair.first; i < pair.first + pair.count; ++i) {
      PointWork& point = points_[static_cast<size_t>(i)];
      if (point.changes >= kMaxChanges) continue;
      const Vector3d v = point.v + dt_ * a.calc_at(point.p);
      const bool moved = resolve_normal(v, &point) || resolve_tangent(v, &point);
      point.changes += moved;
      changed |= moved;
    }
  }
  return changed;
}

bool SpringContact::freeze_violators(const Data& data, bool all) {
  bool any = false;
  for (const PairWork& pair : pairs_) {
    if (pair.coupled) continue;
    const BodyAcceleration a = find_acceleration(data, gravity_W_, pair.body_a);
    for (int i = pair.first; i < pair.first + pair.count; ++i) {
      PointWork& point = points_[static_cast<size_t>(i)];
      if (point.frozen || point.normal == NormalRegime::kOpen) continue;
      const Vector3d v = horizon_ == 0.0 ? point.v : point.v + dt_ * a.calc_at(point.p);
      any |= freeze_violator(pair, calc_parts(point, v), all, &point);
    }
  }
  return any;
}

// True when the force leaves the cone [H03 eq. 6] or pulls.
bool SpringContact::freeze_violator(const PairWork& pair, PointForceParts parts, bool always, PointWork* point) {
  const double normal = parts.normal.sum();
  const double excess = parts.friction.norm() - pair.friction * std::max(0.0, normal);
  const bool violates = normal < 0.0 || excess > 10.0 * kLimitTolerance * normal;
  if (!violates && !always) return false;
  if (normal < 0.0) parts.normal = {};
  if (clip_to_cone(std::max(0.0, normal), pair.friction, &parts.friction)) {
    parts.clipped = true;
    point->tangent = TangentRegime::kSlide;
  }
  point->fixed = parts;
  point->frozen = true;
  return violates;
}

void SpringContact::move(const Data& data) {
  for (const PairWork& pair : pairs_) {
    const Transform X_WA = get_body_pose(data, pair.body_a), X_WB = get_body_pose(data, pair.body_b);
    for (int i = pair.first; i < pair.first + pair.count; ++i) {
      PointWork& point = points_[static_cast<size_t>(i)];
      const Vector3d a = X_WA * point.p_A, b = X_WB * point.p_B;
      point.depth = point.depth0 - point.n.dot(a - b);
      point.p = 0.5 * (a + b);
      point.spring = calc_normal_spring(point.law, point.depth);
      point.damping = calc_damper_coefficient(point.law, point.depth);
      point.v =
          calc_body_point_velocity(data, pair.body_a, point.p) - calc_body_point_velocity(data, pair.body_b, point.p);
      point.slip = remove_normal(point.n, point.slip0 + a - b);
      point.pressing_offset = 0.0;
      point.normal = NormalRegime::kOpen;
      point.tangent = TangentRegime::kStick;
    }
    start_regimes(pair);
  }
}

void SpringContact::finish(const Data& data, ContactReport* report) {
  for (const PairWork& pair : pairs_) {
    const bool implicit = horizon_ != 0.0 && !pair.coupled;
    const BodyAcceleration a = find_acceleration(data, gravity_W_, pair.body_a);
    for (int i = pair.first; i < pair.first + pair.count; ++i) {
      const PointWork& point = points_[static_cast<size_t>(i)];
      const Vector3d v = implicit ? Vector3d(point.v + dt_ * a.calc_at(point.p)) : point.v;
      finish_point(point, v, &report->point(point.index));
      keep_anchor(pair, point, v);
    }
  }
  report->finish();
}

void SpringContact::finish_point(const PointWork& point, const Vector3d& v, PointForce* force) const {
  const PointForceParts parts = calc_parts(point, v);
  force->spring = point.n * parts.normal.spring;
  force->damper = point.n * parts.normal.damper;
  force->friction = parts.friction;
  force->slip = remove_normal(point.n, v);
  force->clipped = parts.clipped;
}

// Where the point's anchor is at the end of the step: left behind while sticking; while sliding so near that spring and
// damper together just hold what friction can.
void SpringContact::keep_anchor(const PairWork& pair, const PointWork& point, const Vector3d& v) {
  const double stiffness = point.law.tangential_stiffness;
  if (stiffness <= 0.0 || point.normal == NormalRegime::kOpen) return;
  const Vector3d tangential = remove_normal(point.n, v);
  ContactAnchor anchor;
  anchor.body_a = pair.body_a;
  anchor.body_b = pair.body_b;
  anchor.p_A = point.p_A;
  anchor.sliding = point.tangent == TangentRegime::kSlide;
  Vector3d slip = point.slip + dt_ * tangential;
  if (anchor.sliding) {
    const Vector3d friction = calc_parts(point, v).friction;
    const double length = friction.norm();
    const Vector3d along = length > 0.0 ? Vector3d(friction / length) : Vector3d(Vector3d::Zero());
    const double elastic = length + point.law.tangential_damping * tangential.dot(along);
    slip = -along * (std::max(0.0, elastic) / stiffness);
  }
  anchor.slip_B = pair.R_WB.transpose() * slip;
  next_anchors_.push_back(anchor);
}

}  // namespace hrp
