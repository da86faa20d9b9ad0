// SPDX-License-Identifier: BSD-3-Clause
// Who may connect. Pages of strangers in the same browser may not: their origin and the host they name give them away.
#pragma once

#include <cstdint>
#include <string>

namespace hrp {

struct AccessRules {
  std::string token;     // empty: none needed
  bool loopback = true;  // bound to this machine only
  uint16_t port = 0;     // that the viewer listens at: names its cookie, as all ports of a host share cookies
};

struct AccessRequest {
  std::string target;  // "/ws?token=..."
  std::string host;    // of the Host header
  std::string origin;  // empty: no browser
  std::string cookie;
  bool foxglove = false;
};

// Empty when access is granted, else the reason.
std::string find_refusal(const AccessRules& rules, const AccessRequest& request);

// "hrp_viewer_token_8080"
std::string make_cookie_name(const AccessRules& rules);

bool is_loopback_address(const std::string& address);
// 128 bits of the kernel's random numbers as text.
std::string make_token();

// "a%20b" -> "a b"
std::string decode_percent(const std::string& text);
// The value of a key in "/path?key=value&...", decoded; empty when it is not there.
std::string find_query_value(const std::string& target, const std::string& key);

}  // namespace hrp
