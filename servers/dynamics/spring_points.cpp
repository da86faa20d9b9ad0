// SPDX-License-Identifier: BSD-3-Clause
// The points of a step for SpringContact: their geometry and velocities, and what the last step's anchors tell of them.
#include <algorithm>
#include <tuple>

#include "servers/dynamics/spring_contact.h"

namespace hrp {

SpringContact::SpringContact(const ContactSpec& spec, const Model& model)
    : spec_(spec), law_(make_point_parameters(spec)), gravity_W_(model.gravity_W()) {
  order_.reserve(kMaxContactPoints);
  pairs_.reserve(kMaxContactPairs);
  points_.reserve(kMaxContactPoints);
  anchors_.reserve(kMaxContactPoints);
  next_anchors_.reserve(kMaxContactPoints);
}

void SpringContact::reset() {
  pairs_.clear();
  points_.clear();
  anchors_.clear();
}

void SpringContact::start(const ContactSet& contacts, const Model& model, const Data& data, double horizon, double dt) {
  horizon_ = horizon;
  dt_ = dt;
  sort_contact_points(contacts, &order_);
  start_pairs(contacts);
  for (PairWork& pair : pairs_) {
    start_pair(data, &pair);
    for (int i = pair.first; i < pair.first + pair.count; ++i) {
      PointWork& point = points_[static_cast<size_t>(i)];
      start_point(pair, contacts, data, &point);
      if (pair.coupled) limit_coupled_stiffness(model, pair, &point);
    }
  }
  project_velocities(contacts, data);
  for (const PairWork& pair : pairs_) start_regimes(pair);
}

// Pairs with the same bodies are one pair here.
void SpringContact::start_pairs(const ContactSet& contacts) {
  pairs_.clear();
  points_.clear();
  next_anchors_.clear();
  for (const PointIndex& index : order_) {
    const ContactPair& contact = contacts[static_cast<size_t>(index.pair)];
    if (pairs_.empty() || pairs_.back().body_a != contact.body_a || pairs_.back().body_b != contact.body_b) {
      PairWork pair;
      pair.body_a = contact.body_a;
      pair.body_b = contact.body_b;
      pair.friction = contact.friction;
      pair.coupled = contact.body_b >= 0;
      pair.first = static_cast<int>(points_.size());
      pairs_.push_back(pair);
    }
    points_.emplace_back();
    points_.back().index = index;
    points_.back().pair = static_cast<int>(pairs_.size()) - 1;
    ++pairs_.back().count;
  }
}

// Anchors lie in the order of their points, which is that of bodies.
void SpringContact::start_pair(const Data& data, PairWork* pair) const {
  const Transform X_WB = get_body_pose(data, pair->body_b);
  pair->R_WB = X_WB.R;
  pair->X_AW = get_body_pose(data, pair->body_a).inverse();
  pair->X_BW = X_WB.inverse();
  const auto comes_before = [](const ContactAnchor& anchor, const PairWork& of) {
    return std::tie(anchor.body_a, anchor.body_b) < std::tie(of.body_a, of.body_b);
  };
  const auto begin = std::lower_bound(anchors_.begin(), anchors_.end(), *pair, comes_before);
  const auto other = [&](const ContactAnchor& anchor) {
    return anchor.body_a != pair->body_a || anchor.body_b != pair->body_b;
  };
  pair->first_anchor = static_cast<size_t>(begin - anchors_.begin());
  pair->end_anchor = static_cast<size_t>(std::find_if(begin, anchors_.end(), other) - anchors_.begin());
}

// The displacement that this point had at the end of the last step; none for a new one.
void SpringContact::recall_anchor(const PairWork& pair, PointWork* point) const {
  const ContactAnchor* found = nullptr;
  double nearest = kSamePoint * kSamePoint;
  for (size_t i = pair.first_anchor; i < pair.end_anchor; ++i) {
    const double distance = (anchors_[i].p_A - point->p_A).squaredNorm();
    if (distance >= nearest) continue;
    nearest = distance;
    found = &anchors_[i];
  }
  point->slip = found ? remove_normal(point->n, pair.R_WB * found->slip_B) : Vector3d(Vector3d::Zero());
  point->was_sliding = found && found->sliding;
  point->slip0 = point->slip;
}

void SpringContact::start_point(const PairWork& pair, const ContactSet& contacts, const Data& data, PointWork* point) {
  const ContactPoint& contact =
      contacts[static_cast<size_t>(point->index.pair)].points[static_cast<size_t>(point->index.point)];
  point->p = contact.p_WC;
  point->n = contact.n_BA_W;
  point->depth = point->depth0 = contact.depth;
  point->p_A = pair.X_AW * contact.p_WC;
  point->p_B = pair.X_BW * contact.p_WC;
  point->law = law_;
  point->spring = calc_normal_spring(law_, point->depth);
  // Near the ground, not on it: the same line, which is negative here. The implicit step asks for its end only.
  if (!(point->depth > 0.0) && horizon_ > 0.0 && law_.exponent == 1.0) {
    point->spring = {law_.stiffness * point->depth, law_.stiffness};
  }
  point->damping = calc_damper_coefficient(law_, point->depth);
  point->v =
      calc_body_point_velocity(data, pair.body_a, point->p) - calc_body_point_velocity(data, pair.body_b, point->p);
  recall_anchor(pair, point);
  point->direction = Vector3d::Zero();
}

// What would be unstable is softened.
void SpringContact::limit_coupled_stiffness(const Model& model, const PairWork& pair, PointWork* point) const {
  const double mass = calc_coupled_mass(model, pair.body_a, pair.body_b) / pair.count;
  const double k_max = mass / (dt_ * dt_), c_max = mass / dt_;
  if (point->spring.slope > k_max) {
    point->spring.force *= k_max / point->spring.slope;
    point->spring.slope = k_max;
  }
  point->damping = std::min(point->damping, c_max);
  point->law.tangential_stiffness = std::min(point->law.tangential_stiffness, k_max);
  point->law.tangential_damping = std::min(point->law.tangential_damping, c_max);
}

// [H03 eq. 2]: only the projected velocity presses. A point or a patch that presses everywhere is its own projection.
bool SpringContact::presses_in_part(const PairWork& pair) const {
  if (law_.two_sided || pair.count == 0) return false;
  const auto begin = points_.begin() + pair.first, end = begin + pair.count;
  const auto is_at_rest = [](const PointWork& point) { return point.depth <= 0.0 || point.n.dot(point.v) <= 0.0; };
  return !std::all_of(begin, end, is_at_rest);
}

Vector6d SpringContact::load_projector(const PairWork& pair, const ContactSet& contacts, const Data& data, int place) {
  const auto begin = points_.begin() + pair.first, end = begin + pair.count;
  const Vector3d p_WR = contacts[static_cast<size_t>(begin->index.pair)].p_WR;
  projectors_[place].reset(spec_.length_scale);
  for (auto point = begin; point != end; ++point) {
    if (point->depth > 0.0) projectors_[place].add_point(point->p - p_WR, point->n);
  }
  Vector6d twist;
  const auto get_rate = [&](int body) {
    return body < 0 ? Vector3d(Vector3d::Zero())
                    : Vector3d(small::to_eigen(data.kinematics[static_cast<size_t>(body)].w));
  };
  twist << get_rate(pair.body_a) - get_rate(pair.body_b),
      calc_body_point_velocity(data, pair.body_a, p_WR) - calc_body_point_velocity(data, pair.body_b, p_WR);
  return twist;
}

void SpringContact::take_projection(const PairWork& pair, const Vector6d& projected, int place) {
  const TwistProjector& projector = projectors_[place];
  const auto begin = points_.begin() + pair.first, end = begin + pair.count;
  int i = 0;
  for (auto point = begin; point != end && i < projector.num_points(); ++point) {
    if (!(point->depth > 0.0)) continue;
    const double pressing = projector.calc_pressing_speed(i++, projected);
    if (pressing > 1e-9) point->pressing_offset = pressing + point->n.dot(point->v);
  }
}

void SpringContact::project_velocities(const ContactSet& contacts, const Data& data) {
  const PairWork* waiting[2];
  Vector6d twists[2];
  TwistProjection projections[2];
  int count = 0;
  for (const PairWork& pair : pairs_) {
    if (!presses_in_part(pair)) continue;
    waiting[count] = &pair;
    twists[count] = load_projector(pair, contacts, data, count);
    if (++count < 2) continue;
    project_both(projectors_, twists, projections);
    for (count = 0; count < 2; ++count) take_projection(*waiting[count], projections[count].x, count);
    count = 0;
  }
  if (count == 1) take_projection(*waiting[0], projectors_[0].project(twists[0]).x, 0);
}

}  // namespace hrp
