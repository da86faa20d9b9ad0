// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/explore.h"

#include <algorithm>
#include <set>
#include <utility>

#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (double v : values) total += v;
  return total;
}

FitOptions quick_options() {
  FitOptions options;
  options.max_iterations = 8;
  options.tolerance = 2e-3;
  return options;
}

}  // namespace

Explorer::Explorer(const Problem& problem) : held_(problem.validate) {
  Problem worker = problem;
  worker.options.max_step = 2.0 * problem.options.max_step;
  worker.jobs = 1;
  worker.view.along = true;
  workers_.assign(static_cast<size_t>(std::max(1, problem.jobs)), worker);
  nominal_.paths = std::make_shared<const Paths>(worker.nominal_paths);
  kept_.push_back(nominal_.paths);
  measure(workers_[0], &nominal_);
}

// Fills train, held and cost of a lead from its hypothesis and paths.
void Explorer::measure(Problem& p, Lead* lead) const {
  p.view = {true, lead->paths.get(), -1};
  const size_t n = static_cast<size_t>(p.experiment->num_joints());
  for (bool train : {true, false}) {
    std::vector<double>& chi2 = train ? lead->train : lead->held;
    chi2.assign(n, 0.0);
    const Score score = calc_score(p, lead->hypothesis, train ? p.train : held_);
    if (train || !held_.empty()) {
      for (size_t c = 0; c < score.signal_chi2.size(); ++c)
        chi2[c / kQuantities] += score.ok ? score.signal_chi2[c] : 1e200;
    }
  }
  lead->cost = sum(lead->train) + sum(lead->held);
}

Lead Explorer::make_lead(const Hypothesis& hypothesis) {
  Lead lead;
  lead.hypothesis = hypothesis;
  lead.paths = std::make_shared<const Paths>(make_paths(workers_[0], hypothesis));
  measure(workers_[0], &lead);
  return lead;
}

// Best of an effect's start values; with `scanned_only`, only of parameters that are scanned and not fitted.
std::vector<Effect> Explorer::choose_starts(const Problem& problem, const Hypothesis& hypothesis, size_t at,
                                            bool scanned_only, size_t count) const {
  const std::vector<Effect> options = list_options(hypothesis[at], scanned_only);
  if (options.size() < 2) return {hypothesis[at]};
  return choose_options(problem, {problem.train[0]}, hypothesis, at, options, count);
}

void Explorer::choose_start(const Problem& problem, Hypothesis* hypothesis, size_t at, bool scanned_only) const {
  (*hypothesis)[at] = choose_starts(problem, *hypothesis, at, scanned_only, 1)[0];
}

// The best shape of a friction law depends on the effects beside it, so it is chosen again.
void Explorer::choose_again(const Problem& problem, const FitOptions& options, FitResult* result) const {
  for (size_t i = 0; i + 1 < result->hypothesis.size(); ++i) {
    const EffectInfo& info = get_effect(result->hypothesis[i].id);
    if (!info.dry || info.torque.shapes.empty() || options.frozen[i]) continue;
    Hypothesis again = result->hypothesis;
    choose_start(problem, &again, i, false);
    if (again[i].p == result->hypothesis[i].p) continue;
    const FitResult other = fit(problem, again, problem.train, options);
    if (other.ok && other.train.chi2 < result->train.chi2) *result = other;
  }
}

// Chi-square over all joints: links beyond an elastic transmission show its motion better than the joint itself.
double Explorer::calc_left(Problem& p, const FitResult& result) const {
  const View own = std::exchange(p.view, {true, nullptr, -1});
  const Score score = calc_score(p, result.hypothesis, p.train);
  p.view = own;
  return score.ok ? score.chi2 : 1e300;
}

// Starts a transmission from the rotor inertia that fits without a transmission, which is a fast fit.
Effect Explorer::start_from_rotor(const Problem& problem, Hypothesis with, const FitOptions& options) const {
  Effect effect = with.back();
  with.back() = make_part(effect, get_effect(effect.id).parts.front());
  const FitResult result = fit(problem, with, problem.train, options);
  const double fitted = result.ok ? result.hypothesis.back().p[0] : 0.0;
  if (fitted > list_infos(with.back().id)[0].step) effect.p[static_cast<size_t>(get_effect(effect.id).rotor)] = fitted;
  return effect;
}

// Fits `start` and the parent's effects at its joint together; the other effects of the parent are frozen.
Explorer::Local Explorer::fit_local(Problem& p, const Lead& parent, const Effect& start) const {
  const int joint = find_joint(start);
  p.view = {true, parent.paths.get(), joint};
  FitOptions options = quick_options();
  Hypothesis all;
  for (const Effect& effect : parent.hypothesis) {
    const bool here = find_joint(effect) == joint;
    all.push_back(effect);
    options.frozen.push_back(!here);
  }
  all.push_back(start);
  if (moves_link(start)) all.back() = start_from_rotor(p, all, options);
  FitResult result;
  double least = 1e300;
  for (const Effect& option : choose_starts(p, all, all.size() - 1, false, moves_link(start) ? kLookedAt : 1)) {
    all.back() = option;
    const FitResult one = fit(p, all, p.train, options);
    const double left = !one.ok ? 1e300 : moves_link(start) ? calc_left(p, one) : one.train.chi2;
    if (left < least) {
      least = left;
      result = one;
    }
  }
  if (result.ok) {
    Hypothesis again = result.hypothesis;
    choose_start(p, &again, again.size() - 1, true);
    if (again.back().p != result.hypothesis.back().p) result = fit(p, again, p.train, options);
  }
  if (result.ok && result.train.chi2 < kHalf * parent.train[static_cast<size_t>(joint)])
    choose_again(p, options, &result);
  Local local;
  if (!result.ok) return local;
  for (const Effect& effect : result.hypothesis) {
    if (find_joint(effect) == joint) local.effects.push_back(effect);
  }
  local.train = result.train.chi2;
  const Score held = calc_score(p, result.hypothesis, held_);
  local.held = held.ok ? held.chi2 : 1e200;
  return local;
}

Lead Explorer::add_local(const Lead& parent, const Effect& start, const Local& local) const {
  Lead lead = parent;
  const int joint = find_joint(start);
  lead.hypothesis.clear();
  for (const Effect& effect : parent.hypothesis) {
    if (find_joint(effect) != joint) lead.hypothesis.push_back(effect);
  }
  lead.hypothesis.insert(lead.hypothesis.end(), local.effects.begin(), local.effects.end());
  lead.train[static_cast<size_t>(joint)] = local.train;
  lead.held[static_cast<size_t>(joint)] = held_.empty() ? 0.0 : local.held;
  lead.cost = sum(lead.train) + sum(lead.held);
  return lead;
}

Lead Explorer::add_shared(Problem& p, const Lead& parent, const Effect& start) const {
  Lead lead = parent;
  lead.cost = 1e300;
  FitOptions options = quick_options();
  options.max_iterations = 5;
  const bool same_paths = start.place == at_all();
  p.view = {true, same_paths ? parent.paths.get() : nullptr, -1};
  for (const Effect& effect : parent.hypothesis) options.frozen.push_back(find_joint(effect) >= 0);
  lead.hypothesis.push_back(start);
  choose_start(p, &lead.hypothesis, lead.hypothesis.size() - 1, false);
  const FitResult result = fit(p, lead.hypothesis, p.train, options);
  if (!result.ok) return lead;
  lead.hypothesis = result.hypothesis;
  if (!same_paths) lead.paths = std::make_shared<const Paths>(make_paths(p, lead.hypothesis));
  measure(p, &lead);
  return lead;
}

Explorer::LocalKey Explorer::make_key(const Lead& parent, const Effect& start) const {
  const int joint = find_joint(start);
  std::vector<std::tuple<EffectId, Place, double>> there{{start.id, start.place, 0.0}};
  for (const Effect& effect : parent.hypothesis) {
    const bool everywhere = effect.place == at_all();
    if (everywhere || find_joint(effect) == joint)
      there.push_back({effect.id, effect.place, everywhere ? effect.p[0] : 0.0});
  }
  std::sort(there.begin(), there.end());
  return {parent.paths.get(), joint, there};
}

// Every start beside every lead, each set once.
std::vector<Explorer::Task> Explorer::list_tasks(const std::vector<Lead>& from, size_t candidates,
                                                 const std::vector<char>& quiet) {
  std::vector<std::vector<Effect>> starts(from.size());
  parallel_for(static_cast<int>(workers_.size()), static_cast<int>(from.size()), [&](int i, int worker) {
    Problem& problem = workers_[static_cast<size_t>(worker)];
    starts[static_cast<size_t>(i)] = list_starts(problem, from[static_cast<size_t>(i)], candidates, quiet);
  });
  std::vector<Task> tasks;
  std::set<EffectSet> seen;
  for (size_t i = 0; i < from.size(); ++i) {
    for (const Effect& start : starts[i]) {
      Hypothesis together = from[i].hypothesis;
      together.push_back(start);
      if (seen.insert(make_set(together)).second) tasks.push_back({i, start});
    }
  }
  return tasks;
}

// Fits shared effects into their leads, and local ones that are not known yet into locals_.
void Explorer::fit_tasks(const std::vector<Lead>& from, const std::vector<Task>& tasks, std::vector<Lead>* leads) {
  std::vector<size_t> fresh;
  std::set<LocalKey> planned;
  for (size_t t = 0; t < tasks.size(); ++t) {
    const LocalKey key = make_key(from[tasks[t].parent], tasks[t].start);
    const bool local = find_joint(tasks[t].start) >= 0;
    if (!local || (!locals_.count(key) && planned.insert(key).second)) fresh.push_back(t);
  }
  std::vector<Local> fits(tasks.size());
  parallel_for(static_cast<int>(workers_.size()), static_cast<int>(fresh.size()), [&](int i, int worker) {
    const size_t t = fresh[static_cast<size_t>(i)];
    Problem& problem = workers_[static_cast<size_t>(worker)];
    if (find_joint(tasks[t].start) >= 0)
      fits[t] = fit_local(problem, from[tasks[t].parent], tasks[t].start);
    else
      (*leads)[t] = add_shared(problem, from[tasks[t].parent], tasks[t].start);
  });
  for (size_t t : fresh) {
    if (find_joint(tasks[t].start) >= 0) locals_[make_key(from[tasks[t].parent], tasks[t].start)] = fits[t];
  }
}

std::vector<Lead> Explorer::grow(const std::vector<Lead>& from, size_t candidates, const std::vector<char>& quiet) {
  const std::vector<Task> tasks = list_tasks(from, candidates, quiet);
  std::vector<Lead> leads(tasks.size());
  fit_tasks(from, tasks, &leads);
  std::vector<size_t> moved;
  for (size_t t = 0; t < tasks.size(); ++t) {
    const Lead& parent = from[tasks[t].parent];
    if (find_joint(tasks[t].start) < 0) continue;
    leads[t] = add_local(parent, tasks[t].start, locals_[make_key(parent, tasks[t].start)]);
    if (moves_link(tasks[t].start) && leads[t].cost < 0.9 * parent.cost) moved.push_back(t);
  }
  parallel_for(static_cast<int>(workers_.size()), static_cast<int>(moved.size()), [&](int i, int worker) {
    Lead& lead = leads[moved[static_cast<size_t>(i)]];
    lead.paths = std::make_shared<const Paths>(make_paths(workers_[static_cast<size_t>(worker)], lead.hypothesis));
    measure(workers_[static_cast<size_t>(worker)], &lead);
  });
  std::stable_sort(leads.begin(), leads.end(), [](const Lead& a, const Lead& b) { return a.cost < b.cost; });
  if (leads.size() > kShortList) leads.resize(kShortList);
  forget(from, leads);
  return leads;
}

// Keeps only fits along paths in use, because a new object may reuse the address of a deleted one.
void Explorer::forget(const std::vector<Lead>& from, const std::vector<Lead>& leads) {
  kept_ = {nominal_.paths};
  for (const auto* list : {&from, &leads}) {
    for (const Lead& lead : *list) kept_.push_back(lead.paths);
  }
  for (auto it = locals_.begin(); it != locals_.end();) {
    const Paths* paths = std::get<const Paths*>(it->first);
    const bool alive = std::any_of(kept_.begin(), kept_.end(), [&](const auto& p) { return p.get() == paths; });
    it = alive ? std::next(it) : locals_.erase(it);
  }
}

}  // namespace hrp::diagnosis
