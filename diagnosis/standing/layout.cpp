// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/layout.h"

#include <algorithm>

#include "common/base/check.h"

namespace hrp::diagnosis::standing {
namespace {

size_t count_flat(const StandProblem& p) {
  return static_cast<size_t>(
      std::count_if(p.feet.begin(), p.feet.end(), [](const StandFoot& f) { return f.kind == SoleKind::kFlat; }));
}

}  // namespace

std::string get_text(ChannelKind kind) {
  switch (kind) {
    case ChannelKind::kTilt: return "tilt";
    case ChannelKind::kStand: return "stand";
    case ChannelKind::kGap: return "gap";
    case ChannelKind::kBalance: return "balance";
    case ChannelKind::kBase: return "base";
    case ChannelKind::kEffort: return "effort";
    case ChannelKind::kServo: return "servo";
    case ChannelKind::kVelocity: return "velocity";
    case ChannelKind::kGyro: return "gyro";
    case ChannelKind::kGravity: return "gravity";
  }
  HRP_CHECK(false, "a channel has a kind");
  return "";
}

size_t find_places(const StandProblem& p) { return 2 * count_flat(p); }
size_t count_places(const StandProblem& p) { return 3 * (p.feet.size() - (p.base_pose ? 0 : 1)); }
size_t find_drives(const StandProblem& p) {
  return find_places(p) + count_places(p) + 6 + (p.base_pose && p.attitude ? 3 : 0);
}

size_t count_drive_channels(const StandProblem& p, size_t j) {
  return (p.is_driven(j) ? 1 : 0) + (p.effort[j] && p.command[j] ? 1 : 0) + (p.velocity[j] ? 1 : 0);
}

size_t find_drive(const StandProblem& p, size_t joint) {
  size_t first = find_drives(p);
  for (size_t j = 0; j < joint; ++j) first += count_drive_channels(p, j);
  return first;
}

std::vector<Channel> list_channels(const StandProblem& p) {
  std::vector<Channel> out;
  const std::string imu = "/imu/" + p.imu, attitude = imu + "/orientation", base = p.tree.links[0].name;
  for (const StandFoot& foot : p.feet) {
    if (foot.kind != SoleKind::kFlat) continue;
    for (int i = 0; i < 2; ++i) out.push_back({ChannelKind::kTilt, attitude, "", foot.name, "", ""});
  }
  const auto add3 = [&](const Channel& channel) { out.insert(out.end(), 3, channel); };
  if (p.base_pose) add3({ChannelKind::kStand, "/base/pose/position", "", p.feet[0].name, "", ""});
  for (size_t f = 1; f < p.feet.size(); ++f) add3({ChannelKind::kGap, attitude, "", p.feet[f].name, "", ""});
  add3({ChannelKind::kBalance, "/wrench/" + p.feet[0].sensor + "/torque", "", "", "", base});
  add3({ChannelKind::kBalance, "/wrench/" + p.feet[0].sensor + "/force", "", "", "", base});
  if (p.base_pose && p.attitude) add3({ChannelKind::kBase, "/base/pose/orientation", "", "", "", base});
  for (int j = 0; j < p.tree.num_joints(); ++j) {
    const auto i = static_cast<size_t>(j);
    const std::string name = p.tree.joint(j).name, signal = "/joint_states/" + name;
    const std::string effort = signal + (p.effort[i] ? "/effort" : "/position");
    if (p.is_driven(i)) out.push_back({ChannelKind::kEffort, effort, name, "", "", ""});
    if (p.effort[i] && p.command[i]) out.push_back({ChannelKind::kServo, effort, name, "", "", ""});
    if (p.velocity[i]) out.push_back({ChannelKind::kVelocity, signal + "/velocity", name, "", "", ""});
  }
  add3({ChannelKind::kGyro, imu + "/angular_velocity", "", "", imu, ""});
  add3({ChannelKind::kGravity, imu + "/linear_acceleration", "", "", imu, ""});
  return out;
}

}  // namespace hrp::diagnosis::standing
