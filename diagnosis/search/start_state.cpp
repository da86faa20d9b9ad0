// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/start_state.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/mean.h"
#include "diagnosis/estimate/rounds.h"

namespace hrp::diagnosis {
namespace {

// One component of the state: where it is stored, and its prior standard deviation.
struct Slot {
  std::vector<double> StartState::*member;
  size_t joint;
  double spread;
};

class Estimator {
 public:
  Estimator(const Problem& problem, const Hypothesis& hypothesis, int recording)
      : problem_(problem),
        hypothesis_(hypothesis),
        recording_(recording),
        smooth_(problem.smooth[static_cast<size_t>(recording)]) {
    options_ = problem.options;
    const std::vector<double>& time = problem.experiment->recordings[static_cast<size_t>(recording)].time;
    options_.until = time[smooth_.judged] - time[smooth_.start];
    list_slots(make_plant(*problem.experiment, hypothesis));
  }

  StartState run() {
    const size_t n = static_cast<size_t>(problem_.experiment->num_joints());
    StartState state;
    for (const Slot& slot : slots_) (state.*slot.member).assign(n, 0.0);
    std::vector<double> residuals;
    if (!calc(state, &residuals)) return {};
    double cost = calc_cost(state, residuals);
    for (int i = 0; i < kFewRounds; ++i) {  // the state acts almost linearly
      StartState next = take_step(state, residuals);
      std::vector<double> moved;
      if (!calc(next, &moved)) break;
      const double next_cost = calc_cost(next, moved);
      if (!(next_cost < cost)) break;
      state = std::move(next);
      residuals = std::move(moved);
      cost = next_cost;
    }
    return state;
  }

 private:
  // Prior standard deviations: a position is known to some deviations of its noise; a rate is as uncertain as its rms.
  // A link is uncertain by the twist under the load, and its rate by that twist times the natural frequency of the
  // motor.
  void list_slots(const Plant& plant) {
    for (size_t j = 0; j < plant.laws.size(); ++j) {
      const SmoothJoint& joint = smooth_.joints[j];
      const double rate = std::max(1e-3, calc_rms(joint.qd));
      slots_.push_back({&StartState::q, j, 10.0 / problem_.weights[j * kQuantities]});
      slots_.push_back({&StartState::v, j, rate});
      const JointLaws& law = plant.laws[j];
      if (law.has_friction()) slots_.push_back({&StartState::bristles, j, 1.0});
      if (law.hysteresis_stiffness > 0.0) slots_.push_back({&StartState::memory, j, 1.0});
      if (!law.elastic) continue;
      const double servo = law.kp * calc_rms(joint.q);
      const double load = smooth_.effort[j].empty() ? servo : calc_rms(smooth_.effort[j]);
      const double twist = std::max(load / law.stiffness, 10.0 / problem_.weights[j * kQuantities]);
      slots_.push_back({&StartState::link_q, j, twist});
      slots_.push_back({&StartState::link_v, j,
                        std::max(rate, twist * std::sqrt(law.stiffness / std::max(1e-9, law.motor_inertia)))});
    }
  }

  bool calc(const StartState& state, std::vector<double>* residuals) const {
    return calc_residuals(problem_, hypothesis_, recording_, options_, &state, residuals);
  }

  double calc_cost(const StartState& state, const std::vector<double>& residuals) const {
    double cost = 0.0;
    for (double r : residuals) cost += r * r;
    for (const Slot& slot : slots_) cost += std::pow((state.*slot.member)[slot.joint] / slot.spread, 2);
    return cost;
  }

  StartState take_step(const StartState& state, const std::vector<double>& residuals) const {
    const long p = static_cast<long>(slots_.size()), n = static_cast<long>(residuals.size());
    const Eigen::Map<const Eigen::VectorXd> r(residuals.data(), n);
    Eigen::MatrixXd J(n, p);
    for (long i = 0; i < p; ++i) {
      const Slot& slot = slots_[static_cast<size_t>(i)];
      StartState moved = state;
      const double step = 0.01 * slot.spread;
      (moved.*slot.member)[slot.joint] += step;
      std::vector<double> other;
      if (!calc(moved, &other)) return state;
      J.col(i) = (Eigen::Map<const Eigen::VectorXd>(other.data(), n) - r) / step;
    }
    Eigen::MatrixXd A = J.transpose() * J;
    Eigen::VectorXd b = J.transpose() * r;
    for (long i = 0; i < p; ++i) {
      const Slot& slot = slots_[static_cast<size_t>(i)];
      const double weight = 1.0 / (slot.spread * slot.spread);
      A(i, i) += weight;
      b[i] += weight * (state.*slot.member)[slot.joint];
    }
    const Eigen::VectorXd change = A.ldlt().solve(-b);
    StartState next = state;
    for (long i = 0; i < p; ++i) {
      const Slot& slot = slots_[static_cast<size_t>(i)];
      if (std::isfinite(change[i])) (next.*slot.member)[slot.joint] += change[i];
    }
    return next;
  }

  const Problem& problem_;
  const Hypothesis& hypothesis_;
  int recording_;
  const SmoothRecording& smooth_;
  RolloutOptions options_;
  std::vector<Slot> slots_;
};

}  // namespace

Starts estimate_starts(const Problem& problem, const Hypothesis& hypothesis, const std::vector<int>& recordings) {
  Starts starts(problem.experiment->recordings.size());
  parallel_for(problem.jobs, static_cast<int>(recordings.size()), [&](int i) {
    const int r = recordings[static_cast<size_t>(i)];
    starts[static_cast<size_t>(r)] = Estimator(problem, hypothesis, r).run();
  });
  return starts;
}

}  // namespace hrp::diagnosis
