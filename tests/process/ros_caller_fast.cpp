// SPDX-License-Identifier: BSD-3-Clause
// ros_caller_fast DOMAIN CALL: as ros_caller.c, but as rmw_fastrtps does: the request names the reader of its reply
// beside the sample, and the reply names the request. Prints "reply SUCCESS MESSAGE", or "silence" after two seconds
// without one.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Sample = std::vector<uint8_t>;

class SampleType : public dds::TopicDataType {
 public:
  explicit SampleType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 256;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const Sample& sample = *static_cast<Sample*>(data);
    std::memcpy(payload->data, sample.data(), sample.size());
    payload->length = static_cast<uint32_t>(sample.size());
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<Sample*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
    return [size = static_cast<uint32_t>(static_cast<Sample*>(data)->size())] { return size; };
  }
  void* createData() override { return new Sample; }
  void deleteData(void* data) override { delete static_cast<Sample*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

// Loopback without multicast, as idl/README.md says.
dds::DomainParticipant* make_participant(unsigned domain) {
  dds::DomainParticipantQos qos;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.push_back("127.0.0.1");
  udp->maxInitialPeersRange = 40;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  rtps::Locator_t here;
  rtps::IPLocator::setIPv4(here, "127.0.0.1");
  here.port = 0;
  qos.wire_protocol().builtin.metatrafficUnicastLocatorList.push_back(here);
  qos.wire_protocol().builtin.initialPeersList.push_back(here);
  return dds::DomainParticipantFactory::get_instance()->create_participant(domain, qos);
}

dds::Topic* make_topic(dds::DomainParticipant* participant, const std::string& name, const std::string& type) {
  dds::TypeSupport(new SampleType(type)).register_type(participant);
  return participant->create_topic(name, type, dds::TOPIC_QOS_DEFAULT);
}

// success, then the length of the message at the next multiple of 4.
void print_reply(const Sample& sample) {
  uint32_t length = 0;
  std::memcpy(&length, sample.data() + 8, 4);
  std::printf("reply %d %.*s\n", sample[4], static_cast<int>(length) - 1,
              reinterpret_cast<const char*>(sample.data() + 12));
}

void await_reply(dds::DataReader* reader, const rtps::SampleIdentity& request) {
  for (int i = 0; i < 200; ++i) {
    Sample sample;
    dds::SampleInfo info;
    while (reader->take_next_sample(&sample, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data || info.related_sample_identity != request) continue;
      return print_reply(sample);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::printf("silence\n");
}

int call_service(unsigned domain, const std::string& call) {
  const std::string service = "run/" + (call == "go" ? std::string("pause") : call);
  const std::string type = std::string("std_srvs::srv::dds_::") + (service == "run/pause" ? "SetBool" : "Trigger");
  dds::DomainParticipant* participant = make_participant(domain);
  dds::DataWriterQos writing;
  writing.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  dds::DataReaderQos reading;
  reading.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  dds::DataWriter* writer =
      participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT)
          ->create_datawriter(make_topic(participant, "rq/" + service + "Request", type + "_Request_"), writing);
  dds::DataReader* reader =
      participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT)
          ->create_datareader(make_topic(participant, "rr/" + service + "Reply", type + "_Response_"), reading);
  dds::PublicationMatchedStatus written;
  dds::SubscriptionMatchedStatus read;
  while (written.current_count == 0 || read.current_count == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    writer->get_publication_matched_status(written);
    reader->get_subscription_matched_status(read);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // the other side must know us, too
  Sample request{0, 1, 0, 0, static_cast<uint8_t>(call != "go"), 0, 0, 0};
  rtps::WriteParams parameters;
  parameters.related_sample_identity().writer_guid() = reader->guid();
  if (!writer->write(&request, parameters)) return 1;
  rtps::SampleIdentity identity = parameters.sample_identity();
  identity.writer_guid(reader->guid());
  await_reply(reader, identity);
  participant->delete_contained_entities();
  dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return argc == 3 ? call_service(static_cast<unsigned>(std::atoi(argv[1])), argv[2]) : 2;
}
