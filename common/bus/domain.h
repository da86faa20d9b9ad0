// SPDX-License-Identifier: BSD-3-Clause
// Which DDS domain a run uses, and which runs there are. Each run on a machine claims a domain of its own, so that runs
// side by side do not see each other. A claim is a locked file in a private folder of the user, so the claim of a
// killed run is free again at once; beside it stands what the run says of itself. Users have folders apart, but share
// the domains of a machine: a claim holds a name among its sockets, too (unix(7), abstract; each network namespace has
// its own).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/private_folder.h"
#include "common/bus/run_entry.h"

namespace hrp {

// Domains that are handed out: ports stay below the range that the kernel gives to outgoing connections.
constexpr int kFirstDomain = 1;
constexpr int kLastDomain = 99;
constexpr int kHighestDomain = 230;

// Holds a domain until destroyed, or until the process ends in whatever way. Processes that a holder starts do not
// inherit it.
class DomainClaim {
 public:
  DomainClaim() = default;
  DomainClaim(PrivateFolder folder, int domain, int file, int machine);
  DomainClaim(DomainClaim&& other) noexcept;
  DomainClaim& operator=(DomainClaim&& other) noexcept;
  ~DomainClaim();
  int domain() const { return domain_; }
  // Says more of the run, for those who look for it. Domain, process and start are filled in.
  void describe(RunEntry entry);
  const RunEntry& entry() const { return entry_; }

 private:
  std::optional<PrivateFolder> folder_;
  int domain_ = -1;
  int file_ = -1;
  int machine_ = -1;  // socket with the domain's name
  RunEntry entry_;
};

// Holds the place of a server in a run that left it free, until destroyed or until the process ends: two controllers in
// one place would end the run.
class PlaceClaim {
 public:
  PlaceClaim() = default;
  PlaceClaim(PrivateFolder folder, std::string name, int file);
  PlaceClaim(PlaceClaim&& other) noexcept;
  PlaceClaim& operator=(PlaceClaim&& other) noexcept;
  ~PlaceClaim();

 private:
  std::optional<PrivateFolder> folder_;
  std::string name_;
  int file_ = -1;
};

// Empty when somebody else holds it.
std::optional<PlaceClaim> claim_place(int domain, const std::string& role);

// Claims a domain that nobody uses, other users included; `what` is shown to people who look for running sets. Throws
// BusError when none is free or the folder cannot be used.
DomainClaim claim_free_domain(const std::string& what);

// Claims one domain. Throws BusError when somebody holds it.
DomainClaim claim_domain(int domain, const std::string& what);

// All runs of this user, by domain; `free_places` without those that somebody has taken. What dead ones left behind is
// removed.
std::vector<RunEntry> find_runs();
// The run of a domain; empty when nobody holds it.
std::optional<RunEntry> find_run_of_domain(int domain);

// Where the claims of this user may be; the first is where new ones go. $XDG_RUNTIME_DIR/openhrp-dds where that is
// safe, else /run/user/<user>/openhrp-dds; where there is none, /tmp/openhrp-dds-<user>, else ~/.openhrp-dds:
// somebody else may have made the one in /tmp.
std::vector<std::string> find_run_folders();

}  // namespace hrp
