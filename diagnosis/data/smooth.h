// SPDX-License-Identifier: BSD-3-Clause
// Local cubics over a sliding window: smooth joint trajectories from noisy samples of position and velocity; series
// with missing samples; and many complete series with the same stamps.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// [s] Time after which a simulation no longer depends on its start state: some periods of the slowest transmission. At
// most a tenth of a short recording.
constexpr double kSettling = 0.6;

struct SmoothJoint {
  std::vector<double> q, qd, qdd;  // at every sample of the recording
  double sigma_qdd = 0.0;          // [rad/s^2] noise of qdd
  int half_window = 0;             // samples
};

struct SmoothRecording {
  size_t start = 0;   // first sample with a two-sided window; rollouts start here
  size_t judged = 0;  // first sample that is compared: errors of the start state have decayed
  std::vector<SmoothJoint> joints;
  std::vector<std::vector<double>> effort;  // smoothed alike; empty if not recorded
};

// Replaces missing samples (NaN) by the previous value, at the start by the first value; 0 if there is none.
std::vector<double> fill_gaps(const std::vector<double>& values);

SmoothRecording smooth_recording(const Experiment& e, const Recording& recording);

// Value and first two derivatives of a series at every sample, by local cubics over +- half_window samples.
void smooth_series(const std::vector<double>& time, const std::vector<double>& values, int half_window,
                   std::vector<double>* value, std::vector<double>* rate, std::vector<double>* second);

// A smoothed series at the recording's stamps, with its rate and second derivative.
struct SmoothSeries {
  std::vector<double> value, rate, second;
};

// Samples that a smoother uses. Even and odd samples have independent noise (standing/fit.h).
enum class Parity { kAll, kEven, kOdd };

// Smoother for series without gaps. The weights depend only on the stamps and are computed once.
class Smoother {
 public:
  Smoother(const std::vector<double>& time, int half, Parity parity);
  SmoothSeries run(const std::vector<double>& values) const;
  int half() const { return half_; }

 private:
  struct Kernel {
    std::size_t begin = 0;
    std::vector<double> value, rate, second;  // weights of the samples from `begin` on
  };
  std::vector<Kernel> kernels_;
  int half_ = 3;
};

}  // namespace hrp::diagnosis
