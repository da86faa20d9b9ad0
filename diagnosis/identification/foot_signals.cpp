// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/foot_signals.h"

#include <algorithm>
#include <cmath>

namespace hrp::identification {

FootSignals calc_foot_signals(const RobotLog& log, const std::vector<Transform>& X_UI, const VerticalEstimate& vertical,
                              const SensorZero& zero, const FootFrame& foot, const Samples& wrench) {
  FootSignals out(log.size());
  for (Eigen::Index k = 0; k < log.size(); ++k) {
    const Matrix3d& R_UI = X_UI[static_cast<size_t>(k)].R;
    const Vector3d n_U = R_UI * vertical.n_I.col(k);
    const BushAngles at = calc_angles(n_U);
    out.angle[0][k] = at.roll;
    out.angle[1][k] = at.pitch;
    for (int i = 0; i < kImuErrors; ++i) {  // angles are close to linear in the vertical
      const BushAngles moved = calc_angles((n_U + 1e-4 * R_UI * vertical.gain[i].col(k)).normalized());
      out.gain[0][i][k] = (moved.roll - at.roll) / 1e-4;
      out.gain[1][i][k] = (moved.pitch - at.pitch) / 1e-4;
    }
    const Vector3d weight = foot.upper_mass * kGravity * n_U;  // of what is above the bush: the bush carries it, too
    const Vector3d force = wrench.col(k).head<3>() - zero.bias.head<3>();
    const Vector3d moment =
        wrench.col(k).tail<3>() - zero.bias.tail<3>() - foot.p_UC.cross(force) + (foot.p_Ucm - foot.p_UC).cross(weight);
    out.torque[0][k] = moment.x();
    out.torque[1][k] = moment.y() * std::cos(at.roll) + moment.z() * std::sin(at.roll);
    const Vector3d carried = force + weight;
    out.load[k] = carried.dot(n_U);
    // Axes higher by compliance x load along U's z: moment less that shift x force.
    out.arm[0][k] = carried.z() * carried.y();
    out.arm[1][k] = -carried.z() * carried.x() * std::cos(at.roll);
    out.height[k] = (make_R_SU(at) * (X_UI[static_cast<size_t>(k)].p - foot.p_UC)).z();
    out.rise[k] = log.accelerometer.col(k).dot(vertical.n_I.col(k)) - kGravity;
    out.zmp.col(k) << -out.torque[1][k] / std::max(out.load[k], 1.0), out.torque[0][k] / std::max(out.load[k], 1.0);
  }
  return out;
}

}  // namespace hrp::identification
