// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/sides.h"

#include <algorithm>

namespace hrp::diagnosis::floating {
namespace {

// The sensor of the foot of that name that has the same axes; -1: none.
int find_sensor(const LeggedLog& log, const std::string& foot, const ForceSensor& like) {
  for (const Foot& f : log.feet) {
    if (f.name != foot || f.sensor < 0) continue;
    const ForceSensor& s = log.sensors[static_cast<size_t>(f.sensor)];
    if (s.world == like.world && std::equal(std::begin(s.axis), std::end(s.axis), std::begin(like.axis)))
      return f.sensor;
  }
  return -1;
}

}  // namespace

std::vector<std::string> list_right_names(const std::string& left) {
  const std::pair<const char*, const char*> sides[] = {
      {"left", "right"}, {"Left", "Right"}, {"LEFT", "RIGHT"}, {"l", "r"}, {"L", "R"}};
  std::vector<std::string> out;
  for (const auto& [from, to] : sides) {
    for (size_t at = left.find(from); at != std::string::npos; at = left.find(from, at + 1))
      out.push_back(left.substr(0, at) + to + left.substr(at + std::string(from).size()));
  }
  return out;
}

std::set<int> list_leg_joints(const LeggedLog& log) {
  std::set<int> joints;
  for (const Foot& foot : log.feet) {
    for (int link = foot.link; link > 0; link = log.tree.links[static_cast<size_t>(link)].parent)
      joints.insert(link - 1);
  }
  return joints;
}

SidePairs list_leg_pairs(const LeggedLog& log) {
  const std::set<int> moving = list_leg_joints(log);
  SidePairs out;
  for (int j : moving) {
    for (const std::string& name : list_right_names(log.tree.joint(j).name)) {
      const int other = log.tree.find_joint(name);
      if (other >= 0 && moving.count(other) > 0) out.emplace_back(static_cast<size_t>(j), static_cast<size_t>(other));
    }
  }
  return out;
}

SidePairs list_sensor_pairs(const LeggedLog& log) {
  SidePairs out;
  for (const Foot& foot : log.feet) {
    if (foot.sensor < 0) continue;
    for (const std::string& name : list_right_names(foot.name)) {
      const int other = find_sensor(log, name, log.sensors[static_cast<size_t>(foot.sensor)]);
      if (other >= 0) out.emplace_back(static_cast<size_t>(foot.sensor), static_cast<size_t>(other));
    }
  }
  return out;
}

LeggedLog exchange_legs(LeggedLog log, const SidePairs& joints) {
  for (Clip& clip : log.clips) {
    for (const auto& [a, b] : joints) std::swap(clip.position[a], clip.position[b]);
  }
  return log;
}

LeggedLog exchange_feet(LeggedLog log, const SidePairs& sensors) {
  for (Clip& clip : log.clips) {
    for (const auto& [a, b] : sensors)
      std::swap_ranges(clip.force.begin() + 6 * static_cast<long>(a), clip.force.begin() + 6 * static_cast<long>(a) + 6,
                       clip.force.begin() + 6 * static_cast<long>(b));
  }
  return log;
}

}  // namespace hrp::diagnosis::floating
