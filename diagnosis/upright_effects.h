// SPDX-License-Identifier: BSD-3-Clause
// Every effect that a standing robot's recordings may hide: how it is written, started, varied, bounded.
#pragma once

#include "diagnosis/upright_terms.h"

namespace hrp::diagnosis::upright {

struct StandInfo {
  StandId id;
  const char* effect;                   // name in the report
  std::vector<const char*> parameters;  // names; "" is a nuisance
  std::vector<const char*> units;
  std::vector<double> neutral;          // value that changes nothing
  std::vector<double> step;             // for finite differences
  bool positive = false;                // first parameter must not fall below its neutral value
};
const StandInfo& get_stand_info(StandId id);

// What may be added to a hypothesis. Effects with a parameter that no linear fit finds (a Stribeck velocity, the
// periods of cogging) come several times, with different starts.
std::vector<StandEffect> list_candidates(const StandProblem& problem, const StandHypothesis& base, double slip_ratio);

// Within what can be: positive stiffness, scales that a sensor can have.
bool is_sensible(const StandProblem& problem, const StandEffect& effect);
bool are_sensible(const StandProblem& problem, const StandHypothesis& hypothesis);

// Standard deviation of what is known beforehand of a nuisance about its neutral value; 0: nothing.
double find_prior(const StandProblem& problem, const StandEffect& effect, size_t parameter);

}  // namespace hrp::diagnosis::upright
