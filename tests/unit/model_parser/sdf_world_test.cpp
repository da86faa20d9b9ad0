// SPDX-License-Identifier: BSD-3-Clause
// An SDF world is the obstacles and the ground that one would have written by hand.
#include "servers/model_parser/sdf/sdf_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/robot/ground_plane.h"
#include "tests/physics/scenario_robot.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

using ::testing::HasSubstr;

const std::string kModels = source_dir() + "/models/";
const std::string kBox = "robot: " + kModels + "test_robots/box.urdf\n";

WorldSpec read(const std::string& models, Diagnostics* diagnostics, const std::string& more = "") {
  const Scenario scenario = parse_scenario(kBox + "world: w.sdf\n" + more, "/dir/s.yaml");
  return read_sdf_world("<sdf version='1.9'>\n<world name='w'>\n" + models + "</world></sdf>\n", scenario, diagnostics);
}

std::string make_model(const std::string& name, const std::string& geometry,
                       const std::string& more = "<static>true</static>") {
  return "<model name='" + name + "'>" + more + "<link name='l'>\n<collision name='c'><geometry>" + geometry +
         "</geometry></collision></link></model>\n";
}

std::string find_complaint(const std::string& models) {
  Diagnostics diagnostics;
  read(models, &diagnostics);
  return diagnostics.error_text();
}

TEST(SdfWorld, StaticModelsAreObstaclesAndThePlaneIsTheGround) {
  const RobotDescription robot =
      load_robot(parse_scenario(kBox + "world: " + kModels + "terrain/yard.sdf\n", kModels + "s.yaml"));
  const Scenario scenario = parse_scenario(robot.scenario, robot.scenario_path);
  ASSERT_EQ(scenario.obstacles.size(), 4u);
  EXPECT_TRUE(scenario.ground.present);
  EXPECT_DOUBLE_EQ(scenario.ground.friction, 0.7);
  const ObstacleSpec &ramp = scenario.obstacles[0], &post = scenario.obstacles[1], &knob = scenario.obstacles[2],
                     &stairs = scenario.obstacles[3];
  EXPECT_EQ(ramp.name, "ramp");
  EXPECT_EQ(ramp.shape, "box");
  EXPECT_EQ(ramp.size, Vector3d(2, 1, 0.05));
  EXPECT_DOUBLE_EQ(ramp.friction, 0.1);
  EXPECT_LT((ramp.X_WG.R - make_rotation_from_rpy({0, -0.2, 0})).norm(), 1e-15);
  EXPECT_EQ(ramp.X_WG.p, Vector3d(1.5, -1, 0.2));
  EXPECT_EQ(post.shape, "cylinder");
  EXPECT_DOUBLE_EQ(post.friction, 0.8) << "none is stated: the scenario's default";
  EXPECT_EQ(knob.name, "post_2");
  EXPECT_NEAR(knob.X_WG.p.z(), 1.1, 1e-15);
  EXPECT_EQ(stairs.shape, "mesh");
  ASSERT_EQ(robot.surfaces.size(), 1u);
  EXPECT_EQ(robot.surfaces[0]->obstacle, "stairs");
}

TEST(SdfWorld, ABoxMovesInItAsAmongObstaclesWrittenByHand) {
  const std::string start = "initial: {position: [1.5, -1, 0.5]}\n";
  ScenarioRobot world(kBox + start + "world: " + kModels + "terrain/yard.sdf\n");
  ScenarioRobot hand(kBox + start +
                     "ground: {friction: 0.7}\nobstacles:\n"
                     "  ramp: {size: [2, 1, 0.05], position: [1.5, -1, 0.2], rpy: [0, -0.2, 0], friction: 0.1}\n"
                     "  post: {shape: cylinder, radius: 0.1, length: 1, position: [-1, 0, 0.5]}\n"
                     "  post_2: {shape: sphere, radius: 0.15, position: [-1, 0, 1.1]}\n"
                     "  stairs: {shape: mesh, file: ../terrain/stairs.obj, position: [0, 1.5, 0]}\n");
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(world.step(), StepStatus::kOk) << world.simulator.fault_text();
    ASSERT_EQ(hand.step(), StepStatus::kOk);
  }
  // Poses come through quaternions: rounding, and 1000 steps of it.
  EXPECT_LT((world.simulator.state().p_WB - hand.simulator.state().p_WB).norm(), 1e-9);
  // Down the ramp of 0.2 rad with mu = 0.1 at g (sin a - mu cos a), about 0.98 m/s^2, for most of a second.
  EXPECT_LT(world.simulator.state().V_WB[3], -0.5);
}

TEST(SdfWorld, ThereIsNoGroundWithoutAPlaneAndTheScenariosOwnWins) {
  Diagnostics diagnostics;
  const std::string ball = make_model("ball", "<sphere><radius>1</radius></sphere>");
  EXPECT_FALSE(read(ball, &diagnostics).ground.present);
  const std::string text = kBox + "world: w.sdf\nground: {height: 2}\n";
  const Scenario merged = parse_scenario(add_world(text, read(ball, &diagnostics)), "/dir/s.yaml");
  EXPECT_FALSE(diagnostics.has_errors()) << diagnostics.error_text();
  EXPECT_TRUE(merged.ground.present);
  EXPECT_EQ(merged.ground.height, 2.0);
}

TEST(SdfWorld, ATurnedPlaneIsATurnedGround) {
  GroundSpec ground;
  for (const Vector3d& n : {Vector3d(0, 0, 1), Vector3d(0.3, -0.2, 0.8), Vector3d(-0.1, 0.4, 0.9)}) {
    set_ground_normal(n.normalized(), &ground);
    EXPECT_LT((make_ground_plane(ground).n_W - n.normalized()).norm(), 1e-15);
  }
}

// Later messages point at lines of the scenario as people wrote it.
TEST(SdfWorld, LinesOfTheScenarioStayWhereTheyAre) {
  Diagnostics diagnostics;
  const WorldSpec world = read(make_model("ball", "<sphere><radius>1</radius></sphere>"), &diagnostics);
  const std::string text = kBox + "# remark\nworld: w.sdf\nfeet: [box]\n";
  const std::string merged = add_world(text, world);
  EXPECT_THAT(merged, HasSubstr("# remark\n# world: w.sdf\nfeet: [box]\n"));
  EXPECT_EQ(parse_scenario(merged, "/dir/s.yaml").obstacles.size(), 1u);
  // With obstacles of its own the text is written anew, and nothing is lost.
  const Scenario both = parse_scenario(add_world(text + "obstacles: {a: {size: [1, 1, 1]}}\n", world), "/dir/s.yaml");
  EXPECT_EQ(both.obstacles.size(), 2u);
  EXPECT_TRUE(both.world.empty());
  EXPECT_EQ(both.feet, std::vector<std::string>{"box"});
}

TEST(SdfWorld, WhatIsNotHeldIsRefusedByNameAndLine) {
  EXPECT_THAT(find_complaint(make_model("cart", "<sphere><radius>1</radius></sphere>", "")),
              HasSubstr("/dir/w.sdf:3: error: model 'cart': is not <static>: movable objects are not simulated"));
  EXPECT_THAT(
      find_complaint(make_model("egg", "<ellipsoid><radii>1 2 3</radii></ellipsoid>")),
      HasSubstr("/dir/w.sdf:4: error: model 'egg' <collision name=\"c\">: is of a shape that is not supported"));
  EXPECT_THAT(find_complaint(make_model("rock", "<mesh><uri>rock.obj</uri></mesh>")),
              HasSubstr("there is no file 'rock.obj'"));
  const std::string plane = "<plane><normal>0 0 1</normal></plane>";
  EXPECT_THAT(find_complaint(make_model("a", plane) + make_model("b", plane)),
              HasSubstr("model 'b' <collision name=\"c\">: is a second plane"));
  EXPECT_THAT(find_complaint(make_model("wall", "<plane><normal>1 0 0</normal></plane>")),
              HasSubstr("steeper than 60 degrees"));
  EXPECT_THAT(find_complaint("<include><uri>model://nowhere</uri></include>"), HasSubstr("libsdformat refuses it"));
}

// libsdformat says no reason, and repeats the file.
TEST(SdfWorld, WhatIsNoSdfIsRefusedWithItsLine) {
  const Scenario scenario = parse_scenario(kBox + "world: w.sdf\n", "/dir/s.yaml");
  const auto complain = [&](const std::string& text) {
    Diagnostics diagnostics;
    read_sdf_world(text, scenario, &diagnostics);
    return diagnostics.error_text();
  };
  EXPECT_THAT(complain("<sdf version='1.9'>\n<world name='w'>\n</wrold></sdf>"),
              HasSubstr("/dir/w.sdf:2: error: not valid XML: XML_ERROR_MISMATCHED_ELEMENT"));
  EXPECT_THAT(complain("<sdf version='1.9'>\n<world name='w\xe9'>"),
              HasSubstr("/dir/w.sdf:2: error: not valid XML: byte 233 is not UTF-8"));
  for (const char* text : {"<sdf><world name='w'/></sdf>", "<svg/>"})
    EXPECT_EQ(complain(text), "/dir/w.sdf: error: libsdformat refuses it: expected <sdf version=\"...\">") << text;
}

// What is read once for all texts stays as it was.
TEST(SdfWorld, NoTextChangesHowTheNextIsRead) {
  const std::string box = make_model("box", "<box><size>1 2 3</size></box>");
  Diagnostics diagnostics, odd;
  const WorldSpec first = read(box, &diagnostics);
  read(make_model("box", "<box><size>4 5 6</size><own>7</own></box><sphere/>", "<static>false</static><pose>x</pose>"),
       &odd);
  const WorldSpec again = read(box, &diagnostics);
  EXPECT_FALSE(diagnostics.has_errors()) << diagnostics.error_text();
  ASSERT_EQ(first.obstacles.size(), 1u);
  ASSERT_EQ(again.obstacles.size(), 1u);
  EXPECT_EQ(again.obstacles[0].size, first.obstacles[0].size);
}

}  // namespace
}  // namespace hrp
