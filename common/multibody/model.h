// SPDX-License-Identifier: BSD-3-Clause
// Constant model of a tree of rigid bodies and the working data of its algorithms.
//
// All algorithms work in world axes about each link's own origin: the articulated inertia of a link needs no rotation
// on its way to the parent (only the shift of its origin), wrenches and contact impedances enter as they are, and no
// precision is lost far away from the base. Accelerations are classical: [alpha; acceleration of the link's origin].
// Generalised velocity v = [w_WB_W; v_WB_W; qd], generalised force = [moment about B's origin; force; efforts]; a fixed
// base has neither of the first two.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/state.h"
#include "common/multibody/tree_spec.h"
#include "common/spatial/small.h"

namespace hrp {

// Outcome of a calculation that can fail for numeric reasons.
enum class [[nodiscard]] Status{
    kOk,
    kSingular,   // an articulated inertia is not positive: massless subtree, negative extra inertia
    kNotFinite,  // NaN or infinity in the input or the result
};

const char* get_status_text(Status status);

// How a joint turns or slides, resolved when the model is made.
enum class JointCode : signed char { kTurnX, kTurnY, kTurnZ, kTurnAny, kSlide };

// Constants of link L and of the joint that moves it.
struct LinkConstants {
  int parent = -1;
  JointCode code = JointCode::kTurnZ;
  bool turned = false;  // R_PF is not the identity
  double sign = 1.0;    // direction of a coordinate axis
  double rotor_inertia = 0.0;
  small::M3 R_PF;
  small::V3 p_PF;
  small::V3 axis_F;
  double mass = 0.0;
  small::V3 h;  // [kg m] mass times centre of mass, link axes
  small::S3 I;  // [kg m^2] about the link's origin, link axes
  // I = I_least 1 + I_u I_u^T + I_v I_v^T: turning two vectors is cheaper than turning a matrix.
  double I_least = 0.0;
  small::V3 I_u, I_v;
};

// I in world axes.
inline small::S3 calc_turned_inertia(const LinkConstants& L, const small::M3& R_WL) {
  const small::V3 u = R_WL * L.I_u, v = R_WL * L.I_v;
  return {L.I_least + u.x * u.x + v.x * v.x, u.x * u.y + v.x * v.y, u.x * u.z + v.x * v.z,
          L.I_least + u.y * u.y + v.y * v.y, u.y * u.z + v.y * v.z, L.I_least + u.z * u.z + v.z * v.z};
}

// Constant after construction. Throws InputError naming link or joint when the tree cannot be computed with.
class Model {
 public:
  explicit Model(const TreeSpec& spec, const Vector3d& gravity_W = Vector3d(0, 0, -9.81));
  static Model make(const TreeSpec& spec, const Vector3d& gravity_W = Vector3d(0, 0, -9.81)) {
    return Model(spec, gravity_W);
  }

  const TreeSpec& spec() const { return spec_; }
  bool floating() const { return spec_.floating_base; }
  int num_links() const { return static_cast<int>(links_.size()); }
  int num_joints() const { return num_links() - 1; }
  int num_base() const { return spec_.floating_base ? 6 : 0; }  // rows of the base in v
  int nv() const { return num_base() + num_joints(); }
  const Vector3d& gravity_W() const { return gravity_W_; }
  double mass() const { return mass_; }  // [kg] of all links
  int parent(int link) const { return links_[static_cast<size_t>(link)].parent; }
  // Position in v of the joint that moves `link` (> 0).
  int velocity_index(int link) const { return num_base() + link - 1; }
  bool is_ancestor(int ancestor, int link) const;  // a link is its own ancestor
  const std::vector<LinkConstants>& links() const { return links_; }
  // All links but the base, parents before children, limb beside limb: neighbours in this order do not wait for each
  // other's results, which is worth a quarter of the time of forward dynamics.
  const std::vector<int>& order() const { return order_; }

 private:
  TreeSpec spec_;
  Vector3d gravity_W_;
  double mass_ = 0.0;
  std::vector<LinkConstants> links_;
  std::vector<int> order_;
};

// Pose and velocity of one link, world axes.
struct LinkKinematics {
  small::M3 R;     // R_WL
  small::V3 p;     // p_WL
  small::V3 r;     // parent's origin to this origin
  small::V3 axis;  // joint axis
  small::V3 w;     // w_WL
  small::V3 v;     // v_WL
};

// Acceleration with vdot = 0 (velocity products) and no gravity, and rigid-body forces it takes; see inverse_dynamics.
struct LinkMotion {
  small::V3 alpha, acc;  // [rad/s^2], [m/s^2]
  small::V3 n, f;        // moment about the link's origin, force
};

// Articulated inertia A = [J H; H^T M] and what the solves need of it.
struct LinkArticulated {
  small::S3 J;
  small::M3 H;
  small::S3 M;
  small::V3 Un, Uf;  // A times joint axis
  double D_inverse;
  double u;              // effort that is left for the joint
  small::V3 n, f;        // bias force of the articulated body
  small::V3 alpha, acc;  // acceleration
};

// Composite rigid body.
struct LinkComposite {
  double mass;
  small::V3 h;
  small::S3 I;
};

// Working memory of one model; every vector has its size from construction on. Which function fills what is said there.
struct Data {
  explicit Data(const Model& model);

  std::vector<LinkKinematics> kinematics;    // update_kinematics
  std::vector<LinkMotion> motion;            // calc_inverse_dynamics, calc_bias, calc_forward_dynamics
  std::vector<LinkArticulated> articulated;  // calc_forward_dynamics
  std::vector<LinkComposite> composite;      // update_mass_matrix
  Eigen::MatrixXd M;                         // nv x nv, update_mass_matrix
  Matrix6d base_factor = Matrix6d::Zero();   // L D L^T of the base's articulated inertia, lower triangle
  Eigen::VectorXd qd;                        // copy of the state's joint velocities, update_kinematics
  Eigen::VectorXd scratch, response;         // nv
  Eigen::VectorXd sine, cosine;              // of joint positions
};

}  // namespace hrp
