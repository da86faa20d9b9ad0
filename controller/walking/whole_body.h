// SPDX-License-Identifier: BSD-3-Clause
// The robot's description put to use: joint angles that realise centre of mass, body attitude and soles of a pattern.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/multibody/kinematics.h"
#include "common/robot/robot_description.h"
#include "common/robot/walk_spec.h"
#include "controller/motion/leg.h"
#include "controller/walking/footsteps.h"
#include "controller/walking/pattern.h"

namespace hrp::walking {

class WholeBody {
 public:
  // `rest`: positions of all joints that are not in the legs. Joints without a drive (rubber) count as unloaded.
  // Throws InputError: no such foot, a leg without six joints to the base.
  WholeBody(const RobotDescription& robot, const WalkSpec& spec, const Eigen::VectorXd& rest);

  double mass() const { return model_.mass(); }
  // Pose of a sole (axes of the foot with the robot straight, origin in the middle of the sole) and centre of mass,
  // both in base axes, and the pose of any frame, for encoder readings `q`.
  void update(const Eigen::VectorXd& q);
  Transform get_sole(Side side) const;
  Vector3d get_com() const;
  Transform get_frame(int frame) const;
  int find_frame(const std::string& name) const { return model_.spec().find_frame(name); }
  // Sole in the axes of the foot's link.
  const Transform& sole_in_foot(Side side) const { return legs_[side].X_LS; }

  // Joint angles for a centre of mass (world), base attitude and soles (world). The centre of mass is that of all
  // links: found by iteration, to 1e-6 m. False when a leg does not reach; *q then has the last angles that did.
  bool solve(const Vector3d& com, const Matrix3d& R_WB, const Transform soles[2], Eigen::VectorXd* q);
  bool has_closed_form() const { return legs_[0].closed_form && legs_[1].closed_form; }

 private:
  struct Leg {
    int foot = 0;          // link
    int links[6] = {};     // from the hip down
    double signs[6] = {};  // of joint axes
    bool closed_form = false;
    LegGeometry geometry;
    Vector3d p_BH = Vector3d::Zero();  // hip
    Transform X_LS;
  };
  Leg make_leg(const RobotDescription& robot, const std::string& foot);
  void recognise(const TreeSpec& tree, Leg* leg) const;
  bool solve_closed(const Leg& leg, const Transform& X_BF);
  bool solve_numerically(const Leg& leg, const Transform& X_BF);

  Model model_;
  Data data_;
  State state_;  // base at the origin
  Eigen::MatrixXd J_;
  Leg legs_[2];
};

// Axes of a pattern, level with the heading of the feet, from the world in which the base has this attitude.
Matrix3d calc_pattern_axes(const WholeBody& body, const Matrix3d& R_WB);

// Where a pattern begins; its origin is between the soles. `R_PB`: base in the pattern's axes.
PatternStart make_pattern_start(const WholeBody& body, const Matrix3d& R_PB);

}  // namespace hrp::walking
