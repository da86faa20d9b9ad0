// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/motion_rows.h"

#include <algorithm>

#include "diagnosis/estimate/enough.h"
#include "diagnosis/measurement/load_or_unit.h"

namespace hrp::diagnosis {
namespace {

constexpr long kSamples = 600;                        // from all recordings, at equal distances
constexpr long kFewest = kRowsPerColumn * kNuisance;  // samples for a result

}  // namespace

bool SampledMotion::tell_nothing() const { return q.rows() < kFewest || weight.isZero(); }

double SampledMotion::count_judged() const {
  return (weight.array() > 0.0).select(use.colwise().sum().transpose().array(), 0.0).sum();
}

double SampledMotion::calc_left(const Eigen::MatrixXd& missing) const {
  double sum = 0.0;
  for (long j = 0; j < missing.cols(); ++j) {
    const Eigen::MatrixXd& B = basis[static_cast<size_t>(j)];
    const Eigen::VectorXd own = missing.col(j).cwiseProduct(use.col(j));
    sum += weight[j] * (own - B * (B.transpose() * own)).squaredNorm();
  }
  return sum;
}

SampledMotion take_rows(const TorqueData& data, const std::vector<size_t>& recordings, double from, double to) {
  const auto find_row = [&](size_t i, double share) {
    return std::lround(share * static_cast<double>(data.recordings[i].kept()));
  };
  long all = 0;
  for (size_t i : recordings) all += find_row(i, to) - find_row(i, from);
  const long skip = std::max(1L, all / kSamples), n = static_cast<long>(data.source.size());
  std::vector<std::pair<const TorqueRecording*, long>> picked;
  for (size_t i : recordings) {
    for (long k = find_row(i, from); k < find_row(i, to); k += skip) picked.emplace_back(&data.recordings[i], k);
  }
  SampledMotion rows;
  const long count = static_cast<long>(picked.size());
  for (Eigen::MatrixXd* m : {&rows.q, &rows.v, &rows.a, &rows.effort, &rows.use}) m->resize(count, n);
  for (long i = 0; i < count; ++i) {
    const auto& [r, k] = picked[static_cast<size_t>(i)];
    const long row = r->full_row(k);
    rows.use.row(i) = r->use.row(k).cast<double>();
    rows.q.row(i) = r->q.row(row);
    rows.v.row(i) = r->v.row(row);
    rows.a.row(i) = r->a.row(row);
    rows.effort.row(i) = r->effort.row(row);
  }
  rows.weight.setZero(n);
  if (count < kFewest) return rows;
  for (long j = 0; j < n; ++j) {
    Eigen::MatrixXd nuisance(count, kNuisance);
    nuisance.col(0) = rows.v.col(j);
    nuisance.col(2) = rows.a.col(j);
    nuisance.col(3).setOnes();
    nuisance.col(1) = (rows.v.col(j).array() / data.slow[static_cast<size_t>(j)]).tanh();
    for (long c = 0; c < kNuisance; ++c) nuisance.col(c).array() *= rows.use.col(j).array();
    rows.basis.push_back(Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(nuisance).householderQ() *
                         Eigen::MatrixXd::Identity(count, kNuisance));
    const double variance = (rows.effort.col(j).array() - rows.effort.col(j).mean()).square().mean();
    if (data.is_judged(static_cast<int>(j)) && variance > 0.0) rows.weight[j] = 1.0 / variance;
  }
  return rows;
}

std::vector<size_t> list_unloaded_training(const TorqueData& data) {
  std::vector<size_t> train;
  for (size_t r = 0; r < data.recordings.size(); ++r) {
    const RecordingSpec& spec = data.experiment->recordings[data.recordings[r].index].spec;
    if (data.recordings[r].train && spec.loads.empty() && spec.pushes.empty()) train.push_back(r);
  }
  return train;
}

}  // namespace hrp::diagnosis
