// SPDX-License-Identifier: BSD-3-Clause
#include "common/messages/reflection/sample.h"

#include <cstdlib>
#include <cstring>

#include "common/base/diagnostics.h"
#include "common/base/join_words.h"
#include "common/base/suggest.h"

namespace hrp {
namespace {

// Reads plain CDR (XCDR1): values aligned to their size, counted from behind the 4-byte header. Or what ROS 1 writes.
class CdrReader {
 public:
  explicit CdrReader(Bytes sample, Wire wire = Wire::kCdr)
      : data_(sample.data), size_(sample.size), is_cdr_(wire == Wire::kCdr) {
    if (!is_cdr_) return;
    if (size_ < 4 || data_[0] != 0 || data_[1] > 1) throw DecodeError("no header of plain CDR in front of the sample");
    swap_ = data_[1] == 0;
    position_ = 4;
  }

  template <typename Value>
  Value read() {
    if (is_cdr_) position_ = 4 + (position_ - 4 + sizeof(Value) - 1) / sizeof(Value) * sizeof(Value);
    need(sizeof(Value));
    unsigned char bytes[sizeof(Value)];
    for (size_t i = 0; i < sizeof(Value); ++i) bytes[i] = data_[position_ + (swap_ ? sizeof(Value) - 1 - i : i)];
    position_ += sizeof(Value);
    Value value;
    std::memcpy(&value, bytes, sizeof(Value));
    return value;
  }

  std::string read_string() {
    const uint32_t size = read<uint32_t>();
    need(size);
    const char* text = reinterpret_cast<const char*>(data_ + position_);
    position_ += size;
    // The length of CDR counts the closing zero.
    return size == 0 ? std::string() : std::string(text, is_cdr_ ? size - 1 : size);
  }

  // Every element takes a byte at least: a count that cannot be is found before anything is done with it.
  size_t read_count() {
    const uint32_t count = read<uint32_t>();
    need(count);
    return count;
  }

 private:
  void need(size_t bytes) const {
    if (position_ > size_ || bytes > size_ - position_) {
      throw DecodeError("the sample of " + std::to_string(size_) + " bytes ends too early");
    }
  }

  const uint8_t* data_;
  size_t size_;
  size_t position_ = 0;
  bool is_cdr_ = true;
  bool swap_ = false;
};

// Reads on without telling anybody.
class Silence : public SampleVisitor {
 public:
  void begin_struct(const StructType&) override {}
  void end_struct() override {}
  void begin_field(const Field&) override {}
  void begin_list(const FieldType&, size_t) override {}
  void end_list() override {}
  void on_bool(bool) override {}
  void on_signed(int64_t) override {}
  void on_unsigned(uint64_t) override {}
  void on_float(double) override {}
  void on_string(const std::string&) override {}
  void on_enum(const EnumType&, uint32_t) override {}
};

void visit_struct(const StructType& type, CdrReader* cdr, SampleVisitor* visitor);

void visit_single(const FieldType& type, CdrReader* cdr, SampleVisitor* visitor) {
  switch (type.kind) {
    case ValueKind::kBool: return visitor->on_bool(cdr->read<uint8_t>() != 0);
    case ValueKind::kInt8: return visitor->on_signed(cdr->read<int8_t>());
    case ValueKind::kUint8: return visitor->on_unsigned(cdr->read<uint8_t>());
    case ValueKind::kInt16: return visitor->on_signed(cdr->read<int16_t>());
    case ValueKind::kUint16: return visitor->on_unsigned(cdr->read<uint16_t>());
    case ValueKind::kInt32: return visitor->on_signed(cdr->read<int32_t>());
    case ValueKind::kUint32: return visitor->on_unsigned(cdr->read<uint32_t>());
    case ValueKind::kInt64: return visitor->on_signed(cdr->read<int64_t>());
    case ValueKind::kUint64: return visitor->on_unsigned(cdr->read<uint64_t>());
    case ValueKind::kFloat32: return visitor->on_float(cdr->read<float>());
    case ValueKind::kFloat64: return visitor->on_float(cdr->read<double>());
    case ValueKind::kString: return visitor->on_string(cdr->read_string());
    case ValueKind::kEnum: return visitor->on_enum(*type.enumeration, cdr->read<uint32_t>());
    case ValueKind::kStruct: return visit_struct(*type.structure, cdr, visitor);
  }
}

void visit_value(const FieldType& type, CdrReader* cdr, SampleVisitor* visitor) {
  if (!type.is_list()) return visit_single(type, cdr, visitor);
  const size_t count = type.is_sequence ? cdr->read_count() : type.array_size;
  visitor->begin_list(type, count);
  for (size_t i = 0; i < count; ++i) visit_single(type, cdr, visitor);
  visitor->end_list();
}

void visit_value(const FieldType& type, const std::string& unit, CdrReader* cdr, SampleVisitor* visitor) {
  const bool hash = unit == "hex" && type.kind == ValueKind::kUint64 && !type.is_list();
  hash ? visitor->on_hash(cdr->read<uint64_t>()) : visit_value(type, cdr, visitor);
}

void visit_struct(const StructType& type, CdrReader* cdr, SampleVisitor* visitor) {
  visitor->begin_struct(type);
  for (const Field& field : type.fields) {
    visitor->begin_field(field);
    visit_value(field.type, field.unit, cdr, visitor);
  }
  visitor->end_struct();
}

// Moves to the element of a step's list. False: it is not there.
bool enter_list(const FieldPath::Step& step, CdrReader* cdr) {
  Silence silence;
  const FieldType& type = step.field->type;
  const size_t count = type.is_sequence ? cdr->read_count() : type.array_size;
  if (step.index >= count) return false;
  for (size_t i = 0; i < step.index; ++i) visit_single(type, cdr, &silence);
  return true;
}

}  // namespace

void visit_sample(const StructType& type, Bytes sample, SampleVisitor* visitor, Wire wire) {
  CdrReader cdr(sample, wire);
  visit_struct(type, &cdr, visitor);
}

bool visit_field(const StructType& type, Bytes sample, const FieldPath& path, SampleVisitor* visitor) {
  CdrReader cdr(sample);
  Silence silence;
  const StructType* at = &type;
  for (const FieldPath::Step& step : path.steps()) {
    for (const Field& field : at->fields) {
      if (&field == step.field) break;
      visit_value(field.type, &cdr, &silence);
    }
    if (step.has_index && !enter_list(step, &cdr)) return false;
    at = step.field->type.structure;
  }
  visit_value(path.type(), path.unit(), &cdr, visitor);
  return true;
}

namespace {

const Field& find_path_field(const StructType& type, const std::string& name, const std::string& path) {
  std::vector<std::string> names;
  for (const Field& field : type.fields) {
    if (field.name == name) return field;
    names.push_back(field.name);
  }
  refuse_input({"", path},
               type.name + " has no field '" + name + "'" + suggest(name, names, "; it has " + join_words(names)));
}

// "pairs[2]" -> field pairs, index 2
FieldPath::Step find_step(const StructType& type, const std::string& part, const std::string& path) {
  FieldPath::Step step;
  const size_t bracket = part.find('[');
  step.field = &find_path_field(type, part.substr(0, bracket), path);
  if (bracket == std::string::npos) return step;
  if (!step.field->type.is_list()) refuse_input({"", path}, "'" + step.field->name + "' is not a list");
  char* end = nullptr;
  step.has_index = true;
  step.index = std::strtoul(part.c_str() + bracket + 1, &end, 10);
  if (end == part.c_str() + bracket + 1 || std::string(end) != "]") {
    refuse_input({"", path}, "'" + part + "': expected a number in the brackets");
  }
  return step;
}

}  // namespace

FieldPath::FieldPath(const StructType& type, const std::string& text) : text_(text) {
  const StructType* at = &type;
  for (size_t begin = 0; begin <= text.size();) {
    if (!at) refuse_input({"", text}, "'" + steps_.back().field->name + "' has no fields");
    if (!steps_.empty() && steps_.back().field->type.is_list() && !steps_.back().has_index) {
      refuse_input({"", text}, "'" + steps_.back().field->name + "' is a list: say which, as in " +
                                   steps_.back().field->name + "[0]");
    }
    const size_t end = std::min(text.find('.', begin), text.size());
    steps_.push_back(find_step(*at, text.substr(begin, end - begin), text));
    at = steps_.back().field->type.structure;
    begin = end + 1;
  }
}

FieldType FieldPath::type() const {
  FieldType type = steps_.back().field->type;
  if (steps_.back().has_index) {
    type.is_sequence = false;
    type.array_size = 0;
  }
  return type;
}

namespace {

class NumberTaker : public Silence {
 public:
  void begin_struct(const StructType&) override { single_ = false; }
  void begin_list(const FieldType&, size_t) override { single_ = false; }
  void on_bool(bool value) override { set(value ? 1 : 0); }
  void on_signed(int64_t value) override { set(static_cast<double>(value)); }
  void on_unsigned(uint64_t value) override { set(static_cast<double>(value)); }
  void on_float(double value) override { set(value); }
  void on_enum(const EnumType&, uint32_t value) override { set(value); }
  std::optional<double> found() const { return single_ ? number_ : std::nullopt; }

 private:
  void set(double value) { number_ = value; }
  bool single_ = true;
  std::optional<double> number_;
};

}  // namespace

std::optional<double> find_number(const StructType& type, Bytes sample, const FieldPath& path) {
  NumberTaker taker;
  if (!visit_field(type, sample, path, &taker)) return std::nullopt;
  return taker.found();
}

}  // namespace hrp
