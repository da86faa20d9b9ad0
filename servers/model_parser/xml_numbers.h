// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace hrp {

// `count` finite numbers with blanks between them; empty when the text is anything else.
std::vector<double> parse_numbers(const char* text, size_t count);

}  // namespace hrp
