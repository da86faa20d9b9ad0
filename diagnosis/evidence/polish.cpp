// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/polish.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/estimate/slopes.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/search/fit.h"
#include "diagnosis/search/nearby.h"
#include "diagnosis/simulation/windows.h"

namespace hrp::diagnosis {
namespace {

// Largest speed of the joint in the training recordings [rad/s].
double find_fastest(const Problem& problem, int joint) {
  double fastest = 0.0;
  for (int r : problem.train) {
    for (double v : problem.smooth[static_cast<size_t>(r)].joints[static_cast<size_t>(joint)].qd)
      fastest = std::max(fastest, std::abs(v));
  }
  return fastest;
}

Hypothesis with(Hypothesis own, const Effect& added) {
  own.push_back(added);
  return own;
}

// A joint's dry friction has one displacement, whatever its laws are. None without dry friction.
std::optional<double> get_presliding(const Hypothesis& own) {
  for (const Effect& effect : own) {
    const std::vector<EffectParameter>& infos = list_infos(effect.id);
    for (size_t i = 0; i < infos.size(); ++i) {
      if (infos[i].scanned) return effect.p[i];
    }
  }
  return std::nullopt;
}

Hypothesis with_presliding(Hypothesis own, double displacement) {
  for (Effect& effect : own) {
    const std::vector<EffectParameter>& infos = list_infos(effect.id);
    for (size_t i = 0; i < infos.size(); ++i) {
      if (infos[i].scanned) effect.p[i] = displacement;
    }
  }
  return own;
}

bool is_logged(const Experiment& e, int joint) {
  return std::all_of(e.recordings.begin(), e.recordings.end(),
                     [&](const Recording& r) { return r.joints[static_cast<size_t>(joint)].has(Quantity::kEffort); });
}

// Hypotheses with one additional law, or with a Stribeck curve in place of Coulomb friction. Only a joint with a drive
// (`driven`) has a gain, and only a recorded effort (`logged`) a late log.
std::vector<Hypothesis> list_enriched(const Hypothesis& own, int joint, double fastest, bool commanded, bool driven,
                                      bool logged) {
  std::vector<Hypothesis> list;
  for (size_t i = 0; i < own.size(); ++i) {
    if (own[i].id != EffectId::kCoulomb) continue;
    for (double share : {kMinor, kMinority}) {  // of the fastest speed: where a Stribeck velocity may be
      list.push_back(own);
      list.back()[i] = {
          EffectId::kStribeck, joint, {own[i].p[0], 1.2 * own[i].p[0], share * fastest, 0.0, own[i].p.back()}};
    }
  }
  const auto has = [&](EffectId id) { return contains(own, id, at_joint(joint)); };
  const double instant = kSeveralTimes * kTimeStep;  // [s] so far from zero a lag or a delay has a slope
  const bool timed = !commanded || has(EffectId::kLag) || has(EffectId::kDelay);
  if (!timed) list.push_back(with(own, {EffectId::kLag, joint, {instant}}));
  if (!timed) list.push_back(with(own, {EffectId::kDelay, joint, {instant}}));
  const bool rotor = std::any_of(own.begin(), own.end(), [](const Effect& e) { return get_effect(e.id).rotor >= 0; });
  if (!rotor) list.push_back(with(own, {EffectId::kRotorInertia, joint, {0.0}}));
  if (!has(EffectId::kViscous)) list.push_back(with(own, {EffectId::kViscous, joint, {0.0}}));
  if (!has(EffectId::kLoadFriction))
    list.push_back(with(own, {EffectId::kLoadFriction, joint, {0.0, get_presliding(own).value_or(kPresliding)}}));
  const Place log = at_sensor(joint, Reading::kEffort);
  if (logged && !contains(own, EffectId::kSensorDelay, log))
    list.push_back(with(own, {EffectId::kSensorDelay, log, {instant}}));
  if (driven && !has(EffectId::kTorqueConstant)) list.push_back(with(own, {EffectId::kTorqueConstant, joint, {1.0}}));
  return list;
}

Hypothesis scan_presliding(const JointAlone& alone, const Hypothesis& own) {
  const Score before = alone.score(own);
  Hypothesis best = own;
  double least = before.ok ? before.chi2 : 1e300;
  for (double displacement : kPreslidings) {
    const Hypothesis tried = with_presliding(own, displacement);
    const Score score = alone.score(tried);
    if (score.ok && score.chi2 < least) {
      best = tried;
      least = score.chi2;
    }
  }
  return best;
}

// Applies `change` to the effects of each joint that has some, along the recorded paths of the others. An empty result
// changes nothing.
using ChangeJoint = std::function<Hypothesis(JointAlone* alone, const Hypothesis& own, int joint)>;
Hypothesis change_joints(const Problem& problem, const Hypothesis& model, const ChangeJoint& change) {
  const Hypothesis links = take_links(model);
  const JointPaths paths(problem, links);
  const int n = problem.experiment->num_joints();
  std::vector<Hypothesis> changed(static_cast<size_t>(n));
  parallel_for(problem.jobs, n, [&](int j) {
    const Hypothesis own = take_joint(model, j);
    if (own.empty()) return;
    JointAlone alone(paths, j);
    changed[static_cast<size_t>(j)] = change(&alone, own, j);
    if (changed[static_cast<size_t>(j)].empty()) changed[static_cast<size_t>(j)] = own;
  });
  Hypothesis out = links;
  for (const Hypothesis& own : changed) out.insert(out.end(), own.begin(), own.end());
  return out;
}

}  // namespace

Hypothesis enrich(const JointAlone& alone, Hypothesis own, int joint) {
  const double fastest = find_fastest(alone.problem, joint);
  const bool commanded = !is_effort_driven(*alone.problem.experiment),
             driven = alone.problem.experiment->robot.tree.joint(joint).actuated;
  const bool logged = is_logged(*alone.problem.experiment, joint);
  const Score before = alone.score(own);
  double least = before.chi2;
  if (!before.ok || least < kNoiseLeft * kNoiseLeft * before.count) return own;
  for (int round = 0; round < kFewRounds; ++round) {  // one additional law each
    Hypothesis best;
    double limit = (1.0 - kBlur) * least;
    for (const Hypothesis& h : list_enriched(own, joint, fastest, commanded, driven, logged)) {
      const FitResult tried = alone.fit(h, kFewRounds);
      if (tried.ok && tried.train.chi2 < limit) {
        best = tried.hypothesis;
        limit = tried.train.chi2;
      }
    }
    if (best.empty()) break;
    own = best;
    least = limit;
  }
  const Hypothesis fitted = alone.fit_to_the_end(own);
  return fitted.empty() ? own : fitted;
}

Hypothesis split_asymmetry(const Hypothesis& model) {
  Hypothesis out = model;
  const EffectId constant = find_effect("constant_torque")->id;
  for (const Effect& dry : model) {
    if (dry.id != EffectId::kCoulomb || dry.p[1] == 0.0) continue;
    const auto there =
        std::find_if(out.begin(), out.end(), [&](const Effect& e) { return e.id == constant && e.place == dry.place; });
    if (there != out.end())
      there->p[0] += dry.p[0] * dry.p[1];
    else
      out.push_back({constant, dry.place, {dry.p[0] * dry.p[1]}});
  }
  for (Effect& effect : out) {
    if (effect.id == EffectId::kCoulomb) effect.p[1] = 0.0;
  }
  return out;
}

Hypothesis find_preslidings(const Problem& problem, const Hypothesis& model) {
  return change_joints(problem, model, [](JointAlone* alone, const Hypothesis& own, int) {
    return get_presliding(own) ? scan_presliding(*alone, own) : own;
  });
}

Hypothesis drop_ripples_of_logs(const Problem& problem, const Hypothesis& model) {
  if (is_effort_driven(*problem.experiment)) return model;
  return change_joints(problem, model, [](JointAlone* alone, Hypothesis own, int) {
    for (size_t i = own.size(); i-- > 0;) {
      if (own[i].id != EffectId::kCogging) continue;
      Hypothesis without = own;
      without.erase(without.begin() + static_cast<long>(i));
      const Score with = alone->score(own), score = alone->score(without);
      if (score.ok && (!with.ok || score.chi2 < with.chi2)) own = without;
    }
    return own;
  });
}

Hypothesis polish_joints(const Problem& problem, const Hypothesis& model, const TorqueData* efforts, bool enriched) {
  std::optional<EffortRows> rows;
  if (efforts) rows.emplace(*problem.experiment, *efforts, take_links(model));
  return split_asymmetry(change_joints(problem, model, [&](JointAlone* alone, const Hypothesis& own, int joint) {
    if (rows) alone->residuals = rows->add_to(alone->residuals, problem.train, own, joint);
    return enriched ? enrich(*alone, own, joint) : alone->fit_to_the_end(own);
  }));
}

double calc_whole_work(const Problem& problem, const Hypothesis& model, int iterations) {
  double seconds = 0.0, parameters = 0.0, squares = 0.0;
  for (int r : problem.train) seconds += problem.experiment->recordings[static_cast<size_t>(r)].duration();
  for (const Effect& e : model) parameters += static_cast<double>(e.p.size());
  for (const Subtree& s : problem.subtrees) squares += std::pow(s.joints.size(), 2);
  if (problem.subtrees.empty()) squares = std::pow(problem.experiment->num_joints(), 2);
  return iterations * parameters * squares * seconds / problem.options.max_step;
}

Hypothesis polish_whole(const Problem& problem, const Hypothesis& model, const CalcResiduals& residuals,
                        int iterations) {
  // Some two minutes of one core. Twelve joints of four legs for 15 s take 2e8, six of an arm for 70 s 2e9.
  if (calc_whole_work(problem, model, iterations) > kHalf * kUsualWork) return model;
  FitOptions options;
  options.max_iterations = iterations;
  options.tolerance = kAgreement;
  const FitResult result = fit(residuals, problem.jobs, model, problem.train, options);
  return result.ok ? split_asymmetry(result.hypothesis) : model;
}

CalcResiduals make_window_residuals(const Problem& problem) {
  return [&problem](const Hypothesis& h, int recording, std::vector<double>* out) {
    const Experiment& e = *problem.experiment;
    const size_t r = static_cast<size_t>(recording), width = problem.weights.size();
    const Recording& data = e.recordings[r];
    std::vector<double> readings;
    if (!simulate_windows(make_plant(e, h), e, problem.smooth[r], recording, &readings)) return false;
    out->assign(data.size() * width, 0.0);
    for (size_t c = 0; c < width; ++c) {
      const std::vector<double>& column = data.joints[c / kQuantities].signal[c % kQuantities];
      for (size_t k = 0; k < column.size(); ++k) {
        const double left = column[k] - readings[k * width + c];
        if (std::isfinite(left)) (*out)[k * width + c] = left * problem.weights[c];
      }
    }
    return true;
  };
}

}  // namespace hrp::diagnosis
