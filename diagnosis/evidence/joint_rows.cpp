// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/joint_rows.h"

#include <algorithm>

namespace hrp::diagnosis {
namespace {

constexpr long kFewest = 200;  // samples: twenty for each of ten columns

}  // namespace

JointRows::JointRows(const TorqueData& data, int joint) : recordings_(data.recordings.size()) {
  const auto is_held = [](const TorqueRecording& r) { return !r.train; };
  const bool has_held = std::any_of(data.recordings.begin(), data.recordings.end(), is_held);
  for (const bool train : {true, false}) {
    for (size_t r = 0; r < recordings_; ++r) {
      const TorqueRecording& recording = data.recordings[r];
      for (long k = 0; recording.train == train && k < recording.kept(); ++k) {
        if (recording.use(k, joint)) rows_.push_back({r, k});
      }
    }
    if (train) train_ = static_cast<long>(rows_.size());
  }
  if (!has_held) train_ = train_ * 2 / 3;
}

bool JointRows::is_few() const { return train() < kFewest || held() < kFewest; }

Eigen::VectorXd JointRows::solve(const Eigen::VectorXd& y, const Eigen::MatrixXd& X) const {
  if (X.cols() == 0) return {};  // Eigen's decompositions take no empty matrix
  return X.topRows(train_).colPivHouseholderQr().solve(y.head(train_));
}

double JointRows::judge(const Eigen::VectorXd& y, const Eigen::MatrixXd& X) const {
  return (y.tail(held()) - X.bottomRows(held()) * solve(y, X)).squaredNorm();
}

Eigen::MatrixXd append(const Eigen::MatrixXd& X, const Eigen::VectorXd& column) {
  Eigen::MatrixXd out(X.rows(), X.cols() + 1);
  out << X, column;
  return out;
}

}  // namespace hrp::diagnosis
