// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/topic_tool/sample_text.h"

#include <cstring>

#include <yaml-cpp/yaml.h>

#include "common/base/diagnostics.h"
#include "common/base/has.h"

namespace hrp {
namespace {

[[noreturn]] void refuse(const YAML::Node& node, const std::string& field, const std::string& message) {
  const YAML::Mark mark = node.IsDefined() ? node.Mark() : YAML::Mark::null_mark();
  refuse_input({"message", field, mark.line + 1, mark.column + 1}, message);
}

// Plain CDR, little endian: each number begins at a multiple of its size, counted behind the header of 4 bytes.
class CdrBytes {
 public:
  CdrBytes() : bytes_{0, 1, 0, 0} {}

  template <typename Number>
  void add(Number value) {
    while ((bytes_.size() - 4) % sizeof(Number) != 0) bytes_.push_back(0);
    uint8_t raw[sizeof(Number)];
    std::memcpy(raw, &value, sizeof raw);
    bytes_.insert(bytes_.end(), raw, raw + sizeof raw);
  }

  void add_text(const std::string& text) {
    add(static_cast<uint32_t>(text.size() + 1));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
  }

  std::vector<uint8_t> finish() {
    while (bytes_.size() % 4 != 0) bytes_.push_back(0);
    return std::move(bytes_);
  }

 private:
  std::vector<uint8_t> bytes_;
};

class TextEncoder {
 public:
  std::vector<uint8_t> encode(const StructType& type, const YAML::Node& node) {
    add_struct(type, node, "");
    return bytes_.finish();
  }

 private:
  void add_struct(const StructType& type, const YAML::Node& node, const std::string& path) {
    if (node.IsDefined() && !node.IsNull() && !node.IsMap())
      refuse(node, path, "expected the fields of " + type.name + " as {field: value}");
    std::vector<std::string> names;
    for (const Field& field : type.fields) names.push_back(field.name);
    if (node.IsDefined() && node.IsMap()) check_keys(node, names, path, type.name);
    for (const Field& field : type.fields) {
      const YAML::Node value =
          node.IsDefined() && node.IsMap() ? node[field.name] : YAML::Node(YAML::NodeType::Undefined);
      add_field(field.type, value, path.empty() ? field.name : path + "." + field.name);
    }
  }

  static void check_keys(const YAML::Node& node, const std::vector<std::string>& names, const std::string& path,
                         const std::string& type) {
    for (const auto& entry : node) {
      const std::string key = entry.first.as<std::string>();
      if (has(names, key)) continue;
      const std::string nearest = find_nearest(key, names);
      refuse(entry.first, path,
             "'" + key + "' is no field of " + type + (nearest.empty() ? "" : "; is it '" + nearest + "'?"));
    }
  }

  void add_field(const FieldType& type, const YAML::Node& node, const std::string& path) {
    if (!type.is_list()) return add_value(type, node, path);
    const bool given = node.IsDefined() && !node.IsNull();
    if (given && !node.IsSequence()) refuse(node, path, "expected a list");
    const size_t size = given ? node.size() : type.array_size;
    if (type.array_size > 0 && size != type.array_size)
      refuse(node, path, std::to_string(size) + " values; expected " + std::to_string(type.array_size));
    if (type.is_sequence) bytes_.add(static_cast<uint32_t>(size));
    for (size_t i = 0; i < size; ++i) {
      add_value(type, given ? node[i] : YAML::Node(YAML::NodeType::Undefined), path + "[" + std::to_string(i) + "]");
    }
  }

  template <typename Number>
  void add_number(const YAML::Node& node, const std::string& path, const char* expected) {
    Number value{};
    if (node.IsDefined() && !YAML::convert<Number>::decode(node, value))
      refuse(node, path, "'" + print(node) + "'; expected " + expected);
    bytes_.add(value);
  }

  static std::string print(const YAML::Node& node) { return node.IsScalar() ? node.Scalar() : "a list or mapping"; }

  void add_value(const FieldType& type, const YAML::Node& node, const std::string& path) {
    switch (type.kind) {
      case ValueKind::kStruct: return add_struct(*type.structure, node, path);
      case ValueKind::kFloat64: return add_number<double>(node, path, "a number");
      case ValueKind::kFloat32: return add_number<float>(node, path, "a number");
      case ValueKind::kInt32: return add_number<int32_t>(node, path, "a whole number");
      case ValueKind::kUint32: return add_number<uint32_t>(node, path, "a whole number, 0 or more");
      case ValueKind::kString:
        if (node.IsDefined() && !node.IsScalar()) refuse(node, path, "expected a text");
        return bytes_.add_text(node.IsDefined() ? node.Scalar() : "");
      default:
        refuse(node, path, "values of this type cannot be sent");  // none of the messages that take commands has them
    }
  }

  CdrBytes bytes_;
};

}  // namespace

std::vector<uint8_t> encode_text(const StructType& type, const std::string& text) {
  try {
    return TextEncoder().encode(type, YAML::Load(text));
  } catch (const YAML::Exception& error) {
    refuse_input({"message", "", error.mark.line + 1, error.mark.column + 1}, error.msg);
  }
}

}  // namespace hrp
