// SPDX-License-Identifier: BSD-3-Clause
// Signals of a recording on an even grid, all smoothed by one kernel: what is linear in them stays exactly true. A
// stretch ends where the recording has a gap; nothing is interpolated across one.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis::floating {

// A smoothed signal at the grid's stamps, and its derivatives by differences of the smoothed values.
struct Track {
  std::vector<double> value, rate, second;
  bool empty() const { return value.empty(); }
};

// Three tracks at one stamp, as a vector; 0 where one was not recorded.
Vector3d get_values(const Track* xyz, size_t k);
Vector3d get_rates(const Track* xyz, size_t k);
// Four tracks w x y z, as a unit quaternion.
Eigen::Quaterniond get_quaternion(const Track* wxyz, size_t k);

// Samples [begin, end) of a recording, without a gap between.
struct Span {
  size_t begin = 0, end = 0;
};

// A stretch of the recording's time that was sampled without a gap.
struct Gap {
  double from = 0, to = 0;  // [s]
};

// Which samples of a sensor's columns are new readings: false where all of them repeat the sample before.
std::vector<char> find_new_samples(const std::vector<const std::vector<double>*>& columns);

// Which samples are readings, told by a sensor's own clock. `fresh`: as find_new_samples() has it. A coarse scale reads
// the same count many times over, as a foot in the air reads 0: a reading that the sensor gives again elsewhere is read
// anew once in each of its periods, and is no held one. What noise makes unique and repeats is held.
std::vector<char> find_readings(const std::vector<const std::vector<double>*>& columns, const std::vector<char>& fresh);

// Cuts a recording at stamps that stand further apart than `longest`, and where no sensor gave a new reading for so
// long. `fresh`: samples that any sensor read anew; gaps are listed.
std::vector<Span> find_spans(const std::vector<double>& time, const std::vector<char>& fresh, double longest,
                             std::vector<Gap>* gaps);

// Values on an even grid, smoothed by a Gaussian of deviation `sigma` [s].
std::vector<double> smooth_evenly(const std::vector<double>& raw, double step, double sigma);

// Which samples are looked at. The noise of even and of odd ones is independent: see least_squares.h.
enum class Half { kEven, kOdd, kAll };

// Even grid over a span; smooths by a Gaussian of deviation `sigma` [s], cut off at 4 deviations. 0: does not smooth.
class Resampler {
 public:
  Resampler(const std::vector<double>& time, Span span, double step, double sigma, Half half);

  size_t size() const { return grid_.size(); }
  const std::vector<double>& grid() const { return grid_; }  // [s]
  double step() const { return step_; }

  // Samples that are not finite, or not `fresh` (empty: all are), are bridged by a line.
  Track run(const std::vector<double>& values, const std::vector<char>& fresh = {}) const;
  // Root mean square, at each stamp, of what the kernel takes away: high where an impact was.
  std::vector<double> calc_roughness(const std::vector<double>& values, const Track& smooth) const;

 private:
  std::vector<double> interpolate_samples(const std::vector<double>& values, const std::vector<char>& fresh) const;

  const std::vector<double>& time_;
  Span span_;
  double step_ = 0;
  Half half_;
  std::vector<double> grid_, kernel_;
};

}  // namespace hrp::diagnosis::floating
