// SPDX-License-Identifier: BSD-3-Clause
// Lists the parameters of all effects of a hypothesis: the columns of a fit. An effect is any struct with values in
// `p`.
#pragma once

#include <cstddef>
#include <vector>

namespace hrp::diagnosis {

template <class Info>
struct Parameter {
  std::size_t effect, index;  // its value is hypothesis[effect].p[index]
  const Info* info;
};

// In the order of the hypothesis. `find_infos(effect)` describes an effect's parameters; keep(index of the effect,
// info) selects them.
template <class Info, class Hypothesis, class FindInfos, class Keep>
std::vector<Parameter<Info>> flatten(const Hypothesis& hypothesis, const FindInfos& find_infos, const Keep& keep) {
  std::vector<Parameter<Info>> list;
  for (std::size_t e = 0; e < hypothesis.size(); ++e) {
    const std::vector<Info>& infos = find_infos(hypothesis[e]);
    for (std::size_t i = 0; i < infos.size(); ++i) {
      if (keep(e, infos[i])) list.push_back({e, i, &infos[i]});
    }
  }
  return list;
}

template <class Info, class Hypothesis, class FindInfos>
std::vector<Parameter<Info>> flatten(const Hypothesis& hypothesis, const FindInfos& find_infos) {
  return flatten<Info>(hypothesis, find_infos, [](std::size_t, const Info&) { return true; });
}

}  // namespace hrp::diagnosis
