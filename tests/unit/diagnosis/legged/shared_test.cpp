// SPDX-License-Identifier: BSD-3-Clause
// Other people's recordings and cases, beside the tree.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <regex>
#include <string>
#include <vector>

#include "diagnosis/data/recording.h"
#include "diagnosis/floating/diagnose.h"
#include "tests/test_places.h"

namespace hrp::diagnosis::floating {
namespace {

Evidence diagnose_shared(const std::string& folder, bool* there) {
  const std::filesystem::path path = std::filesystem::path(source_dir()) / "../shared" / folder / "experiment.yaml";
  *there = std::filesystem::exists(path);
  return *there ? diagnose_legged(load_experiment(path.string()), nullptr).evidence : Evidence{};
}

TEST(LeggedShared, LoadOnTheChestOfAWalkingRobotHasItsMassAndPlace) {
  bool there = false;
  const Evidence e = diagnose_shared("cases/open/walk-03", &there);
  if (!there) GTEST_SKIP() << "no open cases beside the tree, NOTHING was checked";
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "payload");
  EXPECT_EQ(e.findings[0].where.at("link"), "CHEST");
  EXPECT_NEAR(e.findings[0].parameters[0].value[0], 4.83, 0.1);  // 2 %
}

TEST(LeggedShared, RotorsOfBothKneesAreNamedFromAWalk) {
  bool there = false;
  const Evidence e = diagnose_shared("cases/open/walk-04", &there);
  if (!there) GTEST_SKIP() << "no open cases beside the tree, NOTHING was checked";
  ASSERT_EQ(e.findings.size(), 2u);
  for (const Finding& f : e.findings) {
    EXPECT_EQ(f.effect, "rotor_inertia");
    EXPECT_NE(f.where.at("joint").get<std::string>().find("KNEE"), std::string::npos);
  }
}

// Forces logged at 50 Hz beside faster encoders: the kernel that this asks for is longer than the swings of a trot, and
// what it brings in of the stance is no zero.
TEST(LeggedShared, StanceThatTheKernelBringsIntoSwingsIsNoZero) {
  const std::filesystem::path path =
      std::filesystem::path(source_dir()) / "../shared/recordings/go1_walk/experiment.yaml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no recordings beside the tree, NOTHING was checked";
  Experiment e = load_experiment(path.string());
  for (Recording& r : e.recordings) {
    for (auto& [name, column] : r.other) {
      if (name.rfind("/wrench", 0) != 0) continue;
      for (size_t k = 1; k < column.size(); ++k) {
        if (std::floor(50 * r.time[k]) == std::floor(50 * r.time[k - 1])) column[k] = column[k - 1];
      }
    }
  }
  for (const Finding& f : diagnose_legged(e, nullptr).evidence.findings)
    EXPECT_NE(f.effect, "sensor_bias") << f.statement;
}

// Its authors have 0.12 N a count. Diagonal feet bear together, so that the rows tell little of one foot.
TEST(LeggedShared, CountsOfAQuadrupedThatTrotsHaveAScaleOfEachFoot) {
  bool there = false;
  const Evidence e = diagnose_shared("recordings/go1_walk", &there);
  if (!there) GTEST_SKIP() << "no recordings beside the tree, NOTHING was checked";
  size_t feet = 0;
  for (const Finding& f : e.findings) {
    if (f.effect != "sensor_scale" || f.where.at("sensor").get<std::string>().rfind("/wrench/", 0) != 0) continue;
    ++feet;
    EXPECT_NEAR(1 / f.parameters[0].value[0], 0.12, 0.03) << f.statement;
    EXPECT_LT(f.parameters[0].std[0], 0.2 * f.parameters[0].value[0]) << f.statement;
  }
  EXPECT_EQ(feet, 4u);
}

// The real humanoid, whose recordings a test may change.
class LeggedHumanoid : public testing::Test {
 protected:
  using Change = std::function<void(const std::string& name, std::vector<double>* column)>;

  void SetUp() override {
    const std::filesystem::path path =
        std::filesystem::path(source_dir()) / "../shared/recordings/icub_walking/experiment.yaml";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no recordings beside the tree, NOTHING was checked";
    robot = load_experiment(path.string());
  }

  Evidence diagnose() const { return diagnose_legged(robot, nullptr).evidence; }
  Evidence diagnose_with(const Change& change) {
    for (Recording& r : robot.recordings) {
      for (auto& [name, column] : r.other) change(name, &column);
    }
    return diagnose();
  }

  Experiment robot;
};

void add_to(const std::string& part, double value, const std::string& name, std::vector<double>* column) {
  if (name.find(part) == std::string::npos) return;
  for (double& v : *column) v += value;
}

const Finding* find_at(const Evidence& e, const std::string& sensor) {
  for (const Finding& f : e.findings) {
    if (f.where.contains("sensor") && f.where.at("sensor") == sensor) return &f;
  }
  return nullptr;
}

TEST_F(LeggedHumanoid, ZeroOfAVerticalForceIsWhatItReadsInTheAir) {
  const Evidence found = diagnose_with(
      [](const std::string& name, std::vector<double>* column) { add_to("/wrench/l_sole/force/z", 10, name, column); });
  const Finding* zero = find_at(found, "/wrench/l_sole/force");
  ASSERT_NE(zero, nullptr);
  EXPECT_EQ(zero->effect, "sensor_bias");
  EXPECT_EQ(zero->grade, Grade::kSupported);
  EXPECT_NEAR(zero->parameters[0].value[0], 11, 2);  // the foot itself reads 0 to 3 N in the air
  EXPECT_EQ(find_at(found, "/wrench/r_sole/force"), nullptr) << "3 N are below a hundredth of the weight";
}

// By 3 samples. The recording as it is tells no delay of one foot: 0.004 s and less, by both walks.
TEST_F(LeggedHumanoid, AFootOfARealHumanoidThatIsLateIsNamed) {
  const Evidence found = diagnose_with([](const std::string& name, std::vector<double>* column) {
    if (name == "/wrench/l_sole/force/z") std::rotate(column->begin(), column->end() - 3, column->end());
  });
  const Finding* late = find_at(found, "/wrench/l_sole");
  ASSERT_NE(late, nullptr);
  EXPECT_EQ(late->effect, "sensor_delay");
  EXPECT_NEAR(late->parameters[0].value[0], 0.03, 0.008);
}

// Nothing else is hidden in this walk. The recording is corrected before the equations are made, and still the report
// tells how much the delay explains: without that, the finding would be doubted.
TEST(LeggedShared, ALateFootExplainsWhatItsCorrectionTakesAway) {
  const std::filesystem::path path =
      std::filesystem::path(source_dir()) / "../shared/cases/open/walk-01/experiment.yaml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no open cases beside the tree, NOTHING was checked";
  Experiment e = load_experiment(path.string());
  for (Recording& r : e.recordings) {
    for (auto at = r.other.begin(); at != r.other.end();) {
      const bool other_axis = at->first.rfind("/wrench/", 0) == 0 && at->first.find("/force/z") == std::string::npos;
      at = other_axis ? r.other.erase(at) : std::next(at);
    }
    std::vector<double>& z = r.other.at("/wrench/l_ankle_ft/force/z");
    std::rotate(z.begin(), z.end() - 8, z.end());
  }
  const Evidence found = diagnose_legged(e, nullptr).evidence;
  ASSERT_EQ(found.findings.size(), 1u);
  EXPECT_EQ(found.findings[0].effect, "sensor_delay");
  EXPECT_NEAR(found.findings[0].parameters[0].value[0], 0.032, 0.003);
  EXPECT_GT(found.explained, 0.1);
}

TEST_F(LeggedHumanoid, ZeroOfARealGyroscopeIsFound) {
  const Evidence found = diagnose_with(
      [](const std::string& name, std::vector<double>* column) { add_to("angular_velocity/x", 0.05, name, column); });
  const Finding* zero = find_at(found, "/imu/root/angular_velocity");
  ASSERT_NE(zero, nullptr);
  EXPECT_EQ(zero->effect, "sensor_bias");
  EXPECT_NEAR(zero->parameters[0].value[0], 0.05, 0.005);
}

// Its torso turns by 14 degrees at most: along the weight, a zero makes what a scale makes.
TEST_F(LeggedHumanoid, ScaleOfARealAccelerometerIsListedBesideItsZero) {
  const Evidence found = diagnose_with([](const std::string& name, std::vector<double>* column) {
    for (double& v : *column) v *= name.find("linear_acceleration") == std::string::npos ? 1 : 1.05;
  });
  const Finding* zero = find_at(found, "/imu/root/linear_acceleration");
  ASSERT_NE(zero, nullptr);
  EXPECT_EQ(zero->grade, Grade::kAmbiguous);
  const auto scale = std::find_if(zero->alternatives.begin(), zero->alternatives.end(),
                                  [](const Alternative& a) { return a.effect == "sensor_scale"; });
  ASSERT_NE(scale, zero->alternatives.end());
  EXPECT_NEAR(scale->parameters[0].value[0], 1.047, 0.005);  // 1.05 times 0.9972, what it reads of gravity
}

// What one foot lacks may rest on the other, of which nothing is known.
TEST_F(LeggedHumanoid, WeightThatOneFootLacksIsNoMass) {
  for (Recording& r : robot.recordings) r.other.erase("/wrench/r_sole/force/z");
  for (const Finding& f : diagnose().findings) EXPECT_NE(f.family, "mass and its place") << f.statement;
}

// By the base's pose alone: steps shake its acceleration, and the robot stands most of the time.
TEST_F(LeggedHumanoid, WeightOfARealHumanoidIsSeenWithoutAnAccelerometer) {
  for (Recording& r : robot.recordings) {
    for (const char* axis : {"x", "y", "z"}) r.other.erase(std::string("/imu/root/linear_acceleration/") + axis);
  }
  const Evidence found = diagnose();
  const auto weight = std::find_if(found.findings.begin(), found.findings.end(),
                                   [](const Finding& f) { return f.family == "mass and its place"; });
  ASSERT_NE(weight, found.findings.end());
  EXPECT_NEAR(weight->parameters[0].value[0], 0.94, 0.15) << "2.7 to 3.2 % of 33 kg";
  EXPECT_TRUE(std::regex_search(weight->statement, std::regex("0\\.98[0-9] \\+- [0-9.]+ on l_foot alone")))
      << weight->statement;
}

TEST_F(LeggedHumanoid, WeightIsAmbiguousAndNothingIsSaidOfItsDrives) {
  const Evidence e = diagnose();
  const auto weight = std::find_if(e.findings.begin(), e.findings.end(),
                                   [](const Finding& f) { return f.family == "mass and its place"; });
  ASSERT_NE(weight, e.findings.end());
  EXPECT_EQ(weight->grade, Grade::kAmbiguous);
  EXPECT_GE(weight->alternatives.size(), 3u);
  for (const Finding& f : e.findings) EXPECT_EQ(f.effect.find("friction"), std::string::npos);
  // Its feet share the load as the zero-moment point asks: correlations of .72 to .98 in the four recordings, one by
  // one.
  EXPECT_TRUE(std::any_of(e.warnings.begin(), e.warnings.end(),
                          [](const std::string& w) { return w.rfind("load share: ", 0) == 0; }));
}

}  // namespace
}  // namespace hrp::diagnosis::floating
