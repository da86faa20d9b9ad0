// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/walk_brain.h"

#include <stdexcept>

#include "controller/node.h"
#include "controller/play.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::cases {
namespace {

Vector3d to_vector(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }

}  // namespace

struct WalkBrain::Impl {
  Robot robot;
  std::unique_ptr<Controller> controller;
  std::vector<int> index;  // of the caller's joints in the controller's
  SensorData sensors;
  unsigned long long step = 0;
};

WalkBrain::WalkBrain(const std::string& urdf, const std::string& text, const std::vector<std::string>& joints)
    : impl_(std::make_unique<Impl>()) {
  try {
    const Scenario scenario = parse_scenario(text, "walk.yaml");
    impl_->robot = make_robot(parse_robot(urdf, "robot.urdf", scenario), scenario);
    impl_->controller = make_scenario_controller(impl_->robot);
    impl_->controller->start(impl_->robot);
  } catch (const InputError& error) {
    throw std::runtime_error(std::string("the controller refuses the walk: ") + error.what());
  }
  for (const std::string& joint : joints) impl_->index.push_back(impl_->robot.find_joint(joint));
}

WalkBrain::~WalkBrain() = default;

void WalkBrain::control(const BrainInput& input, std::vector<double>* position) {
  Impl& i = *impl_;
  SensorData& s = i.sensors;
  s.time = input.time;
  s.step = i.step;
  i.step += 5;
  s.q.setZero(static_cast<long>(i.robot.joints.size()));
  for (size_t j = 0; j < i.index.size(); ++j) s.q[i.index[j]] = input.position[j];
  const auto& o = input.orientation;
  s.imus.assign(1, {});
  s.imus[0].R_WS = Eigen::Quaterniond(o[3], o[0], o[1], o[2]).normalized();
  s.imus[0].angular_velocity = to_vector(input.rate);
  s.imus[0].linear_acceleration = to_vector(input.acceleration);
  s.wrenches.assign(input.force.size(), {});
  for (size_t f = 0; f < input.force.size(); ++f) {
    s.wrenches[f].force = to_vector(input.force[f]);
    s.wrenches[f].torque = to_vector(input.torque[f]);
  }
  JointCommand command;
  try {
    command = i.controller->control(s, i.robot);
  } catch (const InputError& error) {
    throw std::runtime_error(std::string("the controller refuses the walk: ") + error.what());
  }
  position->resize(i.index.size());
  for (size_t j = 0; j < i.index.size(); ++j) (*position)[j] = command.q[i.index[j]];
}

}  // namespace hrp::cases
