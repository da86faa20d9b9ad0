// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include "common/bus/bus.h"

namespace hrp {
namespace {

constexpr int kDepth = 10;  // as rmw_qos_profile_services_default
constexpr size_t kEncapsulation = 4;
constexpr size_t kRequestId = 16;  // of rmw_cyclonedds: uint64 guid of the client, int64 number of the request

// Alignment is not disturbed: the identity is a multiple of 8 bytes long.
class HeaderService : public Service {
 public:
  HeaderService(Bus& bus, const ServiceSpec& service, ServiceCallback callback)
      : callback_(std::move(callback)),
        replies_(bus.make_writer(find_reply_topic(service))),
        requests_(bus.make_reader(find_request_topic(service), Delivery::kReliable,
                                  [this](Bytes sample) { take(sample); })) {}

 private:
  void take(Bytes sample) {
    if (sample.size < kEncapsulation + kRequestId) return;
    if (sample.data[0] != 0 || sample.data[1] != 1) return;  // the identity would be in another byte order
    request_.assign(sample.data, sample.data + kEncapsulation);
    request_.insert(request_.end(), sample.data + kEncapsulation + kRequestId, sample.data + sample.size);
    const Bytes reply = callback_({request_.data(), request_.size()});
    if (reply.size < kEncapsulation) return;
    reply_.assign(reply.data, reply.data + kEncapsulation);
    reply_.insert(reply_.end(), sample.data + kEncapsulation, sample.data + kEncapsulation + kRequestId);
    reply_.insert(reply_.end(), reply.data + kEncapsulation, reply.data + reply.size);
    replies_->write({reply_.data(), reply_.size()});
  }

  ServiceCallback callback_;
  std::vector<uint8_t> request_, reply_;
  std::unique_ptr<Writer> replies_;
  std::unique_ptr<Reader> requests_;  // ends first: it calls take()
};

}  // namespace

TopicSpec find_request_topic(const ServiceSpec& service) {
  return {"rq/" + service.name + "Request", service.type_name + "_Request_", Retention::kStream, kDepth};
}

TopicSpec find_reply_topic(const ServiceSpec& service) {
  return {"rr/" + service.name + "Reply", service.type_name + "_Response_", Retention::kStream, kDepth};
}

std::unique_ptr<Service> Bus::make_service(const ServiceSpec& service, ServiceCallback callback) {
  return std::make_unique<HeaderService>(*this, service, std::move(callback));
}

}  // namespace hrp
