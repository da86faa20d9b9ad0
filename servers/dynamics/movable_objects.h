// SPDX-License-Identifier: BSD-3-Clause
// The scenario's objects: each is a tree of one link with a simulator of its own, and so has the laws of the robot's links
// with ground and obstacles. What objects, and objects and robot, do to each other acts as link against link does
// (spring_contact.h): explicit, and exactly opposite on both.
#pragma once

#include <string>
#include <vector>

#include "servers/dynamics/simulator.h"
#include "servers/dynamics/spring_contact.h"

namespace hrp {

class MovableObjects {
 public:
  MovableObjects(const RobotDescription& robot, const Scenario& scenario);
  void reset();

  bool empty() const { return simulators_.empty(); }
  const ObjectStates& states() const { return states_; }

  // Forces in the state at the beginning of a step: returns those on the robot's links, with `pushes`. Empty when all is well,
  // else what is wrong with the contacts in `fault`.
  const ExternalWrenches& start(const ContactSet& contacts, const State& robot, const ExternalWrenches& pushes, std::string* fault);
  // The contacts that concern the robot and the fixed world alone.
  const ContactSet& robot_contacts() const { return robot_contacts_; }
  // Moves the objects. Empty when all went well, else which one failed, and why.
  std::string finish(const ContactForces& on_robot);
  // What acted over the last step, on robot and objects, in the order of the contacts.
  const ContactForces& contact_forces() const { return forces_; }
  // `robot`: the hash of the robot's state.
  unsigned long long calc_hash(unsigned long long robot) const;

 private:
  void split(const ContactSet& contacts);
  int find_link(int body) const;  // of the tree of all
  void update_states();
  void update_places(const State& robot);
  void collect(const ContactForces& on_robot);

  int num_links_ = 0;  // of the robot
  std::vector<std::string> names_;
  std::vector<Simulator> simulators_;
  ObjectStates starts_, states_;
  Model all_;          // robot and objects: where they are, and their masses
  Data data_;
  State all_state_;
  SpringContact law_;
  ContactReport report_;
  ContactSet robot_contacts_, between_;
  std::vector<ContactSet> own_;  // of each object with ground and obstacles
  LinkWrenches wrenches_;
  LinkImpedances impedances_;    // stay empty: link against link has none
  ExternalWrenches on_robot_, on_object_;
  ContactForces forces_;
  double dt_ = 0.0;
};

}  // namespace hrp
