// SPDX-License-Identifier: BSD-3-Clause
// What a hypothesis about a standing robot consists of, and its values sorted by where they act.
#pragma once

#include <vector>

#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

// Ordered by kind of place: joint, link, ground, force sensor, IMU, joint sensor; see the predicates below.
enum class StandId {
  kViscous,
  kCoulomb,
  kStribeck,
  kLoadFriction,
  kRotorInertia,
  kSpring,
  kTorqueConstant,
  kSaturation,
  kCogging,
  kHysteresis,
  kCommandDelay,
  kActuatorLag,
  kElasticity,
  kBacklash,
  kJointOffset,
  kPayload,
  kMassError,
  kComError,
  kExternalForce,
  kFootCompliance,
  kFootHardening,
  kGroundSlope,
  kGroundFriction,
  kForceBias,
  kTorqueBias,
  kForceScale,
  kTorqueScale,
  kWrenchDelay,
  kWrenchMisalignment,
  kWrenchSkew,
  kGyroBias,
  kAccelerometerBias,
  kGyroScale,
  kAccelerometerScale,
  kImuDelay,
  kImuMisalignment,
  kImuSkew,
  kEffortBias,
  kEffortScale,
  kEffortDelay,
  kVelocityBias,
  kVelocityScale,
  kVelocityDelay,
  kPositionBias,
  kPositionScale,
  kPositionDelay
};

inline bool is_joint(StandId id) { return id <= StandId::kJointOffset; }
inline bool is_link(StandId id) { return id >= StandId::kPayload && id <= StandId::kExternalForce; }
inline bool is_foot(StandId id) { return id == StandId::kFootCompliance || id == StandId::kFootHardening; }
inline bool is_ground(StandId id) { return id == StandId::kGroundSlope || id == StandId::kGroundFriction; }
inline bool is_wrench(StandId id) { return id >= StandId::kForceBias && id <= StandId::kWrenchSkew; }
inline bool is_imu(StandId id) { return id >= StandId::kGyroBias && id <= StandId::kImuSkew; }
inline bool is_joint_sensor(StandId id) { return id >= StandId::kEffortBias; }
// Those that leave motion and forces as they are and change only what a drive's effort is compared with.
inline bool is_drive(StandId id) {
  return id <= StandId::kActuatorLag || (id >= StandId::kEffortBias && id <= StandId::kVelocityDelay);
}

// One effect at one place with its parameters. `place`: joint, link or foot; of a wrench's delay or misalignment
// foot + feet x part (0 all, 1 force, 2 torque); of an IMU's delay or misalignment the part (0 all, 1 attitude,
// 2 gyroscope, 3 accelerometer).
//
// Parameters are chosen so that the residuals are linear in most of them:
//   feet: 1/k, c/k of roll, then of pitch, 1/kz, and nuisances: where the centre of the bush truly is
//   (x y z [m] off the nominal), and moments at rest about x and y [N m]; hardening adds one coefficient [1/rad^2]
//   payload: mass, mass x com;  cogging: sine and cosine amplitude, periods;  elasticity: 1/stiffness, rotor inertia
//   backlash: gap (kMostPlay where no torque ever held the link at an end), and as nuisances rotor inertia and
//   compliance of the teeth; what the link was seen to move where no torque held it at both ends (read off), else 0
//   Stribeck: Coulomb, static less Coulomb, velocity, viscous;  hysteresis: stiffness, yield angle
struct StandEffect {
  StandId id;
  int place = 0;
  std::vector<double> p;
};
using StandHypothesis = std::vector<StandEffect>;

constexpr size_t kFootParameters = 10;

struct JointTerms {
  JointLaws drive;  // scale, saturation and terms of the drive
  double viscous = 0, coulomb = 0, asymmetry = 0, excess = 0, stribeck_velocity = 0, load = 0;
  double rotor = 0, spring = 0, moment = 0, lag = 0, delay = 0;
  double cogging_sin = 0, cogging_cos = 0, periods = 0, hysteresis = 0, yield = 0;
  double compliance = 0, gap = 0, offset = 0;
  double effort_bias = 0, effort_scale = 1, effort_delay = 0;
  double velocity_bias = 0, velocity_scale = 1, velocity_delay = 0;
  double position_bias = 0, position_scale = 1, position_delay = 0;
  bool has_friction() const { return coulomb != 0 || excess != 0 || load != 0; }
};

struct WrenchTerms {
  Vector3d force_bias{0, 0, 0}, torque_bias{0, 0, 0}, rpy[2] = {{0, 0, 0}, {0, 0, 0}};  // force, torque
  double force_scale = 1, torque_scale = 1, delay[2] = {0, 0}, skew = 0;
};

struct ImuTerms {
  Vector3d gyro_bias{0, 0, 0}, accelerometer_bias{0, 0, 0};
  Vector3d rpy[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};  // attitude, gyroscope, accelerometer
  double gyro_scale = 1, accelerometer_scale = 1, delay[3] = {0, 0, 0}, skew = 0;
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
  double slope_roll = 0, slope_pitch = 0, friction = 0;
  TreeSpec tree;
  std::vector<Vector3d> force_W;

  Terms(const StandProblem& problem, const StandHypothesis& hypothesis);
};

}  // namespace hrp::diagnosis::standing
