// SPDX-License-Identifier: BSD-3-Clause
// Forward dynamics, mass matrix and inverse dynamics from positions and velocities on: ours, MuJoCo, DART, the same
// bodies in the same run. Run with --benchmark_enable_random_interleaving=true --benchmark_repetitions=9; compare
// medians. "full_forward" is MuJoCo's mj_forward; "forward_dynamics" calls only what a free tree needs.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <memory>

#include "common/multibody/forward_dynamics.h"
#include "common/multibody/mass_matrix.h"
#include "tests/engines/dart_engine.h"
#include "tests/engines/mujoco_engine.h"
#include "tests/engines/robots.h"
#include "tests/unit/multibody/random_tree.h"

namespace hrp {
namespace {

using testing::Random;

// Ours with a ring of states, so that no branch or cache line is learnt by heart.
struct Ours {
  explicit Ours(const TreeSpec& spec) : model(spec), data(model), out(model.nv()) {
    Random random(1);
    for (int i = 0; i < 16; ++i) states.push_back(testing::make_random_state(model, &random));
    effort = random.values(model.num_joints(), 10);
    vdot = random.values(model.nv(), 10);
  }
  const State& next() { return states[turn++ % states.size()]; }
  Model model;
  Data data;
  std::vector<State> states;
  size_t turn = 0;
  Eigen::VectorXd effort, vdot, out;
};

void run_forward(benchmark::State& loop, Ours* ours) {
  for ([[maybe_unused]] auto _ : loop) {
    update_kinematics(ours->model, ours->next(), &ours->data);
    benchmark::DoNotOptimize(calc_forward_dynamics(ours->model, ours->effort, nullptr, {}, &ours->data, &ours->out));
    benchmark::ClobberMemory();
  }
}

void run_mass(benchmark::State& loop, Ours* ours) {
  for ([[maybe_unused]] auto _ : loop) {
    update_kinematics(ours->model, ours->next(), &ours->data);
    update_mass_matrix(ours->model, &ours->data);
    benchmark::ClobberMemory();
  }
}

void run_inverse(benchmark::State& loop, Ours* ours) {
  for ([[maybe_unused]] auto _ : loop) {
    update_kinematics(ours->model, ours->next(), &ours->data);
    calc_inverse_dynamics(ours->model, ours->vdot, nullptr, &ours->data, &ours->out);
    benchmark::ClobberMemory();
  }
}

void run_kinematics(benchmark::State& loop, Ours* ours) {
  for ([[maybe_unused]] auto _ : loop) {
    update_kinematics(ours->model, ours->next(), &ours->data);
    benchmark::ClobberMemory();
  }
}

using MujocoRun = void (engines::MujocoEngine::*)();
using DartRun = void (engines::DartEngine::*)();

void run_mujoco(benchmark::State& loop, engines::MujocoEngine* engine, MujocoRun run) {
  for ([[maybe_unused]] auto _ : loop) (engine->*run)();
}

// DART caches what depends on positions: they are set anew each time, as ours are.
void run_dart(benchmark::State& loop, engines::DartEngine* engine, DartRun run) {
  for ([[maybe_unused]] auto _ : loop) {
    engine->touch();
    (engine->*run)();
  }
}

void register_robot(const std::string& name, const TreeSpec& spec) {
  auto ours = std::make_shared<Ours>(spec);
  auto mujoco = std::make_shared<engines::MujocoEngine>(spec, ours->model.gravity_W());
  auto dart = std::make_shared<engines::DartEngine>(spec, ours->model.gravity_W());
  mujoco->set_state(ours->states[0]);
  mujoco->set_effort(ours->effort);
  mujoco->set_acceleration(ours->vdot);
  dart->set_state(ours->states[0]);
  dart->set_effort(ours->effort);
  using benchmark::RegisterBenchmark;
  const auto add_ours = [&](const char* what, void (*run)(benchmark::State&, Ours*)) {
    RegisterBenchmark((name + "/" + what + "/ours").c_str(), [ours, run](benchmark::State& s) { run(s, ours.get()); });
  };
  const auto add_mujoco = [&](const char* what, MujocoRun run) {
    RegisterBenchmark((name + "/" + what + "/mujoco").c_str(),
                      [mujoco, run](benchmark::State& s) { run_mujoco(s, mujoco.get(), run); });
  };
  const auto add_dart = [&](const char* what, DartRun run) {
    RegisterBenchmark((name + "/" + what + "/dart").c_str(),
                      [dart, run](benchmark::State& s) { run_dart(s, dart.get(), run); });
  };
  add_ours("kinematics", run_kinematics);
  add_ours("forward_dynamics", run_forward);
  add_mujoco("forward_dynamics", &engines::MujocoEngine::run_forward_dynamics);
  add_mujoco("full_forward", &engines::MujocoEngine::run_full_forward);
  add_dart("forward_dynamics", &engines::DartEngine::run_forward_dynamics);
  add_ours("mass_matrix", run_mass);
  add_mujoco("mass_matrix", &engines::MujocoEngine::run_mass_matrix);
  add_dart("mass_matrix", &engines::DartEngine::run_mass_matrix);
  add_ours("inverse_dynamics", run_inverse);
  add_mujoco("inverse_dynamics", &engines::MujocoEngine::run_inverse_dynamics);
  add_dart("inverse_dynamics", &engines::DartEngine::run_inverse_dynamics);
}

void register_all() {
  const std::string g1 = engines::find_shared_robot("unitree_g1/g1_29dof_rev_1_0.urdf");
  if (g1.empty()) {
    std::fprintf(stderr, "NOT MEASURED: ../shared/robots/unitree_g1 is absent; a random tree of 29 joints stands in\n");
    register_robot("random29", testing::make_random_tree(1, 29, true));
  } else {
    register_robot("g1", engines::load_tree(g1, true));
  }
}

}  // namespace
}  // namespace hrp

int main(int argc, char** argv) {
  hrp::register_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
