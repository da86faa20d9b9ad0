// SPDX-License-Identifier: BSD-3-Clause
// Late commands are read from the servo's law alone, whatever the log's stamps, digits and scale are.
#include "diagnosis/measurement/servo_law.h"

#include <random>

#include "diagnosis/measurement/servo_rates.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

constexpr double kKp = 200.0, kKd = 10.0;         // of every servo of the experiment
constexpr double kDelay = 0.019, kScale = 0.957;  // [s] of the commands, of the logged effort

double calc_command(double t) { return 0.5 * std::sin(3.0 * t) + 0.2 * std::sin(7.0 * t); }
double calc_command_rate(double t) { return 1.5 * std::cos(3.0 * t) + 1.4 * std::cos(7.0 * t); }

// Two recordings at 1 kHz of an elbow that lags; its servo gets commands late. Stamps are off by `jitter` [s], recorded
// rates by `noise` [rad/s]. The log ripples by `ripple` [N m], once in 0.6 rad.
Experiment make_late(const std::string& name, double jitter, double noise, double delay = kDelay, double ripple = 0.0,
                     double scale = kScale) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("hrp_servo_law_" + name);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << kArm;
  std::ofstream(folder / "experiment.yaml")
      << "robot: robot.urdf\nbase: fixed\nservo: {default: {kp: 200, kd: 10, effort_limit: 80}}\n"
         "recordings:\n- {file: train.csv, role: train}\n- {file: validate.csv, role: validate}\n";
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const char* file : {"train.csv", "validate.csv"}) {
    std::ofstream csv(folder / file);
    csv.precision(10);
    csv << "time,/joint_commands/elbow/position,/joint_commands/elbow/velocity,/joint_states/elbow/position,/"
           "joint_states/elbow/velocity,"
           "/joint_states/elbow/effort,/joint_commands/shoulder/position,/joint_states/shoulder/position\n";
    const double from = file[0] == 't' ? 0.0 : 20.0;
    for (int k = 0; k < 6000; ++k) {
      const double t = 1e-3 * k, at = from + t, q = 0.9 * calc_command(at - 0.03),
                   v = 0.9 * calc_command_rate(at - 0.03);
      const double effort = ripple * std::sin(2.0 * M_PI * q / 0.6) +
                            scale * (kKp * (calc_command(at - delay) - q) + kKd * (calc_command_rate(at - delay) - v));
      csv << t + jitter * normal(random) << "," << calc_command(at) << "," << calc_command_rate(at) << "," << q << ","
          << v + noise * normal(random) << "," << effort + 0.05 * normal(random) << ",0,0\n";
    }
  }
  return load_experiment((folder / "experiment.yaml").string());
}

void expect_delay_and_scale(const Experiment& e) {
  const std::vector<ServoDelay> delays = find_servo_delays(e);
  ASSERT_EQ(delays.size(), 1u);
  EXPECT_EQ(e.robot.tree.joint(delays[0].joint).name, "elbow");
  EXPECT_NEAR(delays[0].delay, kDelay, 2e-4);  // a fifth of the sampling time
  const ServoReading reading = find_servo_readings(e, delays)[static_cast<size_t>(delays[0].joint)];
  ASSERT_TRUE(reading.follows);
  EXPECT_NEAR(reading.scale, kScale, 0.005);  // the design's bar for a sensor's scale is 5 %
}

// The same elbow held by its servo while the arm sways: it gives by three steps of its encoder.
Experiment make_held() {
  constexpr double kStep = 2.0 * M_PI / 4096.0;  // [rad]
  Experiment e = make_late("held", 0.0, 0.0, 0.0, 0.0, 1.0);
  const size_t elbow = static_cast<size_t>(e.robot.tree.find_joint("elbow"));
  for (Recording& r : e.recordings) {
    JointColumns& c = r.joints[elbow];
    for (size_t k = 0; k < r.size(); ++k) {
      const double q = 0.0012 + 0.0016 * std::sin(4.0 * r.time[k]), v = 0.0064 * std::cos(4.0 * r.time[k]);
      c.command[k] = 0.0;
      c.command_rate[k] = 0.0;
      c.signal[0][k] = kStep * std::round(q / kStep);
      c.signal[1][k] = v;
      c.signal[2][k] = -kKp * q - kKd * v;
    }
  }
  return e;
}

TEST(ServoLaw, TheRoundingOfAHeldJointsEncoderIsNoFaultOfItsEffort) {
  const Experiment e = make_held();
  const ServoReading reading = find_servo_readings(e, {})[static_cast<size_t>(e.robot.tree.find_joint("elbow"))];
  EXPECT_FALSE(reading.is_scaled()) << reading.scale;
  EXPECT_FALSE(reading.is_biased()) << reading.bias;
}

// The elbow's bias [N m] if these are added to its effort in three recordings.
double find_bias(const std::string& name, const std::vector<double>& added) {
  Experiment e = make_late(name, 0.0, 0.0, 0.0, 0.0, 1.0);
  e.recordings.push_back(e.recordings[1]);
  const size_t elbow = static_cast<size_t>(e.robot.tree.find_joint("elbow"));
  for (size_t i = 0; i < e.recordings.size(); ++i) {
    e.recordings[i].spec.train = true;
    for (double& effort : e.recordings[i].joints[elbow].signal[2]) effort += added[i];
  }
  return find_servo_readings(e, {})[elbow].bias;
}

TEST(ServoLaw, TheZeroOfAnEffortIsTheSameInEveryRecording) {
  EXPECT_NEAR(find_bias("zero_of_all", {1.0, 1.0, 1.0}), 1.0,
              0.02);  // the log's noise over its 18 000 samples, and the delay's scan
  EXPECT_EQ(find_bias("zero_of_two", {1.0, 1.0, 0.25}), 0.0);
}

// Weight gives the law a mean of 40 N m, and a scale of 0.992 takes 0.32 N m of it.
TEST(ServoLaw, AScaleTooSmallToBeNamedIsNoBiasBesideWeight) {
  constexpr double kWeight = 40.0;
  Experiment e = make_late("weight", 0.0, 0.0, 0.0, 0.0, 1.0);
  const size_t elbow = static_cast<size_t>(e.robot.tree.find_joint("elbow"));
  for (Recording& r : e.recordings) {
    JointColumns& c = r.joints[elbow];
    for (size_t k = 0; k < r.size(); ++k) {
      c.command[k] += kWeight / kKp;
      c.signal[2][k] = 0.992 * (c.signal[2][k] + kWeight);
    }
  }
  const ServoReading reading = find_servo_readings(e, {})[elbow];
  ASSERT_TRUE(reading.follows);
  EXPECT_EQ(reading.bias, 0.0) << reading.bias_std << " " << reading.scale;
}

TEST(ServoLaw, ALogOfAnotherScaleDoesNotMoveTheDelay) { expect_delay_and_scale(make_late("scale", 0.0, 0.0)); }

// The difference of two commands over the time between two such stamps is off by a tenth of the rate.
TEST(ServoLaw, StampsThatJitterDoNotHideADelay) { expect_delay_and_scale(make_late("jitter", 1e-4, 0.0)); }

// A law from noisy rates is noisy, too: least squares make its line flatter by 5 %, which an instrument does not.
TEST(ServoLaw, NoiseOfTheRateDoesNotFlattenTheScale) {
  const Experiment e = make_late("noise", 0.0, 0.3, 0.0);
  const int elbow = e.robot.tree.find_joint("elbow");
  const ServoReading reading = find_servo_readings(e, {})[static_cast<size_t>(elbow)];
  ASSERT_TRUE(reading.follows);
  EXPECT_LT(reading.scale_std, 0.005);
  EXPECT_NEAR(reading.scale, kScale, 3.0 * reading.scale_std);
}

// The line through all samples is bent by 1 % here, and told to 1.3 %; between two motions past one place the ripple is
// the same.
TEST(ServoLaw, ARippleOfTheLogOverPositionHidesNoScaleAndMakesNone) {
  constexpr double kRipple = 2.0;
  const Experiment scaled = make_late("ripple", 0.0, 0.0, 0.0, kRipple),
                   right = make_late("ripple_right", 0.0, 0.0, 0.0, kRipple, 1.0);
  const size_t elbow = static_cast<size_t>(scaled.robot.tree.find_joint("elbow"));
  const ServoReading reading = find_servo_readings(scaled, {})[elbow];
  ASSERT_TRUE(reading.is_scaled());
  EXPECT_LT(reading.scale_std, 0.005);
  EXPECT_NEAR(reading.scale, kScale, 3.0 * reading.scale_std);
  EXPECT_FALSE(find_servo_readings(right, {})[elbow].is_scaled());
}

// Every fifth sample of a log at 1 kHz. Between two of them nobody knows the command.
void thin_out(Experiment* e) {
  const auto thin = [](std::vector<double>* values) {
    for (size_t k = 0; 5 * k < values->size(); ++k) (*values)[k] = (*values)[5 * k];
    values->resize((values->size() + 4) / 5);
  };
  for (Recording& r : e->recordings) {
    thin(&r.time);
    for (JointColumns& joint : r.joints) {
      for (std::vector<double>& column : joint.signal) thin(&column);
      thin(&joint.command);
      thin(&joint.command_rate);
    }
  }
  e->sample_time *= 5.0;
}

// The elbow follows a fast motion at 200 Hz. The log of its effort comes `late_log` [s], and its servo damps with a
// rate that comes `late_rate` [s].
Experiment make_filtered(const std::string& name, double late_log, double late_rate) {
  constexpr double kFast = 30.0, kLag = 0.03;  // [rad/s], [s] of the joint behind its command
  Experiment e = make_late(name, 0.0, 0.0, 0.0, 0.0, 1.0);
  const size_t elbow = static_cast<size_t>(e.robot.tree.find_joint("elbow"));
  thin_out(&e);
  const auto q = [](double t) { return 0.04 * std::sin(kFast * (t - kLag)); };
  const auto v = [](double t) { return 0.04 * kFast * std::cos(kFast * (t - kLag)); };
  for (Recording& r : e.recordings) {
    JointColumns& c = r.joints[elbow];
    for (size_t k = 0; k < r.size(); ++k) {
      const double t = r.time[k], at = t - late_log;
      c.command[k] = 0.05 * std::sin(kFast * t);
      c.command_rate[k] = 0.05 * kFast * std::cos(kFast * t);
      c.signal[0][k] = q(t);
      c.signal[1][k] = v(t);
      c.signal[2][k] =
          kKp * (0.05 * std::sin(kFast * at) - q(at)) + kKd * (0.05 * kFast * std::cos(kFast * at) - v(at - late_rate));
    }
  }
  return e;
}

// With the law's autocorrelation R(t), an instrument three samples earlier gives R(10 ms) / R(15 ms), which is 1.06
// here.
TEST(ServoLaw, ALateLogOfTheEffortIsNoScale) {
  const Experiment e = make_filtered("late_log", 0.005, 0.0);
  const ServoReading reading = find_servo_readings(e, {})[static_cast<size_t>(e.robot.tree.find_joint("elbow"))];
  ASSERT_TRUE(reading.follows);
  EXPECT_FALSE(reading.is_scaled()) << reading.scale;
}

// Damping that comes late pushes with the acceleration, as if the gains were higher. Firmware that logs late velocities
// may use them in its servo.
TEST(ServoLaw, DampingByALateRateIsNoScaleOfTheEffort) {
  VelocityReading late;
  late.late = 0.007;  // [s]
  const Experiment e = make_filtered("late_rate", 0.0, late.late);
  const size_t elbow = static_cast<size_t>(e.robot.tree.find_joint("elbow"));
  const ServoReading reading =
      find_servo_readings(e, {}, std::vector<VelocityReading>(static_cast<size_t>(e.num_joints()), late))[elbow];
  ASSERT_TRUE(reading.follows);
  EXPECT_FALSE(reading.is_scaled()) << reading.scale;
  EXPECT_TRUE(find_servo_readings(e, {})[elbow].is_scaled());  // nothing says that the rate may come late
}

// An elbow with dry friction [N m] whose stiff servo gets a new command every 4 ms, at 250 Hz, and logs no velocity.
Experiment make_jerked(const std::string& name, double scale) {
  constexpr double kInertia = 0.1, kFriction = 1.5, kStiff = 900.0,
                   kDamping = 20.0;  // [kg m^2, N m, N m/rad, N m s/rad]
  constexpr double kStep = 1e-4;     // [s]
  constexpr int kSteps = 40;         // of each command
  Experiment e = make_late(name, 0.0, 0.0, 0.0, 0.0, 1.0);
  const size_t elbow = static_cast<size_t>(e.robot.tree.find_joint("elbow"));
  ServoGains& gains = e.scenario.servo_default;
  gains.kp = kStiff;
  gains.kd = kDamping;
  TestNoise noise;
  for (Recording& r : e.recordings) {
    JointColumns& c = r.joints[elbow];
    r.time.clear();
    c.command.clear();
    c.command_rate.clear();
    c.signal[0].clear();
    c.signal[1].clear();
    c.signal[2].clear();
    double q = 0.0, v = 0.0;
    for (int k = 0; k < 2500; ++k) {
      const double command = calc_command(0.004 * k) - calc_command(0.0);
      for (int i = 0; i < kSteps; ++i) {
        const double effort = kStiff * (command - q) - kDamping * v;
        if (i == kSteps / 2) {
          r.time.push_back(0.004 * k + i * kStep);
          c.command.push_back(command);
          c.signal[0].push_back(q);
          c.signal[2].push_back(scale * effort + 0.1 * noise.draw());
        }
        v += kStep / kInertia * (effort - kFriction * std::tanh(v / 1e-3));
        q += kStep * v;
      }
    }
  }
  e.sample_time = 0.004;
  return e;
}

// Between two held commands the velocity ripples in step with the samples, so the mean rate is off by a hundredth of
// it: a tenth of the effort, as stiffness and damping nearly cancel.
TEST(ServoLaw, TheJerkOfHeldCommandsIsNoScaleOfTheEffort) {
  const Experiment e = make_jerked("jerked", 1.0);
  const ServoReading reading = find_servo_readings(e, {})[static_cast<size_t>(e.robot.tree.find_joint("elbow"))];
  EXPECT_FALSE(reading.is_scaled()) << reading.scale << " " << reading.scale_std;
}

// Without velocities, too, a log of another scale is told where the motion needs effort.
TEST(ServoLaw, AScaleIsToldFromPositionsAlone) {
  Experiment e = make_late("positions", 0.0, 0.0, 0.0);
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) joint.signal[1].clear();
  }
  const ServoReading reading = find_servo_readings(e, {})[static_cast<size_t>(e.robot.tree.find_joint("elbow"))];
  ASSERT_TRUE(reading.is_scaled());
  EXPECT_NEAR(reading.scale, kScale, 3.0 * reading.scale_std);
}

// The slope of effort over law follows the delay: 3 % in a tenth of a sample here.
TEST(ServoLaw, AScaleBesideADelayIsKnownNoBetterThanTheCommandsBetweenTwoSamples) {
  Experiment e = make_late("coarse", 0.0, 0.0, 0.0203, 0.0, 0.8);
  thin_out(&e);
  const std::vector<ServoDelay> delays = find_servo_delays(e);
  ASSERT_EQ(delays.size(), 1u);
  EXPECT_NEAR(delays[0].delay, 0.0203, 5e-4);  // a tenth of a sample
  const ServoReading reading = find_servo_readings(e, delays)[static_cast<size_t>(delays[0].joint)];
  ASSERT_TRUE(reading.is_scaled());
  EXPECT_NEAR(reading.scale, 0.8, 3.0 * reading.scale_std);
  EXPECT_GT(reading.scale_std, 0.01);
}

}  // namespace
}  // namespace hrp::diagnosis
