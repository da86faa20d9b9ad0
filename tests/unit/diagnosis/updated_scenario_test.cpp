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

// The robot's servo reads its own sensors in time; only the file is late.
TEST(UpdatedScenario, SaysThatALateLogIsNoFaultOfTheRobot) {
  const Experiment e = make_simulated_experiment("updated_late", kArm, {"shoulder", "elbow"}, {});
  Reports reports = make_empty_reports(make_problem(e, 1), "a test");
  reports.report["findings"] = {{{"effect", "sensor_delay"}, {"where", {{"sensor", "/joint_states/elbow/effort"}}},
                                 {"parameters", {{"delay", {{"value", 0.01}}}}}}};
  const std::string folder = (std::filesystem::temp_directory_path() / "updated_late_out").string();
  write_reports(e, folder, reports);
  std::ifstream in(folder + "/updated/scenario.yaml");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  EXPECT_NE(text.find("# not simulated: sensor_delay at /joint_states/elbow/effort: a fault of the log, not of the robot; see report.json\n"),
            std::string::npos) << text;
}

}  // namespace
}  // namespace hrp::diagnosis
