// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace hrp {

// While one lives, sockets that this thread binds to all interfaces are bound to one instead: loopback, or the one with
// this IPv4 address, whose multicast packets they then do not get. Cyclone DDS binds
// what it receives with to 0.0.0.0, whatever interface its configuration names: another interface of this machine, and
// with it other users' or machines' packets, would reach a run. It has no setting for it.
class LoopbackBind {
 public:
  explicit LoopbackBind(const std::string& address = "127.0.0.1");
  ~LoopbackBind();
  LoopbackBind(const LoopbackBind&) = delete;
  LoopbackBind& operator=(const LoopbackBind&) = delete;
};

}  // namespace hrp
