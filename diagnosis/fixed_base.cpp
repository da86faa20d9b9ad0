// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/fixed_base.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/has.h"
#include "common/base/join_words.h"
#include "common/effects/units.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/evidence/best_model.h"
#include "diagnosis/evidence/loose_gears.h"
#include "diagnosis/evidence/settled_joints.h"
#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/evidence/torque/report.h"
#include "diagnosis/findings/column_findings.h"
#include "diagnosis/findings/grading.h"
#include "diagnosis/findings/suspect_predictions.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/search/fitted_part.h"
#include "diagnosis/search/hum.h"
#include "diagnosis/search/outcome.h"
#include "diagnosis/search/significance.h"
#include "diagnosis/search/subtrees.h"

namespace hrp::diagnosis {
namespace {

// The nominal model is exact for some joint: a simulated world, where a law that leaves more than noise is not the law.
// No real robot has such a joint beside others that are wrong.
bool is_exact_world(const TorqueVerdict& torque) { return torque.joints > 1 && torque.exact > 0; }

// The same with one or two joints that are driven by recorded efforts: their drives' effects are there, and far more
// than noise is left beside them. In a clean world little is left of one effect once it is modelled. Sets of effects
// are compared by simulation, which from efforts says little.
bool looks_real(const Problem& problem, const TorqueVerdict& torque) {
  if (!is_effort_driven(*problem.experiment) || !torque.judged) return false;
  const Trial model = simulate_trial(problem, torque.model);
  return torque.any_drives >= kEveryDrive * torque.joints && model.validate.ok && model.rms > kFarMore;
}

// From recorded efforts a simulation is drawn to the recording: nothing is judged by it.
std::vector<SuspectJoint> find_suspects(const Problem& problem) {
  return is_effort_driven(*problem.experiment) ? std::vector<SuspectJoint>{} : find_suspect_joints(problem);
}

void say(const TorqueVerdict& torque, const Progress& progress) {
  for (const std::string& text : torque.evidence.warnings) progress("note: " + text);
  for (const std::string& text : torque.evidence.missing) progress("note: " + text);
  if (!torque.judged) return;
  progress("missing torque along the recorded motion: " + number(100.0 * torque.evidence.explained, 3) +
           " % of it is explained, at most " + number(100.0 * torque.evidence.ceiling, 3) + " % can be");
  for (const Finding& f : torque.evidence.findings) progress("    " + f.statement);
}

// Positions by free simulation of short windows, for recorded efforts.
std::vector<SignalFit> list_windows(const Problem& problem, const Outcome& outcome) {
  std::vector<SignalFit> list;
  const WindowErrors before = calc_held_windows(problem, {}),
                     after = calc_held_windows(problem, outcome.chosen.hypothesis);
  for (size_t j = 0; j < before.rms.size(); ++j) {
    const double spread = calc_channel_spread(*problem.experiment, get_judged(problem), j * kQuantities);
    if (!std::isfinite(before.rms[j]) || !does_move(spread)) continue;
    const JointSpec& joint = problem.experiment->robot.tree.joint(static_cast<int>(j));
    list.push_back({signal_name(*problem.experiment, j * kQuantities), get_joint_unit(joint, "rad"), before.rms[j],
                    after.rms[j], spread});
  }
  return list;
}

// Fit of the simulation; for recorded efforts that of the torque: a simulation from them drifts whatever the model.
// `windows`: positions then.
void fill_fit(const Problem& problem, const Outcome& outcome, const TorqueVerdict& torque,
              const std::vector<SignalFit>& windows, Evidence* evidence) {
  Fit& fit = evidence->fit;
  if (!is_effort_driven(*problem.experiment)) {
    fit = calc_simulation_fit(problem, outcome.nominal, outcome.chosen);
    evidence->method = "simulation from the recording's commands; findings from the " + evidence->method;
    evidence->horizon = problem.experiment->recordings[0].duration();
    return;
  }
  fill_torque_fit(torque.torque, &fit);
  evidence->method +=
      "; errors are shares of each effort's spread; positions by simulation from the recorded efforts over " +
      number(kWindow, 2) + " s";
  evidence->horizon = kWindow;
  fit.signals.insert(fit.signals.end(), windows.begin(), windows.end());
}

// Held-out errors of the motion with the nominal and with the chosen model: over windows, where there are any, else of
// the simulation over the whole.
struct MotionErrors {
  double before = 0.0, after = 0.0;
  bool improve() const { return !(after > kNearlyAll * before); }
};

MotionErrors calc_motion_errors(const Outcome& outcome, const std::vector<SignalFit>& windows) {
  if (windows.empty()) return {outcome.nominal.rms, outcome.chosen.rms};
  MotionErrors sum;
  for (const SignalFit& s : windows) {
    sum.before = std::hypot(sum.before, s.before / s.spread);
    sum.after = std::hypot(sum.after, s.after / s.spread);
  }
  return sum;
}

// Torque that is explained does not make the simulated motion better by itself: one that is balanced by a stop that is
// not in the model leaves no missing torque beside friction.
std::string describe_motion(const MotionErrors& errors, bool by_windows) {
  const std::string text =
      "The torque along the recorded motion is explained, but with the updated model the simulated motion is not "
      "better";
  return text + (by_windows ? "."
                            : ": its error goes from " + number(errors.before, 3) + " to " + number(errors.after, 3) +
                                  " times the noise.");
}

// Findings that hardly improve the simulation of held-out recordings explain a part at most, whatever a free model
// predicts.
Reports make_torque_reports(const Problem& problem, const Outcome& outcome, TorqueVerdict torque) {
  Reports reports = make_reports(problem, outcome);
  Evidence& evidence = torque.evidence;
  const std::vector<SignalFit> windows =
      is_effort_driven(*problem.experiment) ? list_windows(problem, outcome) : std::vector<SignalFit>{};
  fill_fit(problem, outcome, torque, windows, &evidence);
  for (const std::string& text : problem.experiment->warnings) evidence.warnings.push_back(text);
  evidence.verdict = find_verdict(evidence);
  const MotionErrors motion = calc_motion_errors(outcome, windows);
  const bool torque_alone = evidence.verdict == Verdict::kMostlyExplained && !motion.improve();
  if (torque_alone) evidence.verdict = Verdict::kPartlyExplained;
  const Json mismatch = reports.report["mismatch"];
  reports.report = make_report(evidence);
  reports.report["mismatch"] = mismatch;
  if (torque_alone) reports.report["motion"] = describe_motion(motion, !windows.empty());
  reports.report["model"] =
      list_torque_model(*problem.experiment, outcome.chosen.hypothesis, reports.report["findings"]);
  reports.series["prediction"] = reports.report["prediction"];
  return reports;
}

std::string list_joints(const Experiment& e, const std::vector<int>& joints) {
  return join_words(joints, [&](int joint) { return e.robot.tree.joint(joint).name; });
}

// What is missing along the recorded motion, where no simulation can follow the recordings; `why` says it.
Reports report_along_motion(const Problem& problem, TorqueVerdict torque, const std::string& why) {
  const Experiment& e = *problem.experiment;
  Reports reports = make_empty_reports(problem, why);
  reports.report["missing"] = torque.evidence.missing;
  if (!torque.judged) return reports;
  fill_torque_fit(torque.torque, &torque.evidence.fit);
  for (const std::string& text : e.warnings) torque.evidence.warnings.push_back(text);
  torque.evidence.warnings.push_back(why);
  torque.evidence.verdict = find_verdict(torque.evidence);
  reports.report = make_report(torque.evidence);
  reports.report["model"] = list_torque_model(e, torque.model, reports.report["findings"]);
  return reports;
}

// Recordings in which a servo hums: no simulation follows them. What is missing at the joints that it does not shake is
// judged along the recorded motion.
Reports judge_beside_hum(const Problem& problem, const Hum& hum) {
  const Experiment e = take_out_hum(*problem.experiment, hum);
  const std::string why =
      "the recordings contradict themselves at " + list_joints(e, hum.humming) +
      ": the effort is at its limit for most of the time and the velocity is not the rate of the position, so the "
      "servo hums faster than the log samples. Not judged, nor called physics: " +
      list_joints(e, hum.shaken);
  TorqueData data = make_torque_data(e);
  for (TorqueRecording& r : data.recordings) {
    for (int joint : hum.shaken) r.use.col(joint).setConstant(false);
  }
  for (int joint : hum.shaken)
    data.velocity[static_cast<size_t>(joint)] = {};  // a hum in one phase looks like a constant
  return report_along_motion(problem, judge_torque(std::move(data), problem.jobs), why);
}

// Recordings that a simulation from efforts cannot follow, because a driven joint's effort was not logged.
std::vector<size_t> list_undriven(const Experiment& e) {
  std::vector<size_t> list;
  for (size_t r = 0; r < e.recordings.size() && is_effort_driven(e); ++r) {
    bool complete = true;
    for (int j = 0; j < e.num_joints(); ++j)
      complete = complete && (!e.robot.tree.joint(j).actuated ||
                              e.recordings[r].joints[static_cast<size_t>(j)].has(Quantity::kEffort));
    if (!complete) list.push_back(r);
  }
  return list;
}

// Without these recordings, as long as others are left.
std::vector<int> leave_out(const std::vector<int>& recordings, const std::vector<size_t>& out) {
  std::vector<int> left;
  for (int r : recordings) {
    if (!has(out, static_cast<size_t>(r))) left.push_back(r);
  }
  return left.empty() ? recordings : left;
}

bool has_any(const std::vector<int>& recordings, const std::vector<size_t>& of) {
  return std::any_of(of.begin(), of.end(), [&](size_t r) { return has(recordings, static_cast<int>(r)); });
}

// Adds what the simulation says of a gear. It takes the place of what the missing torque only suspects there.
void add_gear(const Finding& gear, std::vector<Finding>* findings) {
  const auto same = std::find_if(findings->begin(), findings->end(),
                                 [&](const Finding& f) { return f.where == gear.where && f.family == gear.family; });
  if (same == findings->end())
    findings->push_back(gear);
  else if (same->grade == Grade::kAmbiguous)
    *same = gear;
}

// The best model by simulation. `gears`, if not null: with loose gears, which are added there.
Trial choose_model(const Problem& problem, const Problem& whole, const TorqueVerdict& torque,
                   const Hypothesis& searched, const Progress& progress, std::vector<Finding>* gears) {
  const FittedPart part(problem, whole);
  if (part.is_cut())
    progress("models are fitted to the " + number(part.seconds(), 3) +
             " s in which the joints move most, and judged on all");
  Trial chosen =
      choose_best_model(part.problem(), part.whole(), torque.model, torque.evidence.explained, searched, progress);
  if (gears) *gears = loosen_gears(part.problem(), part.whole(), &chosen, progress);
  return part.is_cut() ? simulate_trial(whole, chosen.hypothesis) : chosen;
}

// The best model where nothing is named. Recordings that are too short for the torque along the motion may still be
// simulated.
Trial choose_unnamed(const Problem& problem, const Problem& whole, const Outcome& outcome, const TorqueVerdict& torque,
                     const Progress& progress) {
  const Trial* closest = find_told_closest(problem, outcome);
  const Hypothesis searched = closest ? closest->hypothesis : Hypothesis{};
  return torque.judged ? choose_model(problem, whole, torque, searched, progress, nullptr)
                       : simulate_trial(whole, searched);
}

// A set that may be told: each effect is of a possible size and, as far as its interval is known, more than nothing.
bool is_sound(const Experiment& e, const Trial& t) {
  if (!find_odd_effect(e, t.hypothesis, {}).empty()) return false;
  if (t.std.size() < t.hypothesis.size() || t.distance.size() < t.hypothesis.size()) return true;
  for (size_t i = 0; i < t.hypothesis.size(); ++i) {
    if (!is_significant(t.hypothesis[i], t.std[i], t.distance[i])) return false;
  }
  return true;
}

bool is_sure(const Finding& f) { return f.grade != Grade::kAmbiguous; }

// Where neither the search nor the missing torque names anything for sure: the effects that come closest, each
// ambiguous, with the sets that come as close. Of a simulated world, those of joints that are settled.
std::optional<Outcome> name_closest(const Problem& whole, const Outcome& outcome, const TorqueVerdict& torque) {
  const std::vector<Finding>& found = torque.evidence.findings;
  if (!outcome.mismatch || outcome.explained || outcome.partly) return std::nullopt;
  if (is_exact_world(torque)) return name_settled_joints(whole, outcome, found);
  if (torque.judged && std::any_of(found.begin(), found.end(), is_sure)) return std::nullopt;
  Outcome named = outcome;
  const auto end = std::remove_if(named.rivals.begin(), named.rivals.end(),
                                  [&](const Trial& t) { return !is_sound(*whole.experiment, t); });
  named.rivals.erase(end, named.rivals.end());
  const Trial* closest = find_told_closest(whole, named);
  if (!closest || closest->std.empty()) return std::nullopt;
  named.indistinguishable.clear();
  for (const Trial* other : list_as_close(named, *closest)) named.indistinguishable.push_back(*other);
  named.chosen = whole.subtrees.empty() ? *closest : simulate_trial(whole, closest->hypothesis);
  named.chosen.std = closest->std;
  named.chosen.probability = 1.0 / static_cast<double>(1 + named.indistinguishable.size());  // one of so many
  named.partly = named.as_set = true;
  return named;
}

// Its verdict by what it explains, as for findings along the recorded motion.
void rate_closest(Json* report) {
  Evidence evidence;
  evidence.findings.resize((*report)["findings"].size());
  evidence.ceiling = (*report)["ceiling"];
  evidence.explained = (*report)["explained"];
  (*report)["verdict"] = get_verdict_name(find_verdict(evidence));
}

// Friction and rotors in most joints, as real robots have them: no set of a few effects explains them.
bool has_losses_in_most(const Problem& whole, const TorqueVerdict& torque) {
  return has_real_drives(torque) || (!is_exact_world(torque) && looks_real(whole, torque));
}

// The search has the answer, or the torque along the recorded motion has none. What fits its own recordings to the
// noise is no proof: without held-out ones its model competes with the others.
bool is_settled_by_search(const Problem& problem, const Outcome& outcome, const TorqueVerdict& torque) {
  const bool confirmed = outcome.explained && !problem.validate.empty();
  return !torque.judged || !outcome.mismatch || confirmed || torque.evidence.findings.empty() || is_exact_world(torque);
}

Reports report_search(const Problem& problem, const Problem& whole, const std::optional<Outcome>& closest,
                      const TorqueVerdict& torque, const Progress& progress, Outcome outcome) {
  // Nothing is named for sure. The best model all the same, of the search only what comes close: many fit their own
  // recordings.
  if (outcome.mismatch && !outcome.explained && !outcome.partly && !is_exact_world(torque)) {
    outcome.chosen = choose_unnamed(problem, whole, outcome, torque, progress);
    outcome.modelled =
        (torque.judged || !outcome.chosen.hypothesis.empty()) && !(outcome.chosen.rms > outcome.nominal.rms);
  }
  Reports reports = make_reports(whole, closest ? *closest : outcome);
  if (outcome.modelled)
    reports.report["model"] =
        list_torque_model(*problem.experiment, outcome.chosen.hypothesis, reports.report["findings"]);
  doubt_suspects(*problem.experiment, find_suspects(problem), &reports.report);
  if (closest) rate_closest(&reports.report);
  if (torque.judged && outcome.mismatch && !outcome.explained)
    add_column_findings(torque.evidence.findings, &reports.report);
  if (problem.validate.empty() && torque.judged) doubt_unconfirmed(torque.evidence.findings, &reports.report);
  return reports;
}

Reports report_torque(const Problem& problem, const Problem& whole, TorqueVerdict torque, const Progress& progress,
                      Outcome outcome) {
  progress("simulation with what was found");
  std::vector<Finding> gears;
  outcome.chosen = choose_model(problem, whole, torque, outcome.best, progress, &gears);
  for (const Finding& gear : gears) add_gear(gear, &torque.evidence.findings);
  sort_findings(&torque.evidence.findings);
  outcome.modelled = true;
  outcome.partly = false;
  outcome.indistinguishable.clear();
  progress("held out: " + number(outcome.nominal.rms, 4) + " -> " + number(outcome.chosen.rms, 4) + " times the noise");
  Reports reports = make_torque_reports(whole, outcome, std::move(torque));
  warn_of_suspects(*problem.experiment, find_suspects(problem), &reports.report);
  return reports;
}

}  // namespace

Reports diagnose_fixed_base(const Problem& given, const Progress& progress) {
  const Hum hum = find_hum(*given.experiment);
  if (!hum.humming.empty()) return judge_beside_hum(given, hum);
  progress("inverse dynamics along the recorded motion");
  TorqueVerdict torque = judge_torque(*given.experiment, given.jobs);
  say(torque, progress);
  Problem problem = given;
  const std::vector<size_t> undriven = list_undriven(*given.experiment);
  problem.train = leave_out(given.train, undriven);
  problem.validate = leave_out(given.validate, undriven);
  if (has_any(problem.train, undriven) || has_any(problem.validate, undriven))
    return report_along_motion(given, std::move(torque),
                               "no simulation is driven by efforts that were not logged, so only the torque along the "
                               "recorded motion is judged");
  problem.train = leave_out(problem.train, torque.frozen);
  problem.validate = leave_out(problem.validate, torque.frozen);
  Problem whole = problem;
  split_subtrees(&whole);
  if (has_losses_in_most(whole, torque)) {
    progress("friction and rotors in most joints: sets of a few effects are not searched");
    Outcome outcome;
    outcome.nominal = outcome.chosen = simulate_trial(whole, {});
    outcome.mismatch = true;
    return report_torque(problem, whole, std::move(torque), progress, std::move(outcome));
  }
  Outcome outcome = search_subtrees(whole, progress);
  const std::optional<Outcome> closest = name_closest(whole, outcome, torque);
  return closest || is_settled_by_search(problem, outcome, torque)
             ? report_search(problem, whole, closest, torque, progress, std::move(outcome))
             : report_torque(problem, whole, std::move(torque), progress, std::move(outcome));
}

}  // namespace hrp::diagnosis
