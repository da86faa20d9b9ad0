// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/make_recording.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/base/diagnostics.h"
#include "common/base/format.h"
#include "common/base/join_words.h"
#include "common/base/rounding.h"
#include "common/base/suggest.h"
#include "diagnosis/data/gaps.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/data/range.h"
#include "diagnosis/data/smooth.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

// SI units. No sensor reads more, and its square stays finite.
constexpr double kLargestReading = 1e12;
constexpr double kShort = 0.5;  // [s] in which a joint hardly moves

// Stamps since 1970 (1.7e9 s) have a resolution of a quarter of a microsecond in a double, too coarse for second
// differences. They are converted to whole microseconds since the recording's first whole second.
void shift_epoch(Recording* recording, std::vector<std::string>* warnings) {
  const double origin = std::floor(recording->time.front());
  if (std::abs(origin) < 1e6) return;
  for (double& t : recording->time) t = 1e-6 * std::round(1e6 * (t - origin));
  warnings->push_back(format("%s: its times are said from %.0f s on", recording->spec.name.c_str(), origin));
}

// Indices of the rows with increasing stamps. `repeated` counts rows with a repeated stamp.
std::vector<size_t> find_rows(const Table& table, int column, size_t* repeated) {
  const std::vector<double>& t = table.columns[static_cast<size_t>(column)];
  std::vector<size_t> rows;
  for (size_t k = 0; k < t.size(); ++k) {
    if (!std::isfinite(t[k])) refuse_input({table.file, "time", table.lines[k], table.number_of(column)}, "is empty");
    if (!rows.empty() && t[k] < t[rows.back()]) {
      refuse_input({table.file, "time", table.lines[k], table.number_of(column)},
                   "goes back from " + number(t[rows.back()], 13) + " to " + number(t[k], 13) + " s");
    }
    if (!rows.empty() && t[k] == t[rows.back()]) {
      ++*repeated;
    } else {
      rows.push_back(k);
    }
  }
  return rows;
}

// True if the rows are poses, not samples of one motion: joints are elsewhere in each row, though every logged velocity
// is zero, or though stamps in milliseconds would make a joint faster than the model lets it be.
bool are_poses(const Experiment& e, const Table& table, const std::vector<double>& t, const std::vector<size_t>& rows) {
  bool moved = false, still = true, any_rate = false, too_fast = false;
  for (int j = 0; j < e.num_joints(); ++j) {
    const JointSpec& joint = e.robot.tree.joint(j);
    const int angle = table.find("/joint_states/" + joint.name + "/position"),
              rate = table.find("/joint_states/" + joint.name + "/velocity");
    for (size_t k = 1; k < rows.size(); ++k) {
      const auto read = [&](int column, size_t row) { return table.columns[static_cast<size_t>(column)][row]; };
      const double step = angle < 0 ? 0.0 : std::abs(read(angle, rows[k]) - read(angle, rows[k - 1]));
      moved = moved || step > 0.0;
      any_rate = any_rate || rate >= 0;
      still = still && (rate < 0 || read(rate, rows[k]) == 0.0);
      too_fast = too_fast || step / (1e-3 * (t[rows[k]] - t[rows[k - 1]])) > joint.velocity_limit;
    }
  }
  return moved && ((any_rate && still) || too_fast);
}

[[noreturn]] void refuse_poses(const InputPlace& place, double mean) {
  refuse_input(
      place, "rows stand " + number(mean, 3) +
                 " s apart and each is a pose at rest: the tool judges motion, at least " +
                 number(1.0 / kLongestStep, 3) +
                 " rows a second. It does not judge held poses yet. Record slow sweeps through them, both ways: "
                 "they show what poses show (load, masses, torque constants, springs), and tell dry friction from it");
}

// Checks that stamps are in seconds, and that no pause is longer than all samples together.
void check_steps(const Experiment& e, const Table& table, int column, const std::vector<size_t>& rows) {
  const std::vector<double>& t = table.columns[static_cast<size_t>(column)];
  std::vector<double> steps;
  for (size_t k = 1; k < rows.size(); ++k) steps.push_back(t[rows[k]] - t[rows[k - 1]]);
  const size_t longest = static_cast<size_t>(std::max_element(steps.begin(), steps.end()) - steps.begin());
  const double mean = (t[rows.back()] - t[rows.front()]) / static_cast<double>(steps.size()),
               usual = find_median(steps);
  if (usual <= kLongestStep && mean > kLongestStep) {
    refuse_input({table.file, "time", table.lines[rows[longest + 1]], table.number_of(column)},
                 "jumps from " + number(t[rows[longest]], 13) + " to " + number(t[rows[longest + 1]], 13) +
                     " s: expected pauses that are short against the recording; make two recordings of it");
  }
  if (mean <= kLongestStep && mean >= kShortestStep) return;
  if (mean > kLongestStep && are_poses(e, table, t, rows))
    refuse_poses({table.file, "time", table.lines[rows[1]], table.number_of(column)}, mean);
  refuse_input({table.file, "time", table.lines[rows[1]], table.number_of(column)},
               "samples stand " + number(mean) + " s apart: expected seconds, from " + number(kShortestStep) + " to " +
                   number(kLongestStep) + " s apart; " +
                   (mean > 1e5              ? "are these nanoseconds?"
                    : mean > 100.0          ? "are these microseconds?"
                    : mean >= kShortestStep ? "are these milliseconds?"
                                            : "in which unit is this column?") +
                   " 'scale' under 'columns' of the experiment converts them");
}

// Reads the time stamps: finite, increasing, in seconds. Drops rows with repeated stamps.
std::vector<size_t> read_time(const Experiment& e, const Table& table, Recording* recording,
                              std::vector<std::string>* warnings) {
  const int column = table.find("time");
  if (column < 0)
    refuse_input({table.file, "time", 1, 1},
                 "is missing: expected a column 'time' [s], or one under 'columns', or 'sample_rate' [Hz] of the "
                 "experiment (docs/text_recordings.md)");
  size_t repeated = 0;
  std::vector<size_t> rows = find_rows(table, column, &repeated);
  if (rows.size() < 8) {
    refuse_input({table.file, "time", 1, table.number_of(column)},
                 "has " + std::to_string(rows.size()) + " different stamps, expected at least 8");
  }
  check_steps(e, table, column, rows);
  for (size_t k : rows) recording->time.push_back(table.columns[static_cast<size_t>(column)][k]);
  shift_epoch(recording, warnings);
  if (repeated > 0) {
    warnings->push_back(recording->spec.name + ": " + std::to_string(repeated) +
                        " rows repeat the last time stamp and were dropped");
  }
  if (recording->duration() < kShort) {
    warnings->push_back(recording->spec.name + ": lasts " + number(recording->duration(), 2) + " s (" +
                        std::to_string(rows.size()) +
                        " samples): too short to show what a model leaves out; expected seconds of motion");
  }
  return rows;
}

// Rows that repeat a stamp, as of two logs that were put together, fill the empty cells of the row that is kept.
std::vector<double> take(const Table& table, int column, const std::vector<size_t>& rows) {
  const std::vector<double>& cells = table.columns[static_cast<size_t>(column)];
  std::vector<double> values;
  for (size_t i = 0; i < rows.size(); ++i) {
    const size_t end = i + 1 < rows.size() ? rows[i + 1] : cells.size();
    size_t k = rows[i];
    while (k + 1 < end && std::isnan(cells[k])) ++k;
    values.push_back(cells[k]);
  }
  return values;
}

// Index of the first value that no sensor reads; values.size() if there is none.
size_t find_absurd(const std::vector<double>& values) {
  return static_cast<size_t>(
      std::find_if(values.begin(), values.end(), [](double v) { return std::abs(v) > kLargestReading; }) -
      values.begin());
}

std::string describe_absurd(double value) {
  return "is " + number(value) + ": expected at most " + number(kLargestReading) + " in SI units";
}

// False for a column without numbers.
bool any_finite(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

bool is_constant(const std::vector<double>& values) { return calc_range(values) == 0.0; }

// True if commanded positions do not follow the commanded rates: the squared difference exceeds half of the squared
// changes.
bool has_separate_rate(const std::vector<double>& time, const JointColumns& joint) {
  const double gap = kGapPeriods * find_period(time);  // the command is unknown in longer steps
  double apart = 0.0, moved = 0.0;
  for (size_t k = 1; k < joint.command_rate.size() && k < joint.command.size(); ++k) {
    if (time[k] - time[k - 1] > gap) continue;
    const double change = joint.command[k] - joint.command[k - 1];
    const double told = 0.5 * (joint.command_rate[k] + joint.command_rate[k - 1]) * (time[k] - time[k - 1]);
    apart += (change - told) * (change - told);
    moved += change * change;
  }
  return apart > kHalf * moved;
}

// True if jitter of stamps, or positions with few digits, disturb the cubic between samples more than the motion's
// curvature does. The curvature changes the mean rate by r'' dt^2 / 12; squares are compared over the recording.
bool is_rough(const std::vector<double>& time, const JointColumns& joint) {
  const std::vector<double>& rate = joint.command_rate;
  const double gap = kGapPeriods * find_period(time);  // the command is unknown in longer steps
  double apart = 0.0, curved = 0.0;
  for (size_t k = 1; k + 1 < rate.size() && k + 1 < joint.command.size(); ++k) {
    if (time[k + 1] - time[k] > gap || time[k] - time[k - 1] > gap) continue;
    const double mean = (joint.command[k] - joint.command[k - 1]) / (time[k] - time[k - 1]);
    const double bend = (rate[k + 1] - 2.0 * rate[k] + rate[k - 1]) / 12.0;
    apart += std::pow(mean - 0.5 * (rate[k] + rate[k - 1]), 2);
    curved += bend * bend;
  }
  return apart > kSeveralTimes * kSeveralTimes * curved;
}

// With `by_effort`, commanded efforts stand in for efforts that were not logged.
void read_joint(const Table& table, const std::vector<size_t>& rows, const std::string& name, bool by_effort,
                JointColumns* joint, std::set<std::string>* used, const std::string& file,
                std::vector<std::string>* warnings) {
  const auto column = [&](const std::string& key, std::vector<double>* values) {
    const int index = table.find(key);
    if (index < 0) return;
    used->insert(key);
    *values = take(table, index, rows);
    const size_t bad = find_absurd(*values);
    if (bad < rows.size())
      refuse_input({table.file, key, table.lines[rows[bad]], index + 1}, describe_absurd((*values)[bad]));
    if (any_finite(*values)) return;
    warnings->push_back(file + ": column " + key + " is empty");
    values->clear();
  };
  column("/joint_commands/" + name + "/position", &joint->command);
  column("/joint_commands/" + name + "/velocity", &joint->command_rate);
  for (int q = 0; q < kQuantities; ++q) {
    const std::string key = "/joint_states/" + name + "/" + get_quantity_name(static_cast<Quantity>(q));
    column(key, &joint->signal[q]);
    if (!joint->signal[q].empty() && is_constant(joint->signal[q])) {
      warnings->push_back(file + ": column " + key +
                          " is constant: " + std::to_string(keep_finite(joint->signal[q]).front()));
    }
  }
  std::vector<double>& effort = joint->signal[static_cast<size_t>(Quantity::kEffort)];
  const std::string key = "/joint_commands/" + name + "/effort";
  if (by_effort && table.find(key) >= 0 && (effort.empty() || is_constant(effort))) {
    effort.clear();
    column(key, &effort);
    if (!effort.empty())
      warnings->push_back(file + ": the effort of " + name + " was not logged; its command " + key +
                          " stands in for it");
  }
  joint->command = fill_gaps(joint->command);
  joint->command_rate = fill_gaps(joint->command_rate);
}

// Leaves out columns of joints that the model does not have, such as those of a gripper. Throws if a joint of the model
// is missing that the name may mean, or if the file has none of the model's joints.
void leave_out_strangers(const Experiment& experiment, const Table& table, const std::string& file,
                         std::set<std::string>* used, std::vector<std::string>* warnings) {
  std::set<std::string> known, strangers;
  std::vector<std::string> missing;
  for (const std::string& column : *used) known.insert(get_joint(column));
  known.erase("");
  for (int j = 0; j < experiment.num_joints(); ++j) {
    const std::string& name = experiment.robot.tree.joint(j).name;
    if (!known.count(name)) missing.push_back(name);
  }
  for (size_t i = 0; i < table.names.size(); ++i) {
    const std::string joint = get_joint(table.names[i]);
    if (joint.empty() || used->count(table.names[i]) || known.count(joint)) continue;
    const std::string near = suggest(joint, missing);
    if (!near.empty() || known.empty())
      refuse_input(
          {table.file, table.names[i], 1, static_cast<int>(i) + 1},
          "the robot has no joint '" + joint + "'" + (near.empty() ? "; its joints are " + join_words(missing) : near));
    strangers.insert(joint);
    used->insert(table.names[i]);
  }
  if (!strangers.empty())
    warnings->push_back(file + ": joints that the model does not have were left out: " + join_words(strangers));
}

}  // namespace

std::string get_joint(const std::string& column) {
  if (column.rfind("/joint_states/", 0) != 0 && column.rfind("/joint_commands/", 0) != 0) return "";
  const size_t begin = column.find('/', 1) + 1;
  return column.substr(begin, column.rfind('/') - begin);
}

Recording make_recording(const Experiment& experiment, const RecordingSpec& spec, const Table& table,
                         std::vector<std::string>* warnings) {
  Recording recording;
  recording.spec = spec;
  const std::vector<size_t> rows = read_time(experiment, table, &recording, warnings);
  std::set<std::string> used{"time"};
  for (size_t i = 0; i < table.names.size(); ++i)
    recording.column_of[table.names[i]] = table.number_of(static_cast<int>(i));
  recording.joints.resize(static_cast<size_t>(experiment.num_joints()));
  for (int j = 0; j < experiment.num_joints(); ++j) {
    read_joint(table, rows, experiment.robot.tree.joint(j).name, experiment.scenario.drive == "effort",
               &recording.joints[static_cast<size_t>(j)], &used, spec.name, warnings);
    JointColumns& joint = recording.joints[static_cast<size_t>(j)];
    joint.separate_rate = has_separate_rate(recording.time, joint);
    joint.rough_command = is_rough(recording.time, joint);
    if (joint.separate_rate)
      warnings->push_back(spec.name + ": /joint_commands/" + experiment.robot.tree.joint(j).name +
                          "/velocity is not the derivative of the commanded positions; the servo gets it as recorded");
  }
  leave_out_strangers(experiment, table, spec.name, &used, warnings);
  for (size_t i = 0; i < table.names.size(); ++i) {
    if (used.count(table.names[i])) continue;
    std::vector<double> values = take(table, static_cast<int>(i), rows);
    const size_t bad = find_absurd(values);
    if (bad < rows.size()) {
      warnings->push_back(table.file + ":" + std::to_string(table.lines[rows[bad]]) + ":" + std::to_string(i + 1) +
                          ": warning: " + table.names[i] + ": " + describe_absurd(values[bad]) +
                          "; the column is left out");
    } else if (any_finite(values)) {
      recording.other[table.names[i]] = std::move(values);
    }
  }
  return recording;
}

}  // namespace hrp::diagnosis
