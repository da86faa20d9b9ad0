// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/drive_search.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "diagnosis/search/drive_model.h"
#include "diagnosis/search/format.h"
#include "diagnosis/search/nearby.h"

namespace hrp::diagnosis {
namespace {

// Times the noise that every joint must miss each of its recordings by: twice what separates noise from a mismatch,
// squared.
constexpr double kEveryJoint = 3.0;
// Of the worst joint: what a sound joint shows of its neighbour's errors through smoothing and coupling stays below.
constexpr double kEcho = 0.05;
// Times its noise that a joint may leave where a rotor is named. One behind play or a shaft that gives shows as a rotor of
// the same inertia in every part; these are no candidates here, because far from their true values they do not help.
constexpr double kRigid = 2.0;
// Rollouts times joints squared times samples up to which all parameters are fitted once more through the simulation.
constexpr double kPolishWork = 3e7;

class DriveSearch {
 public:
  DriveSearch(const Problem& problem, const Progress& progress, Outcome* outcome)
      : problem_(problem),
        progress_(progress),
        outcome_(*outcome),
        held_(get_judged(problem)) {}

  bool run() {
    Problem along = problem_;
    along.view = {};
    if (along.nominal_paths.empty()) prepare_paths(&along);
    const int n = problem_.experiment->num_joints();
    for (int j = 0; j < n; ++j) selectors_.push_back(std::make_unique<DriveSelector>(along, j, held_));
    models_.resize(static_cast<size_t>(n));
    std::vector<double> rms(static_cast<size_t>(n));
    parallel_for(problem_.jobs, n,
                 [&](int j) { rms[static_cast<size_t>(j)] = selectors_[static_cast<size_t>(j)]->calc_nominal_rms(); });
    const auto [least, most] = std::minmax_element(rms.begin(), rms.end());
    if (*least < std::max(kEveryJoint, kEcho * *most)) return false;
    progress_("every joint misses its recordings: a drive of its own for each");
    parallel_for(problem_.jobs, n,
                 [&](int j) { models_[static_cast<size_t>(j)] = selectors_[static_cast<size_t>(j)]->select(); });
    Trial trial = judge(join());
    say("all drives", trial);
    polish(&trial);
    split(trial);
    parallel_for(problem_.jobs, n,
                 [&](int j) { selectors_[static_cast<size_t>(j)]->judge(&models_[static_cast<size_t>(j)]); });
    doubt_rotors(trial);
    return report(trial);
  }

 private:
  Hypothesis join() const {
    Hypothesis all;
    for (const DriveModel& model : models_) all.insert(all.end(), model.effects.begin(), model.effects.end());
    return all;
  }

  // Through the simulation of the whole robot.
  Trial judge(const Hypothesis& hypothesis) const {
    Trial trial;
    trial.hypothesis = hypothesis;
    trial.refined = true;  // timing stays 0: a drive's loop is far below what is missing here
    trial.train = calc_score(problem_, trial.full(), problem_.train);
    trial.validate = calc_score(problem_, trial.full(), held_);
    if (!trial.train.ok || !trial.validate.ok) return trial;
    trial.rms = trial.validate.rms();
    trial.worst = trial.validate.worst();
    return trial;
  }

  // All parameters together; kept only where the held-out recordings agree.
  void polish(Trial* trial) const {
    double samples = 0.0;
    for (int r : problem_.train)
      samples += static_cast<double>(problem_.experiment->recordings[static_cast<size_t>(r)].size());
    const double n = problem_.experiment->num_joints(),
                 parameters = static_cast<double>(list_slots(trial->hypothesis).size());
    constexpr int kIterations = 8;
    if (trial->hypothesis.empty() || kIterations * (parameters + 2.0) * samples * n * n > kPolishWork) return;
    FitOptions options;
    options.max_iterations = kIterations;
    options.tolerance = 1e-3;
    FitResult result = fit(problem_, trial->hypothesis, problem_.train, options);
    if (!result.ok) return;
    const FitResult again = fit(problem_, try_nearby(problem_, result.hypothesis), problem_.train, options);
    if (again.ok && again.train.chi2 < result.train.chi2) result = again;
    const Trial better = judge(result.hypothesis);
    say("fitted together", better);
    if (better.rms < trial->rms) *trial = better;
  }

  // The polished parameters go back to the joints.
  void split(const Trial& trial) {
    size_t at = 0;
    for (DriveModel& model : models_) {
      for (Effect& effect : model.effects) effect = trial.hypothesis[at++];
    }
  }

  void doubt_rotors(const Trial& trial) {
    for (size_t j = 0; j < models_.size(); ++j) {
      double left = 0.0;
      for (size_t q = 0; q < kQuantities; ++q) left = std::max(left, trial.validate.rms(j * kQuantities + q));
      for (size_t i = 0; i < models_[j].effects.size(); ++i) {
        if (models_[j].effects[i].id != EffectId::kRotorInertia || !models_[j].doubts[i].empty() || left < kRigid) continue;
        models_[j].worth[i] = 0.0;
        models_[j].doubts[i] = "what is left may be its transmission's, which would take its place";
      }
    }
  }

  bool report(Trial trial) {
    std::vector<double> worth;
    std::vector<std::string> doubts;
    bool any = false;
    for (const DriveModel& model : models_) {
      for (size_t i = 0; i < model.effects.size(); ++i) {
        worth.push_back(model.worth[i]);
        doubts.push_back(model.doubts[i]);
        trial.std.push_back(i < model.std.size() ? model.std[i] : std::vector<double>(model.effects[i].p.size(), 0.0));
        any = any || model.worth[i] > 0.0;
        progress_("    " + get_label(*problem_.experiment, model.effects[i]) +
                  format(" %.4g: ", model.effects[i].p[0], 0.0) +
                  (model.doubts[i].empty() ? format("certain, worth %.3g", model.worth[i], 0.0) : model.doubts[i]));
      }
    }
    if (!(trial.rms < outcome_.nominal.rms)) return false;
    for (const DriveModel& model : models_) {
      for (const Effect& rival : model.rivals) outcome_.twins.push_back({rival});
    }
    trial.probability = 1.0;
    outcome_.chosen = trial;
    outcome_.worth = worth, outcome_.doubts = doubts;
    outcome_.partly = any;
    outcome_.modelled = true;
    outcome_.rivals.insert(outcome_.rivals.begin(), trial);
    return true;
  }

  void say(const std::string& what, const Trial& t) const {
    progress_(what + ": train " + format("%.4g, held out %.4g", t.train.rms(), t.rms));
  }

  const Problem& problem_;
  const Progress& progress_;
  Outcome& outcome_;
  std::vector<int> held_;
  std::vector<std::unique_ptr<DriveSelector>> selectors_;
  std::vector<DriveModel> models_;
};

}  // namespace

bool search_drives(const Problem& problem, const Progress& progress, Outcome* outcome) {
  return DriveSearch(problem, progress, outcome).run();
}

}  // namespace hrp::diagnosis
