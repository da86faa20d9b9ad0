// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/fast/fast_bus.h"

#include <chrono>
#include <iterator>
#include <map>
#include <thread>
#include <utility>

#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>

#include "common/bus/callback_gate.h"
#include "common/bus/fast/fast_qos.h"
#include "common/bus/fast/forgotten_samples.h"
#include "common/bus/fast/raw_type.h"

namespace hrp {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

// A writer that goes waits for its readers to have everything, but not long for a hung one. As cyclone_domain.cpp says.
const eprosima::fastrtps::Duration_t kLinger{0, 100'000'000};

template <typename Pointer>
Pointer check_made(Pointer made, const char* what, const std::string& name) {
  if (made) return made;
  throw BusError(std::string("Fast DDS cannot make ") + what + " " + name);
}

// The ends that are there, ours and those that discovery found.
class EndList : public dds::DomainParticipantListener {
 public:
  void add(const rtps::GUID_t& guid, const std::string& topic, const std::string& type, bool writer) {
    std::lock_guard<std::mutex> lock(mutex_);
    ends_[guid] = {topic, type, writer};
  }

  void remove(const rtps::GUID_t& guid) {
    std::lock_guard<std::mutex> lock(mutex_);
    ends_.erase(guid);
  }

  std::vector<TopicSeen> find_topics() const {
    std::map<std::string, TopicSeen> topics;
    {
      std::lock_guard<std::mutex> lock(mutex_);
      for (const auto& [guid, end] : ends_) {
        TopicSeen& topic = topics[end.topic];
        topic.name = end.topic;
        topic.type_name = end.type;
        ++(end.writer ? topic.writers : topic.readers);
      }
    }
    std::vector<TopicSeen> seen;
    for (auto& [name, topic] : topics) seen.push_back(std::move(topic));
    return seen;
  }

  void on_publisher_discovery(dds::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) override {
    if (info.status == rtps::WriterDiscoveryInfo::REMOVED_WRITER) return remove(info.info.guid());
    add(info.info.guid(), info.info.topicName().to_string(), info.info.typeName().to_string(), true);
  }

  void on_subscriber_discovery(dds::DomainParticipant*, rtps::ReaderDiscoveryInfo&& info) override {
    if (info.status == rtps::ReaderDiscoveryInfo::REMOVED_READER) return remove(info.info.guid());
    add(info.info.guid(), info.info.topicName().to_string(), info.info.typeName().to_string(), false);
  }

 private:
  struct End {
    std::string topic;
    std::string type;
    bool writer = false;
  };
  mutable std::mutex mutex_;
  std::map<rtps::GUID_t, End> ends_;
};

class FastWriter : public Writer, dds::DataWriterListener {
 public:
  FastWriter(dds::Publisher* publisher, dds::Topic* topic, const TopicSpec& spec, EndList* ends)
      : publisher_(publisher), ends_(ends), name_(spec.name), is_stream_(spec.retention == Retention::kStream) {
    writer_ = check_made(
        publisher->create_datawriter(topic, make_fast_writer_qos(spec), this, dds::StatusMask::publication_matched()),
        "writer of", spec.name);
    ends_->add(writer_->guid(), spec.name, spec.type_name, true);
  }

  ~FastWriter() override {
    ends_->remove(writer_->guid());
    writer_->set_listener(nullptr);
    writer_->wait_for_acknowledgments(kLinger);
    // Fast DDS 2.9 empties the history of a writer it deletes without its lock: a heartbeat at that moment counts the
    // gaps up to a released sample for ever (its pull request 4076). An empty history has none.
    size_t removed = 0;
    writer_->clear_history(&removed);
    publisher_->delete_datawriter(writer_);
  }

  void write(Bytes sample) override {
    std::lock_guard<std::mutex> lock(mutex_);
    forgotten_.drop(writer_);
    if (!writer_->write(&sample)) throw BusError("Fast DDS cannot write to " + name_);
  }

  // The answer to `request`, which its client finds by this.
  void write_reply(Bytes sample, const rtps::SampleIdentity& request) {
    rtps::WriteParams parameters;
    parameters.related_sample_identity(request);
    std::lock_guard<std::mutex> lock(mutex_);
    forgotten_.drop(writer_);
    if (!writer_->write(&sample, parameters)) throw BusError("Fast DDS cannot write to " + name_);
  }

  bool has_readers() const override { return readers_ > 0; }

 private:
  void on_publication_matched(dds::DataWriter*, const dds::PublicationMatchedStatus& status) override {
    readers_ = status.current_count;
    if (is_stream_ && status.current_count_change > 0) forgotten_.on_match();
  }

  dds::Publisher* publisher_;
  EndList* ends_;
  std::string name_;
  bool is_stream_;
  dds::DataWriter* writer_ = nullptr;
  std::atomic<int> readers_{0};
  std::mutex mutex_;  // from the question whether all have everything to the end of a write
  ForgottenSamples forgotten_;
};

using InfoCallback = std::function<void(Bytes, const dds::SampleInfo&)>;

class FastReader : public Reader, dds::DataReaderListener {
 public:
  FastReader(dds::Subscriber* subscriber, dds::Topic* topic, const TopicSpec& spec, Delivery delivery,
             InfoCallback callback, std::recursive_mutex* mutex, EndList* ends)
      : subscriber_(subscriber), ends_(ends), gate_(mutex), callback_(std::move(callback)) {
    reader_ = check_made(subscriber->create_datareader(topic, make_fast_reader_qos(spec, delivery), this,
                                                       dds::StatusMask::data_available()),
                         "reader of", spec.name);
    ends_->add(reader_->guid(), spec.name, spec.type_name, false);
  }

  ~FastReader() override {
    gate_.close();
    ends_->remove(reader_->guid());
    reader_->set_listener(nullptr);
    subscriber_->delete_datareader(reader_);
  }

 private:
  void on_data_available(dds::DataReader* reader) override {
    const auto lock = gate_.enter();
    if (!lock.owns_lock()) return;
    while (reader->take_next_sample(&sample_, &info_) == ReturnCode_t::RETCODE_OK) {
      if (info_.valid_data) callback_({sample_.data(), sample_.size()}, info_);
    }
  }

  dds::Subscriber* subscriber_;
  EndList* ends_;
  CallbackGate gate_;
  InfoCallback callback_;
  std::vector<uint8_t> sample_;
  dds::SampleInfo info_;
  dds::DataReader* reader_ = nullptr;
};

class FastService : public Service {
 public:
  std::unique_ptr<FastWriter> replies;
  std::unique_ptr<Reader> requests;  // ends first: it writes replies
};

// rmw_fastrtps names the reader of its replies in the request; plain writers are named by themselves.
rtps::SampleIdentity find_identity(const dds::SampleInfo& info) {
  rtps::SampleIdentity identity = info.sample_identity;
  const rtps::GUID_t& reader = info.related_sample_identity.writer_guid();
  if (reader != rtps::GUID_t::unknown()) identity.writer_guid(reader);
  return identity;
}

// Within a process Fast DDS would call readers inside write(), on the writer's thread: callbacks would nest. With this
// off they come over the loopback like all others. Counts for participants made later, so it is said once, first.
void switch_off_intraprocess() {
  static const bool done = [] {
    eprosima::fastrtps::LibrarySettingsAttributes settings;
    settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
    eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
    return true;
  }();
  (void)done;
}

}  // namespace

struct FastBus::Impl {
  EndList ends;  // outlives the participant
  dds::DomainParticipant* participant = nullptr;
  dds::Publisher* publisher = nullptr;
  dds::Subscriber* subscriber = nullptr;
  std::mutex topics_mutex;
  std::map<std::string, dds::Topic*> topics;
  TopicTypes types;
  const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  size_t nudges = 0;  // done

  ~Impl() {
    if (!participant) return;
    participant->set_listener(nullptr);
    participant->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
  }

  void nudge_discovery();

  // Not the mutex of callbacks: Fast DDS holds locks of its own while a callback waits for that one.
  dds::Topic* find_or_make_topic(const TopicSpec& spec) {
    std::lock_guard<std::mutex> lock(topics_mutex);
    types.check(spec);
    dds::Topic*& topic = topics[spec.name];
    if (topic) return topic;
    dds::TypeSupport type(new RawType(spec.type_name));
    if (participant->find_type(spec.type_name).empty()) participant->register_type(type);
    topic =
        check_made(participant->create_topic(spec.name, spec.type_name, dds::TOPIC_QOS_DEFAULT), "topic", spec.name);
    return topic;
  }
};

// A Cyclone DDS participant that has not heard of this one drops the heartbeat of our discovery, and our answer to its
// own question waits for the next one, a whole second later (a constant of Fast DDS). Endpoints that are announced
// again bring a heartbeat with them: so they are, a few times while a run starts. The announced change is group data
// that nobody reads.
void FastBus::Impl::nudge_discovery() {
  constexpr std::chrono::milliseconds kTimes[] = {std::chrono::milliseconds(60), std::chrono::milliseconds(150),
                                                  std::chrono::milliseconds(300), std::chrono::milliseconds(500),
                                                  std::chrono::milliseconds(800)};
  if (nudges == std::size(kTimes) || std::chrono::steady_clock::now() - start < kTimes[nudges]) return;
  ++nudges;
  const std::vector<eprosima::fastrtps::rtps::octet> data{static_cast<uint8_t>(nudges)};
  dds::PublisherQos publishing = publisher->get_qos();
  publishing.group_data().data_vec(data);
  publisher->set_qos(publishing);
  dds::SubscriberQos subscribing = subscriber->get_qos();
  subscribing.group_data().data_vec(data);
  subscriber->set_qos(subscribing);
}

FastBus::FastBus(const BusOptions& options) : impl_(std::make_unique<Impl>()) {
  switch_off_intraprocess();
  auto* factory = dds::DomainParticipantFactory::get_instance();
  impl_->participant =
      check_made(factory->create_participant(static_cast<uint32_t>(options.domain), make_participant_qos(options),
                                             &impl_->ends, dds::StatusMask::none()),
                 "participant in domain", std::to_string(options.domain));
  impl_->publisher = check_made(impl_->participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT), "publisher", "");
  impl_->subscriber = check_made(impl_->participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT), "subscriber", "");
}

FastBus::~FastBus() = default;

std::unique_ptr<Writer> FastBus::make_writer(const TopicSpec& topic) {
  return std::make_unique<FastWriter>(impl_->publisher, impl_->find_or_make_topic(topic), topic, &impl_->ends);
}

std::unique_ptr<Reader> FastBus::make_reader(const TopicSpec& topic, Delivery delivery, SampleCallback callback) {
  return std::make_unique<FastReader>(
      impl_->subscriber, impl_->find_or_make_topic(topic), topic, delivery,
      [callback = std::move(callback)](Bytes sample, const dds::SampleInfo&) { callback(sample); }, &mutex(),
      &impl_->ends);
}

std::unique_ptr<Service> FastBus::make_service(const ServiceSpec& service, ServiceCallback callback) {
  const TopicSpec asked = find_request_topic(service), answered = find_reply_topic(service);
  auto made = std::make_unique<FastService>();
  made->replies =
      std::make_unique<FastWriter>(impl_->publisher, impl_->find_or_make_topic(answered), answered, &impl_->ends);
  const auto take = [callback = std::move(callback), replies = made->replies.get()](Bytes request,
                                                                                    const dds::SampleInfo& info) {
    const Bytes reply = callback(request);
    if (reply.size > 0) replies->write_reply(reply, find_identity(info));
  };
  made->requests = std::make_unique<FastReader>(impl_->subscriber, impl_->find_or_make_topic(asked), asked,
                                                Delivery::kReliable, take, &mutex(), &impl_->ends);
  return made;
}

std::vector<TopicSeen> FastBus::find_topics() { return impl_->ends.find_topics(); }

void FastBus::spin(std::chrono::milliseconds timeout) {
  impl_->nudge_discovery();
  std::this_thread::sleep_for(timeout);
}

}  // namespace hrp
