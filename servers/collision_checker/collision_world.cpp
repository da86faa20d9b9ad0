// SPDX-License-Identifier: BSD-3-Clause
#include "servers/collision_checker/collision_world.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "servers/collision_checker/sole_contact.h"

namespace hrp {
namespace {

constexpr double kFallenMargin = 2e-3;  // [m]

// [m] A link beside a foot that is this near to the ground in the initial pose is there for good.
constexpr double kStandingClearance = 5e-3;

bool is_finite(const State& state) {
  return state.p_WB.allFinite() && state.R_WB.coeffs().allFinite() && state.q.allFinite();
}

CollisionShape make_obstacle_shape(const ObstacleSpec& obstacle) {
  CollisionShape shape;
  shape.name = obstacle.name;
  shape.size = obstacle.size;
  shape.kind = obstacle.shape == "sphere"     ? ShapeKind::kSphere
               : obstacle.shape == "cylinder" ? ShapeKind::kCylinder
                                              : ShapeKind::kBox;
  return shape;
}

bool has_solids(const Scenario& scenario) {
  return std::any_of(scenario.obstacles.begin(), scenario.obstacles.end(),
                     [](const ObstacleSpec& o) { return !o.is_surface(); });
}

bool are_neighbours(const TreeSpec& tree, int a, int b) {
  return tree.links[size_t(a)].parent == b || tree.links[size_t(b)].parent == a;
}

}  // namespace

CollisionWorld::CollisionWorld(const RobotDescription& robot, const Scenario& scenario)
    : robot_(robot),
      scenario_(scenario),
      model_(robot.tree, scenario.gravity_W),
      data_(model_),
      start_(make_start_state(robot, scenario)),
      ground_(make_ground_plane(scenario.ground)),
      movers_(make_movers(robot, scenario)),
      filter_(robot.tree, scenario, movers_),
      surfaces_(robot, scenario, filter_) {
  ground_.margin = scenario.contact.margin;
  if (scenario.ground.present) add_soles();
  if (scenario.ground.present && scenario.ground.all_touch && robot.tree.floating_base) add_falling_links();
  update_kinematics(model_, start_, &data_);
  surfaces_.leave_out_start(robot, data_);
  if (scenario.self_collision || has_solids(scenario) || !movers_.empty()) add_bodies();
  if (scenario.self_collision) add_self_pairs();
  add_movers();
}

void CollisionWorld::add_soles() {
  for (const Sole& sole : make_soles(robot_)) {
    if (filter_.may_touch(sole.link, kGround)) soles_.push_back(sole);
  }
}

void CollisionWorld::add_falling_links() {
  update_kinematics(model_, start_, &data_);
  const auto is_beside_foot = [&](int link) {
    return std::any_of(soles_.begin(), soles_.end(), [&](const Sole& sole) {
      return sole.link == link || are_neighbours(robot_.tree, sole.link, link);
    });
  };
  for (const FallingLink& link : make_falling_links(robot_)) {
    const int index = link.others.link;
    if (!filter_.may_touch(index, kGround)) continue;
    const bool stands =
        is_beside_foot(index) && calc_clearance(link.others, get_pose(data_, index), ground_) < kStandingClearance;
    if (!stands) falling_links_.push_back(link);
  }
  fallen_.reserve(falling_links_.size());
}

void CollisionWorld::add_bodies() {
  std::vector<CollisionShape> shapes = robot_.shapes;
  std::stable_sort(shapes.begin(), shapes.end(), [](const auto& a, const auto& b) { return a.link < b.link; });
  const auto add = [&](const CollisionShape& shape, int link, double friction) {
    Body body;
    body.link = link;
    body.shape = pairs_.add(shape);
    body.X_LG = shape.X_LG;
    body.radius = pairs_.get_radius(body.shape);
    body.friction = friction;
    bodies_.push_back(body);
  };
  for (const CollisionShape& shape : shapes) add(shape, shape.link, scenario_.ground.friction);
  num_robot_bodies_ = bodies_.size();
  for (size_t k = 0; k < scenario_.obstacles.size(); ++k) {
    const ObstacleSpec& obstacle = scenario_.obstacles[k];
    if (obstacle.is_surface()) continue;
    add(make_obstacle_shape(obstacle), make_obstacle_index(static_cast<int>(k)), obstacle.friction);
    Body& body = bodies_.back();
    body.X_WG = obstacle.X_WG;
    body.center_W = body.X_WG * pairs_.get_center(body.shape);
    for (size_t i = 0; i < num_robot_bodies_; ++i) {
      if (filter_.may_touch(bodies_[i].link, body.link))
        obstacle_pairs_.emplace_back(static_cast<int>(i), static_cast<int>(bodies_.size()) - 1);
    }
  }
  sort_pairs(&obstacle_pairs_);
}

// By body_a, then body_b: shapes of one pair of bodies stand together.
void CollisionWorld::sort_pairs(std::vector<std::pair<int, int>>* pairs) const {
  std::stable_sort(pairs->begin(), pairs->end(), [&](const auto& a, const auto& b) {
    const int link_a = bodies_[size_t(a.first)].link, link_b = bodies_[size_t(b.first)].link;
    return link_a != link_b ? link_a < link_b : bodies_[size_t(a.second)].link < bodies_[size_t(b.second)].link;
  });
}

// With ground, obstacles and itself each mover has a world of its own; here movers meet the robot and each other.
void CollisionWorld::add_movers() {
  first_mover_ = bodies_.size();
  for (const Mover& mover : movers_) {
    for (const CollisionShape& shape : mover.robot.shapes) add_mover_body(mover, shape);
    mover_worlds_.push_back(std::make_unique<CollisionWorld>(mover.robot, mover.scenario));
  }
  sort_pairs(&mover_pairs_);
}

void CollisionWorld::add_mover_body(const Mover& mover, const CollisionShape& shape) {
  Body body;
  body.link = mover.first_body + shape.link;
  body.shape = pairs_.add(shape);
  body.X_LG = shape.X_LG;
  body.radius = pairs_.get_radius(body.shape);
  body.friction = mover.friction;
  bodies_.push_back(body);
  const size_t last = bodies_.size() - 1;
  for (size_t i = 0; i < last; ++i) {
    const bool moves = i < num_robot_bodies_ || i >= first_mover_;
    if (moves && !mover.has(bodies_[i].link) && filter_.may_touch(bodies_[i].link, body.link)) {
      mover_pairs_.emplace_back(static_cast<int>(i), static_cast<int>(last));
    }
  }
}

void CollisionWorld::add_self_pairs() {
  update_poses(start_);
  std::set<std::pair<int, int>> overlapping;
  for (size_t i = 0; i < num_robot_bodies_; ++i) {
    for (size_t j = i + 1; j < num_robot_bodies_; ++j) {
      const Body &a = bodies_[i], &b = bodies_[j];
      if (a.link == b.link || are_neighbours(robot_.tree, a.link, b.link) || !filter_.may_touch(a.link, b.link))
        continue;
      self_pairs_.emplace_back(static_cast<int>(i), static_cast<int>(j));
      if (are_near(a, b) && pairs_.overlaps(a.shape, a.X_WG, b.shape, b.X_WG)) overlapping.insert({a.link, b.link});
    }
  }
  const auto is_excluded = [&](const std::pair<int, int>& pair) {
    return overlapping.count({bodies_[size_t(pair.first)].link, bodies_[size_t(pair.second)].link}) > 0;
  };
  self_pairs_.erase(std::remove_if(self_pairs_.begin(), self_pairs_.end(), is_excluded), self_pairs_.end());
  sort_pairs(&self_pairs_);
  for (const auto& [a, b] : overlapping) {
    excluded_.emplace_back(robot_.tree.links[size_t(a)].name, robot_.tree.links[size_t(b)].name);
  }
}

void CollisionWorld::update_poses(const State& state) {
  update_kinematics(model_, state, &data_);
  for (size_t i = 0; i < num_robot_bodies_; ++i) {
    Body& body = bodies_[i];
    body.X_WG = get_pose(data_, body.link) * body.X_LG;
    body.center_W = body.X_WG * pairs_.get_center(body.shape);
  }
}

// Bounding spheres. Over a fixed list of pairs this costs 1 to 2 ns a pair, less than a tree that must be updated.
bool CollisionWorld::are_near(const Body& a, const Body& b) const {
  const double reach = a.radius + b.radius;
  return (a.center_W - b.center_W).squaredNorm() < reach * reach;
}

ContactPair* CollisionWorld::open_pair(int body_a, int body_b) {
  if (spare_.empty()) {
    contacts_.emplace_back();
    contacts_.back().points.reserve(64);
  } else {
    contacts_.push_back(std::move(spare_.back()));
    spare_.pop_back();
  }
  ContactPair& pair = contacts_.back();
  pair.points.clear();
  pair.body_a = body_a;
  pair.body_b = body_b;
  return &pair;
}

void CollisionWorld::close_pair() {
  spare_.push_back(std::move(contacts_.back()));
  contacts_.pop_back();
}

// A robot that stands pays one distance a link for the possibility of falling.
void CollisionWorld::find_fallen_links() {
  fallen_.clear();
  // A margin of centimetres, as soft feet without soles of their own need, must not make feet of standing robots fallen
  // links.
  const double margin = std::min(ground_.margin, kFallenMargin);
  for (const FallingLink& link : falling_links_) {
    const Transform& X_WL = get_pose(data_, link.others.link);
    if (ground_.n_W.dot(X_WL * link.p_LC) - ground_.offset > link.radius + margin) continue;
    if (calc_clearance(link.others, X_WL, ground_) < margin) fallen_.push_back(&link.whole);
  }
}

void CollisionWorld::calc_ground_contact(const Sole& sole) {
  ContactPair* pair = open_pair(sole.link, kGround);
  pair->friction = scenario_.ground.friction;
  if (!calc_sole_contact(sole, get_pose(data_, sole.link), ground_, scenario_.max_sole_points, pair)) close_pair();
}

void CollisionWorld::calc_ground_contacts() {
  find_fallen_links();
  for (const Sole& sole : soles_) {
    const bool whole =
        std::any_of(fallen_.begin(), fallen_.end(), [&](const Sole* other) { return other->link == sole.link; });
    if (!whole) calc_ground_contact(sole);
  }
  for (const Sole* link : fallen_) calc_ground_contact(*link);
}

void CollisionWorld::calc_surface_contacts() {
  for (size_t i = 0; i < surfaces_.size(); ++i) {
    ContactPair* pair = open_pair(surfaces_.get_link(i), surfaces_.get_obstacle(i));
    if (!surfaces_.calc_contact(i, data_, pair)) close_pair();
  }
}

void CollisionWorld::calc_body_contacts(const std::vector<std::pair<int, int>>& pairs) {
  for (size_t i = 0; i < pairs.size();) {
    const int link_a = bodies_[size_t(pairs[i].first)].link, link_b = bodies_[size_t(pairs[i].second)].link;
    ContactPair* pair = nullptr;
    for (; i < pairs.size(); ++i) {
      const Body &a = bodies_[size_t(pairs[i].first)], &b = bodies_[size_t(pairs[i].second)];
      if (a.link != link_a || b.link != link_b) break;
      if (!are_near(a, b)) continue;
      if (pair == nullptr) pair = open_pair(link_a, link_b);
      pair->friction = is_object(link_b) ? std::min(a.friction, b.friction) : b.friction;
      pairs_.calc_contacts(a.shape, a.X_WG, b.shape, b.X_WG, scenario_.max_sole_points, &pair->points);
    }
    if (pair == nullptr) continue;
    if (pair->points.empty()) {
      close_pair();
      continue;
    }
    pair->p_WR.setZero();
    for (const ContactPoint& point : pair->points) pair->p_WR += point.p_WC / static_cast<double>(pair->points.size());
    update_separation(pair);
    reduce_points(get_rotation(link_a), pair->separation.normalized(), scenario_.max_sole_points, &pair->points);
  }
}

Transform CollisionWorld::get_mover_pose(int body) const {
  size_t k = 0;
  while (!movers_[k].has(body)) ++k;
  return get_pose(mover_worlds_[k]->data_, body - movers_[k].first_body);
}

Matrix3d CollisionWorld::get_rotation(int link) const {
  return is_object(link) ? get_mover_pose(link).R : get_pose(data_, link).R;
}

void CollisionWorld::update_mover_poses() {
  for (size_t i = first_mover_; i < bodies_.size(); ++i) {
    Body& body = bodies_[i];
    body.X_WG = get_mover_pose(body.link) * body.X_LG;
    body.center_W = body.X_WG * pairs_.get_center(body.shape);
  }
}

void CollisionWorld::calc_mover_contacts(const ObjectStates& states) {
  for (size_t k = 0; k < states.size(); ++k) {
    const int first = movers_[k].first_body;
    for (const ContactPair& found : mover_worlds_[k]->calc_contacts(states[k])) {
      const int body_a = first + found.body_a, body_b = found.body_b < 0 ? found.body_b : first + found.body_b;
      if (!filter_.may_touch(body_a, body_b)) continue;
      ContactPair* pair = open_pair(body_a, body_b);
      *pair = found;
      pair->body_a = body_a;
      pair->body_b = body_b;
    }
  }
  update_mover_poses();
  calc_body_contacts(mover_pairs_);
}

const ContactSet& CollisionWorld::calc_contacts(const State& state, const ObjectStates& objects) {
  while (!contacts_.empty()) close_pair();
  if (state.q.size() != model_.num_joints() || !is_finite(state)) return contacts_;
  update_poses(state);
  calc_ground_contacts();
  calc_surface_contacts();
  calc_body_contacts(obstacle_pairs_);
  calc_body_contacts(self_pairs_);
  if (!objects.empty() && objects.size() == mover_worlds_.size()) calc_mover_contacts(objects);
  std::sort(contacts_.begin(), contacts_.end(), [](const ContactPair& a, const ContactPair& b) {
    return a.body_a != b.body_a ? a.body_a < b.body_a : a.body_b < b.body_b;
  });
  return contacts_;
}

}  // namespace hrp
