// SPDX-License-Identifier: BSD-3-Clause
// Bad and extreme inputs give a status; steps allocate nothing; equal inputs give equal bits.
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <new>
#include <random>

#include "common/base/diagnostics.h"
#include "tests/physics/rigs.h"

namespace {

long g_allocations = 0;

}  // namespace

void* operator new(std::size_t size) {
  ++g_allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace hrp {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Step, AllocatesNothing) {
  for (const char* model_name : {"spring_damper", "impulse"}) {
    rigs::Biped biped = rigs::make_biped();
    Scenario scenario = rigs::make_biped_scenario();
    scenario.contact.model = model_name;
    scenario.sensors.wrenches.push_back({"ft", "l_foot", {}, {}});
    scenario.sensors.imus.push_back({"imu", "body", Vector3d::Zero(), {}, {}});
    scenario.joint_laws["l_knee_joint"] = {{"coulomb_friction", {{"level", 5.0}}},
                                           {"command_delay", {{"delay", 0.01}}}};
    Simulator simulator(biped.robot, scenario);
    const rigs::CornerFinder finder = rigs::make_finder(biped);
    const JointCommand command = rigs::make_command(simulator.state());
    const Model model(simulator.tree());
    for (int i = 0; i < 200; ++i) {
      ExternalWrenches pushes(1);
      pushes[0].F_W[5] = 900.0 * std::sin(0.1 * i);  // contacts come and go
      const ContactSet contacts = finder.find(model, simulator.state());
      const long before = g_allocations;
      const StepStatus status = simulator.step(contacts, command, pushes);
      const long made = g_allocations - before;
      ASSERT_EQ(status, StepStatus::kOk);
      ASSERT_EQ(made, 0) << model_name << " step " << i;
    }
  }
}

TEST(Step, RepeatsToTheBit) {
  unsigned long long hashes[2];
  for (unsigned long long& hash : hashes) {
    rigs::Biped biped = rigs::make_biped();
    Simulator simulator(biped.robot, rigs::make_biped_scenario());
    const rigs::CornerFinder finder = rigs::make_finder(biped);
    const JointCommand command = rigs::make_command(simulator.state());
    const Model model(simulator.tree());
    for (int i = 0; i < 300; ++i) {
      ASSERT_EQ(simulator.step(finder.find(model, simulator.state()), command), StepStatus::kOk);
    }
    hash = simulator.state_hash();
    simulator.reset();
    EXPECT_EQ(simulator.step_number(), 0);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(Step, NamesTheJointOfABadCommand) {
  rigs::Biped biped = rigs::make_biped();
  Simulator simulator(biped.robot, rigs::make_biped_scenario());
  JointCommand command = rigs::make_command(simulator.state());
  command.q[1] = kNan;
  EXPECT_EQ(simulator.step({}, command), StepStatus::kBadCommand);
  EXPECT_NE(simulator.fault_text().find("l_knee_joint"), std::string::npos);
  command.q.resize(3);
  EXPECT_EQ(simulator.step({}, command), StepStatus::kBadCommand);
}

// A number from a palette of ordinary and impossible ones.
struct Palette {
  std::mt19937_64 random{12345};
  double pick() {
    static const double kOdd[] = {0.0,
                                  -0.0,
                                  1e-300,
                                  1e300,
                                  -1e300,
                                  1e30,
                                  -1e30,
                                  1e10,
                                  -1e10,
                                  kNan,
                                  std::numeric_limits<double>::infinity(),
                                  -std::numeric_limits<double>::infinity()};
    if (random() % 4 == 0) return kOdd[random() % 12];
    return std::uniform_real_distribution<double>(-3.0, 3.0)(random);
  }
  double maybe(double usual) { return random() % 8 == 0 ? pick() : usual; }
};

Scenario make_odd_scenario(Palette* palette) {
  Scenario scenario = rigs::make_biped_scenario();
  scenario.servo_default.kp = palette->maybe(5000.0);
  scenario.servo_default.kd = palette->maybe(50.0);
  scenario.contact.stiffness = palette->maybe(2e5);
  scenario.contact.alpha = palette->maybe(2.4);
  scenario.contact.model = palette->random() % 4 == 0 ? "impulse" : "spring_damper";
  const unsigned long long kind = palette->random() % 6;
  if (scenario.contact.model != "impulse") {
    scenario.integrator = kind == 0 ? "rk4" : (kind == 1 ? "semi_implicit_euler" : "implicit");
  }
  scenario.time_step = palette->maybe(0.001);
  return scenario;
}

// One trial: 5 steps. Returns false when a state that is not finite came out with kOk.
bool try_odd_run(Palette* palette, long* refused) {
  rigs::Biped biped = rigs::make_biped();
  const size_t link = palette->random() % biped.robot.tree.links.size();
  LinkInertia& inertia = biped.robot.tree.links[link].inertia;
  inertia.mass = palette->maybe(inertia.mass);
  inertia.I_LLcm_L(0, 0) = palette->maybe(inertia.I_LLcm_L(0, 0));
  try {
    Simulator simulator(biped.robot, make_odd_scenario(palette));
    State state = simulator.state();
    for (int i = 0; i < 8; ++i) {
      state.q[i] = palette->maybe(0.1);
      state.qd[i] = palette->maybe(0.0);
    }
    state.p_WB.z() = palette->maybe(0.79);  // deep, too
    state.V_WB[3] = palette->maybe(0.0);
    if (!simulator.reset(state)) {
      ++*refused;
      return true;
    }
    const rigs::CornerFinder finder = rigs::make_finder(biped);
    const Model model(simulator.tree());
    JointCommand command = rigs::make_command(simulator.state());
    command.q[static_cast<Eigen::Index>(palette->random() % 8)] = palette->maybe(0.0);
    for (int i = 0; i < 5; ++i) {
      ContactSet contacts = finder.find(model, simulator.state());
      if (!contacts.empty()) contacts[0].points[0].depth = palette->maybe(contacts[0].points[0].depth);
      ExternalWrenches pushes(1);
      pushes[0].F_W[4] = palette->maybe(0.0);
      const StepStatus status = simulator.step(contacts, command, pushes);
      const State& end = simulator.state();
      if (!end.q.allFinite() || !end.qd.allFinite() || !end.p_WB.allFinite() || !end.V_WB.allFinite()) return false;
      if (status != StepStatus::kOk) {
        ++*refused;
        return !simulator.fault_text().empty();
      }
    }
  } catch (const InputError&) {
    ++*refused;
  }
  return true;
}

TEST(TenThousandOddRuns, GiveAStatusNeverACrashNorASilentNan) {
  Palette palette;
  long refused = 0;
  for (int i = 0; i < 10000; ++i) ASSERT_TRUE(try_odd_run(&palette, &refused)) << i;
  EXPECT_GT(refused, 100);
  EXPECT_LT(refused, 9900);
}

}  // namespace
}  // namespace hrp
