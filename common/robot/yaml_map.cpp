// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/yaml_map.h"

#include <cmath>
#include <limits>

#include "common/base/join_words.h"
#include "common/base/suggest.h"

namespace hrp {
namespace {

// The value as the user wrote it, short enough for a message.
std::string describe(const YAML::Node& node) {
  if (!node.IsDefined() || node.IsNull()) return "empty";
  if (node.IsSequence()) return "a list of " + std::to_string(node.size());
  if (node.IsMap()) return "a mapping";
  std::string text = node.Scalar();
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return "'" + text + "'";
}

std::string describe_bound(Bound bound) {
  switch (bound) {
    case Bound::kAny: return "a finite number";
    case Bound::kNotNegative: return "a finite number >= 0";
    case Bound::kPositive: return "a finite number > 0";
    case Bound::kNotNegativeOrInfinite: return "a number >= 0 (.inf for no limit)";
    case Bound::kUnitInterval: return "a number from 0 to 1";
    case Bound::kOneToTen: return "a number from 1 to 10";
  }
  return "a number";
}

bool is_within(double value, Bound bound) {
  if (std::isnan(value)) return false;
  if (bound == Bound::kNotNegativeOrInfinite) return value >= 0.0 && (std::isinf(value) || value <= kLargestNumber);
  if (!(std::abs(value) <= kLargestNumber)) return false;
  switch (bound) {
    case Bound::kNotNegative: return value >= 0.0;
    case Bound::kPositive: return value > 0.0;
    case Bound::kUnitInterval: return value >= 0.0 && value <= 1.0;
    case Bound::kOneToTen: return value >= 1.0 && value <= 10.0;
    default: return true;
  }
}

std::string unit_text(const std::string& unit) { return unit.empty() ? "" : " [" + unit + "]"; }

}  // namespace

InputPlace make_place(const std::string& file, const YAML::Mark& mark, const std::string& field) {
  return mark.is_null() ? InputPlace(file, field) : InputPlace(file, field, mark.line + 1, mark.column + 1);
}

InputPlace make_place(const std::string& file, const YAML::Node& node, const std::string& field) {
  return make_place(file, node.IsDefined() ? node.Mark() : YAML::Mark::null_mark(), field);
}

YamlMap::YamlMap(const YAML::Node& node, std::string path, YamlContext* context)
    : node_(node), path_(std::move(path)), context_(context) {
  if (!node.IsDefined() || node.IsNull()) return;  // an empty section: all defaults
  if (!node.IsMap()) {
    complain(node, path_, "is " + describe(node) + ", expected a mapping (key: value)");
    return;
  }
  for (const auto& item : node) {
    if (!item.first.IsScalar()) {
      complain(item.first, path_, "has a key that is " + describe(item.first) + ", expected a word");
      continue;
    }
    const std::string key = item.first.Scalar();
    if (nodes_.count(key) > 0) {
      complain(item.first, path_of(key), "is given twice; keep one");
      continue;
    }
    keys_.push_back(key);
    nodes_.emplace(key, item.second);
    key_nodes_.emplace(key, item.first);
  }
}

bool YamlMap::has(const std::string& key) const { return nodes_.count(key) > 0; }

bool YamlMap::is_mapping(const std::string& key) const { return has(key) && nodes_.at(key).IsMap(); }

YAML::Node YamlMap::find(const std::string& key) {
  asked_.insert(key);
  const auto it = nodes_.find(key);
  if (it == nodes_.end()) return YAML::Node(YAML::NodeType::Undefined);
  const YAML::Mark mark = it->second.Mark();
  if (context_->marks != nullptr && !mark.is_null()) {
    (*context_->marks)[path_of(key)] = {mark.line + 1, mark.column + 1};
  }
  return it->second;
}

void YamlMap::complain(const YAML::Node& node, const std::string& path, const std::string& message) {
  YAML::Mark mark = node.IsDefined() ? node.Mark() : YAML::Mark::null_mark();
  if (mark.is_null() && node_.IsDefined()) mark = node_.Mark();
  context_->diagnostics->add_error(make_place(context_->file, mark, path), message);
}

void YamlMap::error(const std::string& key, const std::string& message) {
  const auto it = nodes_.find(key);
  complain(it == nodes_.end() ? node_ : it->second, key.empty() ? path_ : path_of(key), message);
}

bool YamlMap::decode_number(const YAML::Node& node, const std::string& path, Bound bound, const std::string& unit,
                            double* value) {
  double decoded = 0.0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, decoded) || !is_within(decoded, bound)) {
    const bool large = std::isfinite(decoded) && std::abs(decoded) > kLargestNumber;
    complain(node, path,
             "is " + describe(node) + ", expected " + describe_bound(bound) + unit_text(unit) +
                 (large ? " of at most 1e12 either way" : ""));
    return false;
  }
  *value = decoded;
  return true;
}

bool YamlMap::decode_list(const YAML::Node& node, const std::string& path, Bound bound, const std::string& unit,
                          size_t count, double* values) {
  if (!node.IsSequence() || node.size() != count) {
    complain(node, path,
             "is " + describe(node) + ", expected a list of " + std::to_string(count) + " numbers" + unit_text(unit));
    return false;
  }
  bool good = true;
  for (size_t i = 0; i < count; ++i) {
    const std::string element = path + "[" + std::to_string(i) + "]";
    good = decode_number(node[i], element, bound, unit, &values[i]) && good;
  }
  return good;
}

bool YamlMap::decode_three(const YAML::Node& node, const std::string& path, Bound bound, const std::string& unit,
                           Vector3d* value) {
  Vector3d decoded;
  const bool good = decode_list(node, path, bound, unit, 3, decoded.data());
  if (good) *value = decoded;
  return good;
}

bool YamlMap::decode_text(const YAML::Node& node, const std::string& path, std::string* value) {
  if (!node.IsScalar() || node.Scalar().empty()) {
    complain(node, path, "is " + describe(node) + ", expected a word");
    return false;
  }
  *value = node.Scalar();
  return true;
}

void YamlMap::number(const std::string& key, double* value, Bound bound, const std::string& unit) {
  const YAML::Node node = find(key);
  if (node.IsDefined()) decode_number(node, path_of(key), bound, unit, value);
}

void YamlMap::integer(const std::string& key, unsigned long long* value) {
  const YAML::Node node = find(key);
  if (!node.IsDefined()) return;
  const bool digits = node.IsScalar() && !node.Scalar().empty() && node.Scalar().size() <= 18 &&
                      node.Scalar().find_first_not_of("0123456789") == std::string::npos;
  if (!digits) return complain(node, path_of(key), "is " + describe(node) + ", expected a whole number >= 0");
  *value = std::stoull(node.Scalar());
}

void YamlMap::flag(const std::string& key, bool* value) {
  const YAML::Node node = find(key);
  if (!node.IsDefined()) return;
  if (!node.IsScalar() || !YAML::convert<bool>::decode(node, *value)) {
    complain(node, path_of(key), "is " + describe(node) + ", expected true or false");
  }
}

void YamlMap::text(const std::string& key, std::string* value) {
  const YAML::Node node = find(key);
  if (node.IsDefined()) decode_text(node, path_of(key), value);
}

void YamlMap::choice(const std::string& key, std::string* value, const std::vector<std::string>& choices) {
  const YAML::Node node = find(key);
  std::string word;
  if (!node.IsDefined() || !decode_text(node, path_of(key), &word)) return;
  for (const std::string& candidate : choices) {
    if (candidate == word) {
      *value = word;
      return;
    }
  }
  complain(node, path_of(key), "is '" + word + "', expected one of " + join_words(choices) + suggest(word, choices));
}

void YamlMap::vector3(const std::string& key, Vector3d* value, Bound bound, const std::string& unit) {
  const YAML::Node node = find(key);
  if (node.IsDefined()) decode_three(node, path_of(key), bound, unit, value);
}

void YamlMap::axes3(const std::string& key, Vector3d* value, Bound bound, const std::string& unit) {
  const YAML::Node node = find(key);
  if (!node.IsDefined()) return;
  if (!node.IsScalar()) {
    decode_three(node, path_of(key), bound, unit, value);
    return;
  }
  double all = 0.0;
  if (decode_number(node, path_of(key), bound, unit, &all)) *value = Vector3d::Constant(all);
}

void YamlMap::interval(const std::string& key, double* first, double* last, Bound bound, const std::string& unit) {
  const YAML::Node node = find(key);
  double ends[2];
  if (!node.IsDefined() || !decode_list(node, path_of(key), bound, unit, 2, ends)) return;
  if (ends[0] > ends[1]) return complain(node, path_of(key), "falls, expected the smaller number first");
  *first = ends[0];
  *last = ends[1];
}

void YamlMap::names(const std::string& key, std::vector<std::string>* value) {
  const YAML::Node node = find(key);
  if (!node.IsDefined() || node.IsNull()) return;
  if (!node.IsSequence()) return complain(node, path_of(key), "is " + describe(node) + ", expected a list of names");
  std::vector<std::string> decoded;
  std::set<std::string> seen;
  for (size_t i = 0; i < node.size(); ++i) {
    const std::string element = path_of(key) + "[" + std::to_string(i) + "]";
    std::string name;
    if (!decode_text(node[i], element, &name)) continue;
    if (!seen.insert(name).second) {
      complain(node[i], element, "is '" + name + "', which stands in the list already");
      continue;
    }
    const YAML::Mark mark = node[i].Mark();
    if (context_->marks != nullptr && !mark.is_null()) (*context_->marks)[element] = {mark.line + 1, mark.column + 1};
    decoded.push_back(name);
  }
  *value = decoded;
}

void YamlMap::numbers_by_name(const std::string& key, std::map<std::string, double>* value, Bound bound,
                              const std::string& unit) {
  child(key, [&](YamlMap& map) {
    for (const std::string& name : map.keys_) {
      double decoded = 0.0;
      const YAML::Node node = map.find(name);
      if (map.decode_number(node, map.path_of(name), bound, unit, &decoded)) (*value)[name] = decoded;
    }
  });
}

void YamlMap::names_by_name(const std::string& key, std::map<std::string, std::vector<std::string>>* value) {
  child(key, [&](YamlMap& map) {
    for (const std::string& name : map.keys_) map.names(name, &(*value)[name]);
  });
}

void YamlMap::child(const std::string& key, const std::function<void(YamlMap&)>& read) {
  const YAML::Node node = find(key);
  if (!node.IsDefined()) return;
  YamlMap map(node, path_of(key), context_);
  read(map);
  map.finish();
}

void YamlMap::children(const std::string& key, const std::function<void(const std::string&, YamlMap&)>& read) {
  child(key, [&](YamlMap& map) { map.each(read); });
}

void YamlMap::each(const std::function<void(const std::string&, YamlMap&)>& read) {
  for (const std::string& name : keys_) {
    if (asked_.count(name) == 0) child(name, [&](YamlMap& map) { read(name, map); });
  }
}

void YamlMap::list(const std::string& key, const std::function<void(size_t, YamlMap&)>& read) {
  const YAML::Node node = find(key);
  if (!node.IsDefined()) return;
  if (!node.IsSequence()) return complain(node, path_of(key), "is " + describe(node) + ", expected a list");
  for (size_t i = 0; i < node.size(); ++i) {
    YamlMap map(node[i], path_of(key) + "[" + std::to_string(i) + "]", context_);
    read(i, map);
    map.finish();
  }
}

void YamlMap::mark_as(const std::string& path) {
  const YAML::Mark mark = node_.IsDefined() ? node_.Mark() : YAML::Mark::null_mark();
  if (context_->marks != nullptr && !mark.is_null()) (*context_->marks)[path] = {mark.line + 1, mark.column + 1};
}

void YamlMap::ignore(const std::string& key) { asked_.insert(key); }

void YamlMap::require(const std::string& key, const std::string& expected) {
  asked_.insert(key);
  if (!has(key)) complain(node_, path_of(key), "is missing, expected " + expected);
}

void YamlMap::finish() {
  const std::vector<std::string> known(asked_.begin(), asked_.end());
  for (const std::string& key : keys_) {
    if (asked_.count(key) > 0) continue;
    complain(key_nodes_.at(key), path_of(key),
             "unknown key" + suggest(key, known, "; known here: " + join_words(known)));
  }
}

}  // namespace hrp
