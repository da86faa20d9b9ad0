// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "common/base/join_words.h"
#include "common/base/rounding.h"
#include "common/log/ros_bag.h"
#include "common/robot/closed_chains.h"
#include "common/robot/column_map.h"
#include "common/robot/mesh.h"
#include "common/robot/topic_map.h"
#include "diagnosis/data/bag_table.h"
#include "diagnosis/data/by_hand.h"
#include "diagnosis/data/csv_stream.h"
#include "diagnosis/data/drives.h"
#include "diagnosis/data/make_recording.h"
#include "diagnosis/data/noise.h"
#include "diagnosis/data/plausibility.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/data/repair.h"
#include "diagnosis/data/repaired_robot.h"
#include "diagnosis/data/stretches.h"
#include "diagnosis/data/unrecorded.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;

bool is_log(const std::string& file) { return fs::path(file).extension() == ".mcap"; }

// How long text recordings are reduced to fit into memory: the number of samples that are averaged, and the share that
// is kept.
struct Plan {
  size_t averaging = 1;
  double share = 1.0;
};

Plan plan_reading(const Experiment& e, const std::vector<ColumnMap>& columns) {
  double numbers = 0.0, rate = 0.0;
  for (size_t i = 0; i < e.keys.recordings.size(); ++i) {
    const std::string& file = e.keys.recordings[i].file;
    if (is_ros_bag(file) || is_log(file)) continue;
    const CsvShape shape = probe_csv(file, columns[i]);
    numbers += shape.rows * shape.columns;
    rate = std::max(rate, shape.rate > 0.0 ? shape.rate : columns[i].sample_rate);
  }
  const size_t averaging = find_averaging(numbers, rate);
  return {averaging, std::min(1.0, kMostNumbers * static_cast<double>(averaging) / std::max(1.0, numbers))};
}

class Loader {
 public:
  explicit Loader(Experiment* e)
      : e_(*e), columns_(parse_column_maps(e->scenario.text, e->path)), plan_(plan_reading(*e, columns_)) {
    for (int j = 0; j < e_.num_joints(); ++j) robot_.joints.push_back(e_.robot.tree.joint(j).name);
    for (const ImuSpec& imu : e_.scenario.sensors.imus) robot_.imus.push_back(imu.name);
    for (const WrenchSpec& wrench : e_.scenario.sensors.wrenches) robot_.wrenches.push_back(wrench.name);
    robot_.floating = e_.scenario.floating_base;
  }

  void load() {
    for (size_t i = 0; i < columns_.size(); ++i) load(e_.keys.recordings[i], columns_[i]);
  }

  // Reduces logs and bags that do not fit to the stretches with most motion.
  void cut() {
    double numbers = 0.0;
    for (const Recording& r : e_.recordings) numbers += count_numbers(r);
    if (numbers <= 1.2 * kMostNumbers) return;  // the size of text was estimated from its first lines
    std::vector<Recording> all = std::move(e_.recordings);
    e_.recordings.clear();
    for (Recording& r : all) add(std::move(r), kMostNumbers / numbers, false);
  }

 private:
  void load(const RecordingSpec& spec, const ColumnMap& columns) {
    if (is_ros_bag(spec.file)) return load_bag(spec);
    const bool text = !is_log(spec.file);
    const size_t averaging = text ? plan_.averaging : 1;
    Table table = text ? read_csv_averaged(spec.file, averaging, &e_.warnings, columns)
                       : read_recording_table(spec.file, &e_.warnings);
    if (text) add_stamps(columns.sample_rate / static_cast<double>(averaging), spec.name, &table);
    if (averaging > 1)
      e_.warnings.push_back(spec.name + ": " + std::to_string(averaging) +
                            " samples in a row are averaged to one: it is long");
    add(make_recording(e_, spec, table, &e_.warnings), text ? plan_.share : 1.0, true);
  }

  // Rows without stamps stand at the rate that the experiment states.
  void add_stamps(double rate, const std::string& name, Table* table) {
    if (table->find("time") >= 0 || rate <= 0.0) return;
    table->names.push_back("time");
    table->columns.emplace_back();
    for (size_t k = 0; k < table->rows(); ++k) table->columns.back().push_back(static_cast<double>(k) / rate);
    e_.warnings.push_back(name + ": has no column of time: its rows are taken " + number(1.0 / rate) +
                          " s apart, by 'sample_rate'");
  }

  static double count_numbers(const Recording& r) { return static_cast<double>(r.size() * r.column_of.size()); }

  // Adds the recording, or the share of it in which the joints move most.
  // `pushes_in_time`: times of pushes count from r's first sample; else what is left of them acts throughout.
  void add(Recording&& r, double share, bool pushes_in_time) {
    if (share >= 1.0) {
      e_.recordings.push_back(std::move(r));
      return;
    }
    e_.warnings.push_back(r.spec.name + ": of " + std::to_string(std::lround(r.duration())) + " s about " +
                          std::to_string(std::lround(share * r.duration())) +
                          " s are used, those in which the joints move most");
    for (Recording& piece : cut_to_stretches(r, share * r.duration())) {
      if (pushes_in_time) shift_pushes(piece.time.front() - r.time.front(), piece.duration(), &piece.spec);
      e_.recordings.push_back(std::move(piece));
    }
  }

  // Their times count from the first sample of what was recorded, and this part begins `late` [s] after it.
  static void shift_pushes(double late, double duration, RecordingSpec* part) {
    std::vector<HandPush> own;
    for (HandPush push : part->pushes) {
      push.start -= late;
      push.end -= late;
      if (push.end >= 0.0 && push.start <= duration) own.push_back(push);
    }
    part->pushes = own;
  }

  // Loads a bag, which becomes several recordings where topics are silent.
  void load_bag(const RecordingSpec& spec) {
    std::vector<std::string> notes;
    const TopicMap map = parse_topic_map(e_.scenario.text, e_.path);
    std::vector<BagTable> parts = read_bag(spec.file, map, robot_, e_.path, &notes);
    const double begin = parts.empty() ? 0.0 : parts[0].table.columns[0].front();
    for (BagTable& part : parts) {
      RecordingSpec own = spec;
      own.name += part.part;
      const std::vector<double>& time = part.table.columns[0];
      if (parts.size() > 1) shift_pushes(time.front() - begin, time.back() - time.front(), &own);
      const double rate = static_cast<double>(time.size()) / std::max(1e-9, time.back() - time.front());
      const double numbers = static_cast<double>(time.size() * part.table.names.size() * e_.keys.recordings.size());
      average_rows(find_averaging(numbers, rate), &part.table);
      e_.recordings.push_back(make_recording(e_, own, part.table, &e_.warnings));
    }
    for (const std::string& note : notes) e_.warnings.push_back(spec.name + ": " + note);
  }

  Experiment& e_;
  const std::vector<ColumnMap> columns_;  // by recording
  const Plan plan_;
  BagRobot robot_;
};

void describe_missing(Experiment* e) {
  bool any[kQuantities] = {false, false, false};
  for (const Recording& r : e->recordings) {
    for (const JointColumns& joint : r.joints) {
      for (int q = 0; q < kQuantities; ++q) any[q] = any[q] || !joint.signal[q].empty();
    }
  }
  if (e->num_joints() == 0) return;
  if (has_drive(e->robot.tree) && !any[2])
    e->warnings.push_back(
        "no effort was recorded: faults of effort sensors cannot be told, and a wrong servo gain looks like friction "
        "or inertia");
  if (!any[1])
    e->warnings.push_back(
        "no velocity was recorded: it is taken from the positions; effects at velocity reversal are seen less sharply");
}

// Divides recordings at external forces by hand.
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
  throw InputError(e->scenario.make_diagnostic(
      "recordings", "in all of them somebody pushes with a force that is not known: nothing is left"));
}

// On a fixed base; others cut theirs by what each sensor read anew (floating/log/tracks.h).
void take_between_gaps(Experiment* e) {
  if (e->scenario.floating_base) return;
  std::vector<Recording> parts;
  for (const Recording& r : e->recordings) {
    for (Recording& part : cut_at_gaps(r, &e->warnings)) parts.push_back(std::move(part));
  }
  e->recordings = std::move(parts);
}

// A mesh that cannot be read would leave a foot without a sole, without a word.
void check_sole_meshes(const RobotDescription& robot) {
  for (const CollisionShape& shape : robot.shapes) {
    if (shape.sole && shape.kind == ShapeKind::kMesh) load_mesh(shape.mesh, shape.scale);
  }
}

// Without feet, nothing says where the ground carries a robot.
void note_missing_feet(Experiment* e) {
  const Scenario& scenario = e->scenario;
  if (!scenario.floating_base || !scenario.feet.empty() || e->num_joints() == 0) return;
  const std::string carriers = join_words(scenario.sensors.wrenches, [](const WrenchSpec& s) { return s.link; });
  e->warnings.push_back(e->path +
                        ": feet: is missing, so the forces of the ground are compared with nothing; expected the links "
                        "that carry the robot" +
                        (carriers.empty() ? "" : ", such as those with force sensors: " + carriers));
}

// Throws InputError for a scenario with more than one robot of links in a tree.
void refuse_other_worlds(const Experiment& e) {
  if (!adopt_loops(e.scenario, e.robot.scenario).loops.empty()) {
    throw InputError(e.scenario.make_diagnostic(
        "loops",
        "the robot has closed chains ('loops', or <loop> in its URDF); expected none: the diagnosis knows trees only"));
  }
  if (!e.scenario.robots.empty()) {
    throw InputError(e.scenario.make_diagnostic("robots", "the diagnosis knows one robot; expected no others"));
  }
  if (!e.scenario.objects.empty()) {
    throw InputError(e.scenario.make_diagnostic("objects", "the diagnosis knows no movable objects; expected none"));
  }
  if (!e.scenario.world.empty()) {
    throw InputError(e.scenario.make_diagnostic("world", "the diagnosis knows no SDF worlds; expected 'obstacles'"));
  }
}

// Median step [s] of all recordings.
double find_sample_time(const Experiment& e) {
  std::vector<double> steps;
  for (const Recording& r : e.recordings) {
    for (size_t k = 1; k < r.size(); ++k) steps.push_back(r.time[k] - r.time[k - 1]);
  }
  return find_median(std::move(steps));
}

}  // namespace

const char* get_quantity_name(Quantity quantity) {
  const char* const names[] = {"position", "velocity", "effort"};
  return names[static_cast<int>(quantity)];
}

std::string Experiment::signal_name(int joint, Quantity quantity) const {
  return "/joint_states/" + robot.tree.joint(joint).name + "/" + get_quantity_name(quantity);
}

Experiment load_experiment(const std::string& path) {
  Experiment e;
  e.scenario = load_scenario(path);
  e.path = e.scenario.path;
  e.folder = fs::path(e.path).parent_path().string();
  e.keys = parse_experiment_keys(e.scenario.text, e.path);
  e.robot = load_repaired_robot(&e.scenario);
  refuse_other_worlds(e);
  for (const std::string& text : e.robot.warnings) e.warnings.push_back(text);
  check_sole_meshes(e.robot);
  note_missing_feet(&e);
  const std::vector<std::string> before = e.warnings;
  std::optional<Loader> loader(&e);
  loader->load();
  const std::vector<std::string> read = std::exchange(e.warnings, before);
  if (fix_unrecorded(&e)) {
    loader.emplace(&e);
    loader->load();
  } else {
    e.warnings = read;
  }
  take_by_hand(&e);
  take_between_gaps(&e);
  loader->cut();
  for (Recording& r : e.recordings) repair_recording(e, &r, &e.warnings);
  check_plausibility(&e);
  e.sample_time = find_sample_time(e);
  find_noise(&e);
  describe_missing(&e);
  return e;
}

}  // namespace hrp::diagnosis
