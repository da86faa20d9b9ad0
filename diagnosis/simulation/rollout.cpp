// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/simulation/rollout.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "diagnosis/data/command_reader.h"

namespace hrp::diagnosis {
namespace {

const double kGamma = 1.0 - 1.0 / std::sqrt(2.0);
constexpr int kFiner = 4;       // factor on the number of steps where a joint reverses
constexpr double kHeld = 0.02;  // share of dry friction that bristles do not carry yet; 0 while slipping

class Rollout {
 public:
  // Simulates `joints` of the robot with the dynamics `bodies`.
  Rollout(const Plant& plant, const Recording& recording, const SmoothRecording& smooth, std::vector<int> joints,
          Bodies* bodies)
      : plant_(plant),
        recording_(recording),
        smooth_(smooth),
        joints_(std::move(joints)),
        bodies_(*bodies),
        n_(static_cast<int>(joints_.size())) {
    N_ = n_;
    for (int j = 0; j < n_; ++j) motor_.push_back(laws(j).elastic ? N_++ : j);
    const size_t size = static_cast<size_t>(N_);
    for (std::vector<double>* v : {&Q_, &V_, &Qs_, &Vs_, &f_, &K_, &D_, &k1q_, &k1v_, &k2q_, &k2v_, &rhs_})
      v->assign(size, 0.0);
    for (std::vector<double>* v : {&U_, &Z_, &Us_, &Zs_, &fu_, &fz_, &k1u_, &k1z_, &lag_factor_, &lag_k_, &lag_d_, &gear_,
                                   &bias_, &B_, &Bs_, &fb_, &k1b_, &bristle_k_, &bristle_a_, &bristle_slip_}) {
      v->assign(static_cast<size_t>(n_), 0.0);
    }
    within_.assign(static_cast<size_t>(n_), 0);
    couple_k_.assign(size, 0.0), couple_d_.assign(size, 0.0);
    A_.assign(size * size, 0.0), M_.assign(size * size, 0.0);
    mass_.assign(static_cast<size_t>(n_) * static_cast<size_t>(n_), 0.0);
    choose_follow_gains();
  }

  bool run(const RolloutOptions& options, const StartState* start, std::vector<double>* readings,
           std::vector<LinkMotion>* links) {
    const size_t rows = recording_.size();
    links_ = links;
    free_running_ = options.free_running;
    if (links) prepare_links(rows);
    begin(smooth_.start);
    if (start) correct(*start);
    write(smooth_.start, readings);
    long taken = 0;
    for (size_t k = smooth_.start; k + 1 < rows; ++k) {
      const double t = recording_.time[k], dt = recording_.time[k + 1] - t;
      if (options.until > 0.0 && t - recording_.time[smooth_.start] > options.until) break;
      const double longest = wants_small_steps() ? 0.5 * options.max_step : options.max_step;
      const int steps = std::max(1, static_cast<int>(std::ceil(dt / longest - 1e-9)));
      near_ = k;
      for (int i = 0; i < steps; ++i) {
        const double h = dt / steps;
        const int finer = is_turning(h) ? kFiner : 1;
        taken += finer;
        for (int f = 0; f < finer; ++f) {
          if (!step_within_limits(t + h * (i + static_cast<double>(f) / finer), h / finer)) return false;
        }
      }
      near_ = k + 1;
      write(k + 1, readings);
    }
    if (options.work) *options.work += taken * n_;
    return true;
  }

 private:
  size_t index(int j) const { return static_cast<size_t>(joints_[static_cast<size_t>(j)]); }  // in the robot
  const JointLaws& laws(int j) const { return plant_.laws[index(j)]; }

  // Starts from the measured state at sample k.
  void begin(size_t k) {
    for (int j = 0; j < n_; ++j) {
      const SmoothJoint& joint = smooth_.joints[index(j)];
      Q_[j] = joint.q[k] - laws(j).joint_offset;
      V_[j] = joint.qd[k];
      Z_[j] = 0.0;
    }
    near_ = k;
    start_transmissions(k);
    for (int j = 0; j < n_; ++j) U_[j] = calc_drive(j, recording_.time[k], Q_.data(), V_.data());
    start_bristles(k);
  }

  void correct(const StartState& start) {
    for (int j = 0; j < n_; ++j) {
      const size_t i = index(j), m = static_cast<size_t>(motor_[j]);
      if (!start.q.empty()) Q_[m] += start.q[i], V_[m] += start.v[i];
      if (motor_[j] != j && !start.link_q.empty()) Q_[j] += start.link_q[i], V_[j] += start.link_v[i];
      if (!start.bristles.empty()) B_[j] += start.bristles[i] * laws(j).presliding;
      if (!start.memory.empty()) Z_[j] = std::min(1.0, std::max(-1.0, start.memory[i]));
      limit_bristles(j);
    }
  }

  // True for transmissions, which are much stiffer than a servo, and for dry friction along a recorded path. Small
  // steps cost little there, and steps of 1 ms would hide other effects of the joint.
  bool wants_small_steps() const { return N_ > n_ || (n_ == 1 && laws(0).has_friction()); }

  // True if dry friction holds a joint, or if it stops or starts within about a step of h [s]. The force is then not a
  // smooth function of time, and no method has order 2.
  bool is_turning(double h) const {
    for (int j = 0; j < n_; ++j) {
      const size_t m = static_cast<size_t>(motor_[j]);
      if (!laws(j).has_friction()) continue;
      if (std::abs(V_[m]) < 2.0 * h * std::abs(k1v_[m]) || bristle_slip_[j] > kHeld) return true;
    }
    return false;
  }

  // Initial deflection of the bristles: from the drive's effort minus that of the motion.
  void start_bristles(size_t k) {
    std::vector<double> tau(static_cast<size_t>(n_));
    bodies_.calc_efforts(k, tau.data());
    for (int j = 0; j < n_; ++j) {
      B_[j] = 0.0;
      if (!laws(j).has_friction()) continue;
      const double missing = calc_given_torque(laws(j), U_[j], V_[motor_[j]]) - tau[static_cast<size_t>(j)];
      const double level = calc_level(j, 0.0, U_[j], missing) + calc_holding_level(laws(j), U_[j], missing);
      B_[j] = missing / level * laws(j).presliding;
      limit_bristles(j);
    }
  }

  // Start of elastic joints. The encoder is on the motor; the link differs by the twist under the present load.
  void start_transmissions(size_t k) {
    if (N_ == n_) return;
    std::vector<double> tau(static_cast<size_t>(n_));
    bodies_.calc_efforts(k, tau.data());
    for (int j = 0; j < n_; ++j) {
      if (!laws(j).elastic) continue;
      Q_[motor_[j]] = Q_[j], V_[motor_[j]] = V_[j];
      Q_[j] -= tau[j] / laws(j).stiffness + (tau[j] > 0.0 ? 0.5 : -0.5) * laws(j).gap;
    }
  }

  void choose_follow_gains() {
    follow_k_.assign(static_cast<size_t>(n_), 0.0), follow_d_ = follow_k_, free_.assign(static_cast<size_t>(n_), 0);
    std::vector<double> q(static_cast<size_t>(n_)), zero(static_cast<size_t>(n_), 0.0);
    for (int j = 0; j < n_; ++j) q[j] = smooth_.joints[index(j)].q[smooth_.start];
    bodies_.evaluate(recording_.time[smooth_.start], smooth_.start, q.data(), zero.data(), mass_.data(), bias_.data());
    for (int j = 0; j < n_; ++j) {
      follow_k_[j] = mass_[j * n_ + j] * kFollow * kFollow;
      follow_d_[j] = 2.0 * mass_[j * n_ + j] * kFollow;
    }
  }

  // Pulls the joint to its recorded motion.
  void follow(int j, double t, double q, double v) {
    const SmoothJoint& joint = smooth_.joints[index(j)];
    const double q_recorded = interpolate(recording_.time, joint.q, t, near_),
                 v_recorded = interpolate(recording_.time, joint.qd, t, near_);
    const int m = motor_[j];
    f_[m] += follow_k_[j] * (q_recorded - q) + follow_d_[j] * (v_recorded - v);
    K_[m] += follow_k_[j], D_[m] += follow_d_[j];
  }

  // Servo (or recorded) effort of joint j before lag. Sets K_ and D_ of its motor coordinate to the derivatives.
  double calc_drive(int j, double t, const double* Q, const double* V) {
    const JointLaws& law = laws(j);
    const JointColumns& columns = recording_.joints[index(j)];
    const int m = motor_[j];
    if (plant_.effort_driven) {
      free_[j] = 1;
      const auto& effort = smooth_.effort[index(j)];
      return effort.empty() ? 0.0 : interpolate(recording_.time, effort, t + get_effort_delay(plant_, j), near_);
    }
    free_[j] = 0;
    if (columns.command.empty()) return 0.0;
    double position, rate;
    const double origin = recording_.time.front();
    read_command(recording_.time, columns,
                 origin + (t - origin) * (1.0 + plant_.timing.clock_skew) - law.command_delay - plant_.timing.command_shift, near_,
                 &position, &rate);
    const double u = calc_servo_effort(law, position - Q[m] - law.joint_offset, rate - V[m], 0.0);
    if (std::abs(u) > law.effort_limit && !within_[j]) free_[j] = 1;
    if (free_[j]) return u > 0.0 ? law.effort_limit : -law.effort_limit;
    K_[m] = law.kp, D_[m] = law.kd;
    return u;
  }

  // Viscous friction and cogging on the motor side. Adds the derivative to `slope`.
  double calc_friction(int j, double q, double v, double* slope) const {
    const JointLaws& law = laws(j);
    *slope += law.viscous;
    return -law.viscous * v + (law.cogging_amplitude != 0.0 ? calc_cogging(law, q) : 0.0);
  }

  // Level of dry friction at a speed. The direction is that of the bent bristles `b`, since a joint at rest has none.
  double calc_level(int j, double speed, double load, double b) const {
    return std::max(1e-9, calc_friction_level(laws(j), speed, load, b > 0.0 ? 1.0 : -1.0));
  }

  // A gear that is hard to drive backwards multiplies the braking effort of the drive (joint_law.h), with the rotor's
  // inertia. The factor grows with the deflection of its bristles, `bend` from -1 to 1.
  void add_gear(int j, double drive, double bend) {
    const int m = motor_[j];
    gear_[j] = calc_holding_level(laws(j), drive, bend) / std::max(1e-300, std::abs(drive)) * std::min(1.0, std::abs(bend));
    f_[m] += gear_[j] * drive;
    K_[m] *= 1.0 + gear_[j], D_[m] *= 1.0 + gear_[j];
  }

  // Dry friction by bristles that bend and slip (Dahl, AIAA J. 14, 1976): effort = -level b / d, b' = v - |v| b / d,
  // with the pre-sliding displacement d. The level follows speed and load without delay. While sliding, friction
  // therefore equals the law's level, however fast that changes.
  double calc_dry_friction(int j, double h, double v, double load, double b, double* slope) {
    const double d = laws(j).presliding, speed = std::abs(v), k = calc_level(j, speed, load, b) / d;
    const double slip = speed / d, bend = 1.0 - (v > 0.0 ? b : -b) / d, c = kGamma * h;
    fb_[j] = v - slip * b;
    bristle_k_[j] = k, bristle_a_[j] = 1.0 / (1.0 + c * slip), bristle_slip_[j] = bend;
    *slope += c * k * std::max(0.0, bend) * bristle_a_[j];
    return -k * b;
  }

  void calc_joint_forces(int j, double t, double h, const double* Q, const double* V, const double* U, const double* Z,
                         const double* B) {
    const JointLaws& law = laws(j);
    const int m = motor_[j];
    double u = calc_drive(j, t, Q, V);
    lag_factor_[j] = 0.0;
    if (law.lag > 0.0) {
      const double w = kGamma * h / law.lag;
      fu_[j] = (u - U[j]) / law.lag;
      lag_factor_[j] = 1.0 / (1.0 + w);
      lag_k_[j] = K_[m] * w, lag_d_[j] = D_[m] * w;
      K_[m] *= w / (1.0 + w), D_[m] *= w / (1.0 + w);
      u = U[j];
    }
    const TorqueSlope slope = calc_given_slope(law, u, V[m]);
    u = calc_given_torque(law, u, V[m]);
    if (slope.over_effort == 0.0) free_[j] = 1;
    K_[m] *= slope.over_effort, D_[m] = D_[m] * slope.over_effort - std::min(0.0, slope.over_v);
    const double drive = u + calc_friction(j, Q[m], V[m], &D_[m]);
    f_[m] += drive;
    if (law.backdriven > 0.0) add_gear(j, drive, B[j] / law.presliding);
    if (law.has_friction()) f_[m] += calc_dry_friction(j, h, V[m], u, B[j], &D_[m]);
    if (free_[j] && !free_running_) follow(j, t, Q[m] + law.joint_offset, V[m]);
    if (law.cogging_amplitude != 0.0) K_[m] -= calc_cogging_slope(law, Q[m]);
    if (law.spring_stiffness != 0.0) {
      f_[j] -= law.spring_stiffness * (Q[j] - law.spring_rest);
      K_[j] += law.spring_stiffness;
    }
    if (law.hysteresis_stiffness > 0.0) {
      const double factor = calc_hysteresis_rate_factor(Z[j], V[j]);
      f_[j] -= law.hysteresis_stiffness * law.hysteresis_yield * Z[j];
      fz_[j] = factor * V[j] / law.hysteresis_yield;
      D_[j] += kGamma * h * law.hysteresis_stiffness * factor;
    }
    if (law.elastic) calc_transmission(j, Q, V);
  }

  void calc_transmission(int j, const double* Q, const double* V) {
    const JointLaws& law = laws(j);
    const int m = motor_[j];
    const double twist = calc_backlash_twist(law.gap, Q[m] - Q[j]);
    const bool open = law.gap > 0.0 && twist == 0.0;
    const double k = open ? 0.0 : law.stiffness, d = open ? 0.0 : law.damping;
    const double effort = k * twist + d * (V[m] - V[j]);
    f_[j] += effort, f_[m] -= effort;
    K_[j] += k, K_[m] += k, D_[j] += d, D_[m] += d;
    couple_k_[m] = -k, couple_d_[m] = -d;
  }

  // Computes forces f_, derivatives K_ and D_, and mass matrix M_ at a state.
  void evaluate(double t, double h, const double* Q, const double* V, const double* U, const double* Z,
                const double* B) {
    std::fill(f_.begin(), f_.end(), 0.0), std::fill(K_.begin(), K_.end(), 0.0), std::fill(D_.begin(), D_.end(), 0.0);
    for (int j = 0; j < n_; ++j) calc_joint_forces(j, t, h, Q, V, U, Z, B);
    bodies_.evaluate(t, near_, Q, V, mass_.data(), bias_.data());
    for (int j = 0; j < n_; ++j) f_[j] -= bias_[j];
    std::fill(M_.begin(), M_.end(), 0.0);
    for (int i = 0; i < n_; ++i) {
      for (int j = 0; j < n_; ++j) M_[i * N_ + j] = mass_[i * n_ + j];
      M_[motor_[i] * N_ + motor_[i]] += (1.0 + gear_[i]) * plant_.rotor[index(i)];
      // First-order correction for the lag of the servo's rate. It is limited to half of the inertia.
      double& own = M_[motor_[i] * N_ + motor_[i]];
      if (K_[motor_[i]] > 0.0) own -= std::min(laws(i).kd * plant_.timing.rate_lag, 0.5 * own);
      if (laws(i).elastic) M_[motor_[i] * N_ + motor_[i]] += laws(i).motor_inertia;
    }
  }

  // Solves (M + c D + c^2 K) x = rhs_ for x, with c = gamma h. Returns false if the matrix is not positive definite.
  bool solve(double c, double* x) {
    for (int i = 0; i < N_; ++i) {
      for (int j = 0; j <= i; ++j) A_[i * N_ + j] = M_[i * N_ + j];
      A_[i * N_ + i] += c * D_[i] + c * c * K_[i];
    }
    for (int j = 0; j < n_; ++j) {
      if (motor_[j] != j) A_[motor_[j] * N_ + j] += c * couple_d_[motor_[j]] + c * c * couple_k_[motor_[j]];
    }
    // L D L^T factorisation by rows; the diagonal contains the inverses of D.
    for (int i = 0; i < N_; ++i) {
      double* row = &A_[i * N_];
      for (int j = 0; j < i; ++j) {
        const double* other = &A_[j * N_];
        for (int k = 0; k < j; ++k) row[j] -= row[k] * other[k];
      }
      double d = row[i];
      for (int k = 0; k < i; ++k) {
        const double scaled = row[k];
        row[k] *= A_[k * N_ + k];
        d -= scaled * row[k];
      }
      if (!(d > 0.0)) return false;
      row[i] = 1.0 / d;
    }
    for (int i = 0; i < N_; ++i) {
      x[i] = rhs_[i];
      for (int k = 0; k < i; ++k) x[i] -= A_[i * N_ + k] * x[k];
    }
    for (int i = N_ - 1; i >= 0; --i) {
      x[i] *= A_[i * N_ + i];
      for (int k = i + 1; k < N_; ++k) x[i] -= A_[k * N_ + i] * x[k];
    }
    return std::isfinite(x[0]);
  }

  // Subtracts c K dq, the change of the stiff terms, from rhs_.
  void subtract_stiffness(double c, const double* dq) {
    for (int i = 0; i < N_; ++i) rhs_[i] -= c * K_[i] * dq[i];
    for (int j = 0; j < n_; ++j) {
      const int m = motor_[j];
      if (m == j) continue;
      rhs_[m] -= c * couple_k_[m] * dq[j];
      rhs_[j] -= c * couple_k_[m] * dq[m];
    }
  }

  // True if the servo is too stiff for its link. One step at the effort limit would then move the link far beyond the
  // reference, to the other limit. The simulation would oscillate between the limits, whatever the real servo does in
  // between.
  bool throws_over(int j, double h) const {
    const double own = M_[motor_[j] * N_ + motor_[j]];  // 0: not known before the first step
    return !plant_.effort_driven && own > 0.0 && laws(j).kd * h > own;
  }

  // One step in which such servos leave their limit. The step assumes a servo without limit and is valid if the effort
  // at its end is within the limit. Otherwise the step is repeated with the limit.
  bool step_within_limits(double t, double h) {
    bool any = false;
    for (int j = 0; j < n_; ++j) any = any || (within_[j] = throws_over(j, h));
    if (!any) return step(t, h);
    const auto before = std::make_tuple(Q_, V_, U_, Z_, B_);
    if (step(t, h)) {
      bool lasts = false;
      for (int j = 0; j < n_; ++j) {
        if (within_[j] && std::abs(calc_drive(j, t + h, Q_.data(), V_.data())) > laws(j).effort_limit) {
          lasts = true, within_[j] = 0;
        }
      }
      if (!lasts) return clear_within();
    }
    std::tie(Q_, V_, U_, Z_, B_) = before;
    clear_within();
    return step(t, h);
  }

  bool clear_within() {
    std::fill(within_.begin(), within_.end(), 0);
    return true;
  }

  bool step(double t, double h) {
    const double c = kGamma * h;
    evaluate(t, h, Q_.data(), V_.data(), U_.data(), Z_.data(), B_.data());
    // Stage 1: kq = V + c kv.
    for (int i = 0; i < N_; ++i) rhs_[i] = f_[i];
    add_lag(c, fu_.data());
    subtract_stiffness(c, V_.data());
    if (!solve(c, k1v_.data())) return false;
    for (int i = 0; i < N_; ++i) k1q_[i] = V_[i] + c * k1v_[i];
    for (int j = 0; j < n_; ++j) {
      finish_memory(j, fu_[j], fz_[j], k1q_.data(), k1v_.data(), &k1u_[j], &k1z_[j]);
      k1b_[j] = finish_bristles(j, c, k1v_.data());
      Bs_[j] = B_[j] + h * k1b_[j];
    }
    for (int i = 0; i < N_; ++i) Qs_[i] = Q_[i] + h * k1q_[i], Vs_[i] = V_[i] + h * k1v_[i];
    for (int j = 0; j < n_; ++j) Us_[j] = U_[j] + h * k1u_[j], Zs_[j] = Z_[j] + h * k1z_[j];
    // Stage 2: F(w1) - 2 k1.
    evaluate(t + h, h, Qs_.data(), Vs_.data(), Us_.data(), Zs_.data(), Bs_.data());
    for (int i = 0; i < N_; ++i) {
      double s = f_[i];
      for (int k = 0; k < N_; ++k) s -= 2.0 * M_[i * N_ + k] * k1v_[k];
      rhs_[i] = s;
      Vs_[i] -= 2.0 * k1q_[i];  // right-hand side of the position rows
    }
    for (int j = 0; j < n_; ++j) fu_[j] -= 2.0 * k1u_[j], fz_[j] -= 2.0 * k1z_[j], fb_[j] -= 2.0 * k1b_[j];
    add_lag(c, fu_.data());
    subtract_stiffness(c, Vs_.data());
    if (!solve(c, k2v_.data())) return false;
    for (int i = 0; i < N_; ++i) k2q_[i] = Vs_[i] + c * k2v_[i];
    for (int j = 0; j < n_; ++j) {
      double k2u, k2z;
      finish_memory(j, fu_[j], fz_[j], k2q_.data(), k2v_.data(), &k2u, &k2z);
      U_[j] += h * (1.5 * k1u_[j] + 0.5 * k2u);
      Z_[j] += h * (1.5 * k1z_[j] + 0.5 * k2z);
      B_[j] += h * (1.5 * k1b_[j] + 0.5 * finish_bristles(j, c, k2v_.data()));
      limit_bristles(j);
    }
    for (int i = 0; i < N_; ++i) {
      Q_[i] += h * (1.5 * k1q_[i] + 0.5 * k2q_[i]);
      V_[i] += h * (1.5 * k1v_[i] + 0.5 * k2v_[i]);
    }
    return std::abs(Q_[0]) < 1e6;
  }

  double finish_bristles(int j, double c, const double* kv) const {
    return laws(j).has_friction() ? bristle_a_[j] * (fb_[j] + c * std::max(0.0, bristle_slip_[j]) * kv[motor_[j]])
                                  : 0.0;
  }

  // Limits bristles to the largest friction, whatever the step.
  void limit_bristles(int j) {
    const double most = laws(j).presliding;
    B_[j] = std::min(most, std::max(-most, B_[j]));
  }

  // Adds the forces on the motors from changes of lagged efforts and bristles within the stage.
  void add_lag(double c, const double* fu) {
    for (int j = 0; j < n_; ++j) {
      if (laws(j).has_friction()) rhs_[motor_[j]] -= c * bristle_k_[j] * bristle_a_[j] * fb_[j];
      if (lag_factor_[j] > 0.0) rhs_[motor_[j]] += laws(j).torque_scale * c * lag_factor_[j] * fu[j];
    }
  }

  void finish_memory(int j, double fu, double fz, const double* kq, const double* kv, double* ku, double* kz) const {
    *ku = 0.0, *kz = 0.0;
    if (lag_factor_[j] > 0.0) {
      const int m = motor_[j];
      *ku = lag_factor_[j] * (fu - (lag_k_[j] * kq[m] + lag_d_[j] * kv[m]));
    }
    if (laws(j).hysteresis_stiffness > 0.0) *kz = fz;
  }

  // Columns of joints that are not simulated stay 0.
  void write(size_t k, std::vector<double>* readings) {
    double* row = readings->data() + k * plant_.laws.size() * kQuantities;
    for (int j = 0; j < n_; ++j) {
      const int m = motor_[j];
      double* out = row + index(j) * kQuantities;
      out[0] = Q_[m] + laws(j).joint_offset;
      out[1] = V_[m];
      out[2] = calc_drive(j, recording_.time[k], Q_.data(), V_.data());
      if (!links_) continue;
      LinkMotion& link = (*links_)[index(j)];
      link.q[k] = Q_[j], link.qd[k] = V_[j];
    }
  }

  void prepare_links(size_t rows) {
    links_->resize(plant_.laws.size());
    for (int j = 0; j < n_; ++j) {
      (*links_)[index(j)].q.assign(rows, 0.0), (*links_)[index(j)].qd.assign(rows, 0.0);
    }
  }

  const Plant& plant_;
  const Recording& recording_;
  const SmoothRecording& smooth_;
  std::vector<int> joints_;
  Bodies& bodies_;
  int n_, N_ = 0;
  std::vector<LinkMotion>* links_ = nullptr;
  size_t near_ = 0;
  bool free_running_ = false;
  std::vector<double> follow_k_, follow_d_;
  std::vector<char> free_;    // the drive does not hold the joint at present
  std::vector<char> within_;  // the servo is within its limit again at the end of this step
  std::vector<int> motor_;  // coordinate of each joint's motor
  std::vector<double> Q_, V_, Qs_, Vs_, f_, K_, D_, k1q_, k1v_, k2q_, k2v_, rhs_;
  std::vector<double> B_, Bs_, fb_, k1b_, bristle_k_, bristle_a_, bristle_slip_;  // by joint; B_: deflections [rad]
  std::vector<double> U_, Z_, Us_, Zs_, fu_, fz_, k1u_, k1z_, lag_factor_, lag_k_, lag_d_, gear_;
  std::vector<double> couple_k_, couple_d_, A_, M_, mass_, bias_;
};

}  // namespace

bool simulate_recording(const Plant& plant, const Recording& recording, const SmoothRecording& smooth,
                        const RolloutOptions& options, std::vector<double>* readings, const StartState* start) {
  readings->assign(recording.size() * plant.laws.size() * kQuantities, 0.0);
  std::vector<int> joints(plant.laws.size());
  for (size_t j = 0; j < joints.size(); ++j) joints[j] = static_cast<int>(j);
  const std::unique_ptr<Bodies> bodies = make_robot_bodies(plant, smooth);
  if (!Rollout(plant, recording, smooth, joints, bodies.get()).run(options, start, readings, nullptr)) return false;
  apply_faults(plant, recording, readings);
  return true;
}

bool simulate_joint(const Plant& plant, const Recording& recording, const SmoothRecording& smooth,
                    const RobotPath& path, int joint, const RolloutOptions& options, std::vector<double>* readings,
                    std::vector<LinkMotion>* links) {
  const std::unique_ptr<Bodies> bodies = make_path_bodies(path[static_cast<size_t>(joint)], recording.time);
  return Rollout(plant, recording, smooth, {joint}, bodies.get()).run(options, nullptr, readings, links);
}

void apply_faults(const Plant& plant, const Recording& recording, std::vector<double>* readings) {
  const size_t width = plant.faults.size(), rows = recording.size();
  for (size_t c = 0; c < width; ++c) {
    const SensorErrors& fault = plant.faults[c];
    if (fault.delay > 0.0) {
      std::vector<double> series(rows);
      for (size_t k = 0; k < rows; ++k) series[k] = (*readings)[k * width + c];
      for (size_t k = 0; k < rows; ++k) {
        (*readings)[k * width + c] = interpolate(recording.time, series, recording.time[k] - fault.delay, k);
      }
    }
    const double bias = fault.bias.x(), scale = fault.scale.x();
    if (bias == 0.0 && scale == 1.0) continue;
    for (size_t k = 0; k < rows; ++k)
      (*readings)[k * width + c] = scale * (*readings)[k * width + c] + bias;
  }
}

}  // namespace hrp::diagnosis
