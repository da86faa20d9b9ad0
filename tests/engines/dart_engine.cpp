// SPDX-License-Identifier: BSD-3-Clause
#include "tests/engines/dart_engine.h"

#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/WeldJoint.hpp>

namespace hrp::engines {
namespace {

namespace dd = dart::dynamics;

Eigen::Isometry3d to_isometry(const Transform& X) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = X.R;
  T.translation() = X.p;
  return T;
}

dd::BodyNode::Properties make_body(const LinkSpec& link, int i) {
  const Matrix3d& I = link.inertia.I_LLcm_L;
  dd::Inertia inertia(link.inertia.mass, link.inertia.p_LLcm_L, I);
  return dd::BodyNode::Properties(dd::BodyNode::AspectProperties("b" + std::to_string(i), inertia));
}

template <class Joint>
dd::BodyNode* add_link(const dd::SkeletonPtr& skeleton, dd::BodyNode* parent, const LinkSpec& link, int i) {
  typename Joint::Properties properties;
  properties.mName = "j" + std::to_string(i - 1);
  properties.mT_ParentBodyToJoint = to_isometry(link.joint.X_PF);
  properties.mAxis = link.joint.axis_F;
  return skeleton->createJointAndBodyNodePair<Joint>(parent, properties, make_body(link, i)).second;
}

}  // namespace

struct DartEngine::Impl {
  dd::SkeletonPtr skeleton;
  int num_base = 0;
  Matrix3d R_WB = Matrix3d::Identity();
  Vector6d V_WB = Vector6d::Zero();
  std::vector<Eigen::Index> dofs;  // of joint i
  Eigen::MatrixXd M;
  Eigen::VectorXd positions;
  double turn = 1;

  // DART's velocity = T v: the free joint's is the base's spatial velocity in base axes.
  Eigen::MatrixXd calc_coordinate_change() const {
    const auto nv = static_cast<Eigen::Index>(skeleton->getNumDofs());
    Eigen::MatrixXd T = Eigen::MatrixXd::Zero(nv, nv);
    if (num_base > 0) T.block<3, 3>(0, 0) = T.block<3, 3>(3, 3) = R_WB.transpose();
    for (size_t i = 0; i < dofs.size(); ++i) T(dofs[i], num_base + static_cast<Eigen::Index>(i)) = 1;
    return T;
  }
  // DART's acceleration = T vdot + this: spatial, where ours is that of the origin.
  Eigen::VectorXd calc_acceleration_change() const {
    Eigen::VectorXd a = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(skeleton->getNumDofs()));
    if (num_base > 0) a.segment<3>(3) = -R_WB.transpose() * Vector3d(V_WB.head<3>()).cross(Vector3d(V_WB.tail<3>()));
    return a;
  }
};

DartEngine::DartEngine(const TreeSpec& spec, const Vector3d& gravity_W) : impl_(std::make_unique<Impl>()) {
  impl_->skeleton = dd::Skeleton::create("robot");
  impl_->skeleton->setGravity(gravity_W);
  impl_->num_base = spec.floating_base ? 6 : 0;
  std::vector<dd::BodyNode*> bodies;
  const dd::BodyNode::Properties base = make_body(spec.links[0], 0);
  if (spec.floating_base) {
    bodies.push_back(impl_->skeleton->createJointAndBodyNodePair<dd::FreeJoint>(nullptr, {}, base).second);
  } else {
    bodies.push_back(impl_->skeleton->createJointAndBodyNodePair<dd::WeldJoint>(nullptr, {}, base).second);
  }
  for (int i = 1; i < static_cast<int>(spec.links.size()); ++i) {
    const LinkSpec& link = spec.links[static_cast<size_t>(i)];
    dd::BodyNode* parent = bodies[static_cast<size_t>(link.parent)];
    const bool slides = link.joint.kind == JointKind::kPrismatic;
    bodies.push_back(slides ? add_link<dd::PrismaticJoint>(impl_->skeleton, parent, link, i)
                            : add_link<dd::RevoluteJoint>(impl_->skeleton, parent, link, i));
  }
  for (int i = 1; i < static_cast<int>(bodies.size()); ++i) {
    dd::Joint* joint = bodies[static_cast<size_t>(i)]->getParentJoint();
    impl_->dofs.push_back(static_cast<Eigen::Index>(joint->getIndexInSkeleton(0)));
  }
}

DartEngine::~DartEngine() = default;

void DartEngine::set_state(const State& state) {
  Impl& impl = *impl_;
  impl.R_WB = state.R_WB.toRotationMatrix();
  impl.V_WB = state.V_WB;
  Eigen::VectorXd q = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(impl.skeleton->getNumDofs()));
  Eigen::VectorXd v(q.size());
  if (impl.num_base > 0) q.head<6>() = dd::FreeJoint::convertToPositions(to_isometry({impl.R_WB, state.p_WB}));
  for (size_t i = 0; i < impl.dofs.size(); ++i) q[impl.dofs[i]] = state.q[static_cast<Eigen::Index>(i)];
  Eigen::VectorXd ours(q.size());
  if (impl.num_base > 0) ours.head<6>() = state.V_WB;
  ours.tail(state.qd.size()) = state.qd;
  impl.skeleton->setPositions(q);
  impl.skeleton->setVelocities(impl.calc_coordinate_change() * ours);
  impl.positions = q;
}

void DartEngine::set_effort(const Eigen::VectorXd& effort) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(impl_->skeleton->getNumDofs()));
  for (size_t i = 0; i < impl_->dofs.size(); ++i) force[impl_->dofs[i]] = effort[static_cast<Eigen::Index>(i)];
  impl_->skeleton->setForces(force);
}

void DartEngine::set_acceleration(const Eigen::VectorXd& vdot) {
  impl_->skeleton->setAccelerations(impl_->calc_coordinate_change() * vdot + impl_->calc_acceleration_change());
}

// DART compares with what it has: a change in the last digits makes it forget what it has cached.
void DartEngine::touch() {
  impl_->positions.array() *= 1 + 1e-12 * (impl_->turn = -impl_->turn);
  impl_->skeleton->setPositions(impl_->positions);
}
void DartEngine::run_forward_dynamics() { impl_->skeleton->computeForwardDynamics(); }
void DartEngine::run_mass_matrix() { impl_->M = impl_->skeleton->getMassMatrix(); }
void DartEngine::run_inverse_dynamics() { impl_->skeleton->computeInverseDynamics(false, false, false); }

Eigen::VectorXd DartEngine::get_acceleration() const {
  const Eigen::MatrixXd T = impl_->calc_coordinate_change();
  return T.transpose() * (impl_->skeleton->getAccelerations() - impl_->calc_acceleration_change());
}

Eigen::MatrixXd DartEngine::get_mass_matrix() const {
  const Eigen::MatrixXd T = impl_->calc_coordinate_change();
  return T.transpose() * impl_->M * T;
}

Eigen::VectorXd DartEngine::get_effort() const {
  return impl_->calc_coordinate_change().transpose() * impl_->skeleton->getForces();
}

}  // namespace hrp::engines
