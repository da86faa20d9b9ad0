// SPDX-License-Identifier: BSD-3-Clause
// Input files on a disk that may fail. A stream takes an error of the disk for the end of the file, so that the first
// half of a motion or of a recording would be all of it.
#pragma once

#include <fstream>
#include <string>

namespace hrp {

// Throws InputError where there is no such file, or no permission.
std::ifstream open_input(const std::string& path);

// All of a file that people hand over as a robot, a world or a scenario. Throws InputError for what is no file, and
// beyond 64 MB: parsers of XML recurse and copy.
std::string read_input(const std::string& path);

// All that is left of an open file. Throws InputError when the disk reports an error.
std::string read_rest(std::istream& file, const std::string& path);

// For loops over lines, when they are through. Throws InputError when the disk reported an error.
void check_end(const std::istream& file, const std::string& path);

}  // namespace hrp
