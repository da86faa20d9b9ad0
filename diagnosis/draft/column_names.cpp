// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/draft/column_names.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <tuple>

namespace hrp::diagnosis {
namespace {

struct Word {
  ColumnKind kind = ColumnKind::kNone;
  bool command = false, useless = false;  // useless: a derivative or mean of what is recorded, or another quantity
  double scale = 0.0;
  EffortOf of = EffortOf::kTorque;
  bool counts = false;
  bool bare = false;  // beside a joint's name alone it tells a position: "hip_cmd", "meas_hip"
};

const std::map<std::string, Word>& list_words() {
  using Q = ColumnKind;
  static const std::map<std::string, Word> words = [] {
    std::map<std::string, Word> all;
    const auto add = [&](std::initializer_list<const char*> names, Word word) {
      for (const char* name : names) all[name] = word;
    };
    add({"t", "time", "times", "timestamp", "stamp", "clock", "epoch"}, {Q::kTime, false, false, 0.0});
    add({"sec", "secs", "second", "seconds"}, {Q::kTime, false, false, 1.0});
    add({"msec", "millis", "milliseconds"}, {Q::kTime, false, false, 1e-3});
    add({"usec", "micros", "microseconds"}, {Q::kTime, false, false, 1e-6});
    add({"nsec", "nanos", "nanoseconds"}, {Q::kTime, false, false, 1e-9});
    add({"q", "pos", "position", "positions", "angle", "theta", "phi", "encoder", "enc"},
        {Q::kPosition, false, false, 0.0});
    add({"dq", "qd", "qdot", "vel", "velocity", "velocities", "speed", "omega", "thetadot", "dtheta", "dot", "rate"},
        {Q::kVelocity, false, false, 0.0});
    add({"tau", "torque", "torques", "effort", "efforts", "eff", "trq", "moment", "force"},
        {Q::kEffort, false, false, 0.0});
    add({"current", "currents", "cur", "iq", "amp", "amps", "ampere", "amperes"},
        {Q::kEffort, false, false, 0.0, EffortOf::kCurrent});
    add({"pwm", "duty", "dutycycle", "load"},
        {Q::kEffort, false, false, 0.0, EffortOf::kDuty});  // servos call their duty a load
    add({"voltage", "voltages", "volt", "volts"}, {Q::kEffort, false, false, 0.0, EffortOf::kVoltage});
    add({"cmd", "command", "commanded", "des", "desired", "target", "ref", "reference", "goal", "set", "setpoint"},
        {Q::kNone, true, false, 0.0, EffortOf::kTorque, false, true});
    add({"action"}, {Q::kNone, true, false, 0.0});  // of a policy, alone: in a unit of its own
    add({"meas", "measured", "actual", "present", "feedback", "fb"},
        {Q::kNone, false, false, 0.0, EffortOf::kTorque, false, true});
    add({"ddq",    "qdd",     "ddot",  "acc",    "acceleration", "accel",   "temp", "temperature", "error",
         "err",    "jerk",    "gyro",  "imu",    "quat",         "battery", "bus",  "supply",      "input",
         "enable", "enabled", "limit", "limits", "mode",         "flag",    "gain", "gains"},
        {Q::kNone, false, true, 0.0});
    add({"deg", "degree", "degrees"}, {Q::kNone, false, false, 0.017453292519943295, EffortOf::kTorque, false, true});
    // Only speeds have these units: "left_rpm".
    add({"rpm"}, {Q::kVelocity, false, false, 0.10471975511965977});
    add({"dps", "degps"}, {Q::kVelocity, false, false, 0.017453292519943295});
    add({"rps"}, {Q::kVelocity, false, false, 6.283185307179586});
    add({"radps"}, {Q::kVelocity, false, false, 1.0});
    add({"count", "counts", "tick", "ticks", "pulses"}, {Q::kNone, false, false, 0.0, EffortOf::kTorque, true});
    add({"ms"}, {Q::kNone, false, false, 1e-3});
    add({"us"}, {Q::kNone, false, false, 1e-6});
    add({"ns"}, {Q::kNone, false, false, 1e-9});
    add({"mnm", "mm", "ma", "mv"}, {Q::kNone, false, false, 1e-3});
    return all;
  }();
  return words;
}

std::string drop_digits(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); }), text.end());
  return text;
}

bool is_number(const std::string& word) { return std::isdigit(static_cast<unsigned char>(word[0])); }

// Takes the words of the joint's name out of `words`; false if they are not there in a row.
bool take_out(const std::vector<std::string>& name, std::vector<std::string>* words) {
  const auto at = std::search(words->begin(), words->end(), name.begin(), name.end());
  if (name.empty() || at == words->end()) return false;
  words->erase(at, at + static_cast<long>(name.size()));
  return true;
}

// The joint with the longest name that the words have: "left_hip_yaw" before "hip_yaw". Words that all URDFs have tell
// none apart.
int take_joint(const std::vector<std::string>& joints, std::vector<std::string>* words) {
  int best = -1;
  size_t longest = 0;
  std::vector<std::string> left = *words;
  for (size_t i = 0; i < joints.size(); ++i) {
    std::vector<std::string> name = split_words(joints[i]);
    for (int attempt = 0; attempt < 2; ++attempt) {
      std::vector<std::string> rest = *words;
      if (name.size() > longest && take_out(name, &rest)) {
        best = static_cast<int>(i);
        longest = name.size();
        left = rest;
      }
      if (name.size() < 2 || name.back() != "joint") break;
      name.pop_back();
    }
  }
  *words = left;
  return best;
}

// "mNm", "mA" and "mV" are two words each by their capital letters.
void join_units(std::vector<std::string>* words) {
  for (size_t i = 1; i < words->size(); ++i) {
    const std::string& unit = (*words)[i];
    if ((*words)[i - 1] != "m" || (unit != "nm" && unit != "a" && unit != "v")) continue;
    (*words)[i - 1] += unit;
    words->erase(words->begin() + static_cast<long>(i));
  }
}

// Of the words of a column that name no quantity, and no unit.
std::vector<std::string> list_other_words(const std::string& column) {
  std::vector<std::string> words = split_words(column);
  join_units(&words);
  words.erase(
      std::remove_if(words.begin(), words.end(), [](const std::string& w) { return list_words().count(w) > 0; }),
      words.end());
  return words;
}

// "fl sh" of "fl shoulder joint": each word begins the joint's own one.
bool is_short_for(const std::vector<std::string>& words, const std::string& joint) {
  std::vector<std::string> name = split_words(joint);
  if (name.size() > 1 && name.back() == "joint") name.pop_back();
  const auto begins = [](const std::string& word, const std::string& whole) {
    return is_number(word) ? word == whole : whole.compare(0, word.size(), word) == 0;
  };
  return words.size() == name.size() && std::equal(words.begin(), words.end(), name.begin(), begins);
}

// The joint that the words may be short for; -1: none, or more than one.
int find_short_name(const std::vector<std::string>& words, const std::vector<std::string>& joints) {
  int found = -1;
  for (size_t j = 0; j < joints.size(); ++j) {
    if (!is_short_for(words, joints[j])) continue;
    if (found >= 0) return -1;
    found = static_cast<int>(j);
  }
  return found;
}

// Columns of one quantity whose names, if short, tell a joint each: one such name may fit by chance.
void take_short_names(const std::vector<std::string>& columns, const std::vector<std::string>& joints,
                      std::vector<ColumnMeaning>* meanings) {
  struct Group {
    std::map<size_t, int> joint;  // by column
    std::set<int> told;           // joints, also those that other columns name in full
    size_t columns = 0;
  };
  std::map<std::tuple<ColumnKind, EffortOf, bool>, Group> groups;
  for (size_t i = 0; i < columns.size(); ++i) {
    const ColumnMeaning& m = (*meanings)[i];
    if (m.kind == ColumnKind::kNone || m.kind == ColumnKind::kTime) continue;
    Group& group = groups[{m.kind, m.of, m.command}];
    const int joint = m.joint >= 0 ? m.joint : find_short_name(list_other_words(columns[i]), joints);
    if (m.joint < 0) group.joint[i] = joint;
    if (joint >= 0) group.told.insert(joint);
    ++group.columns;
  }
  for (const auto& [quantity, group] : groups) {
    if (group.joint.size() < 2 || group.told.size() != group.columns) continue;
    for (const auto& [column, joint] : group.joint) {
      (*meanings)[column].joint = joint;
      (*meanings)[column].index = -1;
    }
  }
}

}  // namespace

std::vector<std::string> split_words(const std::string& text) {
  std::vector<std::string> words;
  char before = ' ';
  for (const char c : text) {
    const bool digit = std::isdigit(static_cast<unsigned char>(c)),
               letter = std::isalpha(static_cast<unsigned char>(c));
    const bool digit_before = std::isdigit(static_cast<unsigned char>(before)),
               letter_before = std::isalpha(static_cast<unsigned char>(before));
    const bool camel = std::isupper(static_cast<unsigned char>(c)) && std::islower(static_cast<unsigned char>(before));
    if ((digit && !digit_before) || (letter && (!letter_before || camel))) words.emplace_back();
    if (digit || letter) words.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    before = c;
  }
  return words;
}

ColumnMeaning find_meaning(const std::string& column, const std::vector<std::string>& joints) {
  ColumnMeaning meaning;
  std::vector<std::string> words = split_words(column);
  meaning.joint = take_joint(joints, &words);
  join_units(&words);
  bool useless = false, bare = meaning.joint >= 0;  // the joint's name, and nothing that tells of another quantity
  for (size_t i = 0; i < words.size(); ++i) {
    const auto known = list_words().find(words[i]);
    bare = bare && known != list_words().end() && known->second.bare;
    if (is_number(words[i])) {
      if (words[i].size() < 4) meaning.index = std::stoi(words[i]);
      continue;
    }
    // "q_d", "dq_d" are what libfranka calls desired ones.
    if (words[i] == "d" && i > 0 && meaning.kind != ColumnKind::kNone) meaning.command = true;
    if (known == list_words().end()) continue;
    // "target_pos_rate" is a velocity, "time_error" none: the later word tells more.
    if (known->second.kind != ColumnKind::kNone) {
      meaning.kind = known->second.kind;
      meaning.of = known->second.of;
    }
    if (known->second.scale > 0.0) meaning.scale = known->second.scale;
    meaning.command = meaning.command || known->second.command;
    meaning.counts = meaning.counts || known->second.counts;
    useless = useless || known->second.useless;
  }
  if (bare) meaning.kind = ColumnKind::kPosition;
  if (useless) meaning.kind = ColumnKind::kNone;
  if (meaning.of == EffortOf::kDuty || meaning.of == EffortOf::kVoltage)
    meaning.command = false;  // "pwm_cmd": what the drive was given
  if (meaning.kind == ColumnKind::kTime && (meaning.command || meaning.joint >= 0)) meaning.kind = ColumnKind::kNone;
  return meaning;
}

std::vector<ColumnMeaning> find_meanings(const std::vector<std::string>& columns,
                                         const std::vector<std::string>& joints) {
  std::vector<ColumnMeaning> meanings;
  std::map<std::string, std::vector<size_t>> numbered;  // by the name without its digits: one group of columns each
  bool timed = false;
  for (size_t i = 0; i < columns.size(); ++i) {
    ColumnMeaning meaning = find_meaning(columns[i], joints);
    if (meaning.kind == ColumnKind::kTime && timed) meaning.kind = ColumnKind::kNone;  // the first one counts
    timed = timed || meaning.kind == ColumnKind::kTime;
    const bool of_joint = meaning.kind != ColumnKind::kNone && meaning.kind != ColumnKind::kTime;
    if (of_joint && meaning.joint < 0) numbered[drop_digits(columns[i])].push_back(i);
    meanings.push_back(meaning);
  }
  // Columns of a group count the joints from 0 or 1; where there is one joint, they need no number.
  for (const auto& [name, list] : numbered) {
    std::set<int> indices;
    for (size_t i : list) indices.insert(meanings[i].index);
    const int first = *indices.begin();
    const bool counts = indices.size() == list.size() && list.size() == joints.size() && first >= 0 && first <= 1 &&
                        *indices.rbegin() == first + static_cast<int>(joints.size()) - 1;
    const bool alone = joints.size() == 1 && list.size() == 1;
    for (size_t i : list) {
      if (counts) meanings[i].joint = meanings[i].index - first;
      if (alone) meanings[i].joint = 0;
    }
  }
  take_short_names(columns, joints, &meanings);
  return meanings;
}

void take_named_joints(const std::vector<std::string>& columns, const std::vector<std::string>& first,
                       const std::vector<std::string>& joints, std::vector<ColumnMeaning>* meanings) {
  std::map<int, int> joint_of;  // by the number in the columns' names
  for (size_t i = 0; i < columns.size() && i < first.size(); ++i) {
    const std::vector<std::string> words = split_words(columns[i]);
    const auto joint = std::find(joints.begin(), joints.end(), first[i]);
    const bool name = std::any_of(words.begin(), words.end(),
                                  [](const std::string& word) { return word == "name" || word == "names"; });
    if (name && joint != joints.end() && (*meanings)[i].index >= 0)
      joint_of[(*meanings)[i].index] = static_cast<int>(joint - joints.begin());
  }
  for (ColumnMeaning& m : *meanings) {
    if (joint_of.empty() || m.index < 0 || m.kind == ColumnKind::kNone || m.kind == ColumnKind::kTime) continue;
    const auto named = joint_of.find(m.index);
    m.joint = named == joint_of.end() ? -1 : named->second;
    m.index = -1;
    if (m.joint < 0) m.kind = ColumnKind::kNone;  // of a joint that the model does not have
  }
}

}  // namespace hrp::diagnosis
