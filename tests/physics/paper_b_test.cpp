// SPDX-License-Identifier: BSD-3-Clause
// Mikami et al. 2014 with our own robot: what sensors with noise and bias tell about the rubber in its feet.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include <unistd.h>

#include "diagnosis/identification/bush_fit.h"
#include "diagnosis/identification/motions.h"

namespace hrp::identification {
namespace {

const char* const kScenario = HRP_SOURCE_DIR "/models/scenarios/paper_b/foot.yaml";

Scenario without_errors(Scenario scenario) {
  for (ImuSpec& imu : scenario.sensors.imus) imu.gyro = imu.accelerometer = SensorErrors{};
  for (WrenchSpec& wrench : scenario.sensors.wrenches) wrench.force = wrench.torque = SensorErrors{};
  scenario.sensors.encoders = EncoderSpec{};
  return scenario;
}

class PaperB : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = (std::filesystem::temp_directory_path() / ("paper_b_" + std::to_string(getpid()))).string();
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Clean sensor data of the hanging robot and of some of the motions, shortened.
  void record(double hardening_angle, const std::vector<size_t>& which, double scale) {
    base_ = load_scenario(kScenario);
    const auto run = [&](const std::string& path) {
      Scenario scenario = without_errors(load_scenario(path));
      for (auto& [foot, bush] : scenario.foot_bush) bush.hardening_angle = hardening_angle;
      return run_in_process(scenario);
    };
    hanging_ = run(write_hanging(base_, folder_));
    const std::vector<MotionPlan> plans = make_plans(scale);
    for (size_t i : which) motions_.push_back(run(write_motion(plans[i], base_, folder_)));
  }

  struct Observed {
    std::vector<SensorZero> zeros;
    std::vector<MotionTrack> tracks;
    MotionTrack resting;
  };
  Observed observe(const BushObserver& observer, unsigned long long seed) const {
    Observed observed;
    const RobotLog hanging = add_noise(hanging_, base_, 1000 * seed);
    observed.zeros = observer.calc_zeros(hanging);
    observed.resting = observer.observe(hanging, observed.zeros);
    for (size_t i = 0; i < motions_.size(); ++i) {
      observed.tracks.push_back(observer.observe(add_noise(motions_[i], base_, 1000 * seed + i + 1), observed.zeros));
    }
    return observed;
  }
  BushFit fit(const BushObserver& observer, const Observed& observed, BushLaw law) const {
    FitOptions options;
    options.law = law;
    options.noise = calc_angle_noise(observed.resting);
    return fit_bush(observed.tracks, observed.zeros, observer.bush_centres(), options);
  }

  std::string folder_;
  Scenario base_;
  RobotLog hanging_;
  std::vector<RobotLog> motions_;
};

TEST_F(PaperB, FindsStiffnessDampingAndOffset) {
  record(0.0, {0, 1, 4, 5, 7}, 0.75);
  const BushObserver observer(base_);
  constexpr int kSeeds = 100;
  int inside[3] = {0, 0, 0};
  double worst[3] = {0, 0, 0}, relative[3] = {0, 0, 0}, mean[3][4] = {};
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const BushFit found = fit(observer, observe(observer, static_cast<unsigned>(seed)), BushLaw::kLinear);
    for (size_t f = 0; f < 2; ++f) {
      const FootBushSpec& bush = base_.foot_bush.at(base_.feet[f]);
      for (size_t a = 0; a < 2; ++a) {
        const double truth[3] = {a ? bush.k_pitch : bush.k_roll, a ? bush.c_pitch : bush.c_roll, a ? bush.offset_pitch : bush.offset_roll};
        const BushParameters& p = found.feet[f][a];
        const Estimate* estimates[3] = {&p.K, &p.C, &p.O};
        for (int i = 0; i < 3; ++i) {
          const double error = estimates[i]->value - truth[i];
          inside[i] += std::abs(error) < 1.96 * estimates[i]->std;
          mean[i][2 * f + a] += error / truth[i] / kSeeds;
          if (i == 2 && std::abs(truth[i]) < 1.0) continue;  // the roll offsets: see docs/identification.md
          worst[i] = std::max(worst[i], std::abs(error / truth[i]));
          relative[i] = std::max(relative[i], estimates[i]->relative_std());
        }
      }
    }
  }
  const char* const names[3] = {"K", "C", "O"};
  for (int i = 0; i < 3; ++i) {
    std::printf("%s: truth in the 95 %% interval in %.1f of 100, worst error %.2f %%, largest relative std %.2f %%, mean errors %.3f %.3f %.3f %.3f %%\n", names[i],
                inside[i] / (0.04 * kSeeds), 100 * worst[i], 100 * relative[i], 100 * mean[i][0], 100 * mean[i][1], 100 * mean[i][2], 100 * mean[i][3]);
  }
  // Systematic errors remain that the standard deviations do not know of (docs/identification.md has the numbers), so
  // the intervals are not yet claimed to hold the truth; what is claimed is how near the values are.
  EXPECT_LT(worst[0], 0.02);
  EXPECT_LT(worst[1], 0.03);  // the goal is 0.02; from five short motions damping about pitch is 1.6 % too large
  EXPECT_LT(worst[2], 0.02);
  EXPECT_LT(relative[0], 0.003);  // [M14] table 1: 0.2 to 0.3 %
  EXPECT_LT(relative[1], 0.042);  // [M14] table 1: 1.6 to 4.2 %
}

TEST_F(PaperB, ChoosesTheLinearLawForALinearBush) {
  record(0.0, {0, 1, 5}, 0.6);
  const BushObserver observer(base_);
  const Observed observed = observe(observer, 3);
  const LawChoice choice = choose_law(observed.tracks, observed.zeros, observer.bush_centres());
  EXPECT_EQ(choice.law, BushLaw::kLinear) << choice.linear_error << " against " << choice.hardening_error;
}

TEST_F(PaperB, SeesThatABushHardens) {
  record(0.08, {0, 1, 5}, 0.6);
  const BushObserver observer(base_);
  const Observed observed = observe(observer, 3);
  const LawChoice choice = choose_law(observed.tracks, observed.zeros, observer.bush_centres());
  EXPECT_EQ(choice.law, BushLaw::kHardening) << choice.linear_error << " against " << choice.hardening_error;
  const BushFit found = fit(observer, observed, choice.law);
  for (size_t f = 0; f < 2; ++f) {
    const FootBushSpec& bush = base_.foot_bush.at(base_.feet[f]);
    EXPECT_NEAR(found.feet[f][1].K.value / bush.k_pitch, 1.0, 0.02);
    EXPECT_NEAR(std::sqrt(found.feet[f][1].K.value / found.feet[f][1].cubic.value) / 0.08, 1.0, 0.05);
  }
}

}  // namespace
}  // namespace hrp::identification
