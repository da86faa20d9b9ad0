// SPDX-License-Identifier: BSD-3-Clause
// Which effects of a drive's model are certain. A true effect has the same parameters in every recording, stretch and
// regime, even when something else is missing as well; an effect that stands in for something else has not.
#include <algorithm>
#include <cmath>

#include "diagnosis/data/quantile.h"
#include "diagnosis/search/drive_model.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

// Least growth of the held-out sum of squares without an effect: it takes away as much as stays, or it may be a part of
// what stays.
constexpr double kMaterial = 2.0;
constexpr double kAgree = 0.25;     // share by which parameters of two parts may differ whatever their spread
constexpr double kSpreads = 3.0;    // or so many standard deviations of the difference
constexpr double kTells = 0.35;     // a part tells something when its spread is below this share of the parameter
constexpr double kMoving = 0.02;    // [rad/s] slower samples do not count for the median speed
constexpr double kAsGood = 0.97;    // another effect that predicts nearly as well leaves the choice open

// Value at which an effect does nothing.
double find_absent(const Effect& effect) {
  return list_infos(effect.id)[0].factor ? 1.0 : 0.0;
}

// The parameter that is compared: the largest component of a vector.
size_t find_main(const Effect& effect) {
  if (effect.id != EffectId::kComError) return 0;
  size_t main = 0;
  for (size_t i = 1; i < effect.p.size(); ++i) main = std::abs(effect.p[i]) > std::abs(effect.p[main]) ? i : main;
  return main;
}

}  // namespace

// Values no drive has; they only stand in for something.
std::string DriveSelector::find_nonsense(const Effect& effect) const {
  const double p = effect.p[0];
  std::vector<double> inertia =
      problem_.nominal_paths[static_cast<size_t>(problem_.train[0])][static_cast<size_t>(joint_)].inertia;
  switch (effect.id) {
    case EffectId::kTorqueConstant:
    case EffectId::kMassError:
      return p < 0.5 || p > 2.0 ? "the factor is beyond what a drive or a model can be wrong by" : "";
    // An encoder counts its marks.
    case EffectId::kSensorScale:
      return std::abs(p - 1.0) > 0.05 ? "no encoder is wrong by such a factor" : "";
    case EffectId::kLag:
    case EffectId::kDelay:
    case EffectId::kSensorDelay:
      return p > 0.1 ? "the delay is longer than any drive's" : "";
    case EffectId::kRotorInertia:
      return p > 20.0 * find_median(inertia) ? "the inertia is beyond what a rotor can have" : "";
    // Breaking away takes up to about twice what sliding does; far more is a joint that was nailed down for an instant.
    case EffectId::kStribeck:
      return effect.p[1] > 5.0 * p ? "no bearing sticks so much harder than it slides" : "";
    case EffectId::kLoadFriction:
      return p > 0.6 ? "no transmission loses so much" : "";
    case EffectId::kSpring:
      return std::abs(effect.p[1] - middle_) > 2.0 * swing_
                 ? "over this motion it is a constant torque rather than a spring"
                 : "";
    default:
      return "";
  }
}

// Ways to cut the training samples in two: recordings, times, and regimes of the motion.
std::vector<DriveSelector::Split> DriveSelector::list_splits() const {
  const auto path = [this](size_t i) -> const JointPath& {
    return problem_.nominal_paths[static_cast<size_t>(problem_.train[i])][static_cast<size_t>(joint_)];
  };
  std::vector<double> speeds, positions, loads;
  for (size_t i = 0; i < problem_.train.size(); ++i) {
    const JointPath& p = path(i);
    for (size_t k = 0; k < p.q.size(); ++k) {
      positions.push_back(p.q[k]), loads.push_back(std::abs(find_effort(problem_.train[i], k)));
      if (std::abs(p.qd[k]) > kMoving) speeds.push_back(std::abs(p.qd[k]));
    }
  }
  const double speed = find_median(speeds), position = find_median(positions), load = find_median(loads);
  std::vector<Split> splits{
      {"first and second half", false, [path](size_t i, size_t k) { return 2 * k < path(i).q.size() ? 0 : 1; }},
      {"slow and fast motion", true, [=](size_t i, size_t k) { return std::abs(path(i).qd[k]) < speed ? 0 : 1; }},
      {"positions", true, [=](size_t i, size_t k) { return path(i).q[k] < position ? 0 : 1; }},
      {"directions", true, [=](size_t i, size_t k) { return path(i).qd[k] < 0.0 ? 0 : 1; }},
      {"low and high load", true,
       [=](size_t i, size_t k) { return std::abs(find_effort(problem_.train[i], k)) < load ? 0 : 1; }},
  };
  for (size_t r = 0; r < problem_.train.size() && problem_.train.size() > 1; ++r) {
    splits.push_back({"recordings", false, [r](size_t i, size_t) { return i == r ? 0 : 1; }});
  }
  return splits;
}

// "" when both parts ask for the same value, as far as they tell. `tells`: they do tell.
std::string DriveSelector::compare(const PartStep& a, const PartStep& b, long slot, double size, bool* tells) const {
  const double apart = std::abs(a.step[slot] - b.step[slot]), spread = std::hypot(a.sigma[slot], b.sigma[slot]);
  *tells = spread < kTells * size;
  return apart > std::max(kAgree * size, kSpreads * spread) ? "its value differs between " : "";
}

std::string DriveSelector::find_doubt(const Linear& linear, const Hypothesis& effects, size_t at,
                                      const std::vector<Slot>& slots) const {
  const Effect& effect = effects[at];
  PartStep whole;
  if (!calc_part_step(
          linear, [](size_t, size_t) { return 0; }, 0, &whole))
    return "the recordings are too short";
  size_t of_time = 0, of_regime = 0;
  for (size_t s = 0; s < slots.size(); ++s) {
    const EffectParameter& info = *slots[s].info;
    // What only gives the law its shape (rest, Stribeck speed) is not compared; a second level is.
    const bool main = slots[s].index == find_main(effect) || (effect.id == EffectId::kStribeck && slots[s].index == 1);
    if (slots[s].effect != at || info.nuisance || !main) continue;
    const long slot = static_cast<long>(s);
    // Friction falls with speed by what it takes to break away beyond what it takes to slide.
    const bool excess = effect.id == EffectId::kStribeck && slots[s].index == 1;
    const double size = std::abs(effect.p[slots[s].index] - (excess ? effect.p[0] : find_absent(effect)));
    if (!(size > kSignificantInJoint * whole.sigma[slot])) return "its value is not clearly apart from none";
    for (const Split& split : list_splits()) {
      PartStep a, b;
      if (!calc_part_step(linear, split.part, 0, &a) || !calc_part_step(linear, split.part, 1, &b)) continue;
      bool tells = false;
      const std::string doubt = compare(a, b, slot, size, &tells);
      if (!doubt.empty()) return doubt + split.name;
      (split.of_regime ? of_regime : of_time) += tells ? 1 : 0;
    }
  }
  return of_time < 1 || of_regime < 2 ? "no two parts of the recordings tell its value on their own" : "";
}

// An effect beside which the value would be another one: what a parameter is must not depend on what else is in the
// model, or it makes up for something that is not. A true one does not mind company that there is no need of.
std::string DriveSelector::find_company(const Linear& linear, const Hypothesis& effects, size_t at,
                                        const std::vector<Slot>& slots) const {
  const auto everywhere = [](size_t, size_t) { return 0; };
  PartStep alone;
  if (!calc_part_step(linear, everywhere, 0, &alone)) return "the recordings are too short";
  for (const Effect& candidate : list_candidates(effects)) {
    PartStep beside;
    const Linear both = extend(problem_, linear, effects, candidate);
    if (!both.ok || !calc_part_step(both, everywhere, 0, &beside)) continue;
    // Company that no drive has, such as an encoder wrong by a tenth, proves nothing.
    Effect moved = candidate;
    long column = linear.width.size();
    for (const Slot& slot : list_slots({candidate})) moved.p[slot.index] += beside.step[column++];
    if (!find_nonsense(moved).empty()) continue;
    for (size_t s = 0; s < slots.size(); ++s) {
      if (slots[s].effect != at || slots[s].index != find_main(effects[at])) continue;
      const long slot = static_cast<long>(s);
      const double size = std::abs(effects[at].p[slots[s].index] - find_absent(effects[at]));
      if (std::abs(beside.step[slot] - alone.step[slot]) > kAgree * size)
        return std::string("its value depends on whether ") + get_effect(candidate.id).name + " is there, too";
    }
  }
  return "";
}

// Whether it is known what the drive gave.
bool DriveSelector::knows_effort() const {
  const Experiment& e = *problem_.experiment;
  return e.recordings[static_cast<size_t>(problem_.train[0])].joints[static_cast<size_t>(joint_)].has(
      Quantity::kEffort);
}

void DriveSelector::judge(DriveModel* model) const {
  const Hypothesis& effects = model->effects;
  model->std.clear();
  model->worth.assign(effects.size(), 0.0), model->doubts.assign(effects.size(), "");
  const std::vector<Slot> slots = list_slots(effects);
  const Linear linear = linearise(problem_, effects, slots, problem_.train);
  const Score held = calc_score(problem_, effects, held_);
  if (!linear.ok || !held.ok) {
    model->doubts.assign(effects.size(), "the simulation diverges near the model");
    return;
  }
  PartStep whole;
  calc_part_step(
      linear, [](size_t, size_t) { return 0; }, 0, &whole);
  for (const Effect& effect : effects) model->std.emplace_back(effect.p.size(), 0.0);
  for (size_t s = 0; s < slots.size() && whole.sigma.size() > 0; ++s)
    model->std[slots[s].effect][slots[s].index] = whole.sigma[static_cast<long>(s)];
  std::vector<long> columns;
  for (long i = 0; i < linear.width.size(); ++i) columns.push_back(i);
  const double cross = cross_validate(sum_folds(linear), columns, linear.width);
  for (size_t i = 0; i < effects.size(); ++i) {
    std::string& doubt = model->doubts[i];
    doubt = find_nonsense(effects[i]);
    if (doubt.empty() && !knows_effort())
      doubt = "without a recorded effort, gains and delays of the drive look like friction and inertia";
    if (doubt.empty()) doubt = find_doubt(linear, effects, i, slots);
    if (doubt.empty()) doubt = find_company(linear, effects, i, slots);
    if (!doubt.empty()) continue;
    const Fit rest = try_fit(leave_out(effects, i), 8);
    const bool matters = rest.ok && rest.held > kMaterial * held.chi2 && rest.cross > kMaterial * cross;
    doubt = matters ? find_rival(effects[i], rest, cross, held.chi2, &model->rivals)
                    : "the prediction is hardly worse without it";
    if (doubt.empty()) model->worth[i] = std::sqrt(rest.held / std::max(1e-300, held.chi2));
  }
}

// Another effect that would do as well in the place of one.
std::string DriveSelector::find_rival(const Effect& effect, const Fit& rest, double cross, double held,
                                      Hypothesis* rivals) const {
  for (const auto& candidate : probe(rest.effects)) {
    if (candidate.second.id == effect.id && candidate.second.place == effect.place) continue;
    if (kAsGood * candidate.first > cross) break;
    Hypothesis other = rest.effects;
    other.push_back(candidate.second);
    const Fit swapped = try_fit(other, 6);
    if (!swapped.ok || kAsGood * swapped.cross > cross || kAsGood * swapped.held > held) continue;
    rivals->push_back(candidate.second);
    return std::string(get_effect(candidate.second.id).name) + " in its place predicts as well";
  }
  return "";
}

}  // namespace hrp::diagnosis
