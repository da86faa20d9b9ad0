// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/sensor_frames.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "common/multibody/kinematics.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/checks/imu_over_legs.h"
#include "diagnosis/floating/conventions/signed_axes.h"
#include "diagnosis/floating/fit/shift_columns.h"
#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {
namespace {

// An IMU's readings as others expect them, in its axes by the model.
struct Expected {
  const Clip* clip = nullptr;
  size_t k = 0;
  Vector3d force, rate;
};

// At each moment; empty where nothing else tells the motion for long enough.
std::vector<Expected> list_expected(const LeggedLog& log, size_t imu, Purpose purpose) {
  LeggedLog others = log;
  others.imus.clear();
  std::vector<Expected> expected;
  if (!log.imus[imu].gyro || BodyMotion::find_force_source(others) == MotionSource::kNone) return expected;
  const ImuSensor& sensor = log.imus[imu];
  for (const Clip& own : log.clips) {
    others.clips = {own};
    walk(others, purpose, [&](const Clip&, size_t k, BodyMotion* motion) {
      const Transform X = get_pose(motion->data(), sensor.link);
      const Matrix3d R_IB = (X.R * sensor.R_LI).transpose();
      expected.push_back({&own, k,
                          R_IB * calc_point_acceleration(motion->data(), sensor.link, X * sensor.p_LI).tail<3>(),
                          R_IB * get_velocity(motion->data(), sensor.link).head<3>()});
    });
  }
  if (!is_enough(purpose, expected.size())) expected.clear();
  return expected;
}

// [1] What is left at one moment, over what soles let expect.
double calc_square(const LeggedLog& log, size_t imu, const Expected& e, const Taken& taken) {
  const size_t k = shift(e.k, taken.clock, *e.clip, log);
  double out =
      (taken.axes.gyro * get_values(e.clip->imus[imu].gyro, k) - e.rate).squaredNorm() / (kRateOfSoles * kRateOfSoles);
  if (!log.imus[imu].accelerometer) return out;
  const Vector3d force = taken.axes.accelerometer * get_values(e.clip->imus[imu].accelerometer, k) / taken.per_unit;
  return out + (force - e.force).squaredNorm() / (kForceOfSoles * kForceOfSoles);
}

// `per_unit`: what the accelerometer reads of a specific force of 1 m/s^2.
Left measure_imu(const LeggedLog& log, size_t imu, double per_unit, const std::vector<Expected>& expected) {
  return [&log, &expected, imu, per_unit](const Matrix3d& R, const Clock& clock) {
    double sum = 0.0;
    for (const Expected& e : expected) sum += calc_square(log, imu, e, {{R, R}, clock, per_unit});
    // What is expected is no better known than that: so much is left of a sensor that is mounted as it should be.
    return sum / static_cast<double>(expected.size()) + 1.0;
  };
}

// 1: legs that stand say that `a` is right, -1: `b`, 0: they cannot tell.
int compare_over_legs(const LeggedLog& log, size_t imu, const std::vector<Standing>& standing, const Taken& a,
                      const Taken& b) {
  const double nats =
      calc_odds(list_instants(standing), list_left(log, imu, standing, a), list_left(log, imu, standing, b));
  return nats > kOdds ? 1 : nats < -kOdds ? -1 : 0;
}

SensorFrame make_frame(const std::string& sensor, const BestFrame& best) {
  SensorFrame out;
  out.sensor = sensor;
  out.R = best.R;
  out.late = best.late;
  out.left = best.left;
  return out;
}

// The moments of a clock that is so late.
Purpose find_purpose(double late) {
  if (late == 0.0) return Purpose::kForTurns;
  return std::abs(late) < kNearClock ? Purpose::kForClocks
         : late > 0.0                ? Purpose::kForFarBehind
                                     : Purpose::kForFarAhead;
}

Clock make_clock(double late) { return {late, 0.0, std::min(late, -kNearClock), std::max(late, kNearClock)}; }

Taken take(const BestFrame& whole) { return {{whole.R, whole.R}, make_clock(whole.late), 1.0}; }

// What moments for turns and those for clocks say; nominal where there are too few.
template <class List, class Measure>
BestFrame find_frame(const List& list, const Measure& measure) {
  BestFrame best;
  const auto of_turns = list(Purpose::kForTurns);
  if (!of_turns.empty()) best = find_best_turn(measure(of_turns));
  const auto of_clocks = list(Purpose::kForClocks);
  if (of_clocks.empty()) return best;
  best = find_best_clock(measure(of_clocks), best);
  return may_be_far(measure(of_clocks), best) ? find_far_clock(list, measure, best) : best;
}

// What encoders of legs that stand say of an IMU.
class OverLegs {
 public:
  OverLegs(const LeggedLog& log, size_t imu) : log_(log), imu_(imu) {}

  BestFrame find_best() const {
    return find_frame([this](Purpose purpose) { return list_standing(log_, imu_, purpose); },
                      [this](const std::vector<Standing>& s) { return measure_over_legs(log_, imu_, 1.0, s); });
  }

  // 1: for what an IMU is taken as, -1: against it, 0: legs cannot tell.
  int judge(const Taken& taken) const {
    const std::vector<Standing> moments = list_standing(log_, imu_, find_purpose(taken.clock.late));
    return moments.empty() ? 0 : compare_over_legs(log_, imu_, moments, taken, {});
  }

  SignedAxes find_axes(const BestFrame& whole) const {
    const std::vector<Standing> moments = list_standing(log_, imu_, find_purpose(whole.late));
    const auto list = [&](const Taken& taken) { return list_left(log_, imu_, moments, taken); };
    return find_signed_axes(
        list_instants(moments),
        [&](const ImuAxes& axes) {
          return list({axes, {}, 1.0});
        },
        list(take(whole)), log_.imus[imu_].accelerometer);
  }

 private:
  const LeggedLog& log_;
  size_t imu_;
};

// The same of what the base's pose expects.
SignedAxes find_axes(const LeggedLog& log, size_t imu, const BestFrame& whole) {
  const std::vector<Expected> moments = list_expected(log, imu, find_purpose(whole.late));
  std::vector<Instant> at;
  for (const Expected& e : moments) at.push_back({e.clip, e.k});
  const auto list = [&](const Taken& taken) {
    std::vector<double> left;
    for (const Expected& e : moments) left.push_back(std::sqrt(calc_square(log, imu, e, taken)));
    return left;
  };
  return find_signed_axes(
      at,
      [&](const ImuAxes& axes) {
        return list({axes, {}, 1.0});
      },
      list(take(whole)), log.imus[imu].accelerometer);
}

// Of an IMU whose halves are off by themselves.
std::vector<SensorFrame> list_halves(const std::string& name, const SignedAxes& found) {
  std::vector<SensorFrame> out;
  const auto& [gyro, accelerometer] = found.axes;
  if (!gyro.isIdentity()) out.push_back(make_frame(name + "/angular_velocity", {gyro, 0.0, found.left}));
  if (!accelerometer.isIdentity())
    out.push_back(make_frame(name + "/linear_acceleration", {accelerometer, 0.0, found.left}));
  return out;
}

// Encoders are the clock, and legs that stand the axes. Where they cannot tell, the IMU is off or what it is compared
// with.
std::vector<SensorFrame> find_imu(const LeggedLog& log, size_t imu) {
  const std::string name = "/imu/" + log.imus[imu].name;
  if (!log.imus[imu].gyro) return {};
  const OverLegs legs(log, imu);
  const BestFrame by_legs = legs.find_best();
  std::vector<SensorFrame> halves = list_halves(name, legs.find_axes(by_legs));
  if (!halves.empty()) return halves;
  if (!by_legs.is_nominal()) return {make_frame(name, by_legs)};
  const BestFrame best = find_frame([&](Purpose purpose) { return list_expected(log, imu, purpose); },
                                    [&](const std::vector<Expected>& e) { return measure_imu(log, imu, 1.0, e); });
  // A pose in another convention may look like a half of the IMU that is off: legs must confirm it.
  const SignedAxes by_pose = find_axes(log, imu, best);
  std::vector<SensorFrame> of_pose = list_halves(name, by_pose);
  const int halves_told = of_pose.empty() ? -1 : legs.judge({by_pose.axes, {}, 1.0});
  if (halves_told > 0 || (halves_told == 0 && !log.base_pose)) return of_pose;
  if (best.is_nominal()) return {};
  const int told = legs.judge(take(best));
  if (told < 0 && log.base_pose) return {};
  SensorFrame out = make_frame(name, best);
  if (told == 0 && log.base_pose) out.rival = "/base/pose";
  return {out};
}

// What the motion asks of the ground, and what each sensor's wrench adds: [moment / arm; force] about the base, base
// axes.
struct Balance {
  const Clip* clip = nullptr;
  size_t k = 0;
  Vector6d needed;
  std::vector<Matrix3d> R;
  std::vector<Vector3d> p;
};

std::vector<Balance> list_balances(const LeggedLog& log, Purpose purpose) {
  std::vector<Balance> out;
  Eigen::VectorXd tau;
  walk(log, purpose, [&](const Clip& clip, size_t k, BodyMotion* motion) {
    tau.resize(motion->model().nv());
    calc_inverse_dynamics(motion->model(), motion->vdot(), nullptr, &motion->data(), &tau);
    Balance b;
    b.clip = &clip;
    b.k = k;
    b.needed << tau.head<3>() / kHalfFoot, tau.segment<3>(3);
    for (const ForceSensor& s : log.sensors) {
      const Transform X = get_pose(motion->data(), s.link);
      b.R.push_back(X.R * s.X_LS.R);
      b.p.push_back(X * s.X_LS.p);
    }
    out.push_back(std::move(b));
  });
  return out;
}

// Squares that `count` values leave beside a zero of the sensors, given their sums and sums of squares. A turn is not
// preferred because it moves a zero to where it cancels others. `largest` [N]: a weight on another axis is more than
// any zero.
double sum_beside_zero(const Vector6d& sum, const Vector6d& squares, double count, double largest) {
  double left = 0.0;
  for (int i = 0; i < 6; ++i) {
    const double zero = std::clamp(sum[i] / count, -largest, largest);
    left += squares[i] - 2.0 * zero * sum[i] + count * zero * zero;
  }
  return left;
}

// All sensors together, as one computer reads them; then in turn, each beside the others as they stand by then.
std::vector<SensorFrame> find_wrenches(const LeggedLog& log) {
  std::vector<BestFrame> frames(log.sensors.size());
  const bool whole = !log.sensors.empty() &&
                     std::all_of(log.sensors.begin(), log.sensors.end(),
                                 [](const ForceSensor& s) { return s.has_wrench() && !s.world && s.foot >= 0; });
  const bool known = BodyMotion::find_force_source(log) != MotionSource::kNone && log.sensors.size() >= log.feet.size();
  if (!whole || !known) return {};
  const std::vector<Balance> balances = list_balances(log, Purpose::kForClocks);
  if (!is_enough(Purpose::kForClocks, balances.size())) return {};
  const auto add = [&](const Balance& b, size_t s, const Matrix3d& R, const Clock& clock, Vector6d* left) {
    const size_t k = shift(b.k, clock, *b.clip, log);
    const Vector3d f = b.R[s] * R * get_values(&b.clip->force[6 * s], k),
                   m = b.R[s] * R * get_values(&b.clip->force[6 * s + 3], k);
    left->head<3>() -= (m + b.p[s].cross(f)) / kHalfFoot, left->tail<3>() -= f;
  };
  const double largest_zero = kMinority * log.mass * log.experiment->scenario.gravity_W.norm();
  const auto sum_up = [&](const std::vector<Balance>& of, const std::function<bool(size_t)>& is_tried,
                          const Matrix3d& R, const Clock& clock) {
    Vector6d sum = Vector6d::Zero(), squares = Vector6d::Zero();
    for (const Balance& b : of) {
      Vector6d left = b.needed;
      for (size_t s = 0; s < frames.size(); ++s)
        add(b, s, is_tried(s) ? R : frames[s].R, is_tried(s) ? clock : Clock{frames[s].late, 0.0}, &left);
      sum += left;
      squares += left.cwiseAbs2();
    }
    return sum_beside_zero(sum, squares, static_cast<double>(of.size()), largest_zero);
  };
  const auto measure_all = [&](const std::vector<Balance>& of) -> Left {
    return [&sum_up, &of](const Matrix3d& R, const Clock& clock) {
      return sum_up(
          of, [](size_t) { return true; }, R, clock);
    };
  };
  const BestFrame near = find_best(measure_all(balances));
  const BestFrame all = near.late != 0.0
                            ? near
                            : find_far_clock([&](Purpose side) { return list_balances(log, side); }, measure_all, near);
  for (BestFrame& f : frames) f = all;
  for (int round = 0; round < 2 && all.late == near.late; ++round) {
    for (size_t s = 0; s < frames.size(); ++s) {
      const Left left = [&](const Matrix3d& R, const Clock& clock) {
        return sum_up(
            balances, [s](size_t o) { return o == s; }, R, clock);
      };
      frames[s] = find_best(left, frames[s]);
    }
  }
  std::vector<SensorFrame> out;
  for (size_t s = 0; s < frames.size(); ++s) out.push_back(make_frame("/wrench/" + log.sensors[s].name, frames[s]));
  return out;
}

std::vector<SensorFrame> keep(std::vector<SensorFrame> frames) {
  frames.erase(std::remove_if(frames.begin(), frames.end(),
                              [](const SensorFrame& f) { return !f.is_turned() && f.late == 0.0; }),
               frames.end());
  return frames;
}

void turn(const std::string& base, const Matrix3d& R, Recording* r) {
  std::vector<double>* xyz[3];
  for (int i = 0; i < 3; ++i) {
    const auto at = r->other.find(base + "/" + "xyz"[i]);
    if (at == r->other.end()) return;
    xyz[i] = &at->second;
  }
  for (size_t k = 0; k < xyz[0]->size(); ++k) {
    const Vector3d v = R * Vector3d((*xyz[0])[k], (*xyz[1])[k], (*xyz[2])[k]);
    for (int i = 0; i < 3; ++i) (*xyz[i])[k] = v(i);
  }
}

void turn_attitude(const std::string& base, const Matrix3d& R, Recording* r) {
  std::vector<double>* wxyz[4];
  for (int i = 0; i < 4; ++i) {
    const auto at = r->other.find(base + "/" + "wxyz"[i]);
    if (at == r->other.end()) return;
    wxyz[i] = &at->second;
  }
  for (size_t k = 0; k < wxyz[0]->size(); ++k) {
    const Eigen::Quaterniond q = Eigen::Quaterniond((*wxyz[0])[k], (*wxyz[1])[k], (*wxyz[2])[k], (*wxyz[3])[k]) *
                                 Eigen::Quaterniond(R).conjugate();
    (*wxyz[0])[k] = q.w();
    (*wxyz[1])[k] = q.x();
    (*wxyz[2])[k] = q.y();
    (*wxyz[3])[k] = q.z();
  }
}

}  // namespace

namespace {

// The turn that leaves the least, and how much.
std::pair<Matrix3d, double> find_least(const Left& left) {
  std::pair<Matrix3d, double> best{Matrix3d::Identity(), 1e300};
  for (const Matrix3d& R : list_quarter_turns()) {
    const double here = left(R, {});
    if (here < best.second) best = {R, here};
  }
  return best;
}

}  // namespace

Upside find_upside(const LeggedLog& log, size_t imu, double per_unit) {
  const std::vector<Standing> standing = list_standing(log, imu, Purpose::kForTurns);
  if (!standing.empty()) {
    const Matrix3d turned = find_least(measure_over_legs(log, imu, per_unit, standing)).first;
    const Matrix3d counted = find_least(measure_over_legs(log, imu, -per_unit, standing)).first;
    const int told =
        compare_over_legs(log, imu, standing, {{turned, turned}, {}, per_unit}, {{counted, counted}, {}, -per_unit});
    if (told != 0) return told > 0 ? Upside::kTurned : Upside::kCounts;
  }
  const std::vector<Expected> expected = list_expected(log, imu, Purpose::kForTurns);
  if (expected.empty()) return Upside::kUnknown;
  const double turned = find_least(measure_imu(log, imu, per_unit, expected)).second;
  const double counted = find_least(measure_imu(log, imu, -per_unit, expected)).second;
  return turned < kHalf * counted ? Upside::kTurned : counted < kHalf * turned ? Upside::kCounts : Upside::kUnknown;
}

std::vector<SensorFrame> find_sensor_frames(const Experiment& e) {
  if (!e.scenario.floating_base || e.num_joints() == 0 || e.scenario.feet.empty()) return {};
  const LeggedLog log = make_legged_log(e, Half::kEven);
  std::vector<SensorFrame> out;
  for (size_t i = 0; i < log.imus.size(); ++i) {
    for (SensorFrame& f : find_imu(log, i)) out.push_back(std::move(f));
  }
  const Experiment mounted = convert_sensor_frames(e, out);
  for (SensorFrame& f : keep(find_wrenches(make_legged_log(mounted, Half::kEven)))) out.push_back(std::move(f));
  return out;
}

std::vector<std::string> list_not_looked_for(const Experiment& e) {
  if (!e.scenario.floating_base || e.num_joints() == 0) return {};
  const LeggedLog log = make_legged_log(e, Half::kEven);
  if (log.imus.empty() && log.sensors.empty()) return {};
  const std::string pose = log.base_pose ? " and of the base's pose" : "";
  std::vector<std::string> out;
  const auto add = [&](Purpose purpose, const std::string& what) {
    const size_t count = count_moments(log, purpose);
    if (!is_enough(purpose, count))
      out.push_back(what + " of the body's sensors" + pose + " are not looked for: " + describe_need(purpose, count));
  };
  add(Purpose::kForTurns, "turned mountings");
  add(Purpose::kForClocks, "clocks that are far off");
  return out;
}

Experiment convert_sensor_frames(Experiment e, const std::vector<SensorFrame>& frames) {
  for (const SensorFrame& f : frames) {
    for (Recording& r : e.recordings) {
      for (const char* part : {"", "/force", "/torque", "/linear_acceleration", "/angular_velocity"})
        turn(f.sensor + part, f.R, &r);
      turn_attitude(f.sensor + "/orientation", f.R, &r);
      if (f.late != 0.0) shift_columns(f.sensor, f.late, &r);
    }
  }
  return e;
}

}  // namespace hrp::diagnosis::floating
