// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/nearby.h"

namespace hrp::diagnosis {
namespace {

// Multiplies one parameter by a factor as long as the fit of the training recordings improves.
void walk(const Problem& problem, size_t effect, size_t index, double factor, Hypothesis* best, double* lowest) {
  const EffectParameter& info = list_infos((*best)[effect].id)[index];
  while (true) {
    Hypothesis trial = *best;
    double& value = trial[effect].p[index];
    value *= factor;
    if (value < info.low || value > info.high) return;
    const Score score = calc_score(problem, trial, problem.train);
    if (!score.ok || score.chi2 >= *lowest) return;
    *lowest = score.chi2;
    *best = trial;
  }
}

}  // namespace

Hypothesis try_nearby(const Problem& problem, Hypothesis best, double finest) {
  const Score start = calc_score(problem, best, problem.train);
  double lowest = start.ok ? start.chi2 : 1e300;
  for (size_t i = 0; i < best.size(); ++i) {
    const std::vector<EffectParameter>& infos = list_infos(best[i].id);
    for (size_t k = 0; k < infos.size(); ++k) {
      if (!infos[k].scanned && !infos[k].walked) continue;
      for (double factor : {3.0, 1.5, 1.2, kFinestFactor}) {
        if (infos[k].scanned && factor < finest) break;
        walk(problem, i, k, 1.0 / factor, &best, &lowest);
        walk(problem, i, k, factor, &best, &lowest);
      }
    }
  }
  return best;
}

}  // namespace hrp::diagnosis
