// SPDX-License-Identifier: BSD-3-Clause
// The values of a hypothesis about a standing robot, sorted by where they act.
#pragma once

#include <vector>

#include "diagnosis/model/effect.h"
#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

inline bool is_joint(const Effect& e) { return e.place.kind == PlaceKind::kJoint; }
inline bool is_link(const Effect& e) { return e.place.kind == PlaceKind::kLink; }
inline bool is_foot(const Effect& e) { return e.place.kind == PlaceKind::kFoot; }  // all feet at once
inline bool is_joint_sensor(const Effect& e) {
  return e.place.kind == PlaceKind::kSensor && is_of_joint(e.place.reading);
}
inline bool is_wrench(const Effect& e) {  // index: of the foot
  const Reading r = e.place.reading;
  return e.place.kind == PlaceKind::kSensor && (r == Reading::kWrench || r == Reading::kForce || r == Reading::kTorque);
}
inline bool is_imu(const Effect& e) {
  return e.place.kind == PlaceKind::kSensor && !is_joint_sensor(e) && !is_wrench(e);
}

constexpr size_t kFootParameters = 10;

// What the table's laws of a joint have no place for, because they are written in coefficients that equations are
// linear in.
struct JointTerms {
  JointLaws laws;         // dry friction without Stribeck's excess; motor_inertia is what effects add
  double excess = 0;      // [N m] of friction at rest over that in motion
  double moment = 0;      // [N m] of a parallel spring at position 0
  double cogging_sin = 0, cogging_cos = 0;  // [N m]; the periods are in `laws`
  double compliance = 0;                    // [rad/(N m)] of the transmission
  SensorErrors effort, velocity, position;  // on the first axis
  bool has_friction() const { return laws.coulomb != 0 || excess != 0 || laws.load_ratio != 0; }
};

struct WrenchTerms {
  SensorErrors force, torque;
};

struct ImuTerms {
  SensorErrors attitude, gyro, accelerometer;
};

struct FootTerms {
  double inverse_k[2] = {0, 0}, c_over_k[2] = {0, 0}, inverse_kz = 0, hardening = 0;
  Vector3d shift{0, 0, 0};
  double moment[2] = {0, 0};
  bool soft = false;
};

struct Terms {
  std::vector<JointTerms> joints;
  std::vector<WrenchTerms> wrenches;
  std::vector<FootTerms> feet;
  ImuTerms imu;
  GroundSpec ground;  // slope and friction that effects state; friction 0: that of the scenario
  TreeSpec tree;
  std::vector<Vector3d> force_W;

  Terms(const StandProblem& problem, const Hypothesis& hypothesis);

 private:
  void add(const Effect& effect);
  std::vector<SensorErrors*> find_sensors(const Effect& effect);
};

}  // namespace hrp::diagnosis::standing
