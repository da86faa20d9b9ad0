// SPDX-License-Identifier: BSD-3-Clause
// Which DDS domain a run uses. Each run on a machine claims a domain of its own, so that runs side by side do not see
// each other; a claim is a locked file, so the claim of a killed run is free again at once.
#pragma once

#include <string>
#include <vector>

namespace hrp {

// Domains that are handed out: ports stay below the range that the kernel gives to outgoing connections.
constexpr int kFirstDomain = 1;
constexpr int kLastDomain = 99;

// Holds a domain until destroyed, or until the process ends in whatever way. Processes that a holder starts do not
// inherit it.
class DomainClaim {
 public:
  DomainClaim() = default;
  DomainClaim(int domain, int file) : domain_(domain), file_(file) {}
  DomainClaim(DomainClaim&& other) noexcept;
  DomainClaim& operator=(DomainClaim&& other) noexcept;
  ~DomainClaim();
  int domain() const { return domain_; }

 private:
  int domain_ = -1;
  int file_ = -1;
};

struct RunningDomain {
  int domain = -1;
  long process_id = 0;    // of the holder
  std::string what;       // as given to claim_free_domain: the scenario, usually
};

// Claims a domain that nobody uses; `what` is shown to people who look for running sets. Throws BusError when none is
// free or the folder cannot be written.
DomainClaim claim_free_domain(const std::string& what);

// Claims one domain. Throws BusError when somebody holds it.
DomainClaim claim_domain(int domain, const std::string& what);

// All claimed domains, in order.
std::vector<RunningDomain> find_running_domains();

// The domain that a tool joins: `wanted`, or the only one that runs when `wanted` is negative. Throws BusError, with
// what there is, when none or several run.
int choose_running_domain(int wanted);

// The folder of the claims: $XDG_RUNTIME_DIR/openhrp-dds, else /tmp/openhrp-dds-<user>.
std::string find_domain_folder();

}  // namespace hrp
