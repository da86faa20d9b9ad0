// SPDX-License-Identifier: BSD-3-Clause
// Rigid contact by impulses ([H03 section 3.1]): what a step must do to the velocities so that nothing sinks in
// further, with Coulomb friction and restitution.
//
//   v' = v_free + A J^T P,  A = (M + implicit terms)^-1
//   normal:      0 <= P_n  complementary to  v_n' + e v_n(before) >= 0   (restitution only above a threshold speed)
//   tangential:  P_t minimises |v_t'| under |P_t| <= mu P_n
//
// Solved on the Delassus matrix G = J A J^T by projected Gauss-Seidel in a fixed order, a fixed greatest number of
// sweeps, ended early when no impulse changes. What is left of the penetration is taken out by a second, frictionless
// solve whose velocity moves positions but is forgotten afterwards: it adds no kinetic energy.
#pragma once

#include <vector>

#include "common/multibody/forward_dynamics.h"
#include "servers/dynamics/contact_work.h"

namespace hrp {

struct ImpulseOptions {
  double restitution = 0.0;
  double restitution_threshold = 0.02;  // [m/s] slower impacts do not bounce
  double slop = 1e-4;                   // [m] penetration that is left, so that resting contacts stay contacts
  double correction = 0.1;              // share of the rest that is taken out in a step
  int max_sweeps = 200;
  double tolerance = 1e-10;  // relative change of impulses at which sweeping ends
};

class ImpulseContact {
 public:
  ImpulseContact(const ImpulseOptions& options, const Model& model);
  // `data` at the start of the step with the mass matrix not needed; inertia_extra as in ImplicitTerms.
  // v: velocities at the start, v_free: at the end without contact. loops: dc/dv of closed chains, which v_free obeys
  // and impulses leave as it is; no rows without.
  Status solve(const ContactSet& contacts, const Model& model, const Eigen::VectorXd& inertia_extra,
               const Eigen::VectorXd& v, const Eigen::VectorXd& v_free, const Eigen::MatrixXd& loops, Data* data);
  // Impulses as mean forces over dt.
  void add(const Data& data, double dt, LinkWrenches* wrenches) const;
  // Velocity (size nv) that takes penetration out, for the position update only.
  const Eigen::VectorXd& correction_velocity(double dt);
  // v_end: velocities at the end of the step.
  void report(double dt, const Eigen::VectorXd& v_end, ContactReport* report) const;
  int sweeps() const { return sweeps_; }

 private:
  struct Point {
    PointIndex index;
    int body_a = 0, body_b = 0;
    Vector3d p, n, t1, t2;
    double depth = 0.0, friction = 0.0, target = 0.0;
    Vector3d P = Vector3d::Zero();  // [N s] along n, t1, t2
    bool clipped = false;
  };
  void start_points(const ContactSet& contacts);
  void fill_jacobian(const Model& model, const Data& data);
  void add_body_rows(const Model& model, const Data& data, int body, double sign, int row);
  Status factorise(const Model& model, const Eigen::VectorXd& inertia_extra, Data* data);
  void keep_loops_closed(const Eigen::MatrixXd& loops);
  void sweep_all();
  double sweep_point(int i);
  double row_dot(int row) const;
  void change_impulse(int row, double delta);

  ImpulseOptions options_;
  std::vector<PointIndex> order_;
  std::vector<Point> points_;
  Eigen::MatrixXd M_;         // nv x nv, then its Cholesky factor
  Eigen::MatrixXd J_;         // rows of points (3 each) as columns: nv x 3 points, J^T
  Eigen::MatrixXd Y_;         // L^-1 J^T: G = Y^T Y
  Eigen::VectorXd y_;         // Y P, so that G P is never formed: a sweep costs O(M)
  Eigen::VectorXd u_free_;    // J v_free
  Eigen::VectorXd diagonal_;  // of G
  Eigen::VectorXd correction_;
  int sweeps_ = 0;
};

}  // namespace hrp
