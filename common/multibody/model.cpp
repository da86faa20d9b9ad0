// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/model.h"

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"

namespace hrp {
namespace {

void check_inertia(const LinkSpec& link, Diagnostics* diagnostics) {
  const std::string field = "link '" + link.name + "'";
  const LinkInertia& inertia = link.inertia;
  if (!std::isfinite(inertia.mass) || inertia.mass < 0) {
    diagnostics->add_error({"", field}, "mass " + std::to_string(inertia.mass) + " kg: expected a finite number >= 0");
    return;
  }
  if (!inertia.p_LLcm_L.allFinite() || !inertia.I_LLcm_L.allFinite()) {
    diagnostics->add_error({"", field}, "centre of mass or inertia is not finite");
    return;
  }
  const Matrix3d& I = inertia.I_LLcm_L;
  const double scale = I.cwiseAbs().maxCoeff();
  // 1e-9: inertias are written with few digits; anything above is a wrong matrix, not rounding.
  if ((I - I.transpose()).cwiseAbs().maxCoeff() > 1e-9 * scale) {
    diagnostics->add_error({"", field}, "inertia is not symmetric");
  } else if (scale > 0 &&
             Eigen::SelfAdjointEigenSolver<Matrix3d>(I, Eigen::EigenvaluesOnly).eigenvalues()(0) < -1e-9 * scale) {
    diagnostics->add_error({"", field}, "inertia has a negative eigenvalue");
  }
}

void check_joint(const LinkSpec& link, Diagnostics* diagnostics) {
  const JointSpec& joint = link.joint;
  const std::string field = "joint '" + joint.name + "'";
  if (!joint.X_PF.R.allFinite() || !joint.X_PF.p.allFinite()) {
    diagnostics->add_error({"", field}, "origin is not finite");
  } else if ((joint.X_PF.R * joint.X_PF.R.transpose() - Matrix3d::Identity()).norm() > 1e-9 ||
             joint.X_PF.R.determinant() < 0) {
    diagnostics->add_error({"", field}, "origin's rotation is not a rotation");
  }
  if (!(std::abs(joint.axis_F.norm() - 1) < 1e-9)) diagnostics->add_error({"", field}, "axis is not a unit vector");
  if (!std::isfinite(joint.rotor_inertia) || joint.rotor_inertia < 0) {
    diagnostics->add_error({"", field},
                           "rotor inertia " + std::to_string(joint.rotor_inertia) + ": expected a finite number >= 0");
  }
}

// Every joint must move mass or have a rotor, and a floating base needs a body.
void check_masses(const TreeSpec& spec, Diagnostics* diagnostics) {
  std::vector<double> mass(spec.links.size());
  for (size_t i = spec.links.size(); i-- > 0;) {
    mass[i] += spec.links[i].inertia.mass;
    if (i > 0) mass[static_cast<size_t>(spec.links[i].parent)] += mass[i];
  }
  for (size_t i = 0; i < spec.links.size(); ++i) {
    if (mass[i] > 0 || (i == 0 && !spec.floating_base)) continue;
    if (i > 0 && spec.links[i].joint.rotor_inertia > 0) continue;
    diagnostics->add_error({"", "link '" + spec.links[i].name + "'"},
                           "neither this link nor what hangs on it has mass");
  }
}

void check(const TreeSpec& spec) {
  Diagnostics diagnostics;
  if (spec.links.empty()) diagnostics.add_error({"", "tree '" + spec.name + "'"}, "has no links");
  for (size_t i = 0; i < spec.links.size(); ++i) {
    const LinkSpec& link = spec.links[i];
    check_inertia(link, &diagnostics);
    if (i == 0) continue;
    if (link.parent < 0 || link.parent >= static_cast<int>(i)) {
      diagnostics.add_error({"", "link '" + link.name + "'"}, "its parent must come before it in the tree");
    }
    check_joint(link, &diagnostics);
  }
  for (const FrameSpec& frame : spec.frames) {
    if (frame.link < 0 || frame.link >= static_cast<int>(spec.links.size())) {
      diagnostics.add_error({"", "frame '" + frame.name + "'"}, "is fixed to a link that does not exist");
    }
  }
  if (!diagnostics.has_errors()) check_masses(spec, &diagnostics);
  if (diagnostics.has_errors()) throw InputError(diagnostics);
}

void set_joint(const JointSpec& joint, LinkConstants* constants) {
  constants->turned = joint.X_PF.R != Matrix3d::Identity();
  constants->R_PF = small::from_eigen(joint.X_PF.R);
  constants->p_PF = small::from_eigen(joint.X_PF.p);
  constants->axis_F = small::from_eigen(Vector3d(joint.axis_F.normalized()));
  constants->rotor_inertia = joint.rotor_inertia;
  constants->code = joint.kind == JointKind::kPrismatic ? JointCode::kSlide : JointCode::kTurnAny;
  if (joint.kind == JointKind::kPrismatic) return;
  for (int k = 0; k < 3; ++k) {
    // Exactly: an axis 1e-11 off a coordinate axis shows when engines are compared.
    if (joint.axis_F.cwiseAbs() != Vector3d(Vector3d::Unit(k))) continue;
    constants->code = static_cast<JointCode>(k);
    constants->sign = joint.axis_F[k];
  }
}

LinkConstants make_constants(const LinkSpec& link, bool is_base) {
  LinkConstants constants;
  constants.parent = is_base ? -1 : link.parent;
  if (!is_base) set_joint(link.joint, &constants);
  const Vector3d& c = link.inertia.p_LLcm_L;
  constants.mass = link.inertia.mass;
  constants.h = small::from_eigen(Vector3d(constants.mass * c));
  const Matrix3d C = skew(c);
  const Matrix3d I = link.inertia.I_LLcm_L - constants.mass * C * C;
  constants.I = small::sym_from_eigen(I);
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(I);
  const Vector3d& principal = solver.eigenvalues();  // ascending
  constants.I_least = principal[0];
  constants.I_u = small::from_eigen(Vector3d(std::sqrt(principal[1] - principal[0]) * solver.eigenvectors().col(1)));
  constants.I_v = small::from_eigen(Vector3d(std::sqrt(principal[2] - principal[0]) * solver.eigenvectors().col(2)));
  return constants;
}

// Links by distance from the base, those of equal distance in the order of the tree.
std::vector<int> make_order(const TreeSpec& spec) {
  std::vector<int> depth(spec.links.size(), 0), order;
  for (size_t i = 1; i < spec.links.size(); ++i) {
    depth[i] = depth[static_cast<size_t>(spec.links[i].parent)] + 1;
    order.push_back(static_cast<int>(i));
  }
  std::stable_sort(order.begin(), order.end(),
                   [&depth](int a, int b) { return depth[static_cast<size_t>(a)] < depth[static_cast<size_t>(b)]; });
  return order;
}

}  // namespace

const char* get_status_text(Status status) {
  switch (status) {
    case Status::kOk: return "ok";
    case Status::kSingular: return "singular articulated inertia";
    case Status::kNotFinite: return "not finite";
  }
  return "?";
}

Model::Model(const TreeSpec& spec, const Vector3d& gravity_W) : spec_(spec), gravity_W_(gravity_W) {
  check(spec);
  for (size_t i = 0; i < spec.links.size(); ++i) {
    links_.push_back(make_constants(spec.links[i], i == 0));
    mass_ += spec.links[i].inertia.mass;
  }
  order_ = make_order(spec);
}

bool Model::is_ancestor(int ancestor, int link) const {
  while (link > ancestor) link = parent(link);
  return link == ancestor;
}

Data::Data(const Model& model) {
  const auto n = static_cast<size_t>(model.num_links());
  kinematics.assign(n, LinkKinematics{});
  motion.assign(n, LinkMotion{});
  articulated.assign(n, LinkArticulated{});
  composite.assign(n, LinkComposite{});
  for (LinkKinematics& k : kinematics) k.R = small::from_eigen(Matrix3d(Matrix3d::Identity()));
  M = Eigen::MatrixXd::Zero(model.nv(), model.nv());
  qd = Eigen::VectorXd::Zero(model.num_joints());
  scratch = response = Eigen::VectorXd::Zero(model.nv());
  sine = cosine = Eigen::VectorXd::Zero(model.num_joints());
}

}  // namespace hrp
