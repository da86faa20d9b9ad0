// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/trial/trial.h"

#include <algorithm>
#include <cmath>

#include "common/robot/closed_chains.h"
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
    : robot_(load_robot(scenario)), scenario_(adopt_loops(adopt_world(scenario, robot_.scenario), robot_.scenario)), world_(robot_, scenario_),
      engine_(std::make_unique<SimulatorEngine>(robot_, scenario_)), controlled_(make_robot(robot_, scenario_)),
      controller_(make_controller(controlled_)) {
  controller_->start(controlled_);
}

void Trial::reset() {
  engine_->reset();
  step_ = 0;
  fault_.clear();
  controller_->start(controlled_);
}

bool Trial::reset_to(const State& state) {
  if (!engine_->reset_to(state)) return false;
  step_ = 0;
  fault_.clear();
  controller_->start(controlled_);
  return true;
}

TrialState Trial::save() const { return {engine_->simulator(), engine_->movable_objects(), controller_->clone(), command_, step_}; }

void Trial::restore(const TrialState& kept) {
  engine_->restore(kept.simulator, kept.objects);
  if (kept.controller) controller_ = kept.controller->clone();
  command_ = kept.command;
  step_ = kept.step;
  fault_.clear();
}

void Trial::ask_controller() {
  SensorData sensors;
  static_cast<SensorSample&>(sensors) = engine_->sensors();
  sensors.time = time();
  sensors.step = static_cast<unsigned long long>(step_);
  if (tamper) tamper(&sensors);
  command_ = controller_->control(sensors, controlled_);
}

bool Trial::step() {
  if (step_ % scenario_.control_period == 0) ask_controller();
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
  for (long k = 0; k < steps && (go_on_after_fall || !result.fallen); ++k) {
    if (!step()) break;
    if (on_step) on_step(*this);
    if (result.fallen) continue;
    const State& state = engine_->state();
    const double lean = calc_lean(state);
    result.largest_lean = std::max(result.largest_lean, lean);
    result.travelled = state.p_WB - begin.p_WB;
    result.fallen = lean > 1.0 || state.p_WB.z() - scenario_.ground.height < 0.5 * begin.p_WB.z();
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
