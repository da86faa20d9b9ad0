// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/body_motion.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "diagnosis/identification/smoothing.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::identification {
namespace {

constexpr double kBodySmoothing = 0.04;  // [s] passes 4 Hz, stops the noise of twice differentiated encoders
constexpr double kSticking = 0.01;       // [s] of the rate that tells whether a joint sticks
constexpr double kStuck = 0.01;          // [rad/s] slower than this; encoder noise makes 1e-3 of it
constexpr double kStride = 0.05;         // [s] between samples that are used

Scenario with_rigid_feet(const Scenario& given) {
  Scenario scenario = without_bush(given);
  scenario.link_laws.clear();
  return scenario;
}

// Raw signals of one motion, sample by sample.
struct Raw {
  Samples q, effort, exerted, felt, arm, w;  // felt: specific force; arm: of the IMU from the base's origin; all W
  std::vector<Matrix3d> R_WB;
  Eigen::Matrix<double, 6, Eigen::Dynamic> zero_gain;
};

Raw observe_raw(const BodyRig& rig, const RobotLog& log, const std::vector<Matrix3d>& R_WI,
                const std::vector<SensorZero>& zeros) {
  const Eigen::Index n = log.size(), joints = rig.model.num_joints();
  Raw raw{Samples::Zero(joints, n),
          Samples(),
          Samples::Zero(rig.model.nv(), n),
          Samples(3, n),
          Samples(3, n),
          Samples::Zero(3, n),
          {},
          {}};
  raw.zero_gain.setZero(6, 6 * static_cast<Eigen::Index>(rig.feet.size()));
  if (log.effort.size() > 0) raw.effort = Samples::Zero(joints, n);
  Data data(rig.model);
  State state = make_state(rig.model);
  Eigen::MatrixXd J(6, rig.model.nv());
  for (Eigen::Index k = 0; k < n; ++k) {
    for (size_t j = 0; j < log.joints.size(); ++j) {
      const int i = rig.robot.tree.find_joint(log.joints[j]);
      if (i < 0) continue;
      state.q[i] = raw.q(i, k) = log.q(static_cast<Eigen::Index>(j), k);
      if (log.effort.size() > 0) raw.effort(i, k) = log.effort(static_cast<Eigen::Index>(j), k);
    }
    state.R_WB = Eigen::Quaterniond::Identity();
    update_kinematics(rig.model, state, &data);
    const Transform X_BI = get_pose(data, rig.imu_link) * rig.X_LI;
    const Matrix3d& R_WI_k = R_WI[static_cast<size_t>(k)];
    raw.R_WB.push_back(R_WI_k * X_BI.R.transpose());
    state.R_WB = Eigen::Quaterniond(raw.R_WB.back());
    update_kinematics(rig.model, state, &data);
    raw.felt.col(k) = R_WI_k * log.accelerometer.col(k);
    raw.arm.col(k) = raw.R_WB.back() * X_BI.p;
    for (size_t f = 0; f < rig.feet.size(); ++f) {
      const Transform X_WU = get_pose(data, rig.feet[f]);
      const Vector6d reading = log.wrenches[f].col(k) - zeros[f].bias;
      Matrix6d to_W = Matrix6d::Zero();  // from [force; torque] in U to [moment; force] in W
      to_W.topRightCorner<3, 3>() = to_W.bottomLeftCorner<3, 3>() = X_WU.R;
      J.setZero();
      calc_point_jacobian(rig.model, data, rig.feet[f], X_WU.p, J);
      raw.exerted.col(k) += J.transpose() * (to_W * reading);
      raw.zero_gain.middleCols<6>(6 * static_cast<Eigen::Index>(f)) -=
          J.leftCols<6>().transpose() * to_W / static_cast<double>(n);
    }
  }
  for (Eigen::Index k = 1; k + 1 < n; ++k) {
    const Eigen::AngleAxisd turn(
        Matrix3d(raw.R_WB[static_cast<size_t>(k + 1)] * raw.R_WB[static_cast<size_t>(k - 1)].transpose()));
    raw.w.col(k) = turn.angle() / (2.0 * log.period) * turn.axis();
  }
  return raw;
}

}  // namespace

BodyRig::BodyRig(const Scenario& scenario) : robot(load_robot(with_rigid_feet(scenario))), model(robot.tree) {
  const FrameSpec& frame =
      robot.tree.frames.at(static_cast<size_t>(robot.tree.find_frame(scenario.sensors.imus.at(0).link)));
  imu_link = frame.link;
  X_LI = frame.X_LF * Transform{Matrix3d::Identity(), scenario.sensors.imus[0].p_LS};
  for (const std::string& foot : scenario.feet) feet.push_back(robot.tree.find_link(foot));
}

bool BodyRig::is_foot(int link) const { return has(feet, link); }

BodyMotion observe_body(const BodyRig& rig, const BushObserver& observer, const RobotLog& log,
                        const std::vector<SensorZero>& zeros) {
  const Raw raw = observe_raw(rig, log, observer.calc_attitude(log, zeros), zeros);
  const GaussianFilter filter(kBodySmoothing, log.period);
  const auto stride = static_cast<Eigen::Index>(std::max(1.0, std::round(kStride / log.period)));
  const Eigen::Index margin = 2 * filter.margin() + 2,
                     n = std::max<Eigen::Index>(0, (log.size() - 2 * margin) / stride);
  const auto smooth = [&](const Samples& rows, int order) {
    Samples out(rows.rows(), n);
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      const Eigen::VectorXd all = filter.apply(rows.row(i).transpose(), order);
      for (Eigen::Index k = 0; k < n; ++k) out(i, k) = all[margin + k * stride];
    }
    return out;
  };
  BodyMotion m;
  m.name = log.name;
  m.period = static_cast<double>(stride) * log.period;
  for (Eigen::Index k = 0; k < n; ++k) m.R_WB.push_back(raw.R_WB[static_cast<size_t>(margin + k * stride)]);
  m.w = smooth(raw.w, 0);
  Samples a = smooth(raw.felt, 0) - smooth(raw.arm, 2);  // of the base's origin, less gravity
  a.colwise() += rig.model.gravity_W();
  m.vdot.resize(rig.model.nv(), n);
  m.vdot << smooth(raw.w, 1), a, smooth(raw.q, 2);
  m.q = smooth(raw.q, 0);
  m.qd = smooth(raw.q, 1);
  if (raw.effort.size() > 0) m.effort = smooth(raw.effort, 0);
  // A joint that turns round sticks for some hundredths of a second, with less than its full friction: quicker to see
  // than what the wide filter makes of it.
  const GaussianFilter narrow(kSticking, log.period);
  Samples sign(raw.q.rows(), raw.q.cols());
  for (Eigen::Index i = 0; i < sign.rows(); ++i) {
    const Eigen::ArrayXd rate = narrow.apply(raw.q.row(i).transpose(), 1).array();
    sign.row(i) = (rate.abs() > kStuck).select(rate.sign(), 0.0).matrix().transpose();
  }
  m.direction = smooth(sign, 0);
  m.exerted = smooth(raw.exerted, 0);
  m.zero_gain = raw.zero_gain;
  m.measured.assign(static_cast<size_t>(rig.model.num_joints()), false);
  for (const std::string& joint : log.joints) {
    const int i = rig.robot.tree.find_joint(joint);
    if (i >= 0) m.measured[static_cast<size_t>(i)] = true;
  }
  return m;
}

BodyEquations::BodyEquations(const BodyRig& rig)
    : rig_(rig), data_(rig.model), state_(make_state(rig.model)), Y_(rig.model) {}

void BodyEquations::update(const BodyMotion& m, Eigen::Index k) {
  state_.R_WB = Eigen::Quaterniond(m.R_WB[static_cast<size_t>(k)]);
  state_.V_WB << m.w.col(k), Vector3d::Zero();
  state_.q = m.q.col(k);
  state_.qd = m.qd.col(k);
  update_kinematics(rig_.model, state_, &data_);
  calc_regressor(rig_.model, m.vdot.col(k), &data_, &Y_);
  // What the sensors in the ankles feel contains the feet: the joints bear them in `exerted` already.
  for (int foot : rig_.feet) Y_.Y_JI.middleCols<kInertialParameters>(kInertialParameters * foot).setZero();
}

}  // namespace hrp::identification
