// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/regressor.h"

#include "common/base/check.h"
#include "common/multibody/kinematics.h"

namespace hrp {
namespace {

using LinkRegressor = Eigen::Matrix<double, 6, kInertialParameters>;
using Matrix36d = Eigen::Matrix<double, 3, 6>;

// K(w) with I w = K(w) [xx xy xz yy yz zz].
Matrix36d make_inertia_columns(const Vector3d& w) {
  Matrix36d K;
  K << w.x(), w.y(), w.z(), 0, 0, 0,  //
      0, w.x(), 0, w.y(), w.z(), 0,   //
      0, 0, w.x(), 0, w.y(), w.z();
  return K;
}

// [n; f] about the link's origin in world axes per parameter: Newton and Euler as in motion_pass.h, in link axes first.
LinkRegressor calc_link_regressor(const LinkKinematics& k, const LinkMotion& m, const Vector3d& gravity_W) {
  const Matrix3d R = small::to_eigen(k.R);
  const Vector3d w = R.transpose() * small::to_eigen(k.w), alpha = R.transpose() * small::to_eigen(m.alpha);
  const Vector3d acc = R.transpose() * (small::to_eigen(m.acc) - gravity_W);
  const Matrix3d W = skew(w);
  LinkRegressor Y = LinkRegressor::Zero();
  Y.block<3, 1>(3, 0) = acc;
  Y.block<3, 3>(3, 1) = skew(alpha) + W * W;
  Y.block<3, 3>(0, 1) = -skew(acc);
  Y.block<3, 6>(0, 4) = make_inertia_columns(alpha) + W * make_inertia_columns(w);
  Y.topRows<3>() = (R * Y.topRows<3>()).eval();
  Y.bottomRows<3>() = (R * Y.bottomRows<3>()).eval();
  return Y;
}

// Moves the reference point of the moments to the parent's origin.
void shift(const Vector3d& r, LinkRegressor* Y) { Y->topRows<3>() += skew(r) * Y->bottomRows<3>(); }

void add_link(const Model& model, const Data& data, int link, LinkRegressor Y, Regressor* regressor) {
  const int column = kInertialParameters * link;
  for (int i = link; i > 0; i = model.parent(i)) {
    const LinkKinematics& k = data.kinematics[static_cast<size_t>(i)];
    const bool slides = model.links()[static_cast<size_t>(i)].code == JointCode::kSlide;
    regressor->Y_JI.block<1, kInertialParameters>(i - 1, column) =
        small::to_eigen(k.axis).transpose() * (slides ? Y.bottomRows<3>() : Y.topRows<3>());
    shift(small::to_eigen(k.r), &Y);
  }
  regressor->Y_BI.block<6, kInertialParameters>(0, column) = Y;
}

double sign(double x) { return x > 0 ? 1.0 : (x < 0 ? -1.0 : 0.0); }

}  // namespace

Regressor::Regressor(const Model& model)
    : Y_BI(Eigen::MatrixXd::Zero(6, kInertialParameters * model.num_links())),
      Y_JI(Eigen::MatrixXd::Zero(model.num_joints(), kInertialParameters * model.num_links())),
      Y_JJ(Eigen::MatrixXd::Zero(model.num_joints(), kJointParameters * model.num_joints())) {}

Eigen::VectorXd make_inertial_parameters(const Model& model) {
  Eigen::VectorXd phi(kInertialParameters * model.num_links());
  for (int i = 0; i < model.num_links(); ++i) {
    const LinkConstants& L = model.links()[static_cast<size_t>(i)];
    phi.segment<kInertialParameters>(kInertialParameters * i) << L.mass, L.h.x, L.h.y, L.h.z, L.I.xx, L.I.xy, L.I.xz,
        L.I.yy, L.I.yz, L.I.zz;
  }
  return phi;
}

Eigen::VectorXd make_joint_parameters(const Model& model) {
  Eigen::VectorXd phi(kJointParameters * model.num_joints());
  for (int i = 0; i < model.num_joints(); ++i) {
    const JointSpec& joint = model.spec().joint(i);
    phi.segment<kJointParameters>(kJointParameters * i) << joint.rotor_inertia, joint.viscous_friction,
        joint.coulomb_friction;
  }
  return phi;
}

void calc_regressor(const Model& model, const Eigen::VectorXd& vdot, Data* data, Regressor* regressor) {
  HRP_CHECK(regressor->Y_BI.cols() == kInertialParameters * model.num_links(), "regressor of another model");
  update_accelerations(model, vdot, data);
  for (int i = 0; i < model.num_links(); ++i) {
    const auto k = static_cast<size_t>(i);
    add_link(model, *data, i, calc_link_regressor(data->kinematics[k], data->motion[k], model.gravity_W()), regressor);
  }
  for (int i = 0; i < model.num_joints(); ++i) {
    const double qd = data->qd[i];
    regressor->Y_JJ.block<1, kJointParameters>(i, kJointParameters * i) << vdot[model.num_base() + i], qd, sign(qd);
  }
}

}  // namespace hrp
