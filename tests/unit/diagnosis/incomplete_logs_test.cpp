// SPDX-License-Identifier: BSD-3-Clause
// Logs that lack something: what is there is judged, and what is not there is said.
#include <gmock/gmock.h>

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
  return diagnose_recordings(e, {}, [](const std::string&) {}, [](const Reports&) {}).report;
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

}  // namespace
}  // namespace hrp::diagnosis
