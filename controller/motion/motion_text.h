// SPDX-License-Identifier: BSD-3-Clause
// Numbers out of text, with complaints. Private to controller/motion.
#pragma once

#include <string>

namespace hrp {

// Reads a finite number at *at (leading blanks allowed) and moves *at behind it; false when there is none before `end`.
bool read_number(const char** at, const char* end, double* value);

// Text for a message: what stands at `at` up to a comma, bracket or the end.
std::string show_word(const char* at, const char* end);

}  // namespace hrp
