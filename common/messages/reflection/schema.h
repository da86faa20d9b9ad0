// SPDX-License-Identifier: BSD-3-Clause
// What the IDL says about a type, at run time: for tools that show, plot or log messages without their C++ types.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace hrp {

enum class ValueKind {
  kBool,
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64,
  kString,
  kEnum,
  kStruct
};

struct StructType;

struct EnumType {
  std::string name;                 // "hrp::msg::JointKind"
  std::vector<std::string> values;  // numbered from 0
};

struct FieldType {
  ValueKind kind = ValueKind::kInt32;
  const StructType* structure = nullptr;  // kStruct
  const EnumType* enumeration = nullptr;  // kEnum
  bool is_sequence = false;
  size_t array_size = 0;  // 0: no array
  bool is_list() const { return is_sequence || array_size > 0; }
};

struct Field {
  std::string name;
  FieldType type;
  std::string comment;  // one line
  std::string unit;     // what the comment says in brackets at its start: "N m", empty when it says nothing
};

struct StructType {
  std::string name;  // "hrp::msg::RobotState"
  std::vector<Field> fields;
  std::string comment;
};

class Schema {
 public:
  // nullptr when there is none.
  const StructType* find_struct(const std::string& name) const;
  const EnumType* find_enum(const std::string& name) const;
  // In alphabetic order.
  std::vector<std::string> find_struct_names() const;
  // IDL of one type and of all that it needs, in one text without preprocessor lines, comments kept. Empty when there
  // is no such type.
  std::string find_text(const std::string& name) const;

 private:
  friend class IdlParser;
  struct Definition {
    std::vector<std::string> modules;
    std::string text;                // as it stands in the file, comments in front included
    std::vector<std::string> needs;  // names of other definitions
    size_t order = 0;
  };
  void collect(const std::string& name, std::map<size_t, const Definition*>* found) const;
  std::map<std::string, std::unique_ptr<StructType>> structs_;
  std::map<std::string, std::unique_ptr<EnumType>> enums_;
  std::map<std::string, Definition> definitions_;
};

struct IdlFile {
  std::string name;  // for messages
  std::string text;
};

// Parses the part of IDL that idl/ uses: modules, @final structs of basic types, strings, sequences, arrays, enums and
// structs, comments. Definitions stand before their use. Include lines are skipped. Throws InputError with file and
// line.
Schema parse_idl(const std::vector<IdlFile>& files);

// The files of idl/, as they were when this program was built.
const std::vector<IdlFile>& get_idl_files();

// All our types.
const Schema& get_schema();

// Self-contained IDL of one of our types, as `omgidl` schemas of MCAP want it; empty for unknown types.
std::string find_schema_text(const std::string& type_name);

}  // namespace hrp
