// SPDX-License-Identifier: BSD-3-Clause
#include "common/log/ros_types.h"

#include <set>
#include <sstream>
#include <stdexcept>

#include "common/base/diagnostics.h"
#include "common/base/ends_with.h"
#include "common/base/ros_definitions.h"

namespace hrp {
namespace {

// "ros2msg", "ros1msg": the type's own lines, then a line of '=' and "MSG: package/Type" before the lines of each type
// it needs.
std::map<std::string, std::string> split_definitions(const std::string& name, const std::string& text) {
  std::map<std::string, std::string> parts;
  std::string current = name, line;
  std::istringstream in(text);
  while (std::getline(in, line)) {
    if (line.rfind("====", 0) == 0) continue;
    if (line.rfind("MSG: ", 0) == 0) {
      current = find_ros_name(line.substr(5));
      continue;
    }
    parts[current] += line + "\n";
  }
  return parts;
}

const char* find_basic(const std::string& word) {
  static const std::map<std::string, const char*> basic{{"bool", "boolean"},
                                                        {"byte", "octet"},
                                                        {"char", "uint8"},
                                                        {"int8", "int8"},
                                                        {"uint8", "uint8"},
                                                        {"int16", "short"},
                                                        {"uint16", "unsigned short"},
                                                        {"int32", "long"},
                                                        {"uint32", "unsigned long"},
                                                        {"int64", "long long"},
                                                        {"uint64", "unsigned long long"},
                                                        {"float32", "float"},
                                                        {"float64", "double"},
                                                        {"string", "string"}};
  const auto at = basic.find(word);
  return at == basic.end() ? nullptr : at->second;
}

// Writes IDL of a type and, before it, of all that it needs.
class IdlWriter {
 public:
  explicit IdlWriter(std::map<std::string, std::string> parts) : parts_(std::move(parts)) {}

  std::string write(const std::string& name) {
    write_type(name);
    return out_;
  }

 private:
  std::string find_definition(const std::string& name) const {
    const auto own = parts_.find(name);
    if (own != parts_.end()) return own->second;
    const char* known = find_ros_definition(name);
    if (known == nullptr) throw std::runtime_error("no definition of the type " + name);
    return known;
  }

  void write_type(const std::string& name) {
    if (!written_.insert(name).second) return;
    const std::string package = name.substr(0, name.find('/'));
    std::istringstream in(find_definition(name));
    std::string fields, line;
    while (std::getline(in, line)) fields += write_field(package, line);
    // rosidl gives a type without fields one byte.
    if (fields.empty()) fields = "  uint8 structure_needs_at_least_one_member;\n";
    out_ += "module " + package + " { module msg {\nstruct " + name.substr(name.rfind('/') + 1) + " {\n" + fields +
            "};\n}; };\n";
  }

  // "float64[9] covariance # unit" -> "  double covariance[9];"; empty for constants and comments.
  std::string write_field(const std::string& package, const std::string& line) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string type, name, rest;
    words >> type >> name >> rest;
    if (type.empty() || name.empty() || name.find('=') != std::string::npos || rest.rfind('=', 0) == 0) return "";
    const size_t bracket = type.find('[');
    const std::string bounds =
        bracket == std::string::npos ? "" : type.substr(bracket + 1, type.find(']') - bracket - 1);
    std::string base = type.substr(0, bracket);
    base = base.substr(0, base.find("<="));  // string<=10
    const std::string idl = write_base(package, base);
    if (bracket == std::string::npos) return "  " + idl + " " + name + ";\n";
    const bool fixed = !bounds.empty() && bounds[0] != '<';
    return fixed ? "  " + idl + " " + name + "[" + bounds + "];\n" : "  sequence<" + idl + "> " + name + ";\n";
  }

  std::string write_base(const std::string& package, const std::string& base) {
    if (const char* basic = find_basic(base)) return basic;
    std::string full = base == "Header" ? "std_msgs/msg/Header"
                       : base == "time" || base == "duration"
                           ? std::string("builtin_interfaces/msg/") + (base == "time" ? "Time" : "Duration")
                       : base.find('/') == std::string::npos ? package + "/msg/" + base
                                                             : find_ros_name(base);
    write_type(full);
    return full.substr(0, full.find('/')) + "::msg::" + full.substr(full.rfind('/') + 1);
  }

  std::map<std::string, std::string> parts_;
  std::set<std::string> written_;
  std::string out_;
};

bool has_path(const StructType& type, const std::string& path) {
  const size_t dot = path.find('.');
  std::string head = path.substr(0, dot);
  const bool list = head.size() > 2 && ends_with(head, "[]");
  if (list) head.resize(head.size() - 2);
  for (const Field& field : type.fields) {
    if (field.name != head) continue;
    if (dot == std::string::npos) return field.type.kind != ValueKind::kStruct;
    return field.type.structure && field.type.is_list() == list &&
           has_path(*field.type.structure, path.substr(dot + 1));
  }
  return false;
}

}  // namespace

// Keeps the path of the value that comes next.
class PathVisitor : public SampleVisitor {
 public:
  explicit PathVisitor(std::map<std::string, RosValues::Slot>* slots) : slots_(*slots) {}
  void begin_struct(const StructType&) override {
    if (!path_.empty()) path_ += ".";
    lengths_.push_back(path_.size());
  }
  void end_struct() override {
    const size_t length = lengths_.back();
    path_.resize(length > 0 ? length - 1 : 0);
    lengths_.pop_back();
  }
  void begin_field(const Field& field) override {
    path_.resize(lengths_.back());
    path_ += field.name;
    find_slot();
  }
  void begin_list(const FieldType& type, size_t) override {
    if (type.kind == ValueKind::kStruct) path_ += "[]";
  }
  void end_list() override {}
  void on_bool(bool value) override { add(value ? 1.0 : 0.0); }
  void on_signed(int64_t value) override { add(static_cast<double>(value)); }
  void on_unsigned(uint64_t value) override { add(static_cast<double>(value)); }
  void on_float(double value) override { add(value); }
  void on_enum(const EnumType&, uint32_t value) override { add(value); }
  void on_string(const std::string& value) override {
    if (slot_) slot_->texts.push_back(value);
  }

 private:
  void find_slot() {
    const auto at = slots_.find(path_);
    slot_ = at == slots_.end() ? nullptr : &at->second;
  }
  void add(double value) {
    if (slot_) slot_->numbers.push_back(value);
  }
  std::map<std::string, RosValues::Slot>& slots_;
  RosValues::Slot* slot_ = nullptr;
  std::string path_;
  std::vector<size_t> lengths_;
};

RosType::RosType(const std::string& name, const std::string& encoding, const std::string& definition)
    : name_(find_ros_name(name)), wire_(encoding == "ros1msg" ? Wire::kRos1 : Wire::kCdr) {
  std::map<std::string, std::string> parts;
  if (encoding == "ros2msg" || encoding == "ros1msg") parts = split_definitions(name_, definition);
  const std::string idl = IdlWriter(std::move(parts)).write(name_);
  try {
    schema_ = std::make_shared<Schema>(parse_idl({{name_, idl}}));
  } catch (const InputError& error) {
    throw std::runtime_error("the definition of " + name_ + " is not understood: " + error.what());
  }
  structure_ = schema_->find_struct(name_.substr(0, name_.find('/')) + "::msg::" + name_.substr(name_.rfind('/') + 1));
  if (structure_ == nullptr) throw std::runtime_error("no definition of the type " + name_);
}

bool RosType::has(const std::string& path) const { return has_path(*structure_, path); }

RosValues::RosValues(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) slots_[path];
}

void RosValues::read(const RosType& type, Bytes message) {
  for (auto& [path, slot] : slots_) {
    slot.numbers.clear();
    slot.texts.clear();
  }
  PathVisitor visitor(&slots_);
  visit_sample(type.structure(), message, &visitor, type.wire());
}

const std::vector<double>& RosValues::numbers(const std::string& path) const {
  static const std::vector<double> none;
  const auto at = slots_.find(path);
  return at == slots_.end() ? none : at->second.numbers;
}

const std::vector<std::string>& RosValues::texts(const std::string& path) const {
  static const std::vector<std::string> none;
  const auto at = slots_.find(path);
  return at == slots_.end() ? none : at->second.texts;
}

}  // namespace hrp
