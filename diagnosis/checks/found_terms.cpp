// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/checks/found_terms.h"

#include <cmath>
#include <optional>

#include "diagnosis/measurement/term_rows.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

std::optional<TermKind> find_kind(const std::string& effect) {
  for (const TermRow& row : list_term_rows()) {  // the gain by the effort comes before that by the model
    if (get_effect_name(row.kind) == effect) return row.kind;
  }
  return std::nullopt;
}

double get_value(const Json& finding, const std::string& name) {
  const Json& p = finding["parameters"];
  return p.contains(name) && p[name]["value"].is_number() ? p[name]["value"].get<double>() : 0.0;
}

Eigen::Vector3d get_vector(const Json& finding, const std::string& name) {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  const Json& p = finding["parameters"];
  if (!p.contains(name) || !p[name]["value"].is_array()) return v;
  for (size_t i = 0; i < 3 && i < p[name]["value"].size(); ++i) v[static_cast<long>(i)] = p[name]["value"][i].get<double>();
  return v;
}

Eigen::VectorXd numbers(std::initializer_list<double> values) {
  Eigen::VectorXd v(static_cast<long>(values.size()));
  long i = 0;
  for (double x : values) v[i++] = x;
  return v;
}

// One joint's term: its coefficients from the reported parameters (torque_words.cpp, the other way round).
void add_joint_term(TermKind kind, int joint, size_t at, const Json& finding, std::vector<FoundTerm>* list) {
  const auto first = finding["parameters"].begin();
  const double value = first.value()["value"].is_number() ? first.value()["value"].get<double>() : 0.0;
  FoundTerm out{make_term(kind, joint), numbers({value}), at, first.key(), first.value()["unit"], value};
  if (kind == TermKind::kGain) out.theta[0] = 1.0 - value;
  if (kind == TermKind::kSpring) {
    out.term.columns = 2;
    out.theta = numbers({value, -value * get_value(finding, "rest")});
  } else if (kind == TermKind::kCogging) {
    const double phase = get_value(finding, "phase");
    out.term.columns = 2, out.term.shape = get_value(finding, "periods");
    out.theta = numbers({value * std::cos(phase), value * std::sin(phase)});
  } else if (kind == TermKind::kStribeck) {
    out.term.kind = TermKind::kDry;
    list->push_back(out);
    out.term.kind = kind, out.term.shape = get_value(finding, "stribeck_velocity");
    out.theta = numbers({get_value(finding, "static") - value});
    out.parameter.clear();
  }
  list->push_back(out);
}

void add_link_term(TermKind kind, int link, size_t at, const Json& finding, std::vector<FoundTerm>* list) {
  FoundTerm out{make_term(kind, link), numbers({get_value(finding, "scale") - 1.0}), at, "", "", 0.0};
  if (kind == TermKind::kPayload) {
    const double m = get_value(finding, "mass");
    const Eigen::Vector3d c = m * get_vector(finding, "com");
    out.term.columns = 4, out.theta = numbers({m, c[0], c[1], c[2]});
  } else if (kind == TermKind::kComError || kind == TermKind::kForce) {
    out.term.columns = 3, out.theta = get_vector(finding, kind == TermKind::kForce ? "force" : "offset");
  } else if (kind == TermKind::kCarried) {
    out.theta = numbers({get_value(finding, "share")});
  } else if (kind != TermKind::kMassError) {
    return;
  }
  list->push_back(out);
}

// What terms of links add in every joint's rows of one recording: kept samples x joints.
Eigen::MatrixXd predict_links(const TorqueData& data, const TorqueRecording& r, const std::vector<FoundTerm>& found) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(r.kept(), r.q.cols());
  std::vector<Term> terms;
  Eigen::VectorXd theta(0);
  for (const FoundTerm& f : found) {
    if (!f.term.whole) continue;
    terms.push_back(f.term);
    theta.conservativeResize(theta.size() + f.theta.size());
    theta.tail(f.theta.size()) = f.theta;
  }
  if (terms.empty()) return out;
  const std::vector<Eigen::MatrixXd> columns = calc_whole_columns(data, r, terms);
  for (long j = 0; j < out.cols(); ++j) out.col(j) = columns[static_cast<size_t>(j)] * theta;
  return out;
}

}  // namespace

double find_parameter(const Term& term, const Eigen::VectorXd& theta) {
  if (term.kind == TermKind::kGain) return 1.0 - theta[0];
  return term.kind == TermKind::kCogging ? theta.norm() : theta[0];
}

Eigen::MatrixXd predict_found(const TorqueData& data, const TorqueRecording& r, const std::vector<FoundTerm>& found) {
  Eigen::MatrixXd predicted = predict_links(data, r, found);
  for (const FoundTerm& f : found) {
    if (!f.term.whole) predicted.col(f.term.place) += calc_joint_columns(data, r, f.term) * f.theta;
  }
  return predicted;
}

std::vector<FoundTerm> list_found_terms(const Experiment& e, const Json& findings) {
  std::vector<FoundTerm> joints, links;
  for (size_t f = 0; f < findings.size(); ++f) {
    const Json& finding = findings[f];
    const std::optional<TermKind> kind = find_kind(finding["effect"]);
    if (!kind || finding["parameters"].empty()) continue;
    const Json& where = finding["where"];
    if (where.contains("joint") && *kind != TermKind::kOffset) {
      const int joint = e.robot.tree.find_joint(where["joint"].get<std::string>());
      if (joint >= 0) add_joint_term(*kind, joint, f, finding, &joints);
    } else if (where.contains("link")) {
      for (size_t i = 1; i < e.robot.tree.links.size(); ++i) {
        if (e.robot.tree.links[i].name == where["link"].get<std::string>()) add_link_term(*kind, static_cast<int>(i), f, finding, &links);
      }
    }
  }
  joints.insert(joints.end(), links.begin(), links.end());
  return joints;
}

}  // namespace hrp::diagnosis
