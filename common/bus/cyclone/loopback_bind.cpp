// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/cyclone/loopback_bind.h"

#include <arpa/inet.h>
#include <dlfcn.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>

namespace {

thread_local int loopback_depth = 0;
thread_local in_addr narrow_address{};

using BindFunction = int (*)(int, const sockaddr*, socklen_t);

BindFunction find_system_bind() {
  static const auto function = reinterpret_cast<BindFunction>(dlsym(RTLD_NEXT, "bind"));
  return function;
}

}  // namespace

// Takes the place of the C library's bind() in programs that link this file; the linker exports it because libddsc
// needs one. Everybody else's calls go through as they are.
extern "C" int bind(int file, const sockaddr* address, socklen_t size) noexcept {
  const BindFunction system_bind = find_system_bind();
  if (!system_bind) {
    errno = ENOSYS;
    return -1;
  }
  sockaddr_in narrowed{};
  if (loopback_depth == 0 || size < sizeof narrowed || address->sa_family != AF_INET)
    return system_bind(file, address, size);
  std::memcpy(&narrowed, address, sizeof narrowed);
  if (narrowed.sin_addr.s_addr == htonl(INADDR_ANY)) narrowed.sin_addr = narrow_address;
  return system_bind(file, reinterpret_cast<const sockaddr*>(&narrowed), sizeof narrowed);
}

namespace hrp {

LoopbackBind::LoopbackBind(const std::string& address) {
  ++loopback_depth;
  if (inet_pton(AF_INET, address.c_str(), &narrow_address) != 1) narrow_address.s_addr = htonl(INADDR_LOOPBACK);
}

LoopbackBind::~LoopbackBind() { --loopback_depth; }

}  // namespace hrp
