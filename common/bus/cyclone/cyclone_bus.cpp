// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/cyclone/cyclone_bus.h"

#include <map>
#include <thread>
#include <utility>

#include "common/base/ros_definitions.h"
#include "common/bus/callback_gate.h"
#include "common/bus/cyclone/cyclone_domain.h"
#include "common/bus/cyclone/deferred_delivery.h"
#include "common/bus/cyclone/raw_sertype.h"

namespace hrp {
namespace {

dds_entity_t check_entity(dds_entity_t entity, const char* what, const std::string& name) {
  if (entity >= 0) return entity;
  throw BusError(std::string("Cyclone DDS cannot make ") + what + " " + name + ": " + dds_strretcode(entity));
}

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

Qos make_qos(const TopicSpec& topic) {
  Qos qos(dds_create_qos());
  const bool latest = topic.retention == Retention::kLatest;
  dds_qset_durability(qos.get(), latest ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  const std::string user_data = make_ros_user_data(topic.type_name);
  if (!user_data.empty()) dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  dds_qset_writer_data_lifecycle(qos.get(), false);  // a writer that goes says nothing about its samples
  return qos;
}

Qos make_writer_qos(const TopicSpec& topic) {
  Qos qos = make_qos(topic);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, 0);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, topic.depth);
  dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, topic.depth, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  return qos;
}

// Samples leave the reader's history at once, in the listener, so a reliable reader may keep all: what a stalled
// callback does not take stays in the socket and with the writer.
Qos make_reader_qos(const TopicSpec& topic, Delivery delivery) {
  Qos qos = make_qos(topic);
  if (delivery == Delivery::kReliable) {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, 0);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, DDS_LENGTH_UNLIMITED);
  } else {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, topic.depth);
  }
  return qos;
}

// Makes the topic with our raw type; `type` is the one to make samples with (Cyclone keeps one of equal types).
dds_entity_t make_topic(dds_entity_t participant, const TopicSpec& spec, const ddsi_sertype** type) {
  ddsi_sertype* raw = make_raw_sertype(spec.type_name.c_str());
  const dds_entity_t topic = dds_create_topic_sertype(participant, spec.name.c_str(), &raw, nullptr, nullptr, nullptr);
  if (topic < 0) ddsi_sertype_unref(raw);
  *type = raw;
  return check_entity(topic, "topic", spec.name);
}

// How many writers of this bus a topic has.
struct TopicUse {
  std::atomic<int> writers{0};
};

class CycloneWriter : public Writer {
 public:
  CycloneWriter(dds_entity_t participant, const TopicSpec& spec, TopicUse* use)
      : name_(spec.name), gathered_(spec.gathered), use_(use) {
    topic_ = make_topic(participant, spec, &type_);
    writer_ = check_entity(dds_create_writer(participant, topic_, make_writer_qos(spec).get(), nullptr), "writer of",
                           spec.name);
    ++use_->writers;
  }

  ~CycloneWriter() override {
    --use_->writers;
    dds_delete(writer_);
    dds_delete(topic_);
  }

  void write(Bytes sample) override {
    ddsi_serdata* raw = make_raw_sample(type_, sample);
    raw->statusinfo = 0;
    raw->timestamp.v = dds_time();
    WritingScope writing;
    const dds_return_t result = dds_writecdr(writer_, raw);
    if (result != DDS_RETCODE_OK && result != DDS_RETCODE_TIMEOUT) {
      throw BusError("Cyclone DDS cannot write to " + name_ + ": " + dds_strretcode(result));
    }
    if (!gathered_) flush();
  }

  // Samples wait in the writer's packet (WriteBatch in cyclone_domain.cpp), and go by themselves when it is full.
  void flush() override { dds_write_flush(writer_); }

  bool has_readers() const override {
    dds_publication_matched_status_t status;
    return dds_get_publication_matched_status(writer_, &status) == DDS_RETCODE_OK && status.current_count > 0;
  }

 private:
  std::string name_;
  bool gathered_;
  TopicUse* use_;
  const ddsi_sertype* type_ = nullptr;
  dds_entity_t topic_ = 0;
  dds_entity_t writer_ = 0;
};

// What a reader needs of its bus.
struct ReaderSite {
  dds_entity_t participant;
  std::recursive_mutex* mutex;
  DeferredDelivery* deferred;
  TopicUse* use;
};

class CycloneReader : public Reader, public DeferredReader {
 public:
  CycloneReader(const ReaderSite& site, const TopicSpec& spec, Delivery delivery, SampleCallback callback)
      : gate_(site.mutex), callback_(std::move(callback)), deferred_(site.deferred), use_(site.use) {
    const dds_entity_t participant = site.participant;
    const ddsi_sertype* type = nullptr;
    topic_ = make_topic(participant, spec, &type);
    dds_listener_t* listener = dds_create_listener(this);
    dds_lset_data_available(listener, on_data);
    reader_ = dds_create_reader(participant, topic_, make_reader_qos(spec, delivery).get(), listener);
    dds_delete_listener(listener);
    check_entity(reader_, "reader of", spec.name);
    ready_ = true;
    deferred_->add(this);  // retained samples of writers in this process came while reader_ was not set yet
  }

  ~CycloneReader() override {
    gate_.close();
    deferred_->forget(this);
    dds_set_listener(reader_, nullptr);  // waits for a running callback, which the gate turns back
    dds_delete(reader_);
    dds_delete(topic_);
  }

  void deliver() override {
    constexpr uint32_t kBatch = 32;
    ddsi_serdata* samples[kBatch];
    dds_sample_info_t infos[kBatch];
    // Taking and calling are one step under the mutex: two threads that deliver keep the order.
    const auto lock = gate_.enter();
    while (lock.owns_lock()) {
      const dds_return_t count = dds_takecdr(reader_, samples, kBatch, infos, DDS_ANY_STATE);
      for (dds_return_t i = 0; i < count; ++i) {
        if (infos[i].valid_data) callback_(get_raw_bytes(samples[i]));
        ddsi_serdata_unref(samples[i]);
      }
      if (count < static_cast<dds_return_t>(kBatch)) return;
    }
  }

 private:
  static void on_data(dds_entity_t, void* argument) {
    auto* self = static_cast<CycloneReader*>(argument);
    if (!self->ready_) return;
    // Samples of this process arrive inside somebody's write(): calling back there would nest callbacks. And a callback
    // in this listener that writes to its own topic would wait for the end of the listener, that is for itself.
    if (WritingScope::is_active() || self->use_->writers > 0) {
      self->deferred_->add(self);
    } else {
      self->deliver();
    }
  }

  CallbackGate gate_;
  SampleCallback callback_;
  DeferredDelivery* deferred_;
  TopicUse* use_;
  std::atomic<bool> ready_{false};
  dds_entity_t topic_ = 0;
  dds_entity_t reader_ = 0;
};

}  // namespace

struct CycloneBus::Impl {
  std::shared_ptr<CycloneDomain> domain;
  dds_entity_t participant = 0;
  dds_entity_t publications = 0;  // built-in readers: what discovery knows
  dds_entity_t subscriptions = 0;
  TopicTypes types;
  std::map<std::string, TopicUse> uses;
  DeferredDelivery deferred;
};

CycloneBus::CycloneBus(const BusOptions& options) : impl_(std::make_unique<Impl>()) {
  impl_->domain = CycloneDomain::find_or_make(options);
  impl_->participant =
      check_entity(dds_create_participant(static_cast<dds_domainid_t>(options.domain), nullptr, nullptr),
                   "participant in domain", std::to_string(options.domain));
  impl_->publications =
      check_entity(dds_create_reader(impl_->participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
                   "reader of", "publications");
  impl_->subscriptions =
      check_entity(dds_create_reader(impl_->participant, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr),
                   "reader of", "subscriptions");
}

CycloneBus::~CycloneBus() {
  if (impl_->participant > 0) dds_delete(impl_->participant);
}

std::unique_ptr<Writer> CycloneBus::make_writer(const TopicSpec& topic) {
  std::lock_guard<std::recursive_mutex> lock(mutex());
  impl_->types.check(topic);
  return std::make_unique<CycloneWriter>(impl_->participant, topic, &impl_->uses[topic.name]);
}

std::unique_ptr<Reader> CycloneBus::make_reader(const TopicSpec& topic, Delivery delivery, SampleCallback callback) {
  std::lock_guard<std::recursive_mutex> lock(mutex());
  impl_->types.check(topic);
  const ReaderSite site{impl_->participant, &mutex(), &impl_->deferred, &impl_->uses[topic.name]};
  return std::make_unique<CycloneReader>(site, topic, delivery, std::move(callback));
}

namespace {

// Counts the ends that a built-in reader knows, by topic name.
void count_ends(dds_entity_t reader, int TopicSeen::*counter, std::map<std::string, TopicSeen>* topics) {
  constexpr size_t kMost = 1024;
  std::vector<void*> samples(kMost, nullptr);
  std::vector<dds_sample_info_t> infos(kMost);
  const dds_return_t count =
      dds_read_mask(reader, samples.data(), infos.data(), kMost, kMost, DDS_ALIVE_INSTANCE_STATE);
  for (dds_return_t i = 0; i < count; ++i) {
    if (!infos[i].valid_data) continue;
    const auto* end = static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
    TopicSeen& topic = (*topics)[end->topic_name];
    topic.name = end->topic_name;
    topic.type_name = end->type_name;
    ++(topic.*counter);
  }
  if (count > 0) dds_return_loan(reader, samples.data(), count);
}

}  // namespace

std::vector<TopicSeen> CycloneBus::find_topics() {
  std::map<std::string, TopicSeen> topics;
  count_ends(impl_->publications, &TopicSeen::writers, &topics);
  count_ends(impl_->subscriptions, &TopicSeen::readers, &topics);
  std::vector<TopicSeen> seen;
  for (auto& [name, topic] : topics) {
    if (name.rfind("DCPS", 0) != 0) seen.push_back(std::move(topic));  // Cyclone's built-in topics: our own two readers
  }
  return seen;
}

void CycloneBus::spin(std::chrono::milliseconds timeout) { std::this_thread::sleep_for(timeout); }

}  // namespace hrp
