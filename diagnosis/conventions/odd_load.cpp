// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/odd_load.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "diagnosis/estimate/rows_per_column.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/measurement/load_or_unit.h"
#include "diagnosis/measurement/torque_terms.h"

namespace hrp::diagnosis {
namespace {

constexpr long kCommon = 6;       // v, direction, a, 1, tau, |tau| direction: the same in all recordings
constexpr double kCost = 10.0;    // [nats] four parameters, which link and which recording
constexpr long kFewest = kRowsPerColumn * kCommon;  // samples of a joint

// Rows of one joint, all recordings; those of friction, rotor and gain are taken out.
struct JointRows {
  Eigen::VectorXd y;                      // [N m]
  Eigen::MatrixXd always;                 // by link: a load in all recordings
  std::vector<Eigen::MatrixXd> in_file;   // by file: the same in its rows only
};

std::vector<std::string> list_files(const TorqueData& data) {
  std::vector<std::string> files;
  for (const TorqueRecording& r : data.recordings) {
    const std::string& file = data.experiment->recordings[r.index].spec.file;
    if (!has(files, file)) files.push_back(file);
  }
  return files;
}

class OddLoadSearch {
 public:
  explicit OddLoadSearch(const TorqueData& data) : data_(data), files_(list_files(data)) {
    for (size_t link = 1; link < data.experiment->robot.tree.links.size(); ++link)
      loads_.push_back({&find_term_row(&TermRow::load), static_cast<int>(link)});
  }

  std::optional<OddLoad> run() {
    if (files_.size() < 2) return std::nullopt;
    collect();
    if (rows_.empty()) return std::nullopt;
    std::optional<OddLoad> best;
    for (size_t file = 0; file < files_.size(); ++file) {
      for (size_t load = 0; load < loads_.size(); ++load) {
        const std::optional<OddLoad> odd = fit(file, load);
        if (odd && (!best || odd->share > best->share)) best = odd;
      }
    }
    return best;
  }

 private:
  void collect() {
    std::vector<std::vector<Eigen::MatrixXd>> columns;  // by recording, by joint
    for (const TorqueRecording& r : data_.recordings) columns.push_back(calc_whole_columns(data_, r, loads_));
    for (size_t j = 0; j < data_.source.size(); ++j) {
      if (data_.source[j] == EffortSource::kRecorded) add_joint(static_cast<int>(j), columns);
    }
  }

  void add_joint(int joint, const std::vector<std::vector<Eigen::MatrixXd>>& columns) {
    long n = 0;
    for (const TorqueRecording& r : data_.recordings) n += r.use.col(joint).count();
    if (n < kFewest) return;
    const long width = kLoadColumns * static_cast<long>(loads_.size());
    Eigen::MatrixXd common(n, kCommon), always(n, width);
    JointRows rows{Eigen::VectorXd(n), {}, std::vector<Eigen::MatrixXd>(files_.size(), Eigen::MatrixXd::Zero(n, width))};
    long at = 0;
    for (size_t i = 0; i < data_.recordings.size(); ++i) {
      const TorqueRecording& r = data_.recordings[i];
      const std::string& file = data_.experiment->recordings[r.index].spec.file;
      const auto f = static_cast<size_t>(std::find(files_.begin(), files_.end(), file) - files_.begin());
      const Eigen::VectorXd direction = data_.calc_sign(r, joint);
      for (long k = 0; k < r.kept(); ++k) {
        if (!r.use(k, joint)) continue;
        const long full = r.full_row(k);
        const double tau = r.tau(full, joint);
        common.row(at) << r.v(full, joint), direction[full], r.a(full, joint), 1.0, tau, std::abs(tau) * direction[full];
        rows.y[at] = r.missing(k, joint);
        always.row(at) = columns[i][static_cast<size_t>(joint)].row(k);
        rows.in_file[f].row(at) = always.row(at);
        ++at;
      }
    }
    rows.y = take_out(common, rows.y), rows.always = take_out(common, always);
    for (Eigen::MatrixXd& file : rows.in_file) file = take_out(common, file);
    rows_.push_back(std::move(rows));
  }

  // [1/(N m)^2] of a joint's rows: over what its own loads, in all recordings and in one, leave at best.
  static double weigh(const JointRows& rows, const Eigen::MatrixXd& X) {
    const Eigen::VectorXd left = take_out(X, rows.y);
    return static_cast<double>(rows.y.size()) / std::max(1e-300, left.squaredNorm());
  }

  std::optional<OddLoad> fit(size_t file, size_t load) const {
    constexpr long kBoth = 2 * kLoadColumns;
    Eigen::MatrixXd xx = Eigen::MatrixXd::Zero(kBoth, kBoth);
    Eigen::VectorXd xy = Eigen::VectorXd::Zero(kBoth);
    double yy = 0.0, n = 0.0;
    for (const JointRows& rows : rows_) {
      Eigen::MatrixXd X(rows.y.size(), kBoth);
      const long at = kLoadColumns * static_cast<long>(load);
      X << rows.always.middleCols(at, kLoadColumns), rows.in_file[file].middleCols(at, kLoadColumns);
      const double weight = weigh(rows, X);
      xx += weight * X.transpose() * X, xy += weight * X.transpose() * rows.y, yy += weight * rows.y.squaredNorm();
      n += static_cast<double>(rows.y.size());
    }
    const auto all = xx.completeOrthogonalDecomposition();
    const auto common = xx.topLeftCorner<kLoadColumns, kLoadColumns>().completeOrthogonalDecomposition();
    const Eigen::VectorXd p = all.solve(xy);
    const double left = std::max(1e-300, yy - xy.dot(p));
    const double without = yy - xy.head<kLoadColumns>().dot(common.solve(xy.head<kLoadColumns>()));
    // Odds beyond chance, and most of what is left: friction that changes with the day takes less, and follows no mass.
    const double independent = n / kPerPeriod;
    if (0.5 * independent * std::log(without / left) < kCost + kOdds || left > kHalf * without) return std::nullopt;
    const Eigen::VectorXd std = (left / independent * all.pseudoInverse().diagonal()).cwiseMax(0.0).cwiseSqrt();
    const double mass = p[kLoadColumns];
    if (mass < kUnlikely * std[kLoadColumns]) return std::nullopt;
    OddLoad odd{files_[file], loads_[load].place, mass, std[kLoadColumns], p.tail<3>() / mass, std.tail<3>() / mass, 1.0 - left / without, false};
    odd.leave_out = has_others(files_[file]);
    return odd;
  }

  // True if other files have recordings of every role that this file's have.
  bool has_others(const std::string& file) const {
    const auto has = [&](bool train, bool own) {
      return std::any_of(data_.recordings.begin(), data_.recordings.end(), [&](const TorqueRecording& r) {
        return r.train == train && (data_.experiment->recordings[r.index].spec.file == file) == own;
      });
    };
    return (!has(true, true) || has(true, false)) && (!has(false, true) || has(false, false));
  }

  const TorqueData& data_;
  const std::vector<std::string> files_;
  std::vector<Term> loads_;
  std::vector<JointRows> rows_;
};

}  // namespace

std::optional<OddLoad> find_odd_load(const TorqueData& data) { return OddLoadSearch(data).run(); }

Experiment leave_out(Experiment e, const OddLoad& load) {
  e.recordings.erase(std::remove_if(e.recordings.begin(), e.recordings.end(), [&](const Recording& r) { return r.spec.file == load.file; }),
                     e.recordings.end());
  return e;
}

}  // namespace hrp::diagnosis
