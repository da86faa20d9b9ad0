// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/simulator.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/base/bit_hash.h"
#include "common/base/diagnostics.h"
#include "common/multibody/close_loops.h"
#include "common/multibody/kinematics.h"
#include "common/robot/closed_chains.h"
#include "servers/dynamics/joint_effects.h"
#include "servers/dynamics/simulator_impl.h"

namespace hrp {
namespace {

constexpr double kLargest = 1e12;  // anything beyond is no state of a robot: overflow is on its way

Integrator parse_integrator(const std::string& name) {
  if (name == "rk4") return Integrator::kRungeKutta4;
  return name == "semi_implicit_euler" ? Integrator::kSemiImplicitEuler : Integrator::kImplicit;
}

std::vector<double> get_delays(const std::vector<JointLaws>& laws) {
  std::vector<double> delays;
  for (const JointLaws& law : laws) delays.push_back(law.command_delay);
  return delays;
}

ImpulseOptions make_impulse_options(const ContactSpec& contact) {
  ImpulseOptions options;
  options.restitution = contact.restitution;
  return options;
}

void check_scenario(const Scenario& scenario) {
  if (!(scenario.time_step > 0.0) || !(scenario.time_step <= 0.1))
    refuse_input({"", "time_step"}, "must be in (0, 0.1] s");
  if (scenario.control_period < 1) refuse_input({"", "control_period"}, "must be at least 1 step");
  if (scenario.contact.shared_points < 1) refuse_input({"", "contact.shared_points"}, "must be at least 1");
  if (!(scenario.contact.stiffness > 0.0)) refuse_input({"", "contact.stiffness"}, "must be positive");
  if (!(scenario.contact.exponent >= 1.0)) refuse_input({"", "contact.exponent"}, "must be at least 1");
  if (!(scenario.contact.alpha >= 0.0)) refuse_input({"", "contact.alpha"}, "must not be negative");
  if (scenario.contact.model == "impulse" && scenario.integrator != "implicit") {
    refuse_input({"", "integrator"}, "impulse contacts go with the implicit step only");
  }
  if (scenario.contact.model == "wrench" && scenario.integrator != "implicit") {
    refuse_input({"", "integrator"}, "contacts by wrenches of pairs go with the implicit step only");
  }
  if (scenario.integrator == "rk4" && (scenario.perfect_joints || scenario.drive == "motion")) {
    refuse_input({"", "integrator"}, "joints that follow their references exactly do not go with rk4: use implicit");
  }
  for (const auto& [foot, bush] : scenario.foot_bush) {
    const bool positive = bush.kz > 0.0 && bush.k_roll > 0.0 && bush.k_pitch > 0.0;
    if (scenario.contact.model == "wrench" && !positive)
      refuse_input({"", "foot_bush." + foot}, "kz, k_roll and k_pitch must be positive");
  }
}

// Index of the foot that each link belongs to: the foot's link and everything below it.
std::vector<int> find_feet(const TreeSpec& tree, const std::vector<std::string>& feet) {
  std::vector<int> foot_of_link(tree.links.size(), -1);
  for (size_t i = 0; i < feet.size(); ++i) {
    const int frame = tree.find_frame(feet[i]);
    const int link = frame >= 0 ? tree.frames[static_cast<size_t>(frame)].link : tree.find_link(feet[i]);
    if (link < 0) refuse_input({"", "feet"}, "the robot has no link '" + feet[i] + "'");
    foot_of_link[static_cast<size_t>(link)] = static_cast<int>(i);
  }
  for (size_t i = 1; i < tree.links.size(); ++i) {
    const int above = foot_of_link[static_cast<size_t>(tree.links[i].parent)];
    if (foot_of_link[i] < 0) foot_of_link[i] = above;
  }
  return foot_of_link;
}

}  // namespace

const char* get_step_status_text(StepStatus status) {
  switch (status) {
    case StepStatus::kOk: return "ok";
    case StepStatus::kBadCommand: return "bad command";
    case StepStatus::kBadContact: return "bad contact set";
    case StepStatus::kBadForce: return "bad external wrench";
    case StepStatus::kNonFiniteState: return "the state would not be finite";
    case StepStatus::kSingular: return "an inertia is not positive";
  }
  return "unknown";
}

Simulator::Impl::Impl(const RobotDescription& robot, const Scenario& given, TreeSpec tree,
                      const std::vector<JointLaws>& laws, std::vector<SteadyForce> forces)
    : scenario(given),
      model(tree, given.gravity_W),
      data(model),
      start(make_initial_state(robot, given)),
      state(start),
      next(start),
      stage(start),
      integrator(parse_integrator(given.integrator)),
      impulse(given.contact.model == "impulse"),
      by_pair(given.contact.model == "wrench"),
      dt(given.time_step),
      reference(parse_interpolation(given.interpolation), given.control_period, given.time_step, get_delays(laws)),
      joints(model, given, laws),
      spring(given.contact, model),
      rigid(make_impulse_options(given.contact), model),
      wrench(given, model),
      sensors(model, given),
      steady_forces(std::move(forces)),
      loops(model, find_loops(tree, given)),
      foot_of_link(find_feet(tree, given.feet)),
      foot_forces(given.feet.size(), 0.0) {
  const Eigen::Index n = model.num_joints(), nv = model.nv();
  wrenches.resize(tree.links.size(), Vector6d::Zero());
  push_wrenches = wrenches;
  impedances.reserve(tree.links.size());
  loaded.resize(tree.links.size());
  for (auto* vector : {&effort, &inertia_extra, &joint_efforts, &servo_efforts}) vector->setZero(n);
  for (auto* vector : {&vdot, &v, &v_end, &v_free}) vector->setZero(nv);
  stage_v.assign(6, Eigen::VectorXd::Zero(nv));
  stage_a.assign(4, Eigen::VectorXd::Zero(nv));
  loop_forces.setZero(nv);
  encoders.q = encoders.qd = encoders.effort = Eigen::VectorXd::Zero(n);
  fault.reserve(256);
}

void Simulator::Impl::reset(const State& from) {
  state = next = stage = from;
  step = 0;
  joints.reset(model, state, &data);
  reference.reset(state.q);
  spring.reset();
  report.clear();
  joint_efforts.setZero();
  servo_efforts.setZero();
  std::fill(foot_forces.begin(), foot_forces.end(), 0.0);
  update_kinematics(model, state, &data);
  update_encoders();
  sensors.reset(state, data, encoders);
  fault.clear();
}

StepStatus Simulator::Impl::fail(StepStatus status, const std::string& text) {
  fault = text;
  return status;
}

StepStatus Simulator::Impl::convert(Status status) {
  if (status == Status::kOk) return StepStatus::kOk;
  const std::string at = "step " + std::to_string(step) + ": ";
  if (status == Status::kSingular) return fail(StepStatus::kSingular, at + "an articulated inertia is not positive");
  for (int i = 0; i < model.num_joints(); ++i) {
    if (std::isfinite(vdot[model.num_base() + i])) continue;
    return fail(StepStatus::kNonFiniteState, at + "acceleration of joint '" + model.spec().joint(i).name + "'");
  }
  return fail(StepStatus::kNonFiniteState, at + "acceleration of the base");
}

StepStatus Simulator::Impl::check_inputs(const ContactSet& contacts, const JointCommand& command,
                                         const ExternalWrenches& pushes) {
  int where = -1;
  if (const char* text = Reference::find_fault(command, model.num_joints(), &where)) {
    const std::string name = where >= 0 ? "joint '" + model.spec().joint(where).name + "': " : "";
    return fail(StepStatus::kBadCommand, name + text);
  }
  if (const char* text = find_contact_fault(contacts, model.num_links(), &where)) {
    return fail(StepStatus::kBadContact, "contact pair " + std::to_string(where) + ": " + text);
  }
  start_pushes();
  for (const ExternalWrench& push : pushes) {
    if (push.link < 0 || push.link >= model.num_links() || !push.F_W.allFinite()) {
      return fail(StepStatus::kBadForce, "external wrench on link " + std::to_string(push.link));
    }
    push_wrenches[static_cast<size_t>(push.link)] += push.F_W;
  }
  return StepStatus::kOk;
}

void Simulator::Impl::start_pushes() {
  for (Vector6d& F : push_wrenches) F.setZero();
  for (const SteadyForce& force : steady_forces) {
    const Vector3d arm = get_pose(data, force.link).R * force.p_LQ;
    Vector6d& F = push_wrenches[static_cast<size_t>(force.link)];
    F.head<3>() += arm.cross(force.force_W);
    F.tail<3>() += force.force_W;
  }
}

StepStatus Simulator::Impl::advance(const ContactSet& contacts) {
  if (impulse) return advance_impulse(contacts);
  if (integrator == Integrator::kSemiImplicitEuler) return advance_euler(contacts);
  if (integrator == Integrator::kRungeKutta4) return advance_runge_kutta(contacts);
  return advance_implicit(contacts);
}

StepStatus Simulator::Impl::check_result() {
  const auto bad = [](double x) { return !(std::abs(x) <= kLargest); };
  if (!(next.p_WB.cwiseAbs().maxCoeff() <= kLargest) || !(next.V_WB.cwiseAbs().maxCoeff() <= kLargest) ||
      !next.R_WB.coeffs().allFinite()) {
    return fail(StepStatus::kNonFiniteState, "step " + std::to_string(step) + ": the base's state");
  }
  for (int i = 0; i < model.num_joints(); ++i) {
    const DriveMemory& memory = joints.next_memories()[static_cast<size_t>(i)];
    if (!bad(next.q[i]) && !bad(next.qd[i]) && !bad(memory.motor_q) && !bad(memory.motor_v) &&
        !bad(memory.lag_effort)) {
      continue;
    }
    return fail(StepStatus::kNonFiniteState,
                "step " + std::to_string(step) + ": state of joint '" + model.spec().joint(i).name + "'");
  }
  return StepStatus::kOk;
}

void Simulator::Impl::update_foot_forces() {
  std::fill(foot_forces.begin(), foot_forces.end(), 0.0);
  const auto add = [&](int body, double force) {
    if (body < 0 || foot_of_link[static_cast<size_t>(body)] < 0) return;
    foot_forces[static_cast<size_t>(foot_of_link[static_cast<size_t>(body)])] += force;
  };
  for (const PairForce& pair : report.forces()) {
    add(pair.body_a, pair.total[5]);
    add(pair.body_b, -pair.total[5]);
  }
}

bool Simulator::Impl::sensors_due() const {
  return sensors.needs_every_step() || (step + 1) % scenario.control_period == 0;
}

// Wrenches on links as they acted: pushes and reported contact forces.
void Simulator::Impl::update_sensors() {
  std::copy(push_wrenches.begin(), push_wrenches.end(), wrenches.begin());
  for (const PairForce& pair : report.forces()) {
    wrenches[static_cast<size_t>(pair.body_a)] += calc_wrench_about_origin(data, pair.body_a, pair.p_WR, pair.total);
    if (pair.body_b < 0) continue;
    wrenches[static_cast<size_t>(pair.body_b)] -= calc_wrench_about_origin(data, pair.body_b, pair.p_WR, pair.total);
  }
  v_free = (v_end - v) / dt;
  sensors.update_forces(model, v_free, wrenches, &data);
}

void Simulator::Impl::update_encoders() {
  for (int i = 0; i < model.num_joints(); ++i) {
    const JointLaws& laws = joints.laws()[static_cast<size_t>(i)];
    const DriveMemory& memory = joints.memories()[static_cast<size_t>(i)];
    encoders.q[i] = (laws.elastic ? memory.motor_q : state.q[i]) + laws.joint_offset;
    encoders.qd[i] = laws.elastic ? memory.motor_v : state.qd[i];
    encoders.effort[i] = servo_efforts[i];
  }
}

void Simulator::Impl::accept() {
  const bool due = sensors_due();
  if (due) update_sensors();
  std::swap(state, next);
  joints.accept();
  if (!impulse && !by_pair) spring.accept();
  reference.finish_step();
  ++step;
  update_kinematics(model, state, &data);
  update_foot_forces();
  if (!due) return;
  update_encoders();
  sensors.update_readings(state, data, encoders, static_cast<unsigned long long>(step));
}

// Each loop is closed in the initial pose.
void Simulator::Impl::check_loops() const {
  const std::vector<LoopGap> gaps = calc_gaps(model, find_loops(model.spec(), scenario), state);
  for (size_t i = 0; i < gaps.size(); ++i) {
    if (gaps[i].length < kOpenLoop && gaps[i].angle < kOpenLoop) continue;
    char text[160];
    std::snprintf(text, sizeof text,
                  "is open by %.3g mm and %.3g mrad in the initial pose, expected at most 5 mm and 5 mrad",
                  1e3 * gaps[i].length, 1e3 * gaps[i].angle);
    throw InputError(scenario.make_diagnostic("loops." + scenario.loops[i].name, text));
  }
}

Simulator::Simulator(const RobotDescription& robot, const Scenario& scenario) {
  check_scenario(scenario);
  TreeSpec tree = robot.tree;
  tree.floating_base = scenario.floating_base && tree.floating_base;
  std::vector<SteadyForce> forces = apply_link_laws(scenario, &tree);
  const std::vector<JointLaws> laws = make_joint_laws(scenario, &tree);
  impl_ = std::make_unique<Impl>(robot, scenario, tree, laws, std::move(forces));
  reset();
  impl_->check_loops();
}

Simulator::~Simulator() = default;
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;
Simulator::Simulator(const Simulator& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
Simulator& Simulator::operator=(const Simulator& other) {
  *impl_ = *other.impl_;
  return *this;
}

void Simulator::reset() { impl_->reset(impl_->start); }

bool Simulator::reset(const State& state) {
  const bool fits = state.q.size() == impl_->model.num_joints() && state.qd.size() == impl_->model.num_joints() &&
                    state.q.allFinite() && state.qd.allFinite() && state.p_WB.allFinite() && state.V_WB.allFinite() &&
                    std::abs(state.R_WB.norm() - 1.0) < 1e-6;
  if (fits) impl_->reset(state);
  return fits;
}

StepStatus Simulator::step(const ContactSet& contacts, const JointCommand& command, const ExternalWrenches& pushes) {
  Impl& impl = *impl_;
  impl.fault.clear();
  StepStatus status = impl.check_inputs(contacts, command, pushes);
  if (status != StepStatus::kOk) return status;
  impl.reference.start_step(impl.step, command);
  status = impl.advance(contacts);
  if (status == StepStatus::kOk) status = impl.check_result();
  if (status == StepStatus::kOk) {
    impl.accept();
  } else {
    update_kinematics(impl.model, impl.state, &impl.data);
  }
  return status;
}

const State& Simulator::state() const { return impl_->state; }
const Data& Simulator::kinematics() const { return impl_->data; }
long Simulator::step_number() const { return impl_->step; }
double Simulator::time() const { return static_cast<double>(impl_->step) * impl_->dt; }
double Simulator::time_step() const { return impl_->dt; }
const std::string& Simulator::fault_text() const { return impl_->fault; }
const ContactForces& Simulator::contact_forces() const { return impl_->report.forces(); }
const Eigen::VectorXd& Simulator::joint_efforts() const { return impl_->joint_efforts; }
const Eigen::VectorXd& Simulator::servo_efforts() const { return impl_->servo_efforts; }
const std::vector<double>& Simulator::foot_forces() const { return impl_->foot_forces; }
const SensorSample& Simulator::sensors() const { return impl_->sensors.sample(); }
int Simulator::solves() const { return impl_->solves; }
const TreeSpec& Simulator::tree() const { return impl_->model.spec(); }

unsigned long long Simulator::state_hash() const {
  BitHash hash;
  hash.add(uint64_t{calc_state_hash(impl_->state)});
  hash.add(static_cast<uint64_t>(impl_->step));
  for (const DriveMemory& memory : impl_->joints.memories()) {
    for (double x : {memory.motor_q, memory.motor_v, memory.lag_effort, memory.hysteresis}) hash.add(x);
    if (memory.bend != 0.0) hash.add(memory.bend);  // runs without it keep their hashes
  }
  impl_->reference.visit_memory([&](double x) { hash.add(x); });
  for (const ContactAnchor& anchor : impl_->spring.anchors()) {
    hash.add(static_cast<uint64_t>(anchor.body_a) << 32 | static_cast<uint32_t>(anchor.body_b));
    for (int i = 0; i < 3; ++i) hash.add(anchor.p_A[i]);
    for (int i = 0; i < 3; ++i) hash.add(anchor.slip_B[i]);
  }
  return hash.get();
}

}  // namespace hrp
