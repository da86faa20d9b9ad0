// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/toss/rollout.h"

#include <algorithm>

#include "common/base/has.h"
#include "common/multibody/kinematics.h"
#include "servers/dynamics/impulse_contact.h"

namespace hrp::diagnosis::toss {
namespace {

constexpr double kFlightStep = 4e-3;   // [s] rotates by less than 0.1 rad at 25 rad/s: error of RK4 below 1e-7 rad
constexpr double kContactStep = 1e-3;  // [s] positions move with the mean velocity of the step
constexpr double kBand = 2e-5;         // [m] points this close to the ground touch it: below a tracker's resolution
constexpr double kImpactSpeed = 0.05;  // [m/s] slower contacts count as rolling or resting

ImpulseOptions make_options(double restitution) {
  ImpulseOptions options;
  options.restitution = restitution;
  options.slop = kBand;
  options.correction = 0.1;  // a start state below the ground comes out within 10 ms, not in one jump
  options.max_sweeps = 25;   // enough for a few points
  options.tolerance = 1e-6;
  return options;
}

class Stepper {
 public:
  Stepper(const World& world, const std::vector<Sole>& soles)
      : world_(world),
        soles_(soles),
        model_(world.body, world.gravity_W),
        data_(model_),
        state_(make_state(model_)),
        contact_(make_options(world.restitution), model_),
        plane_(make_ground_plane(world.ground)),
        extra_(0),
        v_(6),
        free_(6) {
    plane_.offset += kBand;
    const LinkInertia& inertia = world.body.links[0].inertia;
    com_ = inertia.p_LLcm_L;
    I_ = inertia.I_LLcm_L;
    I_inverse_ = I_.inverse();
    pairs_.resize(1);
  }

  void start(const BodyState& s) {
    state_.R_WB = s.R_WB;
    state_.p_WB = s.p_WB;
    state_.V_WB << s.w_WB, s.v_WB;
  }
  BodyState get() const { return {state_.R_WB, state_.p_WB, state_.V_WB.head<3>(), state_.V_WB.tail<3>()}; }

  // Advances by dt [s]; returns false if the state does not stay finite.
  bool advance(double dt, Regime* regime) {
    *regime = Regime::kFlight;
    for (int guard = 0; dt > 1e-9; ++guard) {
      if (guard > 400) return false;  // endless chatter
      const bool touching = find_contacts(&pairs_[0]);
      if (touching && *regime == Regime::kFlight) *regime = Regime::kContact;
      const double step =
          touching ? step_contact(std::min(dt, kContactStep), regime) : step_flight(std::min(dt, kFlightStep));
      if (step < 0.0) return false;
      dt -= step;
    }
    return state_.p_WB.allFinite() && state_.V_WB.allFinite();
  }

 private:
  // Visits every point that may touch, with its depth [m] below the raised plane.
  template <typename Visit>
  void visit_points(const State& state, const Visit& visit) const {
    const Transform X = state.X_WB();
    int index = 0;
    const auto see = [&](const Vector3d& p) { visit(index++, p, plane_.offset - plane_.n_W.dot(p)); };
    for (const Sole& sole : soles_) {
      for (const SolePoint& q : sole.points) see(X * q.p_LQ - q.radius * plane_.n_W);
      for (const SoleRim& rim : sole.rims) {
        Vector3d p_WQ[4];
        calc_rim_points(rim, X, plane_.n_W, p_WQ);
        for (const Vector3d& p : p_WQ) see(p);
      }
    }
  }

  bool find_contacts(ContactPair* pair) {
    pair->points.clear();
    touches_.clear();
    pair->body_a = 0;
    pair->body_b = kGround;
    pair->friction = world_.ground.friction;
    visit_points(state_, [&](int index, const Vector3d& p, double depth) {
      if (depth < 0.0) return;
      ContactPoint point;
      point.p_WC = p;
      point.n_BA_W = plane_.n_W;
      point.depth = depth;
      pair->points.push_back(point);
      touches_.push_back(index);
    });
    return !pair->points.empty();
  }

  // Largest depth [m] of a point that did not touch at the start of the step.
  double find_new_depth(const State& state) const {
    double deepest = -1e3;
    visit_points(state, [&](int index, const Vector3d&, double depth) {
      if (!has(touches_, index)) deepest = std::max(deepest, depth);
    });
    return deepest;
  }

  // Takes the longest step up to `dt` after which no new point is deeper than the band; returns its length [s].
  // move(dt) must be pure.
  template <typename Move>
  double take_step(double dt, const Move& move) {
    const double gap = find_new_depth(state_);
    State next = move(dt);
    for (int i = 0; i < 12; ++i) {
      const double depth = find_new_depth(next);
      if (!(depth > kBand)) break;
      dt *= std::clamp((0.5 * kBand - gap) / (depth - gap), 0.02, 0.98);
      next = move(dt);
    }
    state_ = next;
    return state_.p_WB.allFinite() ? dt : -1.0;
  }

  double step_flight(double dt) {
    return take_step(dt, [&](double h) { return fly(h); });
  }

  // Derivative of the quaternion for a constant angular momentum.
  Eigen::Vector4d calc_rate(const Eigen::Vector4d& c, const Vector3d& momentum_W) const {
    Eigen::Quaterniond q;
    q.coeffs() = c;
    const Matrix3d R = q.normalized().toRotationMatrix();
    const Vector3d w = R * (I_inverse_ * (R.transpose() * momentum_W));
    return 0.5 * (Eigen::Quaterniond(0, w.x(), w.y(), w.z()) * q).coeffs();
  }

  State fly(double h) const {
    State next = state_;
    const Matrix3d R = state_.R_WB.toRotationMatrix();
    const Vector3d w = state_.V_WB.head<3>(), r = R * com_;
    const Vector3d momentum = R * (I_ * (R.transpose() * w));
    const Eigen::Vector4d q = state_.R_WB.coeffs();
    const Eigen::Vector4d k1 = calc_rate(q, momentum), k2 = calc_rate(q + 0.5 * h * k1, momentum);
    const Eigen::Vector4d k3 = calc_rate(q + 0.5 * h * k2, momentum), k4 = calc_rate(q + h * k3, momentum);
    next.R_WB.coeffs() = q + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    next.R_WB.normalize();
    const Matrix3d R2 = next.R_WB.toRotationMatrix();
    const Vector3d w2 = R2 * (I_inverse_ * (R2.transpose() * momentum));
    const Vector3d v_com = state_.V_WB.tail<3>() + w.cross(r), a = world_.gravity_W - world_.drag * v_com;
    const Vector3d p_com = state_.p_WB + r + h * v_com + 0.5 * h * h * a, v2 = v_com + h * a;
    next.p_WB = p_com - R2 * com_;
    next.V_WB << w2, v2 - w2.cross(R2 * com_);
    return next;
  }

  // A step with touching points. If a new point touches before the end of the step, the step is repeated with the
  // shorter time.
  double step_contact(double dt, Regime* regime) {
    if (is_struck()) *regime = Regime::kImpact;
    update_kinematics(model_, state_, &data_);
    const State before = state_;
    double taken = 0.0;
    for (int round = 0; round < 3; ++round) {
      state_ = before;
      Vector6d move, after;
      if (!calc_contact_step(dt, &move, &after)) return -1.0;
      taken = take_step(dt, [&](double h) {
        State next = state_;
        integrate_positions(model_, move, h, &next);
        next.V_WB = after;
        return next;
      });
      if (taken < 0.0 || taken > 0.99 * dt || dt < 2e-6) break;
      dt = taken;
    }
    return taken;
  }

  // Velocities after `dt` with the points that touch now, and the velocities that move the positions (they also remove
  // penetration).
  bool calc_contact_step(double dt, Vector6d* move, Vector6d* after) {
    const Matrix3d R = state_.R_WB.toRotationMatrix();
    const Vector3d w = state_.V_WB.head<3>(), r = R * com_;
    const Matrix3d I_W = R * I_ * R.transpose();
    const Vector3d alpha = R * (I_inverse_ * (R.transpose() * -w.cross(I_W * w)));
    const Vector3d v_com = state_.V_WB.tail<3>() + w.cross(r);
    const Vector3d a = world_.gravity_W - world_.drag * v_com - alpha.cross(r) - w.cross(w.cross(r));
    v_ = state_.V_WB;
    free_.head<3>() = w + dt * alpha, free_.tail<3>() = state_.V_WB.tail<3>() + dt * a;
    if (contact_.solve(pairs_, model_, extra_, v_, free_, no_loops_, &data_) != Status::kOk) return false;
    LinkWrenches impulses(1, Vector6d::Zero());
    contact_.add(data_, 1.0, &impulses);  // about the body's origin
    const Vector3d P = impulses[0].tail<3>();
    const Vector3d dw = R * (I_inverse_ * (R.transpose() * (Vector3d(impulses[0].head<3>()) - r.cross(P))));
    *after = free_;
    after->head<3>() += dw, after->tail<3>() += P / model_.mass() - dw.cross(r);
    // Without an impact, the mean velocity makes the step second-order accurate. At an impact only the velocity after
    // it is valid.
    const bool smooth = (*after - v_).tail<3>().norm() < 5.0 * dt * world_.gravity_W.norm();
    *move = (smooth ? Vector6d(0.5 * (*after + v_)) : *after) + contact_.correction_velocity(dt);
    return true;
  }

  bool is_struck() const {
    for (const ContactPoint& point : pairs_[0].points) {
      const Vector3d v = state_.V_WB.tail<3>() + Vector3d(state_.V_WB.head<3>()).cross(point.p_WC - state_.p_WB);
      if (v.dot(point.n_BA_W) < -kImpactSpeed) return true;
    }
    return false;
  }

  const World& world_;
  const std::vector<Sole>& soles_;
  Model model_;
  Data data_;
  State state_;
  ImpulseContact contact_;
  GroundPlane plane_;  // raised by the band
  Vector3d com_;
  Matrix3d I_, I_inverse_;
  ContactSet pairs_;
  std::vector<int> touches_;
  Eigen::VectorXd extra_, v_, free_;
  Eigen::MatrixXd no_loops_;  // of a body alone
};

}  // namespace

bool roll_out(const World& world, const std::vector<Sole>& soles, const BodyState& start,
              const std::vector<double>& time, std::vector<BodyState>* states, std::vector<Regime>* regimes) {
  Stepper stepper(world, soles);
  stepper.start(start);
  states->assign(1, start);
  if (regimes) regimes->assign(1, Regime::kFlight);
  for (size_t k = 1; k < time.size(); ++k) {
    Regime regime;
    if (!stepper.advance(time[k] - time[k - 1], &regime)) return false;
    states->push_back(stepper.get());
    if (regimes) regimes->push_back(regime);
  }
  return true;
}

}  // namespace hrp::diagnosis::toss
