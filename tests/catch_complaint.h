// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/base/diagnostics.h"

namespace hrp {

// In which words `act` refuses; "" where it does not. Errors of other kinds pass.
template <class Error = InputError, class Act>
std::string catch_complaint(const Act& act) {
  try {
    act();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace hrp
