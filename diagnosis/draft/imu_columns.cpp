// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/draft/imu_columns.h"

#include <algorithm>
#include <initializer_list>
#include <map>

#include "common/base/has.h"
#include "diagnosis/draft/column_names.h"

namespace hrp::diagnosis {
namespace {

bool has_any(const std::vector<std::string>& words, std::initializer_list<const char*> names) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) { return has(names, word); });
}

// Of the words before the axis; "" for another quantity. A linear velocity or an acceleration of angles is none of
// them.
std::string find_quantity(const std::vector<std::string>& words) {
  if (has_any(words, {"cmd", "command", "target", "desired", "des", "ref", "error", "bias", "cov", "covariance"}))
    return "";
  const bool angular = has_any(words, {"ang", "angular"}),
             linear = has_any(words, {"acc", "accel", "acceleration", "accelerometer"});
  if (has_any(words, {"gyro", "gyr", "gyroscope", "omega", "angvel"}) ||
      (angular && has_any(words, {"vel", "velocity", "rate"})))
    return "angular_velocity";
  if (linear && !angular) return "linear_acceleration";
  if (has_any(words, {"quat", "quaternion", "orientation"})) return "orientation";
  return "";
}

// "ax", "gyro" in short "gx" or "wx": the letter of the quantity and the axis. Split in two, so that both are words.
std::vector<std::string> split_short(const std::vector<std::string>& words) {
  std::vector<std::string> out;
  for (const std::string& word : words) {
    const bool brief = word.size() == 2 && std::string("xyz").find(word[1]) != std::string::npos;
    const char* quantity = !brief ? "" : word[0] == 'a' ? "acc" : word[0] == 'g' || word[0] == 'w' ? "gyro" : "";
    if (*quantity)
      out.insert(out.end(), {quantity, std::string(1, word[1])});
    else
      out.push_back(word);
  }
  return out;
}

}  // namespace

std::vector<ImuColumn> find_imu_columns(const std::vector<std::string>& columns) {
  // By quantity and the words before the axis, in the order of the file: axis and column.
  struct Group {
    std::string quantity, before;
    std::map<std::string, size_t> axes;
  };
  std::vector<Group> groups;
  for (size_t i = 0; i < columns.size(); ++i) {
    const std::vector<std::string> words = split_short(split_words(columns[i]));
    // "linear_acceleration.x [m/s^2]": what follows the axis is a unit.
    const auto axis = std::find_if(words.begin(), words.end(),
                                   [](const std::string& w) { return w == "x" || w == "y" || w == "z" || w == "w"; });
    if (axis == words.end()) continue;
    std::string before;
    for (auto word = words.begin(); word != axis; ++word) before += *word + " ";
    const std::string quantity = find_quantity({words.begin(), axis});
    if (quantity.empty()) continue;
    auto group = std::find_if(groups.begin(), groups.end(),
                              [&](const Group& g) { return g.quantity == quantity && g.before == before; });
    if (group == groups.end()) group = groups.insert(groups.end(), {quantity, before, {}});
    group->axes.emplace(*axis, i);
  }
  std::vector<ImuColumn> found;
  for (const char* quantity : {"angular_velocity", "linear_acceleration", "orientation"}) {
    const size_t axes = std::string(quantity) == "orientation" ? 4 : 3;
    if (axes == 4 && found.empty()) break;  // a pose alone is no sensor of motion
    const auto whole = std::find_if(groups.begin(), groups.end(),
                                    [&](const Group& g) { return g.quantity == quantity && g.axes.size() == axes; });
    if (whole == groups.end()) continue;
    for (const auto& [axis, column] : whole->axes) found.push_back({column, std::string(quantity) + "/" + axis});
  }
  return found;
}

}  // namespace hrp::diagnosis
