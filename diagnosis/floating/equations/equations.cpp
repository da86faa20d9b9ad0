// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/equations.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/slopes.h"
#include "diagnosis/floating/equations/body_rows.h"
#include "diagnosis/floating/equations/foot_rows.h"
#include "diagnosis/floating/equations/imu_rows.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kSpacing = 0.008;  // [s] between the samples of a cell: the kernel passes nothing that is finer
constexpr double kSlowest = 0.004;  // share of a joint's largest speed above which dry friction has its full size

// [rad/s] Speed above which dry friction has its full size, by joint.
std::vector<double> find_slow_speeds(const LeggedLog& log) {
  std::vector<double> slow(static_cast<size_t>(log.num_joints()), 1e-6);
  for (const Clip& clip : log.clips) {
    for (size_t j = 0; j < slow.size(); ++j) {
      if (clip.position[j].empty()) continue;
      for (size_t k = clip.edge; k + clip.edge < clip.size(); ++k) {
        slow[j] = std::max(slow[j], kSlowest * std::abs(clip.position[j].rate[k]));
      }
    }
  }
  return slow;
}

// Direction of motion by joint and sample, -1 to 1, smoothed as the torque that it causes is.
std::vector<std::vector<double>> find_ways(const Clip& clip, const std::vector<double>& slow) {
  std::vector<std::vector<double>> ways(slow.size());
  for (size_t j = 0; j < slow.size(); ++j) {
    for (double v : clip.position[j].rate) ways[j].push_back(std::tanh(v / slow[j]));
    ways[j] = smooth_evenly(ways[j], clip.step, clip.sigma);
  }
  return ways;
}

// Each joint is turned once for all rows: what the motion is then takes most of the time.
void add_turns(const BodyEquations& equations, const std::vector<JointSides>& sides, BodyRows* rows, FootRows* feet) {
  BodyMotion& motion = rows->at().motion;
  const size_t k = rows->at().k;
  for (const JointTurn& turn : list_turns(equations.log, equations.layout, sides)) {
    motion.turn_joint(turn.joint, turn.axis, kSlopeStep);
    motion.update(k);
    add_turn_columns(turn, rows);
    feet->add_turn(turn, &motion);
    motion.turn_joint(turn.joint, turn.axis, 0);
  }
  motion.update(k);
}

void add_body_rows(const BodySample& at, BodyEquations* equations, FootRows* feet) {
  BodyRows rows(*equations, at);
  const std::vector<JointSides> sides = find_sides(at, rows.nominal().load);
  feet->add(at.clip_index, at.k, &at.motion);
  add_link_columns(equations, &rows);
  add_pull_columns(*equations, &rows);
  add_drive_columns(*equations, &rows);
  add_force_sensor_columns(*equations, &rows);
  if (uses_accelerometer(at.log)) add_accelerometer_columns(*equations, &rows);
  add_servo_rows(*equations, at);
  add_turns(*equations, sides, &rows, feet);
  if (uses_gyroscope(at.log)) add_gyroscope_columns(*equations, &rows);
}

// Samples of a clip in cells: each cell is a row of every equation that holds there.
struct Cells {
  size_t stride = 1, count = 1;  // samples from one to the next, and in a cell
  explicit Cells(const Clip& clip)
      : stride(static_cast<size_t>(std::max(1L, std::lround(kSpacing / clip.step)))),
        count(static_cast<size_t>(std::max(1L, std::lround(kCell / (clip.step * static_cast<double>(stride)))))) {}
  size_t length() const { return count * stride; }
};

RowTable::Cell make_cell(const Clip& clip, const Cells& cells, size_t begin, int block, int phase) {
  double rough = 0;
  for (size_t i = 0; i < cells.count; ++i) rough += std::pow(clip.roughness[begin + i * cells.stride], 2);
  return {clip.time[begin + cells.length() / 2], static_cast<int>(clip.recording),        block, phase, clip.train,
          static_cast<int>(cells.count),         rough / static_cast<double>(cells.count)};
}

// Adds a clip's rows. `block`: the first number that is free; blocks are numbered over all clips.
void add_clip(size_t c, BodyEquations* equations, FootRows* feet, ImuRows* imus, int* block) {
  const Clip& clip = equations->log.clips[c];
  const Cells cells(clip);
  BodyMotion motion(equations->log, clip);
  double block_end = clip.time[clip.edge] + kBlock;
  for (size_t begin = clip.edge; begin + clip.edge + cells.length() < clip.size(); begin += cells.length()) {
    if (clip.time[begin] > block_end) {
      ++*block;
      block_end += kBlock;
    }
    equations->table.begin_cell(make_cell(clip, cells, begin, *block, equations->contacts.find_phase(c, begin)));
    for (size_t i = 0; i < cells.count; ++i) {
      const size_t k = begin + i * cells.stride;
      if (!motion.update(k)) continue;
      imus->add(c, k, &motion);
      add_body_rows({equations->log, clip, c, k, motion}, equations, feet);
    }
    equations->table.end_cell();
  }
  ++*block;
}

}  // namespace

RowTable make_equations(const LeggedLog& log, const Contacts& contacts) {
  const ColumnLayout layout(log);
  RowTable table(layout.count());
  const std::vector<double> slow = find_slow_speeds(log);
  const BodyChannels channels = add_body_channels(log, contacts, layout, &table);
  BodyEquations equations{log, contacts, layout, channels, table, nullptr, {}};
  FootRows feet(log, contacts, layout, &table);
  ImuRows imus(log, contacts, layout, &table);
  int block = 0;
  for (size_t c = 0; c < log.clips.size(); ++c) {
    equations.ways = find_ways(log.clips[c], slow);
    add_clip(c, &equations, &feet, &imus, &block);
  }
  table.finish();
  return table;
}

}  // namespace hrp::diagnosis::floating
