// SPDX-License-Identifier: BSD-3-Clause
// What moves beside the robot (movers.h): objects and other robots. Each has a simulator of its own, and so the laws of
// the robot's links with ground, obstacles and itself. What they do to each other and to the robot acts as link against
// link does (spring_contact.h): explicit, and exactly opposite on both.
#pragma once

#include <string>
#include <vector>

#include "common/robot/movers.h"
#include "common/robot/pushes.h"
#include "servers/dynamics/simulator.h"
#include "servers/dynamics/spring_contact.h"

namespace hrp {

class OtherBodies {
 public:
  OtherBodies(const RobotDescription& robot, const Scenario& scenario);
  void reset();

  bool empty() const { return movers_.empty(); }
  // Objects, then other robots.
  const ObjectStates& states() const { return states_; }
  size_t num_robots() const { return movers_.size() - first_robot_; }
  // `k`: of the other robots, in the order of the scenario. A command holds until the next one; at first the start pose
  // is held.
  const Simulator& robot(size_t k) const { return movers_[first_robot_ + k].simulator; }
  void command(size_t k, const JointCommand& command) { movers_[first_robot_ + k].command = command; }

  // Sets the live pushes of all; returns those that are not theirs.
  PushForces push(const PushForces& forces);
  void let_go();
  // Appends what pushed them over the last step, with names of bodies as Mover::name_body().
  void append_pushes(PushForces* forces) const;

  // Forces in the state at the beginning of a step: returns those on the robot's links, with `pushes`. Empty when all
  // is well, else what is wrong with the contacts in `fault`.
  const ExternalWrenches& start(const ContactSet& contacts, const State& robot, const ExternalWrenches& pushes,
                                std::string* fault);
  // The contacts that concern the robot and the fixed world alone.
  const ContactSet& robot_contacts() const { return robot_contacts_; }
  // Moves them. Empty when all went well, else which one failed, and why.
  std::string finish(const ContactForces& on_robot);
  // What acted over the last step, on all that moves, in the order of the contacts.
  const ContactForces& contact_forces() const { return forces_; }
  // `robot`: the hash of the robot's state.
  unsigned long long calc_hash(unsigned long long robot) const;

 private:
  struct Moving {
    std::string name;
    bool is_robot = false;
    Simulator simulator;
    Pushes pushes;
    State start;
    JointCommand command;
    int first_link = 0;  // of the tree of all
    int num_links = 0;
    ContactSet own;  // with ground, obstacles and itself; its links count from 0
  };

  OtherBodies(const RobotDescription& robot, const Scenario& scenario, const std::vector<Mover>& movers);
  static Moving make_moving(const Mover& mover, int first_link);
  void split(const ContactSet& contacts);
  Moving* find_moving(int body);
  int find_link(int body) const;  // of the tree of all
  int find_body(int link) const;  // the other way round
  void update_states();
  void update_places(const State& robot);
  std::string step(Moving* moving);
  void collect(const ContactForces& on_robot);

  int num_links_ = 0;  // of the robot
  std::vector<Moving> movers_;
  size_t first_robot_ = 0;  // of movers_
  ObjectStates states_;
  Model all_;  // robot, objects and other robots: where they are, and their masses
  Data data_;
  State all_state_;
  SpringContact law_;
  ContactReport report_;
  ContactSet robot_contacts_, between_;
  LinkWrenches wrenches_;
  LinkImpedances impedances_;  // stay empty: link against link has none
  ExternalWrenches on_robot_, on_mover_;
  ContactForces forces_;
  double dt_ = 0.0;
};

}  // namespace hrp
