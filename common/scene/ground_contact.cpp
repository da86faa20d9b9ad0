// SPDX-License-Identifier: BSD-3-Clause
#include "common/scene/ground_contact.h"

#include <algorithm>
#include <map>

namespace hrp {
namespace {

constexpr double kLeastPress = 1.0;  // [N] less is no contact to speak of

// > 0: the way from o over a to b turns left, seen from above.
double calc_turn(const Vector3d& o, const Vector3d& a, const Vector3d& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

// One half of Andrew's monotone chain, without its last point.
template <typename Iterator>
std::vector<Vector3d> walk_chain(Iterator begin, Iterator end) {
  std::vector<Vector3d> chain;
  for (Iterator p = begin; p != end; ++p) {
    while (chain.size() > 1 && calc_turn(chain[chain.size() - 2], chain.back(), *p) <= 0) chain.pop_back();
    chain.push_back(*p);
  }
  chain.pop_back();
  return chain;
}

// [m] of the contact points, weighed by the sizes of their forces.
double calc_mean_height(const ContactForces& forces, const GroundPlane& ground) {
  double sum = 0.0, weight = 0.0;
  for (const PairForce& pair : forces) {
    if (!is_ground_pair(pair, ground)) continue;
    for (const PointForce& point : pair.points) {
      sum += point.total.norm() * point.p_WC.z();
      weight += point.total.norm();
    }
  }
  return weight > 0.0 ? sum / weight : 0.0;
}

}  // namespace

std::vector<LinkForce> sum_link_forces(const ContactForces& forces) {
  struct Sum {
    LinkForce all;
    Vector3d moment_O = Vector3d::Zero();  // [N m] about the world's origin
    double weight = 0.0;                   // [N]
  };
  std::map<int, Sum> sums;
  for (const PairForce& pair : forces) {
    if (pair.body_b >= 0 || is_object(pair.body_a)) continue;  // between links or with objects: nothing from the world
    Sum& sum = sums[pair.body_a];
    const Vector3d force = pair.total.tail<3>();
    sum.all.force += force;
    sum.moment_O += pair.total.head<3>() + pair.p_WR.cross(force);
    for (const PointForce& point : pair.points) {
      sum.weight += point.total.norm();
      sum.all.p_WC += point.total.norm() * point.p_WC;
    }
  }
  std::vector<LinkForce> found;
  for (auto& [link, sum] : sums) {
    if (sum.weight <= 0.0) continue;
    sum.all.link = link;
    sum.all.p_WC /= sum.weight;
    sum.all.moment = sum.moment_O - sum.all.p_WC.cross(sum.all.force);
    found.push_back(sum.all);
  }
  return found;
}

std::optional<Vector3d> calc_ground_zmp(const ContactForces& forces, const GroundPlane& ground) {
  // A point of the plane.
  const Vector3d p_WO =
      ground.present ? Vector3d(ground.n_W * ground.offset) : Vector3d(0, 0, calc_mean_height(forces, ground));
  Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();
  for (const PairForce& pair : forces) {
    if (!is_ground_pair(pair, ground)) continue;
    force += pair.total.tail<3>();
    moment += pair.total.head<3>() + (pair.p_WR - p_WO).cross(Vector3d(pair.total.tail<3>()));
  }
  const double press = ground.n_W.dot(force);
  if (!(press >= kLeastPress)) return std::nullopt;
  return p_WO + ground.n_W.cross(moment) / press;
}

std::vector<Vector3d> calc_support_polygon(const ContactForces& forces, const GroundPlane& ground) {
  std::vector<Vector3d> points;
  for (const PairForce& pair : forces) {
    if (!is_ground_pair(pair, ground)) continue;
    for (const PointForce& point : pair.points) points.push_back(point.p_WC);
  }
  if (points.size() < 3) return {};
  std::sort(points.begin(), points.end(),
            [](const Vector3d& a, const Vector3d& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  std::vector<Vector3d> hull = walk_chain(points.begin(), points.end());
  const std::vector<Vector3d> back = walk_chain(points.rbegin(), points.rend());
  hull.insert(hull.end(), back.begin(), back.end());
  return hull;
}

}  // namespace hrp
