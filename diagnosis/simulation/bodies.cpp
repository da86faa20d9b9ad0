// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/simulation/bodies.h"

#include <algorithm>

#include "common/multibody/kinematics.h"
#include "common/multibody/mass_matrix.h"
#include "diagnosis/data/command_reader.h"

namespace hrp::diagnosis {
namespace {

// Model of a plant with the constant forces on its links.
class Dynamics {
 public:
  explicit Dynamics(const Plant& plant)
      : plant_(plant),
        data_(*plant.model),
        state_(make_state(*plant.model)),
        zero_(Eigen::VectorXd::Zero(plant.model->num_joints())) {}

  void move(const double* q, const double* qd) {
    for (long j = 0; j < zero_.size(); ++j) {
      state_.q[j] = q[j];
      state_.qd[j] = qd[j];
    }
    update_kinematics(*plant_.model, state_, &data_);
    wrenches_ = calc_wrenches(plant_.forces, *plant_.model, data_);
  }

  void calc_effort(const Eigen::VectorXd& qdd, Eigen::VectorXd* tau) {
    calc_inverse_dynamics(*plant_.model, qdd, wrenches_.empty() ? nullptr : &wrenches_, &data_, tau);
  }

  void calc_bias_effort(Eigen::VectorXd* bias) {
    if (wrenches_.empty())
      calc_bias(*plant_.model, &data_, bias);
    else
      calc_effort(zero_, bias);
  }

  const Eigen::MatrixXd& mass() { return update_mass_matrix(*plant_.model, &data_); }

 private:
  const Plant& plant_;
  Data data_;
  State state_;
  Eigen::VectorXd zero_;
  LinkWrenches wrenches_;
};

class RobotBodies : public Bodies {
 public:
  RobotBodies(const Plant& plant, const SmoothRecording& smooth)
      : dynamics_(plant), plant_(plant), smooth_(smooth), bias_(Eigen::VectorXd::Zero(plant.model->num_joints())) {}

  void evaluate(double, size_t, const double* q, const double* qd, double* M, double* bias) override {
    dynamics_.move(q, qd);
    dynamics_.calc_bias_effort(&bias_);
    const Eigen::MatrixXd& mass = dynamics_.mass();
    for (long i = 0; i < bias_.size(); ++i) {
      bias[i] = bias_[i];
      for (long j = 0; j < bias_.size(); ++j) M[i * bias_.size() + j] = mass(i, j);
    }
  }

  void calc_efforts(size_t k, double* tau) override {
    const long n = bias_.size();
    Eigen::VectorXd q(n), qd(n), qdd(n);
    for (long j = 0; j < n; ++j) {
      const SmoothJoint& joint = smooth_.joints[static_cast<size_t>(j)];
      q[j] = joint.q[k] - plant_.laws[static_cast<size_t>(j)].joint_offset;
      qd[j] = joint.qd[k];
      qdd[j] = joint.qdd[k];
    }
    dynamics_.move(q.data(), qd.data());
    dynamics_.calc_effort(qdd, &bias_);
    for (long j = 0; j < n; ++j) tau[j] = bias_[j];
  }

 private:
  Dynamics dynamics_;
  const Plant& plant_;
  const SmoothRecording& smooth_;
  Eigen::VectorXd bias_;
};

class PathBodies : public Bodies {
 public:
  PathBodies(const JointPath& path, const std::vector<double>& time) : path_(path), time_(time) {}

  void evaluate(double t, size_t near, const double* q, const double* qd, double* M, double* bias) override {
    const Moment m = find_moment(time_, t, near);
    M[0] = m.of(path_.inertia);
    bias[0] = m.of(path_.load) + m.of(path_.stiffness) * (q[0] - m.of(path_.q)) +
              m.of(path_.damping) * (qd[0] - m.of(path_.qd));
  }

  void calc_efforts(size_t k, double* tau) override { tau[0] = path_.load[k] + path_.inertia[k] * path_.qdd[k]; }

 private:
  const JointPath& path_;
  const std::vector<double>& time_;
};

// While teeth cross a gap, no law of this kind says where the link is.
bool swings(const JointLaws& laws) { return laws.elastic && laws.gap == 0.0; }

// Links behind elastic gears along one motion of the drives.
class ElasticLinks {
 public:
  ElasticLinks(const Plant& plant, const JointsMotion& drives, double step)
      : dynamics_(plant), drives_(drives), step_(step), out_(drives), q_(drives.q.row(0)), v_(drives.v.row(0)) {
    std::vector<double> k, d;
    for (size_t j = 0; j < plant.laws.size(); ++j) {
      const JointLaws& laws = plant.laws[j];
      if (swings(laws)) {
        at_.push_back(static_cast<long>(j));
        k.push_back(laws.stiffness);
        d.push_back(laws.damping);
      }
    }
    const auto n = static_cast<long>(at_.size());
    K_ = Eigen::Map<const Eigen::VectorXd>(k.data(), n).asDiagonal();
    D_ = Eigen::Map<const Eigen::VectorXd>(d.data(), n).asDiagonal();
  }

  JointsMotion run() {
    twist_by_load();
    for (long k = 0; k < drives_.q.rows(); ++k) {
      if (k > 0) advance(k);
      evaluate(k);
      keep(k);
    }
    return std::move(out_);
  }

 private:
  Eigen::VectorXd pick(const Eigen::VectorXd& all) const {
    Eigen::VectorXd own(static_cast<long>(at_.size()));
    for (long i = 0; i < own.size(); ++i) own[i] = all[at_[static_cast<size_t>(i)]];
    return own;
  }
  void put(const Eigen::VectorXd& own, Eigen::VectorXd* all) const {
    for (long i = 0; i < own.size(); ++i) (*all)[at_[static_cast<size_t>(i)]] = own[i];
  }

  // M and h of the elastic joints at (q_, v_), the others as their drives at sample k.
  void evaluate(long k) {
    dynamics_.move(q_.data(), v_.data());
    const Eigen::MatrixXd& mass = dynamics_.mass();
    const auto n = static_cast<long>(at_.size());
    M_.resize(n, n);
    for (long i = 0; i < n; ++i) {
      for (long j = 0; j < n; ++j) M_(i, j) = mass(at_[static_cast<size_t>(i)], at_[static_cast<size_t>(j)]);
    }
    Eigen::VectorXd a = drives_.a.row(k), tau(a.size());
    put(Eigen::VectorXd::Zero(n), &a);
    dynamics_.calc_effort(a, &tau);
    h_ = pick(tau);
  }

  void twist_by_load() {
    constexpr int kPasses = 5;  // the load hardly changes over a twist
    for (int pass = 0; pass < kPasses; ++pass) {
      evaluate(0);
      const Eigen::VectorXd load = h_ + M_ * pick(drives_.a.row(0));
      put(pick(drives_.q.row(0)) - load.cwiseQuotient(K_.diagonal()), &q_);
    }
  }

  // From sample k - 1 to k; M_ and h_ are those at k - 1.
  void advance(long k) {
    const Eigen::VectorXd q0 = pick(q_), v0 = pick(v_), h0 = h_;
    const Eigen::VectorXd drive_q = 0.5 * (pick(drives_.q.row(k - 1)) + pick(drives_.q.row(k))),
                          drive_v = 0.5 * (pick(drives_.v.row(k - 1)) + pick(drives_.v.row(k)));
    q_ = drives_.q.row(k);
    v_ = drives_.v.row(k);
    for (bool corrected : {false, true}) {  // by the load at the end of the step
      const Eigen::VectorXd load = corrected ? Eigen::VectorXd(0.5 * (h0 + h_)) : h0;
      const Eigen::MatrixXd A = M_ / step_ + 0.5 * D_ + 0.25 * step_ * K_;
      const Eigen::VectorXd b =
          M_ * v0 / step_ + K_ * (drive_q - q0 - 0.25 * step_ * v0) + D_ * (drive_v - 0.5 * v0) - load;
      const Eigen::VectorXd v1 = A.ldlt().solve(b);
      put(q0 + 0.5 * step_ * (v0 + v1), &q_);
      put(v1, &v_);
      if (!corrected) evaluate(k);
    }
  }

  void keep(long k) {
    const Eigen::VectorXd q = pick(q_), v = pick(v_);
    Eigen::VectorXd a = drives_.a.row(k);
    put(M_.ldlt().solve(K_ * (pick(drives_.q.row(k)) - q) + D_ * (pick(drives_.v.row(k)) - v) - h_), &a);
    out_.q.row(k) = q_;
    out_.v.row(k) = v_;
    out_.a.row(k) = a;
  }

  Dynamics dynamics_;
  const JointsMotion& drives_;
  const double step_;
  JointsMotion out_;
  Eigen::VectorXd q_, v_, h_;
  std::vector<long> at_;
  Eigen::MatrixXd K_, D_, M_;
};

// True motion of every joint: the recorded one minus the encoder's offset, or a better known one.
void fill_motion(const Plant& plant, const SmoothRecording& smooth, const std::vector<LinkMotion>& links,
                 RobotPath* path) {
  path->resize(smooth.joints.size());
  for (size_t j = 0; j < smooth.joints.size(); ++j) {
    JointPath& p = (*path)[j];
    if (j < links.size() && !links[j].q.empty()) {
      p.q = links[j].q;
      p.qd = links[j].qd;
      p.qdd = links[j].qdd;
    } else {
      p.q = smooth.joints[j].q;
      p.qd = smooth.joints[j].qd;
      p.qdd = smooth.joints[j].qdd;
      for (double& q : p.q) q -= plant.laws[j].joint_offset;
    }
    for (std::vector<double>* v : {&p.inertia, &p.load, &p.stiffness, &p.damping}) v->assign(p.q.size(), 0.0);
  }
}

// [rad], [rad/s] Steps of a joint for its derivatives: large compared with rounding, small compared with changes of the
// slopes.
constexpr double kMove = 1e-4, kMoveRate = 1e-3;
constexpr size_t kSlopeStride = 4;  // rows between two slopes; a straight line between them

void fill_slopes(Dynamics* dynamics, RobotPath* path) {
  const size_t n = path->size(), rows = (*path)[0].q.size();
  Eigen::VectorXd q(n), qd(n), qdd(n), tau(n), moved(n);
  for (size_t k = 0; k < rows; k += kSlopeStride) {
    for (size_t j = 0; j < n; ++j) {
      q[j] = (*path)[j].q[k];
      qd[j] = (*path)[j].qd[k];
      qdd[j] = (*path)[j].qdd[k];
    }
    dynamics->move(q.data(), qd.data());
    dynamics->calc_effort(qdd, &tau);
    for (size_t j = 0; j < n; ++j) {
      q[j] += kMove;
      dynamics->move(q.data(), qd.data());
      dynamics->calc_effort(qdd, &moved);
      (*path)[j].stiffness[k] = (moved[j] - tau[j]) / kMove;
      q[j] -= kMove;
      qd[j] += kMoveRate;
      dynamics->move(q.data(), qd.data());
      dynamics->calc_effort(qdd, &moved);
      (*path)[j].damping[k] = (moved[j] - tau[j]) / kMoveRate;
      qd[j] -= kMoveRate;
    }
  }
  for (JointPath& p : *path) {
    for (std::vector<double>* v : {&p.stiffness, &p.damping}) {
      for (size_t k = 0; k < rows; ++k) {
        const size_t a = k / kSlopeStride * kSlopeStride, b = a + kSlopeStride;
        if (k == a) continue;
        const double s = static_cast<double>(k - a) / kSlopeStride;
        (*v)[k] = b < rows ? (1.0 - s) * (*v)[a] + s * (*v)[b] : (*v)[a];
      }
    }
  }
}

}  // namespace

LinkWrenches calc_wrenches(const std::vector<SteadyForce>& forces, const Model& model, const Data& data) {
  LinkWrenches wrenches;
  if (forces.empty()) return wrenches;
  wrenches.resize(static_cast<size_t>(model.num_links()), Vector6d::Zero());
  for (const SteadyForce& force : forces) {
    Vector6d& wrench = wrenches[static_cast<size_t>(force.link)];
    wrench.head<3>() += (get_pose(data, force.link).R * force.p_LQ).cross(force.force_W);
    wrench.tail<3>() += force.force_W;
  }
  return wrenches;
}

Eigen::MatrixXd calc_efforts(const Plant& plant, const Eigen::MatrixXd& q, const Eigen::MatrixXd& qd,
                             const Eigen::MatrixXd& qdd) {
  Dynamics dynamics(plant);
  Eigen::VectorXd position, rate, acceleration, tau(q.cols());
  Eigen::MatrixXd efforts(q.rows(), q.cols());
  for (long k = 0; k < q.rows(); ++k) {
    position = q.row(k);
    rate = qd.row(k);
    acceleration = qdd.row(k);
    dynamics.move(position.data(), rate.data());
    dynamics.calc_effort(acceleration, &tau);
    efforts.row(k) = tau;
  }
  return efforts;
}

JointsMotion follow_drives(const Plant& plant, JointsMotion drives, double step) {
  if (std::none_of(plant.laws.begin(), plant.laws.end(), swings)) return drives;
  return ElasticLinks(plant, drives, step).run();
}

std::unique_ptr<Bodies> make_robot_bodies(const Plant& plant, const SmoothRecording& smooth) {
  return std::make_unique<RobotBodies>(plant, smooth);
}

std::unique_ptr<Bodies> make_path_bodies(const JointPath& path, const std::vector<double>& time) {
  return std::make_unique<PathBodies>(path, time);
}

RobotPath calc_path(const Plant& plant, const SmoothRecording& smooth, const RobotPath* slopes,
                    const std::vector<LinkMotion>& links) {
  RobotPath path;
  fill_motion(plant, smooth, links, &path);
  Dynamics dynamics(plant);
  const size_t n = path.size(), rows = path[0].q.size();
  Eigen::VectorXd q(n), qd(n), qdd(n), tau(n);
  for (size_t k = 0; k < rows; ++k) {
    for (size_t j = 0; j < n; ++j) {
      q[j] = path[j].q[k];
      qd[j] = path[j].qd[k];
      qdd[j] = path[j].qdd[k];
    }
    dynamics.move(q.data(), qd.data());
    dynamics.calc_effort(qdd, &tau);
    const Eigen::MatrixXd& M = dynamics.mass();
    for (size_t j = 0; j < n; ++j) {
      const long i = static_cast<long>(j);
      path[j].inertia[k] = M(i, i);
      path[j].load[k] = tau[i] - M(i, i) * qdd[i];
    }
  }
  if (!slopes) {
    fill_slopes(&dynamics, &path);
  } else {
    for (size_t j = 0; j < n; ++j) {
      path[j].stiffness = (*slopes)[j].stiffness;
      path[j].damping = (*slopes)[j].damping;
    }
  }
  return path;
}

}  // namespace hrp::diagnosis
