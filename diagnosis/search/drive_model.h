// SPDX-License-Identifier: BSD-3-Clause
// The drive of one joint, all others taken as recorded: which of a drive's effects together predict best what they were
// not fitted to, and which of them are certain.
#pragma once

#include "diagnosis/search/drive_linear.h"

namespace hrp::diagnosis {

struct DriveModel {
  Hypothesis effects;
  std::vector<double> worth;  // by effect: factor of the held-out error without it; 0 where it is not certain
  std::vector<std::vector<double>> std;  // by effect, by parameter
  Hypothesis rivals;                     // effects that would do as well as one of them
  std::vector<std::string> doubts;       // by effect: why it is not certain, empty where it is
};

// `problem` must have nominal paths; its view is set here. `held` are the recordings to judge on.
class DriveSelector {
 public:
  DriveSelector(const Problem& problem, int joint, const std::vector<int>& held);
  DriveSelector(const DriveSelector&) = delete;  // its view points at its own paths
  DriveSelector& operator=(const DriveSelector&) = delete;

  // Root mean square of the joint's residuals with no effect, of the recording that shows least.
  double calc_nominal_rms() const;
  DriveModel select();
  // Fills worth, doubts and rivals of a model fitted elsewhere.
  void judge(DriveModel* model) const;

 private:
  struct Fit {
    Hypothesis effects;
    double train = 1e300, cross = 1e300, held = 1e300;
    bool ok = false;
    double merit() const;  // what it leaves of what it was not fitted to: other stretches, held-out recordings
  };
  struct Split {
    const char* name;
    bool of_regime;  // else of time or recording
    GroupOf part;
  };

  Hypothesis make_start() const;
  double find_effort(int recording, size_t k) const;
  Fit try_fit(const Hypothesis& start, int iterations) const;
  std::vector<Effect> list_candidates(const Hypothesis& model) const;
  std::vector<Hypothesis> list_variants(const Hypothesis& model) const;
  std::vector<std::pair<double, Effect>> probe(const Hypothesis& model) const;
  std::vector<Hypothesis> list_simpler(const Hypothesis& model) const;
  Hypothesis leave_out(const Hypothesis& model, size_t effect) const;
  void grow(Fit* model) const;
  void prune(Fit* model) const;
  std::vector<Split> list_splits() const;
  std::string find_doubt(const Linear& linear, const Hypothesis& effects, size_t at,
                         const std::vector<Slot>& slots) const;
  std::string find_nonsense(const Effect& effect) const;
  bool is_nonsense(const Hypothesis& effects) const;
  bool knows_effort() const;
  std::string find_rival(const Effect& effect, const Fit& rest, double cross, double held, Hypothesis* rivals) const;
  std::string find_company(const Linear& linear, const Hypothesis& effects, size_t at,
                           const std::vector<Slot>& slots) const;
  std::string compare(const PartStep& a, const PartStep& b, long slot, double size, bool* tells) const;

  Problem problem_;
  int joint_;
  std::vector<int> held_;
  double middle_ = 0.0, swing_ = 0.0;  // mean position, largest distance from it
};

}  // namespace hrp::diagnosis
