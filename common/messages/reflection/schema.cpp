// SPDX-License-Identifier: BSD-3-Clause
#include "common/messages/reflection/schema.h"

namespace hrp {

const StructType* Schema::find_struct(const std::string& name) const {
  const auto found = structs_.find(name);
  return found == structs_.end() ? nullptr : found->second.get();
}

const EnumType* Schema::find_enum(const std::string& name) const {
  const auto found = enums_.find(name);
  return found == enums_.end() ? nullptr : found->second.get();
}

std::vector<std::string> Schema::find_struct_names() const {
  std::vector<std::string> names;
  for (const auto& [name, type] : structs_) names.push_back(name);
  return names;
}

void Schema::collect(const std::string& name, std::map<size_t, const Definition*>* found) const {
  const auto definition = definitions_.find(name);
  if (definition == definitions_.end()) return;
  if (!found->emplace(definition->second.order, &definition->second).second) return;
  for (const std::string& needed : definition->second.needs) collect(needed, found);
}

std::string Schema::find_text(const std::string& name) const {
  std::map<size_t, const Definition*> needed;
  if (find_struct(name)) collect(name, &needed);
  std::string text;
  const std::vector<std::string>* open = nullptr;
  const auto close = [&] {
    for (size_t i = 0; open && i < open->size(); ++i) text += "};\n";
  };
  for (const auto& [order, definition] : needed) {
    if (!open || *open != definition->modules) {
      close();
      for (const std::string& module : definition->modules) text += "module " + module + " {\n";
      open = &definition->modules;
    }
    text += definition->text + "\n";
  }
  close();
  return text;
}

const Schema& get_schema() {
  static const Schema schema = parse_idl(get_idl_files());
  return schema;
}

std::string find_schema_text(const std::string& type_name) { return get_schema().find_text(type_name); }

}  // namespace hrp
