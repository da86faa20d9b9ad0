// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/fast/raw_type.h"

#include <cstring>

namespace hrp {

using eprosima::fastrtps::rtps::SerializedPayload_t;

RawType::RawType(const std::string& type_name) {
  setName(type_name.c_str());
  m_typeSize = 1024;  // what histories reserve for a sample at first; they grow
  m_isGetKeyDefined = false;
  // Cyclone DDS refuses to match Fast's idea of type information.
  auto_fill_type_object(false);
  auto_fill_type_information(false);
}

bool RawType::serialize(void* data, SerializedPayload_t* payload) {
  const Bytes& sample = *static_cast<const Bytes*>(data);
  if (payload->max_size < sample.size) return false;
  std::memcpy(payload->data, sample.data, sample.size);
  payload->length = static_cast<uint32_t>(sample.size);
  payload->encapsulation = CDR_LE;
  return true;
}

bool RawType::deserialize(SerializedPayload_t* payload, void* data) {
  auto& bytes = *static_cast<std::vector<uint8_t>*>(data);
  bytes.assign(payload->data, payload->data + payload->length);
  bytes.resize((bytes.size() + 3) & ~size_t{3}, 0);
  // The options of the header count padding with some writers; without them equal messages are equal bytes.
  if (bytes.size() >= 4) bytes[2] = bytes[3] = 0;
  return true;
}

std::function<uint32_t()> RawType::getSerializedSizeProvider(void* data) {
  const auto size = static_cast<uint32_t>(static_cast<const Bytes*>(data)->size);
  return [size] { return size; };
}

void* RawType::createData() { return new std::vector<uint8_t>; }

void RawType::deleteData(void* data) { delete static_cast<std::vector<uint8_t>*>(data); }

}  // namespace hrp
