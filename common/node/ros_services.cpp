// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/ros_services.h"

#include <utility>

#include "common/messages/cdr.h"
#include "common/messages/ros_topics.h"

namespace hrp {

using ::std_srvs::srv::dds_::SetBool_Request_;
using ::std_srvs::srv::dds_::SetBool_Response_;
using ::std_srvs::srv::dds_::Trigger_Request_;
using ::std_srvs::srv::dds_::Trigger_Response_;

namespace {

constexpr size_t kEncapsulation = 4, kPadding = 3;

}  // namespace

template <typename Request, typename Response>
void RosServices::offer(Bus& bus, const ServiceSpec& service,
                        std::function<msg::RunRequest(const Request&)> find_request) {
  auto buffer = std::make_shared<std::vector<char>>();
  services_.push_back(
      bus.make_service(service, [this, buffer, find_request = std::move(find_request)](Bytes asked) -> Bytes {
        Request request;
        try {
          decode(asked, &request);
        } catch (const DecodeError&) {
          return {};  // no request of this service
        }
        // Nor is what is longer: with Fast DDS that is how requests of rmw_cyclonedds come, whose replies it would not
        // find.
        if (asked.size > kEncapsulation + Request::getCdrSerializedSize(request) + kPadding) return {};
        const SteerResult result = steer_(find_request(request));
        Response response;
        response.success(result.success);
        response.message(result.message);
        return encode(response, buffer.get());
      }));
}

RosServices::RosServices(Bus& bus, Steer steer) : steer_(std::move(steer)) {
  offer<SetBool_Request_, SetBool_Response_>(bus, topics::kRosPause, [](const SetBool_Request_& request) {
    return request.data() ? msg::REQUEST_PAUSE : msg::REQUEST_RUN;
  });
  using Triggered = std::pair<const ServiceSpec&, msg::RunRequest>;
  for (const auto& [service, asked] :
       {Triggered{topics::kRosResume, msg::REQUEST_RUN}, Triggered{topics::kRosStep, msg::REQUEST_STEP},
        Triggered{topics::kRosReset, msg::REQUEST_RESET}}) {
    offer<Trigger_Request_, Trigger_Response_>(bus, service,
                                               [request = asked](const Trigger_Request_&) { return request; });
  }
}

}  // namespace hrp
