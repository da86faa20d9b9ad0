// SPDX-License-Identifier: BSD-3-Clause
// What of a robot touches the ground, obstacles and itself: the core of the collision checker.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/multibody/kinematics.h"
#include "common/robot/movers.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "common/robot/signals.h"
#include "common/robot/sole.h"
#include "servers/collision_checker/contact_filter.h"
#include "servers/collision_checker/shape_pairs.h"
#include "servers/collision_checker/surface_world.h"

namespace hrp {

// Soles touch the ground, and so does every other shape of a robot with a floating base, unless the scenario says
// `ground: {touch: feet}`. Links beside a foot that reach into the ground in the initial pose already, such as an ankle
// whose geometry is longer than the sole is deep, never do. Every shape touches obstacles; with `self_collision` links
// touch each other, except pairs of neighbours in the tree and pairs that overlap in the initial pose already. Objects
// and other robots (movers.h) touch everything. What stands in `no_contact` never touches.
class CollisionWorld {
 public:
  // Throws InputError: meshes that cannot be read, trees that cannot be computed with.
  CollisionWorld(const RobotDescription& robot, const Scenario& scenario);

  // Contacts of this state, ordered by body_a, then body_b (obstacles before the ground before links, as their numbers
  // are). The result lives until the next call; its memory is reused. A state that is not finite touches nothing.
  // `objects`: of all movers, in their order.
  const ContactSet& calc_contacts(const State& state, const ObjectStates& objects = {});

  // Links that never collide although they are no neighbours, because they overlap in the initial pose; by name.
  const std::vector<std::pair<std::string, std::string>>& excluded_pairs() const { return excluded_; }
  const std::vector<Mover>& movers() const { return movers_; }
  // The state at step 0 (sole.h).
  const State& start_state() const { return start_; }

 private:
  struct Body {
    int link = 0;  // body index as in ContactPair
    int shape = 0;
    Transform X_LG;
    Transform X_WG;
    Vector3d center_W = Vector3d::Zero();
    double radius = 0.0;
    double friction = 0.0;
  };
  void add_soles();
  void add_bodies();
  void add_self_pairs();
  void add_movers();
  void add_mover_body(const Mover& mover, const CollisionShape& shape);
  void sort_pairs(std::vector<std::pair<int, int>>* pairs) const;
  void update_mover_poses();
  void calc_mover_contacts(const ObjectStates& states);
  Transform get_mover_pose(int body) const;
  Matrix3d get_rotation(int link) const;
  void update_poses(const State& state);
  bool are_near(const Body& a, const Body& b) const;
  ContactPair* open_pair(int body_a, int body_b);
  void close_pair();
  void add_falling_links();
  void find_fallen_links();
  void calc_ground_contact(const Sole& sole);
  void calc_ground_contacts();
  void calc_surface_contacts();
  void calc_body_contacts(const std::vector<std::pair<int, int>>& pairs);

  RobotDescription robot_;
  Scenario scenario_;
  Model model_;
  Data data_;
  State start_;
  GroundPlane ground_;
  std::vector<Sole> soles_;
  std::vector<FallingLink> falling_links_;
  std::vector<const Sole*> fallen_;  // what else touches the ground in this state
  std::vector<Mover> movers_;
  ContactFilter filter_;
  SurfaceWorld surfaces_;
  ShapePairs pairs_;
  std::vector<Body> bodies_;  // shapes of the robot, by link, then obstacles
  size_t num_robot_bodies_ = 0;
  std::vector<std::pair<int, int>> obstacle_pairs_, self_pairs_, mover_pairs_;  // ordered by links
  std::vector<std::pair<std::string, std::string>> excluded_;
  size_t first_mover_ = 0;                                     // of bodies_; those of movers are the last
  std::vector<std::unique_ptr<CollisionWorld>> mover_worlds_;  // each mover with ground, obstacles and itself
  ContactSet contacts_;
  ContactSet spare_;  // pairs whose memory waits to be used again
};

}  // namespace hrp
