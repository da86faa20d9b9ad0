// SPDX-License-Identifier: BSD-3-Clause
// Makes a bus by name. The only header of the DDS buses that the rest of the tree needs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/bus/bus.h"

namespace hrp {

struct BusOptions {
  std::string vendor = "cyclone";  // "cyclone", "fast" or "memory"
  int domain = 0;                  // DDS domain, 0..230; each run has its own (domain.h)
  // Empty: loopback, and nothing leaves the machine. Else the IPv4 address of the interface to use, and where multicast
  // must not be used, those of all machines behind it: "ADDRESS,PEER,..." (network_choice.h).
  std::string network_interface;
  // A file in the vendor's own format that replaces all of our settings of the network: other hosts, DDS Security.
  // Cyclone: the XML of CYCLONEDDS_URI. Fast: XML profiles with a participant profile named "openhrp_dds".
  std::string config_file;
  // DDS Security: the folder of an identity, see secure_folder.h. Empty: everybody on the network may join.
  std::string secure;
  bool only_looks = false;  // of the identities in `secure`, the one that may only look will do
};

std::vector<std::string> find_bus_vendors();

// Throws InputError for a vendor, domain or file that cannot be used.
std::unique_ptr<Bus> make_bus(const BusOptions& options);

}  // namespace hrp
