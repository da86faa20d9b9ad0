// SPDX-License-Identifier: BSD-3-Clause
// When a fitted effect counts as different from its absence. One rule: chance alone, over all effects that are tried
// in one diagnosis, gives such a value in fewer than one of a thousand diagnoses. How many are tried, and what else
// they have to pass, differs; so do the deviations of a normal distribution that this takes.
#pragma once

namespace hrp::diagnosis {

// Times the noise (root mean square), up to which what is left counts as noise: sizes of noise are estimates
// themselves, and details of laws and of smoothing stay below it.
constexpr double kNoiseLeft = 1.2;

// Times the noise (root mean square), beyond which no detail of laws and no estimate of the noise reaches: something is
// missing.
constexpr double kAboveNoise = 2.0;

// Deviations of one question that is asked once, of errors that are known: chance answers it so in one of 370 cases.
constexpr double kUnlikely = 3.0;

// Deviations of a normal distribution within which 95 % are: half the width of every interval that a report says.
constexpr double kNinetyFive = 1.96;

// Relative: how well two implementations of a law, two integrators, or a log and the law that made it agree at best.
constexpr double kAgreement = 1e-3;

// [nats] of odds of 20 to 1: what one more term must add beyond its cost, and within which two models do as well.
constexpr double kOdds = 3.0;

// |ln| of a factor beyond which nothing is believed: the bound of its prior (EffectParameter::factor).
constexpr double kFactor = 1.0;

// Two regressions of a factor, one each way, bracket it: they tell it where they are nearer to each other than this
// share of its distance from one.
constexpr double kBracket = 0.5;

// Effects of one joint against each other: 16, of which the others have been refused by their price in chi2 before.
constexpr double kSignificantInJoint = 4.0;  // two-sided probability 6e-5
// Three axes at once: 4.0 in one dimension is as improbable as this distance in three.
constexpr double kSignificantVector = 4.7;
// Effects of a whole standing robot: 500 starts at all places, no price: two-sided probability 2e-6.
constexpr double kSignificantInRobot = 4.75;
// Effects of a tossed body: tosses are the independent errors, a dozen of them, each effect has to help on tosses that
// were not fitted as well, which chance does in one of two: 12 x 0.0027 / 2^5 for five of them.
constexpr double kSignificantInTosses = 3.0;

}  // namespace hrp::diagnosis
