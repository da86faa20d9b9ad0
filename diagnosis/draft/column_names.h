// SPDX-License-Identifier: BSD-3-Clause
// What the names of columns in other people's logs mean: "tau_J3", "left_knee_vel", "target_q_0", "Timestamp [ms]".
#pragma once

#include <string>
#include <vector>

namespace hrp::diagnosis {

enum class ColumnKind { kNone, kTime, kPosition, kVelocity, kEffort };

// What a column of efforts is in: a drive's current, duty or voltage is no torque before somebody gives the factor. The
// first ones are closer to the torque: a current is in proportion to it, a voltage contains the back-EMF.
enum class EffortOf { kTorque, kCurrent, kDuty, kVoltage };

struct ColumnMeaning {
  ColumnKind kind = ColumnKind::kNone;
  EffortOf of = EffortOf::kTorque;
  bool command = false;  // asked for, not measured
  int joint = -1;        // in the order of the names that were given; -1: none
  int index = -1;        // a number in the name where no joint is named: "q3"
  double scale = 0.0;    // to SI, as the name says: "deg", "ms"; 0: it says nothing
  bool counts = false;   // of an encoder; the name does not say how many a turn has
};

// Runs of letters, and runs of digits, in lower case; an upper-case letter after a lower-case one begins a word:
// "motorTorque_3".
std::vector<std::string> split_words(const std::string& text);

// Of one column. `joints`: names of the model's joints.
ColumnMeaning find_meaning(const std::string& column, const std::vector<std::string>& joints);

// Of all columns of a file: numbers in names become joints where a group of columns has one for each joint.
std::vector<ColumnMeaning> find_meanings(const std::vector<std::string>& columns,
                                         const std::vector<std::string>& joints);

// Of logs that hold the joints' names in cells: "field.position2" is of the joint that "field.name2" says in the first
// row.
void take_named_joints(const std::vector<std::string>& columns, const std::vector<std::string>& first,
                       const std::vector<std::string>& joints, std::vector<ColumnMeaning>* meanings);

}  // namespace hrp::diagnosis
