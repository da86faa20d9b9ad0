// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/movable_objects.h"

#include <algorithm>

#include "common/base/bit_hash.h"
#include "common/multibody/kinematics.h"
#include "common/robot/object_tree.h"

namespace hrp {
namespace {

// A force at a corner of a free box turns it, too: the corner gives way like a mass 7 times smaller (1 + 3 + 3, from m, and
// from the two axes across the force). The explicit law must be stable for that one.
constexpr double kTurning = 7.0;

// The robot's tree with the objects as further links. Their joints are never used: their places are written.
TreeSpec join_trees(const RobotDescription& robot, const Scenario& scenario) {
  TreeSpec tree = robot.tree;
  for (const ObjectSpec& object : scenario.objects) {
    LinkSpec link;
    link.name = object.name;
    link.parent = 0;
    link.inertia = calc_object_inertia(object);
    link.inertia.mass /= kTurning;
    link.joint.name = object.name;
    tree.links.push_back(link);
  }
  return tree;
}

ContactSpec make_law(ContactSpec contact) {
  contact.model = "spring_damper";
  return contact;
}

}  // namespace

MovableObjects::MovableObjects(const RobotDescription& robot, const Scenario& scenario)
    : num_links_(static_cast<int>(robot.tree.links.size())), all_(join_trees(robot, scenario), scenario.gravity_W), data_(all_),
      all_state_(make_state(all_)), law_(make_law(scenario.contact), all_), dt_(scenario.time_step) {
  for (const ObjectSpec& object : scenario.objects) {
    names_.push_back(object.name);
    simulators_.emplace_back(make_object_robot(object, robot), make_object_scenario(object, scenario));
    State start = simulators_.back().state();
    start.V_WB = object.V_WO;
    starts_.push_back(start);
  }
  own_.resize(simulators_.size());
  wrenches_.resize(all_.spec().links.size(), Vector6d::Zero());
  reset();
}

void MovableObjects::reset() {
  for (size_t k = 0; k < simulators_.size(); ++k) {
    if (!simulators_[k].reset(starts_[k])) simulators_[k].reset();
  }
  law_.reset();
  report_.clear();
  forces_.clear();
  update_states();
}

void MovableObjects::update_states() {
  states_.resize(simulators_.size());
  for (size_t k = 0; k < simulators_.size(); ++k) states_[k] = simulators_[k].state();
}

int MovableObjects::find_link(int body) const { return is_object(body) ? num_links_ + body - kFirstObject : body; }

void MovableObjects::split(const ContactSet& contacts) {
  robot_contacts_.clear();
  between_.clear();
  for (ContactSet& set : own_) set.clear();
  for (const ContactPair& pair : contacts) {
    const bool object_a = is_object(pair.body_a), object_b = is_object(pair.body_b);
    if (!object_a && !object_b) {
      robot_contacts_.push_back(pair);
    } else if (object_a && pair.body_b < 0) {
      ContactSet& own = own_[static_cast<size_t>(pair.body_a - kFirstObject)];
      own.push_back(pair);
      own.back().body_a = 0;
    } else {
      between_.push_back(pair);
      between_.back().body_a = find_link(pair.body_a);
      between_.back().body_b = find_link(pair.body_b);
    }
  }
}

void MovableObjects::update_places(const State& robot) {
  all_state_.R_WB = robot.R_WB;
  all_state_.p_WB = robot.p_WB;
  all_state_.V_WB = robot.V_WB;
  all_state_.q.head(robot.q.size()) = robot.q;
  all_state_.qd.head(robot.qd.size()) = robot.qd;
  update_kinematics(all_, all_state_, &data_);
  for (size_t k = 0; k < states_.size(); ++k) {
    LinkKinematics& at = data_.kinematics[static_cast<size_t>(num_links_) + k];
    at.R = small::from_eigen(states_[k].X_WB().R);
    at.p = small::from_eigen(states_[k].p_WB);
    at.w = small::from_eigen(Vector3d(states_[k].V_WB.head<3>()));
    at.v = small::from_eigen(Vector3d(states_[k].V_WB.tail<3>()));
  }
}

const ExternalWrenches& MovableObjects::start(const ContactSet& contacts, const State& robot, const ExternalWrenches& pushes,
                                              std::string* fault) {
  split(contacts);
  update_places(robot);
  on_robot_ = pushes;
  int where = -1;
  if (const char* text = find_contact_fault(between_, num_links_ + static_cast<int>(states_.size()), &where)) {
    *fault = "contact of objects, pair " + std::to_string(where) + ": " + text;
    return on_robot_;
  }
  law_.start(between_, all_, data_, dt_, dt_);
  for (Vector6d& F : wrenches_) F.setZero();
  law_.add(data_, &wrenches_, &impedances_);
  report_.start(between_);
  law_.finish(data_, &report_);
  for (int link = 0; link < num_links_; ++link) {
    const Vector6d& F = wrenches_[static_cast<size_t>(link)];
    if (!F.isZero(0.0)) on_robot_.push_back({link, F});
  }
  return on_robot_;
}

std::string MovableObjects::finish(const ContactForces& on_robot) {
  for (size_t k = 0; k < simulators_.size(); ++k) {
    on_object_.assign(1, {0, wrenches_[static_cast<size_t>(num_links_) + k]});
    const StepStatus status = simulators_[k].step(own_[k], JointCommand(), on_object_);
    if (status != StepStatus::kOk) {
      return "object '" + names_[k] + "': " + get_step_status_text(status) + ": " + simulators_[k].fault_text();
    }
  }
  law_.accept();
  update_states();
  collect(on_robot);
  return "";
}

void MovableObjects::collect(const ContactForces& on_robot) {
  forces_ = on_robot;
  const auto get_body = [&](int link) { return link >= num_links_ ? make_object_index(link - num_links_) : link; };
  for (const PairForce& pair : report_.forces()) {
    forces_.push_back(pair);
    forces_.back().body_a = get_body(pair.body_a);
    forces_.back().body_b = get_body(pair.body_b);
  }
  for (size_t k = 0; k < simulators_.size(); ++k) {
    for (const PairForce& pair : simulators_[k].contact_forces()) {
      forces_.push_back(pair);
      forces_.back().body_a = make_object_index(static_cast<int>(k));
    }
  }
  std::stable_sort(forces_.begin(), forces_.end(), [](const PairForce& a, const PairForce& b) {
    return a.body_a != b.body_a ? a.body_a < b.body_a : a.body_b < b.body_b;
  });
}

unsigned long long MovableObjects::calc_hash(unsigned long long robot) const {
  BitHash hash;
  hash.add(uint64_t{robot});
  for (const Simulator& simulator : simulators_) hash.add(uint64_t{simulator.state_hash()});
  for (const ContactAnchor& anchor : law_.anchors()) {
    for (int i = 0; i < 3; ++i) hash.add(anchor.p_A[i]);
    for (int i = 0; i < 3; ++i) hash.add(anchor.slip_B[i]);
  }
  return hash.get();
}

}  // namespace hrp
