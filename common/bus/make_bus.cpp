// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/make_bus.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netinet/in.h>

#include <fstream>

#include "common/base/diagnostics.h"
#include "common/bus/cyclone/cyclone_bus.h"
#include "common/bus/fast/fast_bus.h"
#include "common/bus/memory/memory_bus.h"
#include "common/bus/network_choice.h"
#include "common/bus/secure_folder.h"

namespace hrp {
namespace {

// IPv4 addresses of this machine's interfaces.
std::vector<std::string> find_addresses() {
  std::vector<std::string> addresses;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return addresses;
  for (const ifaddrs* entry = list; entry; entry = entry->ifa_next) {
    if (!entry->ifa_addr || entry->ifa_addr->sa_family != AF_INET) continue;
    char text[INET_ADDRSTRLEN] = "";
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(entry->ifa_addr)->sin_addr, text, sizeof text);
    addresses.emplace_back(text);
  }
  freeifaddrs(list);
  return addresses;
}

void check_peer(const std::string& address) {
  in_addr number{};
  if (inet_pton(AF_INET, address.c_str(), &number) == 1) return;
  refuse_input({"", "network-interface"},
               "'" + address + "' is no IPv4 address of a machine: expected ADDRESS or ADDRESS,PEER,...");
}

void check_interface(const std::string& address) {
  const std::vector<std::string> addresses = find_addresses();
  std::string known;
  for (const std::string& here : addresses) {
    if (here == address) return;
    known += " " + here;
  }
  refuse_input({"", "network-interface"}, "'" + address + "' is no IPv4 address of this machine; it has" + known);
}

void check_options(const BusOptions& options) {
  // Ports are 7400 + 250 domain + ..., and end at 65535.
  if (options.domain < 0 || options.domain > 230) {
    refuse_input({"", "domain"}, std::to_string(options.domain) + " is no DDS domain: expected 0 to 230");
  }
  if (!options.config_file.empty() && !std::ifstream(options.config_file)) {
    refuse_input(options.config_file, "cannot read this DDS configuration file");
  }
  const NetworkChoice network = split_network(options.network_interface);
  for (const std::string& peer : network.peers) check_peer(peer);
  if (!options.network_interface.empty()) check_interface(network.address);
  if (options.secure.empty()) return;
  if (!options.config_file.empty())
    refuse_input({"", "secure"}, "excludes dds-config: that file has the settings of DDS Security, too");
  find_secure_files(options.secure, options.only_looks);
}

}  // namespace

std::vector<std::string> find_bus_vendors() { return {"cyclone", "fast", "memory"}; }

std::unique_ptr<Bus> make_bus(const BusOptions& options) {
  check_options(options);
  if (options.vendor == "cyclone") return std::make_unique<CycloneBus>(options);
  if (options.vendor == "fast") return std::make_unique<FastBus>(options);
  if (options.vendor == "memory") return std::make_unique<MemoryBus>();
  const std::string nearest = find_nearest(options.vendor, find_bus_vendors());
  refuse_input({"", "dds"}, "'" + options.vendor + "' is no bus: expected cyclone, fast or memory" +
                                (nearest.empty() ? "" : "; did you mean " + nearest + "?"));
}

}  // namespace hrp
