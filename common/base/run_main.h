// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>

#include "common/base/diagnostics.h"

namespace hrp {

// The work of a program: its own exit status, 2 after bad input, and 1 after any other exception, both said on standard
// error.
template <typename Work>
int run_main(const char* program, Work work) {
  try {
    return work();
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program, error.what());
    return 1;
  }
}

}  // namespace hrp
