// SPDX-License-Identifier: BSD-3-Clause
// Reading of YAML mappings that people wrote: every complaint has line, column, key path, value and what was expected.
// Private to common/robot: nothing else includes yaml-cpp.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "common/base/diagnostics.h"
#include "common/spatial/transform.h"

namespace hrp {

struct YamlContext {
  std::string file;
  Diagnostics* diagnostics = nullptr;
  std::map<std::string, std::pair<int, int>>* marks = nullptr;  // key path -> line, column of its value
};

// Where a node, or an error of yaml-cpp, stands.
InputPlace make_place(const std::string& file, const YAML::Mark& mark, const std::string& field = "");
InputPlace make_place(const std::string& file, const YAML::Node& node, const std::string& field = "");

// Numbers beyond this are no quantity of a robot in SI units; their squares and products still have to be finite.
constexpr double kLargestNumber = 1e12;

enum class Bound { kAny, kNotNegative, kPositive, kNotNegativeOrInfinite, kUnitInterval, kOneToTen };

// One mapping. Each read leaves its target alone when the key is absent. finish() names the keys nobody asked for.
class YamlMap {
 public:
  YamlMap(const YAML::Node& node, std::string path, YamlContext* context);

  bool has(const std::string& key) const;
  bool is_mapping(const std::string& key) const;
  void number(const std::string& key, double* value, Bound bound, const std::string& unit);
  void integer(const std::string& key, unsigned long long* value);
  void flag(const std::string& key, bool* value);
  void text(const std::string& key, std::string* value);
  void choice(const std::string& key, std::string* value, const std::vector<std::string>& choices);
  void vector3(const std::string& key, Vector3d* value, Bound bound, const std::string& unit);
  // Three numbers, or one for all three axes.
  void axes3(const std::string& key, Vector3d* value, Bound bound, const std::string& unit);
  // A list of two numbers, the second one not below the first.
  void interval(const std::string& key, double* first, double* last, Bound bound, const std::string& unit);
  void names(const std::string& key, std::vector<std::string>* value);
  void numbers_by_name(const std::string& key, std::map<std::string, double>* value, Bound bound,
                       const std::string& unit);
  void names_by_name(const std::string& key, std::map<std::string, std::vector<std::string>>* value);
  // Calls `read` with the mapping under `key`, if there, and finishes it.
  void child(const std::string& key, const std::function<void(YamlMap&)>& read);
  // Calls `read` for each named mapping under `key`, in the order of the file, and finishes each.
  void children(const std::string& key, const std::function<void(const std::string&, YamlMap&)>& read);
  // children() into a list of things that have a name.
  template <class T>
  void named(const std::string& key, std::vector<T>* list, void (*read)(YamlMap&, T*)) {
    children(key, [&](const std::string& name, YamlMap& map) {
      list->push_back({});
      list->back().name = name;
      read(map, &list->back());
    });
  }
  // Calls `read` for each mapping of the list under `key` with its index, and finishes each.
  void list(const std::string& key, const std::function<void(size_t, YamlMap&)>& read);
  // As children(), for this mapping's own keys that nobody has asked for yet.
  void each(const std::function<void(const std::string&, YamlMap&)>& read);
  // Later complaints about `path` point at this mapping.
  void mark_as(const std::string& path);
  // Accepts the key without reading it.
  void ignore(const std::string& key);
  void require(const std::string& key, const std::string& expected);
  void error(const std::string& key, const std::string& message);
  void finish();
  const std::string& path() const { return path_; }

 private:
  YAML::Node find(const std::string& key);
  std::string path_of(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  void complain(const YAML::Node& node, const std::string& path, const std::string& message);
  bool decode_number(const YAML::Node& node, const std::string& path, Bound bound, const std::string& unit,
                     double* value);
  bool decode_list(const YAML::Node& node, const std::string& path, Bound bound, const std::string& unit, size_t count,
                   double* values);
  bool decode_three(const YAML::Node& node, const std::string& path, Bound bound, const std::string& unit,
                    Vector3d* value);
  bool decode_text(const YAML::Node& node, const std::string& path, std::string* value);

  YAML::Node node_;
  std::string path_;
  YamlContext* context_;
  std::vector<std::string> keys_;  // in the order of the file
  std::map<std::string, YAML::Node> nodes_;
  std::map<std::string, YAML::Node> key_nodes_;
  std::set<std::string> asked_;
};

}  // namespace hrp
