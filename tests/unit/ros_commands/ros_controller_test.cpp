// SPDX-License-Identifier: BSD-3-Clause
#include "controller/ros/ros_controller.h"

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "common/bus/memory/memory_bus.h"
#include "common/messages/convert_robot.h"
#include "common/messages/ros_topics.h"
#include "controller/play.h"

namespace hrp {
namespace {

constexpr double kExact = 1e-12;  // a few roundings of numbers of size 1
constexpr double kPeriod = 0.005;  // [s]
const double kNan = std::numeric_limits<double>::quiet_NaN();

// Three joints: -1 to 1 rad, 2 rad/s, 5 N m each; the last one slides and has no limits.
RobotDescription make_description() {
  RobotDescription description;
  description.tree.name = "trio";
  for (int i = 0; i < 4; ++i) {
    LinkSpec link;
    link.name = "link" + std::to_string(i);
    link.parent = i - 1;
    link.inertia.mass = 1.0;
    link.joint.name = i == 1 ? "hip" : i == 2 ? "knee" : "slide";
    if (i == 1 || i == 2) {
      link.joint.lower = -1.0, link.joint.upper = 1.0;
      link.joint.velocity_limit = 2.0, link.joint.effort_limit = 5.0;
    }
    if (i == 3) link.joint.kind = JointKind::kPrismatic;
    description.tree.links.push_back(link);
  }
  description.scenario_path = "trio.yaml";
  description.scenario =
      "robot: trio.urdf\n"
      "servo: {default: {kp: 1, kd: 0}}\n"
      "initial: {joints: {knee: 0.2}}\n"
      "steps: {time_step: 0.001, control_period: 0.005, duration: 10}\n";
  return description;
}

Robot make_trio() {
  const RobotDescription description = make_description();
  return make_robot(description, parse_scenario(description.scenario, description.scenario_path));
}

RosJointTrajectory make_message(const std::vector<std::string>& names) {
  RosJointTrajectory message;
  message.joint_names(names);
  return message;
}

void add_point(double time, const std::vector<double>& q, const std::vector<double>& qd, RosJointTrajectory* message) {
  ::trajectory_msgs::msg::dds_::JointTrajectoryPoint_ point;
  point.positions(q);
  point.velocities(qd);
  point.time_from_start().sec(static_cast<int32_t>(std::floor(time)));
  point.time_from_start().nanosec(static_cast<uint32_t>(std::lround((time - std::floor(time)) * 1e9)));
  message->points().push_back(point);
}

// hip to 0.5 rad in 1 s, then knee and hip on.
RosJointTrajectory make_good_message() {
  RosJointTrajectory message = make_message({"hip", "knee"});
  add_point(1.0, {0.5, 0.2}, {0.0, 0.0}, &message);
  add_point(2.0, {0.6, 0.4}, {0.0, 0.0}, &message);
  return message;
}

// In the place of one that walks: all joints at 0.1 t, with velocities and no efforts.
class Drifting : public Controller {
 public:
  JointCommand control(const SensorData& sensors, const Robot& robot) override {
    const auto n = static_cast<Eigen::Index>(robot.joints.size());
    return {Eigen::VectorXd::Constant(n, 0.1 * sensors.time), Eigen::VectorXd::Constant(n, 0.1), {}};
  }
};

class Played {
 public:
  Played() : Played(make_trio()) {}
  explicit Played(const Robot& r) : Played(r, make_scenario_controller(r)) {}
  Played(const Robot& r, std::unique_ptr<Controller> other) : robot(r), controller(r, std::move(other)) { controller.start(robot); }
  // The answer to the next sample.
  JointCommand step() {
    SensorData sensors;
    sensors.time = kPeriod * static_cast<double>(count_++);
    sensors.q = measured;
    return last = controller.control(sensors, robot);
  }
  JointCommand play(double seconds) {
    for (int i = 0; i < std::lround(seconds / kPeriod); ++i) step();
    return last;
  }
  void restart(long count) {
    count_ = count;
    controller.start(robot);
  }

  Robot robot;
  RosController controller;
  Eigen::VectorXd measured = Eigen::Vector3d(0.01, 0.02, 0.03);
  JointCommand last;

 private:
  long count_ = 0;
};

TEST(RosController, HoldsTheInitialPoseUntilItIsTold) {
  Played played;
  for (int i = 0; i < 10; ++i) EXPECT_EQ(played.step().q, Eigen::VectorXd(Eigen::Vector3d(0.0, 0.2, 0.0)));
}

TEST(RosController, BeginsAtTheLastCommandAndPassesThePointsAtTheirTimesSinceThen) {
  Played played;
  played.play(0.5);
  played.controller.take(make_good_message());
  const JointCommand first = played.step();
  EXPECT_NEAR(first.q[0], make_cubic(0.0, 0.0, 0.5, 0.0, 1.0).find_position(kPeriod), kExact);
  EXPECT_EQ(first.q[1], 0.2);
  EXPECT_NEAR(played.play(1.0 - kPeriod).q[0], 0.5, kExact);
  EXPECT_NEAR(played.play(0.5).q[0], 0.55, kExact);
  EXPECT_NEAR(played.last.q[1], 0.3, kExact);
  EXPECT_NEAR(played.last.qd[1], 1.5 * 0.2, 1e-9);  // rest to rest; times of 1e-13 s times the acceleration
  EXPECT_NEAR(played.play(3.0).q[1], 0.4, kExact);
  EXPECT_EQ(played.last.qd[1], 0.0);
  EXPECT_EQ(played.last.q[2], 0.0);
}

TEST(RosController, ANewMessageGoesOnFromThePresentPositionAndVelocity) {
  Played played;
  played.step();
  played.controller.take(make_good_message());
  const JointCommand before = played.play(0.5);
  ASSERT_NEAR(before.qd[0], 0.75, 1e-9);
  RosJointTrajectory back = make_message({"hip"});
  add_point(1.0, {0.0}, {0.0}, &back);
  played.controller.take(back);
  const CubicSegment expected = make_cubic(before.q[0], before.qd[0], 0.0, 0.0, 1.0);
  EXPECT_NEAR(played.step().q[0], expected.find_position(kPeriod), kExact);
  EXPECT_NEAR(played.last.qd[0], expected.find_velocity(kPeriod), kExact);
  EXPECT_EQ(played.play(2.0).q[0], 0.0);
  EXPECT_EQ(played.last.q[1], before.q[1]);  // the old message is no longer followed
}

TEST(RosController, PositionsOnlyAreFollowedOnStraightLines) {
  Played played;
  played.step();
  RosJointTrajectory message = make_message({"slide"});
  add_point(2.0, {4.0}, {}, &message);
  played.controller.take(message);
  EXPECT_NEAR(played.play(0.5).q[2], 1.0, kExact);
  EXPECT_NEAR(played.last.qd[2], 2.0, kExact);
  EXPECT_EQ(played.last.q[1], 0.2);
}

TEST(RosController, EffortsAreFedForwardOnStraightLinesAndKept) {
  Played played;
  played.step();
  RosJointTrajectory message = make_message({"knee"});
  add_point(1.0, {0.2}, {}, &message);
  message.points()[0].effort({4.0});
  played.controller.take(message);
  EXPECT_NEAR(played.play(0.5).effort[1], 2.0, kExact);
  EXPECT_EQ(played.play(1.0).effort[1], 4.0);
  RosJointTrajectory other = make_message({"hip"});
  add_point(1.0, {0.1}, {}, &other);
  played.controller.take(other);
  EXPECT_EQ(played.play(0.5).effort[1], 4.0);
  EXPECT_EQ(played.last.effort[0], 0.0);
}

TEST(RosController, AFirstPointAtTimeZeroIsWhereTheTrajectoryBegins) {
  Played played;
  played.step();
  RosJointTrajectory message = make_message({"hip"});
  add_point(0.0, {0.5}, {}, &message);
  add_point(1.0, {0.7}, {}, &message);
  played.controller.take(message);
  EXPECT_NEAR(played.step().q[0], 0.5 + 0.2 * kPeriod, kExact);
}

TEST(RosController, AMessageWithoutPointsStopsAllJointsWhereTheyAre) {
  Played played;
  played.step();
  played.controller.take(make_good_message());
  const JointCommand before = played.play(0.5);
  played.controller.take(RosJointTrajectory{});
  EXPECT_EQ(played.step().q, before.q);
  EXPECT_TRUE(played.last.qd.isZero(0.0));
  EXPECT_EQ(played.play(2.0).q, before.q);
}

TEST(RosController, PositionCommandsHoldFromTheNextSampleOn) {
  Played played;
  played.step();
  played.controller.take(make_good_message());
  played.play(0.5);
  RosPositions message;
  message.data({-0.5, 0.25, 7.0});
  played.controller.take(message);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(played.step().q, Eigen::VectorXd(Eigen::Vector3d(-0.5, 0.25, 7.0)));
    EXPECT_TRUE(played.last.qd.isZero(0.0));
  }
}

TEST(RosController, JointsThatNoMessageHasNamedFollowTheOtherController) {
  Robot robot = make_trio();
  robot.settings.type = "walk";
  Played played(robot, std::make_unique<Drifting>());
  played.play(1.0);
  const JointCommand before = played.step();
  EXPECT_NEAR(before.q[1], 0.1, kExact);
  RosJointTrajectory message = make_message({"knee"});
  add_point(1.0, {0.5}, {0.0}, &message);
  played.controller.take(message);
  played.step();
  // From where the other controller had it, with the velocity that it had told.
  EXPECT_NEAR(played.last.q[1], make_cubic(0.1, 0.1, 0.5, 0.0, 1.0).find_position(kPeriod), kExact);
  EXPECT_NEAR(played.last.q[0], 0.1 * (1.0 + kPeriod), kExact);
  played.play(2.0);
  EXPECT_EQ(played.last.q[1], 0.5);
  EXPECT_NEAR(played.last.q[0], 0.1 * (3.0 + kPeriod), kExact);
  EXPECT_NEAR(played.last.qd[0], 0.1, kExact);
  // The knee stays where it was told to be when another joint is named.
  RosJointTrajectory other = make_message({"hip"});
  add_point(1.0, {0.4}, {}, &other);
  played.controller.take(other);
  played.play(1.5);
  EXPECT_EQ(played.last.q[1], 0.5);
  EXPECT_EQ(played.last.q[0], 0.4);
  EXPECT_NEAR(played.last.q[2], 0.1 * (4.5 + kPeriod), kExact);
}

TEST(RosController, OneThatJoinsAWalkLeavesItToTheOtherController) {
  Robot robot = make_trio();
  robot.settings.type = "walk";
  Played played(robot, std::make_unique<Drifting>());
  played.restart(1000);
  EXPECT_NEAR(played.step().q[0], 0.5, kExact);
}

TEST(RosController, AResetForgetsTheMessageAndGoesToTheInitialPose) {
  Played played;
  played.step();
  played.controller.take(make_good_message());
  played.play(1.0);
  played.restart(0);
  EXPECT_EQ(played.play(1.0).q, Eigen::VectorXd(Eigen::Vector3d(0.0, 0.2, 0.0)));
}

TEST(RosController, AMessageBeforeTheFirstSampleBeginsWithIt) {
  Played played;
  played.controller.take(make_good_message());
  played.restart(0);
  EXPECT_EQ(played.step().q[0], 0.0);
  EXPECT_NEAR(played.play(1.0).q[0], 0.5, kExact);
}

TEST(RosController, OneThatJoinsARunThatGoesOnHoldsTheMeasuredPose) {
  Played played;
  played.restart(1000);
  EXPECT_EQ(played.step().q, played.measured);
  const Eigen::VectorXd first = played.measured;
  played.measured.setOnes();
  EXPECT_EQ(played.step().q, first);
}

struct BadTrajectory {
  const char* what;
  std::function<void(RosJointTrajectory*)> spoil;
  const char* said;
};

// Each is said with topic, field, value and what was expected, and the robot goes on as if it had not come.
TEST(RosController, RefusesTrajectoriesThatCannotBe) {
  const BadTrajectory cases[] = {
      {"an unknown joint", [](auto* m) { m->joint_names()[1] = "kne"; }, "joint_names[1]: 'kne'; expected a joint of trio; is it 'knee'?"},
      {"control characters", [](auto* m) { m->joint_names()[1] = "\x1b[2J\n"; }, "joint_names[1]: '\\x1b[2J\\x0a'; expected a joint of trio"},
      {"a joint twice", [](auto* m) { m->joint_names()[1] = "hip"; }, "joint_names[1]: 'hip' for the second time; expected each joint once"},
      {"no joints", [](auto* m) { m->joint_names().clear(); }, "joint_names: empty; expected the joints that the points are for"},
      {"too few positions", [](auto* m) { m->points()[1].positions({0.1}); }, "points[1].positions: 1 values; expected 2, one a joint of joint_names"},
      {"no positions", [](auto* m) { m->points()[0].positions().clear(); }, "points[0].positions: 0 values; expected 2"},
      {"too many velocities", [](auto* m) { m->points()[0].velocities({0, 0, 0}); }, "points[0].velocities: 3 values; expected 2"},
      {"velocities in one point only", [](auto* m) { m->points()[0].velocities().clear(); }, "points[1].velocities: 2 values; expected 0, as in the first point"},
      {"too few accelerations", [](auto* m) { m->points()[0].accelerations({0}); }, "points[0].accelerations: 1 values; expected 2"},
      {"an effort without a number", [](auto* m) { m->points()[0].effort({0, kNan}); }, "points[0].effort[1]: joint 'knee' is told nan; expected a finite number"},
      {"too much effort", [](auto* m) { m->points()[0].effort({-6, 0}); m->points()[1].effort({0, 0}); }, "points[0].effort[0]: joint 'hip' is told -6 N m; expected -5 to 5 N m"},
      {"not a number", [](auto* m) { m->points()[1].positions()[0] = kNan; }, "points[1].positions[0]: joint 'hip' is told nan; expected a finite number"},
      {"infinite", [](auto* m) { m->points()[1].velocities()[0] = INFINITY; }, "points[1].velocities[0]: joint 'hip' is told inf; expected a finite number"},
      {"beyond the limit", [](auto* m) { m->points()[1].positions()[1] = 1.1; }, "points[1].positions[1]: joint 'knee' is told 1.1 rad; expected -1 to 1 rad, the joint's limits"},
      {"too fast at a point", [](auto* m) { m->points()[1].velocities()[0] = -2.5; }, "points[1]: on the way there joint 'hip' reaches -2.5 rad/s; expected -2 to 2 rad/s"},
      {"too fast on the way", [](auto* m) { m->points()[0].time_from_start().sec(0); m->points()[0].time_from_start().nanosec(300000000); }, "points[0]: on the way there joint 'hip' reaches 2.5 rad/s; expected -2 to 2 rad/s"},
      // From 0.2 to 0.99 and to 0.98, with 2 rad/s at the point: beyond 1 in between.
      {"beyond the limit on the way", [](auto* m) { m->points()[0].positions()[1] = 0.99; m->points()[0].velocities()[1] = 1.9; m->points()[1].positions()[1] = 0.98; }, "points[1]: on the way there joint 'knee' reaches 1."},
      {"times that do not increase", [](auto* m) { m->points()[1].time_from_start().sec(1); }, "points[1].time_from_start: 1 s; expected later than 1 s of the point before"},
      {"a negative time", [](auto* m) { m->points()[0].time_from_start().sec(-1); }, "points[0].time_from_start: -1 s; expected 0 or later"},
      {"too many nanoseconds", [](auto* m) { m->points()[0].time_from_start().nanosec(1000000000); }, "points[0].time_from_start.nanosec: 1000000000; expected less than 1000000000"},
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
      played.restart(0), undisturbed.restart(0);
      played.step(), undisturbed.step();
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

TEST(RosController, RefusesPositionsThatCannotBe) {
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
TEST(RosController, TakesALimitThatWasRoundedToSixDecimals) {
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
    for (size_t k = find_count(2); k > 0; --k) message.joint_names().push_back(names[(k + find_count(3)) % (is_rare() ? 4 : 3)]);
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

// Whatever comes: all commands are within the limits, and positions make no jump that a velocity of 2 rad/s does not allow.
TEST(RosController, NoMessageMakesAnyJointLeaveItsLimits) {
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
        if (!jumps) played.controller.take(message), ++taken;
      } catch (const InputError&) {
        ++refused;
      }
    }
    const JointCommand now = played.step();
    for (int joint = 0; joint < 2; ++joint) {
      ASSERT_LE(std::abs(now.q[joint]), 1.0 + 1e-6);   // what the controller allows for rounded plans
      ASSERT_LE(std::abs(now.qd[joint]), 2.0 + 1e-6);
      ASSERT_LE(std::abs(now.q[joint] - before.q[joint]), (2.0 + 1e-6) * kPeriod + kExact);
    }
    ASSERT_TRUE(std::isfinite(now.q[2]));
    before = now;
  }
  EXPECT_GT(taken, 100);
  EXPECT_GT(refused, 100);
}

// The node answers in lockstep; what is no message at all ends no run.
class RosNode : public testing::Test {
 protected:
  RosNode() : node_({&bus_, "controller", "hrp-controller-ros", ""}), sensors_(bus_, topics::kSensorData), ros_(bus_.make_writer(topics::kRosJointTrajectory)) {
    node_.make_endpoints();
    reader_ = subscribe<msg::JointCommands>(bus_, topics::kJointCommands, Delivery::kReliable, [this](const msg::JointCommands& m) { answers_.push_back(m); });
    status_reader_ = subscribe<msg::ServerStatus>(bus_, topics::kServerStatus, Delivery::kReliable, [this](const msg::ServerStatus& m) { said_ = m.message(); });
  }

  void describe() {
    msg::RobotDescription message;
    to_message(make_description(), &message);
    Publisher<msg::RobotDescription>(bus_, topics::kRobotDescription).publish(message);
    bus_.dispatch_all();
  }

  void ask(uint64_t step) {
    msg::SensorData message;
    message.header().step(step);
    message.header().time(0.001 * static_cast<double>(step));
    message.positions({0.0, 0.2, 0.0});
    message.velocities({0.0, 0.0, 0.0});
    message.efforts({0.0, 0.0, 0.0});
    sensors_.publish(message);
    bus_.dispatch_all();
  }

  void tell(const RosJointTrajectory& message) {
    std::vector<char> buffer;
    ros_->write(encode(message, &buffer));
    bus_.dispatch_all();
    node_.on_idle(std::chrono::steady_clock::now());
    bus_.dispatch_all();
  }

  MemoryBus bus_;
  RosControllerNode node_;
  Publisher<msg::SensorData> sensors_;
  std::unique_ptr<Writer> ros_;
  std::unique_ptr<Reader> reader_, status_reader_;
  std::vector<msg::JointCommands> answers_;
  std::string said_;
};

TEST_F(RosNode, AnswersEverySampleWithTheTrajectoryOfItsTime) {
  describe();
  ask(0);
  tell(make_good_message());
  ask(500);
  ask(500);  // repeated, as when an answer was lost
  ask(1000);
  ASSERT_EQ(answers_.size(), 4u);
  EXPECT_EQ(answers_[0].positions(), (std::vector<double>{0.0, 0.2, 0.0}));
  EXPECT_NEAR(answers_[1].positions()[0], 0.25, kExact);
  EXPECT_EQ(answers_[2].positions(), answers_[1].positions());
  EXPECT_EQ(answers_[3].header().step(), 1000u);
  EXPECT_NEAR(answers_[3].positions()[0], 0.5, kExact);
}

TEST_F(RosNode, SaysWhatItRefusesAndGoesOn) {
  describe();
  ask(0);
  RosJointTrajectory message = make_good_message();
  message.joint_names()[0] = "hop";
  tell(message);
  EXPECT_THAT(said_, testing::HasSubstr("refused, goes on as before: rt/joint_trajectory: error: joint_names[0]: 'hop'"));
  ask(5);
  EXPECT_EQ(answers_.back().positions(), answers_.front().positions());
  EXPECT_EQ(node_.outcome(), NodeOutcome::kRunning);
}

TEST(RosNodeOfAnotherRobot, FollowsTheTopicsOfItsNamespace) {
  MemoryBus bus;
  NodeContext context{&bus, "controller.partner", "hrp-controller-ros", ""};
  context.robot = "partner";
  RosControllerNode node(context);
  node.make_endpoints();
  std::string said;
  const auto status = subscribe<msg::ServerStatus>(bus, topics::kServerStatus, Delivery::kReliable, [&](const msg::ServerStatus& m) { said = m.message(); });
  msg::RobotDescription description;
  to_message(make_description(), &description);
  Publisher<msg::RobotDescription>(bus, topics::of_robot(topics::kRobotDescription, "partner")).publish(description);
  RosJointTrajectory message = make_good_message();
  message.joint_names()[0] = "hop";
  Publisher<RosJointTrajectory> first(bus, topics::kRosJointTrajectory), its(bus, topics::of_robot(topics::kRosJointTrajectory, "partner"));
  const auto tell = [&](Publisher<RosJointTrajectory>* publisher) {
    publisher->publish(message);
    bus.dispatch_all();
    node.on_idle(std::chrono::steady_clock::now());
    bus.dispatch_all();
  };
  tell(&first);
  EXPECT_EQ(said, "") << "that of the first robot";
  tell(&its);
  EXPECT_THAT(said, testing::HasSubstr("rt/partner/joint_trajectory: error: joint_names[0]: 'hop'"));
}

TEST_F(RosNode, BytesThatAreNoMessageEndNoRun) {
  describe();
  ask(0);
  const std::vector<uint8_t> garbage(64, 0xff);
  ros_->write({garbage.data(), garbage.size()});
  bus_.dispatch_all();
  node_.on_idle(std::chrono::steady_clock::now());
  bus_.dispatch_all();
  EXPECT_THAT(said_, testing::HasSubstr("rt/joint_trajectory: cannot decode a sample of 64 bytes"));
  ask(5);
  EXPECT_EQ(answers_.size(), 2u);
}

// Whoever starts a run and sends a command at once: the robot does it, even if the node did not know the robot yet.
TEST_F(RosNode, DoesWhatCameBeforeTheRobotWasKnown) {
  tell(make_good_message());
  describe();
  ask(0);
  ask(500);
  ASSERT_EQ(answers_.size(), 2u);
  EXPECT_NEAR(answers_[1].positions()[0], 0.25, kExact);
}

TEST_F(RosNode, RefusesWhatIsWrongOfAnEarlyMessageWhenTheRobotIsKnown) {
  RosJointTrajectory message = make_good_message();
  message.joint_names()[0] = "hop";
  tell(message);
  describe();
  node_.on_idle(std::chrono::steady_clock::now());
  bus_.dispatch_all();
  EXPECT_THAT(said_, testing::HasSubstr("rt/joint_trajectory: error: joint_names[0]: 'hop'"));
}

TEST_F(RosNode, SaysThatTooManyMessagesCameBeforeTheRobotWasKnown) {
  for (int i = 0; i < 17; ++i) tell(make_good_message());
  EXPECT_THAT(said_, testing::HasSubstr("rt/joint_trajectory: came before the robot was known, after 16 others; send it again"));
}

}  // namespace
}  // namespace hrp
