// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/link_readings.h"

#include "common/multibody/kinematics.h"

namespace hrp::diagnosis {

// A frame of a link in motion: its pose, angular motion, and acceleration minus gravity.
struct LinkReadings::Body {
  Transform X_WB;
  Vector3d omega_W, alpha_W, apparent_W;  // [rad/s], [rad/s^2], [m/s^2] a_B - g

  // Acceleration minus gravity of the point at r_W from the origin [m/s^2].
  Vector3d calc_apparent(const Vector3d& r_W) const {
    return apparent_W + alpha_W.cross(r_W) + omega_W.cross(omega_W.cross(r_W));
  }
  // Derivative of calc_apparent with respect to r, along e.
  Vector3d calc_change(const Vector3d& e_W) const { return alpha_W.cross(e_W) + omega_W.cross(omega_W.cross(e_W)); }
};

namespace {

// [moment about the world's origin; force] of a force at a point, world axes.
Vector6d make_wrench(const Vector3d& p_WP, const Vector3d& force_W) {
  Vector6d out;
  out << p_WP.cross(force_W), force_W;
  return out;
}

}  // namespace

LinkReadings::LinkReadings(const TreeSpec& tree, const Vector3d& gravity_W, const std::vector<Vector3d>& force_W,
                           const std::vector<LinkSensor>& sensors)
    : tree_(tree),
      sensors_(sensors),
      force_W_(force_W),
      gravity_W_(gravity_W),
      model_(tree, gravity_W),
      data_(model_),
      state_(make_state(model_)) {
  force_W_.resize(tree_.links.size(), Vector3d::Zero());
  for (size_t s = 0; s < sensors_.size(); ++s) {
    const LinkSensor& sensor = sensors_[s];
    first_.push_back(static_cast<int>(size_));
    const auto add = [&](const char* part, const char* unit, int count) {
      groups_.push_back({s, sensor.name + part, unit, static_cast<int>(size_), count});
      size_ += count;
    };
    if (sensor.kind == LinkSensorKind::kTorque)
      add("", tree_.joint(sensor.joint).kind == JointKind::kPrismatic ? "N" : "N m", 1);
    if (sensor.kind == LinkSensorKind::kWrench) {
      add("/force", "N", 3);
      add("/torque", "N m", 3);
    }
    if (sensor.kind == LinkSensorKind::kImu) {
      add("/angular_velocity", "rad/s", 3);
      add("/linear_acceleration", "m/s^2", 3);
    }
    beyond_.emplace_back(tree_.links.size(), 0);
    if (sensor.kind == LinkSensorKind::kImu) continue;
    for (size_t link = 1; link < tree_.links.size(); ++link) {
      const int parent = tree_.links[link].parent;
      const bool own = static_cast<int>(link) == sensor.link && sensor.whole;
      beyond_[s][link] = own || (parent >= 0 && beyond_[s][static_cast<size_t>(parent)]);
    }
  }
}

void LinkReadings::move(const Eigen::VectorXd& q, const Eigen::VectorXd& v, const Eigen::VectorXd& a) {
  state_.q = q;
  state_.qd = v;
  update_kinematics(model_, state_, &data_);
  update_accelerations(model_, a, &data_);
}

LinkReadings::Body LinkReadings::find_body(int link) const {
  const Transform X_WL = get_pose(data_, link);
  const Vector6d acceleration = calc_point_acceleration(data_, link, X_WL.p);
  return {X_WL, get_velocity(data_, link).head<3>(), acceleration.head<3>(), acceleration.tail<3>() - gravity_W_};
}

LinkReadings::Body LinkReadings::find_below(const LinkSensor& sensor) const {
  const FrameSpec& frame = tree_.frames[static_cast<size_t>(sensor.frame)];
  Body body = find_body(frame.link);
  const Transform X_WF = body.X_WB * frame.X_LF;
  body.apparent_W = body.calc_apparent(X_WF.p - body.X_WB.p);
  body.X_WB = X_WF;
  return body;
}

Vector6d LinkReadings::calc_needed(const Body& body, const LinkInertia& inertia) const {
  const Vector3d r_W = body.X_WB.R * inertia.p_LLcm_L;
  const Matrix3d I_W = body.X_WB.R * inertia.I_LLcm_L * body.X_WB.R.transpose();
  Vector6d out = make_wrench(body.X_WB.p + r_W, inertia.mass * body.calc_apparent(r_W));
  out.head<3>() += I_W * body.alpha_W + body.omega_W.cross(I_W * body.omega_W);
  return out;
}

bool LinkReadings::is_beyond(size_t sensor, int link) const {
  const LinkSensor& s = sensors_[sensor];
  return beyond_[sensor][static_cast<size_t>(link)] ||
         (s.kind == LinkSensorKind::kWrench && !s.whole && s.link == link);
}

// Adds the reading of a sensor for a wrench that something beyond it needs.
void LinkReadings::add_passed(size_t sensor, const Vector6d& wrench, Eigen::Ref<Eigen::VectorXd> readings) const {
  const LinkSensor& s = sensors_[sensor];
  const Vector3d moment = wrench.head<3>(), force = wrench.tail<3>();
  const long first = first_[sensor];
  if (s.kind == LinkSensorKind::kTorque) {
    const JointSpec& joint = tree_.joint(s.joint);
    const Transform X_WL = get_pose(data_, s.joint + 1);
    const Vector3d z_W = X_WL.R * joint.axis_F;
    readings[first] += z_W.dot(joint.kind == JointKind::kPrismatic ? force : Vector3d(moment - X_WL.p.cross(force)));
    return;
  }
  const Transform X_WF = find_below(s).X_WB;
  const Matrix3d R = s.world ? Matrix3d::Identity() : Matrix3d(X_WF.R.transpose());
  readings.segment<3>(first) -= R * force;
  readings.segment<3>(first + 3) -= R * (moment - X_WF.p.cross(force));
}

void LinkReadings::add_imu(const LinkSensor& sensor, long first, Eigen::VectorXd* readings) const {
  const Body body = find_below(sensor);
  const Matrix3d R_FW = body.X_WB.R.transpose();
  readings->segment<3>(first) = R_FW * body.omega_W;
  readings->segment<3>(first + 3) = R_FW * body.calc_apparent(body.X_WB.R * sensor.p_FS);
}

Eigen::VectorXd LinkReadings::calc() const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(size_);
  for (size_t s = 0; s < sensors_.size(); ++s) {
    const LinkSensor& sensor = sensors_[s];
    if (sensor.kind == LinkSensorKind::kImu) add_imu(sensor, first_[s], &out);
    if (sensor.kind == LinkSensorKind::kWrench && !sensor.whole)
      add_passed(s, calc_needed(find_below(sensor), tree_.frames[static_cast<size_t>(sensor.frame)].below), out);
  }
  for (size_t link = 1; link < tree_.links.size(); ++link) {
    const LinkInertia& inertia = tree_.links[link].inertia;
    const Body body = find_body(static_cast<int>(link));
    const Vector6d needed = calc_needed(body, inertia) - make_wrench(body.X_WB * inertia.p_LLcm_L, force_W_[link]);
    for (size_t s = 0; s < sensors_.size(); ++s) {
      if (beyond_[s][link]) add_passed(s, needed, out);
    }
  }
  return out;
}

Eigen::MatrixXd LinkReadings::calc_load_columns(const LoadPoint& load) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(size_, 4);
  const Body body = find_body(load.link);
  const Vector3d r_W = body.X_WB.R * load.p_LP, p_WP = body.X_WB.p + r_W, apparent = body.calc_apparent(r_W);
  for (size_t s = 0; s < sensors_.size(); ++s) {
    if (!is_beyond(s, load.link)) continue;
    add_passed(s, make_wrench(p_WP, apparent), out.col(0));
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d e_W = body.X_WB.R.col(axis);
      Vector6d change = make_wrench(p_WP, body.calc_change(e_W));
      change.head<3>() += e_W.cross(apparent);
      add_passed(s, change, out.col(1 + axis));
    }
  }
  return out;
}

Eigen::VectorXd LinkReadings::calc_mass_column(int link) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(size_);
  const Vector6d needed = calc_needed(find_body(link), tree_.links[static_cast<size_t>(link)].inertia);
  for (size_t s = 0; s < sensors_.size(); ++s) {
    const LinkSensor& sensor = sensors_[s];
    if (beyond_[s][static_cast<size_t>(link)])
      add_passed(s, needed, out);
    else if (is_beyond(s, link))
      add_passed(s, calc_needed(find_below(sensor), tree_.frames[static_cast<size_t>(sensor.frame)].below), out);
  }
  return out;
}

Eigen::MatrixXd LinkReadings::calc_com_columns(int link) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(size_, 3);
  const LinkInertia& inertia = tree_.links[static_cast<size_t>(link)].inertia;
  const Body body = find_body(link);
  const Vector3d r_W = body.X_WB.R * inertia.p_LLcm_L, apparent = body.calc_apparent(r_W);
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d e_W = body.X_WB.R.col(axis);
    Vector6d change = make_wrench(body.X_WB.p + r_W, body.calc_change(e_W));
    change.head<3>() += e_W.cross(apparent);
    for (size_t s = 0; s < sensors_.size(); ++s) {
      const LinkSensor& sensor = sensors_[s];
      if (!is_beyond(s, link)) continue;
      const double mass = beyond_[s][static_cast<size_t>(link)]
                              ? inertia.mass
                              : tree_.frames[static_cast<size_t>(sensor.frame)].below.mass;
      add_passed(s, mass * change, out.col(axis));
    }
  }
  return out;
}

Eigen::MatrixXd LinkReadings::calc_force_columns(int link) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(size_, 3);
  const Vector3d p_WC = get_pose(data_, link) * tree_.links[static_cast<size_t>(link)].inertia.p_LLcm_L;
  for (size_t s = 0; s < sensors_.size(); ++s) {
    if (!is_beyond(s, link)) continue;
    for (int axis = 0; axis < 3; ++axis) add_passed(s, make_wrench(p_WC, -Vector3d::Unit(axis)), out.col(axis));
  }
  return out;
}

}  // namespace hrp::diagnosis
