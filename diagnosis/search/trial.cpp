// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/trial.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/search/significance.h"

namespace hrp::diagnosis {
namespace {

constexpr double kBent = 3.0;       // ratio of held-out to training power above the noise
constexpr double kSurprise = 20.0;  // prior cost of a factor of e
constexpr double kEffectPrice = 60.0, kParameterPrice = 15.0;
constexpr double kDetailPrice = 0.004;  // per effect and reading: what details of laws may gain
constexpr double kEvidence = 20.0;      // correlated readings that count as one
constexpr double kSure = 10.0 * kEvidence;
constexpr double kLeastDearer = 30.0;  // per additional parameter

// Power of the held-out residual above the noise.
double calc_excess(const Trial& t) { return t.rms * t.rms - 1.0; }

// The same of the training residual.
double calc_train_excess(const Trial& t) { return std::pow(t.train.rms(), 2) - 1.0; }

double count_readings(const Trial& t) { return t.train.count + t.validate.count; }

// True if smooth effects overfit: together they can imitate other causes, but leave more in held-out recordings.
bool is_bent(const Trial& t) {
  const double fitted = std::max(0.0, calc_train_excess(t));
  return t.hypothesis.size() > 1 && is_smooth(t.hypothesis) && calc_excess(t) > kBent * fitted + kDetail;
}

// True if the training recordings show a mismatch that the model leaves, whatever the held-out ones show. A limit, for
// example, may be reached in one recording only.
bool leaves_training(const Trial& t, const Trial& nominal) {
  return t.train.rms() > kAboveNoise && calc_train_excess(t) > kTrace * calc_train_excess(nominal);
}

// Prior cost of factors far from one: of indistinguishable sets, one with a mass 50 times too large is unlikely.
double calc_surprise(const Hypothesis& hypothesis) {
  double surprise = 0.0;
  for (const Effect& effect : hypothesis) {
    if (list_infos(effect.id)[0].factor) surprise += kSurprise * std::pow(std::log(effect.p[0]), 2);
  }
  return surprise;
}

// Cost in units of the best one's noise plus prior costs. A further parameter must gain more than chance and details of
// laws.
double calc_price(const Trial& t, const Trial& best) {
  const double readings = count_readings(best), unit = std::max(1.0, calc_cost(best) / std::max(1.0, readings));
  return calc_cost(t) / unit + calc_own_price(t.hypothesis, readings);
}

bool is_simpler(const Hypothesis& a, const Hypothesis& b) {
  return a.size() < b.size() || (a.size() == b.size() && count_parameters(a) < count_parameters(b));
}

// True if `rotor` is the same set with rigid rotors in place of transmissions. The residual of such a rotor is no
// detail.
bool is_stiffer(const Hypothesis& rotor, const Hypothesis& transmission) {
  const auto stands = [&](const Effect& e) {
    if (contains(transmission, e.id, e.place)) return true;
    return is_rigid_rotor(e) && std::any_of(transmission.begin(), transmission.end(), [&](const Effect& t) {
             return t.place == e.place && get_effect(t.id).flexible;
           });
  };
  return rotor.size() == transmission.size() && std::all_of(rotor.begin(), rotor.end(), stands);
}

// Moves a simpler set to the front unless the richer one removes most of its residual above the noise.
void prefer_simple(const Trial& nominal, const Trial& best, std::vector<Trial>* list) {
  const double most = 2.0 * std::max(0.0, calc_excess(list->front())) + kDetail;
  for (size_t i = 1; i < list->size(); ++i) {
    const Trial& t = (*list)[i];
    const bool possible = is_noise(t) || is_explained(t, nominal);
    if (!is_simpler(t.hypothesis, list->front().hypothesis) || !possible || calc_excess(t) > most) continue;
    if (is_stiffer(t.hypothesis, list->front().hypothesis) &&
        calc_price(t, best) > calc_price(list->front(), best) + kSure)
      continue;
    std::rotate(list->begin(), list->begin() + static_cast<long>(i), list->begin() + static_cast<long>(i) + 1);
  }
}

// Probabilities from cost differences, divided by kEvidence because residuals are correlated. A richer set that lost to
// the simpler one does not gain by its additional parameters.
void set_probabilities(const Trial& best, std::vector<Trial>* list) {
  const double price = calc_price(list->front(), best);
  const double parameters = static_cast<double>(count_parameters(list->front().hypothesis));
  double sum = 0.0;
  for (Trial& t : *list) {
    const double more = static_cast<double>(count_parameters(t.hypothesis)) - parameters;
    sum += t.probability = calc_odds(calc_price(t, best) - price, more);
  }
  for (Trial& t : *list) t.probability /= sum;
}

}  // namespace

Hypothesis Trial::full() const {
  Hypothesis all = hypothesis;
  all.insert(all.end(), timing.begin(), timing.end());
  return all;
}

double calc_own_price(const Hypothesis& hypothesis, double readings) {
  return calc_surprise(hypothesis) + (kEffectPrice + kDetailPrice * readings) * static_cast<double>(hypothesis.size()) +
         kParameterPrice * static_cast<double>(count_parameters(hypothesis));
}

double calc_odds(double dearer, double more_parameters) {
  return std::exp(-0.5 * std::min(1400.0, std::max(dearer, kLeastDearer * std::max(0.0, more_parameters)) / kEvidence));
}

double calc_dearer(double probability) { return -2.0 * kEvidence * std::log(probability / (1.0 - probability)); }

double calc_cost(const Trial& t) { return t.rms >= 1e299 ? 1e300 : t.train.chi2 + t.validate.chi2; }

std::vector<double> get_std(const Trial& trial, size_t effect) {
  return effect < trial.std.size() ? trial.std[effect] : std::vector<double>();
}

size_t count_parameters(const Hypothesis& hypothesis) {
  size_t count = 0;
  for (const Effect& effect : hypothesis) count += effect.p.size();
  return count;
}

bool is_noise(const Trial& t) { return t.rms < kNoiseLeft && t.worst < 1.7 && t.train.rms() < 1.4; }

bool is_detail(const Trial& t, const Trial& nominal) { return calc_excess(t) < 1e-3 * calc_excess(nominal); }

bool is_explained(const Trial& t, const Trial& nominal) {
  if (t.hypothesis.empty()) return false;
  if (is_noise(t)) return true;
  if (is_bent(t) || leaves_training(t, nominal)) return false;
  return (t.rms < 2.0 && is_detail(t, nominal)) || (t.rms < kNoiseLeft && calc_excess(t) < 3e-3 * calc_excess(nominal));
}

bool is_complete(const Trial& t, const Trial& nominal) {
  const bool passes = is_smooth(t.hypothesis) ? calc_excess(t) <= kDetail : t.rms < kNoiseLeft;
  return is_explained(t, nominal) && passes;
}

void sort_by_preference(const Trial& nominal, std::vector<Trial>* list) {
  const Trial best = list->front();
  std::stable_sort(list->begin(), list->end(),
                   [&](const Trial& a, const Trial& b) { return calc_price(a, best) < calc_price(b, best); });
  prefer_simple(nominal, best, list);
  set_probabilities(best, list);
}

}  // namespace hrp::diagnosis
