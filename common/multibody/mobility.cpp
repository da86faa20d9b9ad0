// SPDX-License-Identifier: BSD-3-Clause
// calc_link_mobility of forward_dynamics.h: responses of a few links to unit wrenches on them. The six unit wrenches of
// a link go through the tree side by side, which vector units like: a third of the time of one after the other.
#include <algorithm>

#include "common/base/check.h"
#include "common/multibody/forward_dynamics.h"

namespace hrp {
namespace {

using small::V3;

constexpr int kWide = LinkBatch::kWide;

bool slides(const LinkConstants& L) { return L.code == JointCode::kSlide; }

// y += (a x b) for each of the six b.
inline void add_cross(V3 a, const double (&b)[3][kWide], double (&y)[3][kWide]) {
  for (int c = 0; c < kWide; ++c) {
    y[0][c] += a.y * b[2][c] - a.z * b[1][c];
    y[1][c] += a.z * b[0][c] - a.x * b[2][c];
    y[2][c] += a.x * b[1][c] - a.y * b[0][c];
  }
}

// y += a s for each of the six s.
inline void add_scaled(V3 a, const double (&s)[kWide], double (&y)[3][kWide]) {
  for (int c = 0; c < kWide; ++c) {
    y[0][c] += a.x * s[c];
    y[1][c] += a.y * s[c];
    y[2][c] += a.z * s[c];
  }
}

// s -= a . b for each of the six b.
inline void subtract_dot(V3 a, const double (&b)[3][kWide], double (&s)[kWide]) {
  for (int c = 0; c < kWide; ++c) s[c] -= a.x * b[0][c] + a.y * b[1][c] + a.z * b[2][c];
}

// Marks the links on the ways from links[first...] to the base and clears their u.
void mark_paths(const Model& model, const std::vector<int>& links, size_t first, Data* data) {
  std::fill(data->marks.begin(), data->marks.end(), 0);
  for (size_t a = first; a < links.size(); ++a) {
    HRP_CHECK(links[a] >= 0 && links[a] < model.num_links(), "link " << links[a]);
    for (int i = links[a]; i > 0; i = model.parent(i)) {
      data->marks[static_cast<size_t>(i)] = 1;
      LinkBatch& batch = data->batch[static_cast<size_t>(i)];
      std::fill(batch.u, batch.u + kWide, 0.0);
    }
  }
}

struct Wrenches {
  double n[3][kWide] = {}, f[3][kWide] = {};
};

// Bias forces of unit wrenches on `link` on their way to the base: what articulated::pass_force does.
void pull_unit_wrenches(const Model& model, int link, Data* data, Wrenches* p) {
  for (int k = 0; k < 3; ++k) p->n[k][k] = p->f[k][k + 3] = -1;
  for (int i = link; i > 0; i = model.parent(i)) {
    const auto at = static_cast<size_t>(i);
    const LinkKinematics& k = data->kinematics[at];
    const LinkArticulated& A = data->articulated[at];
    LinkBatch& batch = data->batch[at];
    double s[kWide];
    subtract_dot(k.axis, slides(model.links()[at]) ? p->f : p->n, batch.u);
    for (int c = 0; c < kWide; ++c) s[c] = batch.u[c] * A.D_inverse;
    add_scaled(A.Uf, s, p->f);
    add_scaled(A.Un, s, p->n);
    add_cross(k.r, p->f, p->n);
  }
}

// What articulated::solve_base does.
void solve_base(const Matrix6d& L, const Wrenches& p, LinkBatch* base) {
  double x[6][kWide];
  for (int i = 0; i < 6; ++i) {
    for (int c = 0; c < kWide; ++c) x[i][c] = i < 3 ? -p.n[i][c] : -p.f[i - 3][c];
    for (int j = 0; j < i; ++j) {
      for (int c = 0; c < kWide; ++c) x[i][c] -= L(i, j) * x[j][c];
    }
  }
  for (int i = 0; i < 6; ++i) {
    for (int c = 0; c < kWide; ++c) x[i][c] *= L(i, i);
  }
  for (int i = 4; i >= 0; --i) {
    for (int j = i + 1; j < 6; ++j) {
      for (int c = 0; c < kWide; ++c) x[i][c] -= L(j, i) * x[j][c];
    }
  }
  for (int i = 0; i < 3; ++i) {
    std::copy(x[i], x[i] + kWide, base->alpha[i]);
    std::copy(x[i + 3], x[i + 3] + kWide, base->acc[i]);
  }
}

// Accelerations of all marked links: what articulated::pass_acceleration does.
void spread_marked(const Model& model, const Wrenches& p, Data* data) {
  LinkBatch& base = data->batch[0];
  if (model.floating()) {
    solve_base(data->base_factor, p, &base);
  } else {
    base = LinkBatch{};
  }
  for (int i : model.order()) {
    const auto at = static_cast<size_t>(i);
    if (!data->marks[at]) continue;
    const LinkKinematics& k = data->kinematics[at];
    const LinkArticulated& A = data->articulated[at];
    const LinkBatch& parent = data->batch[static_cast<size_t>(model.parent(i))];
    LinkBatch& batch = data->batch[at];
    std::copy(&parent.alpha[0][0], &parent.alpha[0][0] + 3 * kWide, &batch.alpha[0][0]);
    std::copy(&parent.acc[0][0], &parent.acc[0][0] + 3 * kWide, &batch.acc[0][0]);
    add_cross(-k.r, parent.alpha, batch.acc);
    double qdd[kWide];
    std::copy(batch.u, batch.u + kWide, qdd);
    subtract_dot(A.Un, batch.alpha, qdd);
    subtract_dot(A.Uf, batch.acc, qdd);
    for (double& value : qdd) value *= A.D_inverse;
    add_scaled(k.axis, qdd, slides(model.links()[at]) ? batch.acc : batch.alpha);
  }
}

}  // namespace

void calc_link_mobility(const Model& model, const std::vector<int>& links, Data* data, Eigen::MatrixXd* G) {
  const auto size = static_cast<Eigen::Index>(6 * links.size());
  HRP_CHECK(G->rows() == size && G->cols() == size, "G is " << G->rows() << " x " << G->cols());
  for (size_t b = 0; b < links.size(); ++b) {
    mark_paths(model, links, b, data);
    Wrenches p;
    pull_unit_wrenches(model, links[b], data, &p);
    spread_marked(model, p, data);
    for (size_t a = b; a < links.size(); ++a) {
      const LinkBatch& batch = data->batch[static_cast<size_t>(links[a])];
      for (int row = 0; row < 6; ++row) {
        for (int c = 0; c < 6; ++c) {
          const auto i = static_cast<Eigen::Index>(6 * a) + row, j = static_cast<Eigen::Index>(6 * b) + c;
          (*G)(i, j) = (*G)(j, i) = row < 3 ? batch.alpha[row][c] : batch.acc[row - 3][c];
        }
      }
    }
  }
}

}  // namespace hrp
