// SPDX-License-Identifier: BSD-3-Clause
// Recorded or made joint motions: files and playing.
//
// Formats: .csv  our own. '#' lines are comments; then a header "time,JOINT,JOINT,..." and one line a frame: seconds,
//                then rad or m. Times rise strictly; steps may differ. Columns named like those of an experiment
//                recording ("/joint_commands/JOINT/position") are understood, others with a slash are left out.
//          .seq  Choreonoid's body motion (YAML text): frameRate and the component with content JointDisplacement. It
//          has
//                no joint names; `joint_order` gives them. Other components (ZMP, root) are left out.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Dense>

namespace hrp {

struct Motion {
  std::vector<std::string> joints;  // names of the columns
  std::vector<double> times;        // [s] strictly rising, the first is 0
  Eigen::MatrixXd positions;        // [rad or m] joints x frames: a frame is a column

  double duration() const { return times.empty() ? 0.0 : times.back(); }
};

// Reads `path` by its suffix. Throws InputError with file, line and reason. `joint_order` is needed for .seq files and
// must be empty for .csv files.
Motion load_motion(const std::string& path, const std::vector<std::string>& joint_order);
Motion parse_csv_motion(const std::string& text, const std::string& path);
Motion parse_seq_motion(const std::string& text, const std::string& path, const std::vector<std::string>& joint_order);

// Plays a motion on a robot: cubic Hermite interpolation whose slopes are central differences (one-sided at both ends,
// zero beyond them). Before the first and after the last frame the pose is held.
class MotionPlayer {
 public:
  // `robot_joints`: order of the commands. Joints without a column keep `rest` [rad or m]. Throws InputError when a
  // column is no joint of the robot; `path` is for that message.
  MotionPlayer(Motion motion, const std::vector<std::string>& robot_joints, const Eigen::VectorXd& rest,
               const std::string& path);

  // Reference at time t [s]; q and qd are resized to the robot's joints. A pure function of t.
  void sample(double t, Eigen::VectorXd* q, Eigen::VectorXd* qd) const;
  double duration() const { return motion_.duration(); }

 private:
  size_t find_interval(double t) const;

  Motion motion_;
  Eigen::MatrixXd slopes_;        // [1/s] as positions
  std::vector<int> robot_index_;  // by column
  Eigen::VectorXd rest_;
};

}  // namespace hrp
