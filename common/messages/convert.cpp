// SPDX-License-Identifier: BSD-3-Clause
#include "common/messages/convert.h"

#include <array>
#include <cstring>

#include "common/base/check.h"
#include "common/messages/plain_numbers.h"
#include "common/robot/movers.h"

namespace hrp {
namespace {

// Structs of nothing but doubles, as one piece of memory: the generated accessors are a call for each number.
template <size_t count, typename Message>
void store(const double* numbers, Message* m) {
  static_assert(kIsPlainNumbers<Message, count>);
  std::memcpy(static_cast<void*>(m), numbers, sizeof(Message));
}

template <size_t count, typename Message>
std::array<double, count> load(const Message& m) {
  static_assert(kIsPlainNumbers<Message, count>);
  std::array<double, count> numbers;
  std::memcpy(numbers.data(), static_cast<const void*>(&m), sizeof(Message));
  return numbers;
}

void set(const Vector3d& v, msg::Vector3* m) { store<3>(v.data(), m); }

void set(const Eigen::Quaterniond& q, msg::Quaternion* m) {
  const double numbers[] = {q.w(), q.x(), q.y(), q.z()};
  store<4>(numbers, m);
}

void set(const Transform& X, msg::Pose* m) {
  set(Eigen::Quaterniond(X.R), &m->rotation());
  set(X.p, &m->translation());
}

// Angular part first, there and here.
void set(const Vector6d& V, msg::Twist* m) { store<6>(V.data(), m); }
void set(const Vector6d& F, msg::Wrench3* m) { store<6>(F.data(), m); }

void set(const Eigen::VectorXd& v, std::vector<double>* m) { m->assign(v.data(), v.data() + v.size()); }

void get(const std::vector<double>& m, Eigen::VectorXd* v) {
  *v = Eigen::Map<const Eigen::VectorXd>(m.data(), static_cast<Eigen::Index>(m.size()));
}

Vector6d get(const msg::Twist& m) { return Vector6d(load<6>(m).data()); }
Vector6d get(const msg::Wrench3& m) { return Vector6d(load<6>(m).data()); }

void set(const PointForce& point, msg::PointForce* m) {
  set(point.p_WC, &m->p_WC());
  set(point.n_BA_W, &m->n_BA_W());
  m->depth(point.depth);
  set(point.spring, &m->spring());
  set(point.damper, &m->damper());
  set(point.friction, &m->friction());
  set(point.total, &m->total());
  set(point.slip, &m->slip());
  m->clipped(point.clipped);
}

// Pose, velocity and joints of a RobotState or an OtherRobotState.
template <typename Message>
void set_state(const State& state, const Eigen::VectorXd& efforts, Message* m) {
  set(state.R_WB, &m->X_WB().rotation());
  set(state.p_WB, &m->X_WB().translation());
  set(state.V_WB, &m->V_WB());
  set(state.q, &m->positions());
  set(state.qd, &m->velocities());
  set(efforts, &m->efforts());
}

template <typename Message>
void get_state(const Message& m, State* state) {
  state->R_WB = from_message(m.X_WB().rotation());
  state->p_WB = from_message(m.X_WB().translation());
  state->V_WB = get(m.V_WB());
  get(m.positions(), &state->q);
  get(m.velocities(), &state->qd);
}

PointForce get(const msg::PointForce& m) {
  PointForce point;
  point.p_WC = from_message(m.p_WC());
  point.n_BA_W = from_message(m.n_BA_W());
  point.depth = m.depth();
  point.spring = from_message(m.spring());
  point.damper = from_message(m.damper());
  point.friction = from_message(m.friction());
  point.total = from_message(m.total());
  point.slip = from_message(m.slip());
  point.clipped = m.clipped();
  return point;
}

}  // namespace

BodyNames::BodyNames(const RobotDescription& robot, const Scenario& scenario) {
  for (const LinkSpec& link : robot.tree.links) links_.push_back(link.name);
  others_.push_back("ground");
  for (const ObstacleSpec& obstacle : scenario.obstacles) others_.push_back(obstacle.name);
  for (const Mover& mover : make_movers(robot, scenario)) {
    for (int link = 0; link < mover.num_bodies(); ++link) objects_.push_back(mover.name_body(link));
  }
}

bool BodyNames::contains(int body) const {
  if (is_object(body)) return static_cast<size_t>(body - kFirstObject) < objects_.size();
  return body >= 0 ? static_cast<size_t>(body) < links_.size() : static_cast<size_t>(-1 - body) < others_.size();
}

const std::string& BodyNames::get(int body) const {
  HRP_CHECK(contains(body), "body " << body << ", " << links_.size() << " links, " << others_.size() << " others");
  if (is_object(body)) return objects_[static_cast<size_t>(body - kFirstObject)];
  return body >= 0 ? links_[static_cast<size_t>(body)] : others_[static_cast<size_t>(-1 - body)];
}

msg::Vector3 to_message(const Vector3d& v) {
  msg::Vector3 m;
  set(v, &m);
  return m;
}

msg::Quaternion to_message(const Eigen::Quaterniond& q) {
  msg::Quaternion m;
  set(q, &m);
  return m;
}

msg::Pose to_message(const Transform& X) {
  msg::Pose m;
  set(X, &m);
  return m;
}

Vector3d from_message(const msg::Vector3& v) { return Vector3d(load<3>(v).data()); }

Eigen::Quaterniond from_message(const msg::Quaternion& q) {
  const auto [w, x, y, z] = load<4>(q);
  return {w, x, y, z};
}

Transform from_message(const msg::Pose& pose) {
  return {from_message(pose.rotation()).toRotationMatrix(), from_message(pose.translation())};
}

void to_message(const State& state, const Eigen::VectorXd& efforts, unsigned long long hash, msg::RobotState* message) {
  set_state(state, efforts, message);
  message->hash(hash);
}

void from_message(const msg::RobotState& message, State* state) { get_state(message, state); }

void to_message(const ObjectStates& states, const std::vector<Eigen::VectorXd>& efforts, const Scenario& scenario,
                msg::RobotState* message) {
  const size_t objects = scenario.objects.size(), robots = scenario.robots.size();
  HRP_CHECK(states.empty() || (states.size() == objects + robots && efforts.size() == robots),
            states.size() << " states, " << objects << " objects, " << robots << " robots");
  message->objects().resize(states.empty() ? 0 : objects);
  for (size_t i = 0; i < message->objects().size(); ++i) {
    msg::ObjectState& m = message->objects()[i];
    m.name() = scenario.objects[i].name;
    set(states[i].R_WB, &m.X_WO().rotation());
    set(states[i].p_WB, &m.X_WO().translation());
    set(states[i].V_WB, &m.V_WO());
  }
  message->robots().resize(states.empty() ? 0 : robots);
  for (size_t i = 0; i < message->robots().size(); ++i) {
    message->robots()[i].name() = scenario.robots[i].name;
    set_state(states[objects + i], efforts[i], &message->robots()[i]);
  }
}

void from_message(const msg::RobotState& message, ObjectStates* states) {
  const size_t objects = message.objects().size();
  states->resize(objects + message.robots().size());
  for (size_t i = 0; i < objects; ++i) {
    const msg::ObjectState& m = message.objects()[i];
    (*states)[i].R_WB = from_message(m.X_WO().rotation());
    (*states)[i].p_WB = from_message(m.X_WO().translation());
    (*states)[i].V_WB = get(m.V_WO());
  }
  for (size_t i = 0; i < message.robots().size(); ++i) get_state(message.robots()[i], &(*states)[objects + i]);
}

void to_message(const PushForces& pushes, msg::RobotState* message) {
  message->pushes().resize(pushes.size());
  for (size_t i = 0; i < pushes.size(); ++i) {
    msg::PushForce& m = message->pushes()[i];
    m.name() = pushes[i].name;
    m.link() = pushes[i].link;
    set(pushes[i].p_LQ, &m.p_LQ());
    set(pushes[i].force_W, &m.force());
  }
}

void from_message(const msg::RobotState& message, PushForces* pushes) {
  pushes->clear();
  for (const msg::PushForce& m : message.pushes())
    pushes->push_back({m.name(), m.link(), from_message(m.p_LQ()), from_message(m.force())});
}

void to_message(const ContactSet& contacts, const BodyNames& names, msg::ContactSet* message) {
  message->pairs().resize(contacts.size());
  for (size_t i = 0; i < contacts.size(); ++i) {
    const ContactPair& pair = contacts[i];
    msg::ContactPair& m = message->pairs()[i];
    m.body_a(pair.body_a);
    m.body_b(pair.body_b);
    m.name_a() = names.get(pair.body_a);
    m.name_b() = names.get(pair.body_b);
    m.points().resize(pair.points.size());
    for (size_t j = 0; j < pair.points.size(); ++j) {
      set(pair.points[j].p_WC, &m.points()[j].p_WC());
      set(pair.points[j].n_BA_W, &m.points()[j].n_BA_W());
      m.points()[j].depth(pair.points[j].depth);
    }
    set(pair.separation, &m.separation());
    set(pair.separation_turn, &m.separation_turn());
    set(pair.p_WR, &m.reference());
    m.friction(pair.friction);
  }
}

void from_message(const msg::ContactSet& message, ContactSet* contacts) {
  contacts->resize(message.pairs().size());
  for (size_t i = 0; i < contacts->size(); ++i) {
    const msg::ContactPair& m = message.pairs()[i];
    ContactPair& pair = (*contacts)[i];
    pair.body_a = m.body_a();
    pair.body_b = m.body_b();
    pair.points.resize(m.points().size());
    for (size_t j = 0; j < pair.points.size(); ++j) {
      pair.points[j].p_WC = from_message(m.points()[j].p_WC());
      pair.points[j].n_BA_W = from_message(m.points()[j].n_BA_W());
      pair.points[j].depth = m.points()[j].depth();
    }
    pair.separation = from_message(m.separation());
    pair.separation_turn = from_message(m.separation_turn());
    pair.p_WR = from_message(m.reference());
    pair.friction = m.friction();
  }
}

void to_message(const ContactForces& forces, const BodyNames& names, msg::ContactForces* message) {
  message->pairs().resize(forces.size());
  for (size_t i = 0; i < forces.size(); ++i) {
    const PairForce& pair = forces[i];
    msg::PairForce& m = message->pairs()[i];
    m.body_a(pair.body_a);
    m.body_b(pair.body_b);
    m.name_a() = names.get(pair.body_a);
    m.name_b() = names.get(pair.body_b);
    set(pair.p_WR, &m.reference());
    set(pair.spring, &m.spring());
    set(pair.damper, &m.damper());
    set(pair.friction, &m.friction());
    set(pair.total, &m.total());
    m.clipped(pair.clipped);
    m.points().resize(pair.points.size());
    for (size_t j = 0; j < pair.points.size(); ++j) set(pair.points[j], &m.points()[j]);
  }
}

void from_message(const msg::ContactForces& message, ContactForces* forces) {
  forces->resize(message.pairs().size());
  for (size_t i = 0; i < forces->size(); ++i) {
    const msg::PairForce& m = message.pairs()[i];
    PairForce& pair = (*forces)[i];
    pair.body_a = m.body_a();
    pair.body_b = m.body_b();
    pair.p_WR = from_message(m.reference());
    pair.spring = get(m.spring());
    pair.damper = get(m.damper());
    pair.friction = get(m.friction());
    pair.total = get(m.total());
    pair.clipped = m.clipped();
    pair.points.resize(m.points().size());
    for (size_t j = 0; j < pair.points.size(); ++j) pair.points[j] = get(m.points()[j]);
  }
}

void to_message(const SensorSample& sample, const SensorsSpec& sensors, msg::SensorData* message) {
  HRP_CHECK(sample.imus.size() == sensors.imus.size() && sample.wrenches.size() == sensors.wrenches.size(),
            sample.imus.size() << " of " << sensors.imus.size() << " IMUs, " << sample.wrenches.size() << " of "
                               << sensors.wrenches.size() << " wrench sensors");
  set(sample.q, &message->positions());
  set(sample.qd, &message->velocities());
  set(sample.effort, &message->efforts());
  message->imus().resize(sample.imus.size());
  for (size_t i = 0; i < sample.imus.size(); ++i) {
    msg::ImuSample& m = message->imus()[i];
    m.name() = sensors.imus[i].name;
    set(sample.imus[i].R_WS, &m.orientation());
    set(sample.imus[i].angular_velocity, &m.angular_velocity());
    set(sample.imus[i].linear_acceleration, &m.linear_acceleration());
  }
  message->wrenches().resize(sample.wrenches.size());
  for (size_t i = 0; i < sample.wrenches.size(); ++i) {
    msg::WrenchSample& m = message->wrenches()[i];
    m.name() = sensors.wrenches[i].name;
    set(sample.wrenches[i].force, &m.force());
    set(sample.wrenches[i].torque, &m.torque());
  }
  message->base_pose().resize(sample.has_base_pose ? 1 : 0);
  message->base_twist().resize(sample.has_base_pose ? 1 : 0);
  if (sample.has_base_pose) {
    set(sample.X_WB, &message->base_pose()[0]);
    set(sample.V_WB, &message->base_twist()[0]);
  }
}

void from_message(const msg::SensorData& message, SensorSample* sample) {
  get(message.positions(), &sample->q);
  get(message.velocities(), &sample->qd);
  get(message.efforts(), &sample->effort);
  sample->imus.resize(message.imus().size());
  for (size_t i = 0; i < sample->imus.size(); ++i) {
    sample->imus[i].R_WS = from_message(message.imus()[i].orientation());
    sample->imus[i].angular_velocity = from_message(message.imus()[i].angular_velocity());
    sample->imus[i].linear_acceleration = from_message(message.imus()[i].linear_acceleration());
  }
  sample->wrenches.resize(message.wrenches().size());
  for (size_t i = 0; i < sample->wrenches.size(); ++i) {
    sample->wrenches[i].force = from_message(message.wrenches()[i].force());
    sample->wrenches[i].torque = from_message(message.wrenches()[i].torque());
  }
  sample->has_base_pose = !message.base_pose().empty() && !message.base_twist().empty();
  if (sample->has_base_pose) {
    sample->X_WB = from_message(message.base_pose()[0]);
    sample->V_WB = get(message.base_twist()[0]);
  }
}

void to_message(const JointCommand& command, msg::JointCommands* message) {
  set(command.q, &message->positions());
  set(command.qd, &message->velocities());
  set(command.effort, &message->efforts());
}

void from_message(const msg::JointCommands& message, JointCommand* command) {
  get(message.positions(), &command->q);
  get(message.velocities(), &command->qd);
  get(message.efforts(), &command->effort);
}

void to_message(const FallEvent& event, msg::RobotEvent* message) {
  message->kind(event.fall ? msg::EVENT_FALL : msg::EVENT_TOUCH);
  message->text(event.text);
  message->links(event.links);
  message->tilt(event.tilt);
  message->height(event.height);
}

}  // namespace hrp
