// SPDX-License-Identifier: BSD-3-Clause
// Lines of a request: target, host, origin, cookie. Without the token nobody gets in.
#include <sstream>

#include "servers/viewer/access.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::istringstream lines(hrp::test::make_text(data, size));
  hrp::AccessRequest request;
  for (std::string* field : {&request.target, &request.host, &request.origin, &request.cookie})
    std::getline(lines, *field);
  hrp::AccessRules rules;
  rules.token = "0123456789abcdef0123456789abcdef";
  rules.port = 8080;
  const bool granted = hrp::find_refusal(rules, request).empty();
  const bool knows = hrp::find_query_value(request.target, "token") == rules.token ||
                     request.cookie.find(rules.token) != std::string::npos;
  if (granted && !knows) std::abort();
  hrp::decode_percent(request.target);
  return 0;
}
