// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/version.h"

#include <cstdio>

namespace hrp {

std::string get_version_text(const std::string& program) { return program + " (openhrp-dds) " HRP_VERSION; }

bool answer_questions(int argc, char** argv, const std::string& program, const std::string& help) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word != "--help" && word != "-h" && word != "--version") continue;
    std::printf("%s\n", word == "--version" ? get_version_text(program).c_str() : help.c_str());
    return true;
  }
  return false;
}

}  // namespace hrp
