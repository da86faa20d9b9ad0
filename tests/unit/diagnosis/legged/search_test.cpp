// SPDX-License-Identifier: BSD-3-Clause
// Which effects the search names, on equations that are made by hand.
#include "diagnosis/floating/search/search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "diagnosis/floating/search/gain.h"
#include "diagnosis/floating/search/rivals.h"
#include "tests/unit/diagnosis/legged/biped.h"
#include "tests/unit/diagnosis/legged/rows.h"

namespace hrp::diagnosis::floating {
namespace {

LeggedOutcome search(std::vector<ChannelRows> rows, int columns, const std::vector<Candidate>& candidates,
                     const Eigen::VectorXd* about = nullptr) {
  LeggedFitter fitter(std::move(rows), columns);
  const ColumnLayout layout(make_legged_log(make_biped({}), Half::kEven));
  return search_legged(&fitter, candidates, layout, nullptr, about);
}

// Its second column tells while rough rows weigh little. When its first one has explained them, they do not.
TEST(LeggedSearch, AnEffectThatLosesItsInformationTakesNoOtherWithIt) {
  const LeggedOutcome found = search(make_calm_and_rough(), 2,
                                     {make_candidate(EffectId::kRotorInertia, "A", {{{0, 1.0}}}),
                                      make_candidate(EffectId::kSpring, "A", {{{0, 1.0}}, {{1, 1.0}}})});
  ASSERT_EQ(found.chosen.effects.size(), 1u);
  EXPECT_EQ(found.chosen.effects[0].law->effect, EffectId::kRotorInertia);
  EXPECT_NEAR(found.chosen.x(0), 100, 1);
}

// A slow walk to fit asks for 92 kg m^2, a fast one that is held out for 100: it has 19 of 20 parts of the information.
TEST(LeggedSearch, AValueIsMeasuredByAllRecordingsAndDecidedByTheHeldOutOne) {
  std::mt19937 random(61);
  std::normal_distribution<double> normal;
  RowHalves rows(1, 900, {{make_joint_channel("A"), {0}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const bool slow = 3 * i < 2 * rows.cells();
    const double acceleration = (slow ? 0.1 : 0.6) * normal(random);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, (slow ? 92 : 100) * acceleration + 0.2 * normal(random), 40 * std::sin(0.1 * i));
      half->add(0, 0, acceleration);
    });
  }
  const LeggedOutcome out = search(rows.merge(), 1, {make_candidate(EffectId::kRotorInertia, "A", {{{0, 1.0}}})});
  ASSERT_EQ(out.effects.size(), 1u);
  EXPECT_NEAR(out.chosen.x(0), 92, 0.5) << "what held-out errors are predicted with has not seen them";
  EXPECT_NEAR(out.effects[0].x(0), 99.6, 0.2);
}

// A drive that is 15 % too strong in an ankle, 6 N m at 40 N m, and a force of this size [N] on the body that nobody
// knows.
size_t count_gains_beside(double force) {
  std::mt19937 random(23);
  std::normal_distribution<double> normal;
  RowHalves rows(1, 900, {{kBalance, {}}, {make_joint_channel("A"), {0}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double unknown = force * std::sin(0.9 * i), torque = 40 * normal(random);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, unknown + normal(random), 400 + 40 * std::sin(0.1 * i));
      half->begin_row(1, 0.15 * torque + 0.2 * normal(random), torque);
      half->add(1, 0, torque);
    });
  }
  Candidate gain = make_candidate(EffectId::kTorqueConstant, "A", {{{0, 1.0}}});
  gain.lever = 0.1;
  return search(rows.merge(), 1, {gain}).effects.size();
}

// Anywhere under a sole of 0.2 m, 150 N make moments of up to 15 N m at the ankle; 20 N make 2.
TEST(LeggedSearch, ADrivesGainThatAnUnknownForceUnderTheSoleCouldMakeIsNotNamed) {
  EXPECT_EQ(count_gains_beside(150), 0u);
  EXPECT_EQ(count_gains_beside(20), 1u);
}

// A force of which a listed effect predicts `listed` and a free law `free` of the square; the search's first effect.
bool is_first_listed(double listed, double free) {
  std::mt19937 random(31);
  std::normal_distribution<double> normal;
  RowHalves rows(2, 900, {{kBalance, {0, 1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double force = normal(random), other = normal(random), another = normal(random);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, 20 * force + normal(random), 400 + 40 * std::sin(0.1 * i));
      half->add(0, 0, std::sqrt(listed) * force + std::sqrt(1 - listed) * other);
      half->add(0, 1, std::sqrt(free) * force + std::sqrt(1 - free) * another);
    });
  }
  Candidate hold = make_candidate(EffectId::kNamed, "A", {{{1, 1.0}}});
  hold.law = &get_laws().hold;
  const LeggedOutcome out = search(rows.merge(), 2, {make_candidate(EffectId::kViscous, "A", {{{0, 1.0}}}), hold});
  return !out.effects.empty() && out.effects[0].effect.is_listed();
}

TEST(LeggedSearch, AFreeLawTakesThePlaceOfANameOnlyWhereItWinsOutright) {
  EXPECT_FALSE(is_first_listed(0.9, 0.999));
  EXPECT_TRUE(is_first_listed(0.999, 0.9));
  EXPECT_TRUE(is_first_listed(0.99, 0.99)) << "a tie is the effect's, which a scenario can hold";
}

// A cause in each of three equations. An effect at each joint predicts its cause to a tenth, one free law predicts what
// they all do, but for an error of its own. How many listed effects the search names.
size_t count_faults(double error) {
  std::mt19937 random(53);
  std::normal_distribution<double> normal;
  RowHalves rows(
      4, 900,
      {{make_joint_channel("A"), {0, 3}}, {make_joint_channel("B"), {1, 3}}, {make_joint_channel("C"), {2, 3}}});
  for (int i = 0; i < rows.cells(); ++i) {
    double cause[3], by_listed[3], by_free[3];
    for (int c = 0; c < 3; ++c) {
      cause[c] = normal(random);
      by_listed[c] = cause[c] + 0.1 * normal(random);
      by_free[c] = by_listed[c] + error * normal(random);
    }
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      for (int c = 0; c < 3; ++c) {
        half->begin_row(c, 20 * cause[c] + 0.2 * normal(random), 40 * std::sin(0.1 * i));
        half->add(c, c, by_listed[c]);
        half->add(c, 3, by_free[c]);
      }
    });
  }
  Candidate hold = make_candidate(EffectId::kNamed, "A", {{{3, 1.0}}});
  hold.law = &get_laws().hold;
  std::vector<Candidate> candidates{hold};
  const char* const joints[] = {"A", "B", "C"};
  for (int c = 0; c < 3; ++c) candidates.push_back(make_candidate(EffectId::kTorqueConstant, joints[c], {{{c, 1.0}}}));
  const LeggedOutcome out = search(rows.merge(), 4, candidates);
  return static_cast<size_t>(
      std::count_if(out.effects.begin(), out.effects.end(), [](const FoundEffect& f) { return f.effect.is_listed(); }));
}

TEST(LeggedSearch, OneFreeLawIsLikelierThanSeveralFaultsThatExplainAsMuchTogether) {
  EXPECT_EQ(count_faults(0.01), 0u);
  EXPECT_EQ(count_faults(0.1), 3u) << "it explains less than three real faults do";
}

// Friction, and a delay of 1 us per N m s/rad whose column is the same but for a hundredth.
size_t count_frictions(double coefficient, double known) {
  std::mt19937 random(29);
  std::normal_distribution<double> normal;
  RowHalves rows(2, 900, {{make_joint_channel("A"), {0, 1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double speed = std::sin(0.9 * i), other = 0.01 * normal(random);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, coefficient * speed + 0.02 * normal(random), 2 * speed);
      half->add(0, 0, speed);
      half->add(0, 1, 1e6 * (speed + other));
    });
  }
  Candidate delay = make_candidate(EffectId::kDelay, "A", {{{1, 1.0}}});
  delay.known = known;
  delay.least = 5 * known;
  return search(rows.merge(), 2, {make_candidate(EffectId::kViscous, "A", {{{0, 1.0}}}), delay}).effects.size();
}

// Rows of 2.5 ms tell instants to a tenth of it: 0.2 us of delay are no mismatch, whatever else they look like.
TEST(LeggedSearch, WhatADelayFarBelowOneSampleExplainsAsWellIsNotNamed) {
  EXPECT_EQ(count_frictions(0.2, 250e-6), 0u);
  EXPECT_EQ(count_frictions(0.2, 0.1e-6), 1u);
}

// A constant of 0.05 rad/s in one axis of a gyroscope. Another axis has a slow error of 0.2 rad/s, of which the same
// zero takes a little: its many independent rows gain more than the constant, which counts as one error.
TEST(LeggedSearch, AZeroIsJudgedByTheEquationThatItExplains) {
  std::mt19937 random(37);
  std::normal_distribution<double> normal;
  const auto name = [](int axis) {
    return ChannelInfo{{EquationKind::kGyroscope, axis},
                       "/imu/waist/angular_velocity",
                       "rad/s",
                       "sensor",
                       "/imu/waist/angular_velocity"};
  };
  RowHalves rows(2, 900, {{name(0), {0}}, {name(2), {1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double x = 0.05 + 0.03 * normal(random), z = 0.06 + 0.2 * normal(random);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, x + 1e-3 * normal(random), std::sin(0.1 * i));
      half->add(0, 0, 1);
      half->begin_row(1, z + 1e-3 * normal(random), std::sin(0.1 * i));
      half->add(1, 1, 1);
    });
  }
  Candidate zero = make_candidate(EffectId::kSensorBias, "", {{{0, 1.0}}, {{1, 1.0}}});
  zero.vector = true;
  const LeggedOutcome out = search(rows.merge(), 2, {zero});
  ASSERT_EQ(out.effects.size(), 1u);
  EXPECT_NEAR(out.effects[0].x(0), 0.05, 0.004);  // four standard errors of 600 rows
}

// A constant in one of three forces whose signals are exact to half a percent of their spread, 1.4 N.
size_t count_constants(double force) {
  std::mt19937 random(67);
  std::normal_distribution<double> normal;
  RowHalves rows(3, 900,
                 {{{{EquationKind::kForce, 0}, "f", "N", "link", "a"}, {0}},
                  {{{EquationKind::kForce, 1}, "f", "N", "link", "a"}, {1}},
                  {{{EquationKind::kForce, 2}, "f", "N", "link", "a"}, {2}}});
  for (int i = 0; i < rows.cells(); ++i) {
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      for (int c = 0; c < 3; ++c) {
        half->begin_row(c, (c == 0 ? force : 0) + 0.1 * normal(random), 400 * std::sin(0.1 * i));
        half->add(c, c, 1);
      }
    });
  }
  Candidate zero = make_candidate(EffectId::kSensorBias, "", {{{0, 1.0}}, {{1, 1.0}}, {{2, 1.0}}});
  zero.vector = true;
  return search(rows.merge(), 3, {zero}).effects.size();
}

// Chance alone would make far less: the zero's scatter is 0.01 N.
TEST(LeggedSearch, AZeroWithinWhatItsEquationIsExactToIsNotNamed) {
  EXPECT_EQ(count_constants(2.5), 0u);
  EXPECT_EQ(count_constants(10), 1u);
}

// A constant moment that play of `gap` [rad] and another cause explain alike, the play a little better.
EffectId find_constant(double gap) {
  std::mt19937 random(71);
  std::normal_distribution<double> normal;
  RowHalves rows(2, 900, {{kBalance, {0, 1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double leans = 1 + 0.1 * normal(random);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, 2 * leans + 0.02 * normal(random), 2 * std::sin(0.1 * i));
      half->add(0, 0, 2 / gap * leans);
      half->add(0, 1, leans + 0.003 * normal(random));
    });
  }
  Candidate play = make_candidate(EffectId::kBacklash, "A", {{{0, 1.0}}});
  play.law = &get_laws().backlash;
  const LeggedOutcome out = search(rows.merge(), 2, {play, make_candidate(EffectId::kSpring, "B", {{{1, 1.0}}})});
  return out.effects.size() == 1 ? out.effects[0].effect.law->effect : EffectId::kNamed;
}

// No usable transmission has gaps of ten degrees, unless nothing else explains what is there.
TEST(LeggedSearch, AnotherCauseTakesThePlaceOfPlayThatIsHugeAndOfNoOther) {
  EXPECT_EQ(find_constant(0.19), EffectId::kSpring);
  EXPECT_EQ(find_constant(0.02), EffectId::kBacklash);
}

// A delay whose column is of first order leaves two thirds of the mismatch. Where the equations are made about its
// value, they are exact, and what is left then counts.
TEST(LeggedSearch, ADelayIsNotJudgedByWhatItsColumnsLeaveOut) {
  std::mt19937 random(41);
  std::normal_distribution<double> normal;
  RowHalves rows(1, 900, {{make_joint_channel("A"), {0}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double rate = normal(random), beyond = normal(random);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, 3 * rate + 4.2 * beyond + 0.02 * normal(random), 10 * rate);
      half->add(0, 0, 100 * rate);
    });
  }
  Candidate delay = make_candidate(EffectId::kDelay, "A", {{{0, 1.0}}});
  delay.law = &get_laws().delay;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(1), there = Eigen::VectorXd::Constant(1, 0.03);
  EXPECT_EQ(search(rows.merge(), 1, {delay}, &none).effects.size(), 1u);
  EXPECT_EQ(search(rows.merge(), 1, {delay}, &there).effects.size(), 0u);
  EXPECT_EQ(search(rows.merge(), 1, {delay}).effects.size(), 0u);
}

// An accelerometer that always feels the same weight: a scale and a zero make the same constant, and with large values
// that undo each other, any small line.
TEST(LeggedSearch, OfTwoEffectsThatUndoEachOtherOneIsLeft) {
  std::mt19937 random(43);
  std::normal_distribution<double> normal;
  const ChannelInfo info{{EquationKind::kAccelerometer, 1},
                         "/imu/waist/linear_acceleration",
                         "m/s^2",
                         "sensor",
                         "/imu/waist/linear_acceleration"};
  RowHalves rows(2, 900, {{info, {0, 1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double feels = 9.8 + 0.05 * normal(random);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, 0.05 - 0.6 * (feels - 9.8) + 0.005 * normal(random), feels);
      half->add(0, 0, feels);
      half->add(0, 1, 1);
    });
  }
  const LeggedOutcome out = search(rows.merge(), 2,
                                   {make_candidate(EffectId::kSensorScale, "A", {{{0, 1.0}}}),
                                    make_candidate(EffectId::kSensorBias, "A", {{{1, 1.0}}})});
  ASSERT_EQ(out.effects.size(), 1u);
  EXPECT_LT(std::abs(out.effects[0].x(0)), 0.1);  // 0.05 m/s^2, or 0.005 of the weight; both together: 6 and -0.6
}

// The left elbow asks for a zero of 15 mrad, the right one for `right` [rad] behind more noise: too little to be found
// alone.
size_t count_zeros(double right) {
  std::mt19937 random(59);
  std::normal_distribution<double> normal;
  RowHalves rows(2, 900, {{make_joint_channel("left_elbow"), {0}}, {make_joint_channel("right_elbow"), {1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double weight = 2 + 0.2 * std::sin(0.3 * i), other = 2 + 0.2 * std::cos(0.2 * i);
    const double error = 0.01 * normal(random), more = 0.09 * normal(random);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, 0.015 * weight + error, weight);
      half->add(0, 0, weight);
      half->begin_row(1, right * other + more, other);
      half->add(1, 1, other);
    });
  }
  return search(rows.merge(), 2,
                {make_candidate(EffectId::kJointOffset, "left_elbow", {{{0, 1.0}}}),
                 make_candidate(EffectId::kJointOffset, "right_elbow", {{{1, 1.0}}})})
      .effects.size();
}

// A body that is tilted against what its sensors say turns both arms.
TEST(LeggedSearch, AZeroThatTheOtherSideAsksForTooIsNoEncoders) {
  EXPECT_EQ(count_zeros(0), 1u);
  EXPECT_EQ(count_zeros(0.015), 0u);
}

// A spring takes two thirds of a joint's mismatch. `play` [rad] of the same joint moves the body.
bool is_spring_named(double play) {
  std::mt19937 random(61);
  std::normal_distribution<double> normal;
  RowHalves rows(2, 900, {{kBalance, {0}}, {make_joint_channel("hip"), {1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double side = normal(random), position = normal(random), unknown = 0.7 * normal(random);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, play * 1000 * side + normal(random), 400 + 40 * std::sin(0.1 * i));
      half->add(0, 0, 1000 * side);
      half->begin_row(1, position + unknown, 20);
      half->add(1, 1, position);
    });
  }
  const LeggedOutcome out = search(rows.merge(), 2,
                                   {make_candidate(EffectId::kBacklash, "hip", {{{0, 1.0}}}),
                                    make_candidate(EffectId::kSpring, "hip", {{{1, 1.0}}})});
  EXPECT_EQ(out.effects.empty() ? false : out.effects[0].effect.law->effect == EffectId::kBacklash, play > 0);
  return std::any_of(out.effects.begin(), out.effects.end(),
                     [](const FoundEffect& f) { return f.effect.law->effect == EffectId::kSpring; });
}

TEST(LeggedSearch, ASpringAcrossATransmissionWithPlayIsWhatItsLawLeaves) {
  EXPECT_TRUE(is_spring_named(0));
  EXPECT_FALSE(is_spring_named(0.02));
}

// Two joints whose causes have nothing in common and gain about the same. A third effect explains what the first one
// does.
TEST(LeggedSearch, WhatExplainsAsMuchOfAnotherEquationIsNoRival) {
  std::mt19937 random(67);
  std::normal_distribution<double> normal;
  RowHalves rows(3, 900, {{make_joint_channel("A"), {0, 2}}, {make_joint_channel("B"), {1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double a = normal(random), b = normal(random), like_a = a + 0.01 * normal(random);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, 10 * a + normal(random), 20);
      half->add(0, 0, a);
      half->add(0, 2, like_a);
      half->begin_row(1, 10 * b + normal(random), 20);
      half->add(1, 1, b);
    });
  }
  const Candidate a = make_candidate(EffectId::kViscous, "A", {{{0, 1.0}}}),
                  b = make_candidate(EffectId::kViscous, "B", {{{1, 1.0}}}),
                  like_a = make_candidate(EffectId::kCoulomb, "A", {{{2, 1.0}}});
  const std::vector<Candidate> candidates{a, b, like_a};
  LeggedFitter fitter(rows.merge(), 3);
  const ColumnLayout layout(make_legged_log(make_biped({}), Half::kEven));
  const LeggedFit nominal = fitter.fit({}), chosen = fitter.fit({a});
  const Say silent;
  const SearchState state{fitter, candidates, layout, silent, nullptr, nominal, chosen, {}, {}};
  FoundEffect found;
  found.effect = a;
  found.gain = calc_total_gain(state, nominal, chosen);
  found.channel = 0;
  const std::vector<Rival> rivals = list_rivals(state, nominal, found);
  ASSERT_EQ(rivals.size(), 1u);
  EXPECT_EQ(rivals[0].effect.law->effect, like_a.law->effect);
}

// A foot's scale of 7 % makes 11 N and, as the body sways, 0.6 N more or less. An accelerometer's zero makes the same
// weight, and in the held-out recording just as much of a tilt, as zeros of IMUs differ: that is no word against the
// scale.
TEST(LeggedSearch, AScaleIsHeldOutByTheForcesThatItChangesNotByATiltThatAnotherEffectTakes) {
  std::mt19937 random(67);
  std::normal_distribution<double> normal;
  RowHalves rows(2, 900, {{kBalance, {0, 1}}, {make_joint_channel("A"), {1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double force = 160 + 8 * std::sin(0.9 * i), zero = 3 * i < 2 * rows.cells() ? -0.03 : -0.33;
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, 0.07 * force + 0.3 * normal(random), 340);
      half->add(0, 0, force);
      half->add(0, 1, -34);
      half->begin_row(1, zero + 0.1 * normal(random), 1);
      half->add(1, 1, 1);
    });
  }
  const Candidate scale = make_candidate(EffectId::kSensorScale, "A", {{{0, 1.0}}}),
                  zero = make_candidate(EffectId::kSensorBias, "A", {{{1, 1.0}}});
  const std::vector<Candidate> candidates{scale, zero};
  LeggedFitter fitter(rows.merge(), 2);
  const ColumnLayout layout(make_legged_log(make_biped({}), Half::kEven));
  const LeggedFit nominal = fitter.fit({}), chosen = fitter.fit({scale, zero}), rest = fitter.fit({zero});
  const Say silent;
  const SearchState state{fitter, candidates, layout, silent, nullptr, nominal, chosen, {}, {}};
  EXPECT_LT(fitter.calc_gain(Part::kHeld, 1, rest, chosen), 0) << "the zero wins there what the scale is not about";
  EXPECT_EQ(calc_own_held_gain(state, rest, 0), fitter.calc_gain(Part::kHeld, 0, rest, chosen));
  EXPECT_GT(calc_own_held_gain(state, rest, 0), kLeastHeldGain);
}

// A foot in the air hardly loads its ankle: friction is the effort, and the effort times 1 is the friction.
// A rotor takes a sixth of what a joint misses; another joint's rotor takes all of its own, or is not there.
size_t count_rotors(bool another) {
  std::mt19937 random(83);
  std::normal_distribution<double> normal;
  RowHalves rows(2, 900, {{make_joint_channel("A"), {0}}, {make_joint_channel("B"), {1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double first = normal(random), second = normal(random), unknown = 9 * std::sin(1.1 * i);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, 3 * first + unknown + 0.2 * normal(random), 40);
      half->add(0, 0, first);
      half->begin_row(1, (another ? 3 * second : 0) + 0.2 * normal(random), 40);
      half->add(1, 1, second);
    });
  }
  const Candidate a = make_candidate(EffectId::kRotorInertia, "A", {{{0, 1.0}}}),
                  b = make_candidate(EffectId::kRotorInertia, "B", {{{1, 1.0}}});
  return search(rows.merge(), 2, {a, b}).effects.size();
}

// A disturbance of 1.3 Hz at one ankle was named a rotor of 2.7 kg m^2 there, which took a sixth of it.
TEST(LeggedSearch, ALoneRotorThatLeavesMostOfItsJointsMismatchIsNotNamed) {
  EXPECT_EQ(count_rotors(false), 0u);
  EXPECT_EQ(count_rotors(true), 2u);
}

TEST(LeggedSearch, FrictionThatIsAllOfAnEffortIsNoShareOfIt) {
  std::mt19937 random(71);
  std::normal_distribution<double> normal;
  RowHalves rows(2, 900, {{make_joint_channel("A"), {0, 1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double direction = i % 30 < 15 ? 1 : -1, load = 0.5 * normal(random), effort = 10 * direction + load;
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, 10 * direction + 0.1 * load + 0.1 * normal(random), 10);
      half->add(0, 0, direction);
      half->add(0, 1, direction * std::abs(effort));
    });
  }
  Candidate plain = make_candidate(EffectId::kCoulomb, "A", {{{0, 1.0}}}),
            loaded = make_candidate(EffectId::kLoadFriction, "A", {{{1, 1.0}}});
  plain.law = &get_laws().coulomb;
  loaded.law = &get_laws().load_friction;
  EXPECT_TRUE(search(rows.merge(), 2, {loaded}).effects.empty());
  const LeggedOutcome out = search(rows.merge(), 2, {plain, loaded});
  ASSERT_EQ(out.effects.size(), 1u);
  EXPECT_EQ(out.effects[0].effect.law, plain.law);
}

TEST(LeggedSearch, AFootWhoseMomentIsNotRecordedMaySink) {
  Recorded recorded;
  recorded.six_axes = false;
  const LeggedLog log = make_legged_log(make_biped({}, recorded), Half::kEven);
  const ColumnLayout layout(log);
  size_t soles = 0;
  for (const Candidate& c : list_candidates(log, layout)) {
    if (c.law->effect != EffectId::kFootCompliance) continue;
    ++soles;
    EXPECT_EQ(c.terms.size(), 1u) << "no equation has columns of moments";
  }
  EXPECT_EQ(soles, 2u);
}

// A load of 4.5 kg at (0.1, -0.05, 0.2) m in the pelvis. Its height hardly changes the weight: what else is in the
// weight would put it 4.6 m up.
TEST(LeggedSearch, ALoadWhoseHeightHardlyShowsIsALoadWithinReach) {
  const LeggedLog log = make_legged_log(make_biped({}), Half::kEven);
  const ColumnLayout layout(log);
  std::vector<Candidate> loads;
  for (const Candidate& c : list_candidates(log, layout)) {
    if (c.law == &get_laws().payload && c.place == 0) loads.push_back(c);
  }
  RowHalves rows(layout.count(), 900,
                 {{kWeight, {layout.link(0, 0), layout.link(0, 1), layout.link(0, 2), layout.link(0, 3)}}});
  std::mt19937 random(47);
  std::normal_distribution<double> normal;
  for (int i = 0; i < rows.cells(); ++i) {
    const double column[] = {9.8 + 0.5 * normal(random), 0.8 * normal(random), 0.8 * normal(random),
                             0.002 * normal(random)};
    const double load = 4.5 * (column[0] + 0.1 * column[1] - 0.05 * column[2] + 0.2 * column[3]),
                 other = 20 * column[3];
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, load + other + 0.3 * normal(random), 400 + 10 * normal(random));
      for (int c = 0; c < 4; ++c) half->add(0, layout.link(0, c), column[c]);
    });
  }
  const LeggedOutcome out = search(rows.merge(), layout.count(), loads);
  ASSERT_EQ(out.effects.size(), 1u);
  const auto parameters = make_estimates(out.effects[0].effect, out.effects[0].x, out.effects[0].std);
  EXPECT_NEAR(parameters[0].value[0], 4.5, 0.05);
  EXPECT_NEAR(parameters[1].value[0], 0.1, 0.02);  // five standard errors of 600 rows
  EXPECT_NEAR(parameters[1].value[2], 0.2, 1.96 * parameters[1].std[2]) << "its own interval";
}

// Tilts of a sole that gives 0.006 rad/(N m) about y. A hand leans the stiff robot: the sole bears a side force in
// proportion to its moment. About x, moments are noise. Without `sink`, no second foot tells how far it sinks.
// `sink` [m/N]: of the height over the other foot; `about`: the axis.
LeggedOutcome search_leaning_sole(double give = 0.006, double damping = 0, double sink = 0, int about = 1) {
  const LeggedLog log = make_legged_log(make_biped({}), Half::kEven);
  const ColumnLayout layout(log);
  std::vector<Candidate> soles;
  for (const Candidate& c : list_candidates(log, layout)) {
    if (c.law == &get_laws().flat_sole && c.place == 0) soles.push_back(c);
  }
  const auto list_tilt = [&](int give, int shift) {
    return std::vector<int>{layout.foot(0, give), layout.foot(0, give + 1), layout.foot(0, shift),
                            layout.foot(0, shift + 1)};
  };
  RowHalves rows(layout.count(), 900,
                 {{{{EquationKind::kTilt, 0}, "/joint_states", "rad", "foot", "l_foot"},
                   list_tilt(kRollGiveColumn, kRollShiftColumn)},
                  {{{EquationKind::kTilt, 1}, "/joint_states", "rad", "foot", "l_foot"},
                   list_tilt(kPitchGiveColumn, kPitchShiftColumn)},
                  {{EquationKind::kHeight, "/joint_states", "m", "foot", "l_foot"}, {layout.foot(0, kSinkColumn)}}});
  std::mt19937 random(37);
  std::normal_distribution<double> normal;
  for (int i = 0; i < rows.cells(); ++i) {
    double moment[] = {0, 0}, rate[] = {0, 0};
    moment[about] = 5 * std::sin(0.04 * i);
    rate[about] = 5 * std::cos(0.04 * i);
    const double force = 100 * std::sin(0.11 * i);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      if (sink > 0) {
        half->begin_row(2, sink * force + 1e-5 * normal(random), 0.02);
        half->add(2, layout.foot(0, kSinkColumn), force);
      }
      for (const int axis : {0, 1}) {
        half->begin_row(axis, give * moment[axis] - damping * rate[axis] + 2e-4 * normal(random), 0.03);
        const int to_give = axis == 0 ? kRollGiveColumn : kPitchGiveColumn,
                  shift = axis == 0 ? kRollShiftColumn : kPitchShiftColumn;
        half->add(axis, layout.foot(0, to_give), moment[axis] + 0.05 * normal(random));
        half->add(axis, layout.foot(0, to_give + 1), (damping > 0 ? -rate[axis] : 0) + 0.002 * normal(random));
        half->add(axis, layout.foot(0, shift), 160 + 0.3 * normal(random));
        half->add(axis, layout.foot(0, shift + 1), moment[axis] + 0.3 * normal(random));
      }
    });
  }
  return search(rows.merge(), layout.count(), soles);
}

// What bends further up is late, too. 4e-5 rad/(N m) are 0.2 mrad, to which no model is exact.
TEST(LeggedSearch, ALagWithoutAStiffnessIsNoSole) {
  EXPECT_TRUE(search_leaning_sole(4e-5, 4e-4, 3e-6, 0).effects.empty());
  EXPECT_EQ(search_leaning_sole(1e-3, 4e-4, 3e-6, 0).effects.size(), 1u);
}

TEST(LeggedSearch, ASoleThatAHandLeansAboutOneAxisGivesAboutIt) {
  const LeggedOutcome out = search_leaning_sole();
  ASSERT_EQ(out.effects.size(), 1u);
  const FoundEffect& sole = out.effects[0];
  const auto parameters = make_estimates(sole.effect, sole.x, sole.std);
  ASSERT_FALSE(parameters.empty());
  EXPECT_EQ(parameters[0].name, "k_pitch") << "nothing pressed it about x";
  EXPECT_NEAR(parameters[0].value[0], 1 / 0.006, 4) << "a side force of 1 N per N m, 0.02 m off the face: 2 %";
}

}  // namespace
}  // namespace hrp::diagnosis::floating
