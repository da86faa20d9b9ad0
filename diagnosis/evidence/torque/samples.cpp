// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/samples.h"

#include <cmath>

namespace hrp::diagnosis {
namespace {

// Kept training samples of a recording in which the joint is used.
std::vector<long> list_term_rows(const TorqueRecording& r, int joint) {
  std::vector<long> rows;
  for (long k = 0; k < r.kept() && r.train; ++k) {
    if (r.use(k, joint)) rows.push_back(k);
  }
  return rows;
}

void append(const Eigen::MatrixXd& block, Eigen::MatrixXd* all) {
  const long before = all->rows();
  all->conservativeResize(before + block.rows(), block.cols());
  if (block.size() > 0) all->bottomRows(block.rows()) = block;  // without columns there is no memory to point into
}

}  // namespace

TorqueSamples list_torque_samples(const TorqueDesign& design, const TorqueModel& model, size_t i) {
  const TorqueData& data = *design.data;
  const int j = design.joints[i].joint;
  std::vector<Term> own, whole;
  for (size_t t : model.own[i]) own.push_back(design.joints[i].terms[t]);
  for (size_t t : model.whole) whole.push_back(design.whole[t]);
  Eigen::MatrixXd x, rest;  // rest: y, effort, its rate, quantities of parts
  for (const TorqueRecording& r : data.recordings) {
    const std::vector<long> rows = list_term_rows(r, j);
    if (rows.empty()) continue;
    std::vector<Eigen::MatrixXd> blocks;
    for (const Term& term : own) blocks.push_back(calc_joint_columns(data, r, term));
    if (!whole.empty()) blocks.push_back(calc_whole_columns(data, r, whole)[static_cast<size_t>(j)]);
    long width = 0;
    for (const Eigen::MatrixXd& block : blocks) width += block.cols();
    Eigen::MatrixXd columns(static_cast<long>(rows.size()), width),
        others(static_cast<long>(rows.size()), 3 + kQuantitiesOfParts);
    for (size_t n = 0; n < rows.size(); ++n) {
      const long k = rows[n], full = r.full_row(k);
      long at = 0;
      for (const Eigen::MatrixXd& block : blocks) {
        columns.row(static_cast<long>(n)).segment(at, block.cols()) = block.row(k);
        at += block.cols();
      }
      others.row(static_cast<long>(n)) << r.missing(k, j), r.effort(full, j), r.effort_rate(full, j),
          static_cast<double>(r.index), static_cast<double>(k) / static_cast<double>(r.kept()), std::abs(r.v(full, j)),
          r.q(full, j), std::abs(r.tau(full, j));
    }
    append(columns, &x);
    append(others, &rest);
  }
  TorqueSamples out;
  out.x = x;
  if (rest.rows() == 0) return out;
  out.y = rest.col(0);
  out.effort = rest.col(1);
  out.effort_rate = rest.col(2);
  out.of = rest.rightCols(kQuantitiesOfParts);
  return out;
}

Eigen::VectorXd list_column(const TorqueDesign& design, size_t i, const Term& term) {
  const int j = design.joints[i].joint;
  std::vector<double> values;
  for (const TorqueRecording& r : design.data->recordings) {
    const std::vector<long> rows = list_term_rows(r, j);
    if (rows.empty()) continue;
    const Eigen::MatrixXd column = calc_joint_columns(*design.data, r, term);
    for (long k : rows) values.push_back(column(k, 0));
  }
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<long>(values.size()));
}

Eigen::MatrixXd list_law_columns(const TorqueDesign& design, const TorqueModel& model, size_t i,
                                 const TorqueRecording& r) {
  std::vector<Eigen::MatrixXd> parts;
  for (size_t t : model.own[i]) parts.push_back(calc_joint_columns(*design.data, r, design.joints[i].terms[t]));
  std::vector<Term> whole;
  for (size_t t : model.whole) whole.push_back(design.whole[t]);
  if (!whole.empty())
    parts.push_back(calc_whole_columns(*design.data, r, whole)[static_cast<size_t>(design.joints[i].joint)]);
  Eigen::MatrixXd columns(r.kept(), 0);
  for (const Eigen::MatrixXd& part : parts) {
    columns.conservativeResize(Eigen::NoChange, columns.cols() + part.cols());
    columns.rightCols(part.cols()) = part;
  }
  return columns;
}

FoundLaws list_laws(const TorqueDesign& design, const TorqueModel& model, size_t i) {
  FoundLaws laws{design.joints[i].joint, {}, design.joints[i].effective};
  for (const TorqueRecording& r : design.data->recordings)
    laws.columns.push_back(list_law_columns(design, model, i, r));
  return laws;
}

Eigen::MatrixXd invert_gram(const Eigen::MatrixXd& x) { return invert_sums(x.transpose() * x); }

Eigen::MatrixXd invert_sums(Eigen::MatrixXd G) {
  G.diagonal() += 1e-9 * G.diagonal();
  G.diagonal().array() += 1e-300;
  return G.ldlt().solve(Eigen::MatrixXd::Identity(G.rows(), G.cols()));
}

}  // namespace hrp::diagnosis
