// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/other_bodies.h"

#include <algorithm>
#include <utility>

#include "common/base/bit_hash.h"
#include "common/multibody/kinematics.h"
#include "servers/dynamics/disturbance.h"

namespace hrp {
namespace {

// A force at a corner of a free box turns it, too: the corner gives way like a mass 7 times smaller (1 + 3 + 3, from m,
// and from the two axes across the force). The explicit law must be stable for that one.
constexpr double kTurning = 7.0;

// The robot's tree with the links of all that moves as further ones. Their joints are never used: their places are
// written.
TreeSpec join_trees(const RobotDescription& robot, const std::vector<Mover>& movers) {
  TreeSpec tree = robot.tree;
  for (const Mover& mover : movers) {
    for (int i = 0; i < mover.num_bodies(); ++i) {
      LinkSpec link;
      link.name = mover.name_body(i);
      link.parent = 0;
      link.inertia = mover.robot.tree.links[static_cast<size_t>(i)].inertia;
      if (!mover.is_robot) link.inertia.mass /= kTurning;
      link.joint.name = link.name;
      link.joint.rotor_inertia = link.inertia.mass > 0.0 ? 0.0 : 1.0;  // lets in links that only join two joints
      tree.links.push_back(link);
    }
  }
  return tree;
}

ContactSpec make_law(ContactSpec contact) {
  contact.model = "spring_damper";
  return contact;
}

}  // namespace

OtherBodies::Moving OtherBodies::make_moving(const Mover& mover, int first_link) {
  const RobotDescription varied = vary_robot(mover.robot, mover.scenario);
  const Scenario scenario = vary_scenario(mover.robot, mover.scenario);
  Simulator simulator(varied, scenario);
  Pushes pushes(varied, scenario, simulator.state());
  Moving moving{
      mover.name, mover.is_robot, std::move(simulator), std::move(pushes), {}, {}, first_link, mover.num_bodies(), {}};
  moving.start = moving.simulator.state();
  moving.start.V_WB = mover.V_WB;
  return moving;
}

OtherBodies::OtherBodies(const RobotDescription& robot, const Scenario& scenario)
    : OtherBodies(robot, scenario, make_movers(robot, scenario)) {}

OtherBodies::OtherBodies(const RobotDescription& robot, const Scenario& scenario, const std::vector<Mover>& movers)
    : num_links_(static_cast<int>(robot.tree.links.size())),
      first_robot_(scenario.objects.size()),
      all_(join_trees(robot, movers), scenario.gravity_W),
      data_(all_),
      all_state_(make_state(all_)),
      law_(make_law(scenario.contact), all_),
      dt_(scenario.time_step) {
  int link = num_links_;
  for (const Mover& mover : movers) {
    movers_.push_back(make_moving(mover, link));
    link += mover.num_bodies();
  }
  wrenches_.resize(all_.spec().links.size(), Vector6d::Zero());
  reset();
}

void OtherBodies::reset() {
  for (Moving& moving : movers_) {
    if (!moving.simulator.reset(moving.start)) moving.simulator.reset();
    moving.pushes.let_go();
    moving.command = JointCommand();
    moving.command.q = moving.start.q;
  }
  law_.reset();
  report_.clear();
  forces_.clear();
  update_states();
}

PushForces OtherBodies::push(const PushForces& forces) {
  std::vector<PushForces> theirs(movers_.size());
  PushForces rest;
  for (const PushForce& force : forces) {
    PushForces* of = &rest;
    std::string link = force.link;
    for (size_t k = 0; k < movers_.size() && of == &rest; ++k) {
      const std::string own =
          find_own_link(force.link, movers_[k].name, movers_[k].is_robot, movers_[k].simulator.tree());
      if (!own.empty()) {
        of = &theirs[k];
        link = own;
      }
    }
    of->push_back(force);
    of->back().link = link;
  }
  for (size_t k = 0; k < movers_.size(); ++k) movers_[k].pushes.set_live(theirs[k]);
  return rest;
}

void OtherBodies::let_go() {
  for (Moving& moving : movers_) moving.pushes.let_go();
}

void OtherBodies::append_pushes(PushForces* forces) const {
  for (const Moving& moving : movers_) {
    for (PushForce force : moving.pushes.acting()) {
      const int link = moving.first_link + moving.simulator.tree().find_link(force.link);
      force.link = all_.spec().links[static_cast<size_t>(link)].name;
      forces->push_back(force);
    }
  }
}

void OtherBodies::update_states() {
  states_.resize(movers_.size());
  for (size_t k = 0; k < movers_.size(); ++k) states_[k] = movers_[k].simulator.state();
}

int OtherBodies::find_link(int body) const { return is_object(body) ? num_links_ + body - kFirstObject : body; }

int OtherBodies::find_body(int link) const { return link >= num_links_ ? make_object_index(link - num_links_) : link; }

OtherBodies::Moving* OtherBodies::find_moving(int body) {
  const int link = find_link(body);
  for (Moving& moving : movers_) {
    if (link >= moving.first_link && link < moving.first_link + moving.num_links) return &moving;
  }
  return nullptr;
}

void OtherBodies::split(const ContactSet& contacts) {
  robot_contacts_.clear();
  between_.clear();
  for (Moving& moving : movers_) moving.own.clear();
  for (const ContactPair& pair : contacts) {
    if (!is_object(pair.body_a) && !is_object(pair.body_b)) {
      robot_contacts_.push_back(pair);
      continue;
    }
    Moving* const a = is_object(pair.body_a) ? find_moving(pair.body_a) : nullptr;
    const bool own = a != nullptr && (pair.body_b < 0 || (is_object(pair.body_b) && find_moving(pair.body_b) == a));
    ContactSet& set = own ? a->own : between_;
    const int first = own ? a->first_link : 0;
    set.push_back(pair);
    set.back().body_a = find_link(pair.body_a) - first;
    if (pair.body_b >= 0) set.back().body_b = find_link(pair.body_b) - first;
  }
}

void OtherBodies::update_places(const State& robot) {
  all_state_.R_WB = robot.R_WB;
  all_state_.p_WB = robot.p_WB;
  all_state_.V_WB = robot.V_WB;
  all_state_.q.head(robot.q.size()) = robot.q;
  all_state_.qd.head(robot.qd.size()) = robot.qd;
  update_kinematics(all_, all_state_, &data_);
  for (const Moving& moving : movers_) {
    for (int i = 0; i < moving.num_links; ++i) {
      const LinkKinematics& from = moving.simulator.kinematics().kinematics[static_cast<size_t>(i)];
      LinkKinematics& to = data_.kinematics[static_cast<size_t>(moving.first_link) + static_cast<size_t>(i)];
      to.R = from.R;
      to.p = from.p;
      to.w = from.w;
      to.v = from.v;
    }
  }
}

const ExternalWrenches& OtherBodies::start(const ContactSet& contacts, const State& robot,
                                           const ExternalWrenches& pushes, std::string* fault) {
  split(contacts);
  update_places(robot);
  on_robot_ = pushes;
  int where = -1;
  if (const char* text = find_contact_fault(between_, all_.num_links(), &where)) {
    *fault = "contact of objects or other robots, pair " + std::to_string(where) + ": " + text;
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

std::string OtherBodies::step(Moving* moving) {
  on_mover_ = moving->pushes.find(moving->simulator.time(), moving->simulator.state());
  for (int link = 0; link < moving->num_links; ++link)
    on_mover_.push_back({link, wrenches_[static_cast<size_t>(moving->first_link) + static_cast<size_t>(link)]});
  const StepStatus status = moving->simulator.step(moving->own, moving->command, on_mover_);
  if (status == StepStatus::kOk) return "";
  return std::string(moving->is_robot ? "robot '" : "object '") + moving->name + "': " + get_step_status_text(status) +
         ": " + moving->simulator.fault_text();
}

std::string OtherBodies::finish(const ContactForces& on_robot) {
  for (Moving& moving : movers_) {
    std::string fault = step(&moving);
    if (!fault.empty()) return fault;
  }
  law_.accept();
  update_states();
  collect(on_robot);
  return "";
}

void OtherBodies::collect(const ContactForces& on_robot) {
  forces_ = on_robot;
  for (const PairForce& pair : report_.forces()) {
    forces_.push_back(pair);
    forces_.back().body_a = find_body(pair.body_a);
    forces_.back().body_b = find_body(pair.body_b);
  }
  for (const Moving& moving : movers_) {
    for (const PairForce& pair : moving.simulator.contact_forces()) {
      forces_.push_back(pair);
      forces_.back().body_a = find_body(moving.first_link + pair.body_a);
      if (pair.body_b >= 0) forces_.back().body_b = find_body(moving.first_link + pair.body_b);
    }
  }
  std::stable_sort(forces_.begin(), forces_.end(), [](const PairForce& a, const PairForce& b) {
    return a.body_a != b.body_a ? a.body_a < b.body_a : a.body_b < b.body_b;
  });
}

unsigned long long OtherBodies::calc_hash(unsigned long long robot) const {
  BitHash hash;
  hash.add(uint64_t{robot});
  for (const Moving& moving : movers_) hash.add(uint64_t{moving.simulator.state_hash()});
  for (const ContactAnchor& anchor : law_.anchors()) {
    for (int i = 0; i < 3; ++i) hash.add(anchor.p_A[i]);
    for (int i = 0; i < 3; ++i) hash.add(anchor.slip_B[i]);
  }
  return hash.get();
}

}  // namespace hrp
