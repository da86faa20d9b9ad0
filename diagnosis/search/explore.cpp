// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/explore.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "diagnosis/search/significance.h"
#include "diagnosis/simulation/nearby.h"

namespace hrp::diagnosis {
namespace {

bool moves_link(const Effect& effect) { return effect.id == EffectId::kElasticity || effect.id == EffectId::kBacklash; }

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (double v : values) total += v;
  return total;
}

// Pairs that are special cases of each other at one joint say nothing together.
bool is_redundant(const Hypothesis& hypothesis, const Effect& added) {
  for (const Effect& e : hypothesis) {
    if (get_effect(e.id).place != PlaceKind::kJoint || get_effect(added.id).place != PlaceKind::kJoint ||
        e.place != added.place)
      continue;
    if (is_dry(e.id) && is_dry(added.id)) return true;
    if (moves_link(e) && moves_link(added)) return true;
    const bool viscous_twice = (e.id == EffectId::kStribeck && added.id == EffectId::kViscous) ||
                               (added.id == EffectId::kStribeck && e.id == EffectId::kViscous);
    const bool rotor_twice = (moves_link(e) && added.id == EffectId::kRotorInertia) ||
                             (moves_link(added) && e.id == EffectId::kRotorInertia);
    if (viscous_twice || rotor_twice) return true;
  }
  return false;
}

}  // namespace

bool can_add(const Hypothesis& hypothesis, const Effect& added) {
  return !contains(hypothesis, added.id, added.place) && !is_redundant(hypothesis, added);
}

namespace {

constexpr double kGearing[] = {25.0, 80.0, 250.0};  // [Hz] of rotors against their links

// [N m/rad] that lets a rotor swing against its link at a frequency [Hz].
double calc_stiffness(double rotor_inertia, double frequency) {
  return rotor_inertia * std::pow(2.0 * M_PI * frequency, 2);
}

// Start values that a regression cannot give, because readings are no smooth function of them.
std::vector<double> list_alternatives(const Effect& effect, const ParameterInfo& info) {
  const std::string name = info.name;
  if (info.scanned) return {std::begin(kPreslidings), std::end(kPreslidings)};
  if (name == "stribeck_velocity") return {0.015, 0.04, 0.1, 0.25};
  if (name == "yield_angle") return {0.3 * effect.p[1], effect.p[1], 3.0 * effect.p[1]};
  if (effect.id == EffectId::kDelay)
    return {0.3 * effect.p[0], effect.p[0], 0.005, 0.02};  // [s] of buses and of queues
  if (name == "time_constant")
    return {0.3 * effect.p[0], effect.p[0], 0.003, 0.01};  // [s] of current loops and of gears
  if (name == "limit") return {0.75 * effect.p[0], effect.p[0], 1.3 * effect.p[0]};
  const bool gap = effect.id == EffectId::kBacklash;
  if (name == "gap") return {0.3 * effect.p[0], effect.p[0], 0.003, 0.01, 0.03, 0.08};  // [rad] of gears
  if (gap && name == "stiffness") {
    std::vector<double> values;
    for (double frequency : kGearing) values.push_back(calc_stiffness(effect.p[3], frequency));
    return values;
  }
  if (effect.id == EffectId::kElasticity && name == "stiffness")
    return {0.4 * effect.p[0], effect.p[0], 2.5 * effect.p[0]};
  if (effect.id == EffectId::kElasticity && name == "rotor_inertia")
    return {0.2 * effect.p[2], effect.p[2], 3.0 * effect.p[2]};
  return {};
}

// Start values of an effect: all combinations of the alternatives of its parameters. A mass far out turns into a fit
// that does not come back when another cause had a part in the regression; so it may start nearer to the link's origin.
std::vector<Effect> list_options(const Effect& effect, bool scanned_only) {
  const EffectInfo& info = get_effect(effect.id);
  std::vector<Effect> options{effect};
  for (size_t i = 0; i < info.parameters.size(); ++i) {
    const std::vector<double> values = list_alternatives(effect, info.parameters[i]);
    if (values.empty() || (scanned_only && !info.parameters[i].scanned)) continue;
    std::vector<Effect> more;
    for (const Effect& option : options) {
      for (double value : values) {
        more.push_back(option);
        more.back().p[i] = value;
      }
    }
    options = std::move(more);
  }
  if (effect.id != EffectId::kPayload) return options;
  for (double mass : {1.0, 0.3}) {
    for (double lever : {0.3, 0.0}) {
      options.push_back(effect);
      options.back().p[0] *= mass;
      for (size_t i = 1; i < 4; ++i) options.back().p[i] *= lever;
    }
  }
  return options;
}

// How many effects are looked at in each joint beside those that promise most: the joint that is missed most and the
// one after it. A second cause elsewhere is hidden by what the first one's details leave.
std::vector<size_t> allow_by_joint(const std::vector<double>& chi2) {
  std::vector<size_t> order(chi2.size()), most(chi2.size(), 0);
  for (size_t j = 0; j < order.size(); ++j) order[j] = j;
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return chi2[a] > chi2[b]; });
  if (!order.empty()) most[order[0]] = 12;
  if (order.size() > 1) most[order[1]] = 4;
  return most;
}

constexpr double kRateShare = 0.1;  // of what is left of a velocity: less is not worth a fit

// The joint that is missed most.
int find_worst(const Lead& lead) {
  return static_cast<int>(std::max_element(lead.train.begin(), lead.train.end()) - lead.train.begin());
}

// Beside friction whose fit has taken up some of another cause in the same joint, the linear signature of that cause
// may point the wrong way. The joint that is missed most and those with friction get the effects of one positive
// parameter in any case.
void add_unseen(const Lead& lead, std::vector<Effect>* list) {
  std::vector<int> joints{find_worst(lead)};
  for (const Effect& effect : lead.hypothesis) {
    const bool there = std::find(joints.begin(), joints.end(), effect.place) != joints.end();
    if (is_dry(effect.id) && !there) joints.push_back(effect.place);
  }
  for (int joint : joints) {
    for (EffectId id : {EffectId::kViscous, EffectId::kRotorInertia, EffectId::kLag, EffectId::kDelay}) {
      const Effect effect{id, joint, {get_effect(id).parameters[0].step}};
      if (can_add(lead.hypothesis, effect) && !contains(*list, effect.id, effect.place)) list->push_back(effect);
    }
  }
}

// A rotor, one behind a transmission that gives, and one behind play look alike to a regression, which may find one and
// miss the others. A plain rotor has some part in most joints; its twins are tried in the joint that is missed most.
void add_twins(const Lead& lead, std::vector<Effect>* list) {
  const int worst = find_worst(lead);
  std::vector<Effect> twins;
  for (const Effect& effect : *list) {
    const double rotor = get_rotor(effect);
    if (rotor <= 0.0 || (effect.id == EffectId::kRotorInertia && effect.place != worst)) continue;
    const double stiffness = calc_stiffness(rotor, kGearing[0]), damping = kGearLoss * stiffness;
    for (const Effect& twin : {Effect{EffectId::kElasticity, effect.place, {stiffness, damping, rotor}},
                               Effect{EffectId::kBacklash, effect.place, {0.01, stiffness, damping, rotor}}}) {
      const bool listed = contains(*list, twin.id, twin.place) || contains(twins, twin.id, twin.place);
      if (!listed && can_add(lead.hypothesis, twin)) twins.push_back(twin);
    }
  }
  list->insert(list->end(), twins.begin(), twins.end());
}

// Faults of the velocity's log leave efforts and positions alone, so no signature in the missing effort shows them:
// what is left of the reading itself is regressed on 1, the velocity and its rate of change.
void add_rate_faults(Problem& problem, const Lead& lead, std::vector<Effect>* list) {
  const Experiment& e = *problem.experiment;
  constexpr int kRate = static_cast<int>(Quantity::kVelocity);
  for (int j = 0; j < e.num_joints(); ++j) {
    const size_t joint = static_cast<size_t>(j);
    const double sigma = e.joint_noise[joint][kRate].sigma;
    double chi2 = 0.0, gram[3] = {0.0, 0.0, 0.0}, projection[3] = {0.0, 0.0, 0.0};
    problem.view = {true, lead.paths.get(), j};
    for (int r : problem.train) {
      const Recording& data = e.recordings[static_cast<size_t>(r)];
      const std::vector<double>& reading = data.joints[joint].signal[kRate];
      std::vector<double> residuals;
      if (reading.empty() || !calc_residuals(problem, lead.hypothesis, r, &residuals)) continue;
      const SmoothJoint& smooth = problem.smooth[static_cast<size_t>(r)].joints[joint];
      for (size_t k = problem.smooth[static_cast<size_t>(r)].judged; k < data.size(); ++k) {
        if (!std::isfinite(reading[k])) continue;
        const double left = residuals[k * kQuantities + kRate] * sigma;
        const double columns[3] = {1.0, reading[k] - left, -smooth.qdd[k]};
        chi2 += left * left;
        for (int i = 0; i < 3; ++i) gram[i] += columns[i] * columns[i], projection[i] += columns[i] * left;
      }
    }
    const Effect faults[3] = {
        {EffectId::kSensorBias, j * kQuantities + kRate, {projection[0] / std::max(1e-12, gram[0])}},
        {EffectId::kSensorScale, j * kQuantities + kRate, {1.0 + projection[1] / std::max(1e-12, gram[1])}},
        {EffectId::kSensorDelay, j * kQuantities + kRate, {projection[2] / std::max(1e-12, gram[2])}}};
    for (int i = 0; i < 3; ++i) {
      const bool helps = projection[i] * projection[i] > kRateShare * chi2 * gram[i];
      const bool possible = i != 2 || projection[i] > 0.0;
      const auto in = [&](const Hypothesis& set) { return contains(set, faults[i].id, faults[i].place); };
      if (helps && possible && !in(lead.hypothesis) && !in(*list)) list->push_back(faults[i]);
    }
  }
}

constexpr double kChanged = 0.5;  // of what was left: an effect that takes more away changes what others were fitted to
constexpr size_t kBodies = 4;     // effects of links that are looked at beside joints' that promise more
constexpr size_t kGaps = 3;       // from which a loose or elastic transmission is fitted: many minima
constexpr size_t kKept = 12;      // leads of one size that are looked at further

FitOptions quick_options() {
  FitOptions options;
  options.max_iterations = 8;
  options.tolerance = 2e-3;
  return options;
}

}  // namespace

int find_joint(const Effect& effect) {
  switch (get_effect(effect.id).place) {
    case PlaceKind::kJoint:
      return effect.id == EffectId::kJointOffset ? -1 : effect.place;
    case PlaceKind::kJointSensor:
      return effect.place / kQuantities;
    default:
      return -1;
  }
}

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

std::vector<Effect> Explorer::list_starts(Problem& p, const Lead& lead, size_t count,
                                          const std::vector<char>& quiet) const {
  const auto is_quiet = [&](const Effect& effect) {
    return find_joint(effect) >= 0 && quiet[static_cast<size_t>(find_joint(effect))];
  };
  const Screening screening = screen(p, lead.hypothesis, lead.paths.get());
  std::vector<Effect> list;
  std::vector<size_t> there(lead.train.size(), 0);  // candidates by joint
  const std::vector<size_t> most = allow_by_joint(lead.train);
  size_t bodies = 0;
  for (const Candidate& c : screening.candidates) {
    if (!can_add(lead.hypothesis, c.start) || is_quiet(c.start)) continue;
    const bool high = list.size() < count && c.gain > 0.01 * screening.candidates.front().gain;
    const int joint = c.start.id == EffectId::kJointOffset ? c.start.place : find_joint(c.start);
    const size_t j = static_cast<size_t>(std::max(0, joint));
    // Offsets of encoders look like masses of links nearby; few enough to try all once.
    const bool offset = c.start.id == EffectId::kJointOffset && lead.hypothesis.empty();
    const bool here = joint >= 0 && (there[j] < most[j] || offset) && c.gain > 0.0;
    const bool body = get_effect(c.start.id).place == PlaceKind::kLink && bodies < kBodies && c.gain > 0.0;
    if (!high && !here && !body) continue;
    there[j] += joint >= 0 ? 1 : 0;
    bodies += body ? 1 : 0;
    list.push_back(c.start);
  }
  if (!lead.hypothesis.empty()) add_unseen(lead, &list);
  add_rate_faults(p, lead, &list);
  add_twins(lead, &list);
  list.erase(std::remove_if(list.begin(), list.end(), is_quiet), list.end());
  return list;
}

// The best of an effect's alternatives (or of the values of those parameters only that no fit moves), the best first,
// no two with the same first parameter.
std::vector<Effect> Explorer::choose_starts(const Problem& problem, Hypothesis hypothesis, size_t at, bool scanned_only,
                                            size_t count) const {
  Effect& effect = hypothesis[at];
  const std::vector<Effect> options = list_options(effect, scanned_only);
  if (options.size() < 2) return {effect};
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < options.size(); ++i) {
    effect = options[i];
    const Score score = calc_score(problem, hypothesis, {problem.train[0]});
    order.push_back({score.ok ? score.chi2 : 1e300, i});
  }
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Effect> best;
  for (const auto& item : order) {
    const Effect& option = options[item.second];
    const bool known = std::any_of(best.begin(), best.end(), [&](const Effect& b) { return b.p[0] == option.p[0]; });
    if (!known) best.push_back(option);
    if (best.size() == count) break;
  }
  return best;
}

void Explorer::choose_start(const Problem& problem, Hypothesis* hypothesis, size_t at, bool scanned_only) const {
  (*hypothesis)[at] = choose_starts(problem, *hypothesis, at, scanned_only, 1)[0];
}

// What friction was fitted to changes with what stands beside it now: its shape is chosen again.
void Explorer::choose_again(const Problem& problem, const FitOptions& options, FitResult* result) const {
  for (size_t i = 0; i + 1 < result->hypothesis.size(); ++i) {
    if (result->hypothesis[i].id != EffectId::kStribeck || options.frozen[i]) continue;
    Hypothesis again = result->hypothesis;
    choose_start(problem, &again, i, false);
    if (again[i].p == result->hypothesis[i].p) continue;
    const FitResult other = fit(problem, again, problem.train, options);
    if (other.ok && other.train.chi2 < result->train.chi2) *result = other;
  }
}

// Of all joints: those beyond feel how the link moves behind its transmission, more than its own joint's readings do.
double Explorer::calc_left(Problem& p, const FitResult& result) const {
  const View own = std::exchange(p.view, {true, nullptr, -1});
  const Score score = calc_score(p, result.hypothesis, p.train);
  p.view = own;
  return score.ok ? score.chi2 : 1e300;
}

// What rattles or swings does so about the motion of a rotor without play, which is quick to fit.
Effect Explorer::start_from_rotor(const Problem& problem, Hypothesis with, const FitOptions& options) const {
  Effect effect = with.back();
  double& rotor = effect.id == EffectId::kBacklash ? effect.p[3] : effect.p[2];
  with.back() = {EffectId::kRotorInertia, effect.place, {rotor}};
  const FitResult result = fit(problem, with, problem.train, options);
  const double fitted = result.ok ? result.hypothesis.back().p[0] : 0.0;
  if (fitted > get_effect(EffectId::kRotorInertia).parameters[0].step) rotor = fitted;
  return effect;
}

// `start` and the effects of the parent at its joint, fitted together; the rest of the parent frozen.
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
  for (const Effect& option : choose_starts(p, all, all.size() - 1, false, moves_link(start) ? kGaps : 1)) {
    all.back() = option;
    const FitResult one = fit(p, all, p.train, options);
    const double left = !one.ok ? 1e300 : moves_link(start) ? calc_left(p, one) : one.train.chi2;
    if (left < least) least = left, result = one;
  }
  if (result.ok) {
    Hypothesis again = result.hypothesis;
    choose_start(p, &again, again.size() - 1, true);
    if (again.back().p != result.hypothesis.back().p) result = fit(p, again, p.train, options);
  }
  if (result.ok && result.train.chi2 < kChanged * parent.train[static_cast<size_t>(joint)])
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
  const bool same_paths = start.id == EffectId::kClockSkew;
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
  std::vector<int> ids{static_cast<int>(start.id) * 1000 + start.place % kQuantities};
  for (const Effect& effect : parent.hypothesis) {
    if (find_joint(effect) == joint) ids.push_back(static_cast<int>(effect.id) * 1000 + effect.place % kQuantities);
    if (effect.id == EffectId::kClockSkew) ids.push_back(static_cast<int>(effect.p[0] * 1e9) + 1000000);
  }
  std::sort(ids.begin(), ids.end());
  return {{parent.paths.get(), joint}, ids};
}

std::vector<Lead> Explorer::grow(const std::vector<Lead>& from, size_t candidates, const std::vector<char>& quiet) {
  std::vector<std::vector<Effect>> starts(from.size());
  parallel_for(static_cast<int>(workers_.size()), static_cast<int>(from.size()), [&](int i, int worker) {
    Problem& problem = workers_[static_cast<size_t>(worker)];
    starts[static_cast<size_t>(i)] = list_starts(problem, from[static_cast<size_t>(i)], candidates, quiet);
  });
  std::vector<Task> tasks;
  std::set<EffectSet> seen;
  std::vector<size_t> fresh;  // tasks that need a fit: shared ones, and local ones not known yet
  std::set<LocalKey> planned;
  for (size_t i = 0; i < from.size(); ++i) {
    for (const Effect& start : starts[i]) {
      Hypothesis together = from[i].hypothesis;
      together.push_back(start);
      if (!seen.insert(make_set(together)).second) continue;
      tasks.push_back({i, start});
      const bool local = find_joint(start) >= 0;
      if (!local || (!locals_.count(make_key(from[i], start)) && planned.insert(make_key(from[i], start)).second))
        fresh.push_back(tasks.size() - 1);
    }
  }
  std::vector<Lead> leads(tasks.size());
  std::vector<Local> fits(tasks.size());
  parallel_for(static_cast<int>(workers_.size()), static_cast<int>(fresh.size()), [&](int i, int worker) {
    const size_t t = fresh[static_cast<size_t>(i)];
    Problem& problem = workers_[static_cast<size_t>(worker)];
    if (find_joint(tasks[t].start) >= 0)
      fits[t] = fit_local(problem, from[tasks[t].parent], tasks[t].start);
    else
      leads[t] = add_shared(problem, from[tasks[t].parent], tasks[t].start);
  });
  for (size_t t : fresh) {
    if (find_joint(tasks[t].start) >= 0) locals_[make_key(from[tasks[t].parent], tasks[t].start)] = fits[t];
  }
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
  if (leads.size() > kKept) leads.resize(kKept);
  forget(from, leads);
  return leads;
}

// Keeps the fits along paths that are still in use: a freed path's address may come again.
void Explorer::forget(const std::vector<Lead>& from, const std::vector<Lead>& leads) {
  kept_ = {nominal_.paths};
  for (const auto* list : {&from, &leads}) {
    for (const Lead& lead : *list) kept_.push_back(lead.paths);
  }
  for (auto it = locals_.begin(); it != locals_.end();) {
    const Paths* paths = it->first.first.first;
    const bool alive = std::any_of(kept_.begin(), kept_.end(), [&](const auto& p) { return p.get() == paths; });
    it = alive ? std::next(it) : locals_.erase(it);
  }
}

}  // namespace hrp::diagnosis
