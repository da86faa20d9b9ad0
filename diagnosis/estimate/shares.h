// SPDX-License-Identifier: BSD-3-Clause
// How much is much: the shares of a spread, a mismatch, a gain, a time or a probability by which the diagnosis judges.
// They are one scale of few steps on purpose. No recording tells whether a limit should be 0.1 or 0.12, so none is
// tuned alone.
#pragma once

namespace hrp::diagnosis {

// No more than a trace: as good as not there.
constexpr double kTrace = 0.01;
// To which the best-known numbers are known: scales and torque constants of data sheets, models fitted to the same log.
constexpr double kKnown = 0.02;
// What filters, derivatives and friction that is no function leave uncertain: who takes less of an error proves
// nothing.
constexpr double kBlur = 0.03;
// The least that counts: chance among a dozen candidates takes as much, a cause takes more.
constexpr double kMinor = 0.05;
// A detail beside the whole. Equality: two values, or two explanations, that differ by no more say the same.
constexpr double kDetail = 0.1;
// The exceptions to a rule.
constexpr double kMinority = 0.2;
// A part that nobody overlooks; of squares, half of the size.
constexpr double kPart = 0.25;
// Large enough to be the cause of something; what is left beside it may have other causes.
constexpr double kMuch = 0.3;
// Decides between two.
constexpr double kHalf = 0.5;

// The same from the other end.
constexpr double kLargely = 1.0 - kMuch;
constexpr double kMostly = 1.0 - kMinority;
constexpr double kNearlyAll = 1.0 - kDetail;

}  // namespace hrp::diagnosis
