// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search.h"

namespace hrp::diagnosis {

Outcome diagnose(const Problem& problem, const Progress& progress) { return search(problem, progress); }

}  // namespace hrp::diagnosis
