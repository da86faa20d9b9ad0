// SPDX-License-Identifier: BSD-3-Clause
// Local cubics over a sliding window: smooth trajectories of joints from noisy samples of position and velocity, series
// with missing samples, and many complete series with the same stamps.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// [s] after which the start of a simulation is judged no more: some periods of the slowest transmission. Of a short
// recording a tenth at most.
constexpr double kSettling = 0.6;

struct SmoothJoint {
  std::vector<double> q, qd, qdd;     // at every sample of the recording
  double sigma_qdd = 0.0;             // [rad/s^2] noise of qdd
  int half_window = 0;                // samples
};

struct SmoothRecording {
  size_t start = 0;   // first sample whose smoothed state rests on samples from both sides: rollouts begin here
  size_t judged = 0;  // first sample that predictions are compared at: what the start was uncertain by has died away
  std::vector<SmoothJoint> joints;
  std::vector<std::vector<double>> effort;     // smoothed alike; empty where none was recorded
};

// Samples that are missing (NaN) filled with the value before them, those at the begin with the first there is; 0 where
// there is none.
std::vector<double> fill_gaps(const std::vector<double>& values);

SmoothRecording smooth_recording(const Experiment& e, const Recording& recording);

// Value, first and second derivative of a series at every sample by local cubics over +- half_window samples.
void smooth_series(const std::vector<double>& time, const std::vector<double>& values, int half_window,
                   std::vector<double>* value, std::vector<double>* rate, std::vector<double>* second);

// A smoothed series at the recording's stamps, with its rate and second derivative.
struct SmoothSeries {
  std::vector<double> value, rate, second;
};

// Which samples a smoother looks at. Even and odd ones have independent noise: see standing/fit.h.
enum class Parity { kAll, kEven, kOdd };

// Of series without gaps the weights depend on the stamps alone and are found once.
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
