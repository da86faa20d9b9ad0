// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "diagnosis/simulation/rollout_impl.h"

namespace hrp::diagnosis {
namespace {

constexpr double kHeld = 0.02;  // share of dry friction that bristles do not carry yet; 0 while slipping

}  // namespace

bool Rollout::wants_small_steps() const { return N_ > n_ || (n_ == 1 && laws(0).has_friction()); }

bool Rollout::is_turning(double h) const {
  for (int j = 0; j < n_; ++j) {
    const size_t m = static_cast<size_t>(motor_[j]);
    if (!laws(j).has_friction()) continue;
    if (std::abs(x_.v[m]) < 2.0 * h * std::abs(k1v_[m]) || bristle_slip_[j] > kHeld) return true;
  }
  return false;
}

bool Rollout::solve(double c, double* x) {
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

void Rollout::subtract_stiffness(double c, const double* dq) {
  for (int i = 0; i < N_; ++i) rhs_[i] -= c * K_[i] * dq[i];
  for (int j = 0; j < n_; ++j) {
    const int m = motor_[j];
    if (m == j) continue;
    rhs_[m] -= c * couple_k_[m] * dq[j];
    rhs_[j] -= c * couple_k_[m] * dq[m];
  }
}

bool Rollout::throws_over(int j, double h) const {
  const double own = M_[motor_[j] * N_ + motor_[j]];  // 0: not known before the first step
  return !plant_.effort_driven && own > 0.0 && laws(j).kd * h > own;
}

bool Rollout::step_within_limits(double t, double h) {
  bool any = false;
  for (int j = 0; j < n_; ++j) any = any || (within_[j] = throws_over(j, h));
  if (!any) return step(t, h);
  const RolloutState before = x_;
  if (step(t, h)) {
    bool lasts = false;
    for (int j = 0; j < n_; ++j) {
      if (within_[j] && std::abs(calc_drive(j, t + h, x_)) > laws(j).effort_limit) {
        lasts = true;
        within_[j] = 0;
      }
    }
    if (!lasts) return clear_within();
  }
  x_ = before;
  clear_within();
  return step(t, h);
}

bool Rollout::clear_within() {
  std::fill(within_.begin(), within_.end(), 0);
  return true;
}

// Solves a stage's equations for the accelerations kv, with rhs_ and the speeds v where the stiff terms act.
bool Rollout::start_stage(double c, const std::vector<double>& v, std::vector<double>* kv) {
  add_lag(c, fu_.data());
  subtract_stiffness(c, v.data());
  return solve(c, kv->data());
}

// k1q = V + c k1v.
bool Rollout::run_first_stage(double h) {
  const double c = kGamma * h;
  for (int i = 0; i < N_; ++i) rhs_[i] = f_[i];
  if (!start_stage(c, x_.v, &k1v_)) return false;
  for (int i = 0; i < N_; ++i) k1q_[i] = x_.v[i] + c * k1v_[i];
  for (int j = 0; j < n_; ++j) {
    finish_memory(j, fu_[j], fz_[j], k1q_.data(), k1v_.data(), &k1u_[j], &k1z_[j]);
    k1b_[j] = finish_bristles(j, c, k1v_.data());
    predicted_.b[j] = x_.b[j] + h * k1b_[j];
  }
  for (int i = 0; i < N_; ++i) {
    predicted_.q[i] = x_.q[i] + h * k1q_[i];
    predicted_.v[i] = x_.v[i] + h * k1v_[i];
  }
  for (int j = 0; j < n_; ++j) {
    predicted_.u[j] = x_.u[j] + h * k1u_[j];
    predicted_.z[j] = x_.z[j] + h * k1z_[j];
  }
  return true;
}

// F(w1) - 2 k1. Adds both stages to the state.
bool Rollout::run_second_stage(double h) {
  const double c = kGamma * h;
  for (int i = 0; i < N_; ++i) {
    double s = f_[i];
    for (int k = 0; k < N_; ++k) s -= 2.0 * M_[i * N_ + k] * k1v_[k];
    rhs_[i] = s;
    predicted_.v[i] -= 2.0 * k1q_[i];  // right-hand side of the position rows
  }
  for (int j = 0; j < n_; ++j) {
    fu_[j] -= 2.0 * k1u_[j];
    fz_[j] -= 2.0 * k1z_[j];
    fb_[j] -= 2.0 * k1b_[j];
  }
  if (!start_stage(c, predicted_.v, &k2v_)) return false;
  for (int i = 0; i < N_; ++i) k2q_[i] = predicted_.v[i] + c * k2v_[i];
  for (int j = 0; j < n_; ++j) {
    double k2u, k2z;
    finish_memory(j, fu_[j], fz_[j], k2q_.data(), k2v_.data(), &k2u, &k2z);
    x_.u[j] += h * (1.5 * k1u_[j] + 0.5 * k2u);
    x_.z[j] += h * (1.5 * k1z_[j] + 0.5 * k2z);
    x_.b[j] += h * (1.5 * k1b_[j] + 0.5 * finish_bristles(j, c, k2v_.data()));
    limit_bristles(j);
  }
  for (int i = 0; i < N_; ++i) {
    x_.q[i] += h * (1.5 * k1q_[i] + 0.5 * k2q_[i]);
    x_.v[i] += h * (1.5 * k1v_[i] + 0.5 * k2v_[i]);
  }
  return true;
}

bool Rollout::step(double t, double h) {
  evaluate(t, h, x_);
  if (!run_first_stage(h)) return false;
  evaluate(t + h, h, predicted_);
  return run_second_stage(h) && std::abs(x_.q[0]) < 1e6;
}

double Rollout::finish_bristles(int j, double c, const double* kv) const {
  return laws(j).has_friction() ? bristle_a_[j] * (fb_[j] + c * std::max(0.0, bristle_slip_[j]) * kv[motor_[j]]) : 0.0;
}

void Rollout::limit_bristles(int j) {
  const double most = laws(j).presliding;
  x_.b[j] = std::min(most, std::max(-most, x_.b[j]));
}

void Rollout::add_lag(double c, const double* fu) {
  for (int j = 0; j < n_; ++j) {
    if (laws(j).has_friction()) rhs_[motor_[j]] -= c * bristle_k_[j] * bristle_a_[j] * fb_[j];
    if (lag_factor_[j] > 0.0) rhs_[motor_[j]] += laws(j).torque_scale * c * lag_factor_[j] * fu[j];
  }
}

void Rollout::finish_memory(int j, double fu, double fz, const double* kq, const double* kv, double* ku,
                            double* kz) const {
  *ku = 0.0;
  *kz = 0.0;
  if (lag_factor_[j] > 0.0) {
    const int m = motor_[j];
    *ku = lag_factor_[j] * (fu - (lag_k_[j] * kq[m] + lag_d_[j] * kv[m]));
  }
  if (laws(j).hysteresis_stiffness > 0.0) *kz = fz;
}

}  // namespace hrp::diagnosis
