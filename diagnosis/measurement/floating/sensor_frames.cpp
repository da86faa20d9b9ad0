// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/sensor_frames.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/multibody/kinematics.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/floating/body_motion.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kStep = 0.02;       // [s] between moments that are compared
constexpr double kClock = 0.5;       // [s] by which a clock is looked for on either side
constexpr double kClockStep = 0.01;  // [s]
constexpr double kFar = 0.05;        // [s] of a clock that is moved: less is a sensor's delay, as in bags (docs/rosbag.md)
constexpr double kFastest = 0.05, kRateStep = 0.001;  // of clocks that run at another rate
constexpr double kTilt = 0.3;        // [m/s^2] to which feet that lie flat tell an accelerometer's direction: 0.03 g
constexpr double kRate = 0.02;       // [rad/s] likewise of a gyroscope
constexpr double kArm = 0.1;         // [m] by which moments are compared with forces: half of a foot
constexpr size_t kLeast = 100;       // moments

// The 24 turns that take axes onto axes.
std::vector<Matrix3d> list_quarter_turns() {
  std::vector<Matrix3d> out{Matrix3d::Identity()};
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      if (x % 3 == y % 3) continue;
      const Vector3d ex = (x < 3 ? 1.0 : -1.0) * Vector3d::Unit(x % 3), ey = (y < 3 ? 1.0 : -1.0) * Vector3d::Unit(y % 3);
      Matrix3d R;
      R << ex, ey, ex.cross(ey);
      if (!R.isIdentity()) out.push_back(R);
    }
  }
  return out;
}

// Calls `use` with the moments of a log that its motion is known at.
void walk(const LeggedLog& log, const std::function<void(const Clip&, size_t, BodyMotion*)>& use) {
  for (const Clip& clip : log.clips) {
    BodyMotion motion(log, clip);
    const auto stride = static_cast<size_t>(std::max(1L, std::lround(kStep / clip.step)));
    const auto margin = clip.edge + static_cast<size_t>(std::lround(kClock / clip.step));
    for (size_t k = margin; k + margin < clip.size(); k += stride) {
      motion.update(k);
      use(clip, k, &motion);
    }
  }
}

// A clock behind that of the encoders, and more so by `rate` of the time since the recording's begin.
struct Clock {
  double late = 0.0;  // [s]
  double rate = 0.0;
};

// What turns and a clock leave: an error in squares.
using Left = std::function<double(const Matrix3d& R, const Clock& clock)>;

// A clock that drifts leaves less than the best of all shifts, `moved`: none puts its readings where they belong.
bool drifts(const Left& left, const Matrix3d& R, double moved) {
  for (double rate = -kFastest; rate <= kFastest; rate += kRateStep) {
    if (left(R, {0.0, rate}) < moved) return true;
  }
  return false;
}

// `start`: what is known by now.
SensorFrame find_best(const std::string& sensor, const Left& left, const SensorFrame& start = {}) {
  SensorFrame best = start;
  best.sensor = sensor;
  const double nominal = left(Matrix3d::Identity(), {});
  double least = left(best.R, {best.late, 0.0});
  for (const Matrix3d& R : list_quarter_turns()) {
    const double here = left(R, {best.late, 0.0});
    if (here < least && here < kPart * nominal) least = here, best.R = R;
  }
  const double turned = least;
  double late = best.late;
  for (double t = -kClock; t <= kClock; t += kClockStep) {
    const double here = left(best.R, {t, 0.0});
    if (here < least) least = here, late = t;
  }
  const bool inside = std::abs(late) > kFar && std::abs(late) < kClock - kFar;
  const bool worth = inside && least < kPart * turned && !drifts(left, best.R, least);
  if (worth) best.late = late;
  best.left = nominal > 0.0 ? (worth ? least : turned) / nominal : 1.0;
  return best;
}

// The sample at which a clock read what the encoders' clock has at k.
size_t shift(size_t k, const Clock& clock, const Clip& clip, const LeggedLog& log) {
  const double since = clip.time[k] - log.experiment->recordings[clip.recording].time.front();
  const double time = std::clamp(clock.late + clock.rate * since, -kClock, kClock);
  return static_cast<size_t>(static_cast<long>(k) + std::lround(time / clip.step));
}

// An IMU's readings as others expect them, in its axes by the model.
struct Expected {
  const Clip* clip = nullptr;
  size_t k = 0;
  Vector3d force, rate;
};

// At each moment; empty where nothing else tells the motion.
std::vector<Expected> list_expected(const LeggedLog& log, size_t imu) {
  LeggedLog others = log;
  others.imus.clear();
  std::vector<Expected> expected;
  if (!log.imus[imu].gyro || BodyMotion::find_force_source(others) == MotionSource::kNone) return expected;
  const ImuSensor& sensor = log.imus[imu];
  size_t clip_index = 0;
  for (const Clip& own : log.clips) {
    others.clips = {log.clips[clip_index++]};
    walk(others, [&](const Clip&, size_t k, BodyMotion* motion) {
      const Transform X = get_pose(motion->data(), sensor.link);
      const Matrix3d R_IB = (X.R * sensor.R_LI).transpose();
      expected.push_back({&own, k, R_IB * calc_point_acceleration(motion->data(), sensor.link, X * sensor.p_LI).tail<3>(),
                          R_IB * get_velocity(motion->data(), sensor.link).head<3>()});
    });
  }
  if (expected.size() < kLeast) expected.clear();
  return expected;
}

// `per_unit`: what the accelerometer reads of a specific force of 1 m/s^2.
Left measure_imu(const LeggedLog& log, size_t imu, double per_unit, const std::vector<Expected>& expected) {
  return [&log, &expected, imu, per_unit](const Matrix3d& R, const Clock& clock) {
    const ImuSensor& sensor = log.imus[imu];
    double sum = 0.0;
    for (const Expected& e : expected) {
      const size_t k = shift(e.k, clock, *e.clip, log);
      if (sensor.accelerometer) sum += (R * get_values(e.clip->imus[imu].accelerometer, k) / per_unit - e.force).squaredNorm() / (kTilt * kTilt);
      sum += (R * get_values(e.clip->imus[imu].gyro, k) - e.rate).squaredNorm() / (kRate * kRate);
    }
    // What is expected is no better known than that: so much is left of a sensor that is mounted as it should be.
    return sum / static_cast<double>(expected.size()) + 1.0;
  };
}

SensorFrame find_imu(const LeggedLog& log, size_t imu) {
  const std::vector<Expected> expected = list_expected(log, imu);
  if (expected.empty()) return {};
  return find_best("/imu/" + log.imus[imu].name, measure_imu(log, imu, 1.0, expected));
}

// What the motion asks of the ground, and what each sensor's wrench adds: [moment / arm; force] about the base, base axes.
struct Balance {
  const Clip* clip = nullptr;
  size_t k = 0;
  Vector6d needed;
  std::vector<Matrix3d> R;
  std::vector<Vector3d> p;
};

std::vector<Balance> list_balances(const LeggedLog& log) {
  std::vector<Balance> out;
  Eigen::VectorXd tau;
  walk(log, [&](const Clip& clip, size_t k, BodyMotion* motion) {
    tau.resize(motion->model().nv());
    calc_inverse_dynamics(motion->model(), motion->vdot(), nullptr, &motion->data(), &tau);
    Balance b;
    b.clip = &clip, b.k = k, b.needed << tau.head<3>() / kArm, tau.segment<3>(3);
    for (const ForceSensor& s : log.sensors) {
      const Transform X = get_pose(motion->data(), s.link);
      b.R.push_back(X.R * s.X_LS.R), b.p.push_back(X * s.X_LS.p);
    }
    out.push_back(std::move(b));
  });
  return out;
}

// All sensors together, as one computer reads them; then in turn, each beside the others as they stand by then.
std::vector<SensorFrame> find_wrenches(const LeggedLog& log) {
  std::vector<SensorFrame> frames(log.sensors.size());
  const bool whole = !log.sensors.empty() && std::all_of(log.sensors.begin(), log.sensors.end(), [](const ForceSensor& s) { return s.has_wrench() && !s.world && s.foot >= 0; });
  const bool known = BodyMotion::find_force_source(log) != MotionSource::kNone && log.sensors.size() >= log.feet.size();
  if (!whole || !known) return {};
  const std::vector<Balance> balances = list_balances(log);
  if (balances.size() < kLeast) return {};
  const auto add = [&](const Balance& b, size_t s, const Matrix3d& R, const Clock& clock, Vector6d* left) {
    const size_t k = shift(b.k, clock, *b.clip, log);
    const Vector3d f = b.R[s] * R * get_values(&b.clip->force[6 * s], k), m = b.R[s] * R * get_values(&b.clip->force[6 * s + 3], k);
    left->head<3>() -= (m + b.p[s].cross(f)) / kArm, left->tail<3>() -= f;
  };
  const auto sum_up = [&](const std::function<bool(size_t)>& is_tried, const Matrix3d& R, const Clock& clock) {
    double sum = 0.0;
    for (const Balance& b : balances) {
      Vector6d left = b.needed;
      for (size_t s = 0; s < frames.size(); ++s) add(b, s, is_tried(s) ? R : frames[s].R, is_tried(s) ? clock : Clock{frames[s].late, 0.0}, &left);
      sum += left.squaredNorm();
    }
    return sum;
  };
  const SensorFrame all = find_best("", [&](const Matrix3d& R, const Clock& clock) { return sum_up([](size_t) { return true; }, R, clock); });
  for (SensorFrame& f : frames) f = all;
  for (int round = 0; round < 2; ++round) {
    for (size_t s = 0; s < frames.size(); ++s) {
      const Left left = [&](const Matrix3d& R, const Clock& clock) { return sum_up([s](size_t o) { return o == s; }, R, clock); };
      frames[s] = find_best("/wrench/" + log.sensors[s].name, left, frames[s]);
    }
  }
  return frames;
}

std::vector<SensorFrame> keep(std::vector<SensorFrame> frames) {
  frames.erase(std::remove_if(frames.begin(), frames.end(), [](const SensorFrame& f) { return !f.is_turned() && f.late == 0.0; }), frames.end());
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
    const Eigen::Quaterniond q = Eigen::Quaterniond((*wxyz[0])[k], (*wxyz[1])[k], (*wxyz[2])[k], (*wxyz[3])[k]) * Eigen::Quaterniond(R).conjugate();
    (*wxyz[0])[k] = q.w(), (*wxyz[1])[k] = q.x(), (*wxyz[2])[k] = q.y(), (*wxyz[3])[k] = q.z();
  }
}

// reading(t + late) at t, by a line between samples.
void shift_columns(const std::string& sensor, double late, Recording* r) {
  for (auto& [name, column] : r->other) {
    if (name.rfind(sensor + "/", 0) != 0) continue;
    const std::vector<double> was = column;
    size_t at = 0;
    for (size_t k = 0; k < was.size(); ++k) {
      const double t = std::clamp(r->time[k] + late, r->time.front(), r->time.back());
      while (at + 2 < was.size() && r->time[at + 1] < t) ++at;
      while (at > 0 && r->time[at] > t) --at;
      const double share = std::clamp((t - r->time[at]) / (r->time[at + 1] - r->time[at]), 0.0, 1.0);
      column[k] = was[at] + share * (was[at + 1] - was[at]);
    }
  }
}

}  // namespace

bool is_upside_down(const LeggedLog& log, size_t imu, double per_unit) {
  const std::vector<Expected> expected = list_expected(log, imu);
  if (expected.empty()) return false;
  const Left as_read = measure_imu(log, imu, per_unit, expected), reversed = measure_imu(log, imu, -per_unit, expected);
  double turned = 1e300, counted = 1e300;
  for (const Matrix3d& R : list_quarter_turns()) {
    turned = std::min(turned, as_read(R, {})), counted = std::min(counted, reversed(R, {}));
  }
  return turned < counted;
}

std::vector<SensorFrame> find_sensor_frames(const Experiment& e) {
  if (!e.scenario.floating_base || e.num_joints() == 0 || e.scenario.feet.empty()) return {};
  const LeggedLog log = make_legged_log(e, Half::kEven);
  std::vector<SensorFrame> out;
  for (size_t i = 0; i < log.imus.size(); ++i) out.push_back(find_imu(log, i));
  out = keep(std::move(out));
  const Experiment mounted = convert_sensor_frames(e, out);
  for (SensorFrame& f : keep(find_wrenches(make_legged_log(mounted, Half::kEven)))) out.push_back(std::move(f));
  return out;
}

Experiment convert_sensor_frames(Experiment e, const std::vector<SensorFrame>& frames) {
  for (const SensorFrame& f : frames) {
    for (Recording& r : e.recordings) {
      for (const char* part : {"/force", "/torque", "/linear_acceleration", "/angular_velocity"}) turn(f.sensor + part, f.R, &r);
      turn_attitude(f.sensor + "/orientation", f.R, &r);
      if (f.late != 0.0) shift_columns(f.sensor, f.late, &r);
    }
  }
  return e;
}

Vector3d find_roll_pitch_yaw(const Matrix3d& R) {
  return {std::atan2(R(2, 1), R(2, 2)), std::asin(std::clamp(-R(2, 0), -1.0, 1.0)), std::atan2(R(1, 0), R(0, 0))};
}

}  // namespace hrp::diagnosis::floating
