// SPDX-License-Identifier: BSD-3-Clause
// Every effect that a standing robot's recordings may hide: how it is written, started, varied, bounded.
#pragma once

#include "diagnosis/standing/terms.h"

namespace hrp::diagnosis::standing {

// Where to look for effects that no linear prediction finds, or that only some motions can show (hints.h).
struct StandHints {
  double slip_ratio = 0;                     // friction at which feet were seen to slip; 0: they were not
  std::vector<std::vector<double>> ripples;  // by joint [1/rad]: how often the missing effort repeats
  std::vector<double> play;                  // by joint [rad]: how far its link would have to move against its encoder
};

// [rad/(N m)] How far ground and sole may give of themselves: feet are taken as rigid above 5e4 N m/rad.
constexpr double kContact = 2e-5;

constexpr double kMostPlay = 0.2;  // [rad] between teeth that somebody would still call a transmission

struct StandInfo {
  StandId id;
  const char* effect;                   // name in the report
  std::vector<const char*> parameters;  // names; "" is a nuisance
  std::vector<const char*> units;
  std::vector<double> neutral;  // value that changes nothing
  std::vector<double> step;     // for finite differences
  bool positive = false;        // first parameter must not fall below its neutral value
};
const StandInfo& get_stand_info(StandId id);

// What may be added to a hypothesis. Effects with a parameter that no linear fit finds (a Stribeck velocity, the
// periods of cogging) come several times, with different starts.
std::vector<StandEffect> list_candidates(const StandProblem& problem, const StandHypothesis& base,
                                         const StandHints& hints);

// Richer laws of the same kind, from where the plain one ended: no linear prediction from nothing finds them.
std::vector<StandEffect> list_richer(const StandProblem& problem, const StandEffect& effect);

// Effects without a neutral start, and starts far from it: a slope at none says nothing about them.
bool starts_away(const StandEffect& effect);

// Effects that multiply a noisy signal: rates, accelerations, efforts, moments. Positions are too quiet to matter.
bool adds_noise(StandId id);

// One quantity written in axes that somebody chose: a force, an offset, a slope.
bool is_vector(StandId id);

// Soles that give, from none.
StandEffect make_soft_soles(const StandProblem& problem);

// Parameters that define an effect; what else is fitted with it may be ill-determined in one recording.
bool is_main(StandId id, size_t parameter);

// Within what can be: positive stiffness, scales that a sensor can have.
bool is_sensible(const StandProblem& problem, const StandEffect& effect);
bool are_sensible(const StandProblem& problem, const StandHypothesis& hypothesis);

// [rad/(N m)] The most that ground and sole give about a foot's roll (axis 0) or pitch: kContact about the sole's short
// edge, more about the long one. Straight down [m/N]: find_sinking.
double find_give(const StandFoot& foot, int axis);
double find_sinking(const StandFoot& foot);

// How much of a parameter the ground may be to blame for, whatever the recordings say: what gives under the feet looks
// like soles, or like transmissions of the leg about the same axis. An effect is sure of what exceeds that only.
double find_bound(const StandProblem& problem, const StandEffect& effect, size_t parameter);

// Minus the logarithm of how much likelier than here an effect of this kind is at the likeliest place, before anything
// is recorded: of links that move alike (hips and a waist that hardly turns) the heavy one carries the load.
double find_doubt(const StandProblem& problem, const StandEffect& effect);

// Standard deviation of what is known beforehand of a parameter about its neutral value; 0: nothing.
double find_prior(const StandProblem& problem, const StandEffect& effect, size_t parameter);

}  // namespace hrp::diagnosis::standing
