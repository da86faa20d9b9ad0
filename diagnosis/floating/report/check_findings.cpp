// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/report/check_findings.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/checks/weight_check.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/fit/remaining.h"
#include "diagnosis/model/tree.h"

namespace hrp::diagnosis::floating {
namespace {

bool is(const Finding& f, const CandidateLaw& law) { return f.effect == law.info().name; }
bool is_at(const Finding& f, const char* signal) { return f.where.dump().find(signal) != std::string::npos; }
bool is_of_mass(const Finding& f) { return f.family == get_family_name(EffectFamily::kMass); }

// Whether an accelerometer's zero makes at least half of what the feet carry too much or too little.
bool holds_weight(const LeggedLog& log, const Finding& bias, const Finding& weight) {
  const LawTable& laws = get_laws();
  if (!is(bias, laws.sensor_bias) || !is_at(bias, "linear_acceleration")) return false;
  const auto scale = std::find_if(weight.alternatives.begin(), weight.alternatives.end(),
                                  [&](const Alternative& a) { return a.effect == laws.sensor_scale.info().name; });
  if (scale == weight.alternatives.end()) return false;
  double square = 0;
  for (double v : bias.parameters[0].value) square += v * v;
  const double g = log.experiment->scenario.gravity_W.norm();
  return std::sqrt(square) / g > 0.5 * std::abs(scale->parameters[0].value[0] - 1);
}

// Whether a finding of the search explains the weight that a check found too large or too small.
bool explains_weight(const LeggedLog& log, const Finding& found, const Finding& weight) {
  const bool scales = is(found, get_laws().sensor_scale) && is_at(found, "linear_acceleration");
  return is_of_mass(found) || is_at(found, "/wrench") || scales || holds_weight(log, found, weight);
}

// Whether the zero of an encoder between the base and a foot is off.
bool is_zero_of_leg(const LeggedLog& log, const Finding& found) {
  if (!is(found, get_laws().joint_offset) || !found.where.contains("joint")) return false;
  const int link = log.tree.find_joint(found.where.at("joint").get<std::string>()) + 1;
  return std::any_of(log.feet.begin(), log.feet.end(),
                     [&](const Foot& foot) { return is_above(log.tree, link, foot.link); });
}

// Whether a finding of the search is the cause of what a check found.
bool explains(const LeggedLog& log, bool raw_counts, const Finding& found, const Finding& check) {
  const LawTable& laws = get_laws();
  if (found.effect == check.effect && found.where == check.where) return true;
  // What a check cannot tell from other effects, the search may have found as one of them.
  const bool told = std::any_of(check.alternatives.begin(), check.alternatives.end(), [&](const Alternative& a) {
    return a.effect == found.effect && a.where == found.where;
  });
  if (is(check, laws.joint_offset) && (told || is(found, laws.flat_sole))) return true;
  if (is_of_mass(check) && explains_weight(log, found, check)) return true;
  // Soles that give sink by what they carry, and a leg whose zero is off reaches another height in each posture: like a
  // slope.
  if (is(check, laws.ground_slope) &&
      (is(found, laws.ground_slope) || is(found, laws.flat_sole) || is_zero_of_leg(log, found)))
    return true;
  // Scale and zero of one sensor are the same number. When it was read is another one.
  const bool alternatives =
      check.grade == Grade::kAmbiguous && !is(check, laws.sensor_delay) && !is(found, laws.sensor_delay);
  return alternatives && check.where.contains("sensor") && found.where == check.where && !raw_counts;
}

double calc_size(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<long>(values.size())).norm();
}

// What a recording was rid of, and what the search then finds of the same fault: their sum, or the product of scales.
// The larger part tells what else it may be.
Finding join_parts(const Finding& corrected, const Finding& found) {
  const bool scales = is(corrected, get_laws().sensor_scale);
  const auto distance = [&](const Finding& f) {
    return scales ? std::abs(f.parameters[0].value[0] - 1) : calc_size(f.parameters[0].value);
  };
  Finding out = distance(corrected) < distance(found) ? found : corrected;
  Estimate& sum = out.parameters[0];
  for (size_t i = 0; i < sum.value.size(); ++i) {
    const Estimate &a = corrected.parameters[0], &b = found.parameters[0];
    sum.value[i] = scales ? a.value[i] * b.value[i] : a.value[i] + b.value[i];
    sum.std[i] = std::hypot(a.std[i], b.std[i]);
  }
  out.statement = corrected.statement + " Beside it, the other equations move the value to the one given here.";
  return out;
}

// Whether the search has found more of a fault that the recordings were rid of. Then the whole of it is the finding.
bool join_corrected(const Finding& corrected, std::vector<Finding>* findings) {
  for (Finding& found : *findings) {
    if (found.effect != corrected.effect || found.where != corrected.where) continue;
    found = join_parts(corrected, found);
    return true;
  }
  return false;
}

// Puts a mass into the model, where it explains something. What the feet carry too much is one number, so that the fit
// says what a mass takes away, whatever the cause is.
void add_weight(const Candidate& mass, Finding* finding, ReportState* state) {
  const LeggedFitter& fitter = state->fitter;
  const LeggedFit& chosen = state->outcome.chosen;
  std::vector<Candidate> effects = state->model.effects;
  effects.push_back(mass);
  const LeggedFit with = fitter.fit(effects);
  const auto get = [&](const LeggedFit& fit, size_t c) { return get_mean_square(fitter, fit, c); };
  // Beside what the search has chosen, which takes its own equations.
  const auto gone = [&](size_t c) { return get(chosen, c) / fitter.floor(c) - get(with, c) / fitter.floor(c); };
  size_t best = 0;
  for (size_t c = 0; c < fitter.channels().size(); ++c) {
    if (gone(c) > gone(best)) best = c;
  }
  if (!with.x.allFinite() || get(with, best) >= get(chosen, best)) return;
  finding->share = std::clamp(1 - get(with, best) / get(chosen, best), 0.0, 1.0);
  state->model = with;
}

// Whether physics outside the table makes more than half of what the feet carry too much or too little: what pulls or
// holds the robot is no mass of it.
bool is_weight_pulled(const ReportState& state) {
  const std::vector<ChannelRows>& channels = state.fitter.channels();
  const ChannelRows* weight = find_weight_equation(channels);
  if (!weight || !has_free_law(state.outcome)) return false;
  const auto c = static_cast<size_t>(weight - channels.data());
  return get_mean_square(state.fitter, state.outcome.chosen, c) < kHalf * get_mean_square(state.fitter, state.model, c);
}

// Whether anything tells where a mass sits: moments about the feet, or joints that carry it. The sum of the feet's
// forces does not.
bool are_places_told(const ReportState& state) {
  const std::vector<ChannelRows>& channels = state.fitter.channels();
  return std::any_of(channels.begin(), channels.end(), [](const ChannelRows& c) {
    return c.rows() > 0 && (c.info.equation.is_of_whole_body() || c.info.equation.is(EquationKind::kJoint));
  });
}

// What the search named in the place of a weight's one number: a link among many, or a sensor that masses stand in for.
// The check says all of it. What was named stays as an alternative.
void take_weight(const ReportState& state, Finding check, std::vector<Finding>* findings) {
  const auto is_mass = [](const auto& f) { return f.family == get_family_name(EffectFamily::kMass); };
  for (Finding& found : *findings) {
    const bool among_masses = std::any_of(found.alternatives.begin(), found.alternatives.end(), is_mass);
    if (found.grade != Grade::kAmbiguous || !among_masses || !explains_weight(state.log, found, check)) continue;
    check.share = found.share;
    check.weight = found.weight;
    check.alternatives.push_back({found.effect, found.family, found.where, found.parameters,
                                  check.alternatives.empty() ? "" : check.alternatives[0].motion});
    found = std::move(check);
    return;
  }
}

}  // namespace

void add_check_findings(const CheckResult& checks, ReportState* state) {
  std::vector<Finding>& findings = state->evidence.findings;
  const bool pulled = is_weight_pulled(*state);
  const auto is_known = [&](const Finding& f) {
    return std::any_of(findings.begin(), findings.end(),
                       [&](const Finding& found) { return explains(state->log, checks.raw_counts, found, f); });
  };
  for (const Finding& f : checks.findings) {
    if (pulled && is_of_mass(f)) continue;
    if (is_known(f)) {
      if (is_of_mass(f) && !are_places_told(*state)) take_weight(*state, f, &findings);
      continue;
    }
    // Something that is not in the table moves bodies: what a check sees and cannot tell may be that.
    if (has_free_law(state->outcome) && f.grade == Grade::kAmbiguous) {
      state->evidence.remaining.push_back({f.where, "", 0.0, 0.0, {}, f.statement});
      continue;
    }
    findings.push_back(f);
    if (!checks.weight.empty() && is_of_mass(f)) add_weight(checks.weight[0], &findings.back(), state);
  }
  for (const Finding& f : checks.corrected) {
    if (!join_corrected(f, &findings)) findings.push_back(f);
  }
}

}  // namespace hrp::diagnosis::floating
