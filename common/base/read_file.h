// SPDX-License-Identifier: BSD-3-Clause
// Input files on a disk that may fail. A stream takes an error of the disk for the end of the file, so that the first half of a
// motion or of a recording would be all of it.
#pragma once

#include <istream>
#include <string>

namespace hrp {

// All that is left of an open file. Throws InputError when the disk reports an error.
std::string read_rest(std::istream& file, const std::string& path);

// For loops over lines, when they are through. Throws InputError when the disk reported an error.
void check_end(const std::istream& file, const std::string& path);

}  // namespace hrp
