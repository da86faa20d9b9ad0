// SPDX-License-Identifier: BSD-3-Clause
// The scenario that replays a recording begins where the recording does: a robot that jumps there is thrown.
#include "common/robot/scenario.h"
#include "diagnosis/evidence/best_model.h"
#include "diagnosis/evidence/torque/report.h"
#include "diagnosis/report/report.h"
#include "servers/dynamics/joint_effects.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/test_places.h"
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

Scenario write_updated(const std::string& name, double moved) {
  return load_scenario(write_updated(name, moved, Json::array()));
}

std::string read_text(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string write_updated(const std::string& name, const Json& findings) {
  return read_text(write_updated(name, 0.0, findings));
}

TEST(UpdatedScenario, BeginsAtTheFirstSampleOfWhatItReplays) {
  const Scenario scenario = write_updated("updated_moved", 0.5);
  ASSERT_EQ(scenario.initial_joints.count("shoulder"), 1u);
  EXPECT_NEAR(scenario.initial_joints.at("shoulder"), 0.5, 1e-3);  // noise of the encoder: 2e-5 rad
}

TEST(UpdatedScenario, KeepsTheStartThatTheExperimentStatesWhereItIsTheSame) {
  EXPECT_TRUE(write_updated("updated_same", 0.0).initial_joints.empty());
}

// What a simulation is compared with, where the recording is a file with these first lines.
std::string find_replayed_file(const std::string& name, const std::string& lines) {
  Experiment e = make_simulated_experiment(name, kArm, {"shoulder", "elbow"}, {});
  const std::string folder = (std::filesystem::temp_directory_path() / name).string();
  std::filesystem::create_directories(folder);
  for (Recording& r : e.recordings) {
    r.spec.file = folder + "/log.csv";
    r.column_of = {{"time", 1}, {"/joint_states/shoulder/position", 2}};
    r.other["/wrench/tool/fz"] = std::vector<double>(r.size(), 4.0);
  }
  std::ofstream(folder + "/log.csv") << lines;
  Reports reports = make_empty_reports(make_problem(e, 1), "a test");
  write_reports(e, folder, reports);
  return Json::parse(read_text(folder + "/series.json"))["updated"]["replays"];
}

TEST(UpdatedScenario, IsComparedWithTheRecordingWhoseFileNamesItsSignals) {
  const std::string file = find_replayed_file("updated_own", "# a log\ntime,/joint_states/shoulder/position\n0,0\n");
  EXPECT_EQ(std::filesystem::path(file).filename(), "log.csv");
  for (const char* lines :
       {"ms;q\n0;0\n", "0 0\n", "time,q\n0,0\n", "time,/joint_states/shoulder/position\n2026-11-28T14:36:19,0\n"}) {
    const std::string copy = find_replayed_file("updated_others", lines);
    EXPECT_EQ(std::filesystem::path(copy).filename(), "recorded.csv") << lines;
    const std::string text = read_text(copy);
    EXPECT_EQ(text.rfind("time,/joint_states/shoulder/position,", 0), 0u) << text.substr(0, 80);
    EXPECT_NE(text.find(",/wrench/tool/fz\n"), std::string::npos) << text.substr(0, 300);
  }
}

// The robot's servo reads its own sensors in time; only the file is late.
TEST(UpdatedScenario, SaysThatALateLogIsNoFaultOfTheRobot) {
  const std::string text = write_updated("updated_late", {{{"effect", "sensor_delay"},
                                                           {"where", {{"sensor", "/joint_states/elbow/effort"}}},
                                                           {"parameters", {{"delay", {{"value", 0.01}}}}}}});
  EXPECT_NE(text.find("# not simulated: sensor_delay at /joint_states/elbow/effort: a fault of the log, not of the "
                      "robot; see report.json\n"),
            std::string::npos)
      << text;
}

// The value is how far a zero goes from the first to the last recording: no constant zero.
TEST(UpdatedScenario, HasNoConstantZeroInThePlaceOfOneThatDrifts) {
  const std::string text =
      write_updated("updated_drift", {{{"effect", "sensor_bias"},
                                       {"where", {{"sensor", "/wrench/l/force"}}},
                                       {"drifts", true},
                                       {"parameters", {{"value", {{"value", {0.0, 0.0, 12.0}}}}}}}});
  EXPECT_NE(text.find("# not simulated: sensor_bias at /wrench/l/force: it drifts, and the simulator's is constant; "
                      "see report.json\n"),
            std::string::npos)
      << text;
}

// Two encoders tell stiffness and damping of a transmission, the torque tells the rotor: the simulator needs all three.
TEST(UpdatedScenario, HasAnElasticTransmissionWithTheRotorThatWasFoundThere) {
  const Json rotor = {
      {"effect", "rotor_inertia"}, {"where", {{"joint", "elbow"}}}, {"parameters", {{"inertia", {{"value", 0.02}}}}}};
  const Json give = {{"effect", "joint_elasticity"},
                     {"where", {{"joint", "elbow"}}},
                     {"parameters", {{"stiffness", {{"value", 300.0}}}, {"damping", {{"value", 0.5}}}}}};
  const std::string text = write_updated("updated_elastic", Json{rotor, give});
  EXPECT_EQ(text.find("not simulated"), std::string::npos) << text;
  EXPECT_NE(text.find("\"rotor_inertia\":0.02"), std::string::npos) << text;
}

TEST(UpdatedScenario, HasASoleWithoutTheNegativeDampingThatNoiseLeftOver) {
  const Experiment e = load_experiment(source_dir() + "/models/experiments/standing/experiment.yaml");
  Reports reports = make_empty_reports(make_problem(make_simulated_experiment("sole", kArm, {"shoulder"}, {}), 1), "");
  const Json sole = {{"effect", "foot_compliance"},
                     {"where", {{"foot", e.scenario.feet.front()}}},
                     {"parameters",
                      {{"kz", {{"value", 2e5}}},
                       {"cz", {{"value", 900.0}}},
                       {"k_roll", {{"value", 300.0}}},
                       {"c_roll", {{"value", -0.5}}},
                       {"k_pitch", {{"value", 300.0}}},
                       {"c_pitch", {{"value", 2.0}}}}}};
  reports.report["findings"] = Json::array({sole});
  const std::string folder = (std::filesystem::temp_directory_path() / "updated_sole_out").string();
  write_reports(e, folder, reports);
  const std::string text = read_text(folder + "/updated/scenario.yaml");
  EXPECT_EQ(text.find("not simulated"), std::string::npos) << text;
  EXPECT_NE(text.find("\"c_roll\":0.0,"), std::string::npos) << text;
}

// The report says the gap; the simulator needs the rotor and the teeth behind it, too.
TEST(UpdatedScenario, HasPlayWithTheRotorAndTheTeethThatWereFitted) {
  const Json play = {{"effect", "backlash"},
                     {"where", {{"joint", "elbow"}}},
                     {"parameters", {{"gap", {{"value", 0.01}}}}},
                     {"also_fitted", {{"stiffness", 3000.0}, {"damping", 3.0}, {"rotor_inertia", 0.05}}}};
  const std::string text = write_updated("updated_play", Json{play});
  EXPECT_EQ(text.find("not simulated"), std::string::npos) << text;
  EXPECT_NE(text.find("\"rotor_inertia\":0.05"), std::string::npos) << text;
}

TEST(UpdatedScenario, OfPlayThatWasFittedNamesAllThatASimulatorNeeds) {
  const Json also = list_also_fitted({EffectId::kBacklash, kElbow, {0.01, 3000.0, 3.0, 0.05}});
  EXPECT_EQ(also, (Json{{"stiffness", 3000.0}, {"damping", 3.0}, {"rotor_inertia", 0.05}}));
  EXPECT_TRUE(list_also_fitted({EffectId::kViscous, kElbow, {0.1}}).empty());
}

// Friction that bends over 3 mrad before it slips: with another displacement the arm creeps at every reversal.
TEST(UpdatedScenario, IsTheModelWhoseErrorsTheReportStates) {
  Hypothesis model = make_arm_drives();
  model[1].p[2] = model[4].p[2] = 3e-3;
  model.push_back({EffectId::kHysteresis, kElbow, {30.0, 0.02}});
  Experiment e = simulate_arm("updated_model", model);
  const Problem problem = make_problem(e, 1);
  Reports reports = make_empty_reports(problem, "a test");
  reports.report["model"] = list_torque_model(e, model, Json::array());
  const std::string folder = (std::filesystem::temp_directory_path() / "updated_model_out").string();
  write_reports(e, folder, reports);
  Experiment back = e;
  back.scenario = load_scenario(folder + "/updated/scenario.yaml");
  const double stated = simulate_trial(problem, model).rms;
  EXPECT_NEAR(simulate_trial(make_problem(back, 1), {}).rms, stated, 1e-4 * stated);  // eight digits of each parameter
}

// A walk tells only how stiff an elastic joint is. The parts that it does not tell are marked.
TEST(UpdatedScenario, HasAnElasticJointOfWhichOnlyTheStiffnessIsKnown) {
  const Json give = {{"effect", "joint_elasticity"},
                     {"where", {{"joint", "elbow"}}},
                     {"grade", "ambiguous"},
                     {"parameters", {{"stiffness", {{"value", 300.0}}}}}};
  const std::string path = write_updated("updated_stiffness", 0.0, Json::array({give}));
  const std::string text = read_text(path);
  EXPECT_EQ(text.find("not simulated"), std::string::npos) << text;
  EXPECT_NE(text.find("# ambiguous; assumed: damping, rotor_inertia\n"), std::string::npos) << text;
  Scenario scenario = load_scenario(path);
  TreeSpec tree = parse_robot(kArm, "arm.urdf", scenario).tree;
  const JointLaws elbow = make_joint_laws(scenario, &tree)[1];
  EXPECT_TRUE(elbow.elastic);
  EXPECT_DOUBLE_EQ(elbow.stiffness, 300);
  EXPECT_GT(elbow.damping, 0);
  EXPECT_GT(elbow.motor_inertia, 0);
}

}  // namespace
}  // namespace hrp::diagnosis
