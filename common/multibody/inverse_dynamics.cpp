// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/inverse_dynamics.h"

#include "common/base/check.h"
#include "common/multibody/motion_pass.h"

namespace hrp {
namespace {

using small::V3;

void start_base(const Model& model, const double* vdot, LinkMotion* base) {
  const bool moves = model.floating() && vdot != nullptr;
  base->alpha = moves ? small::load(vdot) : V3{0, 0, 0};
  base->acc = (moves ? small::load(vdot + 3) : V3{0, 0, 0}) - small::from_eigen(model.gravity_W());
}

// data->motion n, f: what each link takes by itself.
void load_links(const Model& model, const double* vdot, Data* data) {
  const LinkConstants* links = model.links().data();
  const LinkKinematics* k = data->kinematics.data();
  LinkMotion* m = data->motion.data();
  const double* qd = data->qd.data() - 1;
  const double* qdd = vdot != nullptr ? vdot + model.num_base() - 1 : nullptr;
  start_base(model, vdot, m);
  motion_pass::load_link(links[0], k[0], m);
  for (int i : model.order()) {
    const int p = links[i].parent;
    if (qdd != nullptr) {
      motion_pass::accelerate(links[i], k[p], k[i], qd[i], qdd[i], m[p], m + i);
    } else {
      motion_pass::accelerate(links[i], k[p], k[i], qd[i], m[p], m + i);
    }
    motion_pass::load_link(links[i], k[i], m + i);
  }
}

void subtract_wrenches(const Model& model, const LinkWrenches* wrenches, Data* data) {
  if (wrenches == nullptr || wrenches->empty()) return;
  HRP_CHECK(static_cast<int>(wrenches->size()) == model.num_links(), "one wrench per link, got " << wrenches->size());
  for (size_t i = 0; i < wrenches->size(); ++i) {
    data->motion[i].n -= small::load((*wrenches)[i].data());
    data->motion[i].f -= small::load((*wrenches)[i].data() + 3);
  }
}

// Sums the loads towards the base and reads the joints' share.
void gather(const Model& model, const double* vdot, Data* data, double* tau) {
  const LinkConstants* links = model.links().data();
  const LinkKinematics* k = data->kinematics.data();
  LinkMotion* m = data->motion.data();
  const int nb = model.num_base();
  for (auto it = model.order().rbegin(); it != model.order().rend(); ++it) {
    const int i = *it;
    LinkMotion& parent = m[links[i].parent];
    const int row = nb + i - 1;
    tau[row] = dot(k[i].axis, links[i].code == JointCode::kSlide ? m[i].f : m[i].n);
    if (vdot != nullptr) tau[row] += links[i].rotor_inertia * vdot[row];
    parent.f += m[i].f;
    parent.n += m[i].n + cross(k[i].r, m[i].f);
  }
  if (nb == 0) return;
  small::store(m[0].n, tau);
  small::store(m[0].f, tau + 3);
}

}  // namespace

Vector6d calc_wrench_about_origin(const Data& data, int link, const Vector3d& p_WQ, const Vector6d& F_Q_W) {
  const Vector3d arm = p_WQ - small::to_eigen(data.kinematics[static_cast<size_t>(link)].p);
  Vector6d F = F_Q_W;
  F.head<3>() += arm.cross(Vector3d(F_Q_W.tail<3>()));
  return F;
}

void calc_inverse_dynamics(const Model& model, const Eigen::VectorXd& vdot, const LinkWrenches* wrenches, Data* data,
                           Eigen::VectorXd* tau) {
  HRP_CHECK(vdot.size() == model.nv() && tau->size() == model.nv(), "sizes " << vdot.size() << ", " << tau->size());
  load_links(model, vdot.data(), data);
  subtract_wrenches(model, wrenches, data);
  gather(model, vdot.data(), data, tau->data());
}

void calc_bias(const Model& model, Data* data, Eigen::VectorXd* bias) {
  HRP_CHECK(bias->size() == model.nv(), "size " << bias->size());
  load_links(model, nullptr, data);
  gather(model, nullptr, data, bias->data());
}

Vector6d get_joint_wrench(const Data& data, int link) {
  const LinkMotion& m = data.motion[static_cast<size_t>(link)];
  Vector6d F;
  F << m.n.x, m.n.y, m.n.z, m.f.x, m.f.y, m.f.z;
  return F;
}

}  // namespace hrp
