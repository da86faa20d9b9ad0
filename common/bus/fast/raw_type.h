// SPDX-License-Identifier: BSD-3-Clause
// A Fast DDS type that carries encoded samples as they are.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <fastdds/dds/topic/TopicDataType.hpp>

#include "common/bus/bus.h"

namespace hrp {

// Written from Bytes, read into std::vector<uint8_t>.
class RawType : public eprosima::fastdds::dds::TopicDataType {
 public:
  explicit RawType(const std::string& type_name);
  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override;
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override;
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override;
  void* createData() override;
  void deleteData(void* data) override;
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

}  // namespace hrp
