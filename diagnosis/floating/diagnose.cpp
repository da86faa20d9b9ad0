// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/diagnose.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/checks/air_zeros.h"
#include "diagnosis/floating/checks/by_recording.h"
#include "diagnosis/floating/checks/checks.h"
#include "diagnosis/floating/checks/imu_faults.h"
#include "diagnosis/floating/checks/landings.h"
#include "diagnosis/floating/checks/late_feet.h"
#include "diagnosis/floating/checks/load_share.h"
#include "diagnosis/floating/checks/rests.h"
#include "diagnosis/floating/checks/weight_check.h"
#include "diagnosis/floating/conventions/force_clock.h"
#include "diagnosis/floating/equations/equations.h"
#include "diagnosis/floating/equations/leg_friction.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/fit/servo_fit.h"
#include "diagnosis/floating/fit/usable_rows.h"
#include "diagnosis/floating/log/correct_log.h"
#include "diagnosis/floating/report/report.h"
#include "diagnosis/floating/report/series.h"
#include "diagnosis/floating/search/search.h"

namespace hrp::diagnosis::floating {
namespace {

using Progress = std::function<void(const std::string&)>;

// The recordings of one experiment, in two halves whose noise is independent.
struct Halves {
  LeggedLog even, odd;
  Contacts contacts;
};

// What the search has found in the end.
struct SearchResult {
  std::unique_ptr<LeggedFitter> fitter;
  LeggedOutcome outcome;
  Eigen::VectorXd about;  // faults of sensors and drives that the equations were made about, by column
};

CheckResult check_recordings(const Halves& logs, const std::vector<ChannelRows>& channels, const ColumnLayout& layout) {
  CheckResult checks = run_checks(logs.even, logs.contacts, channels, layout);
  if (!checks.raw_counts) {
    for (std::string& note : compare_loads(logs.even)) checks.notes.push_back(std::move(note));
  }
  for (std::string& note : compare_gyros(logs.even)) checks.notes.push_back(std::move(note));
  for (std::string& note : describe_recordings(logs.even, channels, checks.raw_counts))
    checks.notes.push_back(std::move(note));
  return checks;
}

// What the chosen effects say, by column.
Eigen::VectorXd sum_columns(const ColumnLayout& layout, const LeggedFit& fit) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(layout.count());
  long at = 0;
  for (const Candidate& e : fit.effects) {
    for (const Terms& t : e.terms) {
      for (const auto& [column, factor] : t) out(column) += factor * fit.x(at);
      ++at;
    }
  }
  return out;
}

// What the chosen effects say of sensors and drives, by column, and how well they know it.
struct Correction {
  Eigen::VectorXd value, std;
};

Correction find_correction(const ColumnLayout& layout, const std::vector<FoundEffect>& effects) {
  Correction out{Eigen::VectorXd::Zero(layout.count()), Eigen::VectorXd::Zero(layout.count())};
  for (const FoundEffect& f : effects) {
    for (size_t k = 0; k < f.effect.terms.size(); ++k) {
      for (const auto& [column, factor] : f.effect.terms[k]) {
        if (!is_correctable(layout, column)) continue;
        out.value(column) += factor * f.x(static_cast<long>(k));
        out.std(column) = std::hypot(out.std(column), factor * f.std(static_cast<long>(k)));
      }
    }
  }
  return out;
}

// Closer than a hundredth of its size, or than a tenth of what it is known to, a value changes nothing.
bool is_same_correction(const Eigen::VectorXd& before, const Correction& now) {
  for (long i = 0; i < before.size(); ++i) {
    const double size = std::max(std::abs(before(i)), std::abs(now.value(i)));
    if (std::abs(before(i) - now.value(i)) > std::max(kTrace * size, kDetail * now.std(i))) return false;
  }
  return true;
}

// Equations about the values `about`, by column. What these effects do is added back, so that the fit gives whole
// values.
std::vector<ChannelRows> make_channels(Halves logs, const ColumnLayout& layout, const Eigen::VectorXd& about,
                                       const Used& used) {
  correct_log(layout, about, &logs.even);
  correct_log(layout, about, &logs.odd);
  RowTable even = make_equations(logs.even, logs.contacts), odd = make_equations(logs.odd, logs.contacts);
  even.add_back(about);
  odd.add_back(about);
  std::vector<ChannelRows> out = join_halves(even, odd);
  leave_out_leg_friction(layout, &out);
  drop_unused(used, &out);
  return out;
}

// Searches, and searches again in equations about the faults of sensors that were found, until the faults do not
// change: equations are of first order in these faults.
SearchResult search_about_faults(const Halves& logs, std::vector<ChannelRows> channels, const ColumnLayout& layout,
                                 const Used& used, const Progress& progress) {
  const std::vector<Candidate> candidates = list_candidates(logs.even, layout);
  SearchResult out;
  out.fitter = std::make_unique<LeggedFitter>(std::move(channels), layout.count());
  out.about = Eigen::VectorXd::Zero(layout.count());
  out.outcome = search_legged(out.fitter.get(), candidates, layout, progress, &out.about);
  for (int round = 0; round < kFewRounds; ++round) {
    const Correction next = find_correction(layout, out.outcome.effects);
    if (is_same_correction(out.about, next)) break;
    out.about = next.value;
    if (progress) progress("again, about the faults of sensors that were found");
    out.fitter = std::make_unique<LeggedFitter>(make_channels(logs, layout, out.about, used), layout.count());
    const bool last = round + 1 == kFewRounds;
    out.outcome = search_legged(out.fitter.get(), candidates, layout, progress, last ? nullptr : &out.about);
  }
  return out;
}

// The laws of soles that were found to give, by foot. Empty where none was, or where a joint gives, too: then the
// height of a foot tells their sum.
std::vector<SoleLaw> find_sole_laws(const Experiment& e, const ColumnLayout& layout, const Eigen::VectorXd& corrected,
                                    const SearchResult& found) {
  const LawTable& laws = get_laws();
  std::vector<char> soft(static_cast<size_t>(layout.feet), 0);
  for (const FoundEffect& f : found.outcome.effects) {
    const CandidateLaw* law = f.effect.law;
    if (law == &laws.elasticity || law == &laws.backlash) return {};
    if (law == &laws.flat_sole || law == &laws.point_foot) soft[static_cast<size_t>(f.effect.place)] = 1;
  }
  if (std::count(soft.begin(), soft.end(), 1) == 0) return {};
  LeggedLog all = make_legged_log(e, Half::kAll);
  correct_log(layout, corrected, &all);
  correct_log(layout, found.about, &all);
  return fit_landings(list_landings(all), soft);
}

std::vector<ChannelRows> make_channels(const Halves& logs) {
  std::vector<ChannelRows> out =
      join_halves(make_equations(logs.even, logs.contacts), make_equations(logs.odd, logs.contacts));
  leave_out_leg_friction(ColumnLayout(logs.even), &out);
  return out;
}

// Faults of IMUs that other rates tell, and of sensors of the vertical force alone that the feet in turn tell.
struct SensorFaults {
  std::vector<ImuFault> imus;  // what turns with the body tells them before forces are asked
  std::vector<AirZero> zeros;
  LateFoot late;
  ForceClock clock;  // of all of them against the body's motion
  bool any() const { return !imus.empty() || !zeros.empty() || late.sensor >= 0 || clock.found; }
};

Eigen::VectorXd list_faults(const LeggedLog& log, const ColumnLayout& layout, const SensorFaults& faults) {
  Eigen::VectorXd out = list_zeros(layout, faults.zeros) + list_imu_faults(layout, faults.imus);
  if (faults.late.sensor >= 0) out(layout.sensor(faults.late.sensor, kWrenchDelayColumn)) = faults.late.delay;
  const ForceClock& clock = faults.clock;
  for (int s = 0; clock.found && clock.late > 0 && s < layout.sensors; ++s) {
    if (!clock.foot || log.feet[*clock.foot].sensor == s) out(layout.sensor(s, kWrenchDelayColumn)) += clock.late;
  }
  return out;
}

void correct_faults(const Eigen::VectorXd& about, const ColumnLayout& layout, Halves* logs) {
  correct_log(layout, about, &logs->even);
  correct_log(layout, about, &logs->odd);
  logs->contacts = find_contacts(logs->even);
}

// One late foot first: what both have in common is seen in their sum. Counts tell of clocks alone.
SensorFaults find_sensor_faults(const Halves& logs, const std::vector<ChannelRows>& channels,
                                const ColumnLayout& layout) {
  SensorFaults out;
  if (!has_raw_counts(logs.even, logs.contacts, channels, layout)) {
    out.zeros = find_air_zeros(logs.even, logs.contacts);
    out.late = find_late_foot(logs.even, channels, layout);
  }
  const LeggedLog& log = logs.even;
  const auto find_clock = [&](const LeggedLog& of) { return find_force_clock(list_pressed(of), of.sample_time); };
  out.imus = find_imu_faults(log);
  if (out.late.sensor < 0 && out.imus.empty()) {
    out.clock = find_clock(log);
  } else {
    LeggedLog corrected = log;
    correct_log(layout, list_faults(log, layout, out), &corrected);
    out.clock = find_clock(corrected);
  }
  return out;
}

// Mean squares of the weight's equation, by part (train, validate).
void add_squares(const std::vector<ChannelRows>& channels, double* squares, double* rows) {
  const ChannelRows* c = find_weight_equation(channels);
  if (!c) return;
  for (const int part : {0, 1}) {
    double sum = 0, count = 0;
    for (size_t i = 0; i < c->rows(); ++i) {
      if (c->train[i] == (part == 0)) {
        sum += c->y[i] * c->y[i];
        count += 1;
      }
    }
    squares[part] = sum / std::max(1.0, count);
    rows[part] = count;
  }
}

// What the correction takes away of the weight's mismatch: the equations that follow do not show it.
UnitFit compare_corrected(const LeggedLog& log, const std::vector<ChannelRows>& before,
                          const std::vector<ChannelRows>& after) {
  UnitFit out;
  const ChannelRows* c = find_weight_equation(before);
  if (!c) return out;
  add_squares(before, out.before, out.rows);
  add_squares(after, out.after, out.rows);
  out.signal = c->info.signal + " (weight, by faults of force sensors)";
  out.scale = c->scale;
  out.exact = std::pow(kTrace * log.mass * log.experiment->scenario.gravity_W.norm(), 2);
  return out;
}

void add_rests(const LeggedLog& log, const std::vector<Rest>& rests, CheckResult* checks) {
  for (const Rest& rest : rests) {
    Remaining r;
    r.where = {{"link", log.tree.links[0].name}};
    r.unit = "1";
    r.before = r.after = 1 - rest.share;
    r.statement = describe(rest, log.experiment->recordings[static_cast<size_t>(rest.recording)].spec.name);
    checks->remaining.push_back(std::move(r));
  }
}

void add_fault_findings(const LeggedLog& log, const SensorFaults& faults, CheckResult* checks) {
  for (const ImuFault& f : faults.imus) add_imu_findings(log, f, &checks->corrected);
  for (const AirZero& z : faults.zeros) checks->corrected.push_back(make_zero_finding(log, z));
  if (faults.late.sensor >= 0) checks->corrected.push_back(make_late_finding(log, faults.late));
  if (faults.clock.found) checks->corrected.push_back(make_clock_finding(log, faults.clock));
}

std::string join(const std::vector<std::string>& texts) {
  std::string out;
  for (const std::string& text : texts) out += (out.empty() ? "" : "; ") + text;
  return out;
}

void say_equations(const std::vector<ChannelRows>& channels, bool walks, const Progress& progress) {
  if (!progress) return;
  const auto used = std::count_if(channels.begin(), channels.end(), [](const ChannelRows& c) { return c.rows() > 0; });
  progress("robot on its feet" + std::string(walks ? ", walking" : "") + ": " + std::to_string(used) + " equations");
}

}  // namespace

std::string find_obstacle(const Experiment& e) {
  Halves logs{make_legged_log(e, Half::kEven), make_legged_log(e, Half::kOdd), {}};
  if (logs.even.clips.empty()) return join(logs.even.too_short);
  logs.contacts = find_contacts(logs.even);
  size_t most = 0;
  std::string longest;
  for (const ChannelRows& c : make_channels(logs)) {
    if (c.rows() > most) {
      most = c.rows();
      longest = c.info.signal + " (" + get_text(c.info.equation) + ")";
    }
  }
  const std::string few = most > 0 ? "too short: the equation with most samples, " + longest + ", has " +
                                         std::to_string(most) + " of the " + std::to_string(kRowsPerColumn) +
                                         " means over 40 ms that are needed"
                                   : "what was recorded does not tell the same quantity twice";
  std::vector<std::string> texts{few};
  for (const std::vector<std::string>* list : {&logs.even.too_short, &logs.even.missing})
    texts.insert(texts.end(), list->begin(), list->end());
  const bool flat = std::any_of(logs.even.feet.begin(), logs.even.feet.end(), [](const Foot& f) { return f.flat; });
  if (logs.even.feet.empty())
    texts.emplace_back("'feet' names no link that carries the robot");
  else if (!flat)
    texts.emplace_back("no foot has a flat sole, over which encoders would tell how the body turns");
  return join(texts);
}

LeggedReport diagnose_legged(const Experiment& e, const Progress& progress, Robots robots, Drives drives) {
  LeggedReport out;
  Halves logs{make_legged_log(e, Half::kEven), make_legged_log(e, Half::kOdd), {}};
  logs.contacts = find_contacts(logs.even);
  if (robots == Robots::kWalking && !logs.contacts.walks) return out;
  std::vector<ChannelRows> channels = make_channels(logs);
  out.walks = logs.contacts.walks;
  out.judged =
      std::any_of(channels.begin(), channels.end(), [](const ChannelRows& c) { return c.rows() >= kRowsPerColumn; });
  out.evidence.missing = logs.even.missing;
  out.evidence.warnings = logs.even.notes;
  if (!out.judged) return out;
  const ColumnLayout layout(logs.even);
  const std::vector<Rest> rests = find_rests(channels, layout);
  drop_rests(rests, &channels);
  const SensorFaults faults = find_sensor_faults(logs, channels, layout);
  const Eigen::VectorXd corrected = list_faults(logs.even, layout, faults);
  std::vector<ChannelRows> as_logged;
  if (faults.any()) {
    as_logged = std::move(channels);
    correct_faults(corrected, layout, &logs);
    channels = make_channels(logs);
    drop_rests(rests, &channels);
  }
  CheckResult checks = check_recordings(logs, channels, layout);
  add_rests(logs.even, rests, &checks);
  const Used used{!checks.raw_counts, drives == Drives::kJudged, rests};
  if (used.drives) {
    for (Finding& servo : find_servos(e)) checks.findings.push_back(std::move(servo));
  }
  if (faults.any()) {
    checks.units = compare_corrected(logs.even, as_logged, channels);
    add_fault_findings(logs.even, faults, &checks);
  }
  drop_unused(used, &channels);
  say_equations(channels, out.walks, progress);
  const SearchResult found = search_about_faults(logs, std::move(channels), layout, used, progress);
  const std::vector<SoleLaw> soles = find_sole_laws(e, layout, corrected, found);
  out.evidence = make_evidence(logs.even, logs.contacts, *found.fitter, found.outcome, soles, checks);
  out.series = make_series(e, *found.fitter, found.outcome, out.evidence);
  out.raw_counts = checks.raw_counts;
  out.faults = {corrected, found.about};
  out.found = sum_columns(layout, found.outcome.chosen);
  return out;
}

}  // namespace hrp::diagnosis::floating
