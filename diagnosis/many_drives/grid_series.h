// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "diagnosis/data/low_pass.h"

namespace hrp::diagnosis {

// A signal on an even grid with its first and second derivative, as lists {value, rate, second}. `step` [s].
template <class Series>
Series differentiate_twice(const Eigen::VectorXd& value, double step) {
  const auto list = [](const Eigen::VectorXd& v) { return std::vector<double>(v.data(), v.data() + v.size()); };
  const Eigen::VectorXd rate = differentiate(value, step);
  return {list(value), list(rate), list(differentiate(rate, step))};
}

}  // namespace hrp::diagnosis
