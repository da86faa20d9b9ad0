// SPDX-License-Identifier: BSD-3-Clause
// Slope of a drive's recorded effort over the effort that its servo's law asks for.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

namespace hrp::diagnosis {

constexpr size_t kLaterSamples = 3;  // lag at which noise is uncorrelated

// Law, recorded effort, position and the law's part by rates, at training samples where the drive is not at its limit.
struct ServoPairs {
  std::vector<double> law, effort, position, damping;
  std::vector<size_t> recording;
};

// Slope with its standard deviation from stretches.
struct ServoSlope {
  double value = 1.0, std = std::numeric_limits<double>::infinity();
};

// Slope over all samples, or over samples at equal positions. Ripple of a log over position distorts the first, but not
// the difference between two passes of one position. Returns the one with the smaller standard deviation.
ServoSlope find_slope(const ServoPairs& pairs);

// The slope if the rates in the law may be wrong by a factor: effort over law and damping, with both at other samples
// as instruments. The slope over the law alone if there is no damping.
double find_slope_beside_damping(const ServoPairs& pairs);

}  // namespace hrp::diagnosis
