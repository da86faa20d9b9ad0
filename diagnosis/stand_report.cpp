// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "diagnosis/report.h"

namespace hrp::diagnosis {
namespace {

double round_to(double value, int digits) {
  if (!std::isfinite(value)) return 0.0;
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return std::strtod(text, nullptr);
}

std::string number(double value, int digits = 4) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

Json make_value(const StandCandidate::Value& v) {
  Json value = Json::array(), spread = Json::array(), interval = Json::array();
  for (size_t i = 0; i < v.value.size(); ++i) {
    // 0.2 %: linear equations leave out terms of second order in the effect.
    // Stiffness of a sole is that of sole and ground together: the ground is known to be stiffer than 5e4 N m/rad, and in
    // height, where a sole is nearly as stiff as the ground, to a tenth.
    const double share = v.name == "kz" || v.name == "cz" ? 0.12 : v.name.rfind("k_", 0) == 0 || v.name.rfind("c_", 0) == 0 ? 0.018 : 0.002;
    const double s = std::hypot(v.std[i], share * std::abs(v.value[i] - (v.name == "scale" ? 1.0 : 0.0)));
    value.push_back(round_to(v.value[i], 8)), spread.push_back(round_to(s, 4));
    interval.push_back({round_to(v.value[i] - 1.96 * s, 8), round_to(v.value[i] + 1.96 * s, 8)});
  }
  const bool scalar = v.value.size() == 1;
  return {{"value", scalar ? value[0] : value}, {"std", scalar ? spread[0] : spread}, {"ci95", scalar ? interval[0] : interval}, {"unit", v.unit}};
}

std::string make_statement(const StandOutcome& o, size_t i) {
  const StandCandidate& c = o.chosen[i];
  std::string text = c.where + ": " + c.phrase + ".";
  for (const auto& v : o.values[i]) {
    text += " " + v.name + " ";
    for (size_t k = 0; k < v.value.size(); ++k) text += (k ? ", " : "") + number(v.value[k]) + " +- " + number(2.0 * v.std[k], 2);
    text += (v.unit == "1" ? "" : " " + v.unit) + ";";
  }
  text.back() = '.';
  text += " Held-out error falls from " + number(o.validate_before, 3) + " to " + number(o.validate_after, 3) + " times the noise.";
  for (const auto& rival : o.rivals) {
    if (rival.effect == c.effect && rival.where == c.where) continue;
    text += " The best other single explanation, " + rival.effect + " at " + rival.where + ", leaves " + number(rival.validate, 3) + ".";
    break;
  }
  return text;
}

Json make_mismatch(const Problem& problem, const StandOutcome& o) {
  Json list = Json::array();
  struct Entry {
    double score;
    size_t r, c;
  };
  std::vector<Entry> entries;
  for (size_t r = 0; r < o.before.size() && o.mismatch; ++r) {
    for (size_t c = 0; c < o.before[r].size(); ++c) {
      if (o.before[r][c] > 2.5) entries.push_back({o.before[r][c], r, c});
    }
  }
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.score > b.score; });
  if (entries.size() > 24) entries.resize(24);
  for (const Entry& entry : entries) {
    const Eigen::MatrixXd& x = o.residual_before[entry.r];
    Json intervals = Json::array();
    bool open = false;
    double from = 0.0;
    for (long k = 0; k < x.rows() && intervals.size() < 12; ++k) {
      const bool high = std::abs(x(k, static_cast<long>(entry.c))) > std::max(3.0, 0.7 * entry.score);
      if (high && !open) from = o.times[entry.r][static_cast<size_t>(k)], open = true;
      if (open && (!high || k + 1 == x.rows())) {
        intervals.push_back({round_to(from, 6), round_to(o.times[entry.r][static_cast<size_t>(k)], 6)});
        open = false;
      }
    }
    list.push_back({{"signal", o.row_signals[entry.c]}, {"what", o.row_names[entry.c]},
                    {"recording", problem.experiment->recordings[entry.r].spec.name}, {"score", round_to(entry.score, 4)},
                    {"intervals", intervals}, {"regime", "stance"}});
  }
  return list;
}

Json make_series(const Problem& problem, const StandOutcome& o) {
  const Experiment& e = *problem.experiment;
  Json signals = Json::array(), recordings = Json::array(), rivals = Json::array();
  for (size_t c = 0; c < o.row_names.size(); ++c) {
    signals.push_back({{"name", o.row_names[c] + " (" + o.row_signals[c] + ")"}, {"unit", ""}, {"noise", round_to(o.sigma[c], 4)}, {"noise_source", "estimated"}});
  }
  for (size_t r = 0; r < o.times.size(); ++r) {
    const double start = o.times[r].front(), step = std::max(0.05, (o.times[r].back() - start) / 150.0);
    const size_t bins = static_cast<size_t>((o.times[r].back() - start) / step) + 1;
    Json rows = Json::array();
    for (size_t c = 0; c < o.row_names.size(); ++c) {
      std::vector<double> a(bins, 0.0), b(bins, 0.0), n(bins, 0.0);
      for (size_t k = 0; k < o.times[r].size(); ++k) {
        const size_t bin = std::min(bins - 1, static_cast<size_t>((o.times[r][k] - start) / step));
        const double x = o.residual_before[r](static_cast<long>(k), static_cast<long>(c)), y = o.residual_after[r](static_cast<long>(k), static_cast<long>(c));
        a[bin] += x * x, b[bin] += y * y, n[bin] += 1.0;
      }
      Json ja = Json::array(), jb = Json::array();
      for (size_t i = 0; i < bins; ++i) ja.push_back(round_to(std::sqrt(a[i] / std::max(1.0, n[i])), 3)), jb.push_back(round_to(std::sqrt(b[i] / std::max(1.0, n[i])), 3));
      rows.push_back({{"signal", c}, {"before", ja}, {"after", jb}});
    }
    recordings.push_back({{"file", e.recordings[r].spec.name}, {"role", e.recordings[r].spec.train ? "train" : "validate"}, {"start", start},
                          {"end", o.times[r].back()}, {"map", {{"start", start}, {"step", step}, {"rows", rows}}}});
  }
  for (const auto& rival : o.rivals) {
    const bool chosen = o.explained && std::any_of(o.chosen.begin(), o.chosen.end(), [&](const StandCandidate& c) { return c.effect == rival.effect && c.where == rival.where; });
    rivals.push_back({{"effect", rival.effect}, {"where", {{rival.where_kind, rival.where}}}, {"probability", chosen ? 0.99 : 0.0},
                      {"validate_score", round_to(rival.validate, 4)}, {"complexity", 1}, {"chosen", chosen},
                      {"why", chosen ? "explains the recordings it was not fitted to" : "alone leaves " + number(rival.validate, 3) + " times the noise"}});
  }
  return {{"schema", 1}, {"experiment", e.robot.tree.name}, {"robot", e.robot.tree.name}, {"signals", signals}, {"recordings", recordings},
          {"rivals", rivals}, {"notes", e.warnings}};
}

}  // namespace

Reports make_standing_reports(const Problem& problem, const StandOutcome& o) {
  Reports reports;
  Json& r = reports.report;
  r["schema"] = 1;
  r["verdict"] = !o.mismatch ? "no_mismatch" : o.explained ? "explained" : "unexplained";
  r["mismatch"] = make_mismatch(problem, o);
  r["findings"] = Json::array(), r["unexplained"] = Json::array(), r["not_identifiable"] = Json::array();
  for (size_t i = 0; i < o.chosen.size() && o.explained; ++i) {
    Json parameters = Json::object();
    for (const auto& v : o.values[i]) parameters[v.name] = make_value(v);
    r["findings"].push_back({{"effect", o.chosen[i].effect}, {"where", {{o.chosen[i].where_kind, o.chosen[i].where}}}, {"parameters", parameters},
                             {"probability", o.twins.empty() ? 0.99 : 1.0 / (1.0 + static_cast<double>(o.twins.size()))}, {"statement", make_statement(o, i)}});
  }
  for (const auto& twin : o.twins) {
    if (!o.explained) break;
    r["not_identifiable"].push_back({{"effect", twin.effect}, {"where", {{twin.where_kind, twin.where}}}, {"why", "explains the recordings as well as what is reported"},
                                     {"motion_that_would_tell", "stand in other postures: lean to all sides, squat, lift one foot, move the link concerned through its range"}});
  }
  if (o.mismatch && !o.explained) {
    size_t worst = 0;
    double highest = 0.0;
    for (const auto& rows : o.before) {
      for (size_t c = 0; c < rows.size(); ++c) if (rows[c] > highest) highest = rows[c], worst = c;
    }
    const size_t n = static_cast<size_t>(problem.experiment->num_joints());
    Json where = worst >= 6 && worst < 6 + 2 * n ? Json{{"joint", problem.experiment->robot.tree.joint(static_cast<int>((worst - 6) % n)).name}} : Json{{"sensor", o.row_signals[worst]}};
    r["unexplained"].push_back({{"where", where}, {"depends_on", Json::array()},
                                {"statement", o.row_names[worst] + " is off by " + number(highest, 3) + " times its noise, and no effect of the list makes the recordings agree."}});
  }
  r["fit"] = {{"train", {{"before", round_to(o.train_before, 5)}, {"after", round_to(o.explained ? o.train_after : o.train_before, 5)}}},
              {"validate", {{"before", round_to(o.validate_before, 5)}, {"after", round_to(o.explained ? o.validate_after : o.validate_before, 5)}}}};
  Json& per_signal = r["fit"]["per_signal"] = Json::object();
  for (size_t c = 0; c < o.row_names.size(); ++c) {
    double a = 0.0, b = 0.0;
    for (size_t k = 0; k < o.before.size(); ++k) a = std::max(a, o.before[k][c]), b = std::max(b, o.explained ? o.after[k][c] : o.before[k][c]);
    per_signal[o.row_signals[c] + " (" + o.row_names[c] + ")"] = {{"before", round_to(a, 4)}, {"after", round_to(b, 4)}};
  }
  r["prediction"] = {{"method", "equations of motion, balance of wrenches and contact of the soles at every sample, with attitude from the IMU; not a "
                                "simulation; per_signal is in units of the noise"}, {"horizon", 0.0}};
  r["warnings"] = problem.experiment->warnings;
  reports.series = make_series(problem, o);
  reports.series["prediction"] = r["prediction"];
  return reports;
}

Reports make_empty_reports(const Problem& problem, const std::string& reason) {
  Reports reports;
  Json& r = reports.report;
  r["schema"] = 1, r["verdict"] = "unexplained";
  r["mismatch"] = Json::array(), r["findings"] = Json::array();
  r["unexplained"] = {{{"where", Json::object()}, {"depends_on", Json::array()}, {"statement", "The recordings could not be judged: " + reason + "."}}};
  r["not_identifiable"] = Json::array();
  r["fit"] = {{"train", {{"before", 0.0}, {"after", 0.0}}}, {"validate", {{"before", 0.0}, {"after", 0.0}}}, {"per_signal", Json::object()}};
  r["prediction"] = {{"method", "none"}, {"horizon", 0.0}};
  r["warnings"] = problem.experiment->warnings;
  reports.series = {{"schema", 1}, {"experiment", problem.experiment->robot.tree.name}, {"notes", problem.experiment->warnings}};
  return reports;
}

}  // namespace hrp::diagnosis
