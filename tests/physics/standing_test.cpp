// SPDX-License-Identifier: BSD-3-Clause
// A biped that stands: weight, tilt oscillation of a sole bush, quiet stiff soles, sensors, order of listing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>

#include "common/multibody/kinematics.h"
#include "common/multibody/momentum.h"
#include "tests/physics/rigs.h"

namespace hrp {
namespace {

FootBushSpec make_bush() {
  FootBushSpec bush;
  bush.kz = 3e5;
  bush.cz = 800.0;
  bush.k_roll = bush.k_pitch = 450.0;
  bush.c_roll = bush.c_pitch = 15.0;
  return bush;
}

struct Stand {
  rigs::Biped biped = rigs::make_biped();
  Scenario scenario = rigs::make_biped_scenario();
  rigs::CornerFinder finder;
  JointCommand command;

  Simulator make() {
    finder = rigs::make_finder(biped);
    Simulator simulator(biped.robot, scenario);
    command = rigs::make_command(simulator.state());
    return simulator;
  }
};

constexpr double kWeight = 58.0 * 9.81;

TEST(StandingBiped, CarriesItsWeightOnBothFeet) {
  Stand stand;
  Simulator simulator = stand.make();
  const Model model(simulator.tree());
  for (int i = 0; i < 20000; ++i) {
    ASSERT_EQ(simulator.step(stand.finder.find(model, simulator.state()), stand.command), StepStatus::kOk);
  }
  const auto& feet = simulator.foot_forces();
  EXPECT_NEAR((feet[0] + feet[1]) / kWeight, 1.0, 1e-6);
  EXPECT_NEAR(feet[0] / feet[1], 1.0, 1e-6);  // symmetric robot
}

TEST(StandingBiped, FeelsItsWeightLessTheFootsAboveTheBush) {
  Stand stand;
  stand.scenario.sensors.wrenches.push_back({"ft", "l_foot", {}, {}});
  stand.scenario.sensors.imus.push_back({"imu", "body", Vector3d(0, 0, 0.2), {}, {}});
  Simulator simulator = stand.make();
  const Model model(simulator.tree());
  for (int i = 0; i < 20000; ++i) {
    ASSERT_EQ(simulator.step(stand.finder.find(model, simulator.state()), stand.command), StepStatus::kOk);
  }
  // What the foot exerts on the leg: half of everything above the feet.
  EXPECT_NEAR(simulator.sensors().wrenches[0].force.z(), 0.5 * (kWeight - 2.0 * 9.81), 1e-3);
  EXPECT_NEAR(simulator.sensors().imus[0].linear_acceleration.norm(), 9.81, 1e-4);  // still rocks a little
}

struct RockingBiped : Stand {
  FootBushSpec bush = make_bush();
  // On a floor of 1e9 N/m with bushes 10 N m off, rocking and bending its knees.
  Simulator start(double margin) {
    bush.offset_pitch = 10.0;
    rigs::add_bushes(bush, &biped);
    scenario.contact.stiffness = 1e9;
    scenario.contact.tangential_stiffness = 1e8;
    scenario.sensors.wrenches.push_back({"ft", "l_foot", {}, {}});
    Simulator simulator = make();
    finder.margin = scenario.contact.margin = margin;
    return simulator;
  }
  // Moves the references; returns the pitch rate of the left bush.
  double step(const Model& model, int i, Simulator* simulator) {
    JointCommand moved = command;
    for (int j = 0; j < 8; ++j)
      moved.q[j] += 0.05 * std::sin(2.0 * M_PI * 0.7 * 1e-3 * i) * (j % 4 == 1 ? -2.0 : (j % 4 == 3 ? 0.2 : 1.0));
    EXPECT_EQ(simulator->step(finder.find(model, simulator->state()), moved), StepStatus::kOk)
        << simulator->fault_text();
    return simulator->state().qd[model.spec().find_joint("l_foot_bush_pitch")];
  }
};

// The sensor above the bush is computed from the reported contact forces; the bush's law from its state. That they
// agree says that reported forces are those that acted, and that readings are in the axes of their forces.
TEST(RockingBiped, FeelsExactlyWhatItsBushesExert) {
  RockingBiped biped;
  Simulator simulator = biped.start(1e-3);
  const Model model(simulator.tree());
  const int z = model.spec().find_joint("l_foot_bush_z"), roll = z + 1;
  const Vector3d centre(0.015, 0.0, -0.105);
  double largest[2] = {0.0, 0.0};
  for (int i = 0; i < 4000; ++i) {
    biped.step(model, i, &simulator);
    if (i < 500) continue;
    const State& s = simulator.state();
    const WrenchSample& w = simulator.sensors().wrenches[0];
    // 0.1 kg above the bush: its weight and inertia (up to 1 m/s^2 at 0.05 m) stay out.
    const double moment = (w.torque - (centre + Vector3d(0, 0, s.q[z])).cross(w.force)).x();
    largest[0] =
        std::max(largest[0], std::abs(moment - biped.bush.k_roll * s.q[roll] - biped.bush.c_roll * s.qd[roll]));
    const double force = w.force.z() + 0.1 * 9.81;
    largest[1] = std::max(largest[1], std::abs(force - biped.bush.kz * s.q[z] - biped.bush.cz * s.qd[z]));
  }
  EXPECT_LT(largest[0], 5e-3);  // [N m]
  EXPECT_LT(largest[1], 0.15);  // [N] of 280 N
}

TEST(RockingBiped, DoesNotChatterWhenCornersAreSeenBeforeTheyTouch) {
  double fastest[2] = {0.0, 0.0};
  for (int seen = 0; seen < 2; ++seen) {
    RockingBiped biped;
    Simulator simulator = biped.start(seen ? 1e-3 : 0.0);
    const Model model(simulator.tree());
    for (int i = 0; i < 3000; ++i) {
      const double rate = biped.step(model, i, &simulator);
      if (i > 500) fastest[seen] = std::max(fastest[seen], std::abs(rate));
    }
  }
  std::printf("fastest turn of a sole against its foot: %.3f rad/s, %.3f rad/s with a margin\n", fastest[0],
              fastest[1]);
  EXPECT_LT(fastest[1], 0.5);               // feet turn by 0.2 rad/s
  EXPECT_LT(fastest[1], 0.7 * fastest[0]);  // without it they do chatter on this floor
}

// Bushes stand for a joint at the soles: with rigid joints the robot is an inverted pendulum on springs.
TEST(TiltedBiped, OscillatesAtTheFrequencyAndDecayComputedByHand) {
  Stand stand;
  const FootBushSpec bush = make_bush();
  rigs::add_bushes(bush, &stand.biped);
  stand.scenario.perfect_joints = true;
  stand.scenario.contact.stiffness = 2e7;  // as good as rigid beside the bush
  stand.scenario.contact.tangential_stiffness = 2e7;
  stand.scenario.contact.tangential_damping = 2e4;
  stand.scenario.time_step = 2e-4;
  Simulator simulator = stand.make();
  const Model model(simulator.tree());
  State state = simulator.state();
  Data data(model);
  update_kinematics(model, state, &data);
  const Vector3d com = calc_centre_of_mass(model, data);
  for (const char* foot : {"l_foot", "r_foot"}) {  // tilt by turning every bush: the soles stay on the floor
    state.q[model.spec().find_joint(std::string(foot) + "_bush_pitch")] = -0.01;
  }
  const double lean = 0.01;
  state.R_WB = Eigen::AngleAxisd(lean, Vector3d::UnitY());
  const Vector3d pivot(0.015, 0.0, 0.0);
  state.p_WB = pivot + state.R_WB * (state.p_WB - pivot);
  ASSERT_TRUE(simulator.reset(state));
  std::vector<double> pitch;
  for (int i = 0; i < 30000; ++i) {
    ASSERT_EQ(simulator.step(stand.finder.find(model, simulator.state()), stand.command), StepStatus::kOk)
        << simulator.fault_text();
    pitch.push_back(2.0 * simulator.state().R_WB.y());
  }
  // By hand: I about the soles' centre, stiffness 2 K - m g h, damping 2 C, weight on a lever h.
  update_kinematics(model, simulator.state(), &data);
  Data centred(model);
  State unit = simulator.state();
  unit.V_WB.setZero();
  unit.qd.setZero();
  unit.V_WB[1] = 1.0;
  update_kinematics(model, unit, &centred);
  const double h = com.z(), mass = model.mass();
  const double inertia = calc_centroidal_momentum(model, centred)[1] + mass * (h * h);
  const double k = 2.0 * bush.k_pitch - mass * 9.81 * h;
  const double decay = 2.0 * bush.c_pitch / (2.0 * inertia);
  const double w = std::sqrt(k / inertia - decay * decay);
  std::vector<double> highs, lows, times;
  for (size_t i = 1; i + 1 < pitch.size(); ++i) {
    if (pitch[i] > pitch[i - 1] && pitch[i] >= pitch[i + 1] && i > 1000) {
      highs.push_back(pitch[i]);
      times.push_back(static_cast<double>(i) * 2e-4);
    }
    if (pitch[i] < pitch[i - 1] && pitch[i] <= pitch[i + 1] && i > 1000) lows.push_back(pitch[i]);
  }
  ASSERT_GE(highs.size(), 2u);
  ASSERT_GE(lows.size(), 2u);
  const double period = times[1] - times[0];
  // The soles' own inertia and the vertical springs are left out of the hand calculation.
  EXPECT_NEAR(period / (2.0 * 3.14159265358979 / w), 1.0, 0.02);
  // Swing over swing: where the robot comes to rest drops out.
  const double decrement = std::log((highs[0] - lows[0]) / (highs[1] - lows[1]));
  EXPECT_NEAR(decrement / (decay * period), 1.0, 0.05);
}

// Pitch [rad] after 0.4 s of rocking on the bushes: every law of a standing robot takes part.
double rock(double dt) {
  Stand stand;
  rigs::add_bushes(make_bush(), &stand.biped);
  stand.scenario.time_step = dt;
  Simulator simulator = stand.make();
  const Model model(simulator.tree());
  State state = simulator.state();
  state.V_WB[3] = 0.05;  // [m/s]
  EXPECT_TRUE(simulator.reset(state));
  const long steps = std::lround(0.4 / dt);
  for (long k = 0; k < steps; ++k) {
    EXPECT_EQ(simulator.step(stand.finder.find(model, simulator.state()), stand.command), StepStatus::kOk);
  }
  return 2.0 * simulator.state().R_WB.y();
}

TEST(StandingBiped, ConvergesWithTheFirstOrderOfTheStep) {
  const double a = rock(4e-4), b = rock(2e-4), c = rock(1e-4);
  // The error is halved with the step. Landing and leaving points of the soles add a little that is not smooth.
  EXPECT_NEAR((a - b) / (b - c), 2.0, 0.3);
  EXPECT_LT(std::abs(b - c), 0.02 * std::abs(c)) << "and is small at 0.1 ms";
}

// Share of power above 200 Hz in the vertical force of the left foot, of its mean square.
double calc_chatter(Stand* stand, StepStatus* status) {
  Simulator simulator = stand->make();
  const Model model(simulator.tree());
  std::vector<double> force;
  for (int i = 0; i < 1512 && *status == StepStatus::kOk; ++i) {
    *status = simulator.step(stand->finder.find(model, simulator.state()), stand->command);
    if (i >= 1000) force.push_back(simulator.foot_forces()[0]);
  }
  double high = 0.0, all = 0.0;
  const size_t n = force.size();
  for (size_t k = 0; k < n; ++k) {
    std::complex<double> sum = 0.0;
    for (size_t i = 0; i < n; ++i) sum += force[i] * std::polar(1.0, -2.0 * M_PI * static_cast<double>(k * i % n) / n);
    const double f = static_cast<double>(std::min(k, n - k)) / (1e-3 * static_cast<double>(n));
    all += std::norm(sum);
    if (f > 200.0) high += std::norm(sum);
  }
  return all > 0.0 ? high / all : 1.0;
}

Stand make_stiff_stand() {
  Stand stand;
  FootBushSpec bush = make_bush();
  bush.kz = 5e5;
  bush.cz = 1e3;
  bush.k_roll = bush.k_pitch = 1000.0;
  bush.c_roll = bush.c_pitch = 25.0;
  rigs::add_bushes(bush, &stand.biped);
  stand.scenario.contact.stiffness = 5e5;
  return stand;
}

TEST(StiffSoles, AreQuietAtOneMillisecondWhereTheExplicitFormChatters) {
  Stand stand = make_stiff_stand();
  StepStatus status = StepStatus::kOk;
  EXPECT_LT(calc_chatter(&stand, &status), 0.01);
  EXPECT_EQ(status, StepStatus::kOk);
  Stand plain = make_stiff_stand();
  plain.scenario.integrator = "semi_implicit_euler";
  status = StepStatus::kOk;
  const double chatter = calc_chatter(&plain, &status);
  EXPECT_TRUE(status != StepStatus::kOk || chatter > 0.01) << chatter;
}

TEST(Contacts, NeverPullAlongTheirNormalAndStayInTheCone) {
  Stand stand;
  Simulator simulator = stand.make();
  const Model model(simulator.tree());
  double largest = 0.0;
  for (int i = 0; i < 2000; ++i) {  // shaken hard enough to leave the floor and to slip
    ExternalWrenches pushes(1);
    pushes[0].F_W << 0, 0, 0, 500.0 * std::sin(0.05 * i), 400.0 * std::cos(0.031 * i), 700.0 * std::sin(0.02 * i);
    ASSERT_EQ(simulator.step(stand.finder.find(model, simulator.state()), stand.command, pushes), StepStatus::kOk);
    for (const PairForce& pair : simulator.contact_forces()) {
      for (const PointForce& point : pair.points) {
        const double normal = point.n_BA_W.dot(point.total);
        ASSERT_GE(normal, -1e-9);
        const double excess = (point.total - normal * point.n_BA_W).norm() - 0.8 * normal;
        largest = std::max(largest, excess / std::max(normal, 1.0));
      }
    }
  }
  // Settled friction is within 1e-7 of the cone; what has not settled within 1e-6 is clipped.
  EXPECT_LT(largest, 1.1e-6);
}

TEST(Contacts, PartsAddUpToTheTotalToTheLastBit) {
  Stand stand;
  Simulator simulator = stand.make();
  const Model model(simulator.tree());
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(simulator.step(stand.finder.find(model, simulator.state()), stand.command), StepStatus::kOk);
    for (const PairForce& pair : simulator.contact_forces()) {
      EXPECT_EQ(pair.total, Vector6d(pair.spring + pair.damper + pair.friction));
      for (const PointForce& p : pair.points) EXPECT_EQ(p.total, Vector3d(p.spring + p.damper + p.friction));
    }
  }
}

TEST(Contacts, GiveTheSameBitsInWhateverOrderTheyAreListed) {
  Stand stand;
  Simulator forward = stand.make(), backward = stand.make();
  const Model model(forward.tree());
  for (int i = 0; i < 500; ++i) {
    ContactSet contacts = stand.finder.find(model, forward.state());
    ASSERT_EQ(forward.step(contacts, stand.command), StepStatus::kOk);
    std::reverse(contacts.begin(), contacts.end());
    for (ContactPair& pair : contacts) std::reverse(pair.points.begin(), pair.points.end());
    ASSERT_EQ(backward.step(contacts, stand.command), StepStatus::kOk);
    ASSERT_EQ(forward.state_hash(), backward.state_hash()) << i;
  }
}

TEST(Links, MayBeListedInAnotherOrder) {
  Stand stand;
  Simulator forward = stand.make();
  Stand swapped;  // right leg first
  auto& links = swapped.biped.robot.tree.links;
  std::rotate(links.begin() + 1, links.begin() + 5, links.end());
  for (size_t i = 1; i < links.size(); ++i) links[i].parent = (i - 1) % 4 == 0 ? 0 : static_cast<int>(i) - 1;
  std::swap(swapped.biped.feet[0], swapped.biped.feet[1]);
  Simulator backward = swapped.make();
  const Model a(forward.tree()), b(backward.tree());
  for (int i = 0; i < 500; ++i) {
    ASSERT_EQ(forward.step(stand.finder.find(a, forward.state()), stand.command), StepStatus::kOk);
    ASSERT_EQ(backward.step(swapped.finder.find(b, backward.state()), swapped.command), StepStatus::kOk);
  }
  // Sums are formed in another order: rounding only.
  EXPECT_LT((forward.state().p_WB - backward.state().p_WB).norm(), 1e-10);
  EXPECT_LT((forward.state().q.head(4) - backward.state().q.tail(4)).norm(), 1e-10);
}

}  // namespace
}  // namespace hrp
