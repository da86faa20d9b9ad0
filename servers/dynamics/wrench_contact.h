// SPDX-License-Identifier: BSD-3-Clause
// All contacts of a step under `contact.model: wrench`: the law of wrench_law.h for every pair, linearised over the
// twist at the end of the step. It has no memory: nothing but the damping of [H03 eq. 5] holds a robot in its place.
//
//   start     points, centres and twists of all pairs; the law at the twist there is
//   add       wrench on each link at zero acceleration, and impedance: what acceleration takes away from it
//   resolve   after a solve: is the law's wrench at the end the one that acted? Else linearises it there
//   hold      for when that has not settled and is far off: the law's wrench at the end, held for this step
//   finish    the wrenches that acted, part by part
#pragma once

#include <vector>

#include "common/multibody/forward_dynamics.h"
#include "common/robot/scenario.h"
#include "servers/dynamics/contact_work.h"
#include "servers/dynamics/wrench_law.h"

namespace hrp {

// A pair's wrench on A about Q, axes of A.
struct PairWrench {
  Vector6d spring = Vector6d::Zero(), damper = Vector6d::Zero(), tangential = Vector6d::Zero();
  bool clipped = false;
  Vector6d calc_total() const { return calc_normal_wrench(spring, damper) + tangential; }
};

struct WrenchPairWork {
  int index = 0;  // in the contact set
  int body_a = 0, body_b = 0;
  double friction = 0.0;
  bool coupled = false;  // both bodies move: treated explicitly, see docs/physics.md
  WrenchLaw law;
  int first = 0, count = 0;  // points
  Matrix3d R_WA;
  Vector3d p_WQ;
  Vector6d V0;  // twist of A against B at the start of the step
  Vector6d D0;  // displacement at the start of the step
  Vector6d V;   // twist about which it is linearised
  PairWrench at_V;
  Matrix6d slope = Matrix6d::Zero();  // of minus the wrench over the twist: symmetric, not negative
  int changes = 0;
  bool held = false;
};

class WrenchContact {
 public:
  // Feet with a foot_bush get their K and C from it, about its centre; all other links from `contact`.
  WrenchContact(const Scenario& scenario, const Model& model);

  void start(const ContactSet& contacts, const Model& model, const Data& data, double dt);
  void add(const Data& data, LinkWrenches* wrenches, LinkImpedances* impedances) const;
  bool resolve(const Data& data);
  bool hold(const Data& data);
  void finish(const Data& data, ContactReport* report);

 private:
  struct LinkLaw {
    WrenchLaw law;
    bool has_centre = false;
    Vector3d p_LQ = Vector3d::Zero();  // [m]
  };
  void start_pair(const ContactSet& contacts, const Model& model, const Data& data, WrenchPairWork* pair);
  void limit_coupled_law(const Model& model, WrenchPairWork* pair) const;
  Vector6d calc_end_twist(const Data& data, const WrenchPairWork& pair) const;
  // The law when A moves with V until the end of the step; leaves displacement_ and projector_ as they are there.
  PairWrench evaluate(const WrenchPairWork& pair, const Vector6d& V);
  void linearise(const Vector6d& V, WrenchPairWork* pair);
  Matrix6d calc_slope(const WrenchPairWork& pair) const;  // after evaluate() at pair.V
  Vector6d calc_acted(const WrenchPairWork& pair, const Vector6d& V) const;
  bool differs(const WrenchPairWork& pair, const Vector6d& V, double tolerance);  // law and what acted
  void report_points(const WrenchPairWork& pair, const PairWrench& acted, PairForce* report) const;

  std::vector<LinkLaw> laws_;  // by link
  Vector3d gravity_W_;
  double dt_ = 0.0;
  std::vector<WrenchPairWork, Eigen::aligned_allocator<WrenchPairWork>> pairs_;
  std::vector<PairPoint> points_, moved_;
  PairDisplacement displacement_;
  TwistProjector projector_;
  bool projected_ = false;  // else the twist damps as it is
};

}  // namespace hrp
