// SPDX-License-Identifier: BSD-3-Clause
// Always-on checks of contracts between parts of this program. Input from people is not a contract: see diagnostics.h.
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace hrp {

// A broken contract: a fault of this program, never of its input.
class ContractError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] inline void fail_check(const char* file, int line, const char* condition, const std::string& detail) {
  std::ostringstream text;
  text << file << ":" << line << ": broken contract: " << condition;
  if (!detail.empty()) text << " (" << detail << ")";
  throw ContractError(text.str());
}

}  // namespace hrp

// HRP_CHECK(i < n, "i = " << i << ", n = " << n): throws ContractError with the values.
#define HRP_CHECK(condition, detail)                                           \
  do {                                                                         \
    if (!(condition)) {                                                        \
      std::ostringstream hrp_check_text;                                       \
      hrp_check_text << detail;                                                \
      ::hrp::fail_check(__FILE__, __LINE__, #condition, hrp_check_text.str()); \
    }                                                                          \
  } while (false)
