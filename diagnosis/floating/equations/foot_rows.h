// SPDX-License-Identifier: BSD-3-Clause
// Equations of feet that stand: tilt of flat soles against the level ground, and heights of feet against each other.
// Where nothing tells the vertical, the closed chain of two legs is left: tilt and height of soles against the first
// one.
#pragma once

#include "diagnosis/floating/equations/joint_turns.h"
#include "diagnosis/floating/fit/columns.h"
#include "diagnosis/floating/fit/row_table.h"
#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {

// Whether a force [N] with this moment [N m] about the middle of a sole, foot axes, presses well inside its edges.
bool presses_inside(const Foot& foot, const Vector3d& moment, double force);

class FootRows {
 public:
  FootRows(const LeggedLog& log, const Contacts& contacts, const ColumnLayout& layout, RowTable* table);
  // Adds the rows of sample k, where `motion` stands.
  void add(size_t clip, size_t k, BodyMotion* motion);
  // Adds the columns of a turn to the rows of the last sample; `motion` stands there with the joint turned by
  // kSlopeStep.
  void add_turn(const JointTurn& turn, BodyMotion* motion);

 private:
  struct Load {
    bool known = false, flat = false;
    double force = 0, rate = 0;                // [N, N/s] on the sole, along the foot's normal
    Vector3d moment{0, 0, 0}, whole{0, 0, 0};  // [N m] about the sole's centre, [N]; foot axes
  };
  Load find_load(size_t clip, size_t foot, size_t k, BodyMotion* motion) const;
  double find_height_error(size_t a, size_t b) const;
  void find_ground();
  void add_sole_columns(size_t foot, int axis, std::vector<int>* columns) const;
  void add_sole(int channel, size_t foot, int axis, double factor, const Load& load, BodyMotion* motion);
  bool stands(size_t clip, size_t foot, size_t k) const;
  // `turn`: what is added to the vertical, base axes.
  Eigen::VectorXd calc_values(size_t clip, size_t k, const Vector3d& turn, BodyMotion* motion) const;
  void add_attitude(size_t clip, size_t k, const Eigen::VectorXd& y, const std::vector<int>& open, BodyMotion* motion);
  void add_plumb(size_t clip, size_t k, const Eigen::VectorXd& y, const std::vector<int>& open, BodyMotion* motion);

  const LeggedLog& log_;
  const Contacts& contacts_;
  const ColumnLayout& layout_;
  RowTable& table_;
  struct Pair {
    size_t a = 0, b = 0;
    int channel = -1;
  };
  std::vector<int> tilt_;  // by foot * 2, -1: none
  std::vector<int> imu_;   // by foot: an IMU on it, which sees its tilt; -1: none
  std::vector<Pair> pairs_;
  // Of the last sample: values, and the channels of open rows, -1: not open.
  struct Sample {
    size_t clip = 0, k = 0;
    Eigen::VectorXd y;
    std::vector<int> open;
  };
  Sample at_;
  int attitude_ = -1;  // IMU whose attitude tells the vertical; -1: none
  int plumb_ = -1;     // IMU whose accelerometer does, as a plumb line; -1: none
  int ground_ = -1;    // flat foot whose sole tells where the ground is, where nothing tells the vertical; -1: none
};

}  // namespace hrp::diagnosis::floating
