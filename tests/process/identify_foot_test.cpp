// SPDX-License-Identifier: BSD-3-Clause
// What a user of scripts/identify_foot.sh does with logs of one's own: an experiment of MCAP recordings, and the
// scenario that comes out run by the server set.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "common/robot/scenario.h"
#include "diagnosis/identification/motions.h"
#include "diagnosis/identification/robot_log.h"
#include "tests/process/server_set.h"
#include "tests/test_places.h"

namespace hrp::test {
namespace {

constexpr size_t kOneFoot = 9;  // of make_plans: a hand holds the robot, the left foot is lifted
const std::string kScenario = source_dir() + "/models/scenarios/paper_b/foot.yaml";

TEST(IdentifyFoot, TakesLogsOfTheServerSetAndGivesAScenarioThatItRuns) {
  const Scenario base = load_scenario(kScenario);
  const std::string folder = get_test_folder();
  std::ofstream experiment(folder + "/experiment.yaml");
  std::string text = base.text;
  const std::string robot = "../../hrp2p_like";
  text.replace(text.find(robot), robot.size(), source_dir() + "/models/hrp2p_like");
  experiment << text << "recordings:\n";
  std::vector<std::pair<std::string, std::string>> runs = {{"hanging", identification::write_hanging(base, folder)}};
  const std::vector<identification::MotionPlan> plans = identification::make_plans(0.5);
  for (size_t i : {size_t{0}, size_t{4}, kOneFoot})
    runs.push_back({plans[i].name, identification::write_motion(plans[i], base, folder)});
  for (const auto& [name, path] : runs) {
    ServerSet set(name, {path, "--no-plot"});
    ASSERT_EQ(set.wait(), 0) << set.output();
    std::filesystem::create_directories(folder + "/" + name);  // the recording's name is its file's
    std::filesystem::copy_file(set.log(), folder + "/" + name + "/" + name + ".mcap");
    experiment << "  - {file: " << folder << "/" << name << "/" << name << ".mcap, role: train}\n";
  }
  experiment.close();
  // The hand that holds the robot on one foot is the same through the servers and in one process: to the bit.
  const std::string one_foot = plans[kOneFoot].name;
  const identification::RobotLog there = identification::read_mcap(folder + "/" + one_foot + "/" + one_foot + ".mcap"),
                                 here = identification::run_in_process(load_scenario(runs.back().second));
  ASSERT_EQ(there.size(), here.size());
  EXPECT_EQ(there.q, here.q);
  EXPECT_EQ(there.wrenches[0], here.wrenches[0]);
  EXPECT_EQ(there.gyro, here.gyro);
  Program identify({"hrp-identify-foot", "experiment", folder + "/experiment.yaml", "--out", folder + "/out"});
  ASSERT_EQ(identify.wait(), 0) << identify.output();
  const Scenario found = load_scenario(folder + "/out/identified.yaml");
  // Three motions of 12 s: intervals of 0.2 %.
  EXPECT_NEAR(found.foot_bush.at(base.feet[0]).k_pitch / base.foot_bush.at(base.feet[0]).k_pitch, 1.0, 0.02);
  EXPECT_NEAR(found.foot_bush.at(base.feet[1]).k_roll / base.foot_bush.at(base.feet[1]).k_roll, 1.0, 0.02);
  // As a user does, script and all; what it builds first is built already.
  setenv("HRP_BUILD_DIR", (bin_dir() + "/..").c_str(), 1);
  const std::string log = folder + "/identified.mcap";
  Program again({source_dir() + "/scripts/simulate.sh", folder + "/out/identified.yaml", "--no-plot", "--duration", "1",
                 "--log", log});
  EXPECT_EQ(again.wait(), 0) << again.output();
  EXPECT_EQ(find_last_step(log), 2000);
}

TEST(IdentifyFoot, RefusesWhatItCannotUseBeforeItsWork) {
  const std::string folder = get_test_folder();
  const auto refuse = [](std::vector<std::string> words, const std::string& said) {
    words.insert(words.begin(), "hrp-identify-foot");
    Program program(words);
    EXPECT_EQ(program.wait(), 2) << program.output();
    EXPECT_NE(program.output().find(said), std::string::npos) << program.output();
  };
  refuse({"make", kScenario, folder + "/made", "--scale", "nan"}, "--scale");
  refuse({"make", kScenario, "/proc/none"}, "/proc/none: error: cannot be made");
  refuse({"fit", kScenario, folder, "--out", "/proc/none"}, "/proc/none: error: cannot be made");
  refuse({"fit", kScenario, folder, "--out", folder + "/out"}, "motions.txt");
  refuse({"coverage", kScenario, folder, "--seeds", "1"}, "motions.txt");
}

}  // namespace
}  // namespace hrp::test
