// SPDX-License-Identifier: BSD-3-Clause
// State of the search of search.h. Rounds: search.cpp; candidates: screen.cpp; certainty: certainty.cpp,
// alternatives.cpp.
#pragma once

#include <algorithm>
#include <optional>
#include <utility>

#include "diagnosis/estimate/significance.h"
#include "diagnosis/search/search.h"
#include "diagnosis/standing/search.h"

namespace hrp::diagnosis::standing {

// Least gain in score of an effect. Score / kCorrelated is a log-likelihood ratio of independent samples, and 13.1 =
// ln(500 / 1e-3): 500 starts, one false effect in a thousand robots.
constexpr double kGain = kCorrelated * 13.1;
constexpr double kRicher = 40;  // score gain of a richer law at the same place
// Most effects in total. Drives of a robot are alike, so an effect of one joint may occur at others.
constexpr size_t kMostAlike = 12;

inline bool is_same(const Effect& a, const Effect& b) { return a.id == b.id && a.place == b.place; }

class StandSearcher {
 public:
  StandSearcher(const StandProblems& problems, int jobs, const Progress& progress)
      : problems_(problems),
        p_(problems.all),
        coarse_(make_coarse(p_)),
        coarse_even_(make_coarse(problems.even)),
        coarse_odd_(make_coarse(problems.odd)),
        judge_(p_),
        jobs_(jobs),
        progress_(progress) {
    out_.channels = judge_.list();
    for (size_t r = 0; r < p_.recordings.size(); ++r) all_.push_back(r);
  }

  StandOutcome run();

 private:
  size_t channels() const { return out_.channels.size(); }
  static double worst(const StandFit& fit) { return *std::max_element(fit.channel_rms.begin(), fit.channel_rms.end()); }

  bool is_full() const;
  void extend();
  void start_with_soles();
  void start_with_runner_up();
  bool is_explained() const;
  bool predicts_worse(const StandFit& fit) const;
  bool add_effect();
  void enrich_effects();
  bool is_richer(const StandFit& fit, size_t effect) const;
  std::vector<Effect> list_next(const StandFit& so_far, const Evaluation& base) const;
  std::vector<StandTrial> try_candidates(const StandFit& so_far) const;
  struct Screen {  // results on coarse samples that all candidates share
    Evaluation base, even, odd;
    std::vector<double> noise;
    double score = 0, offset = 0;  // score of the fit so far; offset: minus the score of thinned complete samples
    SharedColumns columns, even_columns, odd_columns;
  };
  Screen prepare_screen(const StandFit& so_far) const;
  Eigen::VectorXd find_step(const StandFit& so_far, const Hypothesis& h, const std::vector<Derivative>& added,
                            const Screen& shared) const;
  double find_gain_either_way(const StandFit& so_far, Hypothesis h) const;
  StandFit fit_trial(const StandFit& so_far, const Hypothesis& h, int iterations) const;
  StandTrial screen(const StandFit& so_far, const Effect& candidate, const Screen& shared) const;
  std::vector<double> find_noise_of(const Hypothesis& h, const Screen& shared) const;
  StandFit judge(const Hypothesis& h) const;
  void update_noise(const Hypothesis& h);
  StandFit finish(const StandFit& so_far, const Hypothesis& hypothesis) const;
  StandFit judge_again(const StandFit& fit) const;
  double find_deviations(double normal) const;
  bool has_moving_feet() const;  // positions of the feet, relative to ground or each other, exceed their noise
  bool is_significant(const StandFit& fit) const;
  StandFit find_significant(const std::vector<StandTrial>& trials) const;
  bool exceeds_ground(const StandFit& fit) const;
  std::optional<Effect> find_load(size_t effect) const;
  std::optional<Effect> find_weight(size_t effect) const;
  std::vector<Effect> find_displaced(size_t effect) const;
  void exchange_effects(bool all);
  void look_below_noise();
  void find_indistinguishable();
  StandFit fit_instead(size_t effect, const Effect& other) const;
  void weigh_alternatives();
  void doubt();
  bool is_consistent(size_t effect) const;
  bool explains_its_part(size_t effect) const;
  bool is_balanced() const;
  bool has_equal_drives() const;
  bool is_coupled(size_t effect) const;
  std::vector<std::pair<size_t, size_t>> list_undone(const Hypothesis& h) const;
  void refuse_couplings();
  void refuse_uneven_friction();
  void refuse_bundles();
  size_t find_effort_channel(int joint) const;  // channels() if the joint has no effort

  const StandProblems& problems_;
  const StandProblem& p_;
  StandProblem coarse_, coarse_even_, coarse_odd_;  // a third of the samples, to rank candidates
  StandJudge judge_;
  int jobs_;
  Progress progress_;
  StandOutcome out_;
  std::vector<StandTrial> first_round_;  // before any effect was found
  std::vector<size_t> all_;
  StandHints hints_;
  double slip_spread_ = 0, significant_ = 0;
  Eigen::Vector2d give_{0, 0};  // [rad] standard deviation of the feet's roll and pitch from contact stiffness
};

}  // namespace hrp::diagnosis::standing
