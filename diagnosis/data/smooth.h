// SPDX-License-Identifier: BSD-3-Clause
// Smooth trajectories of joints from noisy samples of position and velocity: local cubics.
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

}  // namespace hrp::diagnosis
