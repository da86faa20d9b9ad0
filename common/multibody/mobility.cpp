// SPDX-License-Identifier: BSD-3-Clause
// calc_link_mobility of forward_dynamics.h: responses of a few links to unit wrenches on them.
#include "common/base/check.h"
#include "common/multibody/articulated.h"
#include "common/multibody/forward_dynamics.h"

namespace hrp {
namespace {

using small::V3;

bool slides(const LinkConstants& L) { return L.code == JointCode::kSlide; }

// Marks the links on the ways from `links` to the base.
void mark_paths(const Model& model, const std::vector<int>& links, std::vector<char>* marks) {
  std::fill(marks->begin(), marks->end(), 0);
  for (int link : links) {
    HRP_CHECK(link >= 0 && link < model.num_links(), "link " << link);
    for (int i = link; i > 0; i = model.parent(i)) (*marks)[static_cast<size_t>(i)] = 1;
  }
}

// Unit wrench (component c) on `link`, carried to the base. Only this path gets u other than zero.
void pull_unit_wrench(const Model& model, int link, int c, Data* data) {
  const LinkConstants* links = model.links().data();
  const LinkKinematics* k = data->kinematics.data();
  LinkArticulated* A = data->articulated.data();
  for (int i = link; i > 0; i = links[i].parent) A[i].n = A[i].f = {0, 0, 0};
  A[0].n = A[0].f = {0, 0, 0};
  double unit[6] = {0, 0, 0, 0, 0, 0};
  unit[c] = -1;
  A[link].n = small::load(unit);
  A[link].f = small::load(unit + 3);
  for (int i = link; i > 0; i = links[i].parent) {
    articulated::pass_force(slides(links[i]), k[i].axis, k[i].r, 0.0, A + i, A + links[i].parent);
  }
}

void spread_marked(const Model& model, Data* data) {
  const LinkConstants* links = model.links().data();
  const LinkKinematics* k = data->kinematics.data();
  LinkArticulated* A = data->articulated.data();
  A[0].alpha = A[0].acc = {0, 0, 0};
  if (model.floating()) articulated::solve_base(data->base_factor, A);
  for (int i = 1; i < model.num_links(); ++i) {
    if (!data->marks[static_cast<size_t>(i)]) continue;
    articulated::pass_acceleration(slides(links[i]), k[i].axis, k[i].r, A[links[i].parent], A + i);
  }
}

}  // namespace

void calc_link_mobility(const Model& model, const std::vector<int>& links, Data* data, Eigen::MatrixXd* G) {
  const auto size = static_cast<Eigen::Index>(6 * links.size());
  HRP_CHECK(G->rows() == size && G->cols() == size, "G is " << G->rows() << " x " << G->cols());
  mark_paths(model, links, &data->marks);
  LinkArticulated* A = data->articulated.data();
  for (int i = 1; i < model.num_links(); ++i) A[i].u = 0;
  for (size_t b = 0; b < links.size(); ++b) {
    for (int c = 0; c < 6; ++c) {
      pull_unit_wrench(model, links[b], c, data);
      spread_marked(model, data);
      const auto column = static_cast<Eigen::Index>(6 * b) + c;
      for (size_t a = 0; a < links.size(); ++a) {
        double* entries = G->data() + column * size + static_cast<Eigen::Index>(6 * a);
        small::store(A[links[a]].alpha, entries);
        small::store(A[links[a]].acc, entries + 3);
      }
    }
    for (int i = links[b]; i > 0; i = model.parent(i)) A[i].u = 0;
  }
}

}  // namespace hrp
