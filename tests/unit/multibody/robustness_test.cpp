// SPDX-License-Identifier: BSD-3-Clause
// No allocation after construction, no crash on bad numbers, nothing that depends on how links are listed.
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

#include "common/base/diagnostics.h"
#include "common/multibody/kinematics.h"
#include "common/multibody/loops.h"
#include "common/multibody/mass_matrix.h"
#include "common/multibody/momentum.h"
#include "common/multibody/regressor.h"
#include "tests/unit/multibody/random_tree.h"

// Counts what operator new and Eigen's matrices take: both end in malloc, which glibc lets a program replace.
// Sanitizers have a malloc of their own, which must not be replaced, and tell of each call.
namespace {
long long num_allocations = 0;
}
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// Of the sanitizers' runtime; GCC ships it without the header that declares it.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*, std::size_t),
                                                         void (*free_hook)(const volatile void*));
[[maybe_unused]] const int kHook = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { ++num_allocations; }, [](const volatile void*) {});
#else
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) {
  ++num_allocations;
  return __libc_malloc(size);
}
#endif

namespace hrp {
namespace {

using testing::Random;
using testing::relative_error;

// Everything that a step calls, with memory of its own.
struct Everything {
  Everything(const TreeSpec& spec, unsigned seed)
      : random(seed),
        model(spec),
        data(model),
        regressor(model),
        loops(model, make_loops()),
        effort(random.values(model.num_joints(), 10)),
        extra(random.values(model.num_joints(), 1).cwiseAbs()),
        vdot(random.values(model.nv(), 10)),
        out(model.nv()),
        J(6, model.nv()),
        J_com(3, model.nv()),
        B(Eigen::MatrixXd::Random(model.nv(), 4)),
        X(model.nv(), 4),
        wrenches(static_cast<size_t>(model.num_links()), Vector6d::Ones()),
        impedances(1),
        state(testing::make_random_state(model, &random)) {
    impedances[0].link = 1;
    impedances[0].Z.setIdentity();
  }
  std::vector<LoopConstraint> make_loops() const {
    LoopConstraint pin;
    pin.kind = LoopKind::kPin;
    pin.link_a = model.num_links() - 1;
    return {pin};
  }
  Status run() {
    update_kinematics(model, state, &data);
    calc_inverse_dynamics(model, vdot, &wrenches, &data, &out);
    calc_bias(model, &data, &out);
    update_mass_matrix(model, &data);
    calc_point_jacobian(model, data, 1, Vector3d::Zero(), J);
    calc_centre_of_mass_jacobian(model, &data, J_com);
    sum = calc_kinetic_energy(model, data) + calc_potential_energy(model, data) +
          calc_centroidal_momentum(model, data).sum() + calc_centre_of_mass(model, data).sum();
    calc_regressor(model, vdot, &data, &regressor);
    const Status closed = loops.calc_forward_dynamics(model, state, effort, &wrenches, {}, &data, &out);
    const Status open = calc_forward_dynamics(model, effort, &wrenches, {&extra, &impedances}, &data, &out);
    calc_responses(model, B, &data, &X);
    return closed == Status::kOk ? open : closed;
  }
  Random random;
  Model model;
  Data data;
  Regressor regressor;
  Loops loops;
  Eigen::VectorXd effort, extra, vdot, out;
  Eigen::MatrixXd J, J_com, B, X;
  LinkWrenches wrenches;
  LinkImpedances impedances;
  State state;
  double sum = 0;
};

TEST(Allocation, NothingIsAllocatedAfterConstruction) {
  for (bool floating : {false, true}) {
    const long long start = num_allocations;
    Everything everything(testing::make_random_tree(3, 20, floating), 3);
    const long long before = num_allocations;
    EXPECT_GT(before, start) << "the counter does not count";
    const Status status = everything.run();
    EXPECT_EQ(num_allocations - before, 0);
    EXPECT_EQ(status, Status::kOk);
  }
}

TEST(BadNumbers, GiveAStatusAndNeverACrash) {
  const double values[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300,
                           -1e200};
  Random random(17);
  int not_ok = 0;
  Everything everything(testing::make_random_tree(5, 8, true), 5);
  const State good = everything.state;
  for (int i = 0; i < 2000; ++i) {
    State& s = everything.state = good;
    const double value = values[i % 4];
    const int what = random.index(5), joint = random.index(8);
    if (what == 0) s.q[joint] = value;
    if (what == 1) s.qd[joint] = value;
    if (what == 2) s.V_WB[random.index(6)] = value;
    if (what == 3) s.p_WB[random.index(3)] = value;
    everything.effort[joint] = what == 4 ? value : 1.0;
    const Status status = everything.run();
    EXPECT_TRUE(status != Status::kOk || everything.out.allFinite());
    if (status != Status::kOk) ++not_ok;
    everything.effort[joint] = 1.0;
  }
  EXPECT_GT(not_ok, 1000);
}

TEST(BadNumbers, NegativeInertiaIsSingular) {
  Everything everything(testing::make_random_tree(5, 8, true), 5);
  everything.extra[3] = -1e6;
  EXPECT_EQ(everything.run(), Status::kSingular);
}

TEST(BadTrees, AreRefusedByName) {
  const auto refuse = [](void (*spoil)(TreeSpec*), const std::string& name) {
    TreeSpec spec = testing::make_random_tree(1, 3, true);
    spoil(&spec);
    try {
      const Model model(spec);
      ADD_FAILURE() << "accepted, expected a complaint about " << name;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  };
  refuse([](TreeSpec* s) { s->links[2].inertia.mass = -1; }, "link2");
  refuse([](TreeSpec* s) { s->links[2].inertia.mass = std::nan(""); }, "link2");
  refuse([](TreeSpec* s) { s->links[3].parent = 3; }, "link3");
  refuse([](TreeSpec* s) { s->joint(1).axis_F *= 1.1; }, "joint1");
  refuse([](TreeSpec* s) { s->joint(1).rotor_inertia = -1; }, "joint1");
  refuse([](TreeSpec* s) { s->joint(1).X_PF.R *= 2; }, "joint1");
  refuse([](TreeSpec* s) { s->links[1].inertia.I_LLcm_L = -Matrix3d::Identity(); }, "link1");
  refuse([](TreeSpec* s) { s->links.clear(); }, "links");
  refuse([](TreeSpec* s) { s->frames[0].link = 9; }, "tip");
}

// Passive joints of a sole bush: slide, roll and pitch with two links without mass between ankle and sole.
TEST(MasslessLinks, BetweenPassiveJointsAreFine) {
  TreeSpec spec = testing::make_random_tree(2, 3, true);
  const Vector3d axes[3] = {Vector3d::UnitZ(), Vector3d::UnitX(), Vector3d::UnitY()};
  for (int i = 0; i < 3; ++i) {
    LinkSpec link;
    link.name = "bush" + std::to_string(i);
    link.parent = static_cast<int>(spec.links.size()) - 1;
    link.joint.name = link.name + "_joint";
    link.joint.axis_F = axes[i];
    link.joint.kind = i == 0 ? JointKind::kPrismatic : JointKind::kRevolute;
    if (i == 2) link.inertia = spec.links[1].inertia;
    spec.links.push_back(link);
  }
  spec.joint(0).rotor_inertia = spec.joint(1).rotor_inertia = spec.joint(2).rotor_inertia = 0;
  Everything everything(spec, 1);
  EXPECT_EQ(everything.run(), Status::kOk);
}

// The same tree with its links listed in another (valid) order.
TreeSpec permute(const TreeSpec& spec, const std::vector<int>& order) {
  TreeSpec other = spec;
  std::vector<int> position(order.size());
  for (size_t i = 0; i < order.size(); ++i) position[static_cast<size_t>(order[i])] = static_cast<int>(i);
  for (size_t i = 0; i < order.size(); ++i) {
    other.links[i] = spec.links[static_cast<size_t>(order[i])];
    if (i > 0) other.links[i].parent = position[static_cast<size_t>(other.links[i].parent)];
  }
  return other;
}

TEST(ListingOrder, DoesNotChangeTheMotion) {
  TreeSpec spec = testing::make_random_tree(8, 6, true);
  const int parents[] = {-1, 0, 1, 2, 0, 4, 5};  // two limbs
  for (size_t i = 1; i < 7; ++i) spec.links[i].parent = parents[i];
  const std::vector<int> order = {0, 4, 1, 5, 2, 6, 3};
  const Model a(spec), b(permute(spec, order));
  Data data_a(a), data_b(b);
  Random random(6);
  const State state_a = testing::make_random_state(a, &random);
  const Eigen::VectorXd effort_a = random.values(6, 10);
  State state_b = state_a;
  Eigen::VectorXd effort_b(6), vdot_a(12), vdot_b(12), back(12);
  for (int i = 0; i < 6; ++i) {
    const int j = order[static_cast<size_t>(i) + 1] - 1;
    state_b.q[i] = state_a.q[j];
    state_b.qd[i] = state_a.qd[j];
    effort_b[i] = effort_a[j];
  }
  update_kinematics(a, state_a, &data_a);
  update_kinematics(b, state_b, &data_b);
  ASSERT_EQ(calc_forward_dynamics(a, effort_a, nullptr, {}, &data_a, &vdot_a), Status::kOk);
  ASSERT_EQ(calc_forward_dynamics(b, effort_b, nullptr, {}, &data_b, &vdot_b), Status::kOk);
  back.head<6>() = vdot_b.head<6>();
  for (int i = 0; i < 6; ++i) back[5 + order[static_cast<size_t>(i) + 1]] = vdot_b[6 + i];
  EXPECT_LT(relative_error(back, vdot_a), 1e-13);  // sums of two limbs in another order: rounding only
}

}  // namespace
}  // namespace hrp
