// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/contact_work.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace hrp {
namespace {

constexpr double kCoupledShare = 0.25;  // explicit stability of link against link: k dt^2 and c dt over the mass
constexpr size_t kReservedPairs = 64;
constexpr size_t kReservedPointsPerPair = 16;

const ContactPoint& get_point(const ContactSet& contacts, PointIndex i) {
  return contacts[static_cast<size_t>(i.pair)].points[static_cast<size_t>(i.point)];
}

bool comes_before(const ContactSet& contacts, PointIndex i, PointIndex j) {
  const ContactPair &a = contacts[static_cast<size_t>(i.pair)], &b = contacts[static_cast<size_t>(j.pair)];
  const Vector3d &p = get_point(contacts, i).p_WC, &q = get_point(contacts, j).p_WC;
  return std::tie(a.body_a, a.body_b, p.x(), p.y(), p.z()) < std::tie(b.body_a, b.body_b, q.x(), q.y(), q.z());
}

const char* find_point_fault(const ContactPoint& point) {
  if (!point.p_WC.allFinite() || !std::isfinite(point.depth)) return "a point is not finite";
  if (!(std::abs(point.n_BA_W.squaredNorm() - 1.0) < 1e-6)) return "a normal is not a unit vector";
  return nullptr;
}

const char* find_pair_fault(const ContactPair& pair, int num_links) {
  if (pair.body_a < 0 || pair.body_a >= num_links) return "body A is no link";
  if (pair.body_b >= num_links || pair.body_b == pair.body_a) return "body B is unknown or the same as body A";
  if (!(pair.friction >= 0.0) || !std::isfinite(pair.friction)) return "friction is negative or not finite";
  if (!pair.p_WR.allFinite()) return "the reference point is not finite";
  for (const ContactPoint& point : pair.points) {
    if (const char* fault = find_point_fault(point)) return fault;
  }
  return nullptr;
}

void add_wrench(const Vector3d& r, const Vector3d& f, Vector6d* F) {
  F->head<3>() += r.cross(f);
  F->tail<3>() += f;
}

}  // namespace

void sort_contact_points(const ContactSet& contacts, std::vector<PointIndex>* order) {
  order->clear();
  for (size_t i = 0; i < contacts.size(); ++i) {
    for (size_t j = 0; j < contacts[i].points.size(); ++j) order->push_back({static_cast<int>(i), static_cast<int>(j)});
  }
  // Insertion sort where a handful is nearly in order; std::sort beyond.
  const auto before = [&](PointIndex a, PointIndex b) { return comes_before(contacts, a, b); };
  if (!std::is_sorted(order->begin(), order->end(), before)) std::sort(order->begin(), order->end(), before);
}

const char* find_contact_fault(const ContactSet& contacts, int num_links, int* pair) {
  if (contacts.size() > kMaxContactPairs) return "more pairs than there is room for";
  size_t points = 0;
  for (size_t i = 0; i < contacts.size(); ++i) {
    *pair = static_cast<int>(i);
    points += contacts[i].points.size();
    if (points > kMaxContactPoints) return "more points than there is room for";
    if (const char* fault = find_pair_fault(contacts[i], num_links)) return fault;
  }
  return nullptr;
}

Transform get_body_pose(const Data& data, int body) {
  if (body < 0) return {};
  const LinkKinematics& k = data.kinematics[static_cast<size_t>(body)];
  return {small::to_eigen(k.R), small::to_eigen(k.p)};
}

Vector3d calc_body_point_velocity(const Data& data, int body, const Vector3d& p_WC) {
  if (body < 0) return Vector3d::Zero();
  const LinkKinematics& k = data.kinematics[static_cast<size_t>(body)];
  return small::to_eigen(k.v) + small::to_eigen(k.w).cross(p_WC - small::to_eigen(k.p));
}

double calc_coupled_mass(const Model& model, int body_a, int body_b) {
  const double a = model.links()[static_cast<size_t>(body_a)].mass;
  const double b = model.links()[static_cast<size_t>(body_b)].mass;
  return kCoupledShare * a * b / std::max(a + b, 1e-9);
}

ContactReport::ContactReport() {
  forces_.reserve(kMaxContactPairs);
  spare_.resize(kReservedPairs);
  spare_.reserve(kMaxContactPairs);
  for (PairForce& pair : spare_) pair.points.reserve(kReservedPointsPerPair);
}

void ContactReport::resize(size_t pairs) {
  while (forces_.size() > pairs) {
    spare_.push_back(std::move(forces_.back()));
    forces_.pop_back();
  }
  while (forces_.size() < pairs) {
    if (spare_.empty()) spare_.emplace_back();
    forces_.push_back(std::move(spare_.back()));
    spare_.pop_back();
  }
}

void ContactReport::clear() { resize(0); }

void ContactReport::start(const ContactSet& contacts) {
  resize(contacts.size());
  for (size_t i = 0; i < contacts.size(); ++i) {
    const ContactPair& pair = contacts[i];
    PairForce& force = forces_[i];
    force.body_a = pair.body_a;
    force.body_b = pair.body_b;
    force.p_WR = pair.p_WR;
    force.points.resize(pair.points.size());
    for (size_t j = 0; j < pair.points.size(); ++j) {
      force.points[j] = PointForce{};
      force.points[j].p_WC = pair.points[j].p_WC;
      force.points[j].n_BA_W = pair.points[j].n_BA_W;
      force.points[j].depth = pair.points[j].depth;
    }
  }
}

void ContactReport::finish() {
  for (PairForce& pair : forces_) {
    pair.spring = pair.damper = pair.friction = Vector6d::Zero();
    pair.clipped = false;
    for (PointForce& point : pair.points) {
      point.total = point.spring + point.damper + point.friction;
      const Vector3d r = point.p_WC - pair.p_WR;
      add_wrench(r, point.spring, &pair.spring);
      add_wrench(r, point.damper, &pair.damper);
      add_wrench(r, point.friction, &pair.friction);
      pair.clipped = pair.clipped || point.clipped;
    }
    pair.total = pair.spring + pair.damper + pair.friction;
  }
}

}  // namespace hrp
