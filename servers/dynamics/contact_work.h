// SPDX-License-Identifier: BSD-3-Clause
// What both contact models work on: the points of one step in an order that does not depend on how they were listed,
// and the anchors of sticking pairs.
#pragma once

#include <vector>

#include "common/multibody/model.h"
#include "common/robot/signals.h"

namespace hrp {

constexpr int kMaxContactPairs = 256;
constexpr int kMaxContactPoints = 512;  // of all pairs together

// Where a point stands in the contact set.
struct PointIndex {
  int pair = 0;
  int point = 0;
};

// Indices of all points ordered by bodies, then by position: equal sets give equal bits, listed in whatever order.
// `order` must have room for all points (reserved): nothing is allocated.
void sort_contact_points(const ContactSet& contacts, std::vector<PointIndex>* order);

// What is wrong with a contact set; nullptr when nothing is.
const char* find_contact_fault(const ContactSet& contacts, int num_links, int* pair);

// Pose of the body: identity for ground and obstacles.
Transform get_body_pose(const Data& data, int body);
// Velocity of the point of `body` that is at p_WC now.
Vector3d calc_body_point_velocity(const Data& data, int body, const Vector3d& p_WC);

// Link against link acts explicitly, so that both links get exactly opposite forces. A law is stable while its
// stiffness is below this mass [kg] over dt^2 and its damping below this mass over dt: a quarter of the links' reduced
// mass.
double calc_coupled_mass(const Model& model, int body_a, int body_b);

// Makes `forces` look like `contacts` (same pairs and points, parts zero) without allocating: what is not needed now
// waits in `spare`.
class ContactReport {
 public:
  ContactReport();
  void start(const ContactSet& contacts);
  PointForce& point(PointIndex i) { return forces_[static_cast<size_t>(i.pair)].points[static_cast<size_t>(i.point)]; }
  // For a law of pairs, which fills the parts itself.
  PairForce& pair(int i) { return forces_[static_cast<size_t>(i)]; }
  // Pair parts and totals from the points': sums in the points' order, total = spring + damper + friction.
  void finish();
  void clear();
  const ContactForces& forces() const { return forces_; }

 private:
  void resize(size_t pairs);
  ContactForces forces_;
  ContactForces spare_;
};

}  // namespace hrp
