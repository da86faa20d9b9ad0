// SPDX-License-Identifier: BSD-3-Clause
// The columns that effects are made of: how each equation changes with each elementary quantity. An effect of the
// report is one of them (viscous friction), several (a payload: mass and mass times place), or a sum (a wrong mass).
#pragma once

#include "common/multibody/regressor.h"
#include "diagnosis/floating/log/legged_log.h"

namespace hrp::diagnosis::floating {

enum JointColumn {
  kViscousColumn,
  kDryColumn,   // direction of motion
  kLoadColumn,  // direction times size of the torque
  kRotorColumn,
  kGainColumn,
  kSpringColumn,
  kConstantColumn,
  kLagColumn,
  kOffsetColumn,  // the encoder reads more than the link's true angle
  kPlayColumn,    // teeth: the encoder's side is ahead of the link's by half the gap, to the torque's side
  kGiveColumn,    // the encoder's side is ahead by torque times this column's coefficient [rad/(N m)]
  kBendColumn,    // what carries the joint bends about two axes across its own: ahead by the moment times [rad/(N m)]
  kBendColumn2,
  kDelayColumn,  // the servo sees commands late
  kEffortScaleColumn,
  kJointColumns
};

enum SensorColumn {
  kForceScaleColumn,
  kTorqueScaleColumn,
  kForceBiasColumn,  // x y z
  kTorqueBiasColumn = kForceBiasColumn + 3,
  kWrenchDelayColumn = kTorqueBiasColumn + 3,
  kWrenchTurnColumn,  // x y z
  kSensorColumns = kWrenchTurnColumn + 3
};

enum ImuColumn {
  kAccelerometerScaleColumn,
  kAccelerometerBiasColumn,
  kAccelerometerDelayColumn = kAccelerometerBiasColumn + 3,
  kAccelerometerTurnColumn,
  kGyroScaleColumn = kAccelerometerTurnColumn + 3,
  kGyroBiasColumn,
  kGyroDelayColumn = kGyroBiasColumn + 3,
  kGyroTurnColumn,
  kAttitudeTurnColumn = kGyroTurnColumn + 3,
  kAttitudeDelayColumn = kAttitudeTurnColumn + 3,
  kImuColumns
};

// When a foot is held: while it is loaded, before and after it lifts, before and after it lands.
enum Hold { kHeldLoaded, kHeldBeforeLifting, kHeldAfterLifting, kHeldBeforeLanding, kHeldAfterLanding, kHolds };

enum FootColumn {
  kRollGiveColumn,  // moment about the sole's centre: rad = N m times this column's coefficient
  kRollDampColumn,
  kPitchGiveColumn,
  kPitchDampColumn,
  kSinkColumn,                               // force: m = N times this column's coefficient
  kSinkDampColumn,                           // its rate: a damped sole sinks late, by -cz / kz^2 m for each N/s
  kRollShiftColumn,                          // forces that a centre elsewhere than the sole's adds to the moments: z, y
  kPitchShiftColumn = kRollShiftColumn + 2,  // z, x
  kHoldColumn =
      kPitchShiftColumn + 2,  // from outside, down [N]: while it is loaded, before and after it lifts and lands
  kFootColumns = kHoldColumn + kHolds
};

// A force from outside on a link, world axes: the link has so much less to carry.
enum PullColumn {
  kPullColumn,                           // x y z [N]
  kPullByPlaceColumn = kPullColumn + 3,  // by the place [N/m]: dFx/dx, dFx/dy = dFy/dx, dFy/dy, dFz/dx, dFz/dy
  kPullColumns = kPullByPlaceColumn + 5
};

// Where the columns of each place begin.
struct ColumnLayout {
  int links = 0, joints = 0, sensors = 0, imus = 0, feet = 0;
  explicit ColumnLayout(const LeggedLog& log)
      : links(static_cast<int>(log.tree.links.size())),
        joints(log.num_joints()),
        sensors(static_cast<int>(log.sensors.size())),
        imus(static_cast<int>(log.imus.size())),
        feet(static_cast<int>(log.feet.size())) {}
  // Of a link: m, m c x y z, I xx xy xz yy yz zz about the link's origin, as common/multibody/regressor.h has them.
  int link(int i, int c) const { return kInertialParameters * i + c; }
  int joint(int i, int c) const { return link(links, 0) + kJointColumns * i + c; }
  int sensor(int i, int c) const { return joint(joints, 0) + kSensorColumns * i + c; }
  int imu(int i, int c) const { return sensor(sensors, 0) + kImuColumns * i + c; }
  int foot(int i, int c) const { return imu(imus, 0) + kFootColumns * i + c; }
  int slope(int axis) const { return foot(feet, 0) + axis; }
  int pull(int link, int c) const { return slope(2) + kPullColumns * link + c; }
  int count() const { return pull(links, 0); }
};

}  // namespace hrp::diagnosis::floating
