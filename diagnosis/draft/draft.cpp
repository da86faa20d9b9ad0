// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/draft/draft.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "common/base/diagnostics.h"
#include "common/base/ends_with.h"
#include "common/base/exact_number.h"
#include "common/base/join_words.h"
#include "common/base/printable.h"
#include "common/log/ros_bag.h"
#include "diagnosis/data/csv_layout.h"
#include "diagnosis/data/csv_stream.h"
#include "diagnosis/data/plausibility.h"
#include "diagnosis/data/repaired_robot.h"
#include "diagnosis/draft/bag_draft.h"
#include "diagnosis/draft/column_names.h"
#include "diagnosis/draft/column_relations.h"
#include "diagnosis/draft/foot_columns.h"
#include "diagnosis/draft/imu_columns.h"
#include "diagnosis/draft/log_columns.h"
#include "diagnosis/draft/quote.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;

bool is_text(const std::string& path) { return !is_ros_bag(path) && fs::path(path).extension() != ".mcap"; }

std::vector<double> find_values(const std::vector<double>& column) {
  std::vector<double> values;
  std::copy_if(column.begin(), column.end(), std::back_inserter(values), [](double v) { return std::isfinite(v); });
  return values;
}

// Of a column of efforts that is no torque: what it is, and the factor that only its owner knows.
struct EffortUnit {
  EffortOf of;
  const char *what, *factor;
};
constexpr EffortUnit kEffortUnits[] = {
    {EffortOf::kTorque, "", ""},
    {EffortOf::kCurrent, "a current", "the torque constant at the joint [N m/A]: gear ratio times that of the motor"},
    {EffortOf::kDuty, "the duty of a PWM",
     "the stall torque over the largest count [N m], and a duty needs the sign of its direction; its back-EMF then "
     "looks like viscous friction"},
    {EffortOf::kVoltage, "a voltage",
     "the torque constant at the joint over the resistance [N m/V]; its back-EMF then looks like viscous friction"}};

std::string format_short(double value) {
  std::ostringstream text;
  text.precision(3);
  text << value;
  return text.str();
}

class DraftWriter {
 public:
  DraftWriter(const std::string& robot, const std::vector<std::string>& logs, const std::string& folder)
      : robot_(robot), logs_(logs), folder_(fs::absolute(folder.empty() ? "." : folder)) {
    for (const std::string& log : logs) {
      std::error_code error;  // a name that is too long for a file, links in a circle
      if (!fs::exists(log, error)) refuse_input(log, "there is no such file or bag folder");
    }
    Scenario scenario;
    scenario.robot = fs::absolute(robot).string();
    scenario.floating_base = false;
    tree_ = load_repaired_robot(&scenario).tree;
    for (int i = 0; i < tree_.num_joints(); ++i) joints_.push_back(tree_.joint(i).name);
    if (joints_.empty())
      refuse_input(robot, "has no joint that moves: write the experiment by hand (docs/diagnosis.md)");
  }

  Draft write() {
    write_recordings();
    const auto text = std::find_if(logs_.begin(), logs_.end(), is_text);
    if (text != logs_.end())
      write_columns(*text);
    else if (is_ros_bag(logs_[0]))
      write_topics(logs_[0]);
    else
      write_drive(true, true);
    if (floats() && feet_.empty()) ask("which links of the model are its feet: 'feet: [left_foot, right_foot]'");
    draft_.text = make_head() + out_.str();
    return draft_;
  }

 private:
  std::string name_from_folder(const std::string& path) const {
    return fs::absolute(path).lexically_normal().lexically_relative(folder_.lexically_normal()).string();
  }

  void ask(const std::string& what) { draft_.asked.push_back(what); }

  // A robot that carries an inertial sensor, or forces under feet, moves as a whole. A root that is the world has no
  // mass.
  bool floats() const { return (imu_ || stands_) && tree_.links[0].inertia.mass > 0.0; }

  std::string make_head() const {
    std::string base = "base: fixed        # (?) or floating, for a robot on its feet\n";
    if (floats()) {
      base = "base: floating     # (?) as the log has " +
             std::string(imu_ ? "an inertial sensor" : "forces under feet") +
             "; fixed, for a robot that is bolted down\n"
             "ground: {type: plane, height: 0.0, friction: 0.8}\nfeet: [" +
             join_words(feet_, quote_name) +
             "]           # (?) the links that touch the ground: [left_foot, right_foot]\n";
    }
    return "# A draft: look at every line. Lines with (?) ask for what only you know.\nrobot: " +
           quote_name(name_from_folder(robot_)) + "\n" + base;
  }

  void write_recordings() {
    out_ << "recordings:\n";
    for (size_t i = 0; i < logs_.size(); ++i) {
      const bool held_out = logs_.size() > 1 && i + 1 == logs_.size();
      out_ << "  - {file: " << quote_name(name_from_folder(logs_[i])) << ", role: " << (held_out ? "validate" : "train")
           << "}\n";
    }
    if (logs_.size() == 1)
      ask("a second log of another motion, with 'role: validate': values of one recording alone are hardly certain");
  }

  void write_topics(const std::string& path) {
    const BagDraft bag = draft_bag(path, tree_);
    write_drive(bag.commands, bag.efforts);
    out_ << bag.text;
    imu_ = bag.imu;
    draft_.found.insert(draft_.found.end(), bag.found.begin(), bag.found.end());
    draft_.asked.insert(draft_.asked.end(), bag.asked.begin(), bag.asked.end());
  }

  // Of the first log; others are expected to look alike.
  void write_columns(const std::string& path) {
    log_ = read_log_columns(path);
    for (const std::string& name : log_.names) ++uses_[name];
    meanings_ = find_meanings(log_.names, joints_);
    take_named_joints(log_.names, log_.first, joints_, &meanings_);
    if (std::find(log_.names.begin(), log_.names.end(), "/joint_states/" + joints_[0] + "/position") !=
        log_.names.end()) {
      draft_.found.push_back("the header names the signals itself: no columns are needed");
      const auto has_signal = [&](const std::string& begin, const std::string& end) {
        return std::any_of(log_.names.begin(), log_.names.end(),
                           [&](const std::string& name) { return name.rfind(begin, 0) == 0 && ends_with(name, end); });
      };
      write_drive(has_signal("/joint_commands/", "/position"), has_signal("/joint_states/", "/effort"));
      return;
    }
    std::ostringstream columns;
    columns << "columns:            # docs/text_recordings.md\n";
    write_time(&columns);
    used_.resize(log_.count, false);
    take_pairs();
    write_imu(&columns);
    write_feet(&columns);
    take_turns_from_speeds();
    take_degrees_from_limits();
    const size_t commands = write_signals(ColumnKind::kPosition, true, "position", &columns);
    const size_t positions = write_signals(ColumnKind::kPosition, false, "position", &columns);
    const size_t velocities = write_signals(ColumnKind::kVelocity, false, "velocity", &columns);
    write_signals(ColumnKind::kVelocity, true, "velocity", &columns);
    size_t efforts = write_efforts(false, &columns);
    const size_t commanded = write_efforts(true, &columns);
    if (efforts == 0 && commands == 0) efforts = commanded;
    if (positions == 0) ask("which columns are the joints' positions");
    if (imu_ || !feet_.empty()) out_ << "sensors:\n";
    if (imu_)
      out_ << "  imu:\n    body: {link: " << quote_name(tree_.links[0].name) << "}   # (?) the link that carries it\n";
    const char* frame =
        upright_ ? ", frame: world}   # (?) one force a foot is taken as upright; without 'frame', along the link's z\n"
                 : "}\n";
    for (const std::string& foot : feet_)
      out_ << (foot == feet_[0] ? "  wrench:\n" : "") << "    " << quote_name(foot) << ": {link: " << quote_name(foot)
           << frame;
    write_drive(commands > 0, efforts > 0);
    out_ << columns.str();
    ask_for_joints();
    write_unused();
    if (std::any_of(meanings_.begin(), meanings_.end(),
                    [](const ColumnMeaning& m) { return m.joint >= 0 && m.index >= 0; }) &&
        joints_.size() > 1)
      ask("whether the numbers in the columns' names count the joints in the model's order: " + join_words(joints_));
    const std::string of = " of " + std::to_string(joints_.size()) + " joints: ";
    draft_.found.push_back("positions" + of + std::to_string(positions) +
                           "; velocities: " + std::to_string(velocities) + "; efforts: " + std::to_string(efforts) +
                           "; commanded positions: " + std::to_string(commands));
  }

  void write_imu(std::ostringstream* columns) {
    for (const ImuColumn& found : find_imu_columns(log_.names)) {
      *columns << "  /imu/body/" << found.signal << ": " << find_place(found.column) << "\n";
      used_[found.column] = imu_ = true;
    }
    if (imu_)
      draft_.found.push_back("an inertial sensor, taken as mounted along the axes of the link '" + tree_.links[0].name +
                             "'");
  }

  void write_feet(std::ostringstream* columns) {
    const std::vector<FootColumn> forces = find_foot_columns(log_.names, tree_);
    // Two feet: one may be a hopper's on a rail.
    stands_ = std::any_of(forces.begin(), forces.end(),
                          [&](const FootColumn& f) { return f.foot && forces[0].foot && f.link != forces[0].link; });
    std::set<std::string> written;  // the first column of a force counts
    for (const FootColumn& found : floats() ? forces : std::vector<FootColumn>{}) {
      const std::string signal = "/wrench/" + found.link + "/force/" + found.axis;
      if (used_[found.column] || !written.insert(signal).second) continue;
      *columns << "  " << quote_name(signal) << ": " << find_place(found.column) << "\n";
      used_[found.column] = true;
      upright_ = upright_ && found.axis == "z";
      if (std::find(feet_.begin(), feet_.end(), found.link) == feet_.end()) feet_.push_back(found.link);
    }
    if (!feet_.empty())
      draft_.found.push_back("forces under " + std::to_string(feet_.size()) + " feet: " + join_words(feet_));
  }

  // Without names: a position and its rate for each joint, and as many other columns, which are the efforts.
  void take_pairs() {
    if (!log_.names.empty() || time_ < 0) return;
    std::vector<ColumnMeaning> meanings(log_.count);
    int pairs = 0, others = 0;
    const auto is_free = [&](size_t i) {
      return meanings[i].kind == ColumnKind::kNone && static_cast<int>(i) != time_;
    };
    for (size_t i = 0; i < log_.count; ++i) {
      double most = 0.9;
      size_t rate = i;
      for (size_t k = 0; k < log_.count && is_free(i); ++k) {
        const double alike = k == i || !is_free(k) ? 0.0 : calc_rate_correlation(column(i), column(k), time());
        const bool same_unit =
            alike > most && std::abs(time_scale_ * calc_travel_ratio(column(i), column(k), time()) - 1.0) < 0.1;
        if (same_unit) {
          most = alike;
          rate = k;
        }
      }
      if (rate == i) continue;
      meanings[i].kind = ColumnKind::kPosition;
      meanings[rate].kind = ColumnKind::kVelocity;
      meanings[i].joint = meanings[rate].joint = pairs++;
    }
    for (size_t i = 0; i < log_.count; ++i) {
      if (is_free(i)) {
        meanings[i].kind = ColumnKind::kEffort;
        meanings[i].joint = others++;
      }
    }
    if (pairs != static_cast<int>(joints_.size()) || others != pairs) return;
    meanings_ = std::move(meanings);
    ask("whether the columns are positions, their velocities and efforts, in the model's order of the joints: the file "
        "has no header, but one column is the rate of another");
  }

  // Counts of an encoder, by the velocity beside them if its unit is known.
  void take_turns_from_speeds() {
    for (size_t i = 0; i < meanings_.size() && time_ >= 0; ++i) {
      ColumnMeaning& m = meanings_[i];
      if (m.kind != ColumnKind::kPosition || !m.counts || m.scale > 0.0) continue;
      for (size_t v = 0; v < meanings_.size(); ++v) {
        const ColumnMeaning& speed = meanings_[v];
        if (speed.kind != ColumnKind::kVelocity || speed.command || speed.joint != m.joint || !(speed.scale > 0.0) ||
            calc_rate_correlation(column(i), column(v), time()) < 0.9)
          continue;
        m.scale = speed.scale * time_scale_ * calc_travel_ratio(column(i), column(v), time());
        draft_.found.push_back("column " + find_place(i) + ": " + std::to_string(std::lround(2.0 * M_PI / m.scale)) +
                               " counts a turn, by column " + find_place(v));
        break;
      }
      if (!(m.scale > 0.0))
        ask("how many counts a turn column " + find_place(i) + " has: 'scale' is 6.2831853 by that number");
    }
  }

  // A motor before its gear turns as far as degrees do.
  void take_degrees_from_limits() {
    for (size_t i = 0; i < meanings_.size(); ++i) {
      ColumnMeaning& m = meanings_[i];
      if (m.kind != ColumnKind::kPosition || m.counts || m.scale > 0.0 || m.joint < 0) continue;
      const double largest = find_largest(column(i));
      if (!may_be_degrees(tree_.joint(m.joint), largest)) continue;
      m.scale = 1.0 / kDegrees;
      ask("whether column " + find_place(i) + " is in degrees: it reaches " + format_short(largest) +
          ", far beyond the joint's limits [rad]. Or is it the angle of the motor, before the gear?");
    }
  }

  // A name in Latin-1 cannot stand in YAML, and one that stands twice in the header means no column.
  std::string find_place(size_t column) const {
    const std::string name = log_.names.empty() ? "" : log_.names[column];
    const bool usable = !name.empty() && uses_.at(name) == 1 && find_strange_byte(name) == std::string::npos;
    return usable ? quote(name) : std::to_string(column + 1);
  }

  void write_time(std::ostringstream* columns) {
    for (size_t i = 0; i < log_.count; ++i) {
      const double period = find_stamp_period(log_.table.columns[i]);
      const bool named = i < meanings_.size() && meanings_[i].kind == ColumnKind::kTime;
      if (period <= 0.0 || !(named || log_.names.empty())) continue;
      const double scale = named && meanings_[i].scale > 0.0 ? meanings_[i].scale
                                                             : find_time_scale(period, log_.table.columns[i].front());
      *columns << "  time: {column: " << find_place(i) << ", scale: " << format_exact(scale) << "}   # "
               << format_short(1.0 / (period * scale)) << " Hz\n";
      time_scale_ = scale;
      draft_.found.push_back("time: column " + find_place(i) + ", " + format_short(1.0 / (period * scale)) +
                             " samples a second");
      time_ = static_cast<int>(i);
      return;
    }
    for (size_t i = 0; i < meanings_.size(); ++i) {
      const std::vector<double>& stamps = column(i);
      const auto back = std::is_sorted_until(stamps.begin(), stamps.end());
      if (meanings_[i].kind != ColumnKind::kTime || back == stamps.end()) continue;
      ask("what happened to the clock: column " + find_place(i) + " goes back from " + format_exact(back[-1]) + " to " +
          format_exact(*back) + ", in row " + std::to_string(back - stamps.begin() + 1) +
          " of the numbers. Cut the file there, or mend the stamps");
    }
    const RatePair pair = find_rate_pair(log_.table.columns);
    const std::string by = pair.rate > 0.0 ? "; so column " + find_place(pair.velocity) + " is the rate of column " +
                                                 find_place(pair.position) + " in the same unit"
                                           : "";
    out_ << "sample_rate: " << (pair.rate > 0.0 ? format_short(pair.rate) : "100")
         << "    # (?) [Hz]: no column of time was found" << by << "\n";
    ask("the rate of the samples, or the column of time");
  }

  // Torques; where there are none, what is closest to them.
  size_t write_efforts(bool command, std::ostringstream* columns) {
    for (const EffortUnit& unit : kEffortUnits) {
      const size_t count = write_signals(ColumnKind::kEffort, command, "effort", columns, unit);
      if (count == 0) continue;
      if (unit.of != EffortOf::kTorque && !command)
        ask("the factor of the efforts: their columns hold " + std::string(unit.what) + ", no torque. It is " +
            unit.factor +
            ". With the factor 1, all torques and inertias of the report are in the unit of the log, or in the one "
            "that it finds");
      return count;
    }
    return 0;
  }

  // One line a joint. Returns how many joints have one.
  size_t write_signals(ColumnKind kind, bool command, const std::string& name, std::ostringstream* columns,
                       const EffortUnit& unit = kEffortUnits[0]) {
    size_t count = 0;
    for (size_t joint = 0; joint < joints_.size(); ++joint) {
      for (size_t i = 0; i < meanings_.size(); ++i) {
        const ColumnMeaning& m = meanings_[i];
        if (m.kind != kind || m.of != unit.of || m.command != command || m.joint != static_cast<int>(joint) || used_[i])
          continue;
        *columns << "  " << quote_name((command ? "/joint_commands/" : "/joint_states/") + joints_[joint] + "/" + name)
                 << ": ";
        if (unit.of != EffortOf::kTorque)
          *columns << "{column: " << find_place(i) << ", scale: " << format_exact(m.scale > 0.0 ? m.scale : 1.0)
                   << "}   # (?) " << unit.what << "\n";
        else if (m.scale > 0.0)
          *columns << "{column: " << find_place(i) << ", scale: " << format_exact(m.scale) << "}\n";
        else
          *columns << find_place(i) << "\n";
        used_[i] = true;
        ++count;
        break;
      }
    }
    return count;
  }

  void write_drive(bool commands, bool efforts) {
    if (!commands) {
      out_ << (efforts || !floats() ? "drive: effort\n" : "drive: motion\n");
      if (!efforts && !floats())
        ask("the columns of the efforts or of the commands: without either, nothing tells what moved the robot");
      return;
    }
    out_ << "servo:              # (?) gains of the position loops: kp [N m/rad], kd [N m s/rad]; or 'drive: effort' "
            "instead of this\n"
         << "  default: {kp: 100, kd: 1}\n";
    ask("the gains of the servos (servo.default), or 'drive: effort' where the log has the drives' efforts");
  }

  // What the other columns look like, so that a person can name them.
  void write_unused() {
    bool any = false;
    for (size_t i = 0; i < log_.count; ++i) {
      if (used_[i] || static_cast<int>(i) == time_) continue;
      const std::vector<double> values = find_values(log_.table.columns[i]);
      if (!any) out_ << "# Columns that are not used yet:\n";
      any = true;
      out_ << "#   " << find_place(i) << ": ";
      if (values.empty()) {
        out_ << "no numbers\n";
        continue;
      }
      const auto [low, high] = std::minmax_element(values.begin(), values.end());
      out_ << format_short(*low) << " to " << format_short(*high) << find_relation(i) << "\n";
    }
    if (any && log_.names.empty())
      ask("which column is which signal: the file has no header. The comments at the end of the draft describe each "
          "column");
  }

  // Columns whose names say what they are, but not of which joint: the current of one of two drives.
  void ask_for_joints() {
    for (size_t i = 0; i < meanings_.size() && joints_.size() > 1; ++i) {
      const ColumnMeaning& m = meanings_[i];
      if (used_[i] || m.joint >= 0 || m.kind == ColumnKind::kNone || m.kind == ColumnKind::kTime) continue;
      const char* what = m.kind == ColumnKind::kPosition   ? "a position"
                         : m.kind == ColumnKind::kVelocity ? "a velocity"
                                                           : "an effort";
      ask("which joint column " + find_place(i) + " belongs to: by its name it is " + what +
          (m.command ? ", commanded" : ""));
    }
  }

  // "; the rate of column 3": both ends of each derivative. Of names that say another quantity, only the gait is the
  // same.
  std::string find_relation(size_t column) const {
    const ColumnKind kind = column < meanings_.size() ? meanings_[column].kind : ColumnKind::kNone;
    if (kind != ColumnKind::kNone && kind != ColumnKind::kVelocity) return "";
    for (size_t other = 0; other < log_.count && time_ >= 0; ++other) {
      if (other == column || static_cast<int>(other) == time_) continue;
      if (calc_rate_correlation(this->column(other), this->column(column), time()) > 0.9)
        return "; the rate of column " + find_place(other);
    }
    return "";
  }

  const std::vector<double>& column(size_t i) const { return log_.table.columns[i]; }
  const std::vector<double>& time() const { return column(static_cast<size_t>(time_)); }

  std::string robot_;
  std::vector<std::string> logs_;
  fs::path folder_;
  TreeSpec tree_;
  std::vector<std::string> joints_;  // its names
  LogColumns log_;
  std::map<std::string, int> uses_;  // of each name in its header
  std::vector<ColumnMeaning> meanings_;
  std::vector<bool> used_;
  std::vector<std::string> feet_;  // links with a sensor of force
  bool upright_ = true;            // they have one force each
  bool imu_ = false;               // the log has an inertial sensor
  bool stands_ = false;            // it has forces under two feet
  int time_ = -1;
  double time_scale_ = 1.0;  // of its column, to seconds
  std::ostringstream out_;
  Draft draft_;
};

}  // namespace

Draft make_draft(const std::string& robot, const std::vector<std::string>& logs, const std::string& folder) {
  return DraftWriter(robot, logs, folder).write();
}

}  // namespace hrp::diagnosis
