// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/momentum.h"

#include "common/base/check.h"

namespace hrp {
namespace {

using small::V3;

// Sum of m p_WLcm [kg m].
V3 calc_first_moment(const Model& model, const Data& data) {
  V3 moment{0, 0, 0};
  for (size_t i = 0; i < model.links().size(); ++i) {
    const LinkKinematics& k = data.kinematics[i];
    moment += k.p * model.links()[i].mass + k.R * model.links()[i].h;
  }
  return moment;
}

}  // namespace

Vector3d calc_centre_of_mass(const Model& model, const Data& data) {
  return small::to_eigen(calc_first_moment(model, data)) / model.mass();
}

Vector3d calc_centre_of_mass_velocity(const Model& model, const Data& data) {
  return calc_momentum(model, data, Vector3d::Zero()).tail<3>() / model.mass();
}

void calc_centre_of_mass_jacobian(const Model& model, Data* data, Eigen::Ref<Eigen::MatrixXd> J) {
  HRP_CHECK(J.rows() == 3 && J.cols() == model.nv(), "J is " << J.rows() << " x " << J.cols());
  const auto& links = model.links();
  for (size_t i = 0; i < links.size(); ++i) {
    data->composite[i].mass = links[i].mass;
    data->composite[i].h = data->kinematics[i].R * links[i].h;
  }
  for (size_t i = links.size(); i-- > 1;) {
    const LinkKinematics& k = data->kinematics[i];
    const LinkComposite& c = data->composite[i];
    LinkComposite& parent = data->composite[static_cast<size_t>(links[i].parent)];
    const V3 column = links[i].code == JointCode::kSlide ? k.axis * c.mass : cross(k.axis, c.h);
    J.col(model.velocity_index(static_cast<int>(i))) = small::to_eigen(column) / model.mass();
    parent.mass += c.mass;
    parent.h += c.h + k.r * c.mass;
  }
  if (!model.floating()) return;
  J.leftCols<3>() = -skew(small::to_eigen(data->composite[0].h) / model.mass());
  J.middleCols<3>(3).setIdentity();
}

Vector6d calc_momentum(const Model& model, const Data& data, const Vector3d& p_WQ) {
  V3 angular{0, 0, 0}, linear{0, 0, 0};
  const V3 q = small::from_eigen(p_WQ);
  for (size_t i = 0; i < model.links().size(); ++i) {
    const LinkConstants& L = model.links()[i];
    const LinkKinematics& k = data.kinematics[i];
    const V3 h = k.R * L.h;
    const V3 l = k.v * L.mass + cross(k.w, h);
    linear += l;
    angular += k.R * (L.I * transpose_times(k.R, k.w)) + cross(h, k.v) + cross(k.p - q, l);
  }
  Vector6d momentum;
  momentum << angular.x, angular.y, angular.z, linear.x, linear.y, linear.z;
  return momentum;
}

Vector6d calc_centroidal_momentum(const Model& model, const Data& data) {
  return calc_momentum(model, data, calc_centre_of_mass(model, data));
}

double calc_kinetic_energy(const Model& model, const Data& data) {
  double twice = 0;
  for (size_t i = 0; i < model.links().size(); ++i) {
    const LinkConstants& L = model.links()[i];
    const LinkKinematics& k = data.kinematics[i];
    const V3 w = transpose_times(k.R, k.w);
    twice += L.mass * dot(k.v, k.v) + 2 * dot(k.v, cross(k.w, k.R * L.h)) + dot(w, L.I * w);
    if (i > 0)
      twice += L.rotor_inertia * data.qd[static_cast<Eigen::Index>(i) - 1] * data.qd[static_cast<Eigen::Index>(i) - 1];
  }
  return 0.5 * twice;
}

double calc_potential_energy(const Model& model, const Data& data) {
  return -dot(small::from_eigen(model.gravity_W()), calc_first_moment(model, data));
}

}  // namespace hrp
