// SPDX-License-Identifier: BSD-3-Clause
// Results on a disk that may be full, and in folders that may not be written.
#pragma once

#include <cstddef>
#include <string>

namespace hrp {

// The whole text, or the file as it was: a program that is killed, or a full disk, leaves no half of it. Throws
// std::runtime_error with path and reason.
void write_file(const std::string& path, const std::string& text);

// Makes the folder, and tries whether a file of so many bytes can be written in it: before the work whose results go
// there. Throws InputError.
void prepare_folder(const std::string& folder, size_t bytes = 0);

// What was printed is on its way: false where standard output takes no more, as a file on a full disk. Then says so on
// standard error, for `program`.
bool finish_output(const char* program);

}  // namespace hrp
