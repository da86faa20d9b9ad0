// SPDX-License-Identifier: BSD-3-Clause
// HTTP and WebSocket on one port, in one thread (Boost.Beast).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "servers/viewer/access.h"
#include "servers/viewer/connection.h"

namespace hrp {

struct WebOptions {
  std::string address = "127.0.0.1";
  uint16_t port = 0;  // 0: a free one
  AccessRules access;
};

class WebServer {
 public:
  // Throws std::runtime_error when the address or the port cannot be had.
  WebServer(const WebOptions& options, WebApplication& application);
  ~WebServer();
  uint16_t port() const;
  // Serves until `tick`, called every `period_ms`, returns false.
  void run(int period_ms, const std::function<bool()>& tick);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace hrp
