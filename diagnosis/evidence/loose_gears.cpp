// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/loose_gears.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/estimate/robust.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/best_model.h"
#include "diagnosis/evidence/polish.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/model/tree.h"
#include "diagnosis/report/json.h"
#include "diagnosis/report/report.h"
#include "diagnosis/search/nearby.h"
#include "diagnosis/search/significance.h"
#include "diagnosis/search/starts.h"

namespace hrp::diagnosis {
namespace {

// Steps from one start of a gap to the next, a factor of three: teeth that meet at another time fit nothing, so a fit
// does not find its way from a gap that is a third wrong.
constexpr double kGapSteps[] = {1.0, 1.33, 1.78, 2.37};

// Starts of a transmission, with more gaps if it has one.
std::vector<Effect> list_starts(const Effect& law) {
  std::vector<Effect> options = list_options(law, false);
  if (!list_infos(law.id)[0].walked) return options;
  std::vector<Effect> out;
  for (const Effect& option : options) {
    for (double step : kGapSteps) {
      Effect one = option;
      one.p[0] *= step;
      if (std::none_of(out.begin(), out.end(), [&](const Effect& e) { return e.p == one.p; })) out.push_back(one);
    }
  }
  return out;
}

// A joint's effects and their chi-square in the training recordings.
struct Fitted {
  Hypothesis effects;
  double cost = 1e300;
};

// Chi-square that the best rigid gear leaves: training, held-out, and each recording.
struct Rigid {
  double train = 1e300, held = 1e300;
  std::vector<double> each;
};

// Effects of links that the joint carries were fitted with a rigid gear. They may stand for its play.
Hypothesis drop_carried(const TreeSpec& tree, Hypothesis model, int joint) {
  model.erase(std::remove_if(model.begin(), model.end(),
                             [&](const Effect& e) {
                               return e.place.kind == PlaceKind::kLink && is_above(tree, joint + 1, e.place.index);
                             }),
              model.end());
  return model;
}

// One joint.
class Gear {
 public:
  Gear(const JointPaths& paths, const Hypothesis& model, int joint)
      : joint_(joint), alone_(paths, joint), own_{take_joint(model, joint)} {}

  const Rigid& rigid() const { return rigid_; }

  // `other`: the same gear, rigid, beside other links.
  std::optional<LooseGear> run(const Rigid& other = {}) {
    const auto rotor = std::find_if(own_.effects.begin(), own_.effects.end(), is_rigid_rotor);
    if (rotor == own_.effects.end() || is_quiet(own_.effects)) return std::nullopt;
    at_ = static_cast<size_t>(rotor - own_.effects.begin());
    own_ = judge(own_.effects);
    improve(&own_, alone_.fit(own_.effects, kFewRounds).hypothesis);
    rigid_ = other;
    take_rigid();
    std::vector<Fitted> loose;
    for (const Effect& law : list_transmissions(joint_, get_rotor(own_.effects[at_]))) {
      for (Fitted& fitted : loosen(law)) {
        if (fitted.cost < kNearlyAll * rigid_.train) loose.push_back(std::move(fitted));
      }
    }
    if (loose.empty()) return std::nullopt;
    improve(&own_, alone_.fit_to_the_end(own_.effects));
    take_rigid();
    for (Fitted& fitted : loose) improve(&fitted, alone_.fit_to_the_end(fitted.effects));
    sort(&loose);
    // The rigid gear's joint has been offered richer laws before.
    const double limit = (1.0 + kDetail) * loose[0].cost;
    for (Fitted& fitted : loose) {
      if (fitted.cost < limit) improve(&fitted, enrich(alone_, fitted.effects, joint_));
    }
    sort(&loose);
    return describe(loose, find_simplest(loose));
  }

 private:
  static void sort(std::vector<Fitted>* loose) {
    std::stable_sort(loose->begin(), loose->end(), [](const Fitted& a, const Fitted& b) { return a.cost < b.cost; });
  }

  void take_rigid() {
    if (!(own_.cost < rigid_.train)) return;
    rigid_ = {own_.cost, get_held(own_.effects), {}};
    for (int r : list_recordings()) rigid_.each.push_back(alone_.score(own_.effects, {r}).chi2);
  }

  std::vector<int> list_recordings() const {
    std::vector<int> recordings = alone_.problem.train;
    recordings.insert(recordings.end(), alone_.problem.validate.begin(), alone_.problem.validate.end());
    return recordings;
  }

  // Whether each reading of the joint leaves no more than its noise, or is as predicted to what two integrators agree.
  bool is_quiet(const Hypothesis& h) const {
    const Score score = calc_score(alone_.problem, h, alone_.problem.validate);
    if (!score.ok || score.rms() < kAboveNoise) return true;
    for (int q = 0; q < kQuantities; ++q) {
      const size_t channel = static_cast<size_t>(joint_) * kQuantities + static_cast<size_t>(q);
      const double left = score.rms(channel),
                   spread = calc_channel_spread(*alone_.problem.experiment, alone_.problem.validate, channel);
      if (left > std::max(kAboveNoise, kAgreement * spread * alone_.problem.weights[channel])) return false;
    }
    return true;
  }

  Fitted judge(const Hypothesis& h) const {
    const Score score = alone_.score(h);
    return {h, score.ok ? score.chi2 : 1e300};
  }

  double get_held(const Hypothesis& h) const { return alone_.score(h, alone_.problem.validate).chi2; }
  const Effect& get_law(const Fitted& loose) const { return loose.effects[at_]; }

  // The joint with this transmission, from the best starts after a few iterations, best first.
  std::vector<Fitted> loosen(const Effect& law) const {
    std::vector<std::pair<double, Hypothesis>> tries;
    const bool gap = list_infos(law.id)[0].walked;
    const size_t count = gap ? kLookedAt : 1;
    for (const Effect& option :
         choose_options(alone_.problem, alone_.problem.train, own_.effects, at_, list_starts(law), count)) {
      Hypothesis start = own_.effects;
      start[at_] = option;
      // Stiffness and damping of the teeth are as far off as the gap: a walk along each leads to where a fit can begin.
      if (gap) start = try_nearby(alone_.problem, start, kCoarseFactor);
      FitResult tried = alone_.fit(start, kFewRounds);
      if (tried.ok) tries.push_back({tried.train.chi2, std::move(tried.hypothesis)});
    }
    std::stable_sort(tries.begin(), tries.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    // A few iterations do not tell the best start for certain.
    tries.resize(std::min(tries.size(), kLookedAt));
    std::vector<Fitted> out;
    for (const auto& [chi2, effects] : tries) out.push_back(judge(effects));
    return out;
  }

  void improve(Fitted* fitted, const Hypothesis& other) const {
    if (other.empty()) return;
    Fitted better = judge(other);
    if (better.cost < fitted->cost) *fitted = std::move(better);
  }

  // Index of the law with the fewest parameters among those that fit about as well as the best, which is first.
  size_t find_simplest(const std::vector<Fitted>& loose) const {
    size_t best = 0;
    for (size_t i = 1; i < loose.size(); ++i) {
      if (loose[i].cost < (1.0 + kDetail) * loose[0].cost && get_law(loose[i]).p.size() < get_law(loose[best]).p.size())
        best = i;
    }
    return best;
  }

  bool is_within_bounds(const Effect& law) const {
    const std::vector<EffectParameter>& infos = list_infos(law.id);
    for (size_t i = 0; i < infos.size(); ++i) {
      if (infos[i].required && (law.p[i] <= infos[i].low || law.p[i] >= infos[i].high)) return false;
    }
    return true;
  }

  bool helps_everywhere(const Hypothesis& loose) const {
    const std::vector<int> recordings = list_recordings();
    for (size_t i = 0; i < recordings.size(); ++i) {
      // Each single recording has to gain, too.
      if (!(alone_.score(loose, {recordings[i]}).chi2 < (1.0 - kMinor) * rigid_.each[i])) return false;
    }
    return true;
  }

  // Standard errors from the spread of fits to single recordings.
  std::vector<double> find_deviations(const Hypothesis& loose) const {
    std::vector<int> recordings = alone_.problem.train;
    if (recordings.size() < 2) recordings = list_recordings();
    std::vector<Spread> spreads(loose[at_].p.size());
    size_t n = 0;
    for (int r : recordings) {
      const FitResult own = alone_.fit(loose, kFewRounds, {r});
      if (!own.ok) continue;
      for (size_t i = 0; i < spreads.size(); ++i) spreads[i].add(own.hypothesis[at_].p[i]);
      ++n;
    }
    std::vector<double> std;
    for (size_t i = 0; i < spreads.size(); ++i) {
      const double value = std::abs(loose[at_].p[i]);
      const double error = n < 2 ? value : find_widening(n) * spreads[i].get() / std::sqrt(static_cast<double>(n - 1));
      // Gap laws of two engines differ as well.
      std.push_back(std::hypot(error, kKnown * value));
    }
    return std;
  }

  // Empty if the recordings do not confirm the loose gear.
  std::optional<LooseGear> describe(const std::vector<Fitted>& loose, size_t best) const {
    const Fitted& chosen = loose[best];
    // Of the squared residual of the rigid gear, in training and held-out recordings: below kLargely the loose gear is
    // used for prediction, below kHalf it is also reported. Friction that varies with position or warms up leaves as
    // much as a little elasticity, and a spring and damper fit up to a third of it.
    if (!is_within_bounds(get_law(chosen)) || chosen.cost > kLargely * rigid_.train) return std::nullopt;
    const double rigid = rigid_.held, held = get_held(chosen.effects);
    if (held > kLargely * rigid || !helps_everywhere(chosen.effects)) return std::nullopt;
    LooseGear gear;
    gear.joint = chosen.effects;
    gear.at = at_;
    gear.std = find_deviations(chosen.effects);
    gear.left = held / rigid;
    gear.named = std::max(gear.left, chosen.cost / rigid_.train) < kHalf && is_gear(get_law(chosen));
    gear.share = std::clamp((rigid - held) / std::max(get_held({}), rigid), 0.0, 1.0);
    for (size_t i = 0; i < loose.size(); ++i) {
      const bool contains_it = get_law(loose[i]).p.size() > get_law(chosen).p.size();  // as a special case
      const bool is_other = get_law(loose[i]).id != get_law(chosen).id;
      if (is_other && !contains_it && loose[i].cost < (1.0 + kDetail) * chosen.cost) gear.rival = get_law(loose[i]);
    }
    return gear;
  }

  const int joint_;
  const JointAlone alone_;
  Fitted own_;
  Rigid rigid_;
  size_t at_ = 0;
};

Finding tell(const Experiment& e, const LooseGear& gear) {
  const EffectInfo& info = get_effect(gear.law().id);
  Finding f = make_finding(info, make_where(e, gear.law()), list_estimates(e, gear.law(), gear.std));
  f.grade = gear.rival ? Grade::kAmbiguous : Grade::kSupported;
  f.probability = 0.95;
  f.share = gear.share;
  f.weight = gear.share / e.num_joints();
  f.statement = get_place_text(e, gear.law()) + ": " + info.phrase;
  for (const Estimate& p : f.parameters)
    f.statement +=
        ", " + p.name + " " + number(p.value[0], 3) + " +- " + number(kNinetyFive * p.std[0], 2) + " " + p.unit;
  f.statement += std::string(" (") + get_grade_name(f.grade) + "). The joint's simulation leaves " +
                 number(100.0 * gear.left, 2) + " % of what it leaves with a rigid gear, on held-out data.";
  if (gear.rival)
    f.alternatives = {
        make_alternative(get_effect(gear.rival->id), f.where, list_estimates(e, *gear.rival, {}), kHeldLink)};
  return f;
}

}  // namespace

bool is_gear(const Effect& law) {
  if (law.id != EffectId::kElasticity) return true;
  const double stiffness = law.p[0], damping = law.p[1], rotor = law.p[2];
  return damping < 2.0 * std::sqrt(stiffness * rotor);
}

std::vector<LooseGear> find_loose_gears(const Problem& problem, const Hypothesis& model,
                                        const std::vector<int>& joints) {
  if (is_effort_driven(*problem.experiment) || problem.validate.empty()) return {};
  Hypothesis moving = take_links(model);
  for (const Effect& e : model) {
    if (!get_effect(e.id).flexible) continue;
    for (const Effect& beside : take_joint(model, e.place.index)) moving.push_back(beside);
  }
  const JointPaths paths(problem, moving);
  std::vector<std::optional<LooseGear>> found(joints.size());
  parallel_for(problem.jobs, static_cast<int>(found.size()), [&](int i) {
    const auto k = static_cast<size_t>(i);
    Gear gear(paths, model, joints[k]);
    found[k] = gear.run();
    const Hypothesis fewer = drop_carried(problem.experiment->robot.tree, moving, joints[k]);
    if (found[k] || fewer.size() == moving.size()) return;
    const JointPaths other(problem, fewer);
    found[k] = Gear(other, model, joints[k]).run(gear.rigid());
    if (found[k]) found[k]->drops_carried = true;
  });
  std::vector<LooseGear> gears;
  for (const auto& gear : found) {
    if (gear) gears.push_back(*gear);
  }
  std::stable_sort(gears.begin(), gears.end(), [](const LooseGear& a, const LooseGear& b) { return a.left < b.left; });
  return gears;
}

std::vector<LooseGear> find_all_loose_gears(const Problem& problem, Hypothesis* model) {
  std::vector<LooseGear> found;
  std::vector<int> joints;
  for (int j = 0; j < problem.experiment->num_joints(); ++j) joints.push_back(j);
  while (!joints.empty()) {
    const std::vector<LooseGear> gears = find_loose_gears(problem, *model, joints);
    joints.clear();
    for (size_t i = 1; i < gears.size(); ++i) joints.push_back(gears[i].law().place.index);
    if (gears.empty()) break;
    const int joint = gears[0].law().place.index;
    if (gears[0].drops_carried) *model = drop_carried(problem.experiment->robot.tree, *model, joint);
    model->erase(std::remove_if(model->begin(), model->end(), [joint](const Effect& e) { return is_at(e, joint); }),
                 model->end());
    model->insert(model->end(), gears[0].joint.begin(), gears[0].joint.end());
    found.push_back(gears[0]);
  }
  return found;
}

std::vector<Finding> loosen_gears(const Problem& problem, const Problem& whole, Trial* model,
                                  const std::function<void(const std::string&)>& progress) {
  Hypothesis loosened = model->hypothesis;
  const std::vector<LooseGear> gears = find_all_loose_gears(problem, &loosened);
  if (gears.empty()) return {};
  Trial best = simulate_trial(whole, split_asymmetry(loosened));
  // The joint was fitted along recorded paths, which move without its play, and effects at other joints may have
  // compensated for the rigid gear. Therefore the whole robot is fitted again.
  const Trial fitted = simulate_trial(whole, polish_whole(whole, loosened, make_residuals(whole), kFewRounds));
  if (fitted.validate.ok && !(best.validate.ok && best.rms <= fitted.rms)) best = fitted;
  if (!best.validate.ok || !(best.rms < model->rms)) return {};
  *model = best;
  std::vector<Finding> findings;
  for (LooseGear gear : gears) {
    if (!gear.named) continue;
    gear.joint = take_joint(best.hypothesis, gear.law().place.index);
    if (!is_gear(gear.law())) continue;
    findings.push_back(tell(*problem.experiment, gear));
    progress("    " + findings.back().statement);
  }
  return findings;
}

}  // namespace hrp::diagnosis
