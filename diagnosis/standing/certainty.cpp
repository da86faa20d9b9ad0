// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/standing/dependence.h"
#include "diagnosis/standing/searcher.h"

namespace hrp::diagnosis::standing {
namespace {

// Effects of links, IMU and force sensors appear in the balance of the whole body. If the balance contains an unknown
// force, none of them is certain.
bool acts_on_balance(const Effect& e) { return is_link(e) || is_imu(e) || is_wrench(e); }

bool are_about_one_place(const Channel& a, const Channel& b) {
  return a.kind == b.kind && a.joint == b.joint && a.foot == b.foot && a.sensor == b.sensor && a.link == b.link;
}

}  // namespace

StandFit StandSearcher::judge(const Hypothesis& h) const {
  return judge_.judge(h, evaluate(p_, h),
                      judge_.find_extra_noise(evaluate(problems_.even, h), evaluate(problems_.odd, h)));
}

void StandSearcher::update_noise(const Hypothesis& h) {
  const StandProblems& p = problems_;
  judge_.update_sigma(evaluate(p_, h),
                      {evaluate(p.even, h), evaluate(p.odd, h), evaluate(p.wide_even, h), evaluate(p.wide_odd, h)}, h);
}

// Final fit of a hypothesis with its covariance. Contact stiffness and slip add to the variance where they matter.
StandFit StandSearcher::finish(const StandFit& so_far, const Hypothesis& hypothesis) const {
  Hypothesis h = hypothesis;
  Eigen::MatrixXd covariance;
  if (!polish(problems_, judge_.select(so_far), 3, &h, &covariance)) {
    const Evaluation base = evaluate(p_, h);
    covariance = solve(p_, judge_.select(so_far), h, differentiate(p_, h, 0, base, judge_.train()), base).covariance;
  }
  for (Effect& e : h) {
    if (get_row(e).loose) find_seen_play(p_, h, &e);
  }
  StandFit fit = judge(h);
  long at = 0;
  for (const Effect& e : h) {
    const auto n = static_cast<long>(e.p.size());
    Eigen::MatrixXd own = covariance.block(at, at, n, n);
    for (long i = 0; i < n; ++i) {
      if (get_row(e).slides) own(i, i) = std::pow(slip_spread_ / 2, 2);
      if (get_row(e).tilts_feet) own(i, i) += n == 1 ? give_.squaredNorm() : give_(i) * give_(i);
    }
    fit.covariance.push_back(own);
    fit.std.push_back(own.diagonal().cwiseMax(0).cwiseSqrt());
    at += n;
  }
  return fit;
}

StandFit StandSearcher::judge_again(const StandFit& fit) const {
  StandFit out = judge(fit.hypothesis);
  out.std = fit.std;
  out.covariance = fit.covariance;
  return out;
}

// True if each recording alone gives the same parameters, within its errors and a fifth of the value. A true effect is
// the same in all recordings.
bool StandSearcher::is_consistent(size_t effect) const {
  const Hypothesis& h = out_.chosen.hypothesis;
  size_t first = 0;
  for (size_t i = 0; i < effect; ++i) first += h[i].p.size();
  const Evaluation base = evaluate(p_, h);
  const std::vector<Derivative> columns = differentiate(p_, h, 0, base, all_);
  const StandRow& row = get_row(h[effect]);
  FitSelection selection = judge_.select(out_.chosen);
  for (size_t r = 0; r < p_.recordings.size(); ++r) {
    selection.recordings = {r};
    const StandStep step = solve(p_, selection, h, columns, base);
    if (!step.ok) continue;
    for (size_t i = 0; i < h[effect].p.size(); ++i) {
      if (!is_main(h[effect], i)) continue;
      const auto at = static_cast<long>(first + i);
      const double size = std::abs(h[effect].p[i] - row.neutral[i % row.neutral.size()]);
      const double off = std::abs(step.delta(at)), std = std::sqrt(std::max(0.0, step.covariance(at, at)));
      if (off > 4 * std + 0.2 * size && off > 4 * out_.chosen.std[effect](static_cast<long>(i))) return false;
    }
  }
  return true;
}

// True if an elastic transmission explains more than soft soles and ground can, whatever their stiffness. A foot tilts
// by its own moment, a leg by the moment of its joint. The possible compliance of the ground is then no reason to doubt
// the transmission.
bool StandSearcher::exceeds_ground(const StandFit& fit) const {
  const auto flat = [](const StandFoot& f) { return f.kind == SoleKind::kFlat; };
  if (!get_row(fit.hypothesis.back()).bends_leg || !std::all_of(p_.feet.begin(), p_.feet.end(), flat)) {
    return false;
  }
  Hypothesis h = fit.hypothesis;
  h.pop_back();
  if (std::any_of(h.begin(), h.end(), [](const Effect& e) { return is_foot(e); })) return true;
  const Effect soles = make_soft_soles(p_);
  h.push_back(soles);
  const StandFit soft = judge(refine(p_, judge_.select(out_.chosen), h, 2));
  return soft.score - kCorrelated * static_cast<double>(soles.p.size()) > fit.score + kGain;
}

// Checks whether a displaced centre of mass beside a force may be a load. At rest, the weight of a load equals a force,
// and its lever a displaced centre of mass. Only the force that accelerates the load distinguishes them. Returns a load
// of unknown size if the mass from the force is within its 95 % interval of zero; else nothing.
std::optional<Effect> StandSearcher::find_load(size_t effect) const {
  Hypothesis h = out_.chosen.hypothesis;
  const Effect& offset = h[effect];
  const auto is_vector_of = [](const Effect& e, EffectFamily family) {
    return is_link(e) && is_vector(e) && get_effect(e.id).family == family;
  };
  const auto pulls = [&](const Effect& e) { return is_vector_of(e, EffectFamily::kZero) && e.place == offset.place; };
  const auto force = std::find_if(h.begin(), h.end(), pulls);
  if (!is_vector_of(offset, EffectFamily::kMass) || force == h.end() || force->p[2] >= 0) return std::nullopt;
  const double load = -force->p[2] / p_.experiment->scenario.gravity_W.norm();
  const double mass = p_.tree.links[static_cast<size_t>(offset.place.index)].inertia.mass;
  long at = 0;
  for (size_t i = 0; i < effect; ++i) at += static_cast<long>(h[i].p.size());
  force->p[2] = 0;
  h[effect] = {EffectId::kPayload, offset.place, {load, mass * offset.p[0], mass * offset.p[1], mass * offset.p[2]}};
  const Effect none{h[effect].id, offset.place, {0, 0, 0, 0}};
  Eigen::MatrixXd covariance;
  if (!polish(problems_, judge_.select(out_.chosen), 0, &h, &covariance)) return std::nullopt;
  return load < kNinetyFive * std::sqrt(covariance(at, at)) ? std::optional<Effect>(none) : std::nullopt;
}

// Checks whether a force that pulls a link down may be its weight. What a mass leaves depends on the noise of the
// acceleration that it multiplies, so that residuals do not decide between the two. Products of even with odd samples
// do. Returns the mass, unless beside it something of the force is beyond chance.
std::optional<Effect> StandSearcher::find_weight(size_t effect) const {
  Hypothesis h = out_.chosen.hypothesis;
  const Effect force = h[effect];
  const bool pulls = is_link(force) && is_vector(force) && get_effect(force.id).family == EffectFamily::kZero;
  if (!pulls || force.p[2] >= 0) return std::nullopt;
  const double mass = p_.tree.links[static_cast<size_t>(force.place.index)].inertia.mass;
  Effect heavier{
      EffectId::kMassError, force.place, {1 - force.p[2] / (mass * p_.experiment->scenario.gravity_W.norm())}};
  h[effect].p = {0, 0, 0};
  h.push_back(heavier);
  Eigen::MatrixXd covariance;
  if (!polish(problems_, judge_.select(out_.chosen), 3, &h, &covariance)) return heavier;
  long at = 0;
  for (size_t i = 0; i < effect; ++i) at += static_cast<long>(h[i].p.size());
  const Eigen::Vector3d left = Eigen::Map<const Eigen::Vector3d>(h[effect].p.data());
  const bool needed =
      calc_deviations(left, covariance.block<3, 3>(at, at)) > find_deviations(find_length(kNinetyFive, 3));
  return needed ? std::nullopt : std::optional<Effect>(heavier);
}

// Links that carry the one whose centre of mass was found elsewhere. Where the joints between them hardly move, all of
// them displace the robot's centre alike, and slow errors of sensors decide between them: the model of the noise does
// not hold these. Returns the displacements that leave no more than the noise of any equation, or than the found one
// does.
std::vector<Effect> StandSearcher::find_displaced(size_t effect) const {
  std::vector<Effect> out;
  const Effect& found = out_.chosen.hypothesis[effect];
  if (found.id != EffectId::kComError) return out;
  for (int l = found.place.index; l > 0;) {
    l = p_.tree.links[static_cast<size_t>(l)].parent;
    if (l < 0 || p_.tree.links[static_cast<size_t>(l)].inertia.mass <= 0) continue;
    Hypothesis h = out_.chosen.hypothesis;
    h.erase(h.begin() + static_cast<long>(effect));
    h.push_back({found.id, {PlaceKind::kLink, l}, {0, 0, 0}});
    const StandFit fit = fit_trial(out_.chosen, h, 3);
    const auto leaves_more = [&](auto set, size_t c) {
      return (fit.*set)[c] > (1 + kDetail) * std::max(1.0, (out_.chosen.*set)[c]);
    };
    bool more = fit.score >= 1e299;
    for (size_t c = 0; c < channels(); ++c)
      more = more || leaves_more(&StandFit::channel_rms, c) || leaves_more(&StandFit::train_rms, c);
    if (!more) out.push_back(fit.hypothesis.back());
  }
  return out;
}

// True if the equations that need an effect are noise with it. A stand-in hardly ever explains its equations
// completely. Equations at one place count together. An unknown force on the body appears in its balance as a force or
// a moment, and a displaced mass may remove only one of them.
bool StandSearcher::explains_its_part(size_t effect) const {
  Hypothesis rest = out_.chosen.hypothesis;
  rest.erase(rest.begin() + static_cast<long>(effect));
  const StandFit without = judge(rest);
  // Each set of recordings (held-out, training) is judged on its own: held-out ones need not show the effect, for
  // example if feet stand on their edges.
  const std::vector<double> StandFit::*sets[] = {&StandFit::channel_rms, &StandFit::train_rms};
  const auto gain = [&](auto set, size_t c) { return (without.*set)[c] - (out_.chosen.*set)[c]; };
  double most = 0;
  for (auto set : sets) {
    for (size_t c = 0; c < channels(); ++c) most = std::max(most, gain(set, c));
  }
  for (auto set : sets) {
    for (size_t c = 0; c < channels(); ++c) {
      if (gain(set, c) < kPart * most) continue;
      for (size_t other = 0; other < channels(); ++other) {
        if (!are_about_one_place(out_.channels[c], out_.channels[other])) continue;
        if (!StandJudge::is_quiet((out_.chosen.*set)[other], (without.*set)[other])) return false;
      }
    }
  }
  return true;
}

bool StandSearcher::is_balanced() const {
  for (size_t c = 0; c < channels(); ++c) {
    const bool quiet = StandJudge::is_quiet(out_.chosen.channel_rms[c], out_.nominal.channel_rms[c]);
    if (out_.channels[c].kind == ChannelKind::kBalance && !quiet) return false;
  }
  return true;
}

// True if the residual of another joint follows the position of this effect's joint, as if something coupled the two.
bool StandSearcher::is_coupled(size_t effect) const {
  const Effect& e = out_.chosen.hypothesis[effect];
  if (!is_joint(e)) return false;
  const Evaluation left = evaluate(p_, out_.chosen.hypothesis);
  for (size_t c = 0; c < channels(); ++c) {
    if (out_.channels[c].kind != ChannelKind::kEffort || out_.chosen.channel_rms[c] < kAboveNoise) continue;
    if (follows_joint(p_, out_.channels[c], c, left, e.place.index)) return true;
  }
  return false;
}

size_t StandSearcher::find_effort_channel(int joint) const {
  const std::string& name = p_.tree.joint(joint).name;
  size_t c = 0;
  while (c < channels() && !(out_.channels[c].kind == ChannelKind::kEffort && out_.channels[c].joint == name)) ++c;
  return c;
}

// Refuses effects of joints that something couples. Signs of a coupling: two drives lack equal and opposite efforts, or
// one spring across two joints explains as much as a spring in each.
void StandSearcher::refuse_couplings() {
  const Evaluation nominal = evaluate(p_, {});
  const Hypothesis& h = out_.chosen.hypothesis;
  for (const Effect& a : h) {
    for (const Effect& b : h) {
      if (!is_joint(a) || !is_joint(b) || a.place.index >= b.place.index) continue;
      const size_t x = find_effort_channel(a.place.index), y = find_effort_channel(b.place.index);
      if (x >= channels() || y >= channels()) continue;
      out_.opposite = out_.opposite || are_equal(nominal, channels(), x, y, -1);
      if (!get_row(a).follows_position || !get_row(b).follows_position) continue;
      const SpringPair pair{{x, y}, {a.place.index, b.place.index}, {judge_.sigma()[x], judge_.sigma()[y]}};
      out_.coupled = out_.coupled || calc_spring_gain(p_, nominal, pair) < kCorrelated * std::log(1 / kMinor);
    }
  }
  if (out_.opposite || out_.coupled) out_.explained = false;
}

// Dry friction whose level depends on the position is not in the list of effects.
void StandSearcher::refuse_uneven_friction() {
  const Evaluation left = evaluate(p_, out_.chosen.hypothesis);
  for (const Effect& e : out_.chosen.hypothesis) {
    if (!get_effect(e.id).sticks) continue;
    const size_t c = find_effort_channel(e.place.index);
    if (c >= channels()) continue;  // no effort was recorded
    out_.uneven = out_.uneven || calc_uneven_gain(p_, left, c, static_cast<size_t>(e.place.index)) > kGain;
  }
  if (out_.uneven) out_.explained = false;
}

// Refuses several effects in one joint unless they are certain, because together they can fit physics that is none of
// them. Each must be the same in every recording, the missing effort must be no sinusoid of time, and the residual must
// be noise.
void StandSearcher::refuse_bundles() {
  const Hypothesis& h = out_.chosen.hypothesis;
  const Evaluation nominal = evaluate(p_, {});
  const auto is_periodic = [&](int joint) {
    const size_t c = find_effort_channel(joint);
    return c < channels() && follows_time(p_, out_.channels[c], c, nominal);
  };
  for (size_t i = 0; i < h.size(); ++i) {
    const auto beside = [&](const Effect& e) {
      return &e != &h[i] && is_joint(e) && is_joint(h[i]) && e.place == h[i].place;
    };
    if (std::none_of(h.begin(), h.end(), beside)) continue;
    out_.periodic = out_.periodic || is_periodic(h[i].place.index);
    // Stricter than is_quiet(): a residual of a thousandth of the power, as details of a law may leave, is not enough
    // here.
    const size_t c = find_effort_channel(h[i].place.index);
    const bool noise = c >= channels() || out_.chosen.channel_rms[c] < kSeveralTimes;
    out_.bent = out_.bent || !noise;
    if (out_.periodic || out_.bent || !is_consistent(i)) out_.explained = false;
  }
}

// True if a drive with an effect lacks the same effort as another drive, or the opposite one. Identical drives in
// identical motion do so, too. Therefore this is used only if something remains unexplained.
bool StandSearcher::has_equal_drives() const {
  const Evaluation nominal = evaluate(p_, {});
  for (const Effect& e : out_.chosen.hypothesis) {
    if (!is_joint(e)) continue;
    const size_t own = find_effort_channel(e.place.index);
    for (size_t c = 0; c < channels(); ++c) {
      const bool agrees = std::max(out_.nominal.channel_rms[c], out_.nominal.train_rms[c]) < kAboveNoise;
      if (out_.channels[c].kind != ChannelKind::kEffort || c == own || agrees) continue;
      if (are_equal(nominal, channels(), own, c, 1) || are_equal(nominal, channels(), own, c, -1)) return true;
    }
  }
  return false;
}

// Pairs of effects, the earlier one first, of which one takes back nearly all that the other changes: a link that is
// too light and an accelerometer that reads too little gravity are the same weight, and what both leave is the
// mismatch. Neither has a value of its own.
std::vector<std::pair<size_t, size_t>> StandSearcher::list_undone(const Hypothesis& h) const {
  std::vector<std::pair<size_t, size_t>> pairs;
  if (h.size() < 2) return pairs;
  const Evaluation none = evaluate(p_, {});
  const auto calc_change = [&](const Evaluation& e) {  // in squares of the noise
    double sum = 0;
    for (size_t r = 0; r < none.size(); ++r) {
      for (size_t i = 0; i < none[r].residuals.size(); ++i) {
        sum += std::pow((e[r].residuals[i] - none[r].residuals[i]) / judge_.sigma()[i % channels()], 2);
      }
    }
    return sum;
  };
  std::vector<double> alone;
  for (const Effect& effect : h) alone.push_back(calc_change(evaluate(p_, {effect})));
  for (size_t i = 0; i < h.size(); ++i) {
    for (size_t k = i + 1; k < h.size(); ++k) {
      if (calc_change(evaluate(p_, {h[i], h[k]})) < kDetail * std::min(alone[i], alone[k])) pairs.emplace_back(i, k);
    }
  }
  return pairs;
}

// Removes uncertain effects if something remains unexplained. An effect may then be a stand-in, so it is named only if
// it is the same in all recordings and explains its equations.
void StandSearcher::doubt() {
  out_.opposite = out_.opposite || has_equal_drives();
  const std::vector<std::pair<size_t, size_t>> undone = list_undone(out_.chosen.hypothesis);
  std::vector<char> gone(out_.chosen.hypothesis.size(), 0);
  for (size_t i = out_.chosen.hypothesis.size(); i-- > 0;) {
    const bool joint = is_joint(out_.chosen.hypothesis[i]);
    const bool refused = joint && (out_.opposite || out_.coupled || out_.periodic || out_.uneven || out_.bent);
    const bool sure = !acts_on_balance(out_.chosen.hypothesis[i]) || is_balanced();
    const bool alone = std::none_of(undone.begin(), undone.end(), [&](const auto& pair) {
      return pair.second == i || (pair.first == i && !gone[pair.second]);
    });
    if (!refused && alone && sure && is_consistent(i) && explains_its_part(i) && !is_coupled(i)) continue;
    gone[i] = 1;
    out_.doubtful.push_back(out_.chosen.hypothesis[i]);
    out_.chosen.hypothesis.erase(out_.chosen.hypothesis.begin() + static_cast<long>(i));
    out_.rounds.erase(out_.rounds.begin() + static_cast<long>(i));
  }
  if (out_.doubtful.empty()) return;
  const StandFit fit = judge(out_.chosen.hypothesis);
  out_.chosen = fit.hypothesis.empty() ? fit : finish(fit, refine(p_, judge_.select(fit), fit.hypothesis, 2));
}

}  // namespace hrp::diagnosis::standing
