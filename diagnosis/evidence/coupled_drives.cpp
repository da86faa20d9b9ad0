// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/coupled_drives.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/evidence/torque/model.h"
#include "diagnosis/measurement/kept_rows.h"
#include "diagnosis/measurement/load_or_unit.h"
#include "diagnosis/model/tree.h"

namespace hrp::diagnosis {
namespace {

constexpr size_t kMost = 2;  // motors of a differential
// Samples: hundreds for each column, so that the best ratio is the best of all samples
constexpr long kToScreen = 3000;
// Ratios of the screen: from a quarter to four, in steps of 2^(1/4). Only samples at which the sign is wrong count
// against a ratio, a few percent within a step. Beyond a quarter, one of the joints hardly changes when the sign does.
constexpr int kSteps = 8;

std::vector<double> list_ratios() {
  std::vector<double> ratios;
  for (int i = -kSteps; i <= kSteps; ++i) {
    ratios.push_back(std::exp2(0.25 * i));
    ratios.push_back(-std::exp2(0.25 * i));
  }
  return ratios;
}

// Columns of one recording's kept samples.
using Column = Eigen::VectorXd (*)(const TorqueData&, const TorqueRecording&, int joint, const CoupledDrive&);

// Smooth sign of the motor's rate. Its direction is as uncertain as those of both joints.
Eigen::VectorXd calc_motor_sign(const TorqueData& data, const TorqueRecording& r, int joint, const CoupledDrive& d) {
  const double slow =
      std::hypot(data.slow[static_cast<size_t>(joint)], d.ratio * data.slow[static_cast<size_t>(d.other)]);
  return ((r.speed.col(joint) + d.ratio * r.speed.col(d.other)).array() / slow).tanh().matrix();
}

Eigen::VectorXd calc_filtered_sign(const TorqueData& data, const TorqueRecording& r, int joint, const CoupledDrive& d) {
  return data.condition(r, calc_motor_sign(data, r, joint, d));
}
Eigen::VectorXd calc_rate(const TorqueData&, const TorqueRecording& r, int, const CoupledDrive& d) {
  return keep_rows(r, r.v.col(d.other));
}
Eigen::VectorXd calc_change(const TorqueData&, const TorqueRecording& r, int, const CoupledDrive& d) {
  return keep_rows(r, r.a.col(d.other));
}

class CoupledSearch {
 public:
  CoupledSearch(const TorqueData& data, const FoundLaws& joint) : data_(data), joint_(joint), rows_(data, joint.joint) {
    const int j = joint_.joint;
    y_ = rows_.stack([&](size_t r) -> Eigen::VectorXd { return recording(r).missing.col(j); });
    own_ = Eigen::MatrixXd::Ones(y_.size(), 1);
    own_ = append(
        own_, rows_.stack([&](size_t r) -> Eigen::VectorXd { return keep_rows(recording(r), recording(r).v.col(j)); }));
    own_ = append(
        own_, rows_.stack([&](size_t r) -> Eigen::VectorXd { return keep_rows(recording(r), recording(r).a.col(j)); }));
    own_ = append(own_, rows_.stack([&](size_t r) { return data_.calc_direction(recording(r), j); }));
    own_ = append(own_, rows_.stack([&](size_t r) { return calc_load(recording(r)); }));
    for (long c = 0; c < (joint_.columns.empty() ? 0 : joint_.columns[0].cols()); ++c)
      own_ = append(own_, rows_.stack([&](size_t r) -> Eigen::VectorXd { return joint_.columns[r].col(c); }));
  }

  CoupledDrives run() {
    CoupledDrives found;
    if (rows_.is_few()) return found;
    const double own = rows_.judge(y_, own_);
    Eigen::MatrixXd smooth = own_, all = own_;
    double left = own;
    while (found.drives.size() < kMost) {
      CoupledDrive next = screen(all);
      if (!(next.level > 0.0)) break;
      refine(add_smooth(all, next), &next);
      if (turns_alike(next)) break;
      const Eigen::MatrixXd beside = add_smooth(smooth, next),
                            with = append(add_smooth(all, next), fill(calc_filtered_sign, next));
      const double without = rows_.judge(y_, add_smooth(all, next)), rest = rows_.judge(y_, with);
      next.level = rows_.solve(y_, with)[with.cols() - 1];
      // A second motor must count beside the first one.
      if (!(next.level > 0.0) || rest > kLargely * without || without - rest < kMinor * own || !is_sure(without, rest))
        break;
      found.drives.push_back(next);
      smooth = beside;
      all = with;
      left = rest;
    }
    // The jumps decide, not what another joint's motion explains without them.
    if (left > kHalf * own || left > kLargely * rows_.judge(y_, smooth)) return {};
    found.left = left / static_cast<double>(rows_.held());
    return found;
  }

 private:
  const TorqueRecording& recording(size_t r) const { return data_.recordings[r]; }

  Eigen::VectorXd fill(Column column, const CoupledDrive& d) const {
    return rows_.stack([&](size_t r) { return column(data_, recording(r), joint_.joint, d); });
  }

  Eigen::MatrixXd add_smooth(const Eigen::MatrixXd& X, const CoupledDrive& d) const {
    return append(append(X, fill(calc_rate, d)), fill(calc_change, d));
  }

  // Regressor of friction that grows with the load.
  Eigen::VectorXd calc_load(const TorqueRecording& r) const {
    return data_.condition(
        r, (r.load.col(joint_.joint).array().abs() * data_.calc_sign(r, joint_.joint).array()).matrix());
  }

  // One of all ratios at all joints: the number of candidates is the price.
  bool is_sure(double without, double with) const {
    const double tried = static_cast<double>(list_ratios().size() * (data_.source.size() - 1));
    return 0.5 * joint_.effective * std::log(without / std::max(1e-300, with)) > kWholeGain + std::log(tried);
  }

  // Every so many training samples.
  long stride() const { return 1 + rows_.train() / kToScreen; }
  Eigen::MatrixXd thin(const Eigen::MatrixXd& X) const {
    Eigen::MatrixXd out((rows_.train() + stride() - 1) / stride(), X.cols());
    for (long i = 0; i < out.rows(); ++i) out.row(i) = X.row(i * stride());
    return out;
  }

  // Sharp signs of motors that turn with `other`, too: thinned training samples x ratios.
  Eigen::MatrixXd calc_signs(int other) const {
    const std::vector<double> ratios = list_ratios();
    const auto j = static_cast<size_t>(joint_.joint), k = static_cast<size_t>(other);
    Eigen::MatrixXd signs((rows_.train() + stride() - 1) / stride(), static_cast<long>(ratios.size()));
    for (long i = 0; i < signs.rows(); ++i) {
      const auto& [r, kept] = rows_.list()[static_cast<size_t>(i * stride())];
      const long row = recording(r).full_row(kept);
      const double v = recording(r).speed(row, joint_.joint), w = recording(r).speed(row, other);
      for (long c = 0; c < signs.cols(); ++c) {
        const double ratio = ratios[static_cast<size_t>(c)];
        signs(i, c) = std::tanh((v + ratio * w) / std::hypot(data_.slow[j], ratio * data_.slow[k]));
      }
    }
    return signs;
  }

  // Motor and joint turn alike, or always against each other, but near reversals. Friction there is no function of the
  // speed, so these samples prove nothing.
  bool turns_alike(const CoupledDrive& d) const {
    long apart = 0;
    for (long i = 0; i < rows_.train(); ++i) {
      const auto& [r, kept] = rows_.list()[static_cast<size_t>(i)];
      const long row = recording(r).full_row(kept);
      const double v = recording(r).speed(row, joint_.joint);
      apart += (v + d.ratio * recording(r).speed(row, d.other)) * v < 0.0 ? 1 : 0;
    }
    const double share = static_cast<double>(apart) / static_cast<double>(rows_.train());
    return share < kMinor || share > 1.0 - kMinor;
  }

  // The drive whose sharp sign explains most of the training samples, beside `taken` and the other joint's smooth
  // motion.
  CoupledDrive screen(const Eigen::MatrixXd& taken) const {
    CoupledDrive best;
    double most = 0.0;
    for (int other = 0; other < static_cast<int>(data_.source.size()); ++other) {
      if (!may_share_drive(other)) continue;
      const Eigen::MatrixXd beside = thin(add_smooth(taken, {other, 0.0, 0.0}));
      const Eigen::VectorXd y = take_out(beside, thin(y_));
      const Eigen::MatrixXd signs = calc_signs(other), alone = take_out(beside, signs);
      for (long c = 0; c < signs.cols(); ++c) {
        const double along = alone.col(c).dot(y),
                     explained = along * along / std::max(1e-300, alone.col(c).squaredNorm());
        if (along > 0.0 && explained > most) {
          most = explained;
          best = {other, list_ratios()[static_cast<size_t>(c)], along / alone.col(c).squaredNorm()};
        }
      }
    }
    return best;
  }

  // A joint that carries this one, or that this one carries: no shaft or tendon leads from one leg to another. It must
  // move.
  bool may_share_drive(int other) const {
    const TreeSpec& tree = data_.experiment->robot.tree;
    const int link = joint_.joint + 1, link_other = other + 1;
    const bool chain = other != joint_.joint && (is_above(tree, link, link_other) || is_above(tree, link_other, link));
    // Slower motion has no clear direction.
    const double clear = kFarMore * data_.slow[static_cast<size_t>(other)];
    const auto is_clear = [&](const TorqueRecording& r) { return r.v.col(other).array().abs().maxCoeff() > clear; };
    return chain && std::any_of(data_.recordings.begin(), data_.recordings.end(), is_clear);
  }

  // Halves the steps of the ratio, as the filtered sign of the training samples wants it.
  void refine(const Eigen::MatrixXd& beside, CoupledDrive* d) const {
    double least = calc_left(append(beside, fill(calc_filtered_sign, *d)));
    for (double step : {0.125, 0.0625, 0.03125}) {
      for (double ratio : {d->ratio * std::exp2(step), d->ratio * std::exp2(-step)}) {
        const double left = calc_left(append(beside, fill(calc_filtered_sign, {d->other, ratio, 0.0})));
        if (left < least) {
          least = left;
          d->ratio = ratio;
        }
      }
    }
  }

  double calc_left(const Eigen::MatrixXd& X) const {
    return take_out(X.topRows(rows_.train()), y_.head(rows_.train())).squaredNorm();
  }

  const TorqueData& data_;
  const FoundLaws& joint_;
  const JointRows rows_;
  Eigen::VectorXd y_;
  Eigen::MatrixXd own_;  // 1, v, a, direction, load, and the laws
};

}  // namespace

CoupledDrives find_coupled_drives(const TorqueData& data, const FoundLaws& joint) {
  return CoupledSearch(data, joint).run();
}

}  // namespace hrp::diagnosis
