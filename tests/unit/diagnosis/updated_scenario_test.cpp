// SPDX-License-Identifier: BSD-3-Clause
// The scenario that replays a recording begins where the recording does: a robot that jumps there is thrown.
#include "common/robot/scenario.h"
#include "diagnosis/report/report.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// Path of the scenario for a report with these findings; the shoulder's held-out positions are `moved` [rad].
std::string write_updated(const std::string& name, double moved, const Json& findings) {
  Experiment e = make_simulated_experiment(name, kArm, {"shoulder", "elbow"}, {});
  for (double& q : e.recordings.back().joints[0].signal[0]) q += moved;
  Reports reports = make_empty_reports(make_problem(e, 1), "a test");
  reports.report["findings"] = findings;
  const std::string folder = (std::filesystem::temp_directory_path() / (name + "_out")).string();
  write_reports(e, folder, reports);
  return folder + "/updated/scenario.yaml";
}

Scenario write_updated(const std::string& name, double moved) { return load_scenario(write_updated(name, moved, Json::array())); }

std::string write_updated(const std::string& name, const Json& findings) {
  std::ifstream in(write_updated(name, 0.0, findings));
  return {std::istreambuf_iterator<char>(in), {}};
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
  const std::string text = write_updated("updated_late", {{{"effect", "sensor_delay"}, {"where", {{"sensor", "/joint_states/elbow/effort"}}},
                                                           {"parameters", {{"delay", {{"value", 0.01}}}}}}});
  EXPECT_NE(text.find("# not simulated: sensor_delay at /joint_states/elbow/effort: a fault of the log, not of the robot; see report.json\n"),
            std::string::npos) << text;
}

// Two encoders tell stiffness and damping of a transmission, the torque tells the rotor: the simulator needs all three.
TEST(UpdatedScenario, HasAnElasticTransmissionWithTheRotorThatWasFoundThere) {
  const Json rotor = {{"effect", "rotor_inertia"}, {"where", {{"joint", "elbow"}}}, {"parameters", {{"inertia", {{"value", 0.02}}}}}};
  const Json give = {{"effect", "joint_elasticity"}, {"where", {{"joint", "elbow"}}},
                     {"parameters", {{"stiffness", {{"value", 300.0}}}, {"damping", {{"value", 0.5}}}}}};
  const std::string text = write_updated("updated_elastic", Json{rotor, give});
  EXPECT_EQ(text.find("not simulated"), std::string::npos) << text;
  EXPECT_NE(text.find("\"rotor_inertia\":0.02"), std::string::npos) << text;
  EXPECT_NE(write_updated("updated_no_rotor", Json::array({give})).find("not simulated: joint_elasticity at elbow"), std::string::npos);
}

}  // namespace
}  // namespace hrp::diagnosis
