// SPDX-License-Identifier: BSD-3-Clause
// Says why a term is not supported where that is not because of its rivals.
#pragma once

#include "diagnosis/evidence/torque/grade.h"

namespace hrp::diagnosis {

struct TermDoubts {
  bool told = false;         // its value is three standard errors from neutral
  bool clear = false;        // also beside differences between parts of the recordings
  bool of_sampling = false;  // a delay within a period of the log
  bool stated = false;       // it rests on stated gains of the servo
  bool confirmed = false;    // it takes away enough of the held-out mismatch
};

// The first reason that a reader can check.
const char* find_doubt(const GradedTerm& term, const TermDoubts& doubts);

}  // namespace hrp::diagnosis
