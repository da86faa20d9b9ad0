// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>

#include "common/log/ros_bag.h"
#include "common/robot/closed_chains.h"
#include "common/robot/topic_map.h"
#include "diagnosis/data/bag_table.h"
#include "diagnosis/data/by_hand.h"
#include "diagnosis/data/csv_stream.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/data/stretches.h"
#include "diagnosis/data/recording.h"
#include "diagnosis/data/repair.h"
#include "diagnosis/data/plausibility.h"
#include "diagnosis/data/urdf_text.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& file, int line, int column, const std::string& field,
                       const std::string& text) {
  Diagnostic d;
  d.file = file, d.line = line, d.column = column, d.field = field, d.message = text;
  throw InputError(d);
}

// Stamps of the epoch (1.7e9 s) leave a double a quarter of a microsecond, too coarse for differences of differences:
// they count from the recording's first whole second, in whole microseconds, which is all they ever held.
void shift_epoch(Recording* recording, std::vector<std::string>* warnings) {
  const double origin = std::floor(recording->time.front());
  if (std::abs(origin) < 1e6) return;
  for (double& t : recording->time) t = 1e-6 * std::round(1e6 * (t - origin));
  char text[40];
  std::snprintf(text, sizeof text, "%.0f", origin);
  warnings->push_back(recording->spec.name + ": its times are said from " + text + " s on");
}

// Time stamps: finite, increasing, in seconds. Rows that repeat a stamp are dropped.
std::vector<size_t> read_time(const Table& table, Recording* recording, std::vector<std::string>* warnings) {
  const int column = table.find("time");
  if (column < 0) fail(table.file, 1, 1, "time", "is missing: expected a column 'time' [s]");
  const std::vector<double>& t = table.columns[static_cast<size_t>(column)];
  std::vector<size_t> rows;
  size_t repeated = 0;
  for (size_t k = 0; k < t.size(); ++k) {
    if (!std::isfinite(t[k])) fail(table.file, table.lines[k], column + 1, "time", "is empty");
    if (!rows.empty() && t[k] < t[rows.back()]) {
      fail(table.file, table.lines[k], column + 1, "time",
           "goes back from " + std::to_string(t[rows.back()]) + " to " + std::to_string(t[k]) + " s");
    }
    if (!rows.empty() && t[k] == t[rows.back()]) {
      ++repeated;
      continue;
    }
    rows.push_back(k);
  }
  if (rows.size() < 8) fail(table.file, 1, column + 1, "time", "has fewer than 8 different stamps");
  for (size_t k : rows) recording->time.push_back(t[k]);
  shift_epoch(recording, warnings);
  if (repeated > 0) {
    warnings->push_back(recording->spec.name + ": " + std::to_string(repeated) +
                        " rows repeat the last time stamp and were dropped");
  }
  const double dt = recording->duration() / static_cast<double>(rows.size() - 1);
  // Four samples a second show no motion of a joint: far more likely the column is not in seconds.
  if (dt > 0.25) {
    fail(table.file, table.lines[rows[1]], column + 1, "time",
         "samples stand " + std::to_string(dt) +
             " s apart: expected seconds, at most 0.25 s apart; are these " +
             (dt > 1e5 ? "nanoseconds?" : dt > 100.0 ? "microseconds?" : "milliseconds?"));
  }
  return rows;
}

std::vector<double> take(const Table& table, int column, const std::vector<size_t>& rows) {
  std::vector<double> values;
  for (size_t k : rows) values.push_back(table.columns[static_cast<size_t>(column)][k]);
  return values;
}

// False for a column without any number.
bool any_finite(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

void fill_gaps(std::vector<double>* values) {
  double last = 0.0;
  for (double v : *values) {
    if (std::isfinite(v)) {
      last = v;
      break;
    }
  }
  for (double& v : *values) {
    if (!std::isfinite(v)) v = last;
    last = v;
  }
}

bool is_constant(const std::vector<double>& values) {
  double low = 1e300, high = -1e300;
  for (double v : values) {
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
  return !(high > low);
}

// Commanded positions move otherwise than the commanded rates say: by more than half of their own changes, as squares.
bool has_separate_rate(const std::vector<double>& time, const JointColumns& joint) {
  constexpr double kSeparate = 0.5;
  double apart = 0.0, moved = 0.0;
  for (size_t k = 1; k < joint.command_rate.size() && k < joint.command.size(); ++k) {
    const double change = joint.command[k] - joint.command[k - 1];
    const double told = 0.5 * (joint.command_rate[k] + joint.command_rate[k - 1]) * (time[k] - time[k - 1]);
    apart += (change - told) * (change - told), moved += change * change;
  }
  return apart > kSeparate * moved;
}

void read_joint(const Table& table, const std::vector<size_t>& rows, const std::string& name, JointColumns* joint,
                std::set<std::string>* used, const std::string& file, std::vector<std::string>* warnings) {
  const auto column = [&](const std::string& key, std::vector<double>* values) {
    const int index = table.find(key);
    if (index < 0) return;
    used->insert(key);
    *values = take(table, index, rows);
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
      warnings->push_back(file + ": column " + key + " is constant: " + std::to_string(joint->signal[q].front()));
    }
  }
  fill_gaps(&joint->command);
  fill_gaps(&joint->command_rate);
}

// The joint of a column of readings or commands; empty: it is none.
std::string get_joint(const std::string& column) {
  if (column.rfind("/joint_states/", 0) != 0 && column.rfind("/joint_commands/", 0) != 0) return "";
  const size_t begin = column.find('/', 1) + 1;
  return column.substr(begin, column.rfind('/') - begin);
}

// Columns of joints that the model has not, as of a gripper. Refused where one of the model's own joints is not there, whose
// misspelt name it may be, and where the file has none of the model's joints.
void leave_out_strangers(const Experiment& experiment, const Table& table, const std::string& file, std::set<std::string>* used,
                         std::vector<std::string>* warnings) {
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
    const std::string near = find_nearest(joint, missing);
    if (!near.empty() || known.empty())
      fail(table.file, 1, static_cast<int>(i) + 1, table.names[i],
           "the robot has no joint '" + joint + "'" + (near.empty() ? "" : "; did you mean '" + near + "'?"));
    strangers.insert(joint), used->insert(table.names[i]);
  }
  std::string list;
  for (const std::string& joint : strangers) list += (list.empty() ? "" : ", ") + joint;
  if (!strangers.empty()) warnings->push_back(file + ": joints that the model does not have were left out: " + list);
}

Recording make_recording(const Experiment& experiment, const RecordingSpec& spec, const Table& table,
                         std::vector<std::string>* warnings) {
  Recording recording;
  recording.spec = spec;
  const std::vector<size_t> rows = read_time(table, &recording, warnings);
  std::set<std::string> used{"time"};
  for (size_t i = 0; i < table.names.size(); ++i) recording.column_of[table.names[i]] = static_cast<int>(i) + 1;
  recording.joints.resize(static_cast<size_t>(experiment.num_joints()));
  for (int j = 0; j < experiment.num_joints(); ++j) {
    read_joint(table, rows, experiment.robot.tree.joint(j).name, &recording.joints[static_cast<size_t>(j)], &used,
               spec.name, warnings);
    JointColumns& joint = recording.joints[static_cast<size_t>(j)];
    joint.separate_rate = has_separate_rate(recording.time, joint);
    if (joint.separate_rate)
      warnings->push_back(spec.name + ": /joint_commands/" + experiment.robot.tree.joint(j).name +
                          "/velocity is not the derivative of the commanded positions; the servo gets it as recorded");
  }
  leave_out_strangers(experiment, table, spec.name, &used, warnings);
  for (size_t i = 0; i < table.names.size(); ++i) {
    if (used.count(table.names[i])) continue;
    std::vector<double> values = take(table, static_cast<int>(i), rows);
    if (any_finite(values)) recording.other[table.names[i]] = std::move(values);
  }
  return recording;
}

bool is_log(const std::string& file) { return fs::path(file).extension() == ".mcap"; }

// How long text recordings fit into memory: so many samples in a row become one, and of that a share is kept.
struct Plan {
  size_t averaging = 1;
  double share = 1.0;
};

Plan plan_reading(const Experiment& e) {
  double numbers = 0.0, rate = 0.0;
  for (const RecordingSpec& spec : e.keys.recordings) {
    if (is_ros_bag(spec.file) || is_log(spec.file)) continue;
    const CsvShape shape = probe_csv(spec.file);
    numbers += shape.rows * shape.columns, rate = std::max(rate, shape.rate);
  }
  const size_t averaging = find_averaging(numbers, rate);
  return {averaging, std::min(1.0, kMostNumbers * static_cast<double>(averaging) / std::max(1.0, numbers))};
}

class Loader {
 public:
  explicit Loader(Experiment* e) : e_(*e), plan_(plan_reading(*e)) {
    for (int j = 0; j < e_.num_joints(); ++j) robot_.joints.push_back(e_.robot.tree.joint(j).name);
    for (const ImuSpec& imu : e_.scenario.sensors.imus) robot_.imus.push_back(imu.name);
    for (const WrenchSpec& wrench : e_.scenario.sensors.wrenches) robot_.wrenches.push_back(wrench.name);
    robot_.floating = e_.scenario.floating_base;
  }

  void load(const RecordingSpec& spec) {
    if (is_ros_bag(spec.file)) return load_bag(spec);
    const bool text = !is_log(spec.file);
    const bool averaged = text && plan_.averaging > 1;
    const Table table = averaged ? read_csv_averaged(spec.file, plan_.averaging, &e_.warnings)
                                 : read_recording_table(spec.file, &e_.warnings);
    if (averaged)
      e_.warnings.push_back(spec.name + ": " + std::to_string(plan_.averaging) + " samples in a row are averaged to one: it is long");
    add(make_recording(e_, spec, table, &e_.warnings), text ? plan_.share : 1.0);
  }

  // What of logs and bags still does not fit is cut to the stretches that tell most.
  void cut() {
    double numbers = 0.0;
    for (const Recording& r : e_.recordings) numbers += count_numbers(r);
    if (numbers <= 1.2 * kMostNumbers) return;  // text was estimated by its first lines
    std::vector<Recording> all = std::move(e_.recordings);
    e_.recordings.clear();
    for (Recording& r : all) add(std::move(r), kMostNumbers / numbers);
  }

 private:
  static double count_numbers(const Recording& r) { return static_cast<double>(r.size() * r.column_of.size()); }

  // The recording, or the share of it in which the joints move most.
  void add(Recording&& r, double share) {
    if (share >= 1.0) {
      e_.recordings.push_back(std::move(r));
      return;
    }
    e_.warnings.push_back(r.spec.name + ": of " + std::to_string(std::lround(r.duration())) + " s about " +
                          std::to_string(std::lround(share * r.duration())) + " s are used, those in which the joints move most");
    for (Recording& piece : cut_to_stretches(r, share * r.duration())) e_.recordings.push_back(std::move(piece));
  }

  // A bag falls into several recordings where topics are silent.
  void load_bag(const RecordingSpec& spec) {
    std::vector<std::string> notes;
    const TopicMap map = parse_topic_map(e_.scenario.text, e_.path);
    for (BagTable& part : read_bag(spec.file, map, robot_, e_.path, &notes)) {
      RecordingSpec own = spec;
      own.name += part.part;
      const std::vector<double>& time = part.table.columns[0];
      const double rate = static_cast<double>(time.size()) / std::max(1e-9, time.back() - time.front());
      const double numbers = static_cast<double>(time.size() * part.table.names.size() * e_.keys.recordings.size());
      average_rows(find_averaging(numbers, rate), &part.table);
      e_.recordings.push_back(make_recording(e_, own, part.table, &e_.warnings));
    }
    for (const std::string& note : notes) e_.warnings.push_back(spec.name + ": " + note);
  }

  Experiment& e_;
  const Plan plan_;
  BagRobot robot_;
};

}  // namespace

const char* get_quantity_name(Quantity quantity) {
  const char* const names[] = {"position", "velocity", "effort"};
  return names[static_cast<int>(quantity)];
}

std::string Experiment::signal_name(int joint, Quantity quantity) const {
  return "/joint_states/" + robot.tree.joint(joint).name + "/" + get_quantity_name(quantity);
}

namespace {

// Step of a quantised signal: the smallest change, when most changes are whole multiples of it; 0 else.
double find_step(const std::vector<double>& signal) {
  std::vector<double> changes;
  double largest = 0.0;
  for (size_t k = 1; k < signal.size(); ++k) {
    const double d = std::abs(signal[k] - signal[k - 1]);
    if (std::isfinite(d)) largest = std::max(largest, std::abs(signal[k]));
    if (std::isfinite(d) && d > 0.0) changes.push_back(d);
  }
  if (changes.size() < 8) return 0.0;
  std::sort(changes.begin(), changes.end());
  const double step = changes[changes.size() / 50];
  if (step < 1e-5 * largest) return 0.0;  // as fine as the digits of the file
  size_t whole = 0;
  for (double d : changes) {
    const double ratio = d / step;
    whole += std::abs(ratio - std::round(ratio)) < 0.05 * std::max(1.0, 0.02 * ratio) ? 1 : 0;
  }
  return whole * 10 > changes.size() * 8 ? step : 0.0;
}

}  // namespace

double estimate_noise(const std::vector<double>& signal) {
  std::vector<double> third;
  size_t zeros = 0;
  for (size_t k = 3; k < signal.size(); ++k) {
    const double d = signal[k] - 3.0 * signal[k - 1] + 3.0 * signal[k - 2] - signal[k - 3];
    if (!std::isfinite(d)) continue;
    if (d == 0.0) ++zeros;
    third.push_back(std::abs(d));
  }
  if (third.size() < 8) return 0.0;
  double value = find_median(third);
  if (zeros * 4 > third.size()) {  // quantised or held: the median says nothing, the mean square still does
    double sum = 0.0;
    for (double d : third) sum += d * d;
    value = 0.6745 * std::sqrt(sum / static_cast<double>(third.size()));
  }
  // A reading in steps is never better than its step.
  // 1 + 9 + 9 + 1: variance of the third difference of white noise
  return std::max(find_step(signal) / std::sqrt(12.0), value / (0.6745 * std::sqrt(20.0)));
}

namespace {

double get_stated(const Experiment& e, const std::string& signal, const std::string& quantity) {
  for (const std::string& key : {signal, quantity}) {
    const auto it = e.keys.noise.find(key);
    if (it != e.keys.noise.end()) return it->second;
  }
  return 0.0;
}

// Median over recordings of what each says.
double estimate_over(const std::vector<double>& estimates) {
  std::vector<double> sorted = estimates;
  std::sort(sorted.begin(), sorted.end());
  return sorted.empty() ? 0.0 : sorted[sorted.size() / 2];
}

void find_noise(Experiment* e) {
  e->joint_noise.assign(static_cast<size_t>(e->num_joints()), std::vector<Noise>(kQuantities));
  for (int j = 0; j < e->num_joints(); ++j) {
    for (int q = 0; q < kQuantities; ++q) {
      Noise& noise = e->joint_noise[static_cast<size_t>(j)][static_cast<size_t>(q)];
      noise.sigma =
          get_stated(*e, e->signal_name(j, static_cast<Quantity>(q)), get_quantity_name(static_cast<Quantity>(q)));
      noise.stated = noise.sigma > 0.0;
      if (noise.stated) continue;
      std::vector<double> found;
      for (const Recording& r : e->recordings) {
        const auto& column = r.joints[static_cast<size_t>(j)].signal[q];
        if (!column.empty()) found.push_back(estimate_noise(column));
      }
      noise.sigma = estimate_over(found);
    }
  }
  for (const Recording& r : e->recordings) {
    for (const auto& item : r.other) {
      Noise& noise = e->other_noise[item.first];
      if (noise.sigma > 0.0) continue;
      const size_t cut = item.first.rfind('/');
      noise.sigma = get_stated(*e, item.first.substr(0, cut), "");
      noise.stated = noise.sigma > 0.0;
      if (!noise.stated) noise.sigma = estimate_noise(item.second);
    }
  }
}

// A signal that never varies by more than rounding has no measurable noise: the spread of its equals stands in, so
// that nothing is divided by zero.
void floor_noise(Experiment* e) {
  for (int q = 0; q < kQuantities; ++q) {
    std::vector<double> others;
    for (auto& joint : e->joint_noise) {
      if (joint[static_cast<size_t>(q)].sigma > 0.0) others.push_back(joint[static_cast<size_t>(q)].sigma);
    }
    const double middle = estimate_over(others);
    for (auto& joint : e->joint_noise) {
      double& sigma = joint[static_cast<size_t>(q)].sigma;
      if (sigma < 1e-3 * middle || sigma <= 0.0) sigma = middle > 0.0 ? middle : 1e-6;
    }
  }
  for (auto& item : e->other_noise) {
    if (item.second.sigma <= 0.0) item.second.sigma = 1e-9;
  }
}

void describe_missing(Experiment* e) {
  bool any[kQuantities] = {false, false, false};
  for (const Recording& r : e->recordings) {
    for (const JointColumns& joint : r.joints) {
      for (int q = 0; q < kQuantities; ++q) any[q] = any[q] || !joint.signal[q].empty();
    }
  }
  if (e->num_joints() == 0) return;
  if (!any[2])
    e->warnings.push_back(
        "no effort was recorded: faults of effort sensors cannot be told, and a wrong servo gain looks like friction "
        "or inertia");
  if (!any[1])
    e->warnings.push_back(
        "no velocity was recorded: it is taken from the positions; effects at velocity reversal are seen less sharply");
}

}  // namespace

namespace {

bool is_recorded(const Experiment& e, int joint) {
  return std::any_of(e.recordings.begin(), e.recordings.end(), [&](const Recording& r) {
    const JointColumns& c = r.joints[static_cast<size_t>(joint)];
    return c.has(Quantity::kPosition) || c.has(Quantity::kVelocity) || c.has(Quantity::kEffort) || !c.command.empty();
  });
}

// A column of a joint that the model has not: perhaps a misspelt one of those that seem to be missing.
bool has_strange_joint(const Experiment& e) {
  std::set<std::string> known;
  for (int j = 0; j < e.num_joints(); ++j) known.insert(e.robot.tree.joint(j).name);
  for (const Recording& r : e.recordings) {
    for (const auto& column : r.column_of) {
      const std::string joint = get_joint(column.first);
      if (!joint.empty() && !known.count(joint)) return true;
    }
  }
  return false;
}

// Joints of which no recording has anything, nor of any joint beyond them.
std::vector<std::string> list_unrecorded(const Experiment& e) {
  const TreeSpec& tree = e.robot.tree;
  std::vector<char> needed(tree.links.size(), 0);
  for (int j = tree.num_joints() - 1; j >= 0; --j) {  // parents come first
    const auto link = static_cast<size_t>(j) + 1;
    needed[link] = needed[link] || is_recorded(e, j);
    if (needed[link]) needed[static_cast<size_t>(tree.links[link].parent)] = 1;
  }
  std::vector<std::string> names;
  for (int j = 0; j < tree.num_joints(); ++j) {
    if (!needed[static_cast<size_t>(j) + 1]) names.push_back(tree.joint(j).name);
  }
  return names;
}

// A gripper whose log nobody kept moves little that the arm feels: fixed at its zero. False: there is none, or the robot's
// base moves, whose joints may be missing.
bool fix_unrecorded(Experiment* e) {
  if (e->scenario.floating_base || has_strange_joint(*e)) return false;
  const std::vector<std::string> names = list_unrecorded(*e);
  if (names.empty() || static_cast<int>(names.size()) == e->num_joints()) return false;
  std::string urdf = e->robot.urdf;
  bool mentioned = false;
  for (const std::string& name : names) {
    urdf = set_joint_attribute(urdf, name, "", "type", "fixed");
    mentioned = e->scenario.servo_joints.erase(name) + e->scenario.initial_joints.erase(name) + e->scenario.rotor_inertia.erase(name) +
                e->scenario.joint_laws.erase(name) > 0 || mentioned;
    e->warnings.push_back("joint " + name + " is in no recording: taken as fixed at its zero");
  }
  const std::string own = e->robot.urdf;
  e->robot = parse_robot(urdf, e->robot.urdf_path, e->scenario);
  if (mentioned) e->robot.urdf = own;  // the updated scenario speaks of it
  e->recordings.clear();
  return true;
}

// Pieces between hands that came and went.
void take_by_hand(Experiment* e) {
  std::vector<Recording> pieces;
  for (Recording& r : e->recordings) {
    resolve_by_hand(*e, &r);
    if (r.spec.pushes.empty()) {
      pieces.push_back(std::move(r));
      continue;
    }
    for (Recording& piece : cut_at_pushes(*e, r, &e->warnings)) pieces.push_back(std::move(piece));
  }
  e->recordings = std::move(pieces);
  if (!e->recordings.empty()) return;
  fail(e->path, 0, 0, "recordings", "in all of them somebody pushes with a force that is not known: nothing is left");
}

}  // namespace

Experiment load_experiment(const std::string& path) {
  Experiment e;
  e.scenario = load_scenario(path);
  e.path = e.scenario.path;
  e.folder = fs::path(e.path).parent_path().string();
  e.keys = parse_experiment_keys(e.scenario.text, e.path);
  e.robot = load_robot(e.scenario);
  if (!adopt_loops(e.scenario, e.robot.scenario).loops.empty()) {
    throw InputError(e.scenario.make_diagnostic(
        "loops", "the robot has closed chains ('loops', or <loop> in its URDF); expected none: the diagnosis knows trees only"));
  }
  if (!e.scenario.objects.empty()) {
    throw InputError(e.scenario.make_diagnostic("objects", "the diagnosis knows no movable objects; expected none"));
  }
  if (!e.scenario.world.empty()) {
    throw InputError(e.scenario.make_diagnostic("world", "the diagnosis knows no SDF worlds; expected 'obstacles'"));
  }
  for (const std::string& text : e.robot.warnings) e.warnings.push_back(text);
  const std::vector<std::string> before = e.warnings;
  std::optional<Loader> loader(&e);
  for (const RecordingSpec& spec : e.keys.recordings) loader->load(spec);
  const std::vector<std::string> read = std::exchange(e.warnings, before);
  if (fix_unrecorded(&e)) {
    loader.emplace(&e);
    for (const RecordingSpec& spec : e.keys.recordings) loader->load(spec);
  } else {
    e.warnings = read;
  }
  take_by_hand(&e);
  loader->cut();
  for (Recording& r : e.recordings) repair_recording(e, &r, &e.warnings);
  check_plausibility(&e);
  std::vector<double> steps;
  for (const Recording& r : e.recordings) {
    for (size_t k = 1; k < r.size(); ++k) steps.push_back(r.time[k] - r.time[k - 1]);
  }
  e.sample_time = find_median(std::move(steps));
  find_noise(&e);
  floor_noise(&e);
  describe_missing(&e);
  return e;
}

}  // namespace hrp::diagnosis
