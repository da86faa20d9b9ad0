// SPDX-License-Identifier: BSD-3-Clause
// Reduces long recordings: averages fast samples, and selects the stretches with most motion.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Largest number of values of all recordings in memory: 130 MB. A diagnosis needs about ten times that (measured: 1.7
// GB at 24e6).
constexpr double kMostNumbers = 16e6;
// [Hz] Averaging does not go below this rate: well above five times what drives follow on purpose.
constexpr double kLeastRate = 125.0;

// Number of samples to average, for recordings with `numbers` values in total at `rate` [Hz].
size_t find_averaging(double numbers, double rate);

// Replaces groups of `count` samples by their means; gaps end a group.
void average_rows(size_t count, Table* table);

// Rows [begin, end) as a recording; its name contains the seconds.
Recording cut_recording(const Recording& recording, size_t begin, size_t end);

// Parts of a recording between gaps of its clock: nobody knows what was commanded in a gap, so a prediction across it
// fails. Leaves out parts shorter than 1 s. Returns the whole recording if no other part is left.
std::vector<Recording> cut_at_gaps(const Recording& recording, std::vector<std::string>* warnings);

// Selects about `seconds` of a recording: pieces of 10 s in which the joints move most, each relative to its own
// fastest piece. Adjacent pieces stay together. Returns the whole recording if it is not longer.
std::vector<Recording> cut_to_stretches(const Recording& recording, double seconds);

// Experiment with recordings of at most `joint_seconds` (joints times seconds), a third of them held out; noise and
// warnings of the whole one. For models that are simulated many times.
Experiment make_screened(const Experiment& experiment, double joint_seconds);
// The same of the recordings with these indices.
Experiment make_screened(const Experiment& experiment, double joint_seconds, const std::vector<int>& recordings);

// Joints times seconds that a search works with; longer recordings are cut to that by make_screened(). Infinite for
// robots whose recordings are not cut.
double calc_searched(const Experiment& experiment);

// Joints times seconds of all recordings.
double calc_joint_seconds(const Experiment& experiment);
// Joints times samples of all recordings.
double calc_joint_samples(const Experiment& experiment);

}  // namespace hrp::diagnosis
