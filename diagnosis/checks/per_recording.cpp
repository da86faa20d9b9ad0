// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/checks/per_recording.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/data/rounding.h"
#include "diagnosis/measurement/torque_terms.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kLooks = 3.0;       // independent samples in a half-cycle of the motion
constexpr double kFewestRows = 30;
constexpr double kApart = 3.0, kDetail = 0.1;  // standard deviations; share of the larger value
constexpr double k95 = 1.96;
constexpr double kTold = 0.7;        // a value is shown whose standard deviation is below that share of the pooled value

// A finding as a term with the value that the whole data gave.
struct Asked {
  Term term;
  size_t finding = 0;
  std::string parameter, unit;
  double pooled = 0.0;  // of the parameter
};

struct Solution {
  Eigen::VectorXd value, std;
};

std::optional<TermKind> find_kind(const std::string& effect) {
  for (int k = 0; k <= static_cast<int>(TermKind::kTilt); ++k) {
    const TermKind kind = static_cast<TermKind>(k);
    if (kind != TermKind::kGainOfModel && get_effect_name(kind) == effect) return kind;
  }
  return std::nullopt;
}

double get_value(const Json& finding, const std::string& name) {
  const Json& p = finding["parameters"];
  return p.contains(name) && p[name]["value"].is_number() ? p[name]["value"].get<double>() : 0.0;
}

int count_columns(TermKind kind) {
  switch (kind) {
    case TermKind::kSpring: case TermKind::kCogging: case TermKind::kTilt: return 2;
    case TermKind::kComError: case TermKind::kForce: return 3;
    case TermKind::kPayload: return 4;
    default: return 1;
  }
}

class Fitter {
 public:
  Fitter(const Experiment& e, const Json& findings) : e_(e), findings_(findings), data_(make_torque_data(e)) {}

  Json run() {
    Json list = Json::array();
    if (data_.recordings.size() < 2) return list;
    for (size_t f = 0; f < findings_.size(); ++f) take(f);
    for (int j = 0; j < e_.num_joints(); ++j) fit_joint(j, &list);
    return list;
  }

 private:
  // Findings at joints; those of links act in many joints at once and are not asked of one recording.
  void take(size_t f) {
    const Json& finding = findings_[f];
    const std::optional<TermKind> kind = find_kind(finding["effect"]);
    if (!kind || finding["parameters"].empty()) return;
    const auto first = finding["parameters"].begin();
    if (!first.value()["value"].is_number()) return;
    Asked asked{{*kind, 0, 0.0, count_columns(*kind), false}, f, first.key(), first.value()["unit"], 0.0};
    asked.pooled = first.value()["value"].get<double>();
    if (!finding["where"].contains("joint")) return;
    asked.term.place = e_.robot.tree.find_joint(finding["where"]["joint"].get<std::string>());
    if (asked.term.place < 0 || !data_.is_judged(asked.term.place)) return;
    if (*kind == TermKind::kCogging) asked.term.shape = get_value(finding, "periods");
    if (*kind == TermKind::kOffset) return;  // of the whole robot
    if (*kind == TermKind::kStribeck) {
      asked.term = {TermKind::kDry, asked.term.place, 0.0, 1, false};
      asked_.push_back(asked);
      asked.term = {TermKind::kStribeck, asked.term.place, get_value(finding, "stribeck_velocity"), 1, false};
      asked.parameter.clear();  // shown with its level
    }
    asked_.push_back(asked);
  }

  void fit_joint(int joint, Json* list) const {
    std::vector<const Asked*> own;
    for (const Asked& a : asked_) {
      if (a.term.place == joint) own.push_back(&a);
    }
    if (own.empty()) return;
    std::vector<Json> each(own.size(), Json::array());
    std::vector<std::vector<std::pair<double, double>>> values(own.size());
    for (const TorqueRecording& r : data_.recordings) {
      const std::optional<Solution> s = solve(r, joint, own);
      if (!s) continue;
      long at = 0;
      for (size_t i = 0; i < own.size(); ++i) {
        const double value = find_parameter(own[i]->term, s->value.segment(at, own[i]->term.columns)), std = s->std[at];
        at += own[i]->term.columns;
        if (!(std < kTold * std::max(std::abs(own[i]->pooled), std::abs(value)))) continue;
        values[i].emplace_back(value, std);
        const RecordingSpec& spec = e_.recordings[r.index].spec;
        each[i].push_back({{"recording", spec.name},
                           {"role", spec.train ? "train" : "validate"},
                           {"value", round_to(value, 4)},
                           {"ci95", {round_to(value - k95 * std, 4), round_to(value + k95 * std, 4)}}});
      }
    }
    for (size_t i = 0; i < own.size(); ++i) {
      if (own[i]->parameter.empty() || each[i].size() < 2) continue;
      const Json& finding = findings_[own[i]->finding];
      list->push_back({{"effect", finding["effect"]}, {"where", finding["where"]}, {"parameter", own[i]->parameter},
                       {"unit", own[i]->unit}, {"each", each[i]}, {"verdict", do_differ(values[i]) ? "differ" : "agree"}});
    }
  }

  static double find_parameter(const Term& term, const Eigen::VectorXd& p) {
    if (term.kind == TermKind::kGain) return 1.0 - p[0];
    return term.kind == TermKind::kCogging ? p.norm() : p[0];
  }

  static bool do_differ(const std::vector<std::pair<double, double>>& values) {
    for (const auto& [a, sa] : values) {
      for (const auto& [b, sb] : values) {
        if (std::abs(a - b) > kApart * std::hypot(sa, sb) && std::abs(a - b) > kDetail * std::max(std::abs(a), std::abs(b))) return true;
      }
    }
    return false;
  }

  // The joint's terms on one recording.
  std::optional<Solution> solve(const TorqueRecording& r, int joint, const std::vector<const Asked*>& own) const {
    long width = 0;
    for (const Asked* a : own) width += a->term.columns;
    Eigen::MatrixXd X(r.kept(), width);
    long at = 0;
    for (const Asked* a : own) X.middleCols(at, a->term.columns) = calc_joint_columns(data_, r, a->term), at += a->term.columns;
    Eigen::MatrixXd G = Eigen::MatrixXd::Zero(width, width);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(width);
    double c = 0.0, n = 0.0, cycles = 0.0, last = 0.0;
    for (long k = 0; k < r.kept(); ++k) {
      if (!r.use(k, joint)) continue;
      const double y = r.missing(k, joint), v = r.v(r.full_row(k), joint);
      G += X.row(k).transpose() * X.row(k), b += y * X.row(k).transpose(), c += y * y, n += 1.0;
      cycles += v * last <= 0.0 ? 1.0 : 0.0, last = v;
    }
    if (n < kFewestRows) return std::nullopt;
    const Eigen::VectorXd scale = G.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
    Eigen::MatrixXd unit = scale.asDiagonal() * G * scale.asDiagonal();
    unit.diagonal().array() += 1e-9;
    const Eigen::MatrixXd inverse = unit.inverse();
    Solution s;
    s.value = scale.cwiseProduct(inverse * scale.cwiseProduct(b));
    const double left = std::max(0.0, c - s.value.dot(b)) / n, looks = std::clamp(kLooks * cycles, 1.0, n);
    s.std = (left * n / looks * scale.array().square() * inverse.diagonal().array()).sqrt();
    return s;
  }

  const Experiment& e_;
  const Json& findings_;
  const TorqueData data_;
  std::vector<Asked> asked_;
};

}  // namespace

Json make_per_recording(const Experiment& e, const Json& findings) {
  const bool fixed = !e.scenario.floating_base && e.scenario.drive != "motion";
  return fixed && !findings.empty() && e.num_joints() > 0 ? Fitter(e, findings).run() : Json::array();
}

}  // namespace hrp::diagnosis
