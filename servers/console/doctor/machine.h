// SPDX-License-Identifier: BSD-3-Clause
// Faults of this machine and of this user's session.
#pragma once

#include <string>
#include <vector>

#include "common/bus/run_entry.h"
#include "servers/console/doctor/finding.h"

namespace hrp {

// Where runs are listed is a folder that only this user can enter.
Finding check_run_folder();
// The interface of `address` (empty: loopback) is there and up.
Finding check_interface(const std::string& address);
// Packets to the group of DDS discovery come back on the interface of `address` (empty: multicast is not used).
Finding check_multicast(const std::string& address);
// Each DDS, and the two together, bring messages back in a free domain of this machine.
Findings check_vendors();
// Places for participants that are taken in a domain, from /proc/net/udp.
Finding check_places(int domain);
// Files of Fast DDS in shared memory whose owner is gone: programs of one's own that use it may hang on them.
Finding check_shared_memory(const std::string& folder = "/dev/shm");
// Settings of the environment that lead programs elsewhere. `domain` < 0: none is known.
Findings check_environment(int domain);
// Clocks that jumped, or that nobody sets where machines must agree.
Finding check_clock(const std::vector<RunEntry>& runs, bool several_machines);
// Open files that a process may have.
Finding check_files();

}  // namespace hrp
