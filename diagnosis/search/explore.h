// SPDX-License-Identifier: BSD-3-Clause
// The wide search: sets of effects, grown one effect at a time, compared along the recorded paths (bodies.h). There a
// joint's readings depend on the effects at that joint only, and on those that all joints feel (masses, forces, encoder
// offsets, links moved by elastic transmissions); so most fits are of one joint, and are shared by all sets alike
// there.
#pragma once

#include <map>
#include <memory>

#include "diagnosis/search/fit.h"
#include "diagnosis/search/starts.h"

namespace hrp::diagnosis {

class Explorer {
 public:
  // Needs the problem's nominal paths.
  explicit Explorer(const Problem& problem);

  // The empty set.
  const Lead& nominal() const { return nominal_; }

  // A set as it is.
  Lead make_lead(const Hypothesis& hypothesis);

  // The best sets that have one effect more than one of `from`, best first, none twice; at `quiet` joints (by joint)
  // none is added that would show in their readings alone.
  std::vector<Lead> grow(const std::vector<Lead>& from, size_t candidates, const std::vector<char>& quiet);

 private:
  struct Local {
    Hypothesis effects;  // at one joint
    double train = 1e300, held = 1e300;
  };
  struct Task {
    size_t parent;
    Effect start;
  };
  // Paths, joint, and the effects there; of clocks, which run in all joints, their values, too.
  using LocalKey = std::tuple<const Paths*, int, std::vector<std::tuple<EffectId, Place, double>>>;

  double calc_left(Problem& p, const FitResult& result) const;
  Effect start_from_rotor(const Problem& problem, Hypothesis with, const FitOptions& options) const;
  Local fit_local(Problem& p, const Lead& parent, const Effect& start) const;
  Lead add_local(const Lead& parent, const Effect& start, const Local& local) const;
  Lead add_shared(Problem& p, const Lead& parent, const Effect& start) const;
  void measure(Problem& p, Lead* lead) const;
  std::vector<Effect> choose_starts(const Problem& problem, const Hypothesis& hypothesis, size_t at, bool scanned_only,
                                    size_t count) const;
  void choose_start(const Problem& problem, Hypothesis* hypothesis, size_t at, bool scanned_only) const;
  void choose_again(const Problem& problem, const FitOptions& options, FitResult* result) const;
  void forget(const std::vector<Lead>& from, const std::vector<Lead>& leads);
  LocalKey make_key(const Lead& parent, const Effect& start) const;

  std::vector<Problem> workers_;  // one a thread; coarser steps than the final fits
  std::vector<int> held_;
  Lead nominal_;
  std::map<LocalKey, Local> locals_;
  std::vector<std::shared_ptr<const Paths>> kept_;  // paths are keys: they must not move
};

}  // namespace hrp::diagnosis
