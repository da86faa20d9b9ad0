// SPDX-License-Identifier: BSD-3-Clause
// Sums of products over the rows of one equation, from which fits of any effects follow.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace hrp::diagnosis::floating {

// Of an equation's columns x and its mismatch y, noise taken out: G = sum w (x x^T - d d^T), d half the difference of
// the halves. G is as large as the equation has columns; of columns that were not summed it is zero.
struct Moments {
  Eigen::MatrixXd G;
  Eigen::VectorXd b;
  double yy = 0, total = 0, noise = 0;
};

// Sums many rows at a time: a product of matrices is several times faster than one of vectors for each row.
class MomentSum {
 public:
  // `columns`: of a row. `used`: those that are summed; the time grows with the square of their number.
  MomentSum(long columns, std::vector<long> used);

  void add(const double* x, const double* d, double y, double e, double w);
  Moments take();

 private:
  void flush();

  long columns_;
  std::vector<long> used_;
  Moments m_;  // of the columns that are used, in turn
  Eigen::MatrixXd x_, d_;
  long filled_ = 0;
};

}  // namespace hrp::diagnosis::floating
