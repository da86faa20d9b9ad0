// SPDX-License-Identifier: BSD-3-Clause
// Values of a hypothesis about a standing robot, by place.
#pragma once

#include <vector>

#include "diagnosis/model/effect.h"
#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

inline bool is_joint(const Effect& e) { return e.place.kind == PlaceKind::kJoint; }
inline bool is_link(const Effect& e) { return e.place.kind == PlaceKind::kLink; }
inline bool is_foot(const Effect& e) { return e.place.kind == PlaceKind::kFoot; }  // all feet together
inline bool is_joint_sensor(const Effect& e) {
  return e.place.kind == PlaceKind::kSensor && is_of_joint(e.place.reading);
}
inline bool is_wrench(const Effect& e) {  // index of the foot
  const Reading r = e.place.reading;
  return e.place.kind == PlaceKind::kSensor && (r == Reading::kWrench || r == Reading::kForce || r == Reading::kTorque);
}
inline bool is_imu(const Effect& e) {
  return e.place.kind == PlaceKind::kSensor && !is_joint_sensor(e) && !is_wrench(e);
}

constexpr size_t kFootParameters = 10;

// Parameters of a joint in coefficients in which the equations are linear. JointLaws has no fields for these.
struct JointTerms {
  JointLaws laws;                           // dry friction without the Stribeck excess; motor_inertia: added by effects
  double excess = 0;                        // [N m] static minus Coulomb friction
  double moment = 0;                        // [N m] of a parallel spring at position 0
  double cogging_sin = 0, cogging_cos = 0;  // [N m]; the wave number is in `laws`
  double compliance = 0;                    // [rad/(N m)] of the transmission
  SensorErrors effort, velocity, position;  // component x
  bool has_friction() const { return laws.coulomb != 0 || excess != 0 || laws.load_ratio != 0; }
};

struct WrenchTerms {
  SensorErrors force, torque;
};

struct ImuTerms {
  SensorErrors attitude, gyro, accelerometer;
};

// A bush: compliances about roll and pitch and in height, damping over stiffness [s], hardening [1/rad^2], shift of its
// centre [m] and moments at rest [N m].
struct FootTerms {
  double inverse_k[2] = {0, 0}, c_over_k[2] = {0, 0}, inverse_kz = 0, hardening = 0;
  Vector3d shift{0, 0, 0};
  double moment[2] = {0, 0};
  bool soft = false;
};

// All parameters of a hypothesis, together with those that the experiment states.
struct Terms {
  std::vector<JointTerms> joints;
  std::vector<WrenchTerms> wrenches;
  std::vector<FootTerms> feet;
  ImuTerms imu;
  GroundSpec ground;  // slope and friction of effects; friction 0: as in the scenario
  TreeSpec tree;
  std::vector<Vector3d> force_W;

  Terms(const StandProblem& problem, const Hypothesis& hypothesis);

 private:
  void add(const Effect& effect);
  std::vector<SensorErrors*> find_sensors(const Effect& effect);
};

}  // namespace hrp::diagnosis::standing
