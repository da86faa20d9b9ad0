// SPDX-License-Identifier: BSD-3-Clause
#include "controller/motion/motion.h"

#include <cmath>
#include <filesystem>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "controller/motion/leg.h"
#include "tests/catch_complaint.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

using ::testing::HasSubstr;

const char kSeq[] = R"(type: CompositeSeq
content: BodyMotion
formatVersion: 2
frameRate: 100
numFrames: 3
components:
  -
    type: MultiSE3Seq
    content: LinkPosition
    numParts: 1
    frames:
      - [ 0, 0, 0, 1, 0, 0, 0 ]
  -
    type: MultiValueSeq
    content: JointDisplacement
    numParts: 2
    frames:
      - [ 0, 1 ]
      - [ 0.5,
          1.5 ]
      - [ 1e0, -2 ]
  -
    type: Vector3Seq
    content: ZMP
    frames:
      - [ 0, 0, 0 ]
)";

std::string complain_csv(const std::string& text) {
  return catch_complaint([&] { parse_csv_motion(text, "m.csv"); });
}
std::string complain_seq(const std::string& text, const std::vector<std::string>& order = {"a", "b"}) {
  return catch_complaint([&] { parse_seq_motion(text, "m.seq", order); });
}

TEST(Motion, ReadsCsvWithNamesInTheHeader) {
  const Motion motion =
      parse_csv_motion("# made by hand\ntime,a,/joint_commands/b/position,/imu/x\n1,2,3,9\n1.5, 4 ,5,9\r\n", "m.csv");
  EXPECT_THAT(motion.joints, ::testing::ElementsAre("a", "b"));
  EXPECT_THAT(motion.times, ::testing::ElementsAre(0.0, 0.5));
  EXPECT_DOUBLE_EQ(motion.positions(1, 1), 5.0);
}

TEST(Motion, ReadsJointDisplacementsOfChoreonoidAndNothingElse) {
  const Motion motion = parse_seq_motion(kSeq, "m.seq", {"a", "b"});
  ASSERT_EQ(motion.times.size(), 3u);
  EXPECT_DOUBLE_EQ(motion.times[2], 0.02);
  EXPECT_DOUBLE_EQ(motion.positions(1, 1), 1.5);
  EXPECT_DOUBLE_EQ(motion.positions(1, 2), -2.0);
}

TEST(Motion, BadFilesAreRefusedWithLineAndReason) {
  EXPECT_THAT(complain_csv(""), HasSubstr("has no frames"));
  EXPECT_THAT(complain_csv("0,1\n"), HasSubstr("m.csv:1: error: the first column is '0'"));
  EXPECT_THAT(complain_csv("time,a,a\n"), HasSubstr("joint 'a' has two columns"));
  EXPECT_THAT(complain_csv("time,a\n0,x\n"), HasSubstr("m.csv:2: error: column 2 is 'x', expected a finite number"));
  EXPECT_THAT(complain_csv("time,a\n0,nan\n"), HasSubstr("column 2 is 'nan'"));
  EXPECT_THAT(complain_csv("time,a\n0,1,2\n"), HasSubstr("has 3 columns, expected 2"));
  EXPECT_THAT(complain_csv("time,a\n0,1\n0,1\n"), HasSubstr("m.csv:3: error: time 0.000000 s does not rise"));
  EXPECT_THAT(complain_seq("hello: 1\n"), HasSubstr("is no Choreonoid motion"));
  EXPECT_THAT(complain_seq(kSeq, {"a"}), HasSubstr("has 2 joints without names; controller.joint_order names 1"));
  EXPECT_THAT(complain_seq(std::string(kSeq).substr(0, 330)), HasSubstr("error:"));
  std::string broken = kSeq;
  broken.replace(broken.find("1e0"), 3, "zzz");
  EXPECT_THAT(complain_seq(broken), HasSubstr("m.seq:21: error: value 1 of the frame is 'zzz'"));
  EXPECT_THAT(catch_complaint([] { load_motion("/no/such.seq", {}); }), HasSubstr("cannot be read"));
  EXPECT_THAT(catch_complaint([] { load_motion(source_dir() + "/README.md", {}); }), HasSubstr("README.md"));
}

TEST(Motion, DamagedTextNeverCrashes) {
  std::mt19937 random(3);
  for (int i = 0; i < 4000; ++i) {
    std::string text = kSeq;
    if (i % 3 == 0) text.resize(random() % text.size());
    for (size_t k = 0; k < 1 + random() % 4 && !text.empty(); ++k)
      text[random() % text.size()] = "[]-:,. \n0e\xff"[random() % 11];
    complain_seq(text);
    complain_csv(text);
  }
}

TEST(MotionPlayer, FollowsAParabolaExactlyAndHoldsTheEnds) {
  // Slopes of uneven central differences are exact for parabolas, and so is the cubic between inner frames.
  std::string csv = "time,a\n";
  for (double t : {0.0, 0.1, 0.25, 0.3, 0.5, 0.6}) csv += std::to_string(t) + "," + std::to_string(t * t) + "\n";
  Eigen::VectorXd rest(2);
  rest << 7.0, 8.0;
  const MotionPlayer player(parse_csv_motion(csv, "m.csv"), {"z", "a"}, rest, "m.csv");
  Eigen::VectorXd q, qd;
  for (double t : {0.12, 0.2, 0.27, 0.45}) {
    player.sample(t, &q, &qd);
    EXPECT_NEAR(q[1], t * t, 1e-6) << "the file has six decimals";
    EXPECT_NEAR(qd[1], 2 * t, 1e-4);
    EXPECT_DOUBLE_EQ(q[0], 7.0) << "joints without a column rest";
  }
  player.sample(-1.0, &q, &qd);
  EXPECT_DOUBLE_EQ(q[1], 0.0);
  player.sample(5.0, &q, &qd);
  EXPECT_DOUBLE_EQ(q[1], 0.36);
  EXPECT_DOUBLE_EQ(qd[1], 0.0);
}

TEST(MotionPlayer, UnknownJointsAreNamed) {
  EXPECT_THAT(catch_complaint([] {
                MotionPlayer(parse_csv_motion("time,knee_l\n0,1\n", "m.csv"), {"knee_r"}, Eigen::VectorXd::Zero(1),
                             "m.csv");
              }),
              HasSubstr("moves joint 'knee_l', which the robot does not have; did you mean 'knee_r'?"));
}

TEST(Motion, WalkingPatternsOfSr1AreRead) {
  std::vector<std::string> order;
  for (int i = 0; i < 29; ++i) order.push_back("j" + std::to_string(i));
  const auto folder = std::filesystem::path(source_dir()) / "../shared/robots/sr1";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "NOT TESTED: ../shared/robots/sr1 is not there";
  const Motion first = load_motion((folder / "SR1WalkPattern1.seq").string(), order);
  EXPECT_EQ(first.times.size(), 6701u);
  EXPECT_NEAR(first.duration(), 13.4, 1e-9);
  EXPECT_DOUBLE_EQ(first.positions(1, 0), -0.036);
  EXPECT_EQ(load_motion((folder / "SR1WalkPattern2.seq").string(), order).times.size(), 7146u);
}

TEST(Leg, InverseKinematicsOfHalfSittingAndOutOfReach) {
  const LegGeometry leg{0.3, 0.3, 0.035};
  const double degree = M_PI / 180.0;
  const Eigen::Vector3d ankle(0.3 * std::sin(26 * degree) - 0.3 * std::sin(24 * degree), 0.035,
                              -0.3 * std::cos(26 * degree) - 0.3 * std::cos(24 * degree));
  const auto angles = solve_leg(leg, {Eigen::Matrix3d::Identity(), ankle});
  ASSERT_TRUE(angles.has_value());
  LegAngles expected;
  expected << 0, 0, -26 * degree, 50 * degree, -24 * degree, 0;
  EXPECT_LT((*angles - expected).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_FALSE(solve_leg(leg, {Eigen::Matrix3d::Identity(), {0, 0.035, -0.61}}).has_value());
}

// Forward kinematics of the joint order that the solution is made for, with any attitude of the foot.
TEST(Leg, InverseKinematicsUndoesForwardKinematics) {
  const LegGeometry leg{0.3, 0.28, -0.035};
  const auto turn = [](double angle, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  };
  for (int k = 0; k < 200; ++k) {
    LegAngles q;
    for (int i = 0; i < 6; ++i) q[i] = 0.5 * std::sin(1.0 + 3.7 * k + 2.1 * i);
    q[3] = 0.7 + q[3];  // knees bend one way
    const Eigen::Matrix3d thigh = turn(q[0], Eigen::Vector3d::UnitZ()) * turn(q[1], Eigen::Vector3d::UnitX()) *
                                  turn(q[2], Eigen::Vector3d::UnitY());
    const Eigen::Matrix3d shank = thigh * turn(q[3], Eigen::Vector3d::UnitY());
    Transform X_HF;
    X_HF.p = thigh * Eigen::Vector3d(0, 0, -leg.thigh) + shank * Eigen::Vector3d(0, leg.ankle_offset, -leg.shank);
    X_HF.R = shank * turn(q[4], Eigen::Vector3d::UnitY()) * turn(q[5], Eigen::Vector3d::UnitX());
    const auto angles = solve_leg(leg, X_HF);
    ASSERT_TRUE(angles.has_value());
    EXPECT_LT((*angles - q).cwiseAbs().maxCoeff(), 1e-9) << "closed form; near-straight knees cost digits";
  }
}

TEST(Motion, TheShippedSquatAndSwayStartsAndEndsInHalfSitting) {
  const Motion motion = load_motion(source_dir() + "/models/motions/hrp2p_squat_and_sway.csv", {});
  EXPECT_NEAR(motion.duration(), 10.0, 1e-9);
  EXPECT_LT((motion.positions.col(0) - motion.positions.rightCols(1)).cwiseAbs().maxCoeff(), 1e-7) << "8 decimals";
  EXPECT_NEAR(motion.positions(2, 0), 50.0 * M_PI / 180.0, 1e-7);
}

}  // namespace
}  // namespace hrp
