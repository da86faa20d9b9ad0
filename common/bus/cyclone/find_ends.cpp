// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/find_ends.h"

#include <cstring>
#include <thread>

#include "common/bus/cyclone/cyclone_domain.h"

namespace hrp {
namespace {

// An entity that is deleted with its children.
class Entity {
 public:
  explicit Entity(dds_entity_t entity) : entity_(entity) {
    if (entity_ < 0) throw BusError(std::string("Cyclone DDS cannot look into the domain: ") + dds_strretcode(entity_));
  }
  ~Entity() { dds_delete(entity_); }
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;
  dds_entity_t get() const { return entity_; }

 private:
  dds_entity_t entity_;
};

std::string find_vendor(const dds_guid_t& guid) {
  if (guid.v[0] & 0x80) return "secured";  // made from the certificate (DDS Security 1.1, table 52)
  if (guid.v[0] == 0x01 && guid.v[1] == 0x10) return "cyclone";
  if (guid.v[0] == 0x01 && guid.v[1] == 0x0f) return "fast";
  return "unknown";
}

std::string format_prefix(const dds_guid_t& guid) {
  static const char kDigits[] = "0123456789abcdef";
  std::string text;
  for (int i = 0; i < 12; ++i) {
    text += kDigits[guid.v[i] >> 4];
    text += kDigits[guid.v[i] & 15];
  }
  return text;
}

EndSeen describe(const dds_builtintopic_endpoint_t& end, bool writer) {
  EndSeen seen;
  seen.topic = end.topic_name;
  seen.type_name = end.type_name;
  seen.writer = writer;
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_duration_t blocking = 0;
  if (dds_qget_reliability(end.qos, &reliability, &blocking)) seen.reliable = reliability == DDS_RELIABILITY_RELIABLE;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  if (dds_qget_durability(end.qos, &durability)) seen.transient_local = durability != DDS_DURABILITY_VOLATILE;
  seen.vendor = find_vendor(end.participant_key);
  seen.participant = format_prefix(end.participant_key);
  return seen;
}

void add_ends(dds_entity_t participant, bool writers, const dds_guid_t& self, std::vector<EndSeen>* ends) {
  const Entity reader(dds_create_reader(
      participant, writers ? DDS_BUILTIN_TOPIC_DCPSPUBLICATION : DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr));
  constexpr size_t kMost = 1024;
  std::vector<void*> samples(kMost, nullptr);
  std::vector<dds_sample_info_t> infos(kMost);
  const dds_return_t count =
      dds_read_mask(reader.get(), samples.data(), infos.data(), kMost, kMost, DDS_ALIVE_INSTANCE_STATE);
  for (dds_return_t i = 0; i < count; ++i) {
    if (!infos[i].valid_data) continue;
    const auto& end = *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
    // Cyclone lists the readers of its built-in topics, all in this process, as well.
    if (std::memcmp(end.participant_key.v, self.v, 12) == 0 || std::strncmp(end.topic_name, "DCPS", 4) == 0) continue;
    ends->push_back(describe(end, writers));
  }
  if (count > 0) dds_return_loan(reader.get(), samples.data(), count);
}

}  // namespace

std::vector<EndSeen> find_ends(const BusOptions& options, std::chrono::milliseconds patience) {
  BusOptions looking = options;
  looking.vendor = "cyclone";
  if (options.vendor == "fast") looking.config_file.clear();  // in the format of the other vendor
  const auto domain = CycloneDomain::find_or_make(looking);
  const Entity participant(dds_create_participant(static_cast<dds_domainid_t>(looking.domain), nullptr, nullptr));
  std::this_thread::sleep_for(patience);
  dds_guid_t self{};
  dds_get_guid(participant.get(), &self);
  std::vector<EndSeen> ends;
  add_ends(participant.get(), true, self, &ends);
  add_ends(participant.get(), false, self, &ends);
  return ends;
}

}  // namespace hrp
