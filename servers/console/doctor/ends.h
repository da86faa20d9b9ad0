// SPDX-License-Identifier: BSD-3-Clause
// Faults that show in what discovery knows of readers and writers.
#pragma once

#include "common/bus/find_ends.h"
#include "servers/console/doctor/finding.h"

namespace hrp {

// Who is there: how many participants of which vendor. A problem when `expected` and nobody is.
Finding judge_participants(const std::vector<EndSeen>& ends, bool expected);
// A reader that asks for more than a writer of its topic offers gets nothing from it (DDS 2.2.3, request and offer).
// One that wants too little of a topic whose last sample is kept misses what was sent before it came.
Findings judge_qos(const std::vector<EndSeen>& ends);
// Ends of one topic with different types do not match; known topics have one type.
Findings judge_types(const std::vector<EndSeen>& ends);
// Topics of ours that somebody reads and nobody writes, or the other way round, are no problem, but names that differ
// from ours by little are.
Findings judge_names(const std::vector<EndSeen>& ends);

}  // namespace hrp
