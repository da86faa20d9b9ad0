// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/trial/trial.h"

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"
#include "common/messages/convert.h"
#include "common/robot/closed_chains.h"
#include "common/robot/fall_watch.h"
#include "common/robot/movers.h"
#include "common/robot/world_text.h"
#include "controller/node.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp {
namespace {

double calc_lean(const State& state) {
  return std::acos(std::min(1.0, std::max(-1.0, (state.R_WB * Vector3d::UnitZ()).z())));
}

double calc_heading(const State& state) {
  const Vector3d x = state.R_WB * Vector3d::UnitX();
  return std::atan2(x.y(), x.x());
}

}  // namespace

Trial::Trial(const Scenario& scenario, const ControllerMaker& make_controller)
    : robot_(load_robot(scenario)),
      scenario_(adopt_loops(adopt_world(scenario, robot_.scenario), robot_.scenario)),
      world_(robot_, scenario_),
      engine_(std::make_unique<SimulatorEngine>(robot_, scenario_)) {
  for (const Mover& mover : make_robots(robot_, scenario_)) {
    const Robot robot = make_robot(mover.robot, mover.scenario);
    drivers_.push_back({robot, mover.name.empty() ? make_controller(robot) : make_scenario_controller(robot)});
  }
  start_controllers();
}

void Trial::start_controllers() {
  for (Driver& driver : drivers_) driver.controller->start(driver.robot);
}

void Trial::reset() {
  engine_->reset();
  pushes_.reset();
  step_ = 0;
  fault_.clear();
  start_controllers();
}

bool Trial::reset_to(const State& state) {
  if (!engine_->reset_to(state)) return false;
  pushes_.reset();
  step_ = 0;
  fault_.clear();
  start_controllers();
  return true;
}

TrialState Trial::save() const {
  TrialState state{engine_->simulator(), engine_->other_bodies(), {}, command_, pushes_, step_};
  for (const Driver& driver : drivers_) state.controllers.push_back(driver.controller->clone());
  return state;
}

void Trial::restore(const TrialState& kept) {
  engine_->restore(kept.simulator, kept.others);
  for (size_t k = 0; k < kept.controllers.size(); ++k) {
    if (kept.controllers[k]) drivers_[k].controller = kept.controllers[k]->clone();
  }
  command_ = kept.command;
  pushes_ = kept.pushes;
  step_ = kept.step;
  fault_.clear();
}

SensorData Trial::make_sensors(const SensorSample& sample) const {
  SensorData sensors;
  static_cast<SensorSample&>(sensors) = sample;
  sensors.time = time();
  sensors.step = static_cast<unsigned long long>(step_);
  return sensors;
}

void Trial::ask_controllers() {
  SensorData sensors = make_sensors(engine_->sensors());
  if (tamper) tamper(&sensors);
  command_ = drivers_[0].controller->control(sensors, drivers_[0].robot);
  for (size_t k = 1; k < drivers_.size(); ++k) {
    engine_->command_other(
        k - 1, drivers_[k].controller->control(make_sensors(engine_->other_sensors(k - 1)), drivers_[k].robot));
  }
}

void Trial::push(const std::string& link, const Vector3d& p_LQ, const Vector3d& force_W, uint64_t steps) {
  msg::Push push;
  push.link(link);
  push.p_LQ(to_message(p_LQ));
  push.force(to_message(force_W));
  push.steps(steps);
  const std::string fault = find_push_fault(push, robot_.tree, world_.movers());
  if (!fault.empty()) refuse_input({""}, fault);
  pushes_.add_from(static_cast<uint64_t>(step_), push);
}

bool Trial::step() {
  if (step_ % scenario_.control_period == 0) ask_controllers();
  if (!pushes_.empty()) engine_->push(pushes_.find(static_cast<uint64_t>(step_)));
  fault_ = engine_->step(world_.calc_contacts(engine_->state(), engine_->objects()), command_);
  if (fault_.empty()) ++step_;
  return fault_.empty();
}

TrialResult Trial::run(const std::function<void(const Trial&)>& on_step) {
  TrialResult result;
  const State begin = engine_->state();
  const long steps = std::lround(scenario_.duration / scenario_.time_step);
  std::vector<double> air(scenario_.feet.size(), 0.0);  // [s] since each foot left the ground
  result.landings.assign(scenario_.feet.size(), 0);
  double heading = calc_heading(begin);
  const Mover robot = make_robots(robot_, scenario_).front();
  FallWatch watch(robot.robot, robot.scenario);
  watch.reset(begin.R_WB, begin.p_WB);
  for (long k = 0; k < steps && (go_on_after_fall || !result.fallen); ++k) {
    if (!step()) break;
    if (on_step) on_step(*this);
    if (result.fallen) continue;
    const State& state = engine_->state();
    result.largest_lean = std::max(result.largest_lean, calc_lean(state));
    result.travelled = state.p_WB - begin.p_WB;
    if (watch.is_due(state.R_WB, state.p_WB)) {
      const auto event = watch.update(find_own_forces(engine_->contact_forces(), robot));
      result.fallen = event && event->fall;
    }
    if (result.fallen) result.fall_time = time();
    for (size_t i = 0; i < air.size(); ++i) {
      if (engine_->foot_forces()[i] > 0.0) {
        if (air[i] > 0.1) ++result.landings[i];
        air[i] = 0.0;
      } else {
        air[i] += scenario_.time_step;
      }
    }
    result.turned += std::remainder(calc_heading(state) - heading, 2.0 * M_PI);
    heading = calc_heading(state);
  }
  result.duration = time();
  result.fault = fault_;
  return result;
}

}  // namespace hrp
