// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/starts.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/search/nearby.h"
#include "diagnosis/search/screen.h"
#include "diagnosis/search/significance.h"

namespace hrp::diagnosis {

bool moves_link(const Effect& effect) { return get_effect(effect.id).flexible; }

int find_joint(const Effect& effect) {
  if (get_effect(effect.id).felt_elsewhere) return -1;
  return effect.place.kind == PlaceKind::kJoint || effect.place.kind == PlaceKind::kSensor ? effect.place.index : -1;
}

namespace {

// True if an effect at the joint is a special case of the added one, or the reverse.
bool is_redundant(const Hypothesis& hypothesis, const Effect& added) {
  for (const Effect& e : hypothesis) {
    if (e.place.kind != PlaceKind::kJoint || e.place != added.place) continue;
    if (is_dry(e.id) && is_dry(added.id)) return true;
    if (moves_link(e) && moves_link(added)) return true;
    if (has_part(e.id, added.id) || has_part(added.id, e.id)) return true;
  }
  return false;
}

}  // namespace

bool can_add(const Hypothesis& hypothesis, const Effect& added) {
  return !contains(hypothesis, added.id, added.place) && !is_redundant(hypothesis, added);
}

namespace {

constexpr double kGearing[] = {25.0, 80.0, 250.0};  // [Hz] natural frequencies of rotors against their links

// Stiffness [N m/rad] at which a rotor oscillates against its link at a frequency [Hz].
double calc_stiffness(double rotor_inertia, double frequency) {
  return rotor_inertia * std::pow(2.0 * M_PI * frequency, 2);
}

// Start values for parameters that readings depend on non-smoothly, which a regression cannot give.
std::vector<double> list_alternatives(const Effect& effect, size_t index) {
  const EffectParameter& info = list_infos(effect.id)[index];
  if (info.scanned) return {std::begin(kPreslidings), std::end(kPreslidings)};
  std::vector<double> values;
  for (double factor : info.start_factors) values.push_back(factor * effect.p[index]);
  values.insert(values.end(), info.start_values.begin(), info.start_values.end());
  if (info.swings_with < 0) return values;
  for (double frequency : kGearing)
    values.push_back(calc_stiffness(effect.p[static_cast<size_t>(info.swings_with)], frequency));
  return values;
}
}  // namespace

std::vector<Effect> list_transmissions(int joint, double rotor_inertia) {
  std::vector<Effect> out;
  for (const EffectInfo& row : list_effects()) {
    if (!row.flexible) continue;
    out.push_back({row.id, joint, std::vector<double>(row.parameters.size())});
    row.give.start_at(rotor_inertia, calc_stiffness(rotor_inertia, kGearing[0]), out.back().p.data());
  }
  return out;
}

std::vector<Effect> list_options(const Effect& effect, bool scanned_only) {
  const std::vector<EffectParameter>& infos = list_infos(effect.id);
  std::vector<Effect> options{effect};
  for (size_t i = 0; i < infos.size(); ++i) {
    const std::vector<double> values = list_alternatives(effect, i);
    if (values.empty() || (scanned_only && !infos[i].scanned)) continue;
    std::vector<Effect> more;
    for (const Effect& option : options) {
      for (double value : values) {
        more.push_back(option);
        more.back().p[i] = value;
      }
    }
    options = std::move(more);
  }
  for (const std::vector<double>& factors : get_effect(effect.id).start_scales) {
    options.push_back(effect);
    for (size_t i = 0; i < factors.size(); ++i) options.back().p[i] *= factors[i];
  }
  return options;
}

std::vector<Effect> choose_options(const Problem& problem, const std::vector<int>& recordings, Hypothesis hypothesis,
                                   size_t at, const std::vector<Effect>& options, size_t count) {
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < options.size(); ++i) {
    hypothesis[at] = options[i];
    const Score score = calc_score(problem, hypothesis, recordings);
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

namespace {

// Number of effects that are tried at each joint beside the best ones: most at the joint with the largest residual,
// some at the next. Details of the first cause may hide a second one elsewhere.
std::vector<size_t> allow_by_joint(const std::vector<double>& chi2) {
  std::vector<size_t> order(chi2.size()), most(chi2.size(), 0);
  for (size_t j = 0; j < order.size(); ++j) order[j] = j;
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return chi2[a] > chi2[b]; });
  if (!order.empty()) most[order[0]] = 12;
  if (order.size() > 1) most[order[1]] = 4;
  return most;
}

// The joint with the largest residual.
int find_worst(const Lead& lead) {
  return static_cast<int>(std::max_element(lead.train.begin(), lead.train.end()) - lead.train.begin());
}

// True for effects with one positive parameter that readings depend on smoothly and linearly.
bool is_plain(const EffectInfo& row) {
  return row.place == PlaceKind::kJoint && row.reported && row.linear && row.smooth && row.parameters.size() == 1 &&
         row.parameters[0].lower == 0.0 && !row.parameters[0].factor;
}

// Adds simple effects at the joint with the largest residual and at joints with friction. A friction fit that absorbed
// part of another cause may change the sign of that cause's linear signature.
void add_unseen(const Lead& lead, std::vector<Effect>* list) {
  std::vector<int> joints{find_worst(lead)};
  for (const Effect& effect : lead.hypothesis) {
    const bool there = has(joints, effect.place.index);
    if (is_dry(effect.id) && !there) joints.push_back(effect.place.index);
  }
  for (int joint : joints) {
    for (const EffectInfo& row : list_effects()) {
      if (!is_plain(row)) continue;
      const Effect effect{row.id, joint, {row.parameters[0].step}};
      if (can_add(lead.hypothesis, effect) && !contains(*list, effect.id, effect.place)) list->push_back(effect);
    }
  }
}

// Adds transmissions where a rotor is a candidate. To a regression, a rotor, an elastic one and a loose one look alike.
// A rotor is a candidate in most joints, so a rigid one gets transmissions only at the joint with the largest residual.
void add_indistinguishable(const Lead& lead, std::vector<Effect>* list) {
  const int worst = find_worst(lead);
  std::vector<Effect> others;
  for (const Effect& effect : *list) {
    const double rotor = get_rotor(effect);
    if (rotor <= 0.0 || (is_rigid_rotor(effect) && effect.place.index != worst)) continue;
    for (const Effect& other : list_transmissions(effect.place.index, rotor)) {
      const bool listed = contains(*list, other.id, other.place) || contains(others, other.id, other.place);
      if (!listed && can_add(lead.hypothesis, other)) others.push_back(other);
    }
  }
  list->insert(list->end(), others.begin(), others.end());
}

// Adds faults of the velocity log. They change neither efforts nor positions, so the missing effort does not show them.
// Instead the residual of the reading is regressed on each fault.
void add_rate_faults(Problem& problem, const Lead& lead, std::vector<Effect>* list) {
  const Experiment& e = *problem.experiment;
  const auto rate = static_cast<size_t>(Quantity::kVelocity);
  std::vector<const EffectInfo*> rows;
  for (const EffectInfo& row : list_effects()) {
    if (row.change.any()) rows.push_back(&row);
  }
  for (int j = 0; j < e.num_joints(); ++j) {
    const size_t joint = static_cast<size_t>(j);
    const double sigma = e.joint_noise[joint][rate].sigma;
    std::vector<double> gram(rows.size(), 0.0), projection = gram;
    double chi2 = 0.0;
    problem.view = {true, lead.paths.get(), j};
    for (int r : problem.train) {
      const Recording& data = e.recordings[static_cast<size_t>(r)];
      const std::vector<double>& reading = data.joints[joint].signal[rate];
      std::vector<double> residuals;
      if (reading.empty() || !calc_residuals(problem, lead.hypothesis, r, &residuals)) continue;
      const SmoothJoint& smooth = problem.smooth[static_cast<size_t>(r)].joints[joint];
      for (size_t k = problem.smooth[static_cast<size_t>(r)].judged; k < data.size(); ++k) {
        if (!std::isfinite(reading[k])) continue;
        const double left = residuals[k * kQuantities + rate] * sigma;
        chi2 += left * left;
        for (size_t i = 0; i < rows.size(); ++i) {
          const ReadingChange& c = rows[i]->change;
          const double column = c.constant + c.of_reading * (reading[k] - left) + c.of_rate * smooth.qdd[k];
          gram[i] += column * column;
          projection[i] += column * left;
        }
      }
    }
    for (size_t i = 0; i < rows.size(); ++i) {
      const EffectParameter& info = rows[i]->parameters[0];
      const Effect fault{
          rows[i]->id, at_sensor(j, Reading::kVelocity), {info.neutral + projection[i] / std::max(1e-12, gram[i])}};
      const bool helps = projection[i] * projection[i] > kDetail * chi2 * gram[i];
      const bool possible = info.lower < info.neutral || projection[i] > 0.0;
      const auto in = [&](const Hypothesis& set) { return contains(set, fault.id, fault.place); };
      if (helps && possible && !in(lead.hypothesis) && !in(*list)) list->push_back(fault);
    }
  }
}

}  // namespace

std::vector<Effect> list_starts(Problem& p, const Lead& lead, size_t count, const std::vector<char>& quiet) {
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
    const int joint = c.start.place.kind == PlaceKind::kJoint ? c.start.place.index : find_joint(c.start);
    const size_t j = static_cast<size_t>(std::max(0, joint));
    // Encoder offsets look like masses of links nearby. There are few, so all are tried once.
    const bool offset = get_effect(c.start.id).felt_elsewhere && lead.hypothesis.empty();
    const bool here = joint >= 0 && (there[j] < most[j] || offset) && c.gain > 0.0;
    // Some of links are tried beside better ones of joints.
    const bool body = c.start.place.kind == PlaceKind::kLink && bodies < kLookedAt && c.gain > 0.0;
    if (!high && !here && !body) continue;
    there[j] += joint >= 0 ? 1 : 0;
    bodies += body ? 1 : 0;
    list.push_back(c.start);
  }
  if (!lead.hypothesis.empty()) add_unseen(lead, &list);
  add_rate_faults(p, lead, &list);
  add_indistinguishable(lead, &list);
  list.erase(std::remove_if(list.begin(), list.end(), is_quiet), list.end());
  return list;
}

}  // namespace hrp::diagnosis
