// SPDX-License-Identifier: BSD-3-Clause
// The scenario that replays a recording begins where the recording does: a robot that jumps there is thrown.
#include "common/robot/scenario.h"
#include "diagnosis/report/report.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

Scenario write_updated(const std::string& name, double moved) {
  Experiment e = make_simulated_experiment(name, kArm, {"shoulder", "elbow"}, {});
  for (double& q : e.recordings.back().joints[0].signal[0]) q += moved;
  const std::string folder = (std::filesystem::temp_directory_path() / (name + "_out")).string();
  write_reports(e, folder, make_empty_reports(make_problem(e, 1), "a test"));
  return load_scenario(folder + "/updated/scenario.yaml");
}

TEST(UpdatedScenario, BeginsAtTheFirstSampleOfWhatItReplays) {
  const Scenario scenario = write_updated("updated_moved", 0.5);
  ASSERT_EQ(scenario.initial_joints.count("shoulder"), 1u);
  EXPECT_NEAR(scenario.initial_joints.at("shoulder"), 0.5, 1e-3);  // noise of the encoder: 2e-5 rad
}

TEST(UpdatedScenario, KeepsTheStartThatTheExperimentStatesWhereItIsTheSame) {
  EXPECT_TRUE(write_updated("updated_same", 0.0).initial_joints.empty());
}

}  // namespace
}  // namespace hrp::diagnosis
