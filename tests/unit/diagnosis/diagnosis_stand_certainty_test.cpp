// SPDX-License-Identifier: BSD-3-Clause
// Standing robots: what the search is sure of, and steps of its fits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "diagnosis/standing/channels.h"
#include "diagnosis/standing/layout.h"
#include "diagnosis/standing/search.h"

namespace hrp::diagnosis::standing {
namespace {

// Tables of chi-square for 5 %, two and three degrees of freedom.
TEST(StandingCertainty, OfAVectorAsksForMoreThanOfOneNumber) {
  EXPECT_NEAR(find_length(1.95996, 1), 1.960, 1e-3);
  EXPECT_NEAR(find_length(1.95996, 2), std::sqrt(5.991), 1e-3);
  EXPECT_NEAR(find_length(1.95996, 3), std::sqrt(7.815), 1e-3);
}

// An offset forward and one upward look nearly alike: neither is sure, a tenth of their difference is.
TEST(StandingCertainty, OfAVectorDoesNotDependOnItsAxes) {
  Eigen::Matrix3d C;
  C << 1, 0.995, 0, 0.995, 1, 0, 0, 0, 1;
  const Vector3d offset(0.7, -0.7, 0.1);
  EXPECT_GT(calc_deviations(offset, C), 9) << "0.7 sqrt(2) / sqrt(0.005) = 14 along the difference, at most 0.7 alone";
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.8, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  EXPECT_NEAR(calc_deviations(R * offset, R * C * R.transpose()), calc_deviations(offset, C), 1e-9);
}

// A signal of size 1 with noise of size 1 in it, twice: 2 is what makes the residual small.
TEST(StandingFit, StepsBetweenTwoHalvesAreNotMadeSmallByNoise) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Evaluation base(1);
  std::vector<Derivative> even{{{}}}, odd{{{}}};
  for (int k = 0; k < 20000; ++k) {
    const double signal = normal(random);
    base[0].residuals.push_back(-2 * signal);
    even[0][0].push_back(signal + normal(random));
    odd[0][0].push_back(signal + normal(random));
  }
  const FitSelection selection{{0}, {1.0}};
  const SharedColumns nothing = share_columns(selection, {}, base);
  const Hypothesis h{{EffectId::kViscous, at_joint(0), {0}}};
  const ColumnSide x{nothing, even}, y{nothing, odd};
  EXPECT_NEAR(solve_with({}, selection, h, x, x)(0), 1.0, 0.05) << "half of the column's square is noise";
  EXPECT_NEAR(solve_with({}, selection, h, x, y)(0), 2.0, 0.1) << "five deviations of 2 sqrt(2 / 20000)";
}

// A load hangs on the robot, and no log has another unit for a mass.
TEST(StandingFit, ALoadMetresAwayAndALinkOfAThirdOfItsMassAreNotPossible) {
  StandProblem p;
  p.tree.links.resize(1);
  const Place link{PlaceKind::kLink, 0, Reading::kAll};
  EXPECT_TRUE(is_sensible(p, {EffectId::kPayload, link, {2, 0.4, 0, 0.6}}));
  EXPECT_FALSE(is_sensible(p, {EffectId::kPayload, link, {0.05, 0, 0, 0.35}})) << "7 m away";
  EXPECT_TRUE(is_sensible(p, {EffectId::kMassError, link, {0.5}}));
  EXPECT_FALSE(is_sensible(p, {EffectId::kMassError, link, {0.35}}));
}

// The damping of a small robot's sole is within its noise: what is sure of the sole is not given up for that.
TEST(StandingFit, ADampingBelowNothingDoesNotCostTheSole) {
  StandProblem p;
  p.feet.resize(1);
  Hypothesis h{make_soft_soles(p)};
  Eigen::VectorXd step = Eigen::VectorXd::Zero(static_cast<long>(kFootParameters));
  step.head<4>() << 0.04, -0.015, 0.03, 0.01;
  add_step(step, 0, &h);
  EXPECT_TRUE(are_sensible(p, h));
  EXPECT_EQ(h[0].p[1], 0);
  EXPECT_EQ(h[0].p[3], 0.01);
}

// How high a hip's centre of mass is hardly shows in a robot that stands.
TEST(StandingEffects, ACentreOfMassIsExpectedWithinItsLink) {
  StandProblem p;
  p.tree.links.resize(1);
  p.tree.links[0].inertia.mass = 4;
  EXPECT_NEAR(find_prior(p, {EffectId::kComError, at_link(0), {0, 0, 0}}, 2), 0.2, 1e-9)
      << "a cube of 4 kg at 500 kg/m^3";
}

// A trunk of 100 kg leans to both sides over one foot, on a hip that gives, or on ground that does, as much as ground
// may: 1.5e-5 rad/(N m). Or the hip lies loose between teeth that no torque reaches, and wanders by `play` [rad].
class Leaner {
 public:
  enum class Gives { kHip, kGround, kPlay };
  explicit Leaner(Gives gives, double play = 0) : gives_(gives), play_(play) {
    std::mt19937 random(29);
    p_.even = make(&random);
    p_.odd = make(&random);
    p_.all = p_.wide_even = p_.even;
    p_.wide_odd = p_.odd;
    for (size_t r = 0; r < p_.all.recordings.size(); ++r) {
      StandRecording &all = p_.all.recordings[r], &odd = p_.odd.recordings[r];
      for (size_t k = 0; k < kSamples; ++k) {
        const auto add = [k](SmoothSeries* a, const SmoothSeries& b) {
          a->value[k] = 0.5 * (a->value[k] + b.value[k]);
        };
        for (size_t i = 0; i < 6; ++i) add(&all.wrench[i], odd.wrench[i]);
        add(&all.effort[0], odd.effort[0]);
      }
    }
  }
  StandOutcome search() const { return search_standing(p_, 1, {}); }

 private:
  static constexpr size_t kSamples = 400;
  static constexpr double kStep = 0.03, kGive = 1.5e-5, kHeight = 0.4;  // [s], [rad/(N m)], [m]
  static constexpr double kTilt = 2e-5;                                 // [rad] noise of a tilt

  static SmoothSeries zeros() {
    const std::vector<double> none(kSamples, 0.0);
    return {none, none, none};
  }

  StandProblem make(std::mt19937* random) const {
    StandProblem p;
    p.experiment = &experiment_;
    p.imu = "imu";
    p.imu_link = 0;
    p.tree.links.resize(2);
    LinkSpec &trunk = p.tree.links[0], &foot = p.tree.links[1];
    trunk.name = "trunk";
    trunk.inertia.mass = 100;
    trunk.inertia.p_LLcm_L = {0, 0, 0.3};
    trunk.inertia.I_LLcm_L = 4 * Matrix3d::Identity();
    foot.name = "foot";
    foot.parent = 0;
    foot.joint.name = "hip";
    foot.joint.axis_F = Vector3d::UnitX();
    foot.inertia.mass = 1e-9;
    foot.inertia.I_LLcm_L = 1e-12 * Matrix3d::Identity();
    p.feet.push_back({"foot", "foot_ft", 1});
    p.feet[0].bush = {0, 0, -kHeight};
    p.effort = {true};
    p.command = p.velocity = {false};
    p.slack = {gives_ == Gives::kPlay ? 1e9 : 1};
    p.noise.assign(list_channels(p).size(), kTilt);  // which places loose teeth
    for (size_t r = 0; r < 3; ++r) p.recordings.push_back(lean(r));
    for (size_t r = 0; r < 3; ++r) load(r, &p, random);
    return p;
  }

  StandRecording lean(size_t recording) const {
    StandRecording r;
    r.train = recording < 2;
    r.position = {zeros()};
    r.effort = {zeros()};
    r.command = r.velocity = {SmoothSeries{}};
    r.wrench.assign(6, zeros());
    for (int i = 0; i < 3; ++i) r.gyro[i] = r.accelerometer[i] = zeros();
    for (SmoothSeries& part : r.attitude) part = zeros();
    const double w = 0.9 + 0.2 * static_cast<double>(recording);
    for (size_t k = 0; k < kSamples; ++k) {
      const double t = kStep * static_cast<double>(k), angle = 0.1 * std::sin(w * t), rate = 0.1 * w * std::cos(w * t);
      const double push = 1.5 * std::sin(2.7 * w * t);  // [m/s^2] sideways
      r.time.push_back(t);
      r.samples.push_back(static_cast<int>(k));
      r.attitude[0].value[k] = std::cos(angle / 2);
      r.attitude[1].value[k] = std::sin(angle / 2);
      r.gyro[0].value[k] = rate;
      r.gyro[0].rate[k] = -w * w * angle;
      r.accelerometer[1].value[k] = std::cos(angle) * push + std::sin(angle) * 9.81;
      r.accelerometer[2].value[k] = std::cos(angle) * 9.81 - std::sin(angle) * push;
      r.position[0].value[k] = -angle;
      r.position[0].rate[k] = -rate;
      r.position[0].second[k] = w * w * angle;
    }
    r.grid = r.samples;
    return r;
  }

  // Wrench and effort that the motion asks for, noise, and what gives under them.
  void load(size_t recording, StandProblem* p, std::mt19937* random) const {
    std::normal_distribution<double> normal;
    StandRecording& r = p->recordings[recording];
    const size_t channels = list_channels(*p).size(), balance = find_places(*p) + count_places(*p);
    const std::vector<double> rows = calc_channels(*p, {}, recording);
    for (size_t k = 0; k < kSamples; ++k) {
      for (size_t i = 0; i < 6; ++i) r.wrench[(i + 3) % 6].value[k] = rows[k * channels + balance + i];
    }
    const std::vector<double> loaded = calc_channels(*p, {}, recording);
    for (size_t k = 0; k < kSamples; ++k) {
      const double torque = -loaded[k * channels + find_drive(*p, 0)];
      const double moment = r.wrench[3].value[k] - kHeight * r.wrench[1].value[k];
      r.position[0].value[k] += find_bend(torque, moment, r.time[k]);
      r.effort[0].value[k] = torque + 0.3 * normal(*random);
      for (size_t i = 0; i < 6; ++i) r.wrench[i].value[k] += (i < 3 ? 1.0 : 0.3) * normal(*random);  // [N], [N m]
    }
  }

  double find_bend(double torque, double moment, double time) const {
    if (gives_ == Gives::kPlay) return play_ * std::sin(7.3 * time + 0.2 * time * time);
    return gives_ == Gives::kHip ? kGive * torque : -kGive * moment;
  }

  Gives gives_;
  double play_;
  Experiment experiment_;
  StandProblems p_;
};

bool is_named(const StandOutcome& o, EffectId id) {
  const Hypothesis& h = o.chosen.hypothesis;
  return std::any_of(h.begin(), h.end(), [id](const Effect& e) { return e.id == id; });
}

TEST(StandingSearch, TellsAHipThatGivesLessThanGroundMayFromTheGround) {
  const StandOutcome hip = Leaner(Leaner::Gives::kHip).search();
  EXPECT_TRUE(hip.explained);
  EXPECT_TRUE(is_named(hip, EffectId::kElasticity));
  EXPECT_FALSE(is_named(Leaner(Leaner::Gives::kGround).search(), EffectId::kElasticity));
}

// A link that no torque ever held follows what the feet say at every sample, noise and all: 1.4 deviations of their
// noise are not enough to call it loose, 14 are.
TEST(StandingSearch, ALinkThatNothingEverHeldIsLooseOnlyIfTheFeetSayIt) {
  EXPECT_FALSE(is_named(Leaner(Leaner::Gives::kPlay, 4e-5).search(), EffectId::kBacklash));
  EXPECT_TRUE(is_named(Leaner(Leaner::Gives::kPlay, 4e-4).search(), EffectId::kBacklash));
}

}  // namespace
}  // namespace hrp::diagnosis::standing
