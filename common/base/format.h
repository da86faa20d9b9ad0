// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace hrp {

// As printf, into a text of any length.
std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

}  // namespace hrp
