// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/fast/forgotten_samples.h"

#include <chrono>
#include <functional>
#include <thread>
#include <vector>

#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <gtest/gtest.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>

#include "common/bus/domain.h"
#include "common/bus/fast/fast_qos.h"
#include "common/bus/fast/raw_type.h"
#include "common/bus/make_bus.h"

namespace hrp {
namespace {

namespace dds = eprosima::fastdds::dds;
using std::chrono::milliseconds;

// A stream and its readers, each in a participant of its own, as servers have them.
class StreamTest : public ::testing::Test, dds::DataWriterListener {
 protected:
  // Over the loopback, as between processes.
  StreamTest() {
    eprosima::fastrtps::LibrarySettingsAttributes settings;
    settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
    eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
  }

  ~StreamTest() override {
    for (dds::DomainParticipant* participant : participants_) {
      participant->delete_contained_entities();
      dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
    }
  }

  dds::DomainParticipant* make_participant() {
    BusOptions options;
    options.domain = claim_.domain();
    participants_.push_back(dds::DomainParticipantFactory::get_instance()->create_participant(
        static_cast<uint32_t>(options.domain), make_participant_qos(options)));
    return participants_.back();
  }

  dds::Topic* make_topic(dds::DomainParticipant* participant) {
    dds::TypeSupport(new RawType(topic_.type_name)).register_type(participant);
    return participant->create_topic(topic_.name, topic_.type_name, dds::TOPIC_QOS_DEFAULT);
  }

  // Asks for acknowledgements this long after a write, and again.
  void make_writer(milliseconds period) {
    dds::DataWriterQos qos = make_fast_writer_qos(topic_);
    qos.reliable_writer_qos().times.heartbeatPeriod = find_duration(period);
    dds::DomainParticipant* participant = make_participant();
    writer_ = participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT)
                  ->create_datawriter(make_topic(participant), qos, this, dds::StatusMask::publication_matched());
  }

  // Acknowledges this long after it is asked.
  void add_reader(dds::DomainParticipant* participant, milliseconds delay) {
    dds::DataReaderQos qos = make_fast_reader_qos(topic_, Delivery::kReliable);
    qos.reliable_reader_qos().times.heartbeatResponseDelay = find_duration(delay);
    participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT)->create_datareader(make_topic(participant), qos);
  }

  static eprosima::fastrtps::Duration_t find_duration(milliseconds time) {
    return {static_cast<int32_t>(time.count() / 1000), static_cast<uint32_t>(time.count() % 1000) * 1000000u};
  }

  void write() {
    dropped_ += forgotten_.drop(writer_);
    Bytes sample{bytes_.data(), bytes_.size()};
    ASSERT_TRUE(writer_->write(&sample));
  }

  static bool wait_until(const std::function<bool()>& done) {
    for (int i = 0; i < 3000 && !done(); ++i) std::this_thread::sleep_for(milliseconds(10));
    return done();
  }

  bool have_all() { return writer_->wait_for_acknowledgments({5, 0}) == ReturnCode_t::RETCODE_OK; }

  void on_publication_matched(dds::DataWriter*, const dds::PublicationMatchedStatus& status) override {
    readers_ = status.current_count;
    if (status.current_count_change > 0) forgotten_.on_match();
  }

  const TopicSpec topic_{"hrp/forgotten", "hrp::msg::Forgotten"};
  DomainClaim claim_;
  std::vector<dds::DomainParticipant*> participants_;
  dds::DataWriter* writer_ = nullptr;
  std::atomic<int> readers_{0};
  ForgottenSamples forgotten_;
  size_t dropped_ = 0;
  std::vector<uint8_t> bytes_ = std::vector<uint8_t>(8, 1);
};

// The first reader acknowledges a sample 500 ms after the write. The second one is matched before, and acknowledges
// later: 450 ms after its match.
TEST_F(StreamTest, ASampleIsNotKeptForEverBecauseAReaderCameBeforeItWasAcknowledged) {
  make_writer(milliseconds(500));
  add_reader(make_participant(), milliseconds(0));
  ASSERT_TRUE(wait_until([&] { return readers_ == 1; }));
  dds::DomainParticipant* late = make_participant();
  std::this_thread::sleep_for(milliseconds(600));  // the participants know each other
  write();
  std::this_thread::sleep_for(milliseconds(150));
  add_reader(late, milliseconds(450));
  ASSERT_TRUE(wait_until([&] { return readers_ == 2; }));
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(have_all());
    write();
  }
  ASSERT_TRUE(have_all());
  size_t kept = 0;
  writer_->clear_history(&kept);
  EXPECT_EQ(kept, 0u) << dropped_ << " dropped";
}

TEST_F(StreamTest, SamplesThatAReaderStillMissesAreKept) {
  make_writer(milliseconds(10000));
  add_reader(make_participant(), milliseconds(0));
  ASSERT_TRUE(wait_until([&] { return readers_ == 1; }));
  std::this_thread::sleep_for(milliseconds(600));  // its first acknowledgement is over
  for (int i = 0; i < 4; ++i) write();
  EXPECT_EQ(dropped_, 0u);
  size_t kept = 0;
  writer_->clear_history(&kept);
  EXPECT_EQ(kept, 4u);
}

}  // namespace
}  // namespace hrp
