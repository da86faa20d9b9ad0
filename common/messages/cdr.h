// SPDX-License-Identifier: BSD-3-Clause
// Message <-> bytes: XCDR1, little endian, with the 4-byte encapsulation header, the same on every bus and in every
// log.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include <fastcdr/Cdr.h>

#include "common/bus/bus.h"
#include "common/messages/loop_cdr.h"

namespace hrp {

// Bytes that are no sample of the expected type.
class DecodeError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Encodes into `buffer`, reusing its memory; the returned bytes live in `buffer`. Equal messages give equal bytes: gaps
// before aligned fields are zero (Fast CDR leaves what was there), and the size is a multiple of 4, as RTPS carries it,
// so that no vendor has to add anything.
template <typename Message>
Bytes encode(const Message& message, std::vector<char>* buffer) {
  const size_t size = (Message::getCdrSerializedSize(message) + 4 + 3) & ~size_t{3};
  if (buffer->size() < size) buffer->resize(size);
  std::fill_n(buffer->data(), size, 0);
  eprosima::fastcdr::FastBuffer fast(buffer->data(), buffer->size());
  eprosima::fastcdr::Cdr cdr(fast, eprosima::fastcdr::Cdr::LITTLE_ENDIANNESS, eprosima::fastcdr::Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  message.serialize(cdr);
  const size_t written = (cdr.getSerializedDataLength() + 3) & ~size_t{3};
  return {reinterpret_cast<const uint8_t*>(buffer->data()), written};
}

// Decodes into `message`, reusing its memory. Throws DecodeError when the bytes end early or make no sense.
template <typename Message>
void decode(Bytes sample, Message* message) {
  try {
    // Fast CDR never writes to a buffer that it decodes from.
    eprosima::fastcdr::FastBuffer fast(const_cast<char*>(reinterpret_cast<const char*>(sample.data)), sample.size);
    eprosima::fastcdr::Cdr cdr(fast, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::Cdr::DDS_CDR);
    cdr.read_encapsulation();
    message->deserialize(cdr);
  } catch (const std::exception& error) {
    throw DecodeError(std::string("cannot decode a sample of ") + std::to_string(sample.size) +
                      " bytes: " + error.what());
  }
}

}  // namespace hrp
