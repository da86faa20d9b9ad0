// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/finding.h"

#include <algorithm>

#include "common/base/rounding.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
using Json = nlohmann::ordered_json;

Estimate make_one(const std::string& name, const std::string& unit, double value, double std) {
  return {name, unit, {value}, {std}, false};
}

Estimate make_assumed_centre(const Eigen::Vector3d& p) {
  Estimate e{"com", "m", {p.x(), p.y(), p.z()}, {1, 1, 1}, true};
  e.assumed = true;
  return e;
}

nlohmann::ordered_json make_estimate(const Estimate& e) {
  const bool list = e.vector || e.value.size() != 1;
  Json value = Json::array(), std = Json::array(), interval = Json::array(), unseen = Json::array();
  for (size_t i = 0; i < e.value.size(); ++i) {
    value.push_back(round_to(e.value[i], 8));
    if (e.std.empty()) continue;
    const double half = kNinetyFive * e.std[i];
    const auto [low, high] = e.ends.empty() ? std::pair(e.value[i] - half, e.value[i] + half) : e.ends[i];
    std.push_back(round_to(e.std[i], 4));
    interval.push_back({round_to(low, 8), round_to(high, 8)});
    if (e.is_unseen(i)) unseen.push_back(std::string(1, "xyz"[i]));
  }
  if (e.std.empty()) return {{"value", list ? value : value[0]}, {"unit", e.unit}};
  if (!list) return {{"value", value[0]}, {"std", std[0]}, {"ci95", interval[0]}, {"unit", e.unit}};
  Json vector{{"value", value}, {"std", std}, {"ci95", interval}, {"unit", e.unit}};
  if (!unseen.empty()) vector["unseen"] = unseen;
  if (e.assumed) vector["assumed"] = true;
  return vector;
}

Finding make_finding(const EffectInfo& effect, const Where& where, std::vector<Estimate> parameters) {
  Finding f;
  f.effect = effect.name;
  f.family = get_family_name(effect.family);
  f.where = where;
  f.parameters = std::move(parameters);
  return f;
}

Alternative make_alternative(const EffectInfo& effect, const Where& where, std::vector<Estimate> parameters,
                             const std::string& motion) {
  return {effect.name, get_family_name(effect.family), where, std::move(parameters), motion};
}

nlohmann::ordered_json make_alternatives(const std::vector<Alternative>& alternatives) {
  Json list = Json::array();
  for (const Alternative& a : alternatives) {
    list.push_back(
        {{"effect", a.effect}, {"family", a.family}, {"where", a.where}, {"parameters", make_estimates(a.parameters)}});
    if (!a.motion.empty()) list.back()["motion_that_would_tell"] = a.motion;
  }
  return list;
}

namespace {

Json make_finding(const Finding& f) {
  Json out{{"effect", f.effect},
           {"family", f.family},
           {"where", f.where},
           {"parameters", make_estimates(f.parameters)},
           {"grade", get_grade_name(f.grade)},
           {"probability", round_to(f.probability, 3)},
           {"share", round_to(f.share, 3)},
           {"weight", round_to(f.weight, 3)},
           {"statement", f.statement},
           {"alternatives", make_alternatives(f.alternatives)}};
  if (!f.also_fitted.empty()) out["also_fitted"] = f.also_fitted;
  return out;
}

Json make_remaining(const Remaining& r) {
  return {{"where", r.where},
          {"unit", r.unit},
          {"before", round_to(r.before, 4)},
          {"after", round_to(r.after, 4)},
          {"share", round_to(r.share(), 3)},
          {"depends_on", r.depends_on},
          {"statement", r.statement}};
}

Json make_mismatch(const Mismatch& m) {
  Json intervals = Json::array();
  for (const auto& [begin, end] : m.intervals) intervals.push_back({round_to(begin, 5), round_to(end, 5)});
  Json out{{"signal", m.signal},
           {"recording", m.recording},
           {"score", round_to(m.score, 4)},
           {"intervals", intervals},
           {"regime", m.regime}};
  if (!m.equation.empty()) out["equation"] = m.equation;
  return out;
}

// Places that findings do not explain.
Json make_unexplained(const Evidence& e) {
  Json list = Json::array();
  for (const Unexplained& u : e.unexplained)
    list.push_back({{"where", u.where}, {"depends_on", u.depends_on}, {"statement", u.statement}});
  if (e.verdict == Verdict::kNoMismatch || e.verdict == Verdict::kExplained) return list;
  for (const Remaining& r : e.remaining) {
    if (r.share() < 1.0 - kMostly) continue;
    list.push_back({{"where", r.where}, {"depends_on", r.depends_on}, {"statement", r.statement}});
  }
  if (e.verdict == Verdict::kNotJudged)
    list.push_back({{"where", Json::object()}, {"depends_on", Json::array()}, {"statement", e.summary}});
  return list;
}

}  // namespace

const char* get_grade_name(Grade grade) {
  static const char* const names[] = {"certain", "supported", "ambiguous"};
  return names[static_cast<int>(grade)];
}

const char* get_verdict_name(Verdict verdict) {
  static const char* const names[] = {"no_mismatch",      "explained",   "mostly_explained",
                                      "partly_explained", "unexplained", "not_judged"};
  return names[static_cast<int>(verdict)];
}

std::string say_ambiguous(std::string statement) {
  for (Grade grade : {Grade::kCertain, Grade::kSupported}) {
    const std::string before = std::string("(") + get_grade_name(grade) + ")";
    const size_t at = statement.find(before);
    if (at != std::string::npos)
      statement.replace(at, before.size(), std::string("(") + get_grade_name(Grade::kAmbiguous) + ")");
  }
  return statement;
}

void make_ambiguous(Finding* finding) {
  finding->grade = Grade::kAmbiguous;
  finding->statement = say_ambiguous(finding->statement);
}

void sort_findings(std::vector<Finding>* findings) {
  std::stable_sort(findings->begin(), findings->end(), [](const Finding& a, const Finding& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.grade < b.grade;
  });
}

Verdict find_verdict(bool mismatch, bool explained, bool partly) {
  if (!mismatch) return Verdict::kNoMismatch;
  return explained ? Verdict::kExplained : partly ? Verdict::kPartlyExplained : Verdict::kUnexplained;
}

Verdict find_verdict(const Evidence& e) {
  const double ceiling = std::max(e.ceiling, e.explained);
  if (e.findings.empty()) return Verdict::kUnexplained;
  return e.explained > 0.0 && e.explained >= kMostly * ceiling ? Verdict::kMostlyExplained : Verdict::kPartlyExplained;
}

void add_to_verdict(nlohmann::ordered_json* report) {
  nlohmann::ordered_json& verdict = (*report)["verdict"];
  if (verdict == get_verdict_name(Verdict::kNoMismatch))
    verdict = get_verdict_name(Verdict::kExplained);
  else if (verdict == get_verdict_name(Verdict::kUnexplained))
    verdict = get_verdict_name(Verdict::kPartlyExplained);
}

nlohmann::ordered_json make_fit(const Fit& fit) {
  Json signals = Json::object();
  for (const SignalFit& s : fit.signals) {
    const double spread = std::max(s.spread, 1e-300);
    Json& signal =
        signals[s.signal] = {{"before", round_to(s.before / spread, 4)}, {"after", round_to(s.after / spread, 4)}};
    if (!s.unit.empty()) {
      signal["rms_before"] = round_to(s.before, 4);
      signal["rms_after"] = round_to(s.after, 4);
      signal["unit"] = s.unit;
    }
    if (!s.equation.empty()) signal["equation"] = s.equation;
  }
  const auto pair = [](double before, double after) -> Json {
    return {{"before", round_to(before, 5)}, {"after", round_to(after, 5)}};
  };
  return {{"train", pair(fit.train_before, fit.train_after)},
          {"validate", pair(fit.validate_before, fit.validate_after)},
          {"over", fit.over_spread ? "spread" : "noise"},
          {"per_signal", signals}};
}

nlohmann::ordered_json make_estimates(const std::vector<Estimate>& parameters) {
  Json json = Json::object();
  for (const Estimate& e : parameters) json[e.name] = make_estimate(e);
  return json;
}

nlohmann::ordered_json make_report(const Evidence& e) {
  Json r;
  r["schema"] = 2;
  r["verdict"] = get_verdict_name(e.verdict);
  if (!e.summary.empty()) r["summary"] = e.summary;
  r["mismatch"] = Json::array();
  for (const Mismatch& m : e.mismatch) r["mismatch"].push_back(make_mismatch(m));
  r["findings"] = Json::array();
  for (const Finding& f : e.findings) r["findings"].push_back(make_finding(f));
  r["unexplained"] = make_unexplained(e);
  r["remaining"] = Json::array();
  for (const Remaining& x : e.remaining) r["remaining"].push_back(make_remaining(x));
  r["not_identifiable"] = Json::array();
  for (const NotIdentifiable& n : e.not_identifiable) {
    Json entry{{"effect", n.effect}};
    if (!n.where.is_null()) entry["where"] = n.where;
    entry["why"] = n.why;
    entry["motion_that_would_tell"] = n.motion;
    r["not_identifiable"].push_back(entry);
  }
  r["ceiling"] = round_to(e.ceiling, 3);
  r["explained"] = round_to(e.explained, 3);
  r["fit"] = make_fit(e.fit);
  r["prediction"] = {{"method", e.method}, {"horizon", e.horizon}};
  r["missing"] = e.missing;
  r["warnings"] = e.warnings;
  return r;
}

}  // namespace hrp::diagnosis
