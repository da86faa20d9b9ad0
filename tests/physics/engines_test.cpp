// SPDX-License-Identifier: BSD-3-Clause
// Our multibody algorithms against MuJoCo and DART with identical bodies, on every robot there is.
#include <gtest/gtest.h>

#include "common/multibody/forward_dynamics.h"
#include "common/multibody/mass_matrix.h"
#include "tests/engines/dart_engine.h"
#include "tests/engines/mujoco_engine.h"
#include "tests/engines/robots.h"
#include "tests/unit/multibody/random_tree.h"

namespace hrp {
namespace {

using testing::Random;
using testing::relative_error;

constexpr int kStates = 5;
// Both sides solve with mass matrices whose condition number reaches 1e7 (fingers against trunk): 1e-9 leaves two
// digits. Mass matrix and inverse dynamics involve no solve; their errors are rounding of sums.
constexpr double kTolerance = 1e-9;

struct Ours {
  explicit Ours(const TreeSpec& spec) : model(spec), data(model), tau(model.nv()), vdot(model.nv()) {}
  void calc(const State& state, const Eigen::VectorXd& wanted) {
    update_kinematics(model, state, &data);
    calc_inverse_dynamics(model, wanted, nullptr, &data, &tau);
    effort = tau.tail(model.num_joints());
    status = calc_forward_dynamics(model, effort, nullptr, {}, &data, &vdot);
    update_mass_matrix(model, &data);
  }
  Model model;
  Data data;
  Eigen::VectorXd tau, effort, vdot;
  Status status = Status::kOk;
};

// Runs all three calculations in `engine` and compares. Efforts are those of random accelerations of 10 rad/s^2, so
// that light fingers do not drown everything else in the norm.
template <class Engine>
void compare(const TreeSpec& spec, Engine* engine) {
  Ours ours(spec);
  Random random(7);
  for (int i = 0; i < kStates; ++i) {
    State state = testing::make_random_state(ours.model, &random);
    if (!spec.floating_base) state.R_WB.setIdentity();  // the engines weld the base without turning it
    const Eigen::VectorXd wanted = random.values(ours.model.nv(), 10);
    ours.calc(state, wanted);
    ASSERT_EQ(ours.status, Status::kOk);
    engine->set_state(state);
    engine->run_mass_matrix();
    EXPECT_LT(relative_error(engine->get_mass_matrix(), ours.data.M), kTolerance) << "mass matrix, state " << i;
    engine->set_acceleration(wanted);
    engine->run_inverse_dynamics();
    EXPECT_LT(relative_error(engine->get_effort(), ours.tau), kTolerance) << "inverse dynamics, state " << i;
    engine->set_effort(ours.effort);
    engine->run_forward_dynamics();
    EXPECT_LT(relative_error(engine->get_acceleration(), ours.vdot), kTolerance) << "forward dynamics, state " << i;
  }
}

void compare_with_mujoco(TreeSpec spec) {
  const Model model(spec);
  engines::MujocoEngine engine(spec, model.gravity_W());
  if (!engine.usable()) GTEST_SKIP() << "MuJoCo refuses " << spec.name << ": " << engine.error();
  compare(spec, &engine);
}

void compare_with_dart(TreeSpec spec) {
  for (LinkSpec& link : spec.links) {
    link.joint.rotor_inertia = 0;
    if (link.inertia.mass == 0) GTEST_SKIP() << "DART has no massless links: " << link.name;
  }
  const Model model(spec);
  engines::DartEngine engine(spec, model.gravity_W());
  compare(spec, &engine);
}

class Robots : public ::testing::TestWithParam<std::string> {};

// A robot that the loader refuses (a stand without mass cannot float) is skipped with the reason.
void compare_robot(const std::string& urdf, bool floating, void (*compare_with)(TreeSpec)) {
  TreeSpec spec;
  try {
    spec = engines::load_tree(urdf, floating);
  } catch (const InputError& error) {
    GTEST_SKIP() << "not loaded: " << error.what();
  }
  compare_with(spec);
}

TEST_P(Robots, MoveAsInMujocoOnAFloatingBase) { compare_robot(GetParam(), true, compare_with_mujoco); }
TEST_P(Robots, MoveAsInMujocoOnAFixedBase) { compare_robot(GetParam(), false, compare_with_mujoco); }
TEST_P(Robots, MoveAsInDartOnAFloatingBase) { compare_robot(GetParam(), true, compare_with_dart); }
TEST_P(Robots, MoveAsInDartOnAFixedBase) { compare_robot(GetParam(), false, compare_with_dart); }

std::string make_name(const ::testing::TestParamInfo<std::string>& info) {
  const std::filesystem::path path(info.param);
  std::string name = path.parent_path().filename().string() + "_" + path.stem().string();
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Urdfs, Robots, ::testing::ValuesIn(engines::find_urdfs()), make_name);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Robots);

class RandomTrees : public ::testing::TestWithParam<int> {
 protected:
  TreeSpec make() { return testing::make_random_tree(static_cast<unsigned>(GetParam()), 20, GetParam() % 2 == 0); }
};

TEST_P(RandomTrees, MoveAsInMujoco) { compare_with_mujoco(make()); }
TEST_P(RandomTrees, MoveAsInDart) { compare_with_dart(make()); }

INSTANTIATE_TEST_SUITE_P(Seeds, RandomTrees, ::testing::Range(0, 6));

TEST(SharedRobots, ArePresent) {
  if (engines::find_shared_robot("unitree_g1/g1_29dof_rev_1_0.urdf").empty()) {
    GTEST_SKIP() << "../shared/robots is absent: robots of other people were NOT compared";
  }
}

}  // namespace
}  // namespace hrp
