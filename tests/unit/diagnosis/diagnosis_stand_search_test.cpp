// SPDX-License-Identifier: BSD-3-Clause
// Standing robots: what the whole search names, of a trunk on one foot that stands still and swings its arms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "diagnosis/estimate/significance.h"
#include "diagnosis/standing/channels.h"
#include "diagnosis/standing/layout.h"
#include "diagnosis/standing/search.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr int kSamples = 400;
constexpr double kStep = 0.03, kNoise = 0.01;  // [s], [N m] of an effort
constexpr double kStiff = 100;                 // [N m/rad] of a servo

// What a drive lacks: of its joint's position [rad] and velocity [rad/s], of time [s] and of the recording.
using Missing = std::function<double(double, double, double, size_t)>;

struct Arm {
  double reach[3];  // [rad] by recording
  Missing missing;
};

// What else is not as the model has it: of the body, of the gyroscope, which is as noisy as `shake` [rad/s^2] says. The
// log of efforts may err by `log` [N m], and commands be recorded beside it.
struct Body {
  Hypothesis hidden;
  double nod = 0, scale = 1, shake = 0;  // [rad] to both sides; of the gyroscope's readings
  double log = 0, bias = 0;              // [N m] deviation and bias of logged efforts; commands are then recorded
  bool untold = false;                   // but not those of the first arm
  double jolt = 0;                       // [m/s^2] deviation of the accelerometer
  size_t late = 0;                       // samples by which the force sensor is late
  bool mute = false;                     // no effort is recorded
};

class Stander {
 public:
  explicit Stander(const std::vector<Arm>& arms, const Body& body = {}, unsigned seed = 17) : arms_(arms), body_(body) {
    experiment_.scenario.servo_default.kp = kStiff;
    std::mt19937 random(seed);
    p_.even = make(&random);
    p_.odd = make(&random);
    p_.all = p_.even;
    for (size_t r = 0; r < 3; ++r) {
      const StandRecording &even = p_.even.recordings[r], &odd = p_.odd.recordings[r];
      for (size_t i = 0; i < 6; ++i) p_.all.recordings[r].wrench[i] = average(even.wrench[i], odd.wrench[i]);
      p_.all.recordings[r].gyro[1].rate = average(even.gyro[1].rate, odd.gyro[1].rate);
      for (size_t i = 0; i < 3; ++i)
        p_.all.recordings[r].accelerometer[i] = average(even.accelerometer[i], odd.accelerometer[i]);
      for (size_t j = 1; j < even.effort.size(); ++j) {
        p_.all.recordings[r].effort[j] = average(even.effort[j], odd.effort[j]);
        if (body.log > 0) p_.all.recordings[r].command[j] = average(even.command[j], odd.command[j]);
      }
    }
    for (StandProblem* p : {&p_.all, &p_.even, &p_.odd}) {
      if (body.untold) drop_commands(p);
    }
    p_.wide_even = p_.even;
    p_.wide_odd = p_.odd;
    if (body.log > 0) choose_laws(&p_);
  }

  StandOutcome search() const { return search_standing(p_, 1, {}); }
  StandProblem get_problem() const { return p_.all; }

 private:
  static void drop_commands(StandProblem* p) {
    p->command[1] = false;
    for (StandRecording& r : p->recordings) r.command[1] = {};
    p->noise.assign(list_channels(*p).size(), kNoise);
  }

  static std::vector<double> average(std::vector<double> a, const std::vector<double>& b) {
    for (size_t k = 0; k < a.size(); ++k) a[k] = 0.5 * (a[k] + b[k]);
    return a;
  }

  static SmoothSeries average(const SmoothSeries& a, const SmoothSeries& b) {
    return {average(a.value, b.value), a.rate, a.second};
  }

  static SmoothSeries constant(double value) {
    return {std::vector<double>(kSamples, value), std::vector<double>(kSamples, 0.0),
            std::vector<double>(kSamples, 0.0)};
  }

  static LinkSpec make_link(const std::string& name, int parent, double mass) {
    LinkSpec link;
    link.name = name;
    link.parent = parent;
    link.joint.name = name;
    link.joint.axis_F = Vector3d::UnitY();
    link.inertia.mass = mass;
    link.inertia.I_LLcm_L = 0.08 * mass * Matrix3d::Identity();
    return link;
  }

  StandProblem make(std::mt19937* random) const {
    StandProblem p;
    p.experiment = &experiment_;
    p.imu = "imu";
    p.imu_link = 0;
    p.tree.links = {make_link("trunk", -1, 12), make_link("foot", 0, 1e-9)};
    p.effort = {false};
    p.feet.push_back({"foot", "foot_ft", 1});
    for (size_t i = 0; i < arms_.size(); ++i) {
      p.tree.links.push_back(make_link("arm_" + std::to_string(i), 0, 2));
      p.effort.push_back(!body_.mute);
      p.tree.links.back().inertia.p_LLcm_L = {0, 0, -0.3};
    }
    p.command = p.velocity = std::vector<bool>(p.effort.size(), false);
    p.slack.assign(p.effort.size(), 0.1);
    for (size_t j = 1; j < p.effort.size(); ++j) p.command[j] = body_.log > 0;
    p.noise.assign(list_channels(p).size(), kNoise);
    for (size_t r = 0; r < 3; ++r) {
      p.recordings.push_back(move(r));
      balance(r, &p, random);
    }
    return p;
  }

  // Wrenches and efforts that the motion asks for, and noise.
  void balance(size_t recording, StandProblem* p, std::mt19937* random) const {
    std::normal_distribution<double> normal;
    StandRecording& r = p->recordings[recording];
    const std::vector<double> rows = calc_channels(*p, body_.hidden, recording);
    const size_t channels = list_channels(*p).size(), first = find_places(*p) + count_places(*p);
    for (size_t k = 0; k < kSamples; ++k) {
      for (size_t i = 0; i < 6; ++i) {
        r.wrench[(i + 3) % 6].value[k] = rows[k * channels + first + i] + (i < 3 ? 0.03 : 0.3) * normal(*random);
      }
      for (size_t j = 1; j < r.effort.size() && !body_.mute; ++j) {
        const double q = r.position[j].value[k], v = r.position[j].rate[k];
        r.effort[j].value[k] = arms_[j - 1].missing(q, v, r.time[k], recording) -
                               rows[k * channels + find_drive(*p, j)] + std::sqrt(2.0) * kNoise * normal(*random);
        if (body_.log == 0) continue;
        // What the servo was given, with the noise of encoders in it, and what a sensor as wide as a leg's makes of it.
        r.command[j].value[k] = r.position[j].value[k] + r.effort[j].value[k] / kStiff;
        r.command[j].rate[k] = r.position[j].rate[k];
        r.effort[j].value[k] += body_.bias + body_.log * normal(*random);
      }
    }
    for (SmoothSeries& axis : r.wrench) {
      for (size_t k = kSamples; k-- > body_.late;) axis.value[k] = axis.value[k - body_.late];
    }
    for (double& rate : r.gyro[1].rate) rate *= body_.scale;
    for (size_t k = 0; k < kSamples && body_.shake > 0; ++k) r.gyro[1].rate[k] += body_.shake * normal(*random);
    for (double& turning : r.gyro[1].value) turning *= body_.scale;
    for (SmoothSeries& axis : r.accelerometer) {
      for (size_t k = 0; k < kSamples && body_.jolt > 0; ++k) axis.value[k] += body_.jolt * normal(*random);
    }
  }

  // The trunk nods over a foot that stands.
  void nod(StandRecording* r) const {
    for (size_t k = 0; k < r->time.size(); ++k) {
      const double w = 1.7, angle = body_.nod * std::sin(w * r->time[k]);
      const double rate = body_.nod * w * std::cos(w * r->time[k]), second = -w * w * angle;
      r->attitude[0].value[k] = std::cos(angle / 2);
      r->attitude[2].value[k] = std::sin(angle / 2);
      r->gyro[1].value[k] = rate;
      r->gyro[1].rate[k] = second;
      r->accelerometer[0].value[k] = -9.81 * std::sin(angle);
      r->accelerometer[2].value[k] = 9.81 * std::cos(angle);
      SmoothSeries& foot = r->position[0];
      foot.value[k] = -angle;
      foot.rate[k] = -rate;
      foot.second[k] = -second;
    }
  }

  StandRecording move(size_t recording) const {
    StandRecording r;
    r.train = recording < 2;
    for (int k = 0; k < kSamples; ++k) {
      r.time.push_back(kStep * k);
      r.samples.push_back(k);
    }
    r.grid = r.samples;
    for (int i = 0; i < 3; ++i) {
      r.gyro[i] = constant(0);
      r.accelerometer[i] = constant(i == 2 ? 9.81 : 0);
    }
    for (size_t i = 0; i < 4; ++i) r.attitude[i] = constant(i == 0 ? 1 : 0);
    r.wrench.assign(6, constant(0));
    r.position = {constant(0)};
    r.effort = {SmoothSeries{}};
    for (const Arm& arm : arms_) {
      SmoothSeries q = constant(0);
      for (size_t k = 0; k < q.value.size(); ++k) {
        const double w = 1.1 + 0.3 * static_cast<double>(recording), size = 0.5 * arm.reach[recording];
        for (const double rate : {w, 2.7 * w}) {
          const double angle = rate * r.time[k];
          q.value[k] += size * std::sin(angle);
          q.rate[k] += size * rate * std::cos(angle);
          q.second[k] -= size * rate * rate * std::sin(angle);
        }
      }
      r.position.push_back(q);
      r.effort.push_back(constant(0));
    }
    r.command = r.velocity = std::vector<SmoothSeries>(r.position.size(), constant(0));
    nod(&r);
    return r;
  }

  std::vector<Arm> arms_;
  Body body_;
  Experiment experiment_;
  StandProblems p_;
};

bool is_named(const StandOutcome& o, EffectId id, const Place& place) {
  const Hypothesis& h = o.chosen.hypothesis;
  return std::any_of(h.begin(), h.end(), [&](const Effect& e) { return e.id == id && e.place == place; });
}

// Pushed by somebody: neither repeats nor follows the arm.
double push(double t, size_t recording) {
  const double r = static_cast<double>(recording);
  return std::sin((1.9 + r) * t + r) + std::sin((3.1 - 0.4 * r) * t) + std::sin(0.7 * (1 + r) * t * t / 6);
}

TEST(StandingSearch, NamesFrictionBesideASpringThatLeaveNoise) {
  const auto law = [](double q, double v, double, size_t) { return 10 * (v > 0 ? 1.0 : -1.0) + 20 * q; };
  const StandOutcome o = Stander({{{0.5, 0.5, 0.5}, law}}).search();
  EXPECT_TRUE(o.explained);
  EXPECT_TRUE(is_named(o, EffectId::kCoulomb, at_joint(1)));
  EXPECT_TRUE(is_named(o, EffectId::kSpring, at_joint(1)));
}

// The same with a push of ten noise deviations: a ten thousandth of the power that was missing.
TEST(StandingSearch, SeveralEffectsInOneJointMustLeaveNoise) {
  const auto law = [](double q, double v, double t, size_t r) {
    return 10 * (v > 0 ? 1.0 : -1.0) + 20 * q + 0.08 * push(t, r);
  };
  const StandOutcome o = Stander({{{0.5, 0.5, 0.5}, law}}).search();
  EXPECT_TRUE(o.bent);
  EXPECT_FALSE(o.explained);
}

// One arm moves in training only, the other is pushed, which nothing explains.
TEST(StandingSearch, NamesWhatOnlyTrainingShowsBesideSomethingUnexplainedElsewhere) {
  const auto viscous = [](double, double v, double, size_t) { return 2 * v; };
  const auto pushed = [](double, double, double t, size_t r) { return 0.1 * push(t, r); };
  const StandOutcome o = Stander({{{0.5, 0.5, 0.0}, viscous}, {{0.3, 0.3, 0.3}, pushed}}).search();
  EXPECT_FALSE(o.explained);
  EXPECT_TRUE(is_named(o, EffectId::kViscous, at_joint(1)));
}

// A push of as much as the noise: no equation stands out, but even and odd samples both show it.
TEST(StandingSearch, SeesWhatIsBelowTheNoiseAndNamesNoCauseForIt) {
  const auto pushed = [](double, double, double t, size_t r) { return 0.01 * push(t, r); };
  const StandOutcome o = Stander({{{0.3, 0.3, 0.3}, pushed}}).search();
  EXPECT_LT(*std::max_element(o.nominal.train_rms.begin(), o.nominal.train_rms.end()), kAboveNoise);
  EXPECT_TRUE(o.mismatch);
  EXPECT_TRUE(o.chosen.hypothesis.empty());
  ASSERT_EQ(o.shared.size(), o.channels.size());
  for (size_t c = 0; c < o.channels.size(); ++c)
    EXPECT_EQ(o.shared[c] > 0, o.channels[c].kind == ChannelKind::kEffort) << c;
}

// An attitude that had to be found may err; what the robot's own sensors tell of its efforts does not depend on it.
TEST(StandingChannels, OfEffortsAndBalanceStayAsTheyAreWhereTheAttitudeErrs) {
  const auto viscous = [](double, double v, double, size_t) { return 2 * v; };
  StandProblem p = Stander({{{0.5, 0.5, 0.5}, viscous}}).get_problem();
  const std::vector<double> before = calc_channels(p, {}, 0);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.05, Vector3d(0.6, 0.8, 0)));
  const double parts[] = {turn.w(), turn.x(), turn.y(), turn.z()};
  for (size_t i = 0; i < 4; ++i)
    std::fill(p.recordings[0].attitude[i].value.begin(), p.recordings[0].attitude[i].value.end(), parts[i]);
  const std::vector<double> after = calc_channels(p, {}, 0);
  const size_t channels = list_channels(p).size(), balance = find_places(p) + count_places(p);
  const auto force = [&](const std::vector<double>& rows, size_t k) {
    return std::hypot(rows[k + balance + 3], rows[k + balance + 4], rows[k + balance + 5]);
  };
  for (size_t k = 0; k < before.size(); k += channels) {
    EXPECT_NEAR(before[k + find_drive(p, 1)], after[k + find_drive(p, 1)], 1e-9);
    EXPECT_NEAR(force(before, k), force(after, k), 1e-9);
  }
}

// Noise that a filter has carried on from each sample to the next is in both halves, but not in the next window but
// one.
TEST(StandingJudge, DoesNotTakeNoiseThatAFilterColoursForSomethingMissing) {
  const auto nothing = [](double, double, double, size_t) { return 0.0; };
  const StandProblem p = Stander({{{0.3, 0.3, 0.3}, nothing}}).get_problem();
  const Evaluation clean = evaluate(p, {});
  const size_t channels = list_channels(p).size(), effort = find_drive(p, 1);
  std::mt19937 random(23);
  std::normal_distribution<double> normal;
  const auto find = [&](double size, double turn) {
    Evaluation even = clean, odd = clean;
    for (size_t r = 0; r < clean.size(); ++r) {
      for (size_t k = 0; k < kSamples; ++k) {
        const double both = normal(random), push = size * std::sin(turn * static_cast<double>(k));
        even[r].residuals[k * channels + effort] = kNoise * (both + push + normal(random));
        odd[r].residuals[k * channels + effort] = kNoise * (both + push + normal(random));
      }
    }
    StandJudge judge(p);
    judge.update_sigma(even, {even, odd, even, odd}, {});
    return judge.find_shared(even, odd)[effort];
  };
  EXPECT_EQ(find(0, 0), 0);
  EXPECT_NEAR(find(1.5, 0.1), 1.5, 0.2) << "1.5 / sqrt(2) of the mean's noise, 1 / sqrt(2)";
  EXPECT_NEAR(find(1.5, M_PI / 4), 1.5 * std::sqrt(std::sqrt(0.5)), 0.2) << "a quarter of a turn over two samples";
}

double lacks_nothing(double, double, double, size_t) { return 0; }

// Where the right scale makes more of the gyroscope's noise, plain least squares would rather keep the wrong one.
TEST(StandingSearch, NamesAScaledGyroscopeThatIsNoisy) {
  const StandOutcome o = Stander({{{0.3, 0.3, 0.3}, lacks_nothing}}, {{}, 0.05, 0.7, 0.3}).search();
  EXPECT_TRUE(o.explained);
  ASSERT_TRUE(is_named(o, EffectId::kSensorScale, at_sensor(0, Reading::kAngularVelocity)));
  EXPECT_EQ(o.chosen.hypothesis.size(), 1);
  // Nodding at 0.085 rad/s against attitudes that are believed to 1e-4 rad/s: 0.2 % a stretch.
  EXPECT_NEAR(o.chosen.hypothesis[0].p[0], 0.7, 2e-3);
}

// The weight of a load is a force, and its lever a displaced centre of mass, where nothing accelerates it. The trunk
// nods so far that the force's lever tells it from zeros of the force sensor.
TEST(StandingSearch, OfALoadAndAForceAtOneTrunkThatStandsStillTellsThatItMayBeALoad) {
  const Hypothesis hidden{{EffectId::kPayload, at_link(0), {3, 0.06, 0.03, 0.2}},
                          {EffectId::kExternalForce, at_link(0), {9, -7, -4}}};
  const StandOutcome o = Stander({{{0.3, 0.3, 0.3}, lacks_nothing}}, {hidden, 0.2}).search();
  EXPECT_TRUE(o.explained);
  EXPECT_TRUE(is_named(o, EffectId::kExternalForce, at_link(0)));
  const auto is_load = [](const Effect& e) { return e.id == EffectId::kPayload && e.place == at_link(0); };
  const Hypothesis& h = o.chosen.hypothesis;
  bool told = std::any_of(h.begin(), h.end(), is_load);
  for (const auto& others : o.indistinguishable) told = told || std::any_of(others.begin(), others.end(), is_load);
  EXPECT_TRUE(told);
}

// An arm that is 1 kg too heavy and hardly accelerates, beside an accelerometer that is shaken by 1 m/s^2: a heavier
// arm makes more of that noise, so that a force leaves less.
TEST(StandingSearch, AForceThatMayBeTheWeightOfItsLinkIsListedBesideItsMass) {
  Body body;
  body.hidden = {{EffectId::kMassError, at_link(2), {1.5}}};
  body.nod = 0.1;
  body.jolt = 1.0;
  const StandOutcome o = Stander({{{0.05, 0.05, 0.05}, lacks_nothing}}, body).search();
  ASSERT_EQ(o.chosen.hypothesis.size(), 1u);
  const auto is_mass = [](const Effect& e) { return e.id == EffectId::kMassError && e.place == at_link(2); };
  const std::vector<Effect>& others = o.indistinguishable[0];
  EXPECT_TRUE(is_mass(o.chosen.hypothesis[0]) || std::any_of(others.begin(), others.end(), is_mass));
}

// An arm of a sixth of the trunk's mass swings by 1.2 degrees, which tells its lever from the trunk's by less than the
// noise of the force sensor: by what slow errors of it may be. By 6 degrees, it tells more.
TEST(StandingSearch, AnArmWithoutEffortsThatSeemsDisplacedMayBeTheTrunkThatCarriesItIfItHardlyMoves) {
  const auto may_be_trunk = [](double reach) {
    Body body;
    body.hidden = {{EffectId::kComError, at_link(2), {0.15, 0, 0}}};
    body.nod = 0.1;
    body.mute = true;
    const StandOutcome o = Stander({{{reach, reach, reach}, lacks_nothing}}, body).search();
    EXPECT_TRUE(is_named(o, EffectId::kComError, at_link(2))) << reach;
    const auto is_trunk = [](const Effect& e) { return e.id == EffectId::kComError && e.place == at_link(0); };
    const std::vector<Effect>& others = o.indistinguishable.at(0);
    return std::any_of(others.begin(), others.end(), is_trunk);
  };
  EXPECT_TRUE(may_be_trunk(0.02));
  EXPECT_FALSE(may_be_trunk(0.1));
}

// A zero of the foot's force beside an arm that is 0.2 kg too light and hardly swings. What the arm's motion shows may
// also be an elastic joint or a displaced arm: the missing weight of 2 N is then in the zero.
TEST(StandingSearch, AZeroOfAForceHoldsWhatItIsBesideEachEffectThatMayBeThere) {
  Body body;
  body.hidden = {{EffectId::kSensorBias, at_sensor(0, Reading::kForce), {30, 20, 4}},
                 {EffectId::kMassError, at_link(2), {0.9}}};
  body.nod = 0.1;
  const StandOutcome o = Stander({{{0.02, 0.02, 0.02}, lacks_nothing}}, body).search();
  ASSERT_EQ(o.chosen.hypothesis.at(0).id, EffectId::kSensorBias);
  ASSERT_FALSE(o.indistinguishable.at(1).empty());
  EXPECT_NEAR(o.chosen.hypothesis[0].p[2], 4, 1.96 * o.widening * o.chosen.std[0](2));
}

// Friction of 0.03 N m under a log that errs by 1 N m: command and encoder tell the same effort to 0.01 N m.
TEST(StandingSearch, TakesTheServosLawWhereItAgreesWithANoisyLog) {
  const auto dry = [](double, double v, double, size_t) { return 0.03 * (v > 0 ? 1.0 : -1.0); };
  const Stander stander({{{0.5, 0.5, 0.5}, dry}}, {{}, 0, 1, 0, 1.0});
  EXPECT_TRUE(stander.get_problem().law[1]);
  const StandOutcome o = stander.search();
  EXPECT_TRUE(o.explained);
  EXPECT_TRUE(is_named(o, EffectId::kCoulomb, at_joint(1)));
  const StandOutcome biased = Stander({{{0.5, 0.5, 0.5}, dry}}, {{}, 0, 1, 0, 1.0, 3.0}).search();
  EXPECT_TRUE(is_named(biased, EffectId::kSensorBias, at_sensor(1, Reading::kEffort)))
      << "a log that is wrong is still seen";
  EXPECT_FALSE(Stander({{{0.5, 0.5, 0.5}, dry}}, {{}, 0, 1, 0, 1.0, 3.0}).get_problem().law[1])
      << "which of the two is wrong is then open";
}

// One recording without the commands of one joint: its law was tried, too, and read columns that are not there.
TEST(StandingSearch, AJointWithoutCommandsHasNoLawAndTheOthersHaveTheirs) {
  const auto dry = [](double, double v, double, size_t) { return 0.03 * (v > 0 ? 1.0 : -1.0); };
  const Arm arm{{0.5, 0.5, 0.5}, dry};
  const std::vector<bool> law = Stander({arm, arm}, {{}, 0, 1, 0, 1.0, 0, true}).get_problem().law;
  EXPECT_FALSE(law[1]);
  EXPECT_TRUE(law[2]);
}

TEST(StandingSearch, FindsNothingInNoise) {
  EXPECT_FALSE(Stander({{{0.3, 0.3, 0.3}, lacks_nothing}}).search().mismatch);
}

// Readings between two samples are less noisy than either: a wrench 14 ms late, halfway, seemed to gain, and a position
// beside it. The position made the wrench needless, and is needless without it.
TEST(StandingSearch, DropsWhatIsNotNeededWithoutWhatWasDroppedBefore) {
  EXPECT_TRUE(Stander({{{0.3, 0.3, 0.3}, lacks_nothing}}, {}, 5).search().chosen.hypothesis.empty());
}

// An accelerometer shaken by 0.3 m/s^2. Half a sample on, its readings are less noisy, later and earlier; and three
// recordings tell three means, which counted at every sample. Both were named as a clock of its own.
TEST(StandingSearch, NamesNoLateClockOfANoisyAccelerometer) {
  for (const unsigned seed : {2U, 7U}) {
    Body shaken;
    shaken.jolt = 0.3;
    const StandOutcome o = Stander({{{0.3, 0.3, 0.3}, lacks_nothing}}, shaken, seed).search();
    EXPECT_TRUE(o.chosen.hypothesis.empty()) << seed;
  }
}

// Encoders, gyroscope, attitude and accelerometer agree with each other against the force sensor.
TEST(StandingSearch, NamesALateForceSensorAndNoImu) {
  Body late;
  late.nod = 0.15;
  late.jolt = 0.1;
  late.late = 1;
  const StandOutcome o = Stander({{{0.3, 0.3, 0.3}, lacks_nothing}}, late).search();
  ASSERT_EQ(o.chosen.hypothesis.size(), 1u);
  EXPECT_TRUE(is_named(o, EffectId::kSensorDelay, at_sensor(0, Reading::kWrench)));
  EXPECT_NEAR(o.chosen.hypothesis[0].p[0], kStep, 0.2 * kStep)
      << "a fifth: interpolation rounds the arms' quickest turns off";
}

}  // namespace
}  // namespace hrp::diagnosis::standing
