// SPDX-License-Identifier: BSD-3-Clause
// Columns of left and right legs that are exchanged in other people's walks.
#include "diagnosis/floating/conventions/exchanged_legs.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <utility>

#include "diagnosis/floating/conventions/exchanged_sides.h"
#include "tests/test_places.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

// Each joint's columns for those of its name with the other side.
void exchange(const std::string& left, const std::string& right, Experiment* e) {
  for (int j = 0; j < e->num_joints(); ++j) {
    std::string name = e->robot.tree.joint(j).name;
    if (name.rfind(left, 0) != 0) continue;
    const int other = e->robot.tree.find_joint(name.replace(0, left.size(), right));
    ASSERT_GE(other, 0) << name;
    for (Recording& r : e->recordings)
      std::swap(r.joints[static_cast<size_t>(j)], r.joints[static_cast<size_t>(other)]);
  }
}

class Exchanged : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const std::filesystem::path path =
        std::filesystem::path(source_dir()) / "../shared/recordings" / GetParam() / "experiment.yaml";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there, NOTHING was checked";
    e_ = load_experiment(path.string());
  }
  Experiment e_;
};

TEST_P(Exchanged, LegsOfARealWalkAreSuspected) {
  exchange("l_", "r_", &e_);
  exchange("FL_", "FR_", &e_);
  exchange("RL_", "RR_", &e_);
  EXPECT_NE(find_exchanged_legs(e_).find("look exchanged"), std::string::npos);
}

TEST_P(Exchanged, NoLegsAreSuspectedWhereColumnsAreRight) { EXPECT_EQ(find_exchanged_legs(e_), ""); }

// Vertical forces alone. A trot bears on diagonals: exchanged feet press in the same middle there, and nothing is said.
TEST_P(Exchanged, FeetThatBearWhileTheyAreInTheAirAreExchangedBack) {
  EXPECT_FALSE(find_exchanged_sides(e_).any());
  if (e_.scenario.feet.size() > 2) return;
  ExchangedSides x;
  x.feet = {{"l_sole", "r_sole"}};
  const ExchangedSides found = find_exchanged_sides(convert_sides(e_, x));
  EXPECT_EQ(found.feet.size(), 1u);
  EXPECT_TRUE(found.legs.empty());
}

INSTANTIATE_TEST_SUITE_P(Recordings, Exchanged, testing::Values("icub_walking", "go1_walk"));

TEST(ExchangedLegs, NoneAreSuspectedOfABodyWhoseLegsTurnAboutTheSameAxes) {
  for (const bool leans : {false, true}) {
    Recorded recorded;
    recorded.leans = leans;
    EXPECT_EQ(find_exchanged_legs(make_biped({}, recorded)), "");
  }
}

Experiment exchange_forces(Experiment e) {
  ExchangedSides x;
  x.feet = {{"l", "r"}};
  return convert_sides(std::move(e), x);
}

// Nothing but the balance of moments tells: both legs turn about the same axes, and both feet stay.
TEST(ExchangedSides, FeetThatPressOnTheOtherSideThanTheMotionAsksForAreExchangedBack) {
  Recorded recorded = kLeans;
  recorded.lifts = true;
  const ExchangedSides found = find_exchanged_sides(exchange_forces(make_biped({}, recorded)));
  ASSERT_EQ(found.feet.size(), 1u);
  EXPECT_EQ(found.feet[0], std::pair(std::string("l"), std::string("r")));
  EXPECT_TRUE(found.legs.empty());
  EXPECT_LT(found.left, 0.25) << "as any convention";
  EXPECT_NE(describe(found).find("exchanged"), std::string::npos);
}

TEST(ExchangedSides, NoneAreExchangedWhereColumnsAreRight) {
  for (const bool leans : {false, true}) {
    Recorded recorded;
    recorded.leans = leans;
    EXPECT_FALSE(find_exchanged_sides(make_biped({}, recorded)).any());
  }
}

// A load on one side stays on that side; so does a hand that sways the robot.
TEST(ExchangedSides, NeitherALoadOnOneSideNorAHandLooksLikeAnExchange) {
  Hidden hidden;
  hidden.load = 5;
  hidden.place = {0, 0.3, 0};
  EXPECT_FALSE(find_exchanged_sides(make_biped(hidden)).any());
  hidden = {};
  hidden.push = 200;
  EXPECT_FALSE(find_exchanged_sides(make_biped(hidden, kLeans)).any());
}

}  // namespace
}  // namespace hrp::diagnosis::floating
