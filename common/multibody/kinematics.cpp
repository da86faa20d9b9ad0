// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/kinematics.h"

#include <cmath>

#include "common/base/check.h"
#include "common/multibody/sine_cosine.h"

namespace hrp {
namespace {

using small::M3;
using small::V3;

// Columns a and b turned in their plane: a' = c a + s b, b' = c b - s a.
inline void turn(V3* a, V3* b, double c, double s) {
  const V3 old = *a;
  *a = old * c + *b * s;
  *b = *b * c - old * s;
}

// R Rot(axis, q) by Rodrigues' formula.
M3 turn_about(const M3& R, V3 axis, double c, double s) {
  const double t = 1 - c;
  const V3 k = axis;
  const M3 Q{{c + t * k.x * k.x, t * k.x * k.y + s * k.z, t * k.x * k.z - s * k.y},
             {t * k.x * k.y - s * k.z, c + t * k.y * k.y, t * k.y * k.z + s * k.x},
             {t * k.x * k.z + s * k.y, t * k.y * k.z - s * k.x, c + t * k.z * k.z}};
  return R * Q;
}

inline void update_revolute(const LinkConstants& L, double c, double sine, LinkKinematics* k) {
  const double s = L.sign * sine;
  switch (L.code) {
    case JointCode::kTurnX:
      k->axis = k->R.x * L.sign;
      turn(&k->R.y, &k->R.z, c, s);
      break;
    case JointCode::kTurnY:
      k->axis = k->R.y * L.sign;
      turn(&k->R.z, &k->R.x, c, s);
      break;
    case JointCode::kTurnZ:
      k->axis = k->R.z * L.sign;
      turn(&k->R.x, &k->R.y, c, s);
      break;
    default: k->axis = k->R * L.axis_F; k->R = turn_about(k->R, L.axis_F, c, sine);
  }
}

struct JointState {
  double q, qd, cosine, sine;
};

inline void update_link(const LinkConstants& L, const LinkKinematics& parent, JointState joint, LinkKinematics* k) {
  k->R = L.turned ? parent.R * L.R_PF : parent.R;
  k->r = parent.R * L.p_PF;
  if (L.code == JointCode::kSlide) {
    k->axis = k->R * L.axis_F;
    k->r += k->axis * joint.q;
    k->w = parent.w;
    k->v = parent.v + cross(parent.w, k->r) + k->axis * joint.qd;
  } else {
    update_revolute(L, joint.cosine, joint.sine, k);
    k->w = parent.w + k->axis * joint.qd;
    k->v = parent.v + cross(parent.w, k->r);
  }
  k->p = parent.p + k->r;
}

void update_base(const Model& model, const State& state, LinkKinematics* base) {
  base->R = small::from_eigen(Matrix3d(state.R_WB.toRotationMatrix()));
  base->p = small::from_eigen(state.p_WB);
  base->r = base->p;
  base->w = model.floating() ? small::load(state.V_WB.data()) : V3{0, 0, 0};
  base->v = model.floating() ? small::load(state.V_WB.data() + 3) : V3{0, 0, 0};
}

Vector6d stack(V3 a, V3 b) {
  Vector6d c;
  c << a.x, a.y, a.z, b.x, b.y, b.z;
  return c;
}

void add_base_columns(V3 d, Eigen::Ref<Eigen::MatrixXd> J) {
  const Vector3d arm = small::to_eigen(d);
  J.topLeftCorner<6, 6>().setIdentity();
  J.block<3, 3>(3, 0) = -skew(arm);
}

}  // namespace

State make_state(const Model& model) {
  State state;
  state.q = Eigen::VectorXd::Zero(model.num_joints());
  state.qd = Eigen::VectorXd::Zero(model.num_joints());
  return state;
}

void update_kinematics(const Model& model, const State& state, Data* data) {
  const int n = model.num_joints();
  HRP_CHECK(state.q.size() == n && state.qd.size() == n,
            "sizes " << state.q.size() << ", " << state.qd.size() << "; the model has " << n << " joints");
  const LinkConstants* links = model.links().data();
  LinkKinematics* k = data->kinematics.data();
  const double *q = state.q.data(), *qd = state.qd.data();
  data->qd = state.qd;
  update_base(model, state, k);
  double *sine = data->sine.data(), *cosine = data->cosine.data();
  calc_sine_cosine(q, n, sine, cosine);
  for (int i : model.order()) {
    const int j = i - 1;
    update_link(links[i], k[links[i].parent], {q[j], qd[j], cosine[j], sine[j]}, k + i);
  }
}

Transform get_pose(const Data& data, int link) {
  const LinkKinematics& k = data.kinematics[static_cast<size_t>(link)];
  return {small::to_eigen(k.R), small::to_eigen(k.p)};
}

Vector6d get_velocity(const Data& data, int link) {
  const LinkKinematics& k = data.kinematics[static_cast<size_t>(link)];
  return stack(k.w, k.v);
}

Vector6d calc_point_velocity(const Data& data, int link, const Vector3d& p_WF) {
  const LinkKinematics& k = data.kinematics[static_cast<size_t>(link)];
  return stack(k.w, k.v + cross(k.w, small::from_eigen(p_WF) - k.p));
}

Transform calc_frame_pose(const Model& model, const Data& data, int frame) {
  const FrameSpec& f = model.spec().frames[static_cast<size_t>(frame)];
  return get_pose(data, f.link) * f.X_LF;
}

Vector6d calc_frame_velocity(const Model& model, const Data& data, int frame) {
  const FrameSpec& f = model.spec().frames[static_cast<size_t>(frame)];
  return calc_point_velocity(data, f.link, get_pose(data, f.link) * f.X_LF.p);
}

void update_accelerations(const Model& model, const Eigen::VectorXd& vdot, Data* data) {
  HRP_CHECK(vdot.size() == model.nv(), "size " << vdot.size() << "; the model has " << model.nv());
  const LinkConstants* links = model.links().data();
  const LinkKinematics* k = data->kinematics.data();
  LinkMotion* m = data->motion.data();
  const double* qdd = vdot.data() + model.num_base();
  m[0].alpha = model.floating() ? small::load(vdot.data()) : V3{0, 0, 0};
  m[0].acc = model.floating() ? small::load(vdot.data() + 3) : V3{0, 0, 0};
  for (int i = 1; i < model.num_links(); ++i) {
    const int p = links[i].parent;
    const V3 w = k[p].w, r = k[i].r, axis = k[i].axis;
    const double qd = data->qd[i - 1];
    m[i].alpha = m[p].alpha;
    m[i].acc = m[p].acc + cross(m[p].alpha, r) + cross(w, cross(w, r));
    if (links[i].code == JointCode::kSlide) {
      m[i].acc += axis * qdd[i - 1] + cross(w, axis) * (2 * qd);
    } else {
      m[i].alpha += axis * qdd[i - 1] + cross(w, axis) * qd;
    }
  }
}

Vector6d calc_point_acceleration(const Data& data, int link, const Vector3d& p_WQ) {
  const LinkKinematics& k = data.kinematics[static_cast<size_t>(link)];
  const LinkMotion& m = data.motion[static_cast<size_t>(link)];
  const V3 d = small::from_eigen(p_WQ) - k.p;
  return stack(m.alpha, m.acc + cross(m.alpha, d) + cross(k.w, cross(k.w, d)));
}

Vector6d calc_frame_acceleration(const Model& model, const Data& data, int frame) {
  const FrameSpec& f = model.spec().frames[static_cast<size_t>(frame)];
  return calc_point_acceleration(data, f.link, get_pose(data, f.link) * f.X_LF.p);
}

Vector6d calc_point_bias_acceleration(const Model& model, int link, const Vector3d& p_WQ, Data* data) {
  data->scratch.setZero();
  update_accelerations(model, data->scratch, data);
  return calc_point_acceleration(*data, link, p_WQ);
}

void calc_point_jacobian(const Model& model, const Data& data, int link, const Vector3d& p_WQ,
                         Eigen::Ref<Eigen::MatrixXd> J) {
  HRP_CHECK(J.rows() == 6 && J.cols() == model.nv(), "J is " << J.rows() << " x " << J.cols());
  const V3 p = small::from_eigen(p_WQ);
  J.setZero();
  if (model.floating()) add_base_columns(p - data.kinematics[0].p, J);
  for (int i = link; i > 0; i = model.parent(i)) {
    const LinkKinematics& k = data.kinematics[static_cast<size_t>(i)];
    const bool slides = model.links()[static_cast<size_t>(i)].code == JointCode::kSlide;
    J.col(model.velocity_index(i)) = slides ? stack({0, 0, 0}, k.axis) : stack(k.axis, cross(k.axis, p - k.p));
  }
}

void calc_frame_jacobian(const Model& model, const Data& data, int frame, Eigen::Ref<Eigen::MatrixXd> J) {
  const FrameSpec& f = model.spec().frames[static_cast<size_t>(frame)];
  calc_point_jacobian(model, data, f.link, get_pose(data, f.link) * f.X_LF.p, J);
}

void get_generalised_velocity(const Model& model, const State& state, Eigen::VectorXd* v) {
  if (model.floating()) v->head<6>() = state.V_WB;
  v->tail(model.num_joints()) = state.qd;
}

void set_generalised_velocity(const Model& model, const Eigen::VectorXd& v, State* state) {
  if (model.floating()) state->V_WB = v.head<6>();
  state->qd = v.tail(model.num_joints());
}

void integrate_positions(const Model& model, const Eigen::VectorXd& v, double dt, State* state) {
  state->q += dt * v.tail(model.num_joints());
  if (!model.floating()) return;
  const Vector3d turn = dt * v.head<3>();
  const double angle = turn.norm();
  // sin(angle / 2) / angle; its series below 1e-4 has an error of angle^4 / 3840 < 1e-19.
  const double scale = angle > 1e-4 ? std::sin(0.5 * angle) / angle : 0.5 - angle * angle / 48;
  Eigen::Quaterniond dR(std::cos(0.5 * angle), scale * turn.x(), scale * turn.y(), scale * turn.z());
  state->R_WB = dR * state->R_WB;
  state->R_WB.normalize();
  state->p_WB += dt * v.segment<3>(3);
}

}  // namespace hrp
