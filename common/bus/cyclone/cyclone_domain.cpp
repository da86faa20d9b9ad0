// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/cyclone/cyclone_domain.h"

#include <atomic>
#include <cstdio>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "common/bus/cyclone/cyclone_security.h"
#include "common/bus/cyclone/loopback_bind.h"
#include "common/bus/network_choice.h"
#include "common/bus/participants.h"

namespace hrp {
namespace {

// All of it is about one rule or one measured microsecond:
// - lo without multicast: nothing leaves the machine. Peers are then found by asking every port a participant may have.
// - messages up to 64 kB: one system call for nearly every sample.
// - watermarks off: a writer never waits for a reader, its KEEP_LAST depth bounds its memory.
// - short discovery period: a process that missed the first packet is found soon.
// - write batch: samples of a gathered topic share a packet; all other writers flush at once.
// - short linger: a writer that goes waits for nobody's acknowledgement for long, a hung reader's least of all.
const char kBuffers[] = R"(
    <SocketReceiveBufferSize max="4MB"/>
    <WriteBatch>true</WriteBatch>
    <Watermarks>
      <WhcHigh>1GB</WhcHigh><WhcHighInit>1GB</WhcHighInit><WhcLow>1GB</WhcLow><WhcAdaptive>false</WhcAdaptive>
    </Watermarks>)";

// Without multicast, among `peers`; `general`: what else the interface needs.
std::string find_unicast_config(const std::string& interface, const std::string& general, const std::string& peers,
                                const std::string& security) {
  return "<CycloneDDS><Domain>" + security + R"(
  <General>
    <Interfaces><NetworkInterface )" +
         interface + R"( multicast="false"/></Interfaces>
    <AllowMulticast>false</AllowMulticast>)" +
         general + R"(
  </General>
  <Discovery>
    <Peers>)" +
         peers + R"(</Peers>
    <ParticipantIndex>auto</ParticipantIndex>
    <MaxAutoParticipantIndex>)" +
         std::to_string(kMostParticipants - 1) + R"(</MaxAutoParticipantIndex>
    <SPDPInterval>200ms</SPDPInterval>
    <LeaseDuration>20s</LeaseDuration>
  </Discovery>
  <Internal>)" +
         kBuffers + R"(
    <WriterLingerDuration>100ms</WriterLingerDuration>
    <GenerateKeyhash>true</GenerateKeyhash>
    <NackDelay>1ms</NackDelay>
    <HeartbeatInterval min="2ms" minsched="5ms" max="8s">20ms</HeartbeatInterval>
  </Internal>
</Domain></CycloneDDS>)";
}

std::string find_loopback_config(const std::string& security) {
  return find_unicast_config("name=\"lo\"",
                             "<MaxMessageSize>65500B</MaxMessageSize><FragmentSize>65000B</FragmentSize>",
                             "<Peer Address=\"127.0.0.1\"/>", security);
}

std::string find_interface_config(const std::string& address, const std::string& security) {
  return "<CycloneDDS><Domain>" + security + R"(
  <General><Interfaces><NetworkInterface address=")" +
         address + R"("/></Interfaces></General>
  <Internal>)" +
         kBuffers + R"(
  </Internal>
</Domain></CycloneDDS>)";
}

// Other machines without multicast: discovery as on loopback, packets as large as the vendor thinks fit for a network.
std::string find_peers_config(const NetworkChoice& network, const std::string& security) {
  std::string peers;
  for (const std::string& peer : network.peers) peers += "<Peer Address=\"" + peer + "\"/>";
  return find_unicast_config("address=\"" + network.address + "\"", "", peers, security);
}

std::string find_config(const BusOptions& options) {
  if (!options.config_file.empty()) return "file://" + options.config_file;
  const std::string security =
      options.secure.empty() ? "" : find_cyclone_security(find_secure_files(options.secure, options.only_looks));
  const NetworkChoice network = split_network(options.network_interface);
  if (!network.peers.empty()) return find_peers_config(network, security);
  if (!options.network_interface.empty()) return find_interface_config(options.network_interface, security);
  return find_loopback_config(security);
}

// Cyclone DDS warns of every participant it hears before its own one is there, half of a millisecond after the domain,
// and greets them all the same when they speak again. Where the way to another machine is broken it warns of every
// packet, hundreds a second: once is enough. What it says else goes to standard error, as ever.
void drop_needless_warnings(void*, const dds_log_data_t* said) {
  static std::atomic<bool> is_broken{false};
  if (std::strstr(said->message, "Remote secure participant") != nullptr) return;
  if (std::strstr(said->message, "ddsi_udp_conn_write to") != nullptr && is_broken.exchange(true)) return;
  std::fputs(said->message, stderr);
}

}  // namespace

std::shared_ptr<CycloneDomain> CycloneDomain::find_or_make(const BusOptions& options) {
  static std::mutex mutex;
  static std::map<int, std::weak_ptr<CycloneDomain>> domains;
  std::lock_guard<std::mutex> lock(mutex);
  std::shared_ptr<CycloneDomain> domain = domains[options.domain].lock();
  if (!domain) {
    domain.reset(new CycloneDomain(options));
    domains[options.domain] = domain;
  }
  return domain;
}

CycloneDomain::CycloneDomain(const BusOptions& options) {
  std::optional<LoopbackBind> loopback;  // it makes its sockets here
  const NetworkChoice network = split_network(options.network_interface);
  if (options.config_file.empty() && options.network_interface.empty()) loopback.emplace();
  if (options.config_file.empty() && !network.peers.empty()) loopback.emplace(network.address);
  if (!options.secure.empty() || !network.peers.empty()) dds_set_log_sink(drop_needless_warnings, nullptr);
  entity_ = dds_create_domain(static_cast<dds_domainid_t>(options.domain), find_config(options).c_str());
  if (entity_ < 0) {
    throw BusError("Cyclone DDS cannot open domain " + std::to_string(options.domain) + ": " + dds_strretcode(entity_) +
                   " (its own words are on standard error)");
  }
}

CycloneDomain::~CycloneDomain() { dds_delete(entity_); }

}  // namespace hrp
