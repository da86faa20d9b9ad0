// SPDX-License-Identifier: BSD-3-Clause
// Positions and velocities of one log contradict each other where one of them is scaled or late; no dynamics is needed.
#include "diagnosis/measurement/velocity_log.h"

#include "diagnosis/data/command_reader.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

constexpr double kScale = 0.92, kDelay = 0.0133;  // [s] no multiple of the sampling time of 5 ms

// The arm of the other tests with the elbow's log as `hidden` says; 200 Hz, noise as there.
VelocityReading read_elbow(const std::string& name, const Hypothesis& hidden) {
  return find_velocity_readings(make_simulated_experiment(name, kArm, {"shoulder", "elbow"}, hidden))[kElbow];
}

TEST(VelocityLog, AWrongScaleOfAVelocityIsRead) {
  const VelocityReading log =
      read_elbow("velocity_scale", {{EffectId::kSensorScale, at_sensor(kElbow, Reading::kVelocity), {kScale}}});
  ASSERT_TRUE(log.is_scaled());
  EXPECT_NEAR(log.scale, kScale, 0.002);  // a tenth of what a log may be off unsaid
  EXPECT_EQ(log.late, 0.0);
}

TEST(VelocityLog, AVelocityThatIsOffByAConstantIsRead) {
  constexpr double kOff = -0.05;  // [rad/s] of 0.5 rad/s root mean square
  const VelocityReading log =
      read_elbow("velocity_bias", {{EffectId::kSensorBias, at_sensor(kElbow, Reading::kVelocity), {kOff}}});
  ASSERT_TRUE(log.is_biased());
  EXPECT_NEAR(log.bias, kOff, 0.002);  // noise of 0.002 rad/s a sample, 2000 of them, and the ends of the motion
  EXPECT_FALSE(log.is_scaled());
  EXPECT_EQ(log.late, 0.0);
}

// Stamps that are off do the same to all joints.
TEST(VelocityLog, OneJointOfAnotherScaleIsNoFaultOfTheClock) {
  const Effect elbow{EffectId::kSensorScale, at_sensor(kElbow, Reading::kVelocity), {kScale}};
  const Effect shoulder{EffectId::kSensorScale, at_sensor(kShoulder, Reading::kVelocity), {kScale}};
  const std::vector<VelocityReading> one =
      find_velocity_readings(make_simulated_experiment("velocity_one", kArm, {"shoulder", "elbow"}, {elbow}));
  const std::vector<VelocityReading> both = find_velocity_readings(
      make_simulated_experiment("velocity_both", kArm, {"shoulder", "elbow"}, {shoulder, elbow}));
  EXPECT_FALSE(may_be_clock(one, one[kElbow]));
  EXPECT_TRUE(may_be_clock(both, both[kElbow]));
}

// Logs of several rates have empty cells between the samples of the slower one.
TEST(VelocityLog, ALateSeriesWithEmptyCellsIsShiftedBetweenItsSamples) {
  std::vector<double> time, series;
  for (int k = 0; k < 20; ++k) {
    time.push_back(0.01 * k);
    series.push_back(k % 2 == 0 ? 3.0 * time.back() : NAN);
  }
  move_series(time, 0.013, &series);
  for (int k = 0; k < 17; k += 2) EXPECT_NEAR(series[static_cast<size_t>(k)], 3.0 * (0.01 * k + 0.013), 1e-12) << k;
  for (int k = 1; k < 20; k += 2) EXPECT_TRUE(std::isnan(series[static_cast<size_t>(k)])) << k;
  std::vector<double> empty(20, NAN);
  move_series(time, 0.013, &empty);
  EXPECT_TRUE(std::isnan(empty[3]));
}

// Servos filter their velocities.
TEST(VelocityLog, AVelocityBehindItsPositionIsLate) {
  const VelocityReading log =
      read_elbow("velocity_late", {{EffectId::kSensorDelay, at_sensor(kElbow, Reading::kVelocity), {kDelay}}});
  EXPECT_NEAR(log.late, kDelay, 5e-4);  // a tenth of the sampling time
  EXPECT_FALSE(log.is_scaled());
}

// No filter looks ahead.
TEST(VelocityLog, AVelocityAheadOfItsPositionShowsALatePosition) {
  const VelocityReading log =
      read_elbow("position_late", {{EffectId::kSensorDelay, at_sensor(kElbow, Reading::kPosition), {kDelay}}});
  ASSERT_TRUE(log.is_position_late());
  EXPECT_NEAR(-log.late, kDelay, 5e-4);
}

// A servo's filter takes a tenth away from a motion at 5 Hz, and nothing from a slow one.
TEST(VelocityLog, AFilterThatDampsFastMotionIsNoScale) {
  constexpr double kTime = 0.012;  // [s] of a first-order filter
  Experiment e = make_simulated_experiment("velocity_filter", kArm, {"shoulder", "elbow"}, {});
  for (Recording& r : e.recordings) {
    double fast = 0.0, filtered = 0.0;
    for (size_t k = 0; k < r.size(); ++k) {
      JointColumns& elbow = r.joints[kElbow];
      fast = 2.0 * M_PI * 5.0 * r.time[k];
      elbow.signal[0][k] += 0.02 * std::sin(fast);
      const double rate = elbow.signal[1][k] + 0.02 * 2.0 * M_PI * 5.0 * std::cos(fast);
      filtered += (k == 0 ? 1.0 : 0.005 / (kTime + 0.005)) * (rate - filtered);
      elbow.signal[1][k] = filtered;
    }
  }
  const VelocityReading log = find_velocity_readings(e)[kElbow];
  EXPECT_FALSE(log.is_scaled());
  EXPECT_NEAR(log.late, kTime,
              0.003);  // half a sample of the filter's own rule, and what it bends beyond the second term
}

// A servo tells its velocity as the way of the last 0.1 s. It starts and turns within a second.
TEST(VelocityLog, AMeanOverATimeIsLateByHalfOfIt) {
  constexpr double kMean = 0.1;  // [s]
  Experiment e = make_simulated_experiment("velocity_mean", kArm, {"shoulder", "elbow"}, {});
  e.recordings.resize(1);
  Recording& r = e.recordings[0];
  r.time.resize(300);  // 1.5 s
  for (JointColumns& c : r.joints) {
    for (std::vector<double>& signal : c.signal) signal.resize(std::min(signal.size(), r.size()));
  }
  JointColumns& elbow = r.joints[kElbow];
  const auto calc_position = [](double time) {
    return 0.3 * std::sin(2.0 * M_PI * time) + 0.06 * std::sin(2.0 * M_PI * 4.0 * time + 0.5);
  };
  for (size_t k = 0; k < r.size(); ++k) {
    elbow.signal[0][k] = calc_position(r.time[k]);
    elbow.signal[1][k] = (calc_position(r.time[k]) - calc_position(r.time[k] - kMean)) / kMean;
  }
  const VelocityReading log = find_velocity_readings(e)[kElbow];
  EXPECT_NEAR(log.late, 0.5 * kMean, 5e-4);  // a tenth of the sampling time
  EXPECT_LT(std::abs(log.late - 0.5 * kMean), 2.0 * log.late_std);
}

// The elbow swings at 2 Hz for 1.5 s, and its drive logs `scale` times its velocity in whole degrees per second, `late`
// [s].
VelocityReading read_one_frequency(const std::string& name, double scale, double late) {
  Experiment e = make_simulated_experiment(name, kArm, {"shoulder", "elbow"}, {});
  constexpr double kTurn = 2.0 * M_PI * 2.0, kDegree = M_PI / 180.0;
  e.recordings.resize(1);
  Recording& r = e.recordings[0];
  r.time.resize(300);
  for (JointColumns& c : r.joints) {
    for (std::vector<double>& signal : c.signal) signal.resize(std::min(signal.size(), r.size()));
  }
  JointColumns& elbow = r.joints[kElbow];
  for (size_t k = 0; k < r.size(); ++k) {
    elbow.signal[0][k] = 0.5 * std::sin(kTurn * r.time[k]);
    elbow.signal[1][k] = kDegree * std::round(scale / kDegree * 0.5 * kTurn * std::cos(kTurn * (r.time[k] - late)));
  }
  return find_velocity_readings(e)[kElbow];
}

// A filter's damping is a scale at one frequency.
TEST(VelocityLog, OneFrequencyShowsNoScaleThatADampingCouldBe) {
  EXPECT_FALSE(read_one_frequency("velocity_one_frequency", 1.0, 0.006).is_scaled());
  const VelocityReading scaled = read_one_frequency("velocity_one_frequency_scaled", 1.2, 0.006);
  ASSERT_TRUE(scaled.is_scaled());
  EXPECT_NEAR(scaled.scale, 1.2, 0.02);
}

// No bus is late by 0.2 s. The rate of the position serves as the velocity then.
TEST(VelocityLog, ASlowFilterOfAVelocityIsReadWithItsTimeConstantAndLeftOut) {
  constexpr double kTime = 0.2;  // [s] of a first-order filter
  Experiment e = make_simulated_experiment("velocity_slow_filter", kArm, {"shoulder", "elbow"}, {});
  for (Recording& r : e.recordings) {
    std::vector<double>& rate = r.joints[kElbow].signal[1];
    for (size_t k = 1; k < r.size(); ++k)
      rate[k] = rate[k - 1] + (1.0 - std::exp(-0.005 / kTime)) * (rate[k] - rate[k - 1]);
  }
  const std::vector<VelocityReading> readings = find_velocity_readings(e);
  EXPECT_NEAR(readings[kElbow].late, kTime, 0.005);  // a sample: the filter's own rule holds a value for as long
  EXPECT_LT(std::abs(readings[kElbow].late - kTime), 2.0 * readings[kElbow].late_std);
  EXPECT_EQ(readings[kShoulder].late, 0.0);
  const Experiment corrected = correct_joint_logs(e, readings);
  EXPECT_FALSE(corrected.recordings[0].joints[kElbow].has(Quantity::kVelocity));
  EXPECT_TRUE(corrected.recordings[0].joints[kShoulder].has(Quantity::kVelocity));
}

// Losses and rotors act on both alike.
TEST(VelocityLog, PhysicsOfTheJointIsNoFaultOfItsLog) {
  const VelocityReading log =
      read_elbow("velocity_right", {{EffectId::kCoulomb, kElbow, {0.8}}, {EffectId::kRotorInertia, kElbow, {0.02}}});
  EXPECT_FALSE(log.is_faulty());
}

TEST(VelocityLog, CorrectedLogsAgreeWithEachOther) {
  const Experiment e =
      make_simulated_experiment("velocity_corrected", kArm, {"shoulder", "elbow"},
                                {{EffectId::kSensorDelay, at_sensor(kElbow, Reading::kPosition), {kDelay}},
                                 {EffectId::kSensorScale, at_sensor(kElbow, Reading::kVelocity), {kScale}}});
  const Experiment corrected = correct_joint_logs(e, find_velocity_readings(e));
  const VelocityReading left = find_velocity_readings(corrected)[kElbow];
  EXPECT_FALSE(left.is_scaled());
  EXPECT_EQ(left.late, 0.0);
  EXPECT_EQ(corrected.recordings[0].joints[kShoulder].signal[0], e.recordings[0].joints[kShoulder].signal[0]);
}

}  // namespace
}  // namespace hrp::diagnosis
