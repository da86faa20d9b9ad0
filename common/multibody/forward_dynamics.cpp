// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/forward_dynamics.h"

#include <cmath>

#include "common/base/check.h"
#include "common/multibody/articulated.h"
#include "common/multibody/motion_pass.h"

namespace hrp {

namespace articulated {

bool factor_base(const LinkArticulated& base, Matrix6d* factor) {
  const S3 &J = base.J, &M = base.M;
  const M3& H = base.H;
  double A[6][6] = {{J.xx},
                    {J.xy, J.yy},
                    {J.xz, J.yz, J.zz},
                    {H.x.x, H.x.y, H.x.z, M.xx},
                    {H.y.x, H.y.y, H.y.z, M.xy, M.yy},
                    {H.z.x, H.z.y, H.z.z, M.xz, M.yz, M.zz}};
  bool positive = true;
  for (int j = 0; j < 6; ++j) {
    const double before = A[j][j];
    double scaled[6];
    for (int k = 0; k < j; ++k) {
      scaled[k] = A[j][k];  // L_jk D_k
      A[j][k] *= A[k][k];   // A[k][k] holds 1 / D_k
      A[j][j] -= scaled[k] * A[j][k];
    }
    positive = positive && A[j][j] > 1e-14 * before;
    A[j][j] = 1.0 / A[j][j];
    for (int i = j + 1; i < 6; ++i) {
      for (int k = 0; k < j; ++k) A[i][j] -= A[i][k] * A[j][k];
    }
  }
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) (*factor)(i, j) = A[i][j];
  }
  return positive;
}

void solve_base(const Matrix6d& factor, LinkArticulated* base) {
  double x[6] = {-base->n.x, -base->n.y, -base->n.z, -base->f.x, -base->f.y, -base->f.z};
  for (int i = 1; i < 6; ++i) {
    for (int j = 0; j < i; ++j) x[i] -= factor(i, j) * x[j];
  }
  for (int i = 0; i < 6; ++i) x[i] *= factor(i, i);
  for (int i = 4; i >= 0; --i) {
    for (int j = i + 1; j < 6; ++j) x[i] -= factor(j, i) * x[j];
  }
  base->alpha = {x[0], x[1], x[2]};
  base->acc = {x[3], x[4], x[5]};
}

}  // namespace articulated

namespace {

using small::V3;

bool slides(const LinkConstants& L) { return L.code == JointCode::kSlide; }

inline void start_inertia(V3 h, const small::S3& I, double mass, LinkArticulated* A) {
  A->J = I;
  A->H = {{0, h.z, -h.y}, {-h.z, 0, h.x}, {h.y, -h.x, 0}};  // [h]x by columns
  A->M = {mass, 0, 0, mass, 0, mass};
}

inline void start_link(const LinkConstants& L, const LinkKinematics& k, LinkMotion* m, LinkArticulated* A) {
  const V3 h = k.R * L.h;
  const small::S3 I = calc_turned_inertia(L, k.R);
  motion_pass::load_link(k, h, I, L.mass, m);
  start_inertia(h, I, L.mass, A);
  A->n = m->n;
  A->f = m->f;
}

// Outward: motion with qdd = 0, its forces, and the rigid-body inertias.
void start_links(const Model& model, Data* data) {
  const LinkConstants* links = model.links().data();
  const LinkKinematics* k = data->kinematics.data();
  LinkMotion* m = data->motion.data();
  LinkArticulated* A = data->articulated.data();
  const double* qd = data->qd.data() - 1;
  m[0].alpha = {0, 0, 0};
  m[0].acc = -small::from_eigen(model.gravity_W());
  start_link(links[0], k[0], m, A);
  for (int i : model.order()) {
    const int p = links[i].parent;
    motion_pass::accelerate(links[i], k[p], k[i], qd[i], m[p], m + i);
    start_link(links[i], k[i], m + i, A + i);
  }
}

// Marked links as start_links leaves them; their motion and its forces are still there.
void restart_links(const Model& model, const std::vector<char>& marks, Data* data) {
  for (size_t i = 0; i < marks.size(); ++i) {
    if (!marks[i]) continue;
    const LinkConstants& L = model.links()[i];
    const LinkKinematics& k = data->kinematics[i];
    LinkArticulated* A = &data->articulated[i];
    start_inertia(k.R * L.h, calc_turned_inertia(L, k.R), L.mass, A);
    A->n = data->motion[i].n;
    A->f = data->motion[i].f;
  }
}

// Of marked links; of all without marks.
void subtract_wrenches(const Model& model, const LinkWrenches* wrenches, Data* data,
                       const std::vector<char>* marks = nullptr) {
  if (wrenches == nullptr || wrenches->empty()) return;
  HRP_CHECK(static_cast<int>(wrenches->size()) == model.num_links(), "one wrench per link, got " << wrenches->size());
  for (size_t i = 0; i < wrenches->size(); ++i) {
    if (marks != nullptr && !(*marks)[i]) continue;
    const Vector6d& F = (*wrenches)[i];
    LinkArticulated& A = data->articulated[i];
    A.n -= small::load(F.data());
    A.f -= small::load(F.data() + 3);
  }
}

void add_impedance_inertia(const Model& model, const LinkImpedances* impedances, Data* data) {
  if (impedances == nullptr) return;
  for (const LinkImpedance& impedance : *impedances) {
    HRP_CHECK(impedance.link >= 0 && impedance.link < model.num_links(), "link " << impedance.link);
    LinkArticulated& A = data->articulated[static_cast<size_t>(impedance.link)];
    const double* Z = impedance.Z.data();
    articulated::add({Z[0], Z[6], Z[12], Z[7], Z[13], Z[14]}, &A.J);
    articulated::add({Z[21], Z[27], Z[33], Z[28], Z[34], Z[35]}, &A.M);
    A.H.x += small::load(Z + 18);
    A.H.y += small::load(Z + 24);
    A.H.z += small::load(Z + 30);
  }
}

// What the impedances take of the motion with qdd = 0. motion.acc lacks gravity, an impedance feels true accelerations.
void add_impedance_force(const Model& model, const LinkImpedances* impedances, Data* data) {
  if (impedances == nullptr) return;
  for (const LinkImpedance& impedance : *impedances) {
    const auto i = static_cast<size_t>(impedance.link);
    const V3 acc = data->motion[i].acc + small::from_eigen(model.gravity_W()), alpha = data->motion[i].alpha;
    Vector6d a, F;
    a << alpha.x, alpha.y, alpha.z, acc.x, acc.y, acc.z;
    F.noalias() = impedance.Z * a;
    data->articulated[i].n += small::load(F.data());
    data->articulated[i].f += small::load(F.data() + 3);
  }
}

const double* get_inertia_extra(const ImplicitTerms& implicit) {
  return implicit.joint_inertia_extra != nullptr ? implicit.joint_inertia_extra->data() : nullptr;
}

inline double calc_joint_inertia(const LinkConstants& L, const double* extra, int link) {
  return L.rotor_inertia + (extra != nullptr ? extra[link - 1] : 0.0);
}

// What is gathered: a whole tree, or only its marked links: what others pass to a marked link is then the same as
// before, added in the same order.
enum class Reach { kAll, kMarked };

// Inward. `marks`: by link, of Reach::kMarked only. Returns false when some joint or the base cannot
// be accelerated.
template <Reach reach = Reach::kAll>
bool gather(const Model& model, const ImplicitTerms& implicit, const double* effort, Data* data,
            const char* marks = nullptr) {
  const LinkConstants* links = model.links().data();
  const LinkKinematics* k = data->kinematics.data();
  LinkArticulated* A = data->articulated.data();
  const double* extra = get_inertia_extra(implicit);
  const bool floating = model.floating();
  const auto is_gathered = [marks](int link) { return reach == Reach::kAll || marks[link] != 0; };
  bool positive = true;
  for (auto it = model.order().rbegin(); it != model.order().rend(); ++it) {
    const int i = *it;
    const int p = links[i].parent;
    if (!is_gathered(p)) continue;
    const bool slide = slides(links[i]);
    if (is_gathered(i))
      positive = articulated::project(slide, k[i].axis, calc_joint_inertia(links[i], extra, i), A + i) && positive;
    if (p > 0 || floating) articulated::pass_inertia(A[i], k[i].r, A + p);
    articulated::pass_force(slide, k[i].axis, k[i].r, effort[i - 1], A + i, A + p);
  }
  return (!floating || articulated::factor_base(A[0], &data->base_factor)) && positive;
}

// Outward: solution of the system whose right side is in the links' n, f and u. Writes all of x.
void spread(const Model& model, Data* data, double* x) {
  const LinkConstants* links = model.links().data();
  const LinkKinematics* k = data->kinematics.data();
  LinkArticulated* A = data->articulated.data();
  const int nb = model.num_base();
  A[0].alpha = A[0].acc = {0, 0, 0};
  if (nb > 0) {
    articulated::solve_base(data->base_factor, A);
    small::store(A[0].alpha, x);
    small::store(A[0].acc, x + 3);
  }
  for (int i : model.order()) {
    x[nb + i - 1] = articulated::pass_acceleration(slides(links[i]), k[i].axis, k[i].r, A[links[i].parent], A + i);
  }
}

void check_sizes(const Model& model, const Eigen::VectorXd& effort, const Eigen::VectorXd& vdot) {
  HRP_CHECK(effort.size() == model.num_joints() && vdot.size() == model.nv(),
            "sizes " << effort.size() << ", " << vdot.size());
}

void check_terms(const Model& model, const ImplicitTerms& implicit) {
  const Eigen::VectorXd* extra = implicit.joint_inertia_extra;
  HRP_CHECK(extra == nullptr || extra->size() == model.num_joints(), "joint_inertia_extra has " << extra->size());
}

Status finish_solve(const Model& model, bool positive, Data* data, Eigen::VectorXd* vdot) {
  spread(model, data, vdot->data());
  if (!std::isfinite(vdot->sum())) return positive ? Status::kNotFinite : Status::kSingular;
  return positive ? Status::kOk : Status::kSingular;
}

void load_right_side(const Model& model, const Eigen::VectorXd& tau, Data* data) {
  for (LinkArticulated& A : data->articulated) A.n = A.f = {0, 0, 0};
  if (!model.floating()) return;
  data->articulated[0].n -= small::load(tau.data());
  data->articulated[0].f -= small::load(tau.data() + 3);
}

// x = (M + ...)^-1 tau.
void calc_response(const Model& model, const Eigen::VectorXd& tau, Data* data, Eigen::VectorXd* x) {
  const LinkConstants* links = model.links().data();
  const LinkKinematics* k = data->kinematics.data();
  LinkArticulated* A = data->articulated.data();
  load_right_side(model, tau, data);
  const double* effort = tau.data() + model.num_base();
  for (auto it = model.order().rbegin(); it != model.order().rend(); ++it) {
    const int i = *it;
    articulated::pass_force(slides(links[i]), k[i].axis, k[i].r, effort[i - 1], A + i, A + links[i].parent);
  }
  spread(model, data, x->data());
}

}  // namespace

Status calc_forward_dynamics(const Model& model, const Eigen::VectorXd& effort, const LinkWrenches* wrenches,
                             const ImplicitTerms& implicit, Data* data, Eigen::VectorXd* vdot) {
  check_sizes(model, effort, *vdot);
  check_terms(model, implicit);
  start_links(model, data);
  subtract_wrenches(model, wrenches, data);
  add_impedance_inertia(model, implicit.impedances, data);
  add_impedance_force(model, implicit.impedances, data);
  return finish_solve(model, gather<>(model, implicit, effort.data(), data), data, vdot);
}

void mark_path(const Model& model, int link, std::vector<char>* marks) {
  for (int i = link; i > 0; i = model.parent(i)) (*marks)[static_cast<size_t>(i)] = 1;
  (*marks)[0] = 1;
}

Status recalc_forward_dynamics(const Model& model, const std::vector<char>& marks, const Eigen::VectorXd& effort,
                               const LinkWrenches* wrenches, const ImplicitTerms& implicit, Data* data,
                               Eigen::VectorXd* vdot) {
  check_sizes(model, effort, *vdot);
  HRP_CHECK(static_cast<int>(marks.size()) == model.num_links(), "one mark per link, got " << marks.size());
  check_terms(model, implicit);
  restart_links(model, marks, data);
  subtract_wrenches(model, wrenches, data, &marks);
  add_impedance_inertia(model, implicit.impedances, data);
  add_impedance_force(model, implicit.impedances, data);
  return finish_solve(model, gather<Reach::kMarked>(model, implicit, effort.data(), data, marks.data()), data, vdot);
}

void calc_responses(const Model& model, const Eigen::MatrixXd& B, Data* data, Eigen::MatrixXd* X) {
  HRP_CHECK(B.rows() == model.nv() && X->rows() == B.rows() && X->cols() == B.cols(), "B has " << B.rows() << " rows");
  for (Eigen::Index c = 0; c < B.cols(); ++c) {
    data->scratch = B.col(c);
    calc_response(model, data->scratch, data, &data->response);
    X->col(c) = data->response;
  }
}

}  // namespace hrp
