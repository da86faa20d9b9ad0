// SPDX-License-Identifier: BSD-3-Clause
// One whole step of Unitree G1 standing on eight contact points (contact, servo, integration; no collision search)
// and that search, against MuJoCo's mj_step on the same robot, and our step against the number of contact points; both
// on robots of 25 to 200 joints that are made here. No pass or fail.
#include <benchmark/benchmark.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "common/base/parallel_for.h"
#include "common/multibody/kinematics.h"
#include "servers/collision_checker/collision_world.h"
#include "servers/dynamics/simulator.h"
#include "servers/model_parser/robot_loader.h"
#include "servers/mujoco_dynamics/mjcf.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

std::string find_g1() { return source_dir() + "/../shared/robots/unitree_g1/g1_29dof_rev_1_0.urdf"; }

bool load(benchmark::State& loop, Scenario* scenario, RobotDescription* robot) {
  if (!std::filesystem::exists(find_g1())) {
    loop.SkipWithError("../shared/robots/unitree_g1 is absent");
    return false;
  }
  scenario->robot = find_g1();
  scenario->feet = {"left_ankle_roll_link", "right_ankle_roll_link"};
  scenario->initial_height_given = true;
  scenario->initial_position = Vector3d(0, 0, 0.7569 + 0.035 - 2e-4);  // soles 0.2 mm in the floor
  scenario->servo_default.kp = 500.0;
  scenario->servo_default.kd = 5.0;
  scenario->control_period = 5;
  *robot = load_robot(*scenario);
  return true;
}

// `points` points on the soles' lower faces, as deep as they are in this state; those that are not above the margin.
ContactSet find_contacts(const Simulator& simulator, const Model& model, int points, double margin) {
  Data data(model);
  update_kinematics(model, simulator.state(), &data);
  ContactSet contacts;
  for (const char* foot : {"left_ankle_roll_link", "right_ankle_roll_link"}) {
    ContactPair pair;
    pair.body_a = simulator.tree().find_link(foot);
    pair.friction = 0.8;
    const Transform X_WL = get_pose(data, pair.body_a);
    pair.p_WR = X_WL.p;
    for (int i = 0; i < points / 2; ++i) {
      const double x = i % 2 == 0 ? -0.05 : 0.12, y = (i / 2) % 2 == 0 ? -0.025 : 0.025;
      const int turn = i / 4;  // the same four corners again, a little further back
      ContactPoint point;
      point.p_WC = X_WL * Vector3d(x - 1e-3 * turn, y, -0.035);
      point.depth = -point.p_WC.z();
      if (point.depth > -margin) pair.points.push_back(point);
    }
    if (!pair.points.empty()) contacts.push_back(pair);
  }
  return contacts;
}

// Settles with a search in every step, then times steps with the contacts of the settled state.
void time_step(benchmark::State& loop, double margin) {
  Scenario scenario;
  RobotDescription robot;
  if (!load(loop, &scenario, &robot)) return;
  scenario.contact.margin = margin;
  const int points = static_cast<int>(loop.range(0));
  Simulator simulator(robot, scenario);
  const Model model(simulator.tree());
  JointCommand command;
  command.q = simulator.state().q;
  StepStatus status = StepStatus::kOk;
  for (int i = 0; points > 0 && i < 500 && status == StepStatus::kOk; ++i) {
    status = simulator.step(find_contacts(simulator, model, points, margin), command);
  }
  const ContactSet contacts = find_contacts(simulator, model, points, margin);
  long found = 0;
  for (const ContactPair& pair : contacts) found += static_cast<long>(pair.points.size());
  const State settled = simulator.state();
  long done = 0, solves = 0;
  for ([[maybe_unused]] auto _ : loop) {
    status = simulator.step(contacts, command);
    solves += simulator.solves();
    if (status != StepStatus::kOk) return loop.SkipWithError(simulator.fault_text().c_str());
    if (++done % 200 != 0) continue;
    loop.PauseTiming();  // the contacts are fixed: the state must not drift away from them
    if (!simulator.reset(settled)) return loop.SkipWithError("reset");
    loop.ResumeTiming();
  }
  loop.counters["contacts"] = static_cast<double>(found);
  loop.counters["solves"] = static_cast<double>(solves) / static_cast<double>(done);
}

void our_step(benchmark::State& loop) { time_step(loop, 0.0); }
BENCHMARK(our_step)->Arg(0)->Arg(4)->Arg(8)->Arg(16)->Arg(32)->Arg(64);

// A corner takes part before it is in the ground: the feet stand still instead of rocking from edge to edge.
void our_quiet_step(benchmark::State& loop) { time_step(loop, 1e-3); }
BENCHMARK(our_quiet_step)->Arg(8)->Arg(32)->Arg(64);

// The collision search of a step that stands on its soles: 0 soles alone may touch the ground, 1 every shape may.
void our_search(benchmark::State& loop) {
  Scenario scenario;
  RobotDescription robot;
  if (!load(loop, &scenario, &robot)) return;
  scenario.ground.all_touch = loop.range(0) != 0;
  CollisionWorld world(robot, scenario);
  const State state = world.start_state();
  for ([[maybe_unused]] auto _ : loop) benchmark::DoNotOptimize(world.calc_contacts(state).size());
}
BENCHMARK(our_search)->Arg(0)->Arg(1);

mjModel* load_mujoco(const std::string& xml, char* error, int size) {
  mjVFS vfs;
  mj_defaultVFS(&vfs);
  mj_makeEmptyFileVFS(&vfs, "model.xml", static_cast<int>(xml.size()));
  std::copy(xml.begin(), xml.end(), static_cast<char*>(vfs.filedata[vfs.nfile - 1]));
  mjModel* model = mj_loadXML("model.xml", &vfs, error, size);
  mj_deleteVFS(&vfs);
  return model;
}

// MuJoCo's options: those of servers/mujoco_dynamics (elliptic cones, implicit integrator, nearest to ours); its
// defaults (pyramids, Newton, semi-implicit Euler); and its defaults with a single iteration of the solver, the fastest
// of all.
enum MujocoOptions { kAsServer, kDefault, kFewest };

void set_options(MujocoOptions options, mjModel* model) {
  if (options == kAsServer) return;
  const double time_step = model->opt.timestep;
  mj_defaultOption(&model->opt);
  model->opt.timestep = time_step;
  if (options != kFewest) return;
  model->opt.iterations = 1;
}

// Its soles' spheres on a plane, as servers/mujoco_dynamics writes it.
mjModel* load_mujoco(benchmark::State& loop, const RobotDescription& robot, const Scenario& scenario,
                     MujocoOptions options) {
  char error[1000] = "";
  mjModel* model = load_mujoco(make_mjcf(robot, scenario), error, sizeof error);
  if (!model) loop.SkipWithError(error);
  if (model) set_options(options, model);
  return model;
}

mjModel* load_mujoco(benchmark::State& loop, MujocoOptions options, double* height) {
  Scenario scenario;
  RobotDescription robot;
  if (!load(loop, &scenario, &robot)) return nullptr;
  *height = scenario.initial_position.z();
  return load_mujoco(loop, robot, scenario, options);
}

mjData* make_settled(const mjModel* model, double height) {
  mjData* data = mj_makeData(model);
  data->qpos[2] = height;
  for (int i = 0; i < 500; ++i) mj_step(model, data);  // its actuators are the same servo, reference 0
  return data;
}

void time_mujoco(benchmark::State& loop, mjModel* model, double height) {
  if (!model) return;
  mjData* data = make_settled(model, height);
  for ([[maybe_unused]] auto _ : loop) mj_step(model, data);
  loop.counters["contacts"] = data->ncon;
  loop.counters["height"] = data->qpos[2];
  mj_deleteData(data);
  mj_deleteModel(model);
}

void mujoco_step(benchmark::State& loop) {
  double height = 0.0;
  mjModel* model = load_mujoco(loop, static_cast<MujocoOptions>(loop.range(0)), &height);
  time_mujoco(loop, model, height);
}
BENCHMARK(mujoco_step)->Arg(kAsServer)->Arg(kDefault)->Arg(kFewest);

// ---- robots of many joints: a base on two legs of six joints, and all others in limbs that are folded beside it.
// Every link has a shape that may touch the ground. Both engines search for contacts in every step.

constexpr int kLegJoints = 6, kLimb = 13;

std::string make_link(const std::string& name, double mass, const char* box) {
  char text[500];
  std::snprintf(text, sizeof text,
                "<link name='%s'><inertial><mass value='%g'/><inertia ixx='%g' iyy='%g' izz='%g' ixy='0' ixz='0' "
                "iyz='0'/></inertial>"
                "<collision><geometry><box size='%s'/></geometry></collision></link>\n",
                name.c_str(), mass, 0.004 * mass, 0.004 * mass, 0.004 * mass, box);
  return text;
}

std::string make_joint(const std::string& name, const std::string& parent, const std::string& xyz, const char* axis) {
  return "<joint name='" + name + "_joint' type='revolute'><parent link='" + parent + "'/><child link='" + name +
         "'/><origin xyz='" + xyz + "'/><axis xyz='" + axis +
         "'/><limit lower='-2' upper='2' effort='1000' velocity='50'/><rotor inertia='0.1'/></joint>\n";
}

std::string make_leg(const std::string& side, const char* hip) {
  const char* axes[kLegJoints] = {"0 0 1", "1 0 0", "0 1 0", "0 1 0", "0 1 0", "1 0 0"};
  const char* places[kLegJoints] = {hip, "0 0 0", "0 0 0", "0 0 -0.35", "0 0 -0.35", "0 0 0"};
  std::string text, parent = "base";
  for (int i = 0; i < kLegJoints; ++i) {
    const bool foot = i + 1 == kLegJoints;
    const std::string name = side + (foot ? "_foot" : std::to_string(i));
    text +=
        make_link(name, 1.0, foot ? "0.24 0.12 0.06" : "0.06 0.06 0.06") + make_joint(name, parent, places[i], axes[i]);
    parent = name;
  }
  return text;
}

// `limb`: joints a limb at most.
std::string make_many_joints(int joints, int limb) {
  std::string text = "<robot name='many_joints'>\n" + make_link("base", 10.0, "0.2 0.3 0.2") +
                     make_leg("left", "0 0.1 0") + make_leg("right", "0 -0.1 0");
  std::string parent = "base";
  for (int i = 0; i < joints - 2 * kLegJoints; ++i) {
    const std::string name = "limb" + std::to_string(i);
    const bool first = i % limb == 0;
    if (first) parent = "base";
    // Folded, so that it is as wide as one link however many there are.
    text += make_link(name, 0.1, "0.04 0.04 0.04") + make_joint(name, parent,
                                                                first        ? "0 0 0.1"
                                                                : i % 2 == 0 ? "0 0 0.06"
                                                                             : "0 0 -0.06",
                                                                i % 2 == 0 ? "0 1 0" : "1 0 0");
    parent = name;
  }
  return text + "</robot>\n";
}

// range(0): joints; range(1): joints a limb.
RobotDescription make_many_joints(const benchmark::State& loop, Scenario* scenario) {
  scenario->robot = "many_joints.urdf";
  scenario->feet = {"left_foot", "right_foot"};
  scenario->servo_default.kp = 2000.0;
  scenario->servo_default.kd = 20.0;
  scenario->control_period = 5;
  return parse_robot(make_many_joints(static_cast<int>(loop.range(0)), static_cast<int>(loop.range(1))),
                     scenario->robot, *scenario);
}

void our_joints(benchmark::State& loop) {
  Scenario scenario;
  const RobotDescription robot = make_many_joints(loop, &scenario);
  Simulator simulator(robot, scenario);
  CollisionWorld world(robot, scenario);
  JointCommand command;
  command.q = simulator.state().q;
  for (int i = 0; i < 500; ++i) {
    if (simulator.step(world.calc_contacts(simulator.state()), command) != StepStatus::kOk)
      return loop.SkipWithError("settling");
  }
  long done = 0, solves = 0;
  size_t points = 0;
  for ([[maybe_unused]] auto _ : loop) {
    const ContactSet& contacts = world.calc_contacts(simulator.state());
    if (simulator.step(contacts, command) != StepStatus::kOk) return loop.SkipWithError(simulator.fault_text().c_str());
    solves += simulator.solves();
    ++done;
    for (const ContactPair& pair : contacts) points += pair.points.size();
  }
  loop.counters["contacts"] = static_cast<double>(points) / static_cast<double>(done);
  loop.counters["solves"] = static_cast<double>(solves) / static_cast<double>(done);
  loop.counters["height"] = simulator.state().p_WB.z();
}

void mujoco_joints(benchmark::State& loop) {
  Scenario scenario;
  const RobotDescription robot = make_many_joints(loop, &scenario);
  const double height = CollisionWorld(robot, scenario).start_state().p_WB.z();
  mjModel* model = load_mujoco(loop, robot, scenario, static_cast<MujocoOptions>(loop.range(2)));
  time_mujoco(loop, model, height);
}

constexpr int kOneLimb = 1000;  // all of them in one chain
BENCHMARK(our_joints)->ArgsProduct({{25, 50, 100, 200}, {kLimb, kOneLimb}});
BENCHMARK(mujoco_joints)->ArgsProduct({{25, 50, 100, 200}, {kLimb, kOneLimb}, {kAsServer, kDefault}});

// ---- many robots in one process: each stands, with its own state; search and step, a slice of time for one robot
// after the other, as a rollout does. Figures are per second of processor, so that others on the machine count little.

constexpr int kRobots = 1000, kSlice = 10;

int find_cores() { return static_cast<int>(std::max(1u, std::thread::hardware_concurrency())); }

void count_steps(benchmark::State& loop) {
  loop.counters["robot_steps"] =
      benchmark::Counter(static_cast<double>(loop.iterations()) * kRobots * kSlice, benchmark::Counter::kIsRate);
  loop.counters["robots"] = kRobots;
  loop.counters["threads"] = find_cores();
}

void our_batch(benchmark::State& loop) {
  Scenario scenario;
  RobotDescription robot;
  if (!load(loop, &scenario, &robot)) return;
  Simulator settled(robot, scenario);
  JointCommand command;
  command.q = settled.state().q;
  std::deque<CollisionWorld> worlds;
  for (int i = 0; i < find_cores(); ++i) worlds.emplace_back(robot, scenario);
  for (int i = 0; i < 500; ++i) {
    if (settled.step(worlds[0].calc_contacts(settled.state()), command) != StepStatus::kOk)
      return loop.SkipWithError("settling");
  }
  std::vector<Simulator> robots(kRobots, settled);
  std::atomic<bool> good{true};
  for ([[maybe_unused]] auto _ : loop) {
    parallel_for(find_cores(), kRobots, [&](int i, int thread) {
      Simulator& mine = robots[static_cast<size_t>(i)];
      CollisionWorld& world = worlds[static_cast<size_t>(thread)];
      for (int k = 0; k < kSlice; ++k) {
        if (mine.step(world.calc_contacts(mine.state()), command) != StepStatus::kOk) good = false;
      }
    });
  }
  if (!good) return loop.SkipWithError("a robot failed");
  count_steps(loop);
}
BENCHMARK(our_batch)->MeasureProcessCPUTime();

void mujoco_batch(benchmark::State& loop) {
  double height = 0.0;
  mjModel* model = load_mujoco(loop, static_cast<MujocoOptions>(loop.range(0)), &height);
  if (!model) return;
  mjData* settled = make_settled(model, height);
  std::vector<mjData*> robots(kRobots);
  for (mjData*& data : robots) data = mj_copyData(nullptr, model, settled);
  for ([[maybe_unused]] auto _ : loop) {
    parallel_for(find_cores(), kRobots, [&](int i) {
      for (int k = 0; k < kSlice; ++k) mj_step(model, robots[static_cast<size_t>(i)]);
    });
  }
  for (mjData* data : robots) mj_deleteData(data);
  mj_deleteData(settled);
  mj_deleteModel(model);
  count_steps(loop);
}
BENCHMARK(mujoco_batch)->Arg(kAsServer)->Arg(kDefault)->Arg(kFewest)->MeasureProcessCPUTime();

}  // namespace
}  // namespace hrp

BENCHMARK_MAIN();
