// SPDX-License-Identifier: BSD-3-Clause
// Samples of one joint in use, to try laws that are no terms: training samples first, then those by which a fit is
// judged.
#pragma once

#include <utility>
#include <vector>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// Laws that were found in a joint's rows. Their values are fitted again beside what is tried: a load or a spring may
// have taken a part of the friction.
struct FoundLaws {
  int joint = 0;
  std::vector<Eigen::MatrixXd> columns;  // by recording of the data: kept samples x columns
  double effective = 0.0;                // independent training samples
};

class JointRows {
 public:
  // Held-out recordings judge; without any, the last third of the samples does.
  JointRows(const TorqueData& data, int joint);

  long train() const { return train_; }
  long held() const { return static_cast<long>(rows_.size()) - train_; }
  bool is_few() const;                                                        // too few to judge
  const std::vector<std::pair<size_t, long>>& list() const { return rows_; }  // recording, kept sample

  // Values at the rows. `calc`: from a recording's index to a vector of its kept samples.
  template <class Calc>
  Eigen::VectorXd stack(Calc calc) const {
    std::vector<Eigen::VectorXd> each;
    for (size_t r = 0; r < recordings_; ++r) each.push_back(calc(r));
    Eigen::VectorXd out(static_cast<long>(rows_.size()));
    for (size_t i = 0; i < rows_.size(); ++i) out[static_cast<long>(i)] = each[rows_[i].first][rows_[i].second];
    return out;
  }

  // Coefficients of the columns of X, from the training samples.
  Eigen::VectorXd solve(const Eigen::VectorXd& y, const Eigen::MatrixXd& X) const;
  // Squares that they leave of the samples that judge.
  double judge(const Eigen::VectorXd& y, const Eigen::MatrixXd& X) const;

 private:
  size_t recordings_ = 0;
  std::vector<std::pair<size_t, long>> rows_;
  long train_ = 0;
};

// X with one more column.
Eigen::MatrixXd append(const Eigen::MatrixXd& X, const Eigen::VectorXd& column);

}  // namespace hrp::diagnosis
