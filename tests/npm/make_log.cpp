// SPDX-License-Identifier: BSD-3-Clause
// make_log FILE COMPRESSION: runs our logger over made-up messages of every logged type, for readers of other people.
#include <cstdio>
#include <limits>
#include <random>

#include "common/bus/memory/memory_bus.h"
#include "common/messages/pubsub.h"
#include "common/messages/topics.h"
#include "hrp_idl/collision.h"
#include "hrp_idl/control.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/model.h"
#include "servers/logger/node.h"

namespace hrp {
namespace {

constexpr uint64_t kSteps = 70;  // more than two chunks
constexpr uint64_t kPeriod = 5;

std::mt19937_64 g_random(11);
double draw() { return std::uniform_real_distribution<double>(-1e3, 1e3)(g_random); }
std::vector<double> draw_many(size_t n) {
  std::vector<double> values(n);
  for (double& value : values) value = draw();
  return values;
}
msg::Vector3 draw_vector() {
  msg::Vector3 v;
  v.x(draw());
  v.y(draw());
  v.z(draw());
  return v;
}
msg::Wrench3 draw_wrench() {
  msg::Wrench3 wrench;
  wrench.moment(draw_vector());
  wrench.force(draw_vector());
  return wrench;
}
msg::Pose draw_pose() {
  msg::Pose pose;
  pose.rotation().w(draw());
  pose.rotation().z(draw());
  pose.translation(draw_vector());
  return pose;
}
msg::Header make_header(uint64_t step) {
  msg::Header header;
  header.epoch(1);
  header.step(step);
  header.time(static_cast<double>(step) * 0.001);
  return header;
}

msg::RobotDescription make_description() {
  msg::RobotDescription robot;
  robot.name("made up: Grüße, \"quotes\"\n");
  robot.scenario_path("made_up.yaml");
  robot.scenario("robot: none.urdf\nsteps: {time_step: 0.001, control_period: 0.005}\n");
  robot.floating_base(true);
  for (int i = 0; i < 3; ++i) {
    msg::LinkDescription link;
    link.name("link" + std::to_string(i));
    link.parent(i - 1);
    link.mass(draw());
    link.inertia_LLcm_L({{draw(), draw(), draw(), draw(), draw(), draw()}});
    robot.links().push_back(link);
    msg::JointDescription joint;
    joint.name("joint" + std::to_string(i));
    joint.kind(i == 1 ? msg::JOINT_PRISMATIC : msg::JOINT_REVOLUTE);
    joint.X_PF(draw_pose());
    joint.lower(-std::numeric_limits<double>::infinity());
    joint.upper(draw());
    joint.actuated(i != 2);
    joint.mimic_joint(-1);
    robot.joints().push_back(joint);
  }
  robot.warnings({"first", "second"});
  return robot;
}

msg::ContactForces make_forces(uint64_t step) {
  msg::ContactForces forces;
  forces.header(make_header(step));
  for (uint64_t i = 0; i < step % 3; ++i) {
    msg::PairForce pair;
    pair.body_a(static_cast<int32_t>(i));
    pair.body_b(-1);
    pair.name_a("link" + std::to_string(i));
    pair.name_b("ground");
    pair.spring(draw_wrench());
    pair.total(draw_wrench());
    pair.clipped(i == 1);
    for (uint64_t k = 0; k <= i; ++k) {
      msg::PointForce point;
      point.p_WC(draw_vector());
      point.depth(draw());
      point.clipped(k == 1);
      point.total(draw_vector());
      pair.points().push_back(point);
    }
    forces.pairs().push_back(pair);
  }
  return forces;
}

msg::SensorData make_sensors(uint64_t step) {
  msg::SensorData sensors;
  sensors.header(make_header(step));
  sensors.positions(draw_many(3));
  sensors.velocities(draw_many(3));
  sensors.efforts(draw_many(3));
  msg::ImuSample imu;
  imu.name("chest");
  imu.angular_velocity(draw_vector());
  sensors.imus().push_back(imu);
  msg::WrenchSample wrench;
  wrench.name("l_foot");
  wrench.force(draw_vector());
  sensors.wrenches().push_back(wrench);
  if (step % 2 == 0) sensors.base_pose().push_back(draw_pose());
  return sensors;
}

template <typename Message>
void send(MemoryBus* bus, const TopicSpec& topic, const Message& message) {
  Publisher<Message> publisher(*bus, topic);
  publisher.publish(message);
  bus->dispatch_all();
}

void send_step(MemoryBus* bus, uint64_t step) {
  msg::RobotState state;
  state.header(make_header(step));
  state.X_WB(draw_pose());
  state.positions(draw_many(3));
  state.hash(g_random());
  send(bus, topics::kRobotState, state);
  send(bus, topics::kContactForces, make_forces(step));
  msg::ContactSet contacts;
  contacts.header(make_header(step));
  contacts.pairs().resize(step % 2);
  send(bus, topics::kContactSet, contacts);
  if (step % kPeriod != 0) return;
  send(bus, topics::kSensorData, make_sensors(step));
  msg::JointCommands commands;
  commands.header(make_header(step));
  commands.positions(draw_many(3));
  send(bus, topics::kJointCommands, commands);
}

int make_log(const std::string& path, const std::string& compression) {
  MemoryBus bus;
  LoggerNode logger({&bus, "logger", "hrp-logger", {}}, {path, compression});
  logger.make_endpoints();
  send(&bus, topics::kRobotDescription, make_description());
  for (uint64_t step = 0; step <= kSteps; ++step) send_step(&bus, step);
  while (logger.outcome() == NodeOutcome::kRunning) {
    logger.request_stop();
    bus.spin(std::chrono::milliseconds(10));
    logger.on_idle(std::chrono::steady_clock::now());
  }
  if (logger.outcome() == NodeOutcome::kFinished) return 0;
  std::fprintf(stderr, "%s\n", logger.failure().c_str());
  return 1;
}

}  // namespace
}  // namespace hrp

int main(int argc, char** argv) { return argc == 3 ? hrp::make_log(argv[1], argv[2]) : 2; }
