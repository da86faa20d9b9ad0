// SPDX-License-Identifier: BSD-3-Clause
// A model without physics: how much of a series any smooth function of the given quantities predicts. Ridge regression
// on random Fourier features (Rahimi and Recht, "Random features for large-scale kernel machines", NIPS 2007).
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace hrp::diagnosis {

struct FreeData {
  Eigen::MatrixXd x;  // samples x quantities
  Eigen::VectorXd y;
  std::vector<int> fold;  // by sample; for choosing the ridge
};

// Share of the squares of `test` that the model learnt on `train` takes away; at least 0. The same features every time.
double find_free_share(const FreeData& train, const FreeData& test);

}  // namespace hrp::diagnosis
