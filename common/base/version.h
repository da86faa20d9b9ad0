// SPDX-License-Identifier: BSD-3-Clause
// What every program answers to --version.
#pragma once

#include <string>

namespace hrp {

// "hrp-log (openhrp-dds) 0.1.0"
std::string get_version_text(const std::string& program);

// For programs without a parser of options: prints `help` for --help or -h, the version for --version. True when it
// has.
bool answer_questions(int argc, char** argv, const std::string& program, const std::string& help);

}  // namespace hrp
