// SPDX-License-Identifier: BSD-3-Clause
// Reads encoded samples by their schema: visit every value, print as text or JSON, pick one value by its path.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/messages/cdr.h"
#include "common/messages/reflection/schema.h"

namespace hrp {

// Told of the values of a sample in the order of the IDL. A list is a sequence or an array.
class SampleVisitor {
 public:
  virtual ~SampleVisitor() = default;
  virtual void begin_struct(const StructType& type) = 0;
  virtual void end_struct() = 0;
  // Says which field the next value is.
  virtual void begin_field(const Field& field) = 0;
  virtual void begin_list(const FieldType& type, size_t size) = 0;
  virtual void end_list() = 0;
  virtual void on_bool(bool value) = 0;
  virtual void on_signed(int64_t value) = 0;
  virtual void on_unsigned(uint64_t value) = 0;
  // A hash: the unit of its field is "hex".
  virtual void on_hash(uint64_t value) { on_unsigned(value); }
  virtual void on_float(double value) = 0;
  virtual void on_string(const std::string& value) = 0;
  virtual void on_enum(const EnumType& type, uint32_t value) = 0;
};

// "pairs[0].total.force.z": fields and indices that lead to a part of a message.
class FieldPath {
 public:
  // Throws InputError naming the step that does not exist, and the nearest that does.
  FieldPath(const StructType& type, const std::string& text);

  struct Step {
    const Field* field = nullptr;
    bool has_index = false;
    size_t index = 0;
  };
  const std::vector<Step>& steps() const { return steps_; }
  const std::string& text() const { return text_; }
  // Type of what the path leads to; elements of lists are no lists.
  FieldType type() const;
  std::string unit() const { return steps_.back().field->unit; }

 private:
  std::string text_;
  std::vector<Step> steps_;
};

// kRos1: as ROS 1 serializes: no header, no gaps, texts without a closing zero, little endian.
enum class Wire { kCdr, kRos1 };

// All of these throw DecodeError when the bytes are no sample of `type`.
void visit_sample(const StructType& type, Bytes sample, SampleVisitor* visitor, Wire wire = Wire::kCdr);
// False: the path's index is beyond a sequence's end in this sample.
bool visit_field(const StructType& type, Bytes sample, const FieldPath& path, SampleVisitor* visitor);

// One line of JSON. Numbers are exact (shortest form that reads back the same); not-a-number and infinities, which JSON
// does not have, are the strings "nan", "inf" and "-inf". Hashes are strings of 16 hexadecimal digits.
std::string print_json(const StructType& type, Bytes sample);
// Many lines for people, with units: "depth [m]: 0.0012". Long strings are cut.
std::string print_text(const StructType& type, Bytes sample);
// The same for the part of the message that a path leads to; nothing when it is not there in this sample.
std::optional<std::string> print_json(const StructType& type, Bytes sample, const FieldPath& path);
std::optional<std::string> print_text(const StructType& type, Bytes sample, const FieldPath& path);

// The number at a path: booleans are 0 and 1, enums their number. Nothing when it is not there or not a number.
std::optional<double> find_number(const StructType& type, Bytes sample, const FieldPath& path);

}  // namespace hrp
