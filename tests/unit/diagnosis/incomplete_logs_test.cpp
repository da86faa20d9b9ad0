// SPDX-License-Identifier: BSD-3-Clause
// Logs that lack something: what is there is judged, and what is not there is said.
#include <gmock/gmock.h>

#include "diagnosis/conventions/effort_dropouts.h"
#include "diagnosis/data/stretches.h"
#include "diagnosis/diagnose_recordings.h"
#include "diagnosis/page/terminal.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string kElbowEffort = "/joint_states/elbow/effort";

// An arm with friction and rotors, driven by its efforts; of these recordings the elbow's was not logged.
Experiment make_unlogged(const std::string& name, const std::vector<size_t>& recordings) {
  Experiment e = simulate_arm(name, make_arm_drives());
  e.scenario.drive = "effort";
  for (size_t r : recordings) e.recordings[r].joints[kElbow].signal[static_cast<size_t>(Quantity::kEffort)].clear();
  return e;
}

Json diagnose(const Experiment& e) {
  return diagnose_recordings(
             e, {}, [](const std::string&) {}, [](const Reports&) {})
      .report;
}

// Value of a joint's first parameter; 0 if the effect was not found there.
double find_value(const Json& report, const std::string& effect, const std::string& joint) {
  for (const Json& f : report["findings"]) {
    if (f["effect"] == effect && f["where"].value("joint", "") == joint) return f["parameters"].begin()->at("value");
  }
  return 0.0;
}

TEST(IncompleteLogs, WithoutTheEffortOfOneJointTheOtherIsJudged) {
  const Json report = diagnose(make_unlogged("unlogged_elbow", {0, 1, 2}));
  // A tenth: friction over the load and at low speed are shared among three effects.
  EXPECT_NEAR(find_value(report, "rotor_inertia", "shoulder"), 0.6, 0.06) << report["findings"].dump(1);
  EXPECT_NEAR(find_value(report, "coulomb_friction", "shoulder"), 1.5, 0.15);
  for (const Json& f : report["findings"]) EXPECT_NE(f["where"].value("joint", ""), "elbow") << f["statement"];
  const std::string text = make_terminal_text(report);
  EXPECT_THAT(report["missing"].dump(), HasSubstr("r0.csv, r1.csv, r2.csv: no column " + kElbowEffort));
  EXPECT_THAT(text, HasSubstr(kElbowEffort));
  EXPECT_THAT(text, Not(HasSubstr("foot")));
}

TEST(IncompleteLogs, ATurnedEffortAndAMotionThatIsNoBetterAreToldInWords) {
  const auto make = [](const char* effect, const char* kind, const std::string& place, double value) {
    return Json{{"effect", effect},
                {"where", {{kind, place}}},
                {"grade", "supported"},
                {"share", 0.5},
                {"weight", 0.5},
                {"statement", place + ": ."},
                {"alternatives", Json::array()},
                {"parameters", {{"scale", {{"value", value}, {"unit", "1"}}}}}};
  };
  const Json findings{make("sensor_scale", "sensor", kElbowEffort, -1.0),
                      make("sensor_scale", "sensor", "/joint_states/shoulder/velocity", 1.2),
                      make("viscous_friction", "joint", "elbow", 2.0), make("coulomb_friction", "joint", "elbow", 1.0)};
  const std::string text = make_terminal_text(
      {{"verdict", "partly_explained"}, {"findings", findings}, {"motion", "The motion is not better."}});
  EXPECT_THAT(text, HasSubstr("The recorded effort has the opposite sign at sensor " + kElbowEffort + "."));
  EXPECT_THAT(text, HasSubstr("The motion is not better."));
}

TEST(IncompleteLogs, AnEffortThatOneRecordingLacksIsTakenFromTheOthers) {
  for (const size_t lacking : {0u, 2u}) {
    const Json report = diagnose(make_unlogged("unlogged_once", {lacking}));
    EXPECT_NEAR(find_value(report, "rotor_inertia", "elbow"), 0.3, 0.03) << report["findings"].dump(1);
    EXPECT_NEAR(find_value(report, "coulomb_friction", "elbow"), 0.8, 0.08);
    EXPECT_THAT(report["missing"].dump(), HasSubstr("r" + std::to_string(lacking) + ".csv: no column " + kElbowEffort));
  }
}

TEST(IncompleteLogs, WithoutAnyEffortColumnsAreNamed) {
  Experiment e = make_unlogged("unlogged_all", {0, 1, 2});
  for (Recording& r : e.recordings) r.joints[kShoulder].signal[static_cast<size_t>(Quantity::kEffort)].clear();
  const Json report = diagnose(e);
  EXPECT_EQ(report["verdict"], "not_judged");
  EXPECT_THAT(report["missing"].dump(), HasSubstr("/joint_states/shoulder/effort"));
  EXPECT_THAT(report.dump(), Not(HasSubstr("foot")));
}

// The first 4 s, with the shoulder's effort set to `value(effort before)` for 0.3 s of every 1.4 s.
template <typename Value>
Experiment make_dropping(const std::string& name, Value value) {
  Experiment e = make_unlogged(name, {});
  for (Recording& r : e.recordings) {
    r = cut_recording(r, 0, r.time.size() * 2 / 3);
    std::vector<double>& effort = r.joints[kShoulder].signal[static_cast<size_t>(Quantity::kEffort)];
    for (size_t begin = 150; begin + 60 < effort.size(); begin += 280)
      std::fill_n(effort.begin() + static_cast<long>(begin), 60, value(effort[begin]));
  }
  return e;
}

void expect_left_out(const Experiment& e) {
  const std::vector<Dropout> found = find_dropouts(e);
  ASSERT_GE(found.size(), 8u);  // three in each recording; one ends near the value that it held
  for (const Dropout& d : found) EXPECT_EQ(d.end - d.begin, 60u) << d.begin;
  const Json report = diagnose(e);
  EXPECT_NEAR(find_value(report, "rotor_inertia", "shoulder"), 0.6, 0.06)
      << report["findings"].dump(1);  // a tenth, as above
  EXPECT_NEAR(find_value(report, "coulomb_friction", "shoulder"), 1.5, 0.15);
  EXPECT_THAT(report["warnings"].dump(), HasSubstr("r0.csv (0 to 3.995 s): /joint_states/shoulder/effort is exactly"));
}

TEST(IncompleteLogs, EffortsThatALogLosesAreLeftOutWithAWarning) {
  expect_left_out(make_dropping("dropping_hold", [](double last) { return last; }));
}

TEST(IncompleteLogsNightly, EffortsThatALogHasAsZeroAreLeftOutToo) {
  expect_left_out(make_dropping("dropping_zero", [](double) { return 0.0; }));
}

// A drive that is released: its effort is 0, and the arm coasts.
TEST(IncompleteLogs, EffortsThatTheMotionTakesStayHoweverConstantTheyAre) {
  constexpr double kStep = 0.005, kInertia = 0.1, kViscous = 0.2, kDry = 0.1;
  const std::string disc = R"(<robot name="disc"><link name="stand"/>
    <link name="disc"><inertial><mass value="1"/><inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.1"/></inertial></link>
    <joint name="motor" type="continuous"><parent link="stand"/><child link="disc"/><axis xyz="0 0 1"/>
      <limit effort="50" velocity="100"/></joint></robot>)";
  Experiment e = make_simulated_experiment("coasting", disc, {"motor"}, {});
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    double q = 0.0, v = 0.0;
    for (size_t k = 0; k < r.size(); ++k) {
      const double t = r.time[k],
                   effort = std::fmod(t, 1.5) > 1.1 ? 0.0 : 2.0 * std::sin(2.5 * t) + std::sin(7.0 * t + 0.3);
      r.joints[0].signal[0][k] = q;
      r.joints[0].signal[1][k] = v;
      r.joints[0].signal[2][k] = effort;
      v += kStep / kInertia * (effort - kViscous * v - kDry * std::tanh(v / 0.01));
      q += kStep * v;
    }
  }
  EXPECT_TRUE(find_dropouts(e).empty());
}

}  // namespace
}  // namespace hrp::diagnosis
