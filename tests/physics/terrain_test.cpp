// SPDX-License-Identifier: BSD-3-Clause
// Terrain: bodies on tilted boxes, held against Coulomb's law on an incline; on meshes and height fields, held against
// the plane.
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "servers/console/trial/trial.h"
#include "tests/physics/scenario_robot.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

constexpr double kGravity = 9.81;           // [m/s^2]
constexpr double kHalfHeight = 0.1 + 0.05;  // [m] half of the body's height and of the ramp's

// The box of test_robots on a ramp that descends along x by `slope` [rad].
std::string make_ramp(double slope, double friction) {
  const Vector3d p = kHalfHeight * Vector3d(std::sin(slope), 0.0, std::cos(slope));
  const auto text = [](double x) { return std::to_string(x); };
  return "robot: ../test_robots/box.urdf\nfeet: [box]\nground: {type: none}\n"
         "initial: {position: [" +
         text(p.x()) + ", 0, " + text(p.z()) + "], rpy: [0, " + text(slope) +
         ", 0]}\n"
         "contact: {stiffness: 1.0e6, tangential_stiffness: 1.0e6}\n"
         "obstacles: {ramp: {size: [20, 4, 0.1], rpy: [0, " +
         text(slope) + ", 0], friction: " + text(friction) + "}}\n";
}

struct Slide {
  double speed = 0.0;   // [m/s] down the ramp at the end
  double normal = 0.0;  // [N] of all points, across the ramp, mean of the second half
  double weight = 0.0;  // [N]
};

Slide slide_for_a_second(double slope, double friction) {
  ScenarioRobot robot(make_ramp(slope, friction));
  const Matrix3d R_WR = make_rotation_from_rpy({0.0, slope, 0.0});
  Slide slide;
  for (const LinkSpec& link : robot.robot.tree.links) slide.weight += kGravity * link.inertia.mass;
  Vector3d p_before = robot.simulator.state().p_WB;
  for (int i = 0; i < 1000; ++i) {
    p_before = robot.simulator.state().p_WB;
    EXPECT_EQ(robot.step(), StepStatus::kOk);
    if (i < 500) continue;
    for (const PairForce& pair : robot.simulator.contact_forces()) {
      slide.normal += R_WR.col(2).dot(pair.total.tail<3>()) / 500.0;
    }
  }
  slide.speed = R_WR.col(0).dot(robot.simulator.state().p_WB - p_before) / 1e-3;
  return slide;
}

// ---- files of surfaces, in a folder of this process ----------------------------------------------------------------

std::string write_file(const std::string& name, const std::string& text) {
  std::string path = ::testing::TempDir() + "/terrain_" + std::to_string(getpid()) + "_" + name;
  std::ofstream(path) << text;
  return path;
}

// A field of 6 m x 4 m with a height every 0.05 m.
std::string write_field(const std::string& name, const std::function<double(double, double)>& height) {
  std::string text;
  for (int i = 0; i <= 80; ++i) {
    for (int j = 0; j <= 120; ++j) {
      char number[32];
      std::snprintf(number, sizeof number, "%.17g%c", height(-3.0 + 0.05 * j, 2.0 - 0.05 * i), j == 120 ? '\n' : ',');
      text += number;
    }
  }
  return write_file(name, text);
}

// A level square of 8 m as two triangles.
std::string write_plane() {
  return write_file("plane.obj", "v -4 -4 0\nv 4 -4 0\nv -4 4 0\nv 4 4 0\nf 1 2 3\nf 2 4 3\n");
}

// Three steps of 0.5 m x 2 m, 0.2 m high, up along x from x = 0, as triangles: treads and risers.
std::string write_stairs() {
  std::string text, faces;
  int vertices = 0;
  const auto add = [&](double x0, double z0, double x1, double z1) {
    for (const double y : {-1.0, 1.0})
      text += "v " + std::to_string(x0) + " " + std::to_string(y) + " " + std::to_string(z0) + "\n";
    for (const double y : {-1.0, 1.0})
      text += "v " + std::to_string(x1) + " " + std::to_string(y) + " " + std::to_string(z1) + "\n";
    const auto v = [&](int k) { return " " + std::to_string(vertices + k); };
    faces += "f" + v(1) + v(3) + v(2) + "\nf" + v(3) + v(4) + v(2) + "\n";
    vertices += 4;
  };
  for (int k = 0; k < 3; ++k) {
    add(0.5 * k, 0.2 * k, 0.5 * k, 0.2 * (k + 1));
    add(0.5 * k, 0.2 * (k + 1), 0.5 * (k + 1), 0.2 * (k + 1));
  }
  return write_file("stairs.obj", text + faces);
}

std::string make_land(const std::string& file, const std::string& more = "") {
  const bool mesh = file.find(".obj") != std::string::npos;
  return "obstacles: {land: {" + std::string(mesh ? "shape: mesh" : "shape: height_field, spacing: 0.05") +
         ", file: '" + file + "'" + more + "}}\n";
}

std::string make_box(const std::string& position, const std::string& rpy, const std::string& land) {
  return "robot: ../test_robots/box.urdf\nfeet: [box]\nground: {type: none}\ninitial: {position: " + position +
         ", rpy: " + rpy + "}\ncontact: {stiffness: 1.0e6, tangential_stiffness: 1.0e6}\n" + land;
}

struct Rest {
  Vector3d force = Vector3d::Zero();  // [N] of all contacts, mean of the second half of a second
  Vector3d p = Vector3d::Zero();      // [m] at the end
  double speed = 0.0;                 // [m/s] at the end
  unsigned long long hash = 0;
};

Rest rest_for_a_second(const std::string& yaml, int steps = 1000) {
  ScenarioRobot robot(yaml);
  Rest rest;
  for (int i = 0; i < steps; ++i) {
    EXPECT_EQ(robot.step(), StepStatus::kOk) << robot.simulator.fault_text();
    if (i < steps - 500) continue;
    for (const PairForce& pair : robot.simulator.contact_forces()) rest.force += pair.total.tail<3>() / 500.0;
  }
  rest.p = robot.simulator.state().p_WB;
  rest.speed = robot.simulator.state().V_WB.tail<3>().norm();
  rest.hash = robot.simulator.state_hash();
  return rest;
}

constexpr double kWeight = 12.0 * kGravity;  // [N] of the box

// Four heights from 2 to 5 mm above the plane, in turn: edges of up to 3 mm that no footstep of the plan knows.
std::string make_plates() {
  std::string text = "obstacles:\n";
  const double heights[] = {0.003, 0.005, 0.002, 0.004};  // [m]
  for (int k = 0; k < 12; ++k) {
    text += "  plate" + std::to_string(k) + ": {size: [0.6, 1.5, 0.02], position: [" + std::to_string(0.6 + 0.6 * k) +
            ", 0, " + std::to_string(heights[k % 4] - 0.01) + "]}\n";
  }
  return text;
}

TrialResult walk_over(const std::string& obstacles) {
  const Scenario flat = load_scenario(source_dir() + "/models/scenarios/default.yaml");
  return Trial(parse_scenario(flat.text + obstacles, flat.path)).run();
}

TEST(Terrain, ABoxOnAnInclineIsCarriedByItsWeightTimesTheCosine) {
  for (const double slope : {0.1, 0.2, 0.3}) {
    const Slide slide = slide_for_a_second(slope, 0.5);
    // 0.1 %: the box has settled after half a second; 1e6 N/m and 12 kg swing with less than 10 ms.
    EXPECT_NEAR(slide.normal, slide.weight * std::cos(slope), 1e-3 * slide.weight) << slope;
  }
}

TEST(Terrain, ABoxRestsBelowTheFrictionAngle) {
  const double friction = 0.4;
  const Slide slide = slide_for_a_second(std::atan(friction) - 0.03, friction);
  EXPECT_NEAR(slide.speed, 0.0, 1e-4) << "a thousandth of what it would have without friction after 0.03 s";
}

TEST(Terrain, ABoxSlidesAboveTheFrictionAngleWithCoulombsAcceleration) {
  const double friction = 0.4, slope = std::atan(friction) + 0.1;
  const Slide slide = slide_for_a_second(slope, friction);
  const double acceleration = kGravity * (std::sin(slope) - friction * std::cos(slope));
  EXPECT_NEAR(slide.speed, acceleration, 0.02 * acceleration) << "after 1 s; the box first sinks in for milliseconds";
}

TEST(Surface, ABoxRestsOnTheStepOfAMeshWithItsWeight) {
  const std::string stairs = make_land(write_stairs());
  // In the middle of the second tread, and on its nose: a third of the box hangs over the first.
  for (const double x : {0.75, 0.57}) {
    const Rest rest = rest_for_a_second(make_box("[" + std::to_string(x) + ", 0, 0.5]", "[0, 0, 0]", stairs));
    EXPECT_NEAR(rest.force.z(), kWeight, 1e-3 * kWeight) << "settled after half a second";
    EXPECT_NEAR(rest.p.z(), 0.5, 1e-3) << "0.4 m of two steps, 0.1 m of half a box; it sinks in by 0.12 mm";
    EXPECT_NEAR(rest.p.x(), x, 1e-3);
    EXPECT_LT(rest.speed, 1e-4);
  }
}

// The scenario that docs/tutorials/world.md tells to save under this name, as if it lay in models/scenarios.
std::string read_from_tutorial(const std::string& name) {
  std::ifstream file(source_dir() + "/docs/tutorials/world.md");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  text.erase(0, text.find("# " + name));
  text.erase(text.find("```"));
  for (size_t at = 0; (at = text.find(" models/", at)) != std::string::npos;) text.replace(at, 8, " ../");
  return text;
}

TEST(Surface, TheBoxesOfTheTutorialComeToRestOnStairsAndHills) {
  for (const char* name : {"stairs.yaml", "hills.yaml"}) {
    const Rest rest = rest_for_a_second(read_from_tutorial(name), 2000);
    EXPECT_NEAR(rest.force.z(), kWeight, 0.005) << name << ": 117.72 N to the digits that the tutorial has";
    EXPECT_LT(rest.speed, 1e-6) << name;
    EXPECT_GT(rest.p.z(), 0.25) << name << ": above the ground and the foot of the hills";
  }
}

TEST(Surface, ABoxOnTheSlopeOfAFieldIsCarriedAcrossTheSlope) {
  const double slope = 0.2;
  const std::string land = make_land(write_field("slope.csv", [&](double x, double) { return -std::tan(slope) * x; }));
  const Vector3d n(std::sin(slope), 0, std::cos(slope));
  const std::string at = "[" + std::to_string(0.1 * n.x()) + ", 0, " + std::to_string(0.1 * n.z()) + "]";
  const Rest rest = rest_for_a_second(make_box(at, "[0, 0.2, 0]", land));
  EXPECT_NEAR(rest.force.dot(n), kWeight * std::cos(slope), 1e-3 * kWeight);
  EXPECT_NEAR((rest.force - n * rest.force.dot(n)).norm(), kWeight * std::sin(slope), 1e-3 * kWeight)
      << "friction holds the rest";
  ScenarioRobot robot(make_box(at, "[0, 0.2, 0]", land));
  for (int i = 0; i < 100; ++i) ASSERT_EQ(robot.step(), StepStatus::kOk);
  ASSERT_FALSE(robot.simulator.contact_forces().empty());
  for (const PointForce& point : robot.simulator.contact_forces()[0].points) {
    EXPECT_NEAR((point.n_BA_W - n).norm(), 0.0, 1e-9) << "the slope's normal";
  }
}

// Rolls out the box dropped askew, so that corners, edges and friction take part; largest differences of the whole run.
TEST(Surface, APlaneOfTrianglesGivesTheForcesOfThePlane) {
  const std::string plane = write_plane(), field = write_field("level.csv", [](double, double) { return 0.0; });
  const std::string askew =
      "{position: [0.03, -0.02, 0.2], rpy: [0.2, -0.3, 0.4]}\ncontact: {stiffness: 1.0e6, tangential_stiffness: "
      "1.0e6}\n";
  const std::string head = "robot: ../test_robots/box.urdf\nfeet: [box]\ninitial: " + askew;
  ScenarioRobot truth(head + "ground: {friction: 0.8}\n");
  for (const std::string& file : {plane, field}) {
    truth.simulator.reset();
    ScenarioRobot robot(head + "ground: {type: none}\n" + make_land(file));
    double force = 0.0, largest = 0.0, place = 0.0;
    for (int i = 0; i < 1000; ++i) {
      ASSERT_EQ(truth.step(), StepStatus::kOk);
      ASSERT_EQ(robot.step(), StepStatus::kOk);
      Vector3d a = Vector3d::Zero(), b = Vector3d::Zero();
      for (const PairForce& pair : truth.simulator.contact_forces()) a += pair.total.tail<3>();
      for (const PairForce& pair : robot.simulator.contact_forces()) b += pair.total.tail<3>();
      force = std::max(force, (a - b).norm());
      largest = std::max(largest, a.norm());
      place = std::max(place, (truth.simulator.state().p_WB - robot.simulator.state().p_WB).norm());
    }
    std::printf("%s: forces up to %.0f N differ by up to %.1e N, places by %.1e m\n", file.c_str(), largest, force,
                place);
    // Rounding of 1e-16 m on 1e6 N/m is 1e-10 N; the tumbling of a second makes it up to ten thousand times as large.
    EXPECT_LT(force, 1e-6 * largest) << file;
    EXPECT_LT(place, 1e-9) << file;
  }
}

TEST(Surface, ARobotStartsOnTheFieldUnderIt) {
  const std::string land =
      make_land(write_field("high.csv", [](double x, double) { return 1.0 + 0.1 * x; }), ", position: [0, 0, 0.5]");
  const ScenarioRobot robot("robot: ../test_robots/box.urdf\nfeet: [box]\nground: {type: none}\n" + land);
  EXPECT_NEAR(robot.simulator.state().p_WB.z(), 1.5 + 0.1 * 0.2 + 0.1, 1e-9)
      << "its front corners, 0.2 m ahead, are the first to touch";
  EXPECT_EQ(robot.simulator.state().p_WB.z(), robot.world.start_state().p_WB.z());
}

TEST(Surface, TheShippedWalkOverWavesStaysUpright) {
  const TrialResult r = Trial(load_scenario(source_dir() + "/models/scenarios/terrain.yaml")).run();
  EXPECT_FALSE(r.fallen) << r.fault;
  EXPECT_NEAR(r.duration, 12.0, 1e-9) << r.fault;
  EXPECT_NEAR(r.travelled.x(), 1.6, 0.15) << "eight steps of 0.2 m";
  std::printf("waves: %.3f m forward, %.4f m up, lean %.4f rad\n", r.travelled.x(), r.travelled.z(), r.largest_lean);
}

TEST(Surface, AWalkerThatIsPushedOverOnWavesHasFallen) {
  const Scenario waves = load_scenario(source_dir() + "/models/scenarios/terrain.yaml");
  const std::string push = "pushes: {shove: {link: CHEST_IMU, force: [0, 400, 0], start: 3, duration: 0.3}}\n";
  const TrialResult r = Trial(parse_scenario(waves.text + push, waves.path)).run();
  EXPECT_TRUE(r.fallen);
  EXPECT_GT(r.fall_time, 3.0);
}

TEST(Surface, ARunOnAFieldRepeatsToTheBit) {
  const std::string land = make_land(
      write_field("hills.csv", [](double x, double y) { return 0.1 * std::sin(3.0 * x) * std::cos(2.0 * y); }));
  const std::string yaml = make_box("[0.3, 0.1, 0.5]", "[0.3, 0.2, 0.1]", land);
  EXPECT_EQ(rest_for_a_second(yaml).hash, rest_for_a_second(yaml).hash);
}

TEST(Surface, ABoxComesToRestInHills) {
  const std::string land = make_land(
      write_field("hills.csv", [](double x, double y) { return 0.05 * std::sin(3.0 * x) * std::cos(2.0 * y); }));
  const Rest rest = rest_for_a_second(make_box("[0.3, 0.1, 0.3]", "[0, 0, 0.1]", land), 4000);
  EXPECT_NEAR(rest.force.z(), kWeight, 1e-3 * kWeight);
  EXPECT_LT(rest.speed, 1e-3);
}

TEST(Terrain, TheWalkOfTheDefaultScenarioStaysUprightOverPlatesOfMillimetres) {
  const TrialResult r = walk_over(make_plates());
  EXPECT_FALSE(r.fallen) << r.fault;
  EXPECT_NEAR(r.duration, 12.0, 1e-9) << r.fault;
  EXPECT_NEAR(r.travelled.x(), 1.6, 0.15) << "eight steps of 0.2 m; settling moves the base by some centimetres";
  const TrialResult flat = walk_over("");
  // The last step ends on the edge from 5 mm down to 2 mm.
  EXPECT_GT(r.travelled.z(), flat.travelled.z() + 0.001) << "it stands on plates in the end";
  EXPECT_LT(r.travelled.z(), flat.travelled.z() + 0.006) << "and the highest is 5 mm";
  std::printf("plane: %.3f m forward, %.4f m up, lean %.4f rad\n", flat.travelled.x(), flat.travelled.z(),
              flat.largest_lean);
  std::printf("plates: %.3f m forward, %.4f m up, lean %.4f rad\n", r.travelled.x(), r.travelled.z(), r.largest_lean);
}

TEST(Terrain, TheWalkOfTheDefaultScenarioClimbsARampOfTwoDegrees) {
  // Rises from x = 0.2 m on: its upper side there is at height 0.
  const TrialResult r =
      walk_over("obstacles: {ramp: {size: [8, 2, 0.02], position: [4.2, 0, 0.1296], rpy: [0, -0.0349, 0]}}\n");
  EXPECT_FALSE(r.fallen) << r.fault;
  EXPECT_NEAR(r.travelled.z(), 0.0349 * (1.6 - 0.2), 0.005)
      << "1.6 m of steps, 1.4 m of them on the ramp; feet may stop 0.14 m off";
  std::printf("ramp: %.3f m forward, %.4f m up, lean %.4f rad\n", r.travelled.x(), r.travelled.z(), r.largest_lean);
}

// Half of the height at the start, above the floor and not above the world's zero, counts as fallen.
TEST(Terrain, AFloorOfAnyHeightIsNoFall) {
  for (const double height : {-1.0, 1.0}) {
    Scenario scenario = load_scenario(source_dir() + "/models/scenarios/hrp2p_stand.yaml");
    scenario.ground.height = height;
    scenario.duration = 0.2;
    const TrialResult result = Trial(scenario).run();
    EXPECT_FALSE(result.fallen) << height;
    EXPECT_EQ(result.fault, "");
  }
}

}  // namespace
}  // namespace hrp
