// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/reference.h"

#include <cmath>

namespace hrp {
namespace {

const char* find_vector_fault(const Eigen::VectorXd& v, int joints, bool may_be_empty, int* joint) {
  if (may_be_empty && v.size() == 0) return nullptr;
  if (v.size() != joints) return "wrong number of joints";
  for (int i = 0; i < joints; ++i) {
    *joint = i;
    if (!std::isfinite(v[i])) return "a value is not finite";
  }
  return nullptr;
}

ReferenceSample mix(const ReferenceSample& a, const ReferenceSample& b, double s) {
  return {a.q + s * (b.q - a.q), a.qd + s * (b.qd - a.qd), a.effort + s * (b.effort - a.effort)};
}

}  // namespace

Interpolation parse_interpolation(const std::string& name) {
  if (name == "hold") return Interpolation::kHold;
  return name == "hermite" ? Interpolation::kHermite : Interpolation::kLinear;
}

ReferenceSample interpolate(Interpolation kind, const ReferenceSample& a, const ReferenceSample& b, double T,
                            double s) {
  if (kind == Interpolation::kHold || s == 1.0) return b;
  ReferenceSample sample = mix(a, b, s);
  if (kind == Interpolation::kLinear) return sample;
  const double s2 = s * s, s3 = s2 * s;
  sample.q =
      (2 * s3 - 3 * s2 + 1) * a.q + (s3 - 2 * s2 + s) * T * a.qd + (3 * s2 - 2 * s3) * b.q + (s3 - s2) * T * b.qd;
  sample.qd = (6 * s2 - 6 * s) / T * (a.q - b.q) + (3 * s2 - 4 * s + 1) * a.qd + (3 * s2 - 2 * s) * b.qd;
  return sample;
}

Reference::Reference(Interpolation kind, int control_period, double dt, const std::vector<double>& delays)
    : kind_(kind), period_(control_period), dt_(dt), from_(delays.size()), to_(delays.size()) {
  for (double delay : delays) {
    Delayed delayed;
    delayed.first = ring_.size();
    if (delay > 0.0) {
      delayed.steps = delay / dt;
      delayed.slots = static_cast<int>(std::ceil(delayed.steps)) + 2;
    }
    ring_.resize(ring_.size() + static_cast<size_t>(delayed.slots));
    delayed_.push_back(delayed);
  }
}

void Reference::reset(const Eigen::VectorXd& q) {
  step_ = 0;
  for (size_t i = 0; i < to_.size(); ++i) {
    to_[i] = from_[i] = ReferenceSample{q[static_cast<Eigen::Index>(i)], 0.0, 0.0};
    for (int k = 0; k < delayed_[i].slots; ++k) ring_[delayed_[i].first + static_cast<size_t>(k)] = to_[i];
  }
}

const char* Reference::find_fault(const JointCommand& command, int joints, int* joint) {
  *joint = -1;
  if (const char* fault = find_vector_fault(command.q, joints, false, joint)) return fault;
  if (const char* fault = find_vector_fault(command.qd, joints, true, joint)) return fault;
  return find_vector_fault(command.effort, joints, true, joint);
}

void Reference::start_step(long step, const JointCommand& command) {
  step_ = step;
  if (step % period_ != 0) return;
  for (size_t i = 0; i < to_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    from_[i] = to_[i];
    to_[i] = {command.q[k], command.qd.size() ? command.qd[k] : 0.0, command.effort.size() ? command.effort[k] : 0.0};
  }
}

ReferenceSample Reference::get_now(int joint, double fraction) const {
  const auto i = static_cast<size_t>(joint);
  const double s = (static_cast<double>(step_ % period_) + fraction) / period_;
  return interpolate(kind_, from_[i], to_[i], period_ * dt_, s);
}

// The ring holds the references at the starts of this and earlier steps: slot (step mod slots).
ReferenceSample Reference::get(int joint, double fraction) const {
  const Delayed& delayed = delayed_[static_cast<size_t>(joint)];
  if (delayed.slots == 0) return get_now(joint, fraction);
  const double age = delayed.steps - fraction;  // in steps, from the start of this step back
  if (age <= 0.0) return get_now(joint, -age);
  const long whole = static_cast<long>(std::floor(age));
  const auto at = [&](long back) {
    if (back == 0) return get_now(joint, 0.0);
    const long slot = ((step_ - back) % delayed.slots + delayed.slots) % delayed.slots;
    return ring_[delayed.first + static_cast<size_t>(slot)];
  };
  return mix(at(whole), at(whole + 1), age - static_cast<double>(whole));
}

void Reference::finish_step() {
  for (size_t i = 0; i < delayed_.size(); ++i) {
    if (delayed_[i].slots == 0) continue;
    const long slot = step_ % delayed_[i].slots;
    ring_[delayed_[i].first + static_cast<size_t>(slot)] = get_now(static_cast<int>(i), 0.0);
  }
}

}  // namespace hrp
