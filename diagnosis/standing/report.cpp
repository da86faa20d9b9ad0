// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "common/base/rounding.h"
#include "diagnosis/findings/grading.h"
#include "diagnosis/report/effect_shares.h"
#include "diagnosis/standing/dependence.h"
#include "diagnosis/standing/findings.h"

namespace hrp::diagnosis::standing {
namespace {

const StandTrial* find_runner_up(const StandOutcome& o, size_t round) {
  if (round >= o.rounds.size()) return nullptr;
  const Effect& chosen = o.chosen.hypothesis[round];
  for (const StandTrial& t : o.rounds[round]) {
    const Effect& e = t.fit.hypothesis[round];
    if (t.fit.score < 1e299 && (e.id != chosen.id || !(e.place == chosen.place))) return &t;
  }
  return nullptr;
}

std::string spell(std::string out) {
  std::replace(out.begin(), out.end(), '_', ' ');
  return out;
}

std::string make_statement(const StandProblem& p, const StandOutcome& o, size_t round, const std::string& where,
                           const std::vector<Estimate>& parameters) {
  const std::string& phrase = get_effect(o.chosen.hypothesis[round].id).phrase;
  std::string out = where + ": " + phrase + " (" + describe_values(parameters) + ").";
  if (const StandTrial* second = find_runner_up(o, round)) {
    const Effect& other = second->fit.hypothesis[round];
    const double worst = *std::max_element(second->fit.channel_rms.begin(), second->fit.channel_rms.end());
    out += " The next best explanation, " + spell(get_effect(other.id).name) + " at " + find_place(p, other).second +
           ", leaves up to " + number(worst, 2) + " times the noise.";
  }
  return out;
}

// Values of a rival as its trial was fitted. No interval was calculated.
std::vector<Estimate> make_bare_parameters(const StandProblem& p, const Effect& e, size_t foot) {
  std::vector<Estimate> out = make_parameters(p, e, Eigen::VectorXd::Zero(static_cast<long>(e.p.size())), foot);
  for (Estimate& parameter : out) parameter.std.clear();
  return out;
}

std::vector<Alternative> list_alternatives(const StandProblem& p, const std::vector<Effect>& others, size_t foot) {
  std::vector<Alternative> out;
  for (const Effect& e : others) {
    const auto [kind, name] = find_place(p, e);
    out.push_back(make_alternative(get_effect(e.id), {{kind, name}}, make_bare_parameters(p, e, foot), ""));
  }
  return out;
}

// Share of the squared residual above the noise that each effect removes (Shapley), on held-out recordings if there are
// any.
std::vector<double> calc_shares(const StandProblem& p, const StandOutcome& o) {
  const bool train = std::all_of(p.recordings.begin(), p.recordings.end(), [](const auto& r) { return r.train; });
  const auto calc_left = [&](const Hypothesis& part) { return calc_fit(p, o, evaluate(p, part), train); };
  return calc_effect_shares(o.chosen.hypothesis, calc_left({}), calc_left);
}

void add_findings(const StandProblem& p, const StandOutcome& o, std::vector<Finding>* findings) {
  const std::vector<double> shares = calc_shares(p, o);
  for (size_t i = 0; i < o.chosen.hypothesis.size(); ++i) {
    const Effect& e = o.chosen.hypothesis[i];
    double probability = i < o.rounds.size() ? 0 : 0.999;
    for (const StandTrial& t : i < o.rounds.size() ? o.rounds[i] : std::vector<StandTrial>{}) {
      const Effect& tried = t.fit.hypothesis[i];
      if (tried.id == e.id && tried.place == e.place) probability = std::min(0.999, t.probability);
    }
    const size_t places = is_foot(e) ? p.feet.size() : 1;
    for (size_t f = 0; f < places; ++f) {
      auto [kind, name] = find_place(p, e);
      if (is_foot(e)) name = p.feet[f].name;
      Finding finding =
          make_finding(get_effect(e.id), {{kind, name}}, make_parameters(p, e, o.widening * o.chosen.std[i], f));
      finding.share = finding.weight = std::clamp(shares[i], 0.0, 1.0) / static_cast<double>(places);
      finding.probability = probability;
      finding.statement = make_statement(p, o, i, name, finding.parameters);
      if (i < o.indistinguishable.size()) finding.alternatives = list_alternatives(p, o.indistinguishable[i], f);
      findings->push_back(std::move(finding));
    }
  }
}

// Place of a channel in the form of the schema.
Json make_where(const Channel& c) {
  if (!c.joint.empty()) return {{"joint", c.joint}};
  if (!c.foot.empty()) return {{"foot", c.foot}};
  if (!c.sensor.empty()) return {{"sensor", c.sensor}};
  return {{"link", c.link}};
}

// Describes what remains: the worst channel, and up to two other places that stand out at least half as much.
void add_unexplained(const StandProblem& p, const StandOutcome& o, std::vector<Unexplained>* out) {
  const Evaluation left = evaluate(p, o.chosen.hypothesis);
  std::vector<size_t> order(o.channels.size());
  for (size_t c = 0; c < order.size(); ++c) order[c] = c;
  std::vector<double> rms = o.shared;
  for (size_t c = 0; o.shared.empty() && c < order.size(); ++c) {
    rms.push_back(std::max(o.chosen.channel_rms[c], o.chosen.train_rms[c]));
  }
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return rms[a] > rms[b]; });
  std::vector<Json> places;
  for (size_t c : order) {
    const Json where = make_where(o.channels[c]);
    const bool loud = o.shared.empty() ? rms[c] >= 2 : rms[c] > 0;
    if (places.size() >= 3 || (!places.empty() && (!loud || rms[c] < 0.5 * rms[order[0]]))) break;
    if (has(places, where)) continue;
    places.push_back(where);
    std::string statement = "What is left at " + where.begin().value().get<std::string>() +
                            " (equation: " + get_text(o.channels[c].kind) + ") is up to " + number(rms[c], 2) +
                            " times its noise; no known effect explains it.";
    if (!o.shared.empty()) statement += " It hardly shows, but lasts longer than noise does.";
    if (o.opposite) {
      statement += " Two drives lack equal or opposite efforts, as if something coupled them.";
    } else if (o.coupled) {
      statement += " One spring across two joints would explain as much as a spring in each.";
    } else if (o.uneven) {
      statement += " Dry friction explains it only if its level follows the position.";
    } else if (o.periodic) {
      statement += " What the drive lacks is one sinusoid of time.";
    } else if (!o.doubtful.empty()) {
      statement += " The nearest, " + spell(get_effect(o.doubtful.back().id).name) +
                   ", does not leave noise where it acts, or differs from recording to recording.";
    }
    const Relation follows = find_dependence(p, o.channels[c], c, left);
    if (!follows.names.empty()) statement += " It follows " + follows.words + ".";
    out->push_back({where, follows.names, statement});
  }
}

}  // namespace

double calc_fit(const StandProblem& p, const StandOutcome& o, const Evaluation& evaluation, bool train) {
  double sum = 0, count = 0;
  for (size_t r = 0; r < p.recordings.size(); ++r) {
    if (p.recordings[r].train != train) continue;
    const std::vector<double>& flat = evaluation[r].residuals;
    for (size_t k = 0; k < flat.size(); ++k) {
      const double z = flat[k] / o.sigma[k % o.channels.size()];
      sum += z * z;
      count += flat[k] != 0;
    }
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

namespace {

// Rms of the columns of a channel's signal about their means, in the signal's unit; 0 if no column is found.
double calc_spread(const StandProblem& p, const std::string& signal, bool held) {
  double sum = 0, count = 0;
  for (const Recording& recording : p.experiment->recordings) {
    if (held && recording.spec.train) continue;
    const auto add = [&](const std::vector<double>& column) {
      double mean = 0, n = 0;
      for (double v : column) {
        if (std::isfinite(v)) {
          mean += v;
          ++n;
        }
      }
      for (double v : column) {
        if (std::isfinite(v)) {
          sum += std::pow(v - mean / n, 2);
          ++count;
        }
      }
    };
    for (const auto& [name, column] : recording.other) {
      if (name.rfind(signal + "/", 0) == 0) add(column);
    }
    for (size_t j = 0; j < recording.joints.size(); ++j) {
      for (int q = 0; q < kQuantities; ++q) {
        if (p.experiment->signal_name(static_cast<int>(j), static_cast<Quantity>(q)) == signal) {
          add(recording.joints[j].signal[q]);
        }
      }
    }
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

// By signal, the largest residual of its channels relative to the spread of the signal.
std::vector<SignalFit> list_signals(const StandProblem& p, const StandOutcome& o) {
  const bool held = std::any_of(p.recordings.begin(), p.recordings.end(), [](const auto& r) { return !r.train; });
  std::vector<SignalFit> out;
  for (size_t c = 0; c < o.channels.size(); ++c) {
    const Channel& channel = o.channels[c];
    double spread = calc_spread(p, channel.signal, held);
    // A quaternion's component is half an angle. A gap has no recorded signal in metres.
    if (channel.kind == ChannelKind::kTilt || channel.kind == ChannelKind::kBase) spread *= 2;
    if (spread == 0 || channel.kind == ChannelKind::kGap) continue;
    const SignalFit own{
        channel.signal,        "", o.nominal.channel_rms[c] * o.sigma[c], o.chosen.channel_rms[c] * o.sigma[c], spread,
        get_text(channel.kind)};
    const auto same = std::find_if(out.begin(), out.end(), [&](const SignalFit& s) { return s.signal == own.signal; });
    if (same == out.end())
      out.push_back(own);
    else if (same->before / same->spread < own.before / spread)
      *same = own;
  }
  return out;
}

Fit find_fit(const StandProblem& p, const StandOutcome& o) {
  const Evaluation nominal = evaluate(p, {}), chosen = evaluate(p, o.chosen.hypothesis);
  return {calc_fit(p, o, nominal, true), calc_fit(p, o, chosen, true), calc_fit(p, o, nominal, false),
          calc_fit(p, o, chosen, false), list_signals(p, o)};
}

void add_mismatch(const StandProblem& p, const StandOutcome& o, std::vector<Mismatch>* out) {
  const Evaluation nominal = evaluate(p, {});
  for (size_t c = 0; c < o.channels.size(); ++c) {
    const bool shared = !o.shared.empty() && o.shared[c] > 0;
    for (size_t r = 0; (shared || o.nominal.channel_rms[c] >= 2) && r < p.recordings.size(); ++r) {
      const StandRecording& recording = p.recordings[r];
      double sum = 0, count = 0, begin = -1, end = -1;
      std::vector<std::pair<double, double>> intervals;
      for (size_t s = 0; s < recording.samples.size(); ++s) {
        const double z = nominal[r].residuals[s * o.channels.size() + c] / o.sigma[c];
        const double t = recording.time[static_cast<size_t>(recording.samples[s])];
        sum += z * z;
        ++count;
        if (std::abs(z) < 4) continue;
        if (begin < 0 || t > end + 0.15) {
          if (begin >= 0) intervals.emplace_back(begin, end);
          begin = t;
        }
        end = t;
      }
      if (begin >= 0) intervals.emplace_back(begin, end);
      const double score = std::sqrt(sum / count);
      if (!shared && score < 2) continue;
      out->push_back({o.channels[c].signal, recording.file, score, intervals, "stance", get_text(o.channels[c].kind)});
    }
  }
  std::stable_sort(out->begin(), out->end(), [](const Mismatch& a, const Mismatch& b) { return a.score > b.score; });
}

const char* const kOtherSign = "loads on the joint that change their sign";

void add_not_identifiable(const StandProblem& p, const StandOutcome& o, std::vector<NotIdentifiable>* out) {
  for (const Effect& e : o.chosen.hypothesis) {
    if (!is_foot(e)) continue;
    out->push_back({"foot_compliance.cz", nullptr, "a standing robot hardly moves up and down on its soles",
                    "short vertical bounces above 5 Hz"});
  }
  for (const Effect& e : o.chosen.hypothesis) {
    if (!get_row(e).loose || e.p[3] == 0) continue;
    const auto [kind, name] = find_place(p, e);
    out->push_back({"backlash.gap",
                    {{kind, name}},
                    "no torque held the teeth on both sides: the gap is at least as wide as what was seen",
                    kOtherSign});
  }
  for (size_t i = 0; i < o.indistinguishable.size(); ++i) {
    for (const Effect& e : o.indistinguishable[i]) {
      const auto [kind, name] = find_place(p, e);
      if (get_row(e).loose && get_row(o.chosen.hypothesis[i]).tilts_feet) {
        out->push_back({get_effect(e.id).name,
                        {{kind, name}},
                        "the torque on the joint never changed its sign: teeth " + number(e.p[0], 2) +
                            " rad apart would look like the offset",
                        kOtherSign});
        continue;
      }
      out->push_back({get_effect(e.id).name,
                      {{kind, name}},
                      "explains the held-out recordings about as well as what is reported",
                      "wider and faster sweeps of the joints and of the trunk's lean"});
    }
  }
  out->push_back(
      {"restitution", {{"ground", "ground"}}, "feet that stay on the ground do not bounce", "hops that land flat"});
  const bool any_effort = std::any_of(p.effort.begin(), p.effort.end(), [](bool b) { return b; });
  if (any_effort) return;
  out->push_back({"torque_saturation", nullptr, "no effort was recorded; the servo law stands in for it",
                  "any, with the drives' efforts recorded"});
}

}  // namespace

Json make_stand_report(const StandProblem& p, const StandOutcome& o) {
  Evidence evidence;
  evidence.verdict = find_verdict(o.mismatch, o.explained, !o.chosen.hypothesis.empty());
  if (o.mismatch) add_mismatch(p, o, &evidence.mismatch);
  add_findings(p, o, &evidence.findings);
  if (o.mismatch && !o.explained) add_unexplained(p, o, &evidence.unexplained);
  add_not_identifiable(p, o, &evidence.not_identifiable);
  evidence.fit = find_fit(p, o);
  evidence.method =
      "equations of motion along the recorded motion: attitude and encoders against foot sensors, efforts and servo "
      "law; "
      "fit in units of each equation's noise";
  const bool held = std::any_of(p.recordings.begin(), p.recordings.end(), [](const auto& r) { return !r.train; });
  return make_graded_report(held, evidence);
}

}  // namespace hrp::diagnosis::standing
