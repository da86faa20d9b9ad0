// SPDX-License-Identifier: BSD-3-Clause
// Rows of the body's and its joints' equations at one sample: residuals, and how one unit of each effect changes them.
#pragma once

#include <memory>

#include "common/multibody/regressor.h"
#include "diagnosis/floating/equations/residuals.h"

namespace hrp::diagnosis::floating {

// What stays the same from sample to sample of a log.
struct BodyEquations {
  const LeggedLog& log;
  const Contacts& contacts;
  const ColumnLayout& layout;
  const BodyChannels& channels;
  RowTable& table;
  std::unique_ptr<Regressor> regressor;   // memory of the links' columns
  std::vector<std::vector<double>> ways;  // by joint, by sample of the clip: direction of motion, -1 to 1
};

// The rows that are open at a sample.
class BodyRows {
 public:
  BodyRows(const BodyEquations& equations, const BodySample& sample);

  const BodySample& at() const { return at_; }
  const Vector3d& normal() const { return normal_; }
  const BodyResiduals& nominal() const { return nominal_; }
  bool is_open(int row) const { return open_[static_cast<size_t>(row)] != 0; }
  // Whether an equation that is open has the torque of a joint in it.
  bool uses_joint(int j) const { return is_open(kJointRow + j) || (shares_.size() > 0 && shares_.col(j).any()); }

  // Adds to a column what one unit of its effect changes in a row, if the row is open. A torque of a leg that tells the
  // ground's force changes the base's equations, too.
  void put(int row, double value, int column) {
    if (is_open(row)) equations_.table.add(equations_.channels.row[static_cast<size_t>(row)], column, value);
    for (int i = 0; row >= kJointRow && i < shares_.rows(); ++i) put(i, -shares_(i, row - kJointRow) * value, column);
  }
  // The same in all rows.
  void put_all(const Eigen::VectorXd& by_row, int column);
  // The same of a wrench on a link that the sensors feel (sign 1), or that acts on the robot beside them (-1).
  void put_wrench(const PointWrench& wrench, double sign, int column);
  // How the residuals change by a unit of what has moved `sample.motion` by `step` units.
  Eigen::VectorXd calc_slope(double step) const;

 private:
  void open(int row, double y, double measured);
  void open_by_legs();

  const BodyEquations& equations_;
  BodySample at_;
  Vector3d normal_;
  BodyResiduals nominal_;
  std::vector<char> open_;  // by row
  Eigen::MatrixXd shares_;  // of joints in the base's equations (leg_forces.h); empty: they are not compared by legs
};

// Columns of links: mass, first moments and inertia.
void add_link_columns(BodyEquations* equations, BodyRows* rows);
// Columns of forces from outside, 1 N each. On links: constant in the world, and in proportion to the place of the
// body, with a symmetric stiffness along the ground as a tether has. On feet: by the time from lifting and landing.
void add_pull_columns(const BodyEquations& equations, BodyRows* rows);
// Columns of drives: friction, rotor, gain, spring, lag, delay.
void add_drive_columns(const BodyEquations& equations, BodyRows* rows);
// Columns of encoders' zeros, play and give of a joint, which is turned by kSlopeStep.
void add_turn_columns(const JointTurn& turn, BodyRows* rows);
// Columns of force sensors and of the main IMU.
void add_force_sensor_columns(const BodyEquations& equations, BodyRows* rows);
void add_accelerometer_columns(const BodyEquations& equations, BodyRows* rows);
void add_gyroscope_columns(const BodyEquations& equations, BodyRows* rows);

// Rows of logged efforts against the servo law.
void add_servo_rows(const BodyEquations& equations, const BodySample& at);

}  // namespace hrp::diagnosis::floating
