// SPDX-License-Identifier: BSD-3-Clause
#include "controller/walking/pattern.h"

#include <algorithm>
#include <cmath>

#include "common/spatial/turn_z.h"

namespace hrp::walking {
namespace {

double mix_yaw(double a, double b, double s) { return a + s * std::remainder(b - a, 2.0 * M_PI); }

double get_yaw(const Matrix3d& R) { return std::atan2(R(1, 0), R(0, 0)); }

// Quintic from (x0, 0, 0) to (x1, v1, 0) over unit time.
double calc_quintic(double s, double x0, double x1, double v1) {
  const double d = x1 - x0;
  const double a3 = 10.0 * d - 4.0 * v1, a4 = -15.0 * d + 7.0 * v1, a5 = 6.0 * d - 3.0 * v1;
  return x0 + s * s * s * (a3 + s * (a4 + s * a5));
}

// Ground under a robot that stands: normals of its soles.
ConstraintPlane find_plane(const PatternStart& start) {
  const Vector3d n = start.soles[kLeft].R.col(2) + start.soles[kRight].R.col(2);
  return {-n.x() / n.z(), -n.y() / n.z()};
}

constexpr double kSwingStart = 0.04, kSwingEnd = 0.92;  // shares of a swing within which the foot moves sideways

}  // namespace

double calc_blend(double s) {
  s = std::min(std::max(s, 0.0), 1.0);
  return calc_quintic(s, 0.0, 1.0, 0.0);
}

double calc_swing_height(double s, double T, double height, double landing_speed) {
  if (s <= 0.0 || s >= 1.0) return 0.0;
  if (s < 0.5) return height * calc_blend(2.0 * s);
  return calc_quintic(2.0 * s - 1.0, height, 0.0, -landing_speed * 0.5 * T);
}

WalkPattern::WalkPattern(const WalkSpec& spec, const PatternStart& start, double zc, double g)
    : spec_(spec), start_(start), plane_(spec.measured_ground ? find_plane(start) : ConstraintPlane()) {
  pendulum_.zc = zc;
  pendulum_.g = g;
  for (int side : {kLeft, kRight}) {
    first_.feet[side].p = start.soles[side].p;
    first_.feet[side].yaw = get_yaw(start.soles[side].R);
    // Both stand on the ground, whatever bent joints say at the start: the origin is between them.
    first_.feet[side].p.z() = plane_.calc_height(first_.feet[side].xy());
  }
  planned_ = steps_ = make_footsteps(spec, first_, plane_);
  make_phases();
}

Matrix3d WalkPattern::calc_sole_attitude(double yaw) const {
  const Vector3d n = Vector3d(-plane_.kx, -plane_.ky, 1.0).normalized();
  const Matrix3d tilt = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), n).toRotationMatrix();
  return tilt * turn_z(yaw);
}

Vector2d WalkPattern::find_zmp(const Stance& stance, Side side) const {
  const Foothold& foot = stance.feet[side];
  const double inward = side == kLeft ? -spec_.zmp_y : spec_.zmp_y;
  return foot.xy() + Eigen::Rotation2Dd(foot.yaw) * Vector2d(spec_.zmp_x, inward);
}

Vector2d WalkPattern::find_middle(const Stance& stance) const {
  return 0.5 * (find_zmp(stance, kLeft) + find_zmp(stance, kRight));
}

void WalkPattern::add(const ZmpSegment& zmp, Support support, const Stance& stance, double floor1) {
  Phase phase;
  phase.begin = time_;
  phase.zmp = zmp;
  phase.state = last_;
  phase.support = support;
  phase.stance = stance;
  phase.step = phases_.empty() ? 0 : phases_.back().step;
  if (support != Support::kBoth) ++phase.step;
  phase.floor0 = floor_;
  phase.floor1 = floor1;
  phases_.push_back(phase);
  last_ = calc_state(pendulum_, last_, zmp, zmp.T);
  floor_ = floor1;
  time_ += zmp.T;
}

// Where the body should be when step n's foot (0 = first) is about to be carried no longer, if the next steps go as
// planned: the walk primitive of the step after it, over its planned foothold [K01].
PendulumState WalkPattern::find_target(size_t n) const {
  Stance stance = first_;
  for (size_t i = 0; i <= n; ++i) stance.feet[planned_[i].side] = planned_[i].hold;
  const Side carrying = planned_[n].side;
  const Vector2d foot = find_zmp(stance, carrying);
  const double yaw = planned_[n].hold.yaw;
  // After the last step the other foot stands beside: the step to it is where it stands.
  Vector2d next = find_zmp(stance, other(carrying));
  if (n + 1 < planned_.size()) {
    stance.feet[planned_[n + 1].side] = planned_[n + 1].hold;
    next = find_zmp(stance, planned_[n + 1].side);
  }
  const Eigen::Rotation2Dd R(yaw);
  PendulumState target =
      calc_walk_primitive(pendulum_, R.inverse() * (next - foot), spec_.single_support, spec_.double_support);
  target.x = foot + R * target.x;
  target.v = R * target.v;
  return target;
}

void WalkPattern::make_phases() {
  time_ = spec_.settle;
  const double middle = 0.5 * (first_.feet[kLeft].p.z() + first_.feet[kRight].p.z());
  last_.x = find_middle(first_);
  last_.v.setZero();
  floor_ = middle - plane_.calc_height(0.5 * (first_.feet[kLeft].xy() + first_.feet[kRight].xy()));
  if (!planned_.empty()) {
    const Side carrying = other(planned_[0].side);
    start_walk(carrying, first_);
    make_walk(0, carrying, first_);
  }
  finish();
}

void WalkPattern::finish() {
  const Stance stance = phases_.empty() ? first_ : phases_.back().stance;
  // What is left of the motion dies away over a still zero moment point.
  const Vector2d rest = find_middle(stance);
  add({0.0, rest, rest}, Support::kBoth, stance, floor_);
}

// The shift of weight ends where the first single support's orbit begins: sideways that of the repeated walk, forward
// from between the feet with the speed that reaches the walk primitive's position.
void WalkPattern::start_walk(Side carrying, const Stance& stance) {
  const Vector2d foot = find_zmp(stance, carrying);
  const Side moving = other(carrying);
  Stance after = stance;
  after.feet[moving] = planned_[0].hold;
  const Eigen::Rotation2Dd R(stance.feet[carrying].yaw);
  const PendulumState end = calc_walk_primitive(pendulum_, R.inverse() * (find_zmp(after, moving) - foot),
                                                spec_.single_support, spec_.double_support);
  const double Tc = pendulum_.calc_time_constant();
  const double C = std::cosh(spec_.single_support / Tc), S = std::sinh(spec_.single_support / Tc);
  const double x0 = (R.inverse() * (find_middle(stance) - foot)).x();
  PendulumState begin;
  begin.x = foot + R * Vector2d(x0, end.x.y());
  begin.v = R * Vector2d((end.x.x() - x0 * C) / (Tc * S), -end.v.y());
  const Vector2d goal = calc_divergent(pendulum_, begin);
  for (const ZmpSegment& s : calc_transfer(pendulum_, last_, find_middle(stance), goal, foot, spec_.transfer)) {
    add(s, Support::kBoth, stance, floor_);
  }
}

// The steps from `first` on: single support, then the shift of weight to the foot that has landed.
void WalkPattern::make_walk(size_t first, Side carrying, Stance stance) {
  const auto floor_of = [&](const Foothold& foot) { return foot.p.z() - plane_.calc_height(foot.xy()); };
  for (size_t n = first; n < planned_.size(); ++n) {
    const Vector2d foot = find_zmp(stance, carrying);
    const double floor = std::min(floor_of(stance.feet[carrying]), floor_of(planned_[n].hold));
    add({spec_.single_support, foot, foot}, carrying == kLeft ? Support::kLeft : Support::kRight, stance, floor);
    stance = land(n, carrying, stance);
    carrying = steps_[n].side;
  }
}

// Modified foot placement of step n, whose single support over `carrying` ends in last_.
void WalkPattern::place(size_t n, Side carrying, const Stance& stance) {
  const Side landing = steps_[n].side;
  Stance after = stance;
  after.feet[landing] = planned_[n].hold;
  const Vector2d wanted =
      calc_placement(pendulum_, last_, find_zmp(stance, carrying), find_target(n), spec_.single_support,
                     spec_.double_support, {spec_.placement_position, spec_.placement_velocity});
  const Vector2d shift = wanted - find_zmp(after, landing);
  steps_[n].hold = planned_[n].hold;
  steps_[n].hold.p.head<2>() += shift;
  steps_[n].hold.p.z() += plane_.calc_height(shift);
}

// Returns where the feet stand then.
Stance WalkPattern::land(size_t n, Side carrying, Stance stance) {
  const auto floor_of = [&](const Foothold& foot) { return foot.p.z() - plane_.calc_height(foot.xy()); };
  const Vector2d foot = find_zmp(stance, carrying);
  const Side landing = steps_[n].side;
  if (n + 1 < planned_.size()) {
    place(n, carrying, stance);
    stance.feet[landing] = steps_[n].hold;
    add({spec_.double_support, foot, find_zmp(stance, landing)}, Support::kBoth, stance, floor_);
    return stance;
  }
  if (n > 0) {  // beside the foot before it, wherever the rule has put that
    steps_[n].hold.p = planned_[n].hold.p + (steps_[n - 1].hold.p - planned_[n - 1].hold.p);
  }
  stance.feet[landing] = steps_[n].hold;
  const Vector2d rest = find_middle(stance);
  const double end_floor = 0.5 * (floor_of(stance.feet[kLeft]) + floor_of(stance.feet[kRight]));
  for (const ZmpSegment& s : calc_transfer(pendulum_, last_, foot, rest, rest, spec_.transfer)) {
    add(s, Support::kBoth, stance, end_floor);
  }
  return stance;
}

bool WalkPattern::move_step(double t, const Vector2d& shift) {
  if (t < phases_.front().begin) return false;
  const Phase& phase = find_phase(t);
  if (phase.support == Support::kBoth || static_cast<size_t>(phase.step) >= planned_.size()) return false;
  // Everything from this step on moves with it; what feet stand on stays.
  const size_t n = static_cast<size_t>(phase.step - 1);
  const Side landing = steps_[n].side;
  Foothold support = phase.stance.feet[other(landing)];
  support.p.head<2>() += find_shift(phase.step - 1);
  const Vector2d goal = steps_[n].hold.xy() + find_shift(phase.step - 1) + shift;
  const Vector2d reached = limit_to_reach(spec_, landing, support, goal) - steps_[n].hold.xy();
  shifts_.resize(n, Vector2d::Zero());
  shifts_.push_back(reached);
  return true;
}

// Of the foothold of the step with this number (1 = first); feet that have not stepped yet stand where they stood.
Vector2d WalkPattern::find_shift(int number) const {
  if (number <= 0 || shifts_.empty()) return Vector2d::Zero();
  return shifts_[std::min(static_cast<size_t>(number), shifts_.size()) - 1];
}

// The plan's phase, moved to where the feet have been put.
void WalkPattern::shift(const Phase& phase, double s, PatternSample* sample) const {
  if (shifts_.empty()) return;
  const auto move = [&](const Vector2d& by, Vector3d* p) { *p += Vector3d(by.x(), by.y(), plane_.calc_height(by)); };
  const bool both = phase.support == Support::kBoth;
  const Vector2d newest = find_shift(phase.step), before = find_shift(phase.step - 1);
  sample->shift = both ? newest : before;
  move(both ? Vector2d(before + s * (newest - before)) : before, &sample->zmp);
  move(sample->shift, &sample->com);
  if (phase.step == 0) return;
  const Side last = steps_[static_cast<size_t>(phase.step - 1)].side;
  move(before, &sample->soles[other(last)].p);
  const Vector2d lifted = find_shift(phase.step - 2);
  const double u = calc_blend((s - kSwingStart) / (kSwingEnd - kSwingStart));
  move(both ? newest : Vector2d(lifted + u * (newest - lifted)), &sample->soles[last].p);
}

double WalkPattern::find_remaining(double t) const {
  const Phase& phase = find_phase(t);
  return std::max(0.0, phase.begin + phase.zmp.T - t);
}

// Five time constants: 0.7 % of the last sway is left.
double WalkPattern::duration() const { return phases_.back().begin + 5.0 * pendulum_.calc_time_constant(); }

const WalkPattern::Phase& WalkPattern::find_phase(double t) const {
  const auto after = std::upper_bound(phases_.begin(), phases_.end(), t,
                                      [](double time, const Phase& phase) { return time < phase.begin; });
  return after == phases_.begin() ? phases_.front() : *(after - 1);
}

// After the last transfer: only what decays, exp(-t / Tc).
PendulumState WalkPattern::calc_rest(const Phase& phase, double t) const {
  const double Tc = pendulum_.calc_time_constant();
  const Vector2d away = (phase.state.x - phase.zmp.p1) * std::exp(-t / Tc);
  return {phase.zmp.p1 + away, -away / Tc};
}

// From the initial pose to upright, the centre of mass over the middle of the feet.
PatternSample WalkPattern::sample_settling(double t) const {
  PatternSample sample;
  const Phase& first = phases_.front();
  const Vector2d middle = find_middle(first_);
  const Vector3d goal(middle.x(), middle.y(), plane_.calc_height(middle) + first.floor0 + pendulum_.zc);
  const double T = spec_.settle, s = t / T;
  const auto at = [&](double u) { return Vector3d(start_.com + calc_blend(u) * (goal - start_.com)); };
  sample.com = at(s);
  constexpr double kEps = 1e-3;
  if (s > 0.0 && s < 1.0) {
    sample.com_velocity = (at(s + kEps) - at(s - kEps)) / (2.0 * kEps * T);
    sample.com_acceleration = ((at(s + kEps) - 2.0 * at(s) + at(s - kEps)) / (kEps * kEps * T * T)).head<2>();
  }
  const Vector2d zmp = sample.com.head<2>() - pendulum_.zc / pendulum_.g * sample.com_acceleration;
  sample.zmp = {zmp.x(), zmp.y(), goal.z() - pendulum_.zc};
  const double yaw = mix_yaw(first_.feet[kRight].yaw, first_.feet[kLeft].yaw, 0.5);
  const Matrix3d upright = turn_z(yaw) * Eigen::AngleAxisd(spec_.base_pitch, Vector3d::UnitY()).toRotationMatrix();
  sample.R_WB = Eigen::Quaterniond(start_.R_WB).slerp(calc_blend(s), Eigen::Quaterniond(upright)).toRotationMatrix();
  for (int side : {kLeft, kRight}) {
    sample.soles[side] = {calc_sole_attitude(first_.feet[side].yaw), first_.feet[side].p};
  }
  return sample;
}

Foothold WalkPattern::find_swing(const Phase& phase, double s) const {
  const Footstep& step = steps_[static_cast<size_t>(phase.step - 1)];
  const Foothold& from = phase.stance.feet[step.side];
  const double u = calc_blend((s - kSwingStart) / (kSwingEnd - kSwingStart));
  Foothold foot;
  foot.p = from.p + u * (step.hold.p - from.p);
  foot.yaw = mix_yaw(from.yaw, step.hold.yaw, u);
  const double rise = std::max(0.0, step.hold.p.z() - from.p.z() - plane_.calc_height(step.hold.xy() - from.xy()));
  foot.p.z() += calc_swing_height(s, phase.zmp.T, spec_.swing_height + rise, spec_.landing_speed);
  return foot;
}

void WalkPattern::put_feet(const Phase& phase, double t, PatternSample* sample) const {
  Foothold feet[2] = {phase.stance.feet[kLeft], phase.stance.feet[kRight]};
  double yaw0 = mix_yaw(feet[kRight].yaw, feet[kLeft].yaw, 0.5), yaw = yaw0;
  if (phase.support != Support::kBoth) {
    const Side moving = phase.support == Support::kLeft ? kRight : kLeft;
    const double s = (t - phase.begin) / phase.zmp.T;
    feet[moving] = find_swing(phase, s);
    yaw = mix_yaw(feet[kRight].yaw, feet[kLeft].yaw, 0.5);
  }
  for (int side : {kLeft, kRight}) sample->soles[side] = {calc_sole_attitude(feet[side].yaw), feet[side].p};
  sample->R_WB = turn_z(yaw) * Eigen::AngleAxisd(spec_.base_pitch, Vector3d::UnitY()).toRotationMatrix();
}

PatternSample WalkPattern::sample(double t) const {
  if (t < spec_.settle) return sample_settling(t);
  const Phase& phase = find_phase(t);
  const double inside = std::min(t - phase.begin, phase.zmp.T);
  const PendulumState state =
      phase.zmp.T > 0.0 ? calc_state(pendulum_, phase.state, phase.zmp, inside) : calc_rest(phase, t - phase.begin);
  const Vector2d zmp = phase.zmp.at(inside);
  PatternSample sample;
  sample.support = phase.support;
  sample.step = phase.step;
  const double s = phase.zmp.T > 0.0 ? inside / phase.zmp.T : 1.0;
  const double floor = phase.floor0 + calc_blend(s) * (phase.floor1 - phase.floor0);
  const auto lift = [&](const Vector2d& xy, double height) {
    return Vector3d(xy.x(), xy.y(), plane_.calc_height(xy) + floor + height);
  };
  sample.com = lift(state.x, pendulum_.zc);
  sample.com_velocity = {state.v.x(), state.v.y(), plane_.calc_height(state.v)};
  sample.com_acceleration = pendulum_.g / pendulum_.zc * (state.x - zmp);
  sample.zmp = lift(zmp, 0.0);
  put_feet(phase, t, &sample);
  shift(phase, s, &sample);
  return sample;
}

}  // namespace hrp::walking
