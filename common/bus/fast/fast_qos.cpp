// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/fast/fast_qos.h"

#include <algorithm>
#include <set>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>

#include "common/base/diagnostics.h"
#include "common/base/ros_definitions.h"
#include "common/bus/network_choice.h"
#include "common/bus/participants.h"
#include "common/bus/secure_folder.h"

namespace hrp {
namespace {

namespace dds = eprosima::fastdds::dds;
using eprosima::fastdds::rtps::UDPv4TransportDescriptor;
using eprosima::fastrtps::rtps::IPLocator;
using eprosima::fastrtps::rtps::Locator_t;

constexpr uint32_t kSocketBuffer = 4 * 1024 * 1024;  // bytes; the kernel grants what it allows
constexpr const char* kProfile = "openhrp_dds";

std::shared_ptr<UDPv4TransportDescriptor> make_udp(const std::string& address) {
  auto udp = std::make_shared<UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.push_back(address);
  udp->sendBufferSize = kSocketBuffer;
  udp->receiveBufferSize = kSocketBuffer;
  udp->maxMessageSize = 65500;  // nearly every sample in one system call
  udp->maxInitialPeersRange = kMostParticipants;
  return udp;
}

// Port 0: the ports of all participants that may be there.
Locator_t make_locator(const std::string& address) {
  Locator_t locator;
  locator.kind = LOCATOR_KIND_UDPv4;
  IPLocator::setIPv4(locator, address);
  locator.port = 0;
  return locator;
}

dds::DomainParticipantQos load_profile(const std::string& file) {
  auto* factory = dds::DomainParticipantFactory::get_instance();
  dds::DomainParticipantQos qos;
  if (factory->load_XML_profiles_file(file) != ReturnCode_t::RETCODE_OK ||
      factory->get_participant_qos_from_profile(kProfile, qos) != ReturnCode_t::RETCODE_OK) {
    refuse_input(file, std::string("not a Fast DDS XML file with a participant profile named ") + kProfile);
  }
  return qos;
}

eprosima::fastrtps::Duration_t find_milliseconds(int milliseconds) {
  return {milliseconds / 1000, static_cast<uint32_t>(milliseconds % 1000) * 1000000u};
}

// What both ends share.
template <typename Qos>
void set_common(const TopicSpec& topic, Qos* qos) {
  qos->durability().kind =
      topic.retention == Retention::kLatest ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  const std::string user_data = make_ros_user_data(topic.type_name);
  qos->user_data().assign(user_data.begin(), user_data.end());
  qos->data_sharing().off();
  qos->endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos->resource_limits().max_instances = 1;
  qos->resource_limits().allocated_samples = std::min(topic.depth, 16);
  qos->resource_limits().extra_samples = 1;
}

// Names of DDS Security 1.1, 9.3 to 9.5.
void add_security(const SecureFiles& files, dds::DomainParticipantQos* qos) {
  const auto add = [&](const std::string& name, const std::string& value) {
    qos->properties().properties().emplace_back("dds.sec." + name, value);
  };
  add("auth.plugin", "builtin.PKI-DH");
  add("auth.builtin.PKI-DH.identity_ca", "file://" + files.authority);
  add("auth.builtin.PKI-DH.identity_certificate", "file://" + files.certificate);
  add("auth.builtin.PKI-DH.private_key", "file://" + files.key);
  if (!files.revoked.empty()) add("auth.builtin.PKI-DH.identity_crl", "file://" + files.revoked);
  add("access.plugin", "builtin.Access-Permissions");
  add("access.builtin.Access-Permissions.permissions_ca", "file://" + files.authority);
  add("access.builtin.Access-Permissions.governance", "file://" + files.governance);
  add("access.builtin.Access-Permissions.permissions", "file://" + files.permissions);
  add("crypto.plugin", "builtin.AES-GCM-GMAC");
}

}  // namespace

dds::DomainParticipantQos make_participant_qos(const BusOptions& options) {
  if (!options.config_file.empty()) return load_profile(options.config_file);
  dds::DomainParticipantQos qos;
  qos.name("openhrp-dds");
  if (!options.secure.empty()) add_security(find_secure_files(options.secure, options.only_looks), &qos);
  const bool loopback = options.network_interface.empty();
  const NetworkChoice network = split_network(loopback ? "127.0.0.1,127.0.0.1" : options.network_interface);
  qos.transport().use_builtin_transports = false;  // no shared memory
  qos.transport().user_transports.push_back(make_udp(network.address));
  auto& builtin = qos.wire_protocol().builtin;
  // Killed processes are forgotten after the lease; the announcements repeat for those who missed the first ones.
  builtin.discovery_config.leaseDuration = {20, 0};
  builtin.discovery_config.leaseDuration_announcementperiod = find_milliseconds(300);
  builtin.discovery_config.initial_announcements.count = 10;
  builtin.discovery_config.initial_announcements.period = find_milliseconds(20);
  if (network.peers.empty()) return qos;
  // A unicast locator of our own switches the multicast ones off.
  builtin.metatrafficUnicastLocatorList.push_back(make_locator(network.address));
  for (const std::string& peer : std::set<std::string>(network.peers.begin(), network.peers.end())) {
    builtin.initialPeersList.push_back(make_locator(peer));
  }
  return qos;
}

dds::DataWriterQos make_fast_writer_qos(const TopicSpec& topic) {
  dds::DataWriterQos qos;
  set_common(topic, &qos);
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = {1, 0};  // for locks only: a full KEEP_LAST history drops its oldest
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = topic.depth;
  qos.resource_limits().max_samples = topic.depth;
  qos.resource_limits().max_samples_per_instance = topic.depth;
  qos.publish_mode().kind = dds::SYNCHRONOUS_PUBLISH_MODE;
  // A heartbeat with every sample costs an acknowledgement each: 61 us a round trip, 44 without. Instead heartbeats go
  // by time; on loopback a sample is lost only when a socket buffer overflows.
  auto& reliable = qos.reliable_writer_qos();
  reliable.disable_heartbeat_piggyback = true;
  reliable.times.initialHeartbeatDelay = find_milliseconds(2);
  reliable.times.heartbeatPeriod = find_milliseconds(20);
  reliable.times.nackResponseDelay = find_milliseconds(0);
  // How long a sample that was just sent is not sent again. With 0, the default, each sample wakes a thread that ends
  // this time at once: two more changes of thread for each reader.
  reliable.times.nackSupressionDuration = find_milliseconds(5);
  return qos;
}

dds::DataReaderQos make_fast_reader_qos(const TopicSpec& topic, Delivery delivery) {
  dds::DataReaderQos qos;
  set_common(topic, &qos);
  if (delivery == Delivery::kReliable) {
    qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    qos.history().kind = dds::KEEP_ALL_HISTORY_QOS;
    qos.resource_limits().max_samples = 0;  // unlimited: the listener takes them at once
    qos.resource_limits().max_samples_per_instance = 0;
  } else {
    qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = topic.depth;
    qos.resource_limits().max_samples = topic.depth;
    qos.resource_limits().max_samples_per_instance = topic.depth;
  }
  qos.reliable_reader_qos().times.initialAcknackDelay = find_milliseconds(1);
  qos.reliable_reader_qos().times.heartbeatResponseDelay = find_milliseconds(0);
  return qos;
}

}  // namespace hrp
