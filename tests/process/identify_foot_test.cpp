// SPDX-License-Identifier: BSD-3-Clause
// What a user of scripts/identify_foot.sh does with logs of one's own: an experiment of MCAP recordings, and the scenario
// that comes out run by the server set.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/robot/scenario.h"
#include "diagnosis/identification/motions.h"
#include "tests/process/server_set.h"

namespace hrp::test {
namespace {

const char* const kScenario = HRP_SOURCE_DIR "/models/scenarios/paper_b/foot.yaml";

TEST(IdentifyFoot, TakesLogsOfTheServerSetAndGivesAScenarioThatItRuns) {
  const Scenario base = load_scenario(kScenario);
  const std::string folder = get_test_folder();
  std::ofstream experiment(folder + "/experiment.yaml");
  std::string text = base.text;
  const std::string robot = "../../hrp2p_like";
  text.replace(text.find(robot), robot.size(), HRP_SOURCE_DIR "/models/hrp2p_like");
  experiment << text << "recordings:\n";
  std::vector<std::pair<std::string, std::string>> runs = {{"hanging", identification::write_hanging(base, folder)}};
  const std::vector<identification::MotionPlan> plans = identification::make_plans(0.5);
  for (size_t i : {size_t{0}, size_t{4}}) runs.push_back({plans[i].name, identification::write_motion(plans[i], base, folder)});
  for (const auto& [name, path] : runs) {
    ServerSet set(name, {path, "--no-plot"});
    ASSERT_EQ(set.wait(), 0) << set.output();
    std::filesystem::create_directories(folder + "/" + name);  // the recording's name is its file's
    std::filesystem::copy_file(set.log(), folder + "/" + name + "/" + name + ".mcap");
    experiment << "  - {file: " << folder << "/" << name << "/" << name << ".mcap, role: train}\n";
  }
  experiment.close();
  Program identify({"hrp-identify-foot", "experiment", folder + "/experiment.yaml", "--out", folder + "/out"});
  ASSERT_EQ(identify.wait(), 0) << identify.output();
  const Scenario found = load_scenario(folder + "/out/identified.yaml");
  // Two motions of 12 s: intervals of 0.2 %.
  EXPECT_NEAR(found.foot_bush.at(base.feet[0]).k_pitch / base.foot_bush.at(base.feet[0]).k_pitch, 1.0, 0.02);
  EXPECT_NEAR(found.foot_bush.at(base.feet[1]).k_roll / base.foot_bush.at(base.feet[1]).k_roll, 1.0, 0.02);
  ServerSet again("identified", {folder + "/out/identified.yaml", "--no-plot", "--duration", "1"});
  EXPECT_EQ(again.wait(), 0) << again.output();
}

}  // namespace
}  // namespace hrp::test
