// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/wrench_contact.h"

#include <algorithm>
#include <cmath>

namespace hrp {
namespace {

constexpr int kMaxChanges = 9;         // of one pair's linearisation within a step: as many as solve_regimes() has
constexpr double kSettled = 1e-7;      // relative: the law agrees with its linearisation
constexpr double kHeld = 1e-3;         // relative: what has not settled is this near, or held
constexpr double kSmallWrench = 1e-7;  // [N] or less does not matter
constexpr size_t kReservedPairs = 64;

Vector6d make_diagonal(double x, double y, double z, const Vector3d& linear) {
  Vector6d diagonal;
  diagonal << x, y, z, linear;
  return diagonal;
}

WrenchLaw make_law(const ContactSpec& contact) {
  WrenchLaw law;
  const double l2 = contact.length_scale * contact.length_scale;
  law.stiffness = contact.stiffness * make_diagonal(l2, l2, l2, Vector3d::Ones());
  law.damping = contact.tangential_damping * make_diagonal(l2, l2, l2, Vector3d::Ones());
  law.alpha = contact.alpha;
  law.exponent = contact.exponent;
  law.length = contact.length_scale;
  law.two_sided = contact.damping == "two_sided";
  return law;
}

// The foot's mechanism as the pair's law: yaw and the plane of the sole have no stiffness of their own in a bush.
WrenchLaw make_foot_law(const ContactSpec& contact, const FootBushSpec& bush) {
  WrenchLaw law = make_law(contact);
  const double c = contact.tangential_damping, l2 = contact.length_scale * contact.length_scale;
  law.stiffness = make_diagonal(bush.k_roll, bush.k_pitch, bush.k_roll + bush.k_pitch, Vector3d::Constant(bush.kz));
  law.damping = make_diagonal(bush.c_roll, bush.c_pitch, c * l2, Vector3d(c, c, bush.cz));
  return law;
}

Vector3d get_origin(const Data& data, int body) {
  return small::to_eigen(data.kinematics[static_cast<size_t>(body)].p);
}

Vector3d get_rate(const Data& data, int body) {
  return body < 0 ? Vector3d(Vector3d::Zero())
                  : Vector3d(small::to_eigen(data.kinematics[static_cast<size_t>(body)].w));
}

Vector6d turn(const Matrix3d& R, const Vector6d& x) {
  Vector6d turned;
  turned << R * x.head<3>(), R * x.tail<3>();
  return turned;
}

// About a point that is r from where F is taken to.
Vector6d shift(const Vector6d& F, const Vector3d& r) {
  Vector6d shifted = F;
  shifted.head<3>() += r.cross(F.tail<3>());
  return shifted;
}

Matrix6d make_angular_scale(double length) {
  Vector6d unit;
  unit << length, length, length, 1.0, 1.0, 1.0;
  return unit.asDiagonal();
}

}  // namespace

WrenchContact::WrenchContact(const Scenario& scenario, const Model& model)
    : laws_(static_cast<size_t>(model.num_links())), gravity_W_(model.gravity_W()) {
  for (LinkLaw& law : laws_) law.law = make_law(scenario.contact);
  const TreeSpec& tree = model.spec();
  for (const auto& [foot, bush] : scenario.foot_bush) {
    const int frame = tree.find_frame(foot);
    const int link = frame >= 0 ? tree.frames[static_cast<size_t>(frame)].link : tree.find_link(foot);
    if (link < 0) continue;
    LinkLaw& law = laws_[static_cast<size_t>(link)];
    law.law = make_foot_law(scenario.contact, bush);
    law.has_centre = bush.center.has_value();
    if (law.has_centre) law.p_LQ = *bush.center;
  }
  pairs_.reserve(kReservedPairs);
  points_.reserve(kMaxContactPoints);
  moved_.reserve(kMaxProjectionPoints);
}

void WrenchContact::start(const ContactSet& contacts, const Model& model, const Data& data, double dt) {
  dt_ = dt;
  pairs_.clear();
  points_.clear();
  for (size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].points.empty()) continue;
    pairs_.emplace_back();
    pairs_.back().index = static_cast<int>(i);
    start_pair(contacts, model, data, &pairs_.back());
  }
}

void WrenchContact::start_pair(const ContactSet& contacts, const Model& model, const Data& data, WrenchPairWork* pair) {
  const ContactPair& contact = contacts[static_cast<size_t>(pair->index)];
  const LinkLaw& link = laws_[static_cast<size_t>(contact.body_a)];
  pair->body_a = contact.body_a;
  pair->body_b = contact.body_b;
  pair->friction = contact.friction;
  pair->coupled = contact.body_b >= 0;
  pair->law = link.law;
  pair->R_WA = get_body_pose(data, contact.body_a).R;
  pair->p_WQ = link.has_centre ? get_body_pose(data, contact.body_a) * link.p_LQ : contact.p_WR;
  if (pair->coupled) limit_coupled_law(model, pair);
  pair->first = static_cast<int>(points_.size());
  pair->count = std::min(static_cast<int>(contact.points.size()), kMaxProjectionPoints);
  for (int i = 0; i < pair->count; ++i) {
    const ContactPoint& point = contact.points[static_cast<size_t>(i)];
    points_.push_back(
        {pair->R_WA.transpose() * (point.p_WC - pair->p_WQ), pair->R_WA.transpose() * point.n_BA_W, point.depth});
  }
  Vector6d twist;
  twist << get_rate(data, pair->body_a) - get_rate(data, pair->body_b),
      calc_body_point_velocity(data, pair->body_a, pair->p_WQ) -
          calc_body_point_velocity(data, pair->body_b, pair->p_WQ);
  pair->V0 = turn(pair->R_WA.transpose(), twist);
  pair->D0 = calc_pair_displacement(pair->law, points_.data() + pair->first, pair->count).D;
  linearise(pair->V0, pair);
}

// What would be unstable is softened.
void WrenchContact::limit_coupled_law(const Model& model, WrenchPairWork* pair) const {
  const double mass = calc_coupled_mass(model, pair->body_a, pair->body_b);
  pair->law.stiffness *= std::min(1.0, mass / (dt_ * dt_) / pair->law.stiffness.tail<3>().maxCoeff());
  pair->law.damping *= std::min(1.0, mass / dt_ / std::max(pair->law.damping.tail<3>().maxCoeff(), 1e-9));
}

// What an impedance feels, see calc_acceleration() in spring_contact.cpp.
Vector6d WrenchContact::calc_end_twist(const Data& data, const WrenchPairWork& pair) const {
  if (pair.coupled) return pair.V0;
  const LinkArticulated& A = data.articulated[static_cast<size_t>(pair.body_a)];
  const LinkMotion& m = data.motion[static_cast<size_t>(pair.body_a)];
  const Vector3d alpha = small::to_eigen(A.alpha) + small::to_eigen(m.alpha);
  Vector6d a;
  a << alpha, small::to_eigen(A.acc) + small::to_eigen(m.acc) + gravity_W_ +
                  alpha.cross(pair.p_WQ - get_origin(data, pair.body_a));
  return pair.V0 + dt_ * turn(pair.R_WA.transpose(), a);
}

// [H03 eq. 1 to 6] of a pair.
PairWrench WrenchContact::evaluate(const WrenchPairWork& pair, const Vector6d& V) {
  const double horizon = pair.coupled ? 0.0 : dt_;
  moved_.assign(points_.begin() + pair.first, points_.begin() + pair.first + pair.count);
  for (PairPoint& point : moved_) point.depth -= horizon * point.n.dot(V.tail<3>() + V.head<3>().cross(point.r));
  displacement_ = calc_pair_displacement(pair.law, moved_.data(), pair.count);
  PairWrench wrench;
  projected_ = false;
  if (displacement_.D.isZero(0.0)) return wrench;
  Vector6d pressing = V;
  if (!pair.law.two_sided) {
    projector_.reset(pair.law.length);
    for (int i = 0; i < pair.count; ++i) {
      const PairPoint& point = moved_[static_cast<size_t>(i)];
      if (point.depth > 0.0 || displacement_.force[static_cast<size_t>(i)] > 0.0)
        projector_.add_point(point.r, point.n);
    }
    pressing = projector_.project(V).x;
    projected_ = true;
  }
  wrench.spring = calc_spring_wrench(pair.law.stiffness, displacement_.D);
  wrench.damper = calc_damping_wrench(pair.law, pair.D0, pressing);
  const Vector6d normal = calc_normal_wrench(wrench.spring, wrench.damper);
  wrench.tangential = calc_tangential_wrench(pair.law, normal, V);
  wrench.clipped = clip_wrench(pair.friction, pair.law.length, normal, &wrench.tangential);
  return wrench;
}

Matrix6d WrenchContact::calc_slope(const WrenchPairWork& pair) const {
  if (displacement_.D.isZero(0.0)) return Matrix6d::Zero();
  const Matrix6d unit = make_angular_scale(pair.law.length), inverse = make_angular_scale(1.0 / pair.law.length);
  const Matrix6d press =
      projected_ ? Matrix6d(inverse * projector_.calc_slope() * unit) : Matrix6d(Matrix6d::Identity());
  Matrix6d slope = dt_ * displacement_.slope;
  slope += press.transpose() * calc_damping_coefficients(pair.law, pair.D0).asDiagonal() * press;
  const Matrix6d across = calc_tangential_slope(pair.law, calc_normal_wrench(pair.at_V.spring, pair.at_V.damper));
  if (!pair.at_V.clipped) return slope + across;
  // Clipped, as if C were smaller. That is more than the slope, and does not throw the foot to and fro as the slope
  // does.
  const double size = calc_wrench_norm(pair.law.length, across * pair.V);
  const double share = size > 0.0 ? calc_wrench_norm(pair.law.length, pair.at_V.tangential) / size : 0.0;
  return slope + share * across;
}

void WrenchContact::linearise(const Vector6d& V, WrenchPairWork* pair) {
  pair->V = V;
  pair->at_V = evaluate(*pair, V);
  if (!pair->coupled) pair->slope = calc_slope(*pair);
}

void WrenchContact::add(const Data& data, LinkWrenches* wrenches, LinkImpedances* impedances) const {
  for (const WrenchPairWork& pair : pairs_) {
    const Vector6d F = turn(pair.R_WA, calc_acted(pair, pair.V0));
    const Vector3d r = pair.p_WQ - get_origin(data, pair.body_a);
    (*wrenches)[static_cast<size_t>(pair.body_a)] += shift(F, r);
    if (pair.body_b >= 0)
      (*wrenches)[static_cast<size_t>(pair.body_b)] -= shift(F, pair.p_WQ - get_origin(data, pair.body_b));
    if (pair.coupled || pair.held) continue;
    Matrix6d X = Matrix6d::Zero();  // from the link's acceleration in world axes to that of Q in A's
    X.topLeftCorner<3, 3>() = X.bottomRightCorner<3, 3>() = pair.R_WA.transpose();
    X.bottomLeftCorner<3, 3>() = -pair.R_WA.transpose() * skew(r);
    impedances->push_back({});  // reserved by the caller; two of one link add
    impedances->back().link = pair.body_a;
    impedances->back().Z = X.transpose() * (dt_ * pair.slope) * X;
  }
}

Vector6d WrenchContact::calc_acted(const WrenchPairWork& pair, const Vector6d& V) const {
  return pair.at_V.calc_total() - pair.slope * (V - pair.V);
}

bool WrenchContact::differs(const WrenchPairWork& pair, const Vector6d& V, double tolerance) {
  const Vector6d law = evaluate(pair, V).calc_total();
  const double limit = tolerance * calc_wrench_norm(pair.law.length, law) + kSmallWrench;
  return calc_wrench_norm(pair.law.length, law - calc_acted(pair, V)) > limit;
}

bool WrenchContact::resolve(const Data& data) {
  bool changed = false;
  for (WrenchPairWork& pair : pairs_) {
    if (pair.coupled || pair.changes >= kMaxChanges) continue;
    const Vector6d V = calc_end_twist(data, pair);
    if (!differs(pair, V, kSettled)) continue;
    linearise(V, &pair);
    ++pair.changes;
    changed = true;
  }
  return changed;
}

bool WrenchContact::hold(const Data& data) {
  bool any = false;
  for (WrenchPairWork& pair : pairs_) {
    if (pair.coupled || pair.held) continue;
    const Vector6d V = calc_end_twist(data, pair);
    if (!differs(pair, V, kHeld)) continue;
    pair.at_V = evaluate(pair, V);
    pair.slope.setZero();
    pair.held = any = true;
  }
  return any;
}

// The points get the pair's force by their part in the spring. Moments are the pair's alone: only its wrench is exact.
void WrenchContact::report_points(const WrenchPairWork& pair, const PairWrench& acted, PairForce* report) const {
  double sum = 0.0;
  for (int i = 0; i < pair.count; ++i) sum += displacement_.force[static_cast<size_t>(i)];
  if (!(sum > 0.0)) return;
  const Vector3d damper = pair.R_WA * acted.damper.tail<3>(), friction = pair.R_WA * acted.tangential.tail<3>();
  for (int i = 0; i < pair.count; ++i) {
    PointForce& point = report->points[static_cast<size_t>(i)];
    const double force = displacement_.force[static_cast<size_t>(i)];
    point.spring = force * point.n_BA_W;
    point.damper = force / sum * damper;
    point.friction = force / sum * friction;
    point.total = point.spring + point.damper + point.friction;
    point.clipped = acted.clipped;
  }
}

void WrenchContact::finish(const Data& data, ContactReport* report) {
  for (const WrenchPairWork& pair : pairs_) {
    PairForce& force = report->pair(pair.index);
    const Vector6d V = calc_end_twist(data, pair);
    PairWrench acted = evaluate(pair, V);
    if (pair.held) acted = pair.at_V;
    acted.tangential =
        calc_acted(pair, V) - acted.spring - acted.damper;  // what acted is reported, to the last bit or two
    const Vector3d r = pair.p_WQ - force.p_WR;
    force.spring = shift(turn(pair.R_WA, acted.spring), r);
    force.damper = shift(turn(pair.R_WA, acted.damper), r);
    force.friction = shift(turn(pair.R_WA, acted.tangential), r);
    force.total = force.spring + force.damper + force.friction;
    force.clipped = acted.clipped;
    report_points(pair, acted, &force);
  }
}

}  // namespace hrp
