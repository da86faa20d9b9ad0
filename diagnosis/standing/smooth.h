// SPDX-License-Identifier: BSD-3-Clause
// Local cubics over a sliding window, as smooth_series() has them, for many columns with the same stamps: the weights
// depend on the stamps alone and are found once.
#pragma once

#include <cstddef>
#include <vector>

namespace hrp::diagnosis::standing {

// A smoothed series at the recording's stamps, with its rate and second derivative.
struct Series {
  std::vector<double> value, rate, second;
};

// Which samples a smoother looks at. Even and odd ones have independent noise: see fit.h.
enum class Parity { kAll, kEven, kOdd };

class Smoother {
 public:
  Smoother(const std::vector<double>& time, int half, Parity parity);
  Series run(const std::vector<double>& values) const;
  int half() const { return half_; }

 private:
  struct Kernel {
    std::size_t begin = 0;
    std::vector<double> value, rate, second;  // weights of the samples from `begin` on
  };
  std::vector<Kernel> kernels_;
  int half_ = 3;
};

}  // namespace hrp::diagnosis::standing
