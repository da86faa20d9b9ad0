// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/mass_matrix.h"

namespace hrp {
namespace {

using small::S3;
using small::V3;

void turn_inertias(const Model& model, Data* data) {
  const LinkConstants* links = model.links().data();
  const LinkKinematics* k = data->kinematics.data();
  LinkComposite* c = data->composite.data();
  for (int i = model.floating() ? 0 : 1; i < model.num_links(); ++i) {
    c[i].mass = links[i].mass;
    c[i].h = k[i].R * links[i].h;
    c[i].I = calc_turned_inertia(links[i], k[i].R);
  }
}

// Adds a composite body whose origin is r away: Steiner's rule for a body with first moment h,
//   I + 2 r^T h 1 - r h^T - h r^T + m (r^T r 1 - r r^T) = I + r^T s 1 + r^T h 1 - sym(r s^T + ...), s = h + m r.
inline void add_composite(const LinkComposite& c, V3 r, LinkComposite* parent) {
  const V3 h = c.h, s = h + r * c.mass;
  const double xx = r.x * (h.x + s.x), yy = r.y * (h.y + s.y), zz = r.z * (h.z + s.z);
  parent->mass += c.mass;
  parent->h += s;
  S3& I = parent->I;
  I.xx += c.I.xx + yy + zz;
  I.yy += c.I.yy + xx + zz;
  I.zz += c.I.zz + xx + yy;
  I.xy += c.I.xy - (r.x * s.y + h.x * r.y);
  I.xz += c.I.xz - (r.x * s.z + h.x * r.z);
  I.yz += c.I.yz - (r.y * s.z + h.y * r.z);
}

// Column of joint i: force that the composite takes per qdd, projected on every joint up to the base.
inline void fill_column(const Model& model, int i, const Data& data, double* M, int nv) {
  const LinkConstants* links = model.links().data();
  const LinkKinematics* k = data.kinematics.data();
  const LinkComposite& c = data.composite[static_cast<size_t>(i)];
  const int nb = model.num_base(), col = nb + i - 1;
  const bool slides = links[i].code == JointCode::kSlide;
  const V3 a = k[i].axis;
  const V3 f = slides ? a * c.mass : cross(a, c.h);
  V3 n = slides ? cross(c.h, a) : c.I * a;
  M[col * nv + col] = dot(a, slides ? f : n) + links[i].rotor_inertia;
  for (int j = i; j > 0;) {
    n += cross(k[j].r, f);
    j = links[j].parent;
    if (j == 0) break;
    const int row = nb + j - 1;
    M[row * nv + col] = M[col * nv + row] = dot(k[j].axis, links[j].code == JointCode::kSlide ? f : n);
  }
  if (nb == 0) return;
  const double base[6] = {n.x, n.y, n.z, f.x, f.y, f.z};
  for (int row = 0; row < 6; ++row) M[row * nv + col] = M[col * nv + row] = base[row];
}

void fill_base(const LinkComposite& c, double* M, int nv) {
  const double A[6][6] = {{c.I.xx, c.I.xy, c.I.xz, 0, -c.h.z, c.h.y}, {c.I.xy, c.I.yy, c.I.yz, c.h.z, 0, -c.h.x},
                          {c.I.xz, c.I.yz, c.I.zz, -c.h.y, c.h.x, 0}, {0, c.h.z, -c.h.y, c.mass, 0, 0},
                          {-c.h.z, 0, c.h.x, 0, c.mass, 0},           {c.h.y, -c.h.x, 0, 0, 0, c.mass}};
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 6; ++col) M[row * nv + col] = A[row][col];
  }
}

}  // namespace

const Eigen::MatrixXd& update_mass_matrix(const Model& model, Data* data) {
  const int nv = model.nv();
  double* M = data->M.data();
  LinkComposite* c = data->composite.data();
  turn_inertias(model, data);
  for (auto it = model.order().rbegin(); it != model.order().rend(); ++it) {
    const int i = *it;
    fill_column(model, i, *data, M, nv);
    const int p = model.parent(i);
    if (p > 0 || model.floating()) add_composite(c[i], data->kinematics[static_cast<size_t>(i)].r, c + p);
  }
  if (model.floating()) fill_base(c[0], M, nv);
  return data->M;
}

}  // namespace hrp
