// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace hrp::diagnosis {

// What recordings count otherwise than the model, as it was taken out of them, and what could not be looked for.
struct ConventionRemarks {
  std::vector<std::string> found, not_looked_for;
};

}  // namespace hrp::diagnosis
