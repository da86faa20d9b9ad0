// SPDX-License-Identifier: BSD-3-Clause
// Everything that moves beside the robot, and all robots of a run: the scenario's objects, then its other robots. An
// object is a robot of one link, so that everything that is known of robots and the world holds for both.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/state.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "common/robot/signals.h"

namespace hrp {

struct Mover {
  std::string name;
  bool is_robot = false;
  RobotDescription robot;
  Scenario scenario;                 // the world as this mover meets it, without other movers
  double friction = 0.8;             // of its bodies: where two bodies meet, the smaller one counts
  Vector6d V_WB = Vector6d::Zero();  // [rad/s; m/s] of its base at step 0
  int first_body = kFirstObject;     // body index of its base; its other links follow. 0 of the first robot

  int num_bodies() const { return static_cast<int>(robot.tree.links.size()); }
  bool has(int body) const { return body >= first_body && body < first_body + num_bodies(); }
  // "crate" of an object, "partner/L_ANKLE_R_LINK" of a robot's link.
  std::string name_body(int link) const;
};

// The link of a mover, or its frame, that `body` names as name_body() does; "" when it names none.
std::string find_own_link(const std::string& body, const std::string& mover, bool is_robot, const TreeSpec& tree);

// True when `body` can only mean an object or another robot of the scenario, whether it has such a link or not.
bool names_mover(const Scenario& scenario, const std::string& body);

// In the order of their bodies, each with the scenario's pushes on it. Throws InputError: a scenario of another robot
// that is no scenario, or that does not go with this one (another time step or control period, cameras).
std::vector<Mover> make_movers(const RobotDescription& robot, const Scenario& scenario);

// Names of the scenario's other robots.
std::vector<std::string> list_robots(const Scenario& scenario);

// All robots of a run, the first one, whose name is empty, before the scenario's others. Throws as make_movers() does.
std::vector<Mover> make_robots(const RobotDescription& robot, const Scenario& scenario);
// The same from movers that are there already.
std::vector<Mover> make_robots(const RobotDescription& robot, const Scenario& scenario,
                               const std::vector<Mover>& movers);

// Where the state of the k-th of these robots stands: `first` is that of robot 0.
const State& find_robot_state(size_t k, const State& first, const ObjectStates& others, const Scenario& scenario);

// What acts on the links of one of these robots, which then have its own indices, as if it were alone: every other body
// that moves is kFirstObject.
ContactForces find_own_forces(const ContactForces& forces, const Mover& robot);

// "" when there is a state for each mover with as many joints as it has, else how many there are and were expected.
std::string find_wrong_states(const std::vector<Mover>& movers, const std::vector<State>& states);

// The scenario of another robot with the world of `world`, and its start pose where `placement` says.
Scenario place_in_world(const Scenario& own, const RobotPlacement& placement, const Scenario& world);

}  // namespace hrp
