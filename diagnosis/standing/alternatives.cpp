// SPDX-License-Identifier: BSD-3-Clause
// What else may be in the place of an effect that was found, and what follows for the values of the others.
#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/standing/free_play.h"
#include "diagnosis/standing/searcher.h"

namespace hrp::diagnosis::standing {
namespace {

// Coefficients of effect k.
Eigen::Map<const Eigen::VectorXd> map_values(const StandFit& fit, size_t k) {
  return {fit.hypothesis[k].p.data(), static_cast<long>(fit.hypothesis[k].p.size())};
}

}  // namespace

void StandSearcher::find_indistinguishable() {
  for (size_t i = 0; i < out_.chosen.hypothesis.size(); ++i) {
    out_.indistinguishable.emplace_back();
    const Effect& found = out_.chosen.hypothesis[i];
    for (size_t k = 0; i < out_.rounds.size() && k < out_.rounds[i].size(); ++k) {
      const StandTrial& t = out_.rounds[i][k];
      const Effect& e = t.fit.hypothesis[i];
      if (t.fit.score < 1e299 && t.probability > kMinor && !is_same(e, found))
        out_.indistinguishable.back().push_back(e);
    }
    const auto is_listed = [&](EffectId id) {
      const std::vector<Effect>& others = out_.indistinguishable.back();
      return std::any_of(others.begin(), others.end(), [&](const Effect& e) { return e.id == id; });
    };
    for (const std::optional<Effect>& load : {find_load(i), find_weight(i)}) {
      if (load && !is_listed(load->id)) out_.indistinguishable.back().push_back(*load);
    }
    for (const Effect& e : find_displaced(i)) {
      const std::vector<Effect>& others = out_.indistinguishable.back();
      if (std::none_of(others.begin(), others.end(), [&](const Effect& o) { return is_same(o, e); }))
        out_.indistinguishable.back().push_back(e);
    }
    if (!get_effect(found.id).felt_elsewhere) continue;
    const auto joint = static_cast<size_t>(found.place.index);
    if (!may_be_play(p_, evaluate(p_, out_.chosen.hypothesis), joint, found.p[0])) continue;
    out_.indistinguishable.back().push_back({EffectId::kBacklash, found.place, {2 * std::abs(found.p[0]), 0, 0, 0}});
  }
}

// The chosen effects with another one in the place of effect i, fitted.
StandFit StandSearcher::fit_instead(size_t i, const Effect& other) const {
  Hypothesis h = out_.chosen.hypothesis;
  h.erase(h.begin() + static_cast<long>(i));
  h.push_back(other);
  StandFit fit = fit_trial(out_.chosen, h, 3);
  std::rotate(fit.hypothesis.begin() + static_cast<long>(i), fit.hypothesis.end() - 1, fit.hypothesis.end());
  return fit;
}

// An effect has the value that it has beside one of several others. Its interval must hold what it is beside each of
// them.
void StandSearcher::weigh_alternatives() {
  std::vector<Eigen::VectorXd> reach;
  for (const Effect& e : out_.chosen.hypothesis) reach.push_back(Eigen::VectorXd::Zero(static_cast<long>(e.p.size())));
  for (size_t i = 0; i < out_.indistinguishable.size() && reach.size() > 1; ++i) {
    std::vector<StandFit> fits;
    std::vector<Effect> unfitted;
    for (const Effect& e : out_.indistinguishable[i]) {
      fits.push_back(fit_instead(i, e));
      if (fits.back().score >= 1e299) {
        fits.pop_back();
        unfitted.push_back(e);
      }
    }
    out_.indistinguishable[i] = unfitted;
    for (const StandFit& fit : fits) {
      out_.indistinguishable[i].push_back(fit.hypothesis[i]);
      for (size_t k = 0; k < reach.size(); ++k) {
        if (k != i) reach[k] = reach[k].cwiseMax((map_values(fit, k) - map_values(out_.chosen, k)).cwiseAbs());
      }
    }
  }
  for (size_t k = 0; k < out_.chosen.std.size(); ++k) {
    Eigen::VectorXd& std = out_.chosen.std[k];
    for (long n = 0; n < std.size(); ++n) std(n) = std::hypot(std(n), reach[k](n) / kNinetyFive);
  }
}

}  // namespace hrp::diagnosis::standing
