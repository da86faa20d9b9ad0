// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/body_channels.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "common/effects/units.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/equations/joint_turns.h"
#include "diagnosis/floating/equations/leg_forces.h"
#include "diagnosis/floating/fit/candidates.h"

namespace hrp::diagnosis::floating {
namespace {

bool is_at(const LeggedLog& log, int from, int link) { return is_above(log.tree, from, link); }

std::vector<int> list_link_columns(const LeggedLog& log, const ColumnLayout& layout, int from) {
  std::vector<int> out;
  for (int l = 0; l < layout.links; ++l) {
    for (int p = 0; is_at(log, from, l) && p < kInertialParameters; ++p) out.push_back(layout.link(l, p));
  }
  return out;
}

void add_sensor_columns(const LeggedLog& log, const ColumnLayout& layout, int from, std::vector<int>* out) {
  for (int s = 0; s < layout.sensors; ++s) {
    const ForceSensor& sensor = log.sensors[static_cast<size_t>(s)];
    if (!is_at(log, from, sensor.link) || (from > 0 && !is_whole(log, sensor))) continue;
    for (int c = 0; c < kSensorColumns; ++c) out->push_back(layout.sensor(s, c));
  }
}

void add_imu_columns(const LeggedLog& log, const ColumnLayout& layout, std::vector<int>* out) {
  const int imu = BodyMotion::find_main_imu(log);
  for (int c = 0; uses_accelerometer(log) && c < kGyroScaleColumn; ++c) out->push_back(layout.imu(imu, c));
  for (int c = kGyroScaleColumn; uses_gyroscope(log) && c < kAttitudeTurnColumn; ++c)
    out->push_back(layout.imu(imu, c));
}

void add_pull_columns(const LeggedLog& log, const ColumnLayout& layout, const std::vector<int>& pulled, int from,
                      std::vector<int>* out) {
  for (int l : pulled) {
    for (int c = 0; is_at(log, from, l) && c < kPullColumns; ++c) out->push_back(layout.pull(l, c));
  }
  for (int f = 0; f < layout.feet; ++f) {
    const int link = log.feet[static_cast<size_t>(f)].link;
    for (int c = 0; is_at(log, from, link) && c < kHolds; ++c) out->push_back(layout.foot(f, kHoldColumn + c));
  }
}

// Columns that may change the equation of a link and of all that hangs on it.
std::vector<int> list_columns(const LeggedLog& log, const ColumnLayout& layout, const std::vector<int>& pulled,
                              int from) {
  std::vector<int> out = list_link_columns(log, layout, from);
  add_sensor_columns(log, layout, from, &out);
  add_imu_columns(log, layout, &out);
  const std::vector<int> turns = list_turn_columns(log, layout);
  out.insert(out.end(), turns.begin(), turns.end());
  add_pull_columns(log, layout, pulled, from, &out);
  return out;
}

// Whether the acceleration of the base is known all the time: whatever hangs on the base feels it.
bool is_motion_known(const LeggedLog& log, const Contacts& contacts) {
  const MotionSource source = BodyMotion::find_force_source(log);
  return source != MotionSource::kNone && (source != MotionSource::kFoot || !contacts.walks);
}

bool has_force(const LeggedLog& log, const Foot& foot) {
  return foot.sensor >= 0 && log.sensors[static_cast<size_t>(foot.sensor)].has_force();
}

// Forces balance without the moments, which the sensor of a flat foot may not tell.
void add_balance(const LeggedLog& log, const std::vector<int>& columns, BodyChannels* channels, RowTable* table) {
  const bool moments = std::all_of(log.feet.begin(), log.feet.end(), [&](const Foot& f) { return is_known(log, f); });
  channels->balances = true;
  for (int i = moments ? 0 : 3; i < 6; ++i) {
    const std::string signal = "/wrench/" + log.sensors[0].name + "/" + (i < 3 ? "torque" : "force");
    channels->row[static_cast<size_t>(i)] =
        table->add_channel({{i < 3 ? EquationKind::kMoment : EquationKind::kForce, i % 3},
                            signal,
                            i < 3 ? "N m" : "N",
                            "link",
                            log.tree.links[0].name},
                           columns);
  }
}

// Columns of a joint's drive, as far as its torque tells them.
void add_drive_columns(const ColumnLayout& layout, int j, std::vector<int>* out) {
  for (int c = 0; c < kOffsetColumn; ++c) out->push_back(layout.joint(j, c));
}

// Where no foot has a force sensor: forces by the legs' torques.
void add_balance_by_legs(const LeggedLog& log, const ColumnLayout& layout, std::vector<int> columns,
                         BodyChannels* channels, RowTable* table) {
  channels->legs = list_legs_that_tell(log);
  if (channels->legs.empty()) return;
  channels->balances = true;
  for (size_t j = 0; j < channels->legs.size(); ++j) {
    if (channels->legs[j]) add_drive_columns(layout, static_cast<int>(j), &columns);
  }
  for (int i = 0; i < 6; ++i) {
    const EquationKind kind = i < 3 ? EquationKind::kLegMoment : EquationKind::kLegForce;
    channels->row[static_cast<size_t>(i)] = table->add_channel(
        {{kind, i % 3}, "/joint_states", i < 3 ? "N m" : "N", "link", log.tree.links[0].name}, columns);
  }
}

void add_body(const LeggedLog& log, const Contacts& contacts, const ColumnLayout& layout, BodyChannels* channels,
              RowTable* table) {
  if (log.feet.empty() || !log.tree.floating_base) return;
  const bool forces = std::all_of(log.feet.begin(), log.feet.end(), [&](const Foot& f) { return has_force(log, f); });
  const bool vertical = has(channels->felt, 1);
  const bool moves = is_motion_known(log, contacts);
  const std::vector<int> columns = list_columns(log, layout, channels->pulled, 0);
  if (forces && moves) return add_balance(log, columns, channels, table);
  if (!vertical && is_base_felt(log, contacts)) return add_balance_by_legs(log, layout, columns, channels, table);
  // A foot that stands tells the base's motion well enough for a weight, in walking, too.
  const MotionSource source = BodyMotion::find_force_source(log);
  if (!vertical || !(forces ? source == MotionSource::kFoot : source != MotionSource::kNone)) return;
  channels->weighs = true;
  channels->row[kWeightRow] = table->add_channel(
      {EquationKind::kWeight, "/wrench/" + log.sensors[0].name + "/force", "N", "link", log.tree.links[0].name},
      columns);
}

bool is_compared(const LeggedLog& log, const Contacts& contacts, int j) {
  const auto i = static_cast<size_t>(j);
  const bool driven = log.is_driven(i) && log.tree.joint(j).actuated;
  const bool passive = !log.tree.joint(j).actuated && log.has_position[i];
  return (driven || passive) && is_base_felt(log, contacts);
}

void add_joint(const LeggedLog& log, const Contacts& contacts, const ColumnLayout& layout, int j,
               BodyChannels* channels, RowTable* table) {
  const auto i = static_cast<size_t>(j);
  const JointSpec& joint = log.tree.joint(j);
  const std::string signal = "/joint_states/" + joint.name + "/effort";
  const std::string unit = get_joint_unit(joint, "N m");
  if (is_compared(log, contacts, j)) {
    std::vector<int> columns = list_columns(log, layout, channels->pulled, j + 1);
    add_drive_columns(layout, j, &columns);
    if (!log.has_effort[i]) columns.push_back(layout.joint(j, kDelayColumn));
    channels->row[size_t{kJointRow} + static_cast<size_t>(j)] =
        table->add_channel({EquationKind::kJoint, signal, unit, "joint", joint.name}, columns);
  }
  if (log.has_effort[i] && log.has_law[i] && joint.actuated) {
    channels->servo[i] = table->add_channel({EquationKind::kServo, signal, unit, "joint", joint.name},
                                            {layout.joint(j, kDelayColumn), layout.joint(j, kEffortScaleColumn)});
  }
}

// Whether a foot's sensor feels more than the air.
bool touches(const BodySample& at, const Contacts& contacts, size_t foot, size_t k) {
  const int sensor = at.log.feet[foot].sensor;
  if (sensor < 0 || !contacts.levels[static_cast<size_t>(sensor)].swings) return false;
  const ForceLevels& level = contacts.levels[static_cast<size_t>(sensor)];
  const double force = calc_vertical_force(at.log, at.clip, static_cast<size_t>(sensor), k);
  // A foot that scrapes along the ground reads more.
  return std::abs(force - level.air) > kKnown * (level.stance - level.air);
}

// Samples as far before and after as the smoothing reaches: a foot that lands or lifts pushes before it counts as
// loaded.
std::pair<size_t, size_t> find_reach(const BodySample& at) {
  const size_t reach = at.clip.edge;
  return {at.k > reach ? at.k - reach : 0, std::min(at.k + reach, at.clip.size() - 1)};
}

}  // namespace

BodyChannels add_body_channels(const LeggedLog& log, const Contacts& contacts, const ColumnLayout& layout,
                               RowTable* table) {
  BodyChannels out;
  out.row.assign(size_t{kJointRow} + static_cast<size_t>(layout.joints), -1);
  out.servo.assign(static_cast<size_t>(layout.joints), -1);
  out.pulled = list_pulled_links(log);
  for (const Foot& foot : log.feet) {
    out.felt.push_back(foot.sensor >= 0 && log.sensors[static_cast<size_t>(foot.sensor)].axis[2]);
  }
  add_body(log, contacts, layout, &out, table);
  for (int j = 0; j < layout.joints; ++j) add_joint(log, contacts, layout, j, &out, table);
  return out;
}

bool is_base_felt(const LeggedLog& log, const Contacts& contacts) {
  const bool blurred = contacts.walks && BodyMotion::find_force_source(log) == MotionSource::kPose;
  return is_motion_known(log, contacts) && !blurred;
}

bool uses_accelerometer(const LeggedLog& log) { return BodyMotion::find_force_source(log) == MotionSource::kImu; }
bool uses_gyroscope(const LeggedLog& log) { return BodyMotion::find_rate_source(log) == MotionSource::kImu; }

bool is_weight_known(const BodySample& at, const Contacts& contacts, const BodyChannels& channels) {
  const auto [before, after] = find_reach(at);
  for (size_t f = 0; f < channels.felt.size(); ++f) {
    const std::vector<char>& loaded = contacts.loaded[at.clip_index][f];
    if (!channels.felt[f] && (loaded[before] || loaded[at.k] || loaded[after])) return false;
  }
  return true;
}

bool is_joint_known(const BodySample& at, const Contacts& contacts, int j) {
  const auto [before, after] = find_reach(at);
  const std::vector<std::string>& unknown = at.log.experiment->recordings[at.clip.recording].spec.unknown_force;
  const auto is_unknown = [&](const std::string& name) { return has(unknown, name); };
  for (size_t f = 0; f < at.log.feet.size(); ++f) {
    const Foot& foot = at.log.feet[f];
    if (!is_above(at.log.tree, j + 1, foot.link)) continue;
    if (is_unknown(foot.name)) return false;
    if (is_known(at.log, foot)) continue;
    const std::vector<char>& loaded = contacts.loaded[at.clip_index][f];
    if (loaded[before] || loaded[at.k] || loaded[after]) return false;
    if (touches(at, contacts, f, before) || touches(at, contacts, f, at.k) || touches(at, contacts, f, after))
      return false;
  }
  return !is_unknown(at.log.tree.joint(j).name);
}

}  // namespace hrp::diagnosis::floating
