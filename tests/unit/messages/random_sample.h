// SPDX-License-Identifier: BSD-3-Clause
// Valid encoded samples of any type, made from its schema: plain CDR written a second time, independent of Fast CDR.
#pragma once

#include <cstring>
#include <random>
#include <vector>

#include "common/messages/reflection/schema.h"

namespace hrp {

class RandomSample {
 public:
  RandomSample(const StructType& type, unsigned seed, size_t longest_list = 3)
      : bytes_{0, 1, 0, 0}, random_(seed), longest_list_(longest_list) {
    write_struct(type);
    while (bytes_.size() % 4) bytes_.push_back(0);
  }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  template <typename Value>
  void write(Value value) {
    while ((bytes_.size() - 4) % sizeof(Value)) bytes_.push_back(0);
    const auto* raw = reinterpret_cast<const uint8_t*>(&value);
    bytes_.insert(bytes_.end(), raw, raw + sizeof(Value));
  }

  void write_string() {
    const uint32_t size = static_cast<uint32_t>(random_() % 12);
    write<uint32_t>(size + 1);
    for (uint32_t i = 0; i < size; ++i) bytes_.push_back(static_cast<uint8_t>('a' + random_() % 26));
    bytes_.push_back(0);
  }

  void write_single(const FieldType& type) {
    switch (type.kind) {
      case ValueKind::kBool: return write<uint8_t>(random_() % 2);
      case ValueKind::kInt8:
      case ValueKind::kUint8: return write<uint8_t>(static_cast<uint8_t>(random_()));
      case ValueKind::kInt16:
      case ValueKind::kUint16: return write<uint16_t>(static_cast<uint16_t>(random_()));
      case ValueKind::kInt32:
      case ValueKind::kUint32: return write<uint32_t>(static_cast<uint32_t>(random_()));
      case ValueKind::kInt64:
      case ValueKind::kUint64: return write<uint64_t>(random_());
      case ValueKind::kFloat32: return write<float>(static_cast<float>(random_() % 1000) / 8);
      case ValueKind::kFloat64: return write<double>(static_cast<double>(random_() % 1000000) / 1024 - 400);
      case ValueKind::kString: return write_string();
      case ValueKind::kEnum: return write<uint32_t>(static_cast<uint32_t>(random_() % type.enumeration->values.size()));
      case ValueKind::kStruct: return write_struct(*type.structure);
    }
  }

  void write_struct(const StructType& type) {
    for (const Field& field : type.fields) {
      size_t count = field.type.array_size > 0 ? field.type.array_size : 1;
      if (field.type.is_sequence) {
        count = random_() % (longest_list_ + 1);
        write<uint32_t>(static_cast<uint32_t>(count));
      }
      for (size_t i = 0; i < count; ++i) write_single(field.type);
    }
  }

  std::vector<uint8_t> bytes_;
  std::mt19937_64 random_;
  size_t longest_list_;
};

}  // namespace hrp
