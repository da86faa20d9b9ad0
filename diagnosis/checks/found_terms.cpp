// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/checks/found_terms.h"

#include <algorithm>

#include "diagnosis/report/json.h"

namespace hrp::diagnosis {
namespace {

const TermRow* find_row(const std::string& effect) {
  for (const TermRow& row : list_term_rows()) {
    if (row.effect->name == effect) return &row;
  }
  return nullptr;
}

// Values of the effect's parameters in the order of its table row; 0 if they are neither reported nor fitted beside.
std::vector<double> list_values(const EffectInfo& effect, const Json& finding) {
  const Json& reported = finding["parameters"];
  const Json fitted = finding.value("also_fitted", Json::object());
  std::vector<double> values;
  for (const EffectParameter& p : effect.parameters) {
    const Json value = reported.contains(p.name) ? reported[p.name]["value"] : fitted.value(p.name, Json());
    const Json number = p.axis >= 0 && value.is_array() ? value.at(static_cast<size_t>(p.axis)) : value;
    values.push_back(number.is_number() ? number.get<double>() : 0.0);
  }
  return values;
}

// Dry friction that differs by direction is a level and a constant torque: level (1 +- asymmetry).
FoundTerm make_asymmetry(const FoundTerm& level, double asymmetry) {
  const std::vector<TermRow>& rows = list_term_rows();
  const auto constant =
      std::find_if(rows.begin(), rows.end(), [](const TermRow& r) { return r.is_constant() && !r.whole; });
  return {{&*constant, level.term.place}, asymmetry * level.theta, level.finding, "", "", 0.0};
}

// Adds a term with the coefficients of the reported parameters. Stribeck friction becomes a level and its excess.
void add_term(const TermRow& row, int place, size_t at, const Json& finding, std::vector<FoundTerm>* list) {
  const std::vector<double> values = list_values(*row.effect, finding);
  FoundTerm out{{&row, place, row.shape_parameter < 0 ? 0.0 : values[static_cast<size_t>(row.shape_parameter)]},
                calc_coefficients(row, values),
                at,
                "",
                "",
                0.0};
  if (!row.whole) {
    const auto first = finding["parameters"].begin();
    out.parameter = first.key();
    out.unit = first.value()["unit"];
    out.value = values[0];
  }
  if (row.excess) {
    FoundTerm level = out;
    level.term = {&find_term_row(&TermRow::level), place};
    list->push_back(level);
    out.theta[0] = values[1] - values[0];
    out.parameter.clear();
  }
  list->push_back(out);
  for (size_t i = 0; i < values.size(); ++i) {
    if (row.effect->parameters[i].by_direction && values[i] != 0.0) list->push_back(make_asymmetry(out, values[i]));
  }
}

// Contribution of links to every joint's torque in one recording: kept samples x joints [N m].
Eigen::MatrixXd predict_links(const TorqueData& data, const TorqueRecording& r, const std::vector<FoundTerm>& found) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(r.kept(), r.q.cols());
  std::vector<Term> terms;
  Eigen::VectorXd theta(0);
  for (const FoundTerm& f : found) {
    if (!f.term.whole()) continue;
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

Eigen::MatrixXd predict_found(const TorqueData& data, const TorqueRecording& r, const std::vector<FoundTerm>& found) {
  Eigen::MatrixXd predicted = predict_links(data, r, found);
  for (const FoundTerm& f : found) {
    if (!f.term.whole()) predicted.col(f.term.place) += calc_joint_columns(data, r, f.term) * f.theta;
  }
  return predicted;
}

std::vector<FoundTerm> list_found_terms(const Experiment& e, const Json& findings) {
  std::vector<FoundTerm> joints, links;
  for (size_t f = 0; f < findings.size(); ++f) {
    const Json& finding = findings[f];
    const TermRow* row = find_row(finding["effect"]);
    if (!row || finding["parameters"].empty()) continue;
    const Place place = find_place(e, *row->effect, finding["where"]);
    const bool of_joint = row->of_log ? place.reading == Reading::kEffort : place.kind == PlaceKind::kJoint;
    if (of_joint && !row->whole && place.index >= 0) add_term(*row, place.index, f, finding, &joints);
    if (place.kind == PlaceKind::kLink && place.index > 0) add_term(*row, place.index, f, finding, &links);
  }
  joints.insert(joints.end(), links.begin(), links.end());
  return joints;
}

}  // namespace hrp::diagnosis
