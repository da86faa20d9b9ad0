// SPDX-License-Identifier: BSD-3-Clause
// Mikami et al. 2014 on one foot: what stands, what a hand that holds the robot is needed for, and what the bush's fit
// says of a motion with the other foot in the air.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "diagnosis/identification/identify.h"
#include "diagnosis/identification/motions.h"
#include "tests/test_places.h"

namespace hrp::identification {
namespace {

const std::string kScenario = source_dir() + "/models/scenarios/paper_b/foot.yaml";
constexpr size_t kTilt = 0, kSwayRight = 9, kSwayLeft = 10;

class SingleSupport : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = (std::filesystem::temp_directory_path() / ("one_foot_" + std::to_string(getpid()))).string();
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string folder_;
  Scenario base_ = load_scenario(kScenario);
};

// One foot, 250 samples a second, two seconds: the load and the centre of pressure that a function of time says.
RobotLog make_log(const std::function<Vector3d(double)>& load_and_place) {
  RobotLog log;
  log.period = 0.004;
  log.q.resize(0, 500);
  log.wrenches.emplace_back(6, 500);
  for (Eigen::Index k = 0; k < 500; ++k) {
    const Vector3d at = load_and_place(log.period * static_cast<double>(k));
    log.wrenches[0].col(k) << 0, 0, at[0], at[0] * at[2], -at[0] * at[1], 0;
  }
  return log;
}

TEST(Standing, NeedsLoadWithItsCentreInsideTheSole) {
  FootFrame foot;
  foot.p_UC = {0, 0, -0.1};
  foot.sole = Eigen::AlignedBox2d(Eigen::Vector2d(-0.1, -0.06), Eigen::Vector2d(0.13, 0.06));
  const std::vector<SensorZero> zeros(1);
  const auto find = [&](const std::function<Vector3d(double)>& load) {
    return find_standing(make_log(load), {foot}, zeros)[0];
  };
  EXPECT_TRUE(find([](double) { return Vector3d(100, 0.12, -0.05); }).all());
  EXPECT_FALSE(find([](double) { return Vector3d(-14, 0, 0); }).any()) << "its own weight hangs on the sensor";
  EXPECT_FALSE(find([](double) { return Vector3d(100, -0.099, 0); }).any()) << "on the heel";
  EXPECT_FALSE(find([](double) { return Vector3d(100, 0, 0.07); }).any()) << "an edge is not level";
  const Mask lifted = find([](double t) { return Vector3d(t < 1.0 ? 100 : 0, 0, 0); });
  ASSERT_EQ(find_stretches(lifted).size(), 1u);
  EXPECT_EQ(find_stretches(lifted)[0].first, 0);
  // 1 s less kReach, to one sample either way.
  EXPECT_NEAR(static_cast<double>(find_stretches(lifted)[0].second) * 0.004, 1.0 - kReach, 0.005);
}

// Rubber alone does not hold the robot on one foot: K < m g h.
TEST_F(SingleSupport, NeedsTheHand) {
  const MotionPlan plan = make_plans(0.5)[kSwayRight];
  const std::string path = write_motion(plan, base_, folder_);
  const MotionCheck held = check_motion(path, plan.lifted);
  EXPECT_TRUE(held.ok()) << held.margin << " m, " << held.smallest_load << " N, " << held.in_the_air << " s";
  EXPECT_FALSE(check_motion(path).ok()) << "a foot in the air that no plan lifts";
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  std::string alone = text.str();
  alone.replace(alone.find("stiffness: [800"), 15, "stiffness: [0.8");
  std::ofstream(folder_ + "/alone.yaml") << alone;
  try {
    EXPECT_FALSE(check_motion(folder_ + "/alone.yaml", plan.lifted).ok());
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("fell"), std::string::npos) << error.what();
  }
}

// What two feet tell of the rubber is right on one foot; the foot in the air is no part of it, and does not slip.
TEST_F(SingleSupport, IsPredictedByWhatTwoFeetTell) {
  std::vector<Source> sources = {{kHanging, run_in_process(load_scenario(write_hanging(base_, folder_))), false}};
  const std::vector<MotionPlan> plans = make_plans(0.6);
  for (size_t i : {kTilt, kTilt + 4, kSwayRight, kSwayLeft}) {
    sources.push_back({plans[i].name, run_in_process(load_scenario(write_motion(plans[i], base_, folder_))), i < 6});
  }
  const BushObserver observer(base_);
  const Observation o = observe(observer, sources);
  ASSERT_EQ(o.unseen.size(), 2u);
  for (size_t m = 0; m < 2; ++m) {
    const MotionTrack& track = o.unseen[m];
    EXPECT_TRUE(track.stands[m].all()) << "the foot that stays";
    EXPECT_LT(track.calc_standing_time(1 - m), 1.0) << "the foot that is lifted at 3 s";
    EXPECT_FALSE(has_slipped(track));
  }
  const BushFit fit = fit_bush(o.fitted, o.zeros, observer.bush_centres(), o.options);
  const std::vector<ValidationError> errors = validate(fit, o.unseen);
  ASSERT_EQ(errors.size(), 4u) << "one foot, two axes of each motion";
  for (const ValidationError& e : errors) {
    std::printf("%s foot %zu %s: %.3f N m of %.1f\n", e.motion.c_str(), e.foot, kAxisNames[e.axis], e.mean, e.largest);
    EXPECT_LT(e.relative(), 0.01);
  }
}

}  // namespace
}  // namespace hrp::identification
