// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/robot_loader.h"

#include <filesystem>
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "servers/model_parser/inertia_check.h"
#include "servers/model_parser/mesh_path.h"
#include "tests/catch_complaint.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

using ::testing::HasSubstr;

const std::string kModels = source_dir() + "/models/";

Scenario make_scenario(const std::string& more = "") { return parse_scenario("robot: r.urdf\n" + more, "/dir/s.yaml"); }

RobotDescription load_arm(const std::string& more = "base: fixed\n") {
  return load_robot(parse_scenario("robot: " + kModels + "test_robots/arm.urdf\n" + more, kModels + "s.yaml"));
}

const char kInertia[] =
    "<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>";

std::string make_link(const std::string& name, const std::string& inside = kInertia) {
  return "<link name='" + name + "'>" + inside + "</link>\n";
}

std::string make_joint(const std::string& name, const std::string& type, const std::string& parent,
                       const std::string& child,
                       const std::string& inside = "<limit lower='-1' upper='1' effort='1' velocity='1'/>") {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child + "'/>" +
         inside + "</joint>\n";
}

std::string find_complaint(const std::string& body, const std::string& more = "") {
  return catch_complaint(
      [&] { parse_robot("<robot name='r'>\n" + body + "</robot>\n", "r.urdf", make_scenario(more)); });
}

TEST(RobotLoader, OtherFormatsAreRefusedByName) {
  const auto complain = [](const std::string& text) -> std::string {
    return catch_complaint([&] { parse_robot(text, "r.xml", make_scenario()); });
  };
  EXPECT_THAT(complain("<svg/>"), HasSubstr("neither URDF, MJCF nor SDF"));
}

TEST(RobotLoader, ReadsJointsInTheOrderOfTheFile) {
  const TreeSpec tree = load_arm().tree;
  ASSERT_EQ(tree.num_joints(), 5);
  const char* names[] = {"turn", "shoulder", "elbow", "grip", "grip_follower"};
  for (int i = 0; i < 5; ++i) EXPECT_EQ(tree.joint(i).name, names[i]);
  EXPECT_EQ(tree.joint(0).upper, std::numeric_limits<double>::infinity()) << "continuous";
  EXPECT_EQ(tree.joint(3).kind, JointKind::kPrismatic);
  EXPECT_DOUBLE_EQ(tree.joint(1).rotor_inertia, 0.04);
  EXPECT_DOUBLE_EQ(tree.joint(0).viscous_friction, 0.4);
  EXPECT_DOUBLE_EQ(tree.joint(0).coulomb_friction, 0.2);
  EXPECT_EQ(tree.joint(4).mimic.joint, 3);
  EXPECT_DOUBLE_EQ(tree.joint(4).mimic.multiplier, -1.0);
}

TEST(RobotLoader, FixedLinksAreLumpedAndKeepTheirFrames) {
  const TreeSpec tree = load_arm().tree;
  const int counterweight = tree.find_frame("counterweight");
  ASSERT_GE(counterweight, 0);
  const FrameSpec& frame = tree.frames[static_cast<size_t>(counterweight)];
  EXPECT_EQ(tree.links[static_cast<size_t>(frame.link)].name, "upper_arm");
  EXPECT_TRUE(frame.X_LF.p.isApprox(Vector3d(-0.12, 0, 0)));
  const LinkInertia& inertia = tree.links[static_cast<size_t>(frame.link)].inertia;
  EXPECT_DOUBLE_EQ(inertia.mass, 4.0);
  EXPECT_NEAR(inertia.p_LLcm_L.x(), (2.5 * 0.15 - 1.5 * 0.12) / 4.0, 1e-15);
  // Steiner: two point masses 0.27 m apart have m1 m2 / (m1 + m2) d^2 about their common centre.
  EXPECT_NEAR(inertia.I_LLcm_L(1, 1), 0.02 + 0.001 + 2.5 * 1.5 / 4.0 * 0.27 * 0.27, 1e-12);
  EXPECT_DOUBLE_EQ(frame.below.mass, 1.5);  // what a force sensor there would have below it
  EXPECT_DOUBLE_EQ(tree.frames[static_cast<size_t>(tree.find_frame("upper_arm"))].below.mass, 4.0);
}

// Parents first in the file, and every other one last. Work that grows faster than the links takes minutes here, beyond
// the limit of the suite; the robot itself is read in a second.
TEST(RobotLoader, ALongChainOfFixedLinksIsOneBodyInLinearTime) {
  constexpr int kLinks = 20000;
  const std::string inertia =
      "<inertial><mass value='1e-5'/><inertia ixx='1e-8' ixy='0' ixz='0' iyy='1e-8' iyz='0' izz='1e-8'/></inertial>";
  std::string links = make_link("l0", inertia), forward, odd, even;
  for (int i = 0; i < kLinks; ++i) {
    const std::string at = std::to_string(i), next = std::to_string(i + 1);
    links += make_link("l" + next, inertia);
    const std::string joint = make_joint("j" + at, "fixed", "l" + at, "l" + next, "<origin xyz='1e-5 0 0'/>");
    forward += joint;
    (i % 2 == 0 ? even : odd) += joint;
  }
  for (const std::string& joints : {forward, odd + even}) {
    const RobotDescription robot =
        parse_robot("<robot name='r'>\n" + links + joints + "</robot>\n", "r.urdf", make_scenario("base: fixed\n"));
    ASSERT_EQ(robot.tree.links.size(), 1u);
    // Sums of 2e4 equal terms: each rounds once, by at most 1e-16 of the sum so far.
    EXPECT_NEAR(robot.tree.links[0].inertia.mass, 1e-5 * (kLinks + 1), 1e-11);
    EXPECT_NEAR(robot.tree.frames[kLinks].X_LF.p.x(), 1e-5 * kLinks, 1e-11);
    constexpr int kMiddle = kLinks / 2;
    EXPECT_NEAR(robot.tree.frames[kMiddle].below.mass, 1e-5 * (kMiddle + 1), 1e-11);
  }
}

TEST(RobotLoader, ControlCharactersInNamesAreSaidAsCodes) {
  const std::string complaint =
      find_complaint(make_link("a\x1b[2J\x7f\xc2\x9b"
                               "1m",
                               "<inertial><mass value='-1'/></inertial>"));
  EXPECT_THAT(complaint, HasSubstr("link 'a\\x1b[2J\\x7f\\xc2\\x9b1m'"));
  EXPECT_THAT(complaint, HasSubstr("value is negative"));
  EXPECT_EQ(complaint.find('\x1b'), std::string::npos);
  EXPECT_THAT(find_complaint(make_link("\xe8\x84\x9a", "<inertial><mass value='-1'/></inertial>")),
              HasSubstr("link '\xe8\x84\x9a'"))
      << "other letters stay";
}

// A scenario, which is UTF-8, could not say such a name. Latin-1 in a comment harms nobody.
TEST(RobotLoader, AnotherEncodingIsNamedWithItsLine) {
  EXPECT_THAT(find_complaint(make_link("a") + make_link("f\xfc\xdf")),
              HasSubstr("r.urdf:3: error: <link>: byte 252 is not UTF-8; expected a text in UTF-8"));
  EXPECT_THAT(find_complaint(make_link("a") + make_link("b") + make_joint("h\xfc", "continuous", "a", "b")),
              HasSubstr("r.urdf:4: error: <joint>: byte 252"));
  EXPECT_EQ(find_complaint("<!-- h\xfc -->" + make_link("a")), "");
  const auto complain = [](const std::string& text) -> std::string {
    return catch_complaint([&] { parse_robot(text, "r.urdf", make_scenario()); });
  };
  EXPECT_THAT(complain(std::string("\xff\xfe<\0r\0/\0>\0", 10)),
              HasSubstr("r.urdf:1: error: not valid XML: byte 255 is not UTF-8"));
}

TEST(RobotLoader, AnEmptyFileIsSaidToBeEmpty) {
  EXPECT_THAT(catch_complaint([] { parse_robot("", "r.urdf", make_scenario()); }),
              HasSubstr("r.urdf:1: error: is empty"));
}

TEST(RobotLoader, ScenarioOverridesRotorInertiaAndDrives) {
  const TreeSpec tree = load_arm("base: fixed\nrotor_inertia: {elbow: 0.5}\nunactuated: [grip]\n").tree;
  EXPECT_DOUBLE_EQ(tree.joint(2).rotor_inertia, 0.5);
  EXPECT_FALSE(tree.joint(3).actuated);
  EXPECT_TRUE(tree.joint(2).actuated);
}

TEST(RobotLoader, FaultsAreNamedWithLineAndElement) {
  const std::string two = make_link("a") + make_link("b");
  const struct {
    std::string body;
    const char* expected;
  } cases[] = {
      {"<link name='a'", "r.urdf:2: error: not valid XML"},
      {make_link("a") + make_link("a"), "r.urdf:3: error: link 'a': stands here again; first in line 2"},
      {two, "r.urdf:3: error: link 'b': has no parent joint, and neither has 'a' (line 2)"},
      {two + make_joint("j", "revolute", "a", "b", ""), "r.urdf:4: error: joint 'j': is revolute and has no <limit"},
      {two + make_joint("j", "planar", "a", "b"),
       "r.urdf:4: error: joint 'j': is of type 'planar', which is not supported"},
      {two + make_joint("j", "floating", "a", "b"), "is of type 'floating'"},
      {two + make_joint("j", "revolut", "a", "b"), "is of type 'revolut', expected revolute"},
      {two + make_joint("j", "fixed", "a", "c"), "names link 'c', which is not in the file"},
      {two + make_joint("j", "fixed", "a", "b") + make_joint("k", "fixed", "b", "a"), "cycle"},
      {two + make_joint("j", "fixed", "a", "b") + make_joint("k", "fixed", "a", "b"),
       "moves link 'b', which joint 'j' (line 4) moves already"},
      {two + make_joint("j", "continuous", "a", "b", "<axis xyz='0 0 0'/>"), "joint 'j' <axis>: has length zero"},
      {two + make_joint("j", "continuous", "a", "b", "<axis xyz='0 0 nan'/>"),
       "xyz is '0 0 nan', expected 3 finite numbers"},
      {two + make_joint("j", "continuous", "a", "b", "<origin xyz='1 2'/>"), "joint 'j' <origin>: xyz is '1 2'"},
      {two + make_joint("j", "continuous", "a", "b", "<mimic joint='x'/>"),
       "follows joint 'x', which is not a moving joint"},
      {two + make_joint("j", "continuous", "a", "b", "<mimic joint='j'/>"), "follows itself"},
      {two + make_joint("j", "revolute", "a", "b", "<limit lower='1' upper='0' effort='1' velocity='1'/>"),
       "lower is above upper"},
      {two + make_joint("j", "continuous", "a", "b", "<rotor inertia='-1'/>"),
       "joint 'j' <rotor>: inertia is negative"},
      {make_link("a",
                 "<inertial><mass value='-1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>"),
       "value is negative"},
      {make_link("a",
                 "<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='3'/></inertial>"),
       "r.urdf:2: error: link 'a' <inertial>: inertia breaks the triangle inequality"},
      {make_link("a",
                 "<inertial><mass value='1'/><inertia ixx='1' ixy='2' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>"),
       "not positive definite"},
      {make_link("a", "<inertial><mass value='1'/></inertial>"), "has no <inertia"},
      {make_link("a", ""), "moves but has no mass"},
      {make_link("a") + make_link("b", "") + make_joint("j", "continuous", "a", "b"),
       "link 'b': moves but has no mass, and carries none"},
      {make_link("a", std::string(kInertia) + "<collision><geometry><cone/></geometry></collision>"),
       "link 'a' <cone>: is no known shape"},
      {make_link("a", std::string(kInertia) + "<collision><geometry><box size='1 -1 1'/></geometry></collision>"),
       "negative size"},
      {"", "has no <link>"}};
  for (const auto& c : cases) EXPECT_THAT(find_complaint(c.body), HasSubstr(c.expected)) << c.body;
}

// With a repair, a moving link without mass or with all its mass in one point is a ball of 1 mm radius of gyration.
TEST(RobotLoader, RepairsPointMassesAndMovingLinksWithoutMass) {
  const std::string tip =
      make_link("b",
                "<inertial><mass value='2'/><inertia ixx='0' ixy='0' ixz='0' iyy='0' iyz='0' izz='0'/></inertial>") +
      make_link("c", "");
  const RobotDescription robot =
      parse_robot("<robot name='r'>\n" + make_link("a") + tip + make_joint("j", "continuous", "a", "b") +
                      make_joint("k", "continuous", "b", "c") + "</robot>\n",
                  "r.urdf", make_scenario("repair_inertias: true\n"));
  EXPECT_DOUBLE_EQ(robot.tree.links[1].inertia.I_LLcm_L(0, 0), 2e-6);
  EXPECT_DOUBLE_EQ(robot.tree.links[2].inertia.mass, 1e-3);
  EXPECT_THAT(robot.warnings, testing::Contains(HasSubstr("repaired to")).Times(2));
}

TEST(RobotLoader, ScenarioNamesAreCheckedAgainstTheRobot) {
  const std::string body = make_link("left_foot");
  EXPECT_THAT(find_complaint(body, "feet: [lft_foot]"),
              HasSubstr("s.yaml:2:8: error: feet[0]: the robot has no link 'lft_foot'; did you mean 'left_foot'?"));
  EXPECT_THAT(find_complaint(body, "servo: {joints: {knee: {kp: 1}}}"),
              HasSubstr("servo.joints.knee: the robot has no joint that moves 'knee'"));
  EXPECT_THAT(find_complaint(body, "feet: [left_foot]"), HasSubstr("has no collision geometry to stand on"));
}

TEST(RobotLoader, NumbersThatNoRobotHasAreRefusedWithLineAndValue) {
  const auto with_mass = [](const std::string& mass) {
    return make_link("a", "<inertial><mass value='" + mass +
                              "'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>");
  };
  EXPECT_THAT(find_complaint(with_mass("1e300")),
              HasSubstr("r.urdf:2: error: link 'a' <mass>: value is '1e300', expected 0 or 1e-9 to 1e6 [kg]"));
  EXPECT_THAT(find_complaint(with_mass("1e-300")), HasSubstr("value is '1e-300', expected 0 or 1e-9 to 1e6 [kg]"));
  EXPECT_EQ(find_complaint(with_mass("1e-9")), "");
  const std::string box = std::string(kInertia) + "<collision><geometry><box size='1 1e9 1'/></geometry></collision>";
  EXPECT_THAT(find_complaint(make_link("a", box)), HasSubstr("is larger than 10 km"));
  const std::string far =
      "<inertial><origin xyz='0 0 -1e300'/><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' "
      "izz='1'/></inertial>";
  EXPECT_THAT(find_complaint(make_link("a", far)),
              HasSubstr("r.urdf:2: error: link 'a' <origin>: is further away than 10 km"));
  const std::string two = make_link("a") + make_link("b");
  EXPECT_THAT(find_complaint(two + make_joint("j", "revolute", "a", "b",
                                              "<limit lower='-1' upper='1' effort='-1' velocity='1'/>")),
              HasSubstr("r.urdf:4: error: joint 'j' <limit>: effort is negative, expected a limit >= 0"));
}

std::vector<std::string> find_warnings(const std::string& body, const std::string& more) {
  return parse_robot("<robot name='r'>\n" + body + "</robot>\n", "r.urdf", make_scenario(more)).warnings;
}

TEST(RobotLoader, AnInitialPoseBeyondTheLimitsIsRefusedAndALittleBeyondWarnedOf) {
  const std::string body = make_link("a") + make_link("b") + make_joint("j", "revolute", "a", "b");
  const std::string gains = "base: fixed\nservo: {default: {kp: 1}}\n";
  EXPECT_THAT(find_complaint(body, gains + "initial: {joints: {j: 24}}"),
              HasSubstr("s.yaml:4:23: error: initial.joints.j: is 24 rad, expected -1 to 1 rad, the limits in the "
                        "URDF; are these degrees?"));
  EXPECT_THAT(find_warnings(body, gains + "initial: {joints: {j: 1.2}}"),
              testing::ElementsAre(HasSubstr("is 1.2 rad, expected -1 to 1 rad")));
  EXPECT_THAT(find_warnings(body, gains + "initial: {joints: {j: -1}}"), testing::IsEmpty());
  const std::string endless = make_link("a") + make_link("b") + make_joint("j", "continuous", "a", "b", "");
  EXPECT_THAT(find_complaint(endless, gains + "initial: {joints: {j: 24}}"),
              HasSubstr("is 24 rad, expected less than two turns either way"));
}

TEST(RobotLoader, ForgottenGainsAndFeetAreWarnedOf) {
  const std::string body = make_link("a") + make_link("b") + make_link("c") + make_joint("j", "revolute", "a", "b") +
                           make_joint("k", "revolute", "b", "c");
  EXPECT_THAT(find_warnings(body, "base: fixed\n"), testing::ElementsAre(HasSubstr("no servo gains: joints are free")));
  EXPECT_THAT(find_warnings(body, "base: fixed\nservo: {default: {kp: 0}, joints: {j: {kp: 5}}}\n"),
              testing::ElementsAre(
                  HasSubstr("s.yaml:3:8: warning: servo: no servo gains: these joints are free: k (kp is 0)")));
  EXPECT_THAT(find_warnings(body, "base: fixed\nservo: {joints: {j: {kp: 5}}}\nunactuated: [k]\n"), testing::IsEmpty());
  EXPECT_THAT(find_warnings(body, "servo: {default: {kp: 1}}\n"),
              testing::ElementsAre(HasSubstr("feet: is missing: nothing is known to stand on")));
  EXPECT_THAT(find_warnings(body, "servo: {default: {kp: 1}}\nground: {type: none}\n"), testing::IsEmpty());
}

TEST(RobotLoader, MissingMeshesAreLeftOutWithAWarningButNotThoseOfFeet) {
  const std::string body = make_link(
      "a", std::string(kInertia) + "<collision><geometry><mesh filename='package://p/m.stl'/></geometry></collision>");
  const RobotDescription robot = parse_robot("<robot name='r'>" + body + "</robot>", "r.urdf", make_scenario());
  EXPECT_TRUE(robot.shapes.empty());
  ASSERT_EQ(robot.warnings.size(), 2u) << "and one that no feet are named";
  EXPECT_THAT(robot.warnings[0], HasSubstr("there is no file 'package://p/m.stl'; simulated without it"));
  EXPECT_THAT(find_complaint(body, "feet: [a]"), HasSubstr("a foot needs its geometry"));
  EXPECT_EQ(find_complaint(body, "feet: [a]\nsoles: {a: {box: [0.2, 0.1, 0.02]}}"), "");
}

TEST(RobotLoader, AVisualWithoutMaterialNameCostsNoCollision) {
  const std::string body = make_link(
      "a", std::string(kInertia) +
               "<visual><geometry><sphere radius='1'/></geometry><material><color rgba='1 1 1 1'/></material></visual>"
               "<collision><geometry><sphere radius='0'/></geometry></collision>");
  const RobotDescription robot =
      parse_robot("<robot name='r'>" + body + "</robot>", "r.urdf", make_scenario("feet: [a]"));
  ASSERT_EQ(robot.shapes.size(), 1u) << "spheres of radius zero are points";
  EXPECT_TRUE(robot.shapes[0].sole);
}

TEST(RobotLoader, DamagedTextIsRefusedOrReadButNeverCrashes) {
  const std::string good = load_arm().urdf;
  std::mt19937 random(7);
  for (int i = 0; i < 1500; ++i) {
    std::string text = good;
    if (i % 5 == 0) text.resize(random() % text.size());
    for (size_t k = 0; k < 1 + random() % 5 && !text.empty(); ++k) {
      text[random() % text.size()] = "<>/=\"'&;0.-xe \n\x01\xff"[random() % 17];
    }
    try {
      parse_robot(text, "r.urdf", make_scenario("base: fixed"));
    } catch (const InputError&) {
    }
  }
}

TEST(MeshPath, PackagesAreSearchedUpward) {
  const std::filesystem::path root = std::filesystem::path(::testing::TempDir()) / "mesh_path_test";
  std::filesystem::create_directories(root / "my_robot/meshes");
  std::filesystem::create_directories(root / "my_robot/urdf");
  std::ofstream(root / "my_robot/meshes/a.stl") << "x";
  const std::string urdf = (root / "my_robot/urdf/r.urdf").string();
  const std::string mesh = (root / "my_robot/meshes/a.stl").string();
  EXPECT_EQ(find_mesh("package://my_robot/meshes/a.stl", urdf), mesh);
  EXPECT_EQ(find_mesh("package://renamed/meshes/a.stl", urdf), mesh);
  EXPECT_EQ(find_mesh("../meshes/a.stl", urdf), mesh);
  EXPECT_EQ(find_mesh("file://" + mesh, urdf), mesh);
  EXPECT_EQ(find_mesh("package://my_robot/meshes/b.stl", urdf), "");
}

TEST(InertiaCheck, RepairGivesTheNearestPhysicalMoments) {
  LinkInertia inertia;
  inertia.mass = 2.0;
  inertia.I_LLcm_L = Vector3d(-1e-3, 0.1, 0.3).asDiagonal();
  EXPECT_FALSE(find_inertia_fault(inertia).empty());
  const LinkInertia repaired = repair_inertia(inertia);
  EXPECT_TRUE(find_inertia_fault(repaired).empty()) << find_inertia_fault(repaired);
  EXPECT_DOUBLE_EQ(repaired.mass, 2.0);
  EXPECT_NEAR(repaired.I_LLcm_L(2, 2), 0.3, 1e-12) << "the largest moment stays";
}

TEST(RobotLoader, LimitsOfZerosOnlyAreThoseOfAnExporterThatKnewNone) {
  const auto load = [](const std::string& limit) {
    return parse_robot("<robot name='r'>" + make_link("a") + make_link("b") +
                           make_joint("j", "revolute", "a", "b", limit) + "</robot>",
                       "r.urdf", make_scenario());
  };
  const RobotDescription unknown = load("<limit lower='0' upper='0' effort='0' velocity='0'/>");
  EXPECT_EQ(unknown.tree.joint(0).upper, std::numeric_limits<double>::infinity());
  EXPECT_THAT(unknown.warnings, ::testing::Contains(HasSubstr("joint 'j' <limit>: has zeros only")));
  const RobotDescription locked = load("<limit lower='0' upper='0' effort='5' velocity='1'/>");
  EXPECT_EQ(locked.tree.joint(0).upper, 0.0);
  EXPECT_EQ(locked.tree.joint(0).effort_limit, 5.0);
  EXPECT_THAT(locked.warnings, ::testing::Not(::testing::Contains(HasSubstr("has zeros only"))));
}

// Two legs, one with the axes of its foot upright and one with its x axis up, as CAD or Denavit and Hartenberg leave
// them.
std::string make_two_legs() {
  const std::string box = "<collision><origin xyz='X'/><geometry><box size='Y'/></geometry></collision>";
  const auto fill = [&](std::string text, const std::string& at, const std::string& size) {
    return text.replace(text.find('X'), 1, at).replace(text.find('Y'), 1, size);
  };
  const std::string limit = "<limit lower='-1' upper='1' effort='1' velocity='1'/>";
  return make_link("trunk") + make_link("a_foot", kInertia + fill(box, "0.03 0 -0.04", "0.2 0.1 0.02")) +
         make_joint("a", "revolute", "trunk", "a_foot", "<origin xyz='0 0.1 -0.8'/><axis xyz='0 1 0'/>" + limit) +
         make_link("b_foot", kInertia + fill(box, "-0.04 0 -0.03", "0.02 0.1 0.2")) + make_link("b_cell") +
         make_joint("b", "revolute", "trunk", "b_foot",
                    "<origin xyz='0 -0.1 -0.8' rpy='0 -1.5707963267948966 0'/><axis xyz='0 1 0'/>" + limit) +
         make_joint("cell", "fixed", "b_foot", "b_cell", "<origin xyz='-0.02 0 0'/>");
}

TEST(RobotLoader, AFootOnlyTurnsItsAxesSoThatZPointsUp) {
  const std::string feet = "feet: [a_foot, b_foot]\n";
  const RobotDescription robot =
      parse_robot("<robot name='r'>" + make_two_legs() + "</robot>", "r.urdf", make_scenario(feet));
  const RobotDescription as_drawn =
      parse_robot("<robot name='r'>" + make_two_legs() + "</robot>", "r.urdf", make_scenario("feet: [a_foot]\n"));
  const int foot = robot.tree.find_link("b_foot"), cell = robot.tree.find_frame("b_cell");
  ASSERT_GT(foot, 0);
  for (const double q : {0.0, 0.3, -0.7}) {
    const auto place = [&](const RobotDescription& r) -> Transform {
      const JointSpec& joint = r.tree.links[static_cast<size_t>(foot)].joint;
      return {joint.X_PF.R * Eigen::AngleAxisd(q, joint.axis_F).toRotationMatrix(), joint.X_PF.p};
    };
    if (q == 0.0) {
      EXPECT_LT((place(robot).R - Matrix3d::Identity()).norm(), 1e-12) << "z is up, x ahead";
    }
    // Its shapes, its masses and what is fixed to it stay where the file has them.
    const auto expect_same = [&](const Transform& ours, const Transform& theirs) {
      EXPECT_LT(((place(robot) * ours).p - (place(as_drawn) * theirs).p).norm(), 1e-12);
      EXPECT_LT(((place(robot) * ours).R - (place(as_drawn) * theirs).R).norm(), 1e-12);
    };
    for (size_t i = 0; i < robot.shapes.size(); ++i) {
      if (robot.shapes[i].link == foot) expect_same(robot.shapes[i].X_LG, as_drawn.shapes[i].X_LG);
    }
    expect_same(robot.tree.frames[static_cast<size_t>(cell)].X_LF,
                as_drawn.tree.frames[static_cast<size_t>(cell)].X_LF);
    const auto inertia = [&](const RobotDescription& r) -> Matrix3d {
      const Matrix3d R = place(r).R;
      return R * r.tree.links[static_cast<size_t>(foot)].inertia.I_LLcm_L * R.transpose();
    };
    EXPECT_LT((inertia(robot) - inertia(as_drawn)).norm(), 1e-12);
  }
  const int upright = robot.tree.find_link("a_foot");
  EXPECT_EQ(robot.tree.links[static_cast<size_t>(upright)].joint.X_PF.R, Matrix3d::Identity());
}

// A base whose z axis lies level says nothing of where up is.
TEST(RobotLoader, FeetKeepTheirAxesWhereTheBaseDoesNotTellUp) {
  const std::string body =
      make_link("trunk") +
      make_link("foot", std::string(kInertia) + "<collision><geometry><sphere radius='0.1'/></geometry></collision>") +
      make_joint("j", "revolute", "trunk", "foot",
                 "<origin xyz='-0.8 0 0' rpy='0 1.5707963267948966 0'/><axis xyz='0 1 0'/><limit lower='-1' upper='1' "
                 "effort='1' velocity='1'/>");
  const RobotDescription robot =
      parse_robot("<robot name='r'>" + body + "</robot>", "r.urdf", make_scenario("feet: [foot]\n"));
  EXPECT_EQ(robot.tree.links[1].joint.axis_F, Vector3d::UnitY());
  EXPECT_TRUE(robot.tree.frames[1].X_LF.R.isIdentity(0.0));
}

}  // namespace
}  // namespace hrp
