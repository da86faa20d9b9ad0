// SPDX-License-Identifier: BSD-3-Clause
// Long recordings in part: averaged to fewer samples where they come fast, and cut to the stretches that tell most.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// What all recordings of an experiment may hold in memory [numbers]: 130 MB, and about ten times that for
// all that a diagnosis makes of them (measured: 1.7 GB at 24e6).
constexpr double kMostNumbers = 16e6;
// [Hz] below which samples are not averaged any further: five times what drives follow on purpose, and some.
constexpr double kLeastRate = 125.0;

// How many samples in a row make one, for recordings of `numbers` numbers at `rate` [Hz] altogether.
size_t find_averaging(double numbers, double rate);

// Groups of `count` samples as their means; groups end at gaps.
void average_rows(size_t count, Table* table);

// Rows from `begin` to before `end`; its name says the seconds.
Recording cut_recording(const Recording& recording, size_t begin, size_t end);

// The recording in parts where its clock has a gap: nobody knows what was commanded there, and a prediction from the state
// before it fails behind it. Shorter parts than a second are left out; the whole one where no other is left.
std::vector<Recording> cut_at_gaps(const Recording& recording, std::vector<std::string>* warnings);

// The recording cut to about `seconds`: those 10 s pieces in which the joints move most, each against its own fastest.
// Neighbours stay together. The whole one when it is not longer.
std::vector<Recording> cut_to_stretches(const Recording& recording, double seconds);

// The experiment with at most `joint_seconds` (joints times seconds) of recordings, a third of them held out; noise and
// warnings as of the whole. For what is simulated many times.
Experiment make_screened(const Experiment& experiment, double joint_seconds);

double calc_joint_seconds(const Experiment& experiment);

}  // namespace hrp::diagnosis
