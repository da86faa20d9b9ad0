// SPDX-License-Identifier: BSD-3-Clause
// Other people's robots load with the mass and joints that their notes state, or are refused as they should be.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/multibody/tree_mass.h"
#include "common/robot/sole.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/shared_files.h"

namespace hrp {
namespace {

using ::testing::HasSubstr;

struct Expected {
  const char* file;
  const char* more;  // scenario
  int joints;
  double mass;  // [kg] as in its note, four decimals
  size_t shapes;
};

std::string find_robot(const std::string& file) { return find_shared("robots/" + file); }

Scenario make_scenario(const std::string& urdf, const std::string& more) {
  return parse_scenario("robot: " + urdf + "\n" + more, "/test.yaml");
}

class RealRobot : public ::testing::TestWithParam<Expected> {};

TEST_P(RealRobot, LoadsWithTheMassAndJointsOfItsNote) {
  const std::string path = find_robot(GetParam().file);
  if (path.empty()) GTEST_SKIP() << "NOT TESTED: ../shared/robots/" << GetParam().file << " is not there";
  const RobotDescription robot = load_robot(make_scenario(path, GetParam().more));
  EXPECT_EQ(robot.tree.num_joints(), GetParam().joints);
  EXPECT_NEAR(calc_mass(robot.tree), GetParam().mass, 5.1e-5) << "the note has four decimals";
  EXPECT_EQ(robot.shapes.size(), GetParam().shapes);
  for (size_t i = 1; i < robot.tree.links.size(); ++i) EXPECT_LT(robot.tree.links[i].parent, static_cast<int>(i));
}

TEST_P(RealRobot, DamagedFilesAreRefusedOrReadButNeverCrash) {
  const std::string path = find_robot(GetParam().file);
  if (path.empty()) GTEST_SKIP() << "NOT TESTED: ../shared/robots/" << GetParam().file << " is not there";
  const Scenario scenario = make_scenario(path, GetParam().more);
  const std::string good = load_robot(scenario).urdf;
  unsigned random = 12345u;
  const auto draw = [&](size_t n) { return static_cast<size_t>((random = random * 1664525u + 1013904223u) >> 8) % n; };
  int refused = 0;
  for (int i = 0; i < 40; ++i) {
    std::string text = good;
    if (i % 4 == 0) text.resize(draw(text.size()));
    for (size_t k = 0; k < 1 + draw(6) && !text.empty(); ++k)
      text[draw(text.size())] = "<>/=\"'&0.-xe \n\x01\xff"[draw(17)];
    try {
      parse_robot(text, path, scenario);
    } catch (const InputError& error) {
      EXPECT_FALSE(error.diagnostics().empty());
      ++refused;
    }
  }
  EXPECT_GT(refused, 10);
}

INSTANTIATE_TEST_SUITE_P(
    Shared, RealRobot,
    ::testing::Values(Expected{"atlas/atlas_minimal_contact.urdf", "feet: [l_foot, r_foot]", 30, 175.1180, 16},
                      Expected{"ergocub/ergoCubSN002.urdf", "", 57, 56.9861, 4},
                      Expected{"ergocub/ergoCubGazeboV1_3_minContacts.urdf",
                               "feet: [l_foot_front, l_foot_rear, r_foot_front, r_foot_rear]", 57, 56.9861, 4},
                      Expected{"jvrc1/jvrc1.urdf", "feet: [L_ANKLE_P_S, R_ANKLE_P_S]", 44, 62.4000, 2},
                      Expected{"robotis_op3/robotis_op3.urdf", "feet: [l_ank_roll_link, r_ank_roll_link]", 20, 3.1475,
                               2},
                      Expected{"sr1/SR1.urdf", "feet: [LLEG_ANKLE_R, RLEG_ANKLE_R]", 29, 130.8000, 47},
                      Expected{"unitree_g1/g1_29dof_rev_1_0.urdf",
                               "feet: [left_ankle_roll_link, right_ankle_roll_link]", 29, 33.3411, 12},
                      Expected{"unitree_h1/h1.urdf", "feet: [left_ankle_link, right_ankle_link]", 19, 59.3380, 23}));

TEST(RealRobots, Hrp4cIsRefusedForTenInertiasEachWithItsLine) {
  const std::string path = find_robot("hrp4c/HRP4Cmain.urdf");
  if (path.empty()) GTEST_SKIP() << "NOT TESTED: ../shared/robots/hrp4c is not there";
  try {
    load_robot(make_scenario(path, ""));
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.diagnostics().size(), 10u);
    for (const Diagnostic& d : error.diagnostics()) EXPECT_GT(d.line, 0);
    for (const char* link : {"L_WRIST_R_LINK", "R_WRIST_R_LINK", "CHEEK_P_LINK", "EYEBROW_P_LINK", "EYELID_P_LINK",
                             "EYE_P_LINK", "EYE_Y_LINK", "MOUTH_P_LINK", "LOWERLIP_P_LINK", "UPPERLIP_P_LINK"}) {
      EXPECT_THAT(error.what(), HasSubstr(std::string("link '") + link + "'"));
    }
  }
}

TEST(RealRobots, Hrp4cIsAcceptedWithRepairAndTheRepairsAreListed) {
  const std::string path = find_robot("hrp4c/HRP4Cmain.urdf");
  if (path.empty()) GTEST_SKIP() << "NOT TESTED: ../shared/robots/hrp4c is not there";
  const RobotDescription robot = load_robot(make_scenario(path, "repair_inertias: true"));
  EXPECT_EQ(robot.tree.num_joints(), 42);
  EXPECT_NEAR(calc_mass(robot.tree), 42.7721, 5.1e-5);
  int repairs = 0;
  for (const std::string& warning : robot.warnings) repairs += warning.find("repaired to") != std::string::npos ? 1 : 0;
  EXPECT_EQ(repairs, 10);
}

TEST(RealRobots, AMissingFootMeshNeedsASoleBox) {
  const std::string path = find_robot("hrp4c/HRP4Cmain.urdf");
  if (path.empty()) GTEST_SKIP() << "NOT TESTED: ../shared/robots/hrp4c is not there";
  const std::string feet = "repair_inertias: true\nfeet: [L_ANKLE_R_LINK, R_ANKLE_R_LINK]\n";
  EXPECT_THROW(load_robot(make_scenario(path, feet)), InputError);
  const std::string soles =
      "soles:\n  L_ANKLE_R_LINK: {box: [0.16, 0.076, 0.02], xyz: [0.02, 0.01, -0.083]}\n"
      "  R_ANKLE_R_LINK: {box: [0.16, 0.076, 0.02], xyz: [0.02, -0.01, -0.083]}\n";
  EXPECT_EQ(load_robot(make_scenario(path, feet + soles)).shapes.size(), 2u);
}

// Height of the base at which the soles touch the ground at zero pose, from the notes: foot frame below the base plus
// sole below the foot frame, both to 0.1 mm.
TEST(RealRobots, StandAtTheHeightsOfTheirNotes) {
  const struct {
    const char* file;
    const char* more;
    double height;
  } cases[] = {
      {"sr1/SR1.urdf", "feet: [LLEG_ANKLE_R, RLEG_ANKLE_R]", 0.7135 - 0.005},  // "about 5 mm above contact"
      {"unitree_g1/g1_29dof_rev_1_0.urdf", "feet: [left_ankle_roll_link, right_ankle_roll_link]", 0.7569 + 0.035},
      {"robotis_op3/robotis_op3.urdf", "feet: [l_ank_roll_link, r_ank_roll_link]", 0.2486 + 0.0305},
      {"atlas/atlas_minimal_contact.urdf", "feet: [l_foot, r_foot]", 0.8620 + 0.07645}};
  for (const auto& c : cases) {
    const std::string path = find_robot(c.file);
    if (path.empty()) GTEST_SKIP() << "NOT TESTED: ../shared/robots/" << c.file << " is not there";
    const Scenario scenario = make_scenario(path, c.more);
    EXPECT_NEAR(make_start_state(load_robot(scenario), scenario).p_WB.z(), c.height, 6e-4) << c.file;
  }
}

// Both JVRC-1 feet come from meshes; the left one hides a scale of 0.01 in a node of its .dae.
TEST(RealRobots, MeshNodesScaleTheSolesOfJvrc1) {
  const std::string path = find_robot("jvrc1/jvrc1.urdf");
  if (path.empty()) GTEST_SKIP() << "NOT TESTED: ../shared/robots/jvrc1 is not there";
  const auto soles = make_soles(load_robot(make_scenario(path, "feet: [L_ANKLE_P_S, R_ANKLE_P_S]")));
  ASSERT_EQ(soles.size(), 2u);
  for (const Sole& sole : soles) {
    double low = 1.0, front = -1.0;
    for (const SolePoint& point : sole.points) {
      low = std::min(low, point.p_LQ.z());
      front = std::max(front, point.p_LQ.x());
    }
    EXPECT_NEAR(low, -0.1077, 1e-3) << "the note's contact rectangle";
    EXPECT_NEAR(front, 0.157, 1e-3) << "the note's bounding box";
  }
}

}  // namespace
}  // namespace hrp
