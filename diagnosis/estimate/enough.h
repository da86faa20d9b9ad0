// SPDX-License-Identifier: BSD-3-Clause
// How many values and how many deviations are enough, and how many things a report names. One scale of few steps, as in
// shares.h: no recording tells whether a limit should be 20 or 25.
#pragma once

#include <cstddef>

namespace hrp::diagnosis {

// Values that have to agree: two do by chance, and hardly tell a variance.
constexpr size_t kFewestToAgree = 3;
// Of a median or a share that a rule goes by, as of cells at rest or of a foot that slides.
constexpr size_t kFewestToTell = 20;
// Of one recording or equation that has a value of its own: fewer follow anything by chance.
constexpr size_t kFewestOfItsOwn = 30;
// Of a value that a report states: below, nothing is said.
constexpr size_t kFewestToSay = 50;
// For a fit of a servo's law, at least. Neighbours resemble each other: some ten of them are independent.
constexpr size_t kLeastServoSamples = 100;
// Samples for each column that is fitted, at least: fewer follow any law by chance.
constexpr long kRowsPerColumn = 10;

// Robust standard deviations of an outlier: a spike, an impact, a foot in the air. None of some thousand samples of
// noise is so far off.
constexpr double kOutlier = 4.0;
// Standard deviations that chance does not reach, whatever is asked. Of a sum of products: those of two independent
// errors have either sign, so the probability to exceed it is below 2 exp(-5^2 / 2).
constexpr double kNoChance = 5.0;
// Probability that no finding exceeds, however clear it is: laws outside the table exist.
constexpr double kSurest = 0.99;

// A report says no more than people read, and counts the rest: in a sentence, of curves or names, in a list.
constexpr size_t kMostInSentence = 3;
constexpr size_t kMostNamed = 4;
constexpr size_t kMostInList = 5;

}  // namespace hrp::diagnosis
