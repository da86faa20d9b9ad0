// SPDX-License-Identifier: BSD-3-Clause
// Predicts the readings of sensors on the links of a robot on a fixed base, from its masses and motion.
//
// The wrench that accelerates a link L: [moment about the world's origin; force], world axes,
//
//   W_L = [p_WC x m (a_C - g) + I_C alpha + omega x I_C omega;  m (a_C - g)],   C: centre of mass of L,
//
// minus other wrenches on it. A sensor measures the wrench that it transmits to the links beyond it:
//
//   joint torque behind the gear, on the joint's axis z:  tau =  z . sum of W about the joint [N m], positive like the
//     drive's effort; for a prismatic joint the force along z [N];
//   wrench in frame F:     wrench of the links beyond F on the body that F is fixed to: -sum of W about F's origin, F's
//     axes (a hanging load reads a force downwards);
//   IMU at point S of frame F:  R_WF^T omega [rad/s] and specific force R_WF^T (a_S - g) [m/s^2], F's axes.
//
// Friction and rotors of drives affect none of these readings.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "common/multibody/model.h"
#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

enum class LinkSensorKind { kTorque, kWrench, kImu };

// A sensor on the link side of a gear.
struct LinkSensor {
  LinkSensorKind kind = LinkSensorKind::kTorque;
  std::string name;    // prefix of its columns: "/wrench/hand", "/imu/hand", "/joint_states_link/elbow/effort"
  int joint = -1;      // of a joint torque
  int frame = -1;      // of the tree; of wrench and IMU
  int link = 0;        // the moving link that the frame is fixed to
  bool whole = true;   // the whole link is beyond the sensor, else only `below` of the frame
  bool world = false;  // the wrench was recorded in world axes
  Vector3d p_FS = Vector3d::Zero();  // [m] position of an IMU
};

// One reading of a sensor, with one or three components. The readings of all sensors form one vector.
struct ReadingGroup {
  size_t sensor = 0;
  std::string name, unit;  // "/wrench/hand/force", "N"
  int first = 0, size = 1;
};

// A trial load: a mass at a point of the link, where its wrench is linearised.
struct LoadPoint {
  int link = 0;
  Vector3d p_LP = Vector3d::Zero();  // [m]
};

// Predicts the readings of a set of sensors for one robot.
class LinkReadings {
 public:
  // `tree`: as the experiment states. `force_W`: [N] on each link's centre of mass, world axes, or empty.
  LinkReadings(const TreeSpec& tree, const Vector3d& gravity_W, const std::vector<Vector3d>& force_W,
               const std::vector<LinkSensor>& sensors);

  // The same robot with another gravity [m/s^2], world axes.
  LinkReadings turn(const Vector3d& gravity_W) const { return LinkReadings(tree_, gravity_W, force_W_, sensors_); }

  const std::vector<LinkSensor>& sensors() const { return sensors_; }
  const std::vector<ReadingGroup>& groups() const { return groups_; }
  long size() const { return size_; }

  // Sets the motion: positions, velocities, accelerations by joint.
  void move(const Eigen::VectorXd& q, const Eigen::VectorXd& v, const Eigen::VectorXd& a);

  // The functions below use this motion; rows: `size()` readings.
  Eigen::VectorXd calc() const;
  // Derivatives with respect to (m, m dx, m dy, m dz) of a point mass m near p_LP, by reading.
  Eigen::MatrixXd calc_load_columns(const LoadPoint& load) const;
  Eigen::VectorXd calc_mass_column(int link) const;    // for a relative change of the link's mass and inertia
  Eigen::MatrixXd calc_com_columns(int link) const;    // for a displacement of its centre of mass [m]
  Eigen::MatrixXd calc_force_columns(int link) const;  // for a force at its centre of mass [N], world axes
  bool is_beyond(size_t sensor, int link) const;       // the sensor measures that link

 private:
  struct Body;
  Body find_body(int link) const;
  Body find_below(const LinkSensor& sensor) const;
  Vector6d calc_needed(const Body& body, const LinkInertia& inertia) const;
  void add_passed(size_t sensor, const Vector6d& wrench, Eigen::Ref<Eigen::VectorXd> readings) const;
  void add_imu(const LinkSensor& sensor, long first, Eigen::VectorXd* readings) const;

  TreeSpec tree_;
  std::vector<LinkSensor> sensors_;
  std::vector<ReadingGroup> groups_;
  std::vector<int> first_;                 // by sensor
  std::vector<std::vector<char>> beyond_;  // by sensor, by link: the whole link is beyond the sensor
  std::vector<Vector3d> force_W_;
  Vector3d gravity_W_;
  long size_ = 0;
  Model model_;
  Data data_;
  State state_;
};

}  // namespace hrp::diagnosis
