// SPDX-License-Identifier: BSD-3-Clause
// Which equations of the body, of its joints and of its servos a log allows, and when they hold.
//
// The equations of the body and its joints are numbered by row: 0 to 5 are moments and forces of the whole body (row 3
// is its weight where feet tell no other force), 6 + j is the torque of joint j.
#pragma once

#include "diagnosis/floating/equations/body_sample.h"
#include "diagnosis/floating/fit/columns.h"
#include "diagnosis/floating/fit/row_table.h"
#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {

constexpr int kWeightRow = 3;
constexpr int kJointRow = 6;  // of the first joint

struct BodyChannels {
  bool balances = false;  // rows 0 to 5 are compared, or rows 3 to 5
  // By joint: its torque tells the ground's force in rows 0 to 5; empty: sensors do, or nothing
  std::vector<char> legs;
  bool weighs = false;      // else: the weight alone
  std::vector<int> row;     // channel of the table by row, -1: not compared
  std::vector<int> servo;   // by joint, -1: not compared
  std::vector<int> pulled;  // links that something from outside may pull at
  std::vector<char> felt;   // by foot: its vertical force is recorded
  int joint(int j) const { return row[size_t{kJointRow} + static_cast<size_t>(j)]; }
};

// Adds the channels with the columns that may change them.
BodyChannels add_body_channels(const LeggedLog& log, const Contacts& contacts, const ColumnLayout& layout,
                               RowTable* table);

// Whether specific force and rate of the body come from the main IMU, so that its faults change all equations.
bool uses_accelerometer(const LeggedLog& log);
bool uses_gyroscope(const LeggedLog& log);

// Whether feet without a sensor are in the air at a sample, so that the others carry all of the weight.
bool is_weight_known(const BodySample& at, const Contacts& contacts, const BodyChannels& channels);

// Whether the motion of the base is known well enough for torques of joints. A pose that is differentiated twice misses
// the impacts of steps.
bool is_base_felt(const LeggedLog& log, const Contacts& contacts);

// Whether no foot beyond a joint bears an unknown force at a sample, so that the joint's torque can be compared.
bool is_joint_known(const BodySample& at, const Contacts& contacts, int joint);

}  // namespace hrp::diagnosis::floating
