// SPDX-License-Identifier: BSD-3-Clause
#include "servers/collision_checker/surface_world.h"

#include <algorithm>

#include "common/base/diagnostics.h"
#include "servers/collision_checker/sole_contact.h"

namespace hrp {
namespace {

const Surface& find_surface(const RobotDescription& robot, const ObstacleSpec& obstacle, const Scenario& scenario) {
  for (const auto& surface : robot.surfaces) {
    if (surface->obstacle == obstacle.name) return *surface;
  }
  throw InputError(
      scenario.make_diagnostic("obstacles." + obstacle.name, "the robot's description lacks this surface"));
}

// Reference point of a link [m, link axes]: that of its soles where it has some.
Vector3d find_reference(int link, const std::vector<Sole>& soles, const std::vector<FallingLink>& others) {
  for (const Sole& sole : soles) {
    if (sole.link == link) return sole.p_LR;
  }
  for (const FallingLink& other : others) {
    if (other.others.link == link) return other.whole.p_LR;
  }
  return Vector3d::Zero();
}

bool is_beside_foot(const TreeSpec& tree, const std::vector<Sole>& soles, int link) {
  return std::any_of(soles.begin(), soles.end(), [&](const Sole& sole) {
    return sole.link == link || tree.links[size_t(link)].parent == sole.link ||
           tree.links[size_t(sole.link)].parent == link;
  });
}

}  // namespace

SurfaceWorld::SurfaceWorld(const RobotDescription& robot, const Scenario& scenario, const ContactFilter& filter)
    : max_points_(scenario.max_sole_points) {
  add_places(robot, scenario);
  if (!places_.empty()) add_couples(robot, scenario.contact.margin, filter);
}

void SurfaceWorld::add_places(const RobotDescription& robot, const Scenario& scenario) {
  for (size_t k = 0; k < scenario.obstacles.size(); ++k) {
    const ObstacleSpec& obstacle = scenario.obstacles[k];
    if (!obstacle.is_surface()) continue;
    places_.push_back({std::make_unique<SurfaceMesh>(find_surface(robot, obstacle, scenario)), obstacle.X_WG,
                       make_obstacle_index(static_cast<int>(k)), obstacle.friction});
  }
}

void SurfaceWorld::add_couples(const RobotDescription& robot, double margin, const ContactFilter& filter) {
  const std::vector<Sole> soles = make_soles(robot);
  const std::vector<FallingLink> others = make_falling_links(robot);
  for (int link = 0; link < static_cast<int>(robot.tree.links.size()); ++link) {
    std::vector<Part> parts;
    const Vector3d p_LR = find_reference(link, soles, others);
    for (const CollisionShape& shape : robot.shapes) {
      if (shape.link == link) parts.push_back({make_touching_shape(shape, p_LR, margin), 0, shape.sole});
    }
    for (size_t k = 0; k < places_.size() && !parts.empty(); ++k) {
      if (!filter.may_touch(link, places_[k].obstacle)) continue;
      for (Part& part : parts) part.query = places_[k].mesh->add_query(2.0 * part.shape.half);
      couples_.push_back({link, places_[k].obstacle, k, p_LR, parts});
    }
  }
}

void SurfaceWorld::calc_part(const Couple& couple, const Part& part, const Data& data) {
  Place& place = places_[couple.place];
  const Transform X_GL = place.X_WG.inverse() * get_pose(data, couple.link);
  place.mesh->find_faces({X_GL * part.shape.X_LB, part.shape.half, part.query}, &faces_);
  if (!faces_.empty()) calc_surface_contact(*place.mesh, faces_, part.shape, X_GL, &points_);
}

void SurfaceWorld::leave_out_start(const RobotDescription& robot, const Data& start) {
  const std::vector<Sole> soles = couples_.empty() ? std::vector<Sole>() : make_soles(robot);
  for (Couple& couple : couples_) {
    if (!is_beside_foot(robot.tree, soles, couple.link)) continue;
    const auto reaches_in = [&](const Part& part) {
      points_.clear();
      if (!part.sole) calc_part(couple, part, start);
      return !points_.empty();
    };
    couple.parts.erase(std::remove_if(couple.parts.begin(), couple.parts.end(), reaches_in), couple.parts.end());
  }
}

bool SurfaceWorld::calc_contact(size_t i, const Data& data, ContactPair* pair) {
  const Couple& couple = couples_[i];
  points_.clear();
  for (const Part& part : couple.parts) calc_part(couple, part, data);
  if (points_.empty()) return false;
  const Place& place = places_[couple.place];
  const Transform& X_WL = get_pose(data, couple.link);
  for (const ContactPoint& point : points_) {
    pair->points.push_back({place.X_WG * point.p_WC, place.X_WG.R * point.n_BA_W, point.depth});
  }
  pair->friction = place.friction;
  pair->p_WR = X_WL * couple.p_LR;
  update_separation(pair);  // of the whole patch
  reduce_by_normal(X_WL.R, max_points_, &pair->points);
  return true;
}

}  // namespace hrp
