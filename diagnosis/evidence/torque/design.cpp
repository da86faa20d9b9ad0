// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/design.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/gram.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/load_or_unit.h"
#include "diagnosis/measurement/passive_torque.h"

namespace hrp::diagnosis {
namespace {

// By recording and kept sample: index of the fold; -1 in held-out recordings.
std::vector<std::vector<int>> assign_folds(const TorqueData& data, int* count) {
  double time = 0.0;
  for (const TorqueRecording& r : data.recordings)
    time += r.train ? static_cast<double>(r.kept() * r.stride) * r.step : 0.0;
  // About 2.5 s: long beside the time for which residuals resemble each other.
  const double piece = time / std::clamp(time / (kFarMore * kBlock), double{kFewestBlocks}, double{kFolds});
  std::vector<std::vector<int>> folds;
  *count = 0;
  for (const TorqueRecording& r : data.recordings) {
    folds.emplace_back(static_cast<size_t>(r.kept()), -1);
    if (!r.train) continue;
    const double own = static_cast<double>(r.kept() * r.stride) * r.step;
    const long pieces = std::max(1L, std::lround(own / piece));
    for (long k = 0; k < r.kept(); ++k)
      folds.back()[static_cast<size_t>(k)] = *count + static_cast<int>(k * pieces / r.kept());
    *count += static_cast<int>(pieces);
  }
  return folds;
}

// Rows that are added to sums together: a product of matrices takes a fraction of the time of its rows one by one.
class RowBlock {
 public:
  explicit RowBlock(long width) : X_(width, kMost), y_(kMost) {}
  bool is_full() const { return count_ == kMost; }
  auto next() { return X_.col(count_); }
  void add(double y) { y_[count_++] = y; }
  void move_to(Gram* sums) {
    if (count_ > 0) sums->add_columns(X_.leftCols(count_), y_.head(count_));
    count_ = 0;
  }

 private:
  static constexpr long kMost = 128;
  Eigen::MatrixXd X_;  // a row of the equations in each column
  Eigen::VectorXd y_;
  long count_ = 0;
};

struct Rows {
  std::vector<Eigen::MatrixXd> own;    // by recording: kept samples x columns of the joint's terms
  std::vector<Eigen::MatrixXd> whole;  // by recording
};

// Half-cycles of the joint's motion in training: changes of direction, plus one per recording.
double count_half_cycles(const TorqueData& data, int joint) {
  double count = 0.0;
  for (const TorqueRecording& r : data.recordings) {
    double last = 0.0;
    for (long k = 0; k < r.kept() && r.train; ++k) {
      if (!r.use(k, joint)) continue;
      const double v = r.v(r.full_row(k), joint);
      if (v * last <= 0.0) count += 1.0;
      last = v;
    }
  }
  return count;
}

// Columns of all terms without memory. Terms with memory can follow any slow error of a motion.
Columns list_common_columns(const JointDesign& joint, long whole_width) {
  Columns list;
  for (size_t t = 0; t < joint.terms.size(); ++t) {
    if (joint.terms[t].row->memory) continue;
    for (long c : list_columns(joint, t)) list.push_back(c);
  }
  for (long c = 0; c < whole_width; ++c) list.push_back(joint.own_width + c);
  return list;
}

// Residual [N m] of these columns with parameters from the sums `fitted`: by recording and kept sample; NaN where a row
// is not used.
std::vector<std::vector<double>> calc_left(const TorqueData& data, const JointDesign& joint, const Rows& rows,
                                           const Gram& fitted, const Columns& columns) {
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(joint.own_width + rows.whole[0].cols());
  const Eigen::VectorXd found = solve(fitted, columns);
  for (size_t c = 0; c < columns.size(); ++c) theta[columns[c]] = found[static_cast<long>(c)];
  const auto own = theta.head(joint.own_width), whole = theta.tail(rows.whole[0].cols());
  std::vector<std::vector<double>> left;
  for (size_t r = 0; r < data.recordings.size(); ++r) {
    left.emplace_back();
    for (long k = 0; k < data.recordings[r].kept(); ++k)
      left.back().push_back(data.recordings[r].use(k, joint.joint)
                                ? data.recordings[r].missing(k, joint.joint) - rows.own[r].row(k).dot(own) -
                                      rows.whole[r].row(k).dot(whole)
                                : std::numeric_limits<double>::quiet_NaN());
  }
  return left;
}

// Number of independent training samples. The residual of a model follows the motion. Therefore at most `kLooks`
// samples per half-cycle count as independent, even if the noise is white.
double count_independent(const TorqueData& data, const JointDesign& joint,
                         const std::vector<std::vector<double>>& all_left) {
  double independent = 0.0;
  for (size_t r = 0; r < all_left.size(); ++r) {
    std::vector<double> left;
    for (double x : all_left[r]) {
      if (std::isfinite(x) && data.recordings[r].train) left.push_back(x);
    }
    if (left.empty()) continue;
    const Eigen::Map<const Eigen::VectorXd> series(left.data(), static_cast<long>(left.size()));
    independent += static_cast<double>(left.size()) / calc_correlation_time(series);
  }
  return std::min(independent, kLooks * count_half_cycles(data, joint.joint));
}

// Marks samples as unused if no term explains them (knocks, touches, numerical failures): their residual exceeds
// kTenTimes the median, 6.7 standard deviations of normal errors. In a recording with many such samples the terms are
// wrong, so they stay. A load that swings and then rests, or another motion in held-out data, is no outlier. Therefore
// the fit uses the terms of the whole robot and all recordings. Returns true if it marked any.
bool drop_outliers(const JointDesign& joint, const Rows& rows, TorqueData* data) {
  const long width = joint.own_width + rows.whole[0].cols();
  Gram everything = sum(joint.held, width);
  everything.add(joint.total, 1.0);
  const std::vector<std::vector<double>> left =
      calc_left(*data, joint, rows, everything, list_common_columns(joint, rows.whole[0].cols()));
  std::vector<double> size;
  for (const std::vector<double>& recording : left) {
    for (double x : recording) {
      if (std::isfinite(x)) size.push_back(std::abs(x));
    }
  }
  if (size.empty()) return false;
  const double limit = kTenTimes * find_median(std::move(size));
  bool any = false;
  for (size_t r = 0; r < left.size(); ++r) {
    // false for NaN, so unused samples are no outliers
    const auto is_far = [&](double x) { return std::abs(x) > limit; };
    const auto is_used = [](double x) { return std::isfinite(x); };
    const double share = static_cast<double>(std::count_if(left[r].begin(), left[r].end(), is_far)) /
                         std::max(1.0, static_cast<double>(std::count_if(left[r].begin(), left[r].end(), is_used)));
    for (size_t k = 0; k < left[r].size() && share < kDetail; ++k) {
      if (!(std::abs(left[r][k]) > limit)) continue;
      data->recordings[r].use(static_cast<long>(k), joint.joint) = false;
      any = true;
    }
  }
  return any;
}

// Folds of one joint. If the joint is used in too few folds, its own samples are divided into equal parts.
std::vector<std::vector<int>> assign_own_folds(const TorqueData& data, int joint, std::vector<std::vector<int>> folds) {
  std::set<int> used;
  long samples = 0, at = 0;
  const auto is_fitted = [&](size_t r, long k) {
    return folds[r][static_cast<size_t>(k)] >= 0 && data.recordings[r].use(k, joint);
  };
  for (size_t r = 0; r < folds.size(); ++r) {
    for (long k = 0; k < data.recordings[r].kept(); ++k) {
      if (is_fitted(r, k)) {
        used.insert(folds[r][static_cast<size_t>(k)]);
        ++samples;
      }
    }
  }
  if (used.size() >= kFewestBlocks || samples < static_cast<long>(kFewestToTell)) return folds;
  for (size_t r = 0; r < folds.size(); ++r) {
    for (long k = 0; k < data.recordings[r].kept(); ++k) {
      if (is_fitted(r, k))
        folds[r][static_cast<size_t>(k)] = static_cast<int>(static_cast<long>(kFewestBlocks) * at++ / samples);
    }
  }
  return folds;
}

void fill_joint(const TorqueData& data, const std::vector<std::vector<int>>& folds, int fold_count, const Rows& rows,
                JointDesign* joint) {
  const long width = joint->own_width + rows.whole[0].cols();
  joint->train.assign(static_cast<size_t>(fold_count), Gram(width));
  joint->held.clear();
  Spread spread;
  for (size_t r = 0; r < data.recordings.size(); ++r) {
    const TorqueRecording& recording = data.recordings[r];
    Gram held(width);
    RowBlock block(width);
    Gram* last = &held;
    for (long k = 0; k < recording.kept(); ++k) {
      if (!recording.use(k, joint->joint)) continue;
      const int fold = folds[r][static_cast<size_t>(k)];
      Gram* const to = fold < 0 ? &held : &joint->train[static_cast<size_t>(fold)];
      if (to != last || block.is_full()) {
        block.move_to(last);
        last = to;
      }
      block.next() << rows.own[r].row(k).transpose(), rows.whole[r].row(k).transpose();
      block.add(recording.missing(k, joint->joint));
      spread.add(recording.effort(recording.full_row(k), joint->joint));
    }
    block.move_to(last);
    if (held.n > 0.0) joint->held.push_back(held);
  }
  joint->spread = spread.get();
  joint->total = sum(joint->train, width);
}

// Correlation of effort and nominal torque in the training samples in use.
double correlate_load(const TorqueData& data, int joint) {
  Eigen::Matrix2d S = Eigen::Matrix2d::Zero();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double n = 0.0;
  for (const TorqueRecording& r : data.recordings) {
    for (long k = 0; k < r.kept() && r.train; ++k) {
      if (!r.use(k, joint)) continue;
      const Eigen::Vector2d x(r.effort(r.full_row(k), joint), r.tau(r.full_row(k), joint));
      S += x * x.transpose();
      sum += x;
      n += 1.0;
    }
  }
  S -= sum * sum.transpose() / std::max(1.0, n);
  return S(0, 1) / std::sqrt(std::max(1e-300, S(0, 0) * S(1, 1)));
}

// The same beside friction, rotor and a constant, of a joint whose torque these do not explain and whose effort was
// logged, in volts perhaps. Back-EMF of a motor that drives a pendulum is four times the pendulum's torque: the effort
// hardly follows the torque, and tells its gain to 1 %.
double correlate_load_beside_drive(const TorqueData& data, int joint) {
  if (data.source[static_cast<size_t>(joint)] != EffortSource::kRecorded) return 0.0;
  const UnitRows rows = collect_efforts(data, joint);
  if (rows.tau.size() < static_cast<long>(kFewestToTell)) return 0.0;
  const Eigen::VectorXd tau = take_out(rows.nuisance, rows.tau), effort = take_out(rows.nuisance, rows.effort);
  const double own = (rows.tau.array() - rows.tau.mean()).square().sum();
  if (tau.squaredNorm() < kMuch * kMuch * own) return 0.0;
  return tau.dot(effort) / std::sqrt(std::max(1e-300, tau.squaredNorm() * effort.squaredNorm()));
}

}  // namespace

Columns list_columns(const JointDesign& joint, size_t term) {
  Columns columns;
  for (int c = 0; c < joint.terms[term].columns(); ++c) columns.push_back(joint.first[term] + c);
  return columns;
}

Columns list_whole_columns(const TorqueDesign& design, const JointDesign& joint, size_t whole_term) {
  Columns columns;
  for (int c = 0; c < design.whole[whole_term].columns(); ++c)
    columns.push_back(joint.own_width + design.whole_first[whole_term] + c);
  return columns;
}

TorqueDesign make_torque_design(TorqueData&& given) {
  TorqueDesign design;
  design.data = std::make_shared<TorqueData>(std::move(given));
  TorqueData& data = *design.data;
  design.whole = list_whole_terms(data);
  long width = 0;
  for (const Term& term : design.whole) {
    design.whole_first.push_back(width);
    width += term.columns();
  }
  int fold_count = 0;
  const std::vector<std::vector<int>> folds = assign_folds(data, &fold_count);
  // same count for all joints; joints in few folds have their own folds
  fold_count = std::max(fold_count, static_cast<int>(kFewestBlocks));
  std::vector<std::vector<Eigen::MatrixXd>> whole;  // by recording, by joint
  for (const TorqueRecording& r : data.recordings) whole.push_back(calc_whole_columns(data, r, design.whole));
  std::vector<double> passive;
  for (int j = 0; j < data.experiment->num_joints(); ++j) {
    JointDesign joint;
    joint.joint = j;
    joint.terms = list_joint_terms(data, j);
    if (joint.terms.empty()) continue;
    for (const Term& term : joint.terms) {
      joint.first.push_back(joint.own_width);
      joint.own_width += term.columns();
    }
    Rows rows;
    for (size_t r = 0; r < data.recordings.size(); ++r) {
      Eigen::MatrixXd own(data.recordings[r].kept(), joint.own_width);
      for (size_t t = 0; t < joint.terms.size(); ++t)
        own.middleCols(joint.first[t], joint.terms[t].columns()) =
            calc_joint_columns(data, data.recordings[r], joint.terms[t]);
      rows.own.push_back(std::move(own));
      rows.whole.push_back(whole[r][static_cast<size_t>(j)]);
    }
    const std::vector<std::vector<int>> own_folds = assign_own_folds(data, j, folds);
    fill_joint(data, own_folds, fold_count, rows, &joint);
    for (int pass = 0; pass < kFewRounds && joint.total.n >= kFewestToTell; ++pass) {
      if (!drop_outliers(joint, rows, &data)) break;
      fill_joint(data, own_folds, fold_count, rows, &joint);
    }
    if (joint.total.n < kFewestToTell) continue;
    if (!data.experiment->robot.tree.joint(j).actuated) {  // in place of the effort's spread
      if (passive.empty()) passive = calc_passive_squares(data);
      joint.spread = std::sqrt(passive[static_cast<size_t>(j)]);
    }
    // Then friction is the smaller part.
    joint.loaded = std::max(correlate_load(data, j), correlate_load_beside_drive(data, j)) > kMostly;
    joint.effective =
        count_independent(data, joint, calc_left(data, joint, rows, joint.total, list_common_columns(joint, 0)));
    design.joints.push_back(std::move(joint));
  }
  for (JointDesign& joint : design.joints) {
    joint.has_held = !joint.held.empty();
    design.has_held = design.has_held || joint.has_held;
    if (!joint.has_held) joint.held = joint.train;
  }
  return design;
}

}  // namespace hrp::diagnosis
