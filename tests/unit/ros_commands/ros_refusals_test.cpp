// SPDX-License-Identifier: BSD-3-Clause
// Messages that no robot can follow: what is said of them, and that the robot goes on as if they had not come.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "common/base/diagnostics.h"
#include "tests/unit/ros_commands/trio.h"

namespace hrp {
namespace {

struct BadTrajectory {
  const char* what;
  std::function<void(RosJointTrajectory*)> spoil;
  const char* said;
};

// Each is said with topic, field, value and what was expected, and the robot goes on as if it had not come.
TEST(RosRefusals, RefusesTrajectoriesThatCannotBe) {
  const BadTrajectory cases[] = {
      {"an unknown joint", [](auto* m) { m->joint_names()[1] = "kne"; },
       "joint_names[1]: 'kne'; expected a joint of trio; is it 'knee'?"},
      {"control characters", [](auto* m) { m->joint_names()[1] = "\x1b[2J\n"; },
       "joint_names[1]: '\\x1b[2J\\x0a'; expected a joint of trio"},
      {"a joint twice", [](auto* m) { m->joint_names()[1] = "hip"; },
       "joint_names[1]: 'hip' for the second time; expected each joint once"},
      {"no joints", [](auto* m) { m->joint_names().clear(); },
       "joint_names: empty; expected the joints that the points are for"},
      {"too few positions", [](auto* m) { m->points()[1].positions({0.1}); },
       "points[1].positions: 1 values; expected 2, one a joint of joint_names"},
      {"no positions", [](auto* m) { m->points()[0].positions().clear(); },
       "points[0].positions: 0 values; expected 2"},
      {"too many velocities",
       [](auto* m) {
         m->points()[0].velocities({0, 0, 0});
       },
       "points[0].velocities: 3 values; expected 2"},
      {"velocities in one point only", [](auto* m) { m->points()[0].velocities().clear(); },
       "points[1].velocities: 2 values; expected 0, as in the first point"},
      {"too few accelerations", [](auto* m) { m->points()[0].accelerations({0}); },
       "points[0].accelerations: 1 values; expected 2"},
      {"an effort without a number",
       [](auto* m) {
         m->points()[0].effort({0, kNan});
       },
       "points[0].effort[1]: joint 'knee' is told nan; expected a finite number"},
      {"too much effort",
       [](auto* m) {
         m->points()[0].effort({-6, 0});
         m->points()[1].effort({0, 0});
       },
       "points[0].effort[0]: joint 'hip' is told -6 N m; expected -5 to 5 N m"},
      {"not a number", [](auto* m) { m->points()[1].positions()[0] = kNan; },
       "points[1].positions[0]: joint 'hip' is told nan; expected a finite number"},
      {"infinite", [](auto* m) { m->points()[1].velocities()[0] = INFINITY; },
       "points[1].velocities[0]: joint 'hip' is told inf; expected a finite number"},
      {"beyond the limit", [](auto* m) { m->points()[1].positions()[1] = 1.1; },
       "points[1].positions[1]: joint 'knee' is told 1.1 rad; expected -1 to 1 rad, the joint's limits"},
      {"too fast at a point", [](auto* m) { m->points()[1].velocities()[0] = -2.5; },
       "points[1]: on the way there joint 'hip' reaches -2.5 rad/s; expected -2 to 2 rad/s"},
      {"too fast on the way",
       [](auto* m) {
         m->points()[0].time_from_start().sec(0);
         m->points()[0].time_from_start().nanosec(300000000);
       },
       "points[0]: on the way there joint 'hip' reaches 2.5 rad/s; expected -2 to 2 rad/s"},
      // From 0.2 to 0.99 and to 0.98, with 2 rad/s at the point: beyond 1 in between.
      {"beyond the limit on the way",
       [](auto* m) {
         m->points()[0].positions()[1] = 0.99;
         m->points()[0].velocities()[1] = 1.9;
         m->points()[1].positions()[1] = 0.98;
       },
       "points[1]: on the way there joint 'knee' reaches 1."},
      {"times that do not increase", [](auto* m) { m->points()[1].time_from_start().sec(1); },
       "points[1].time_from_start: 1 s; expected later than 1 s of the point before"},
      {"a negative time", [](auto* m) { m->points()[0].time_from_start().sec(-1); },
       "points[0].time_from_start: -1 s; expected 0 or later"},
      {"too many nanoseconds", [](auto* m) { m->points()[0].time_from_start().nanosec(1000000000); },
       "points[0].time_from_start.nanosec: 1000000000; expected less than 1000000000"},
  };
  for (const BadTrajectory& bad : cases) {
    Played played, undisturbed;
    for (Played* each : {&played, &undisturbed}) {
      each->step();
      each->controller.take(make_good_message());
      each->play(0.25);
    }
    RosJointTrajectory message = make_message({"hip", "knee"});
    add_point(1.0, {0.5, 0.2}, {0.0, 0.0}, &message);
    add_point(2.0, {0.6, 0.4}, {0.0, 0.0}, &message);
    // The ways are judged from rest.
    if (std::string(bad.what).find("on the way") != std::string::npos) {
      played.restart(0);
      undisturbed.restart(0);
      played.step();
      undisturbed.step();
    }
    bad.spoil(&message);
    try {
      played.controller.take(message);
      ADD_FAILURE() << bad.what << " was taken";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(std::string("rt/joint_trajectory: error: ") + bad.said)) << bad.what;
      EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n"))) << bad.what;
    }
    for (int i = 0; i < 400; ++i) ASSERT_EQ(played.step().q, undisturbed.step().q) << bad.what;
  }
}

TEST(RosRefusals, RefusesPositionsThatCannotBe) {
  Played played;
  played.step();
  const auto expect_refused = [&](const RosPositions& message, const std::string& said) {
    try {
      played.controller.take(message);
      ADD_FAILURE() << "taken; expected " << said;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("rt/position_commands: error: " + said));
    }
    EXPECT_EQ(played.step().q, Eigen::VectorXd(Eigen::Vector3d(0.0, 0.2, 0.0)));
  };
  RosPositions message;
  message.data({0.1, 0.2});
  expect_refused(message, "data: 2 values; expected 3, one a joint in the order of joint_states");
  message.data({0.1, kNan, 0.0});
  expect_refused(message, "data[1]: joint 'knee' is told nan; expected a finite number");
  message.data({0.1, 0.2, 0.0});
  message.data()[0] = -1.5;
  expect_refused(message, "data[0]: joint 'hip' is told -1.5 rad; expected -1 to 1 rad, the joint's limits");
  message.data()[0] = 0.1;
  message.layout().data_offset(3);
  expect_refused(message, "layout.data_offset: 3; expected 0");
}

// Plans print limits such as pi / 3 with six decimals: up to 5e-7 beyond.
TEST(RosRefusals, TakesALimitThatWasRoundedToSixDecimals) {
  Played played;
  RosPositions message;
  message.data({1.0000005, 0.2, 0.0});
  EXPECT_NO_THROW(played.controller.take(message));
}

// Numbers as a careless node sends them: small and huge, none at all, counts that do not fit.
class RandomMessage {
 public:
  explicit RandomMessage(unsigned seed) : random_(seed) {}

  RosJointTrajectory make() {
    static const std::vector<std::string> names{"hip", "knee", "slide", "hop"};
    RosJointTrajectory message;
    for (size_t k = find_count(2); k > 0; --k)
      message.joint_names().push_back(names[(k + find_count(3)) % (is_rare() ? 4 : 3)]);
    double time = 0.0;
    for (size_t i = find_count(4); i > 0; --i) {
      time += is_rare() ? 0.0 : 3.0 * std::abs(small_(random_));
      add_point(time, make_numbers(message.joint_names().size()), {}, &message);
      if (with_velocities_) message.points().back().velocities(make_numbers(message.joint_names().size()));
    }
    with_velocities_ = !with_velocities_;
    return message;
  }

 private:
  bool is_rare() { return random_() % 40 == 0; }
  size_t find_count(size_t most) { return random_() % (most + 1); }
  std::vector<double> make_numbers(size_t count) {
    std::vector<double> numbers(is_rare() ? count + 1 : count);
    for (double& number : numbers) number = is_rare() ? kNan : is_rare() ? 1e300 : 0.5 * small_(random_);
    return numbers;
  }

  std::mt19937 random_;
  std::uniform_real_distribution<double> small_{-1.0, 1.0};
  bool with_velocities_ = false;
};

// Whatever comes: all commands are within the limits, and positions make no jump that a velocity of 2 rad/s does not
// allow.
TEST(RosRefusals, NoMessageMakesAnyJointLeaveItsLimits) {
  Played played;
  RandomMessage random(5);
  JointCommand before = played.step();
  int taken = 0, refused = 0;
  for (int i = 0; i < 20000; ++i) {
    if (i % 20 == 0) {
      const RosJointTrajectory message = random.make();
      const bool jumps = !message.points().empty() && message.points()[0].time_from_start().sec() == 0 &&
                         message.points()[0].time_from_start().nanosec() == 0;  // to be taken as it is
      try {
        if (!jumps) {
          played.controller.take(message);
          ++taken;
        }
      } catch (const InputError&) {
        ++refused;
      }
    }
    const JointCommand now = played.step();
    for (int joint = 0; joint < 2; ++joint) {
      ASSERT_LE(std::abs(now.q[joint]), 1.0 + 1e-6);  // what the controller allows for rounded plans
      ASSERT_LE(std::abs(now.qd[joint]), 2.0 + 1e-6);
      ASSERT_LE(std::abs(now.q[joint] - before.q[joint]), (2.0 + 1e-6) * kPeriod + kExact);
    }
    ASSERT_TRUE(std::isfinite(now.q[2]));
    before = now;
  }
  EXPECT_GT(taken, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace hrp
