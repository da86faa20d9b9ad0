// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/doubts.h"

#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {

const char* find_doubt(const GradedTerm& term, const TermDoubts& doubts) {
  if (!term.helps_held) return "the held-out recordings are predicted worse with it";
  if (term.agreement < kMostly) return "stretches of the recordings give it opposite signs";
  if (!doubts.told) return "the recordings tell its size too poorly";
  if (!doubts.clear) return "parts of the recordings differ by as much as its size";
  if (doubts.of_sampling) return "a log that holds its values is late by up to a period, too";
  if (term.harms_one) return "one held-out recording is predicted worse with it";
  if (doubts.stated) return "the stated gains of the servo may be wrong instead";
  return doubts.confirmed ? "other sets of effects do nearly as well"
                          : "it takes away too little of the held-out mismatch";
}

}  // namespace hrp::diagnosis
