// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/diagnose_recordings.h"

#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "diagnosis/checks/checks.h"
#include "diagnosis/checks/on_all.h"
#include "diagnosis/checks/per_recording.h"
#include "diagnosis/checks/torque_traces.h"
#include "diagnosis/conventions/effort_dropouts.h"
#include "diagnosis/conventions/falls.h"
#include "diagnosis/conventions/log_conventions.h"
#include "diagnosis/conventions/odd_load_report.h"
#include "diagnosis/conventions/stamps.h"
#include "diagnosis/conventions/unit_doubts.h"
#include "diagnosis/data/held_out.h"
#include "diagnosis/data/stretches.h"
#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/findings/doubtful_constants.h"
#include "diagnosis/findings/doubtful_efforts.h"
#include "diagnosis/findings/even_speeds.h"
#include "diagnosis/findings/grading.h"
#include "diagnosis/findings/odd_sizes.h"
#include "diagnosis/findings/simpler_law.h"
#include "diagnosis/page/terminal.h"

namespace hrp::diagnosis {
namespace {

// The same for the first answer: seconds of one core.
constexpr double kFirst = 240.0;
// Of less there is nothing to be gained by a first answer: joint-seconds, or as many samples as these have at 200 Hz,
// as a simulation takes its time by the sample.
constexpr double kWorthFirst = 60.0, kWorthFirstSamples = 200.0 * kWorthFirst;
// Times what the first answer took for so many joint-seconds that the whole takes for as many (measured with
// make_long_recordings: 12 joints, 600 s at 200 Hz).
constexpr double kWhole = 7.0;

bool is_in_torque_space(const Experiment& e) {
  return !e.scenario.floating_base && e.scenario.drive != "motion" && e.num_joints() > 0;
}

bool is_long(const Experiment& e) { return calc_joint_seconds(e) > calc_searched(e); }

// Of long recordings the stretches that the search works with.
std::optional<Experiment> cut_long(const Experiment& e) {
  if (!is_long(e)) return std::nullopt;
  return make_screened(e, calc_searched(e));
}

// Enough to see how a log was written. Robots on their feet need both feet and the motion that loads them.
double calc_for_conventions(const Experiment& e) { return is_in_torque_space(e) ? kFirst : calc_searched(e); }

bool is_worth_first(const Experiment& e) {
  return is_in_torque_space(e) && (calc_joint_seconds(e) > kWorthFirst || calc_joint_samples(e) > kWorthFirstSamples);
}

// The sentences on top, which are the same for all engines.
void finish(const Experiment& e, Reports* reports) {
  Json& report = reports->report;
  report["fit"]["held_out"] = has_held_out(e.recordings);
  name_simpler_laws(&report);
  lower_grades(&report);
  doubt_constants_of_masses(e, &report);
  doubt_constants_of_feet(e, &report);
  doubt_constants_of_commands(e, &report);
  doubt_efforts_at_rest(e, &report);
  doubt_common_scale(e, &report);
  doubt_limits_within_friction(&report);
  doubt_friction_of_even_speeds(e, &report);
  doubt_upright_forces(e, &report);
  drop_idle_findings(&report);
  list_once(&report);
  doubt_odd_sizes(e.robot.tree, &report);
  doubt_stiff_soles(e.robot.tree, &report);
  report["summary"] = make_summary_text(report);
}

// The missing torque of a few stretches, as a report that says so.
std::optional<Reports> make_first(const Experiment& e, int jobs) {
  const Experiment part = make_screened(e, kFirst);
  TorqueVerdict torque = judge_torque(part, jobs);
  if (!torque.judged) return std::nullopt;
  torque.evidence.verdict = find_verdict(torque.evidence);
  for (const SignalFit& s : torque.torque) torque.evidence.fit.signals.push_back(s);
  Reports first;
  first.report = make_report(torque.evidence);
  first.report["preliminary"] = true;
  first.series = {{"schema", 1}, {"experiment", e.robot.tree.name}, {"robot", e.robot.tree.name}};
  return first;
}

void say_first(const Experiment& e, const DiagnosisOptions& options, const Json& checks, const Progress& progress,
               const std::function<void(const Reports&)>& write_first) {
  const auto begin = std::chrono::steady_clock::now();
  std::optional<Reports> first = make_first(e, options.jobs);
  if (!first) return;
  first->report["checks"] = checks;
  write_first(*first);
  const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const double whole = took * calc_searched(e) / kFirst * kWhole;
  progress("a first answer is written (report.json, marked preliminary)" +
           (is_long(e)
                ? "; about " + std::to_string(std::lround(std::ceil(whole / 10.0) * 10.0)) + " s more for the whole"
                : ""));
}

Reports diagnose_whole(const Experiment& all, const ConventionRemarks& conventions, const DiagnosisOptions& options,
                       const Progress& progress, const std::function<void(const Reports&)>& write_first) {
  const std::optional<Experiment> part = cut_long(all);
  const Experiment& searched = part ? *part : all;
  const Json checks = make_checks(all, searched, conventions);
  for (const Json& remark : checks["remarks"]) progress("check: " + remark.get<std::string>());
  if (is_worth_first(all)) say_first(all, options, checks, progress, write_first);
  if (is_long(all)) {
    progress("long recordings: the search works on " + number(calc_joint_seconds(searched) / all.num_joints(), 4) +
             " of " + number(calc_joint_seconds(all) / all.num_joints(), 5) +
             " s, those in which the joints move most");
  }
  Problem problem = make_problem(searched, options.jobs);
  problem.most_work *= options.patience;
  Reports reports = diagnose(problem, progress);
  reports.report["checks"] = checks;
  reports.report["per_recording"] = Json::array();
  if (!is_in_torque_space(all) || reports.report["findings"].empty()) return reports;
  if (part) progress("what was found, on all recordings");
  const TorqueData data = make_torque_data(all);
  reports.report["per_recording"] = make_per_recording(data, reports.report["findings"]);
  reports.series["torque_traces"] = make_torque_traces(data, reports.report["findings"]);
  if (part) reports.report["on_all"] = make_fit_on_all(data, searched, reports.report["findings"]);
  return reports;
}

std::optional<OddLoad> find_odd(const Experiment& e) {
  if (!is_in_torque_space(e) || e.recordings.size() < 2) return std::nullopt;
  const Experiment part = is_long(e) ? make_screened(e, kFirst) : e;
  const TorqueData data = make_torque_data(part);
  return data.recordings.empty() ? std::nullopt : find_odd_load(data);
}

// Without efforts that are none, at the times when the rows were taken; of robots on their feet, up to a fall.
Experiment mend_log(const Experiment& logged) {
  if (logged.scenario.floating_base && !logged.scenario.feet.empty()) return cut_at_crashes(logged);
  if (!is_in_torque_space(logged)) return logged;
  Experiment e = correct_stamps(logged);
  const std::vector<Dropout> dropouts = find_dropouts(e);
  return leave_out_dropouts(std::move(e), dropouts);
}

}  // namespace

Reports diagnose_recordings(const Experiment& logged, const DiagnosisOptions& options, const Progress& progress,
                            const std::function<void(const Reports&)>& write_first) {
  const Experiment all = mend_log(logged);
  const LogConventions found =
      find_conventions(is_long(all) ? make_screened(all, calc_for_conventions(all)) : all, options.jobs);
  const ConventionRemarks remarks = make_remarks(all, found);
  std::optional<Experiment> converted;
  if (found.any()) converted = convert_recordings(all, found);
  const std::optional<OddLoad> odd = find_odd(converted ? *converted : all);
  if (odd && odd->leave_out) converted = leave_out(converted ? *converted : all, *odd);
  const auto complete = [&](Reports* reports) {
    add_conventions(all, found, reports);
    if (odd) add_odd_load(all, *odd, reports);
    finish(all, reports);
  };
  const auto complete_first = [&](Reports first) {
    complete(&first);
    write_first(first);
  };
  Reports reports = diagnose_whole(converted ? *converted : all, remarks, options, progress, complete_first);
  if (!found.friction.empty()) reports.urdf = converted->robot.urdf;
  complete(&reports);
  return reports;
}

std::string check_recordings(const Experiment& logged) {
  const Experiment e = mend_log(logged);
  const std::optional<Experiment> part = cut_long(e);
  const Experiment& searched = part ? *part : e;
  if (e.scenario.floating_base)
    return print_checks(make_checks(e, searched, make_remarks(e, find_conventions(searched, 1))));  // at once
  ConventionRemarks remarks;
  if (has_effort(e))
    remarks.not_looked_for = {
        "units and signs of all efforts, zeros and gears: only the diagnosis compares efforts with the motion"};
  return print_checks(make_checks(e, searched, remarks));
}

}  // namespace hrp::diagnosis
