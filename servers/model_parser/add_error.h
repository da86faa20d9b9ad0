// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/base/diagnostics.h"

namespace hrp {

// What is wrong at a line of a robot's or a world's file; line 0: unknown.
void add_error(const std::string& file, int line, const std::string& field, const std::string& message,
               Diagnostics* diagnostics);

}  // namespace hrp
