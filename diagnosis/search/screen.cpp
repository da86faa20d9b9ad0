// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/screen.h"

#include <algorithm>
#include <map>

#include "diagnosis/search/regression.h"
#include "diagnosis/search/signature.h"

namespace hrp::diagnosis {
namespace {

// Gain and coefficients of the columns of one shape alone.
Regression solve_columns(const Signatures& s, const std::vector<int>& columns) {
  return solve_gram(s.gram(columns, columns), s.projection(columns));
}

}  // namespace

Screening screen(const Problem& problem, const Hypothesis& base, const Paths* paths) {
  const Signatures s = calc_signatures(problem, base, paths);
  Screening screening;
  screening.chi2 = s.chi2;
  screening.count = s.count;
  screening.joint_chi2 = s.joint_chi2;
  std::map<std::pair<EffectId, Place>, Candidate> best;
  for (const Shape& shape : s.shapes) {
    const Regression solution = solve_columns(s, shape.columns);
    std::vector<double> x(solution.x.data(), solution.x.data() + solution.x.size());
    Candidate candidate;
    candidate.start = {shape.id, shape.place, {}};
    if (!shape.make_start(x, &candidate.start.p)) continue;
    candidate.gain = solution.gain;
    candidate.columns = shape.columns;
    Candidate& slot = best[{shape.id, shape.place}];
    if (slot.start.p.empty() || candidate.gain > slot.gain) slot = candidate;
  }
  for (const auto& item : best) screening.candidates.push_back(item.second);
  std::stable_sort(screening.candidates.begin(), screening.candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.gain > b.gain; });
  return screening;
}

}  // namespace hrp::diagnosis
