// SPDX-License-Identifier: BSD-3-Clause
// All spring-damper contacts of a step: the laws of contact_law.h at every point, linearised over the velocity at the
// end of the step, with regimes (open, damping, sticking, sliding) that are settled by a few solves.
//
//   start      points, projected velocities [H03 eq. 2], regimes as the state suggests
//   add        wrench on each link at zero acceleration, and impedance: what acceleration takes away from it
//   resolve    after a solve: do the regimes agree with the accelerations? Changes those that do not
//   finish     the forces that acted, part by part; new anchors
#pragma once

#include <vector>

#include "common/multibody/forward_dynamics.h"
#include "servers/dynamics/contact_anchor.h"
#include "servers/dynamics/contact_law.h"
#include "servers/dynamics/contact_work.h"
#include "servers/dynamics/twist_projection.h"

namespace hrp {

enum class NormalRegime : signed char { kOpen, kSpring, kSpringDamper };
enum class TangentRegime : signed char { kStick, kSlide };

// [N] along the normal.
struct NormalForce {
  double spring = 0.0, damper = 0.0;
  double sum() const { return spring + damper; }
};

struct PointForceParts {
  NormalForce normal;
  Vector3d friction = Vector3d::Zero();
  bool clipped = false;
};

// One point during one step. Velocities: of A against B, world axes.
struct PointWork {
  PointIndex index;
  int pair = 0;       // of PairWork
  Vector3d p, n;      // [m], unit
  Vector3d p_A, p_B;  // [m] the material points in A and B
  double depth = 0.0, depth0 = 0.0;
  PointContactParameters law;
  NormalSpring spring;
  double damping = 0.0;          // [N s/m] at this depth
  double pressing_offset = 0.0;  // [m/s] projected minus true pressing speed, [H03 eq. 2]
  Vector3d v;                    // [m/s] at the start of the step
  Vector3d slip, slip0;          // [m] tangential displacement since sticking; at the start of the step
  bool was_sliding = false;
  NormalRegime normal = NormalRegime::kOpen;
  TangentRegime tangent = TangentRegime::kStick;
  double limit = 0.0;     // [N] friction force while sliding
  Vector3d direction;     // of the friction force while sliding
  double sideways = 0.0;  // stiffness of the direction: limit / |force before clipping|
  int changes = 0;
  bool frozen = false;  // regimes did not settle: the force is `fixed`, whatever the velocity
  PointForceParts fixed;
};

struct PairWork {
  int body_a = 0, body_b = 0;
  double friction = 0.0;
  bool coupled = false;                  // both bodies move: treated explicitly, see docs/physics.md
  int first = 0, count = 0;              // points
  Matrix3d R_WB = Matrix3d::Identity();  // at the start of the step
  Transform X_AW, X_BW;
  size_t first_anchor = 0, end_anchor = 0;  // of the last step
};

struct PointImpedances;

class SpringContact {
 public:
  SpringContact(const ContactSpec& spec, const Model& model);
  void reset();

  // horizon: time step for the implicit step, 0 for forces now.
  void start(const ContactSet& contacts, const Model& model, const Data& data, double horizon, double dt);
  // Same points, bodies moved to where `data` has them (stages of Runge-Kutta).
  void move(const Data& data);
  void add(const Data& data, LinkWrenches* wrenches, LinkImpedances* impedances) const;
  // `data` holds the accelerations of a solve.
  bool resolve(const Data& data);
  // For when regimes have not settled within the solves a step may take. Points whose force would pull or leave the
  // cone [H03 eq. 6] get it clipped and held for this step (all of them when `all`); true: solve again. What is
  // reported is then exactly what acted.
  bool freeze_violators(const Data& data, bool all);
  // Parts that acted, with the accelerations in `data` (horizon 0: those at the start).
  void finish(const Data& data, ContactReport* report);
  // Keeps the anchors that finish() has made; call when the step is accepted.
  void accept() { anchors_.swap(next_anchors_); }

  const std::vector<ContactAnchor>& anchors() const { return anchors_; }
  int num_points() const { return static_cast<int>(points_.size()); }

 private:
  void start_pairs(const ContactSet& contacts);
  void start_pair(const Data& data, PairWork* pair) const;
  void start_point(const PairWork& pair, const ContactSet& contacts, const Data& data, PointWork* point);
  void limit_coupled_stiffness(const Model& model, const PairWork& pair, PointWork* point) const;
  // The pairs that press in part are projected two by two.
  void project_velocities(const ContactSet& contacts, const Data& data);
  bool presses_in_part(const PairWork& pair) const;
  // Fills projectors_[place] and returns the pair's twist.
  Vector6d load_projector(const PairWork& pair, const ContactSet& contacts, const Data& data, int place);
  void take_projection(const PairWork& pair, const Vector6d& projected, int place);
  void start_regimes(const PairWork& pair);
  void recall_anchor(const PairWork& pair, PointWork* point) const;
  void add_pair(const PairWork& pair, const Data& data, LinkWrenches* wrenches, PointImpedances* sum) const;
  NormalForce calc_normal_force(const PointWork& point, const Vector3d& v) const;
  double calc_pressing_force(const PointWork& point, const Vector3d& v) const;
  Vector3d calc_trial(const PointWork& point, const Vector3d& v) const;
  PointForceParts calc_parts(const PointWork& point, const Vector3d& v) const;
  small::S3 calc_point_impedance(const PointWork& point) const;
  bool resolve_normal(const Vector3d& v, PointWork* point) const;
  bool resolve_tangent(const Vector3d& v, PointWork* point) const;
  void start_sliding(double limit, const Vector3d& trial, PointWork* point) const;
  static bool freeze_violator(const PairWork& pair, PointForceParts parts, bool always, PointWork* point);
  void finish_point(const PointWork& point, const Vector3d& v, PointForce* force) const;
  void keep_anchor(const PairWork& pair, const PointWork& point, const Vector3d& v);

  ContactSpec spec_;
  PointContactParameters law_;
  Vector3d gravity_W_;
  double horizon_ = 0.0, dt_ = 0.0;
  std::vector<PointIndex> order_;
  std::vector<PairWork> pairs_;
  std::vector<PointWork> points_;
  TwistProjector projectors_[2];
  std::vector<ContactAnchor> anchors_, next_anchors_;
};

}  // namespace hrp
