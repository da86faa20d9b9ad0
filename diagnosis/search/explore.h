// SPDX-License-Identifier: BSD-3-Clause
// Searches sets of effects, grown by one effect at a time, with joints simulated along recorded paths (bodies.h). There
// a joint's readings depend only on effects at that joint and on shared ones (masses, forces, encoder offsets, links
// behind elastic transmissions). Therefore most fits concern one joint, and all sets with the same effects at that
// joint share the fit.
#pragma once

#include <map>
#include <memory>

#include "diagnosis/search/fit.h"
#include "diagnosis/search/starts.h"

namespace hrp::diagnosis {

class Explorer {
 public:
  // Requires the problem's nominal paths.
  explicit Explorer(const Problem& problem);

  // The empty set.
  const Lead& nominal() const { return nominal_; }

  // Judges a set without fitting it.
  Lead make_lead(const Hypothesis& hypothesis);

  // The best sets with one effect more than one of `from`, best first, without duplicates. Adds no effect that changes
  // only the readings of a `quiet` joint (flag by joint).
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
  // Key of a local fit: paths, joint, the effects there. Clock effects act on all joints, so their values are in the
  // key.
  using LocalKey = std::tuple<const Paths*, int, std::vector<std::tuple<EffectId, Place, double>>>;

  std::vector<Task> list_tasks(const std::vector<Lead>& from, size_t candidates, const std::vector<char>& quiet);
  void fit_tasks(const std::vector<Lead>& from, const std::vector<Task>& tasks, std::vector<Lead>* leads);
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

  std::vector<Problem> workers_;  // one per thread; coarser steps than final fits
  std::vector<int> held_;
  Lead nominal_;
  std::map<LocalKey, Local> locals_;
  std::vector<std::shared_ptr<const Paths>> kept_;  // keys contain their addresses, so they must not move
};

}  // namespace hrp::diagnosis
