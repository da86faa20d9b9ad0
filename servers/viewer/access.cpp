// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/access.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace hrp {
namespace {

// "localhost:8080" -> "localhost", "[::1]:80" -> "[::1]"
std::string strip_port(const std::string& host) {
  if (!host.empty() && host[0] == '[') return host.substr(0, host.find(']') + 1);
  return host.substr(0, host.find(':'));
}

// As long for a wrong guess as for a right one.
bool equals(const std::string& guess, const std::string& token) {
  unsigned difference = guess.size() == token.size() ? 0 : 1;
  for (size_t i = 0; i < token.size(); ++i) {
    difference |= static_cast<unsigned char>(token[i]) ^ static_cast<unsigned char>(i < guess.size() ? guess[i] : 0);
  }
  return difference == 0;
}

// "a=b; name=value; c=d" -> "value"
std::string find_cookie(const std::string& cookies, const std::string& name) {
  for (size_t at = 0; at < cookies.size();) {
    const size_t end = std::min(cookies.find(';', at), cookies.size());
    const std::string pair = cookies.substr(at, end - at);
    if (pair.rfind(name + "=", 0) == 0) return pair.substr(name.size() + 1);
    at = end + 1;
    while (at < cookies.size() && cookies[at] == ' ') ++at;
  }
  return "";
}

// Whole origins: a scheme of its own ("file://", that of an extension) or a subdomain is another origin.
bool is_own_origin(const AccessRequest& request) {
  return !request.host.empty() && request.origin == "http://" + request.host;
}

bool is_foxglove_origin(const std::string& origin) {
  return origin == "https://app.foxglove.dev" || origin == "https://studio.foxglove.dev";
}

}  // namespace

bool is_loopback_address(const std::string& address) {
  // Digits and dots alone: "127.0.0.1.example" is a name that somebody else owns.
  const bool numeric = address.find_first_not_of("0123456789.") == std::string::npos;
  return address == "::1" || (numeric && address.rfind("127.", 0) == 0);
}

std::string find_refusal(const AccessRules& rules, const AccessRequest& request) {
  const std::string host = strip_port(request.host);
  // A foreign name that resolves to this machine (DNS rebinding) makes a foreign page our own in the browser's eyes.
  if (rules.loopback && host != "localhost" && host != "[::1]" && !is_loopback_address(host)) {
    return "this viewer answers to localhost and 127.0.0.1 only, not to '" + host + "'";
  }
  const bool own = request.origin.empty() || is_own_origin(request);
  if (!own && !(request.foxglove && is_foxglove_origin(request.origin))) {
    return "pages of " + request.origin + " may not connect";
  }
  if (rules.token.empty()) return "";
  if (equals(find_query_value(request.target, "token"), rules.token) ||
      equals(find_cookie(request.cookie, make_cookie_name(rules)), rules.token)) {
    return "";
  }
  return "the token is missing or wrong: use the address that the viewer printed";
}

std::string make_cookie_name(const AccessRules& rules) { return "hrp_viewer_token_" + std::to_string(rules.port); }

std::string make_token() {
  unsigned char bytes[16];
  std::ifstream random("/dev/urandom", std::ios::binary);
  if (!random.read(reinterpret_cast<char*>(bytes), sizeof bytes))
    throw std::runtime_error("no random numbers for a token");
  std::string text;
  for (const unsigned char byte : bytes) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", byte);
    text += digits;
  }
  return text;
}

std::string decode_percent(const std::string& text) {
  std::string decoded;
  for (size_t i = 0; i < text.size(); ++i) {
    char* end = nullptr;
    const std::string digits = text[i] == '%' ? text.substr(i + 1, 2) : "";
    const long value = digits.size() == 2 ? std::strtol(digits.c_str(), &end, 16) : 0;
    if (end != nullptr && *end == '\0') {
      decoded += static_cast<char>(value);
      i += 2;
    } else {
      decoded += text[i];
    }
  }
  return decoded;
}

std::string find_query_value(const std::string& target, const std::string& key) {
  size_t at = target.find('?');
  while (at != std::string::npos && ++at < target.size()) {
    const size_t end = target.find('&', at);
    const std::string pair = target.substr(at, end == std::string::npos ? end : end - at);
    if (pair.rfind(key + "=", 0) == 0) return decode_percent(pair.substr(key.size() + 1));
    at = end;
  }
  return "";
}

}  // namespace hrp
