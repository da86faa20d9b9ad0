// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/body_units.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "diagnosis/data/plausibility.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/conventions/sensor_frames.h"
#include "diagnosis/floating/log/body_motion.h"
#include "diagnosis/floating/log/contacts.h"
#include "diagnosis/floating/log/foot_sensors.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kTurns = 0.02;   // [rad/s] root mean square of rates that tell a gyroscope's unit
constexpr double kFastest = 6.0;  // [rad/s] half of the time: no body on its feet turns so
constexpr double kFar = 30.0;     // times the robot's own height: no base is so far up

// Nothing else is so far from 1.
bool is_near(double factor, double unit) { return std::abs(factor / unit - 1.0) < kPart; }

class Finder {
 public:
  explicit Finder(const LeggedLog& log) : log_(log) {}

  std::vector<BodyUnit> run() {
    for (size_t i = 0; i < log_.imus.size(); ++i) {
      if (log_.imus[i].accelerometer) find_accelerometer(i);
      if (log_.imus[i].gyro) find_gyroscope(i);
    }
    for (size_t s = 0; s < log_.sensors.size(); ++s) find_force(s);
    find_kilograms();
    if (log_.base_pose) find_position();
    return std::move(out_);
  }

 private:
  std::string get_imu(size_t i, const char* quantity) const { return "/imu/" + log_.imus[i].name + "/" + quantity; }

  // Mean reading in the base's axes: over seconds a body that stands or walks feels gravity alone.
  void find_accelerometer(size_t i) {
    Vector3d sum = Vector3d::Zero();
    double count = 0.0;
    for (const Clip& clip : log_.clips) {
      BodyMotion motion(log_, clip);
      for (size_t k = clip.edge; k + clip.edge < clip.size(); k += kStride) {
        motion.update(k);
        Vector3d f;
        for (int a = 0; a < 3; ++a) f(a) = clip.imus[i].accelerometer[a].value[k];
        sum += get_pose(motion.data(), log_.imus[i].link).R * log_.imus[i].R_LI * f;
        count += 1.0;
      }
    }
    const double g = log_.experiment->scenario.gravity_W.norm(), size = sum.norm() / std::max(1.0, count) / g;
    if (count < 1.0 || std::abs(sum.z()) < kLargely * sum.norm()) return;
    const double unit = is_near(size, 1.0 / g) ? 1.0 / g : is_near(size, 1000.0 / g) ? 1000.0 / g : 1.0;
    const Upside upside = sum.z() < 0.0 ? find_upside(log_, i, unit) : Upside::kTurned;
    const double sign = upside == Upside::kTurned ? 1.0 : -1.0;
    if (unit == 1.0 && (sign > 0.0 || !is_near(size, 1.0))) return;
    const std::string in = unit == 1.0 ? "" : unit < 1.0 ? "in g" : "in thousandths of g";
    out_.push_back({get_imu(i, "linear_acceleration"), sign * unit,
                    "it counts " + in +
                        (sign < 0.0 ? std::string(in.empty() ? "" : " and ") +
                                          "gravity upwards down, as a body at rest does not feel it"
                                    : ""),
                    upside == Upside::kUnknown});
  }

  // Against the rate of the same sensor's attitude, or of the base's pose where nothing moves between: sample by
  // sample, else by how much both turn at all, which no clock and no mounting changes; else by its size.
  void find_gyroscope(size_t i) {
    const ImuSensor& imu = log_.imus[i];
    const Ratio ratio = imu.attitude || (log_.base_pose && imu.link == 0) ? calc_ratio(i) : Ratio{};
    if (is_near(ratio.slope, 1.0)) return;
    if (is_near(ratio.slope, kDegrees) || is_near(ratio.size, kDegrees) || calc_median_rate(i) > kFastest)
      out_.push_back({get_imu(i, "angular_velocity"), kDegrees, "it counts in degrees per second"});
  }

  double calc_median_rate(size_t i) const {
    std::vector<double> size;
    for (const Clip& clip : log_.clips) {
      const Track* w = clip.imus[i].gyro;
      for (size_t k = clip.edge; k + clip.edge < clip.size(); k += kStride)
        size.push_back(Vector3d(w[0].value[k], w[1].value[k], w[2].value[k]).norm());
    }
    return size.empty() ? 0.0 : find_median(std::move(size));
  }

  // Reading over the attitude's rate: slope of a line, and ratio of sizes. 0 where it hardly turns.
  struct Ratio {
    double slope = 0.0, size = 0.0;
  };

  Ratio calc_ratio(size_t i) const {
    const ImuSensor& imu = log_.imus[i];
    double same = 0.0, square = 0.0, read = 0.0, count = 0.0;
    for (const Clip& clip : log_.clips) {
      for (size_t k = clip.edge; k + clip.edge < clip.size(); k += kStride) {
        Vector3d w, dw;
        calc_quaternion_rates(imu.attitude ? clip.imus[i].attitude : clip.base_attitude, k, &w, &dw);
        const Vector3d reading = get_values(clip.imus[i].gyro, k);
        if (!imu.attitude) w = imu.R_LI.transpose() * w;
        same += w.dot(reading);
        square += w.squaredNorm();
        read += reading.squaredNorm();
        count += 1.0;
      }
    }
    if (count == 0.0 || std::sqrt(square / count) <= kTurns) return {};
    return {same / square, std::sqrt(read / square)};
  }

  // The ground presses: it does not pull.
  void find_force(size_t s) {
    std::vector<double> all;
    for (const Clip& clip : log_.clips) {
      for (size_t k = clip.edge; k + clip.edge < clip.size(); k += kStride)
        all.push_back(calc_vertical_force(log_, clip, s, k));
    }
    if (all.empty() || log_.sensors[s].foot < 0) return;
    const double low = find_quantile(all, 0.05), high = find_quantile(all, 0.95);
    const double weight = log_.mass * log_.experiment->scenario.gravity_W.norm() /
                          std::max<double>(1.0, static_cast<double>(log_.feet.size()));
    if (-low < kFarMore * std::max(0.0, high) || -low < 0.5 * weight) return;
    // Impacts of a robot that falls exceed its weight many times, but last shortly.
    const auto down = std::count_if(all.begin(), all.end(), [&](double f) { return f < -0.5 * weight; });
    const auto up = std::count_if(all.begin(), all.end(), [&](double f) { return f > 0.5 * weight; });
    if (static_cast<double>(down) < kFarMore * static_cast<double>(up)) return;
    out_.push_back({"/wrench/" + log_.sensors[s].name + "/force", -1.0, "it counts what the foot does to the ground"});
    if (log_.sensors[s].has_wrench())
      out_.push_back(
          {"/wrench/" + log_.sensors[s].name + "/torque", -1.0, "it counts what the foot does to the ground"});
  }

  // What all feet bear is the weight, and in kilograms a tenth of it. Raw counts that come so near by chance are rare,
  // and their scales are then told as such.
  void find_kilograms() {
    if (log_.feet.empty() || !all_feel(log_)) return;
    double sum = 0.0, count = 0.0;
    for (const Clip& clip : log_.clips) {
      for (size_t k = clip.edge; k + clip.edge < clip.size(); k += kStride, count += 1.0) {
        for (size_t s = 0; s < log_.sensors.size(); ++s)
          sum += log_.sensors[s].foot >= 0 ? calc_vertical_force(log_, clip, s, k) : 0.0;
      }
    }
    const double g = log_.experiment->scenario.gravity_W.norm();
    if (count == 0.0 || !is_near(sum / count / ((log_.mass - log_.mass_below) * g), 1.0 / g)) return;
    for (const ForceSensor& sensor : log_.sensors) {
      if (sensor.foot >= 0) out_.push_back({"/wrench/" + sensor.name + "/force", 1.0 / g, "it counts in kilograms"});
    }
  }

  // A base stands about as high as its legs are long.
  void find_position() {
    double reach = 0.0;
    std::vector<double> height;
    for (const Clip& clip : log_.clips) {
      BodyMotion motion(log_, clip);
      for (size_t k = clip.edge; k + clip.edge < clip.size(); k += kStride) {
        motion.update(k);
        for (const Foot& foot : log_.feet)
          reach = std::max(reach, (get_pose(motion.data(), foot.link) * foot.p_LC).norm());
        height.push_back(clip.base_position[2].value[k]);
      }
    }
    if (height.empty() || reach <= 0.0 || std::abs(find_median(height)) < kFar * reach) return;
    const double millimetres = find_median(height) / reach;
    const bool fits = millimetres > 300.0 && millimetres < 3000.0;
    if (fits) out_.push_back({"/base/pose/position", 1000.0, "it counts in millimetres"});
  }

  const LeggedLog& log_;
  std::vector<BodyUnit> out_;
};

}  // namespace

std::vector<BodyUnit> find_body_units(const Experiment& e) {
  if (!e.scenario.floating_base || e.num_joints() == 0) return {};
  const LeggedLog log = make_legged_log(e, Half::kEven);
  return Finder(log).run();
}

Experiment convert_body_units(Experiment e, const std::vector<BodyUnit>& units) {
  for (const BodyUnit& unit : units) {
    for (Recording& r : e.recordings) {
      for (const char* axis : {"/x", "/y", "/z"}) {
        const auto column = r.other.find(unit.sensor + axis);
        if (column == r.other.end()) continue;
        for (double& x : column->second) x /= unit.scale;
      }
    }
    for (const char* axis : {"/x", "/y", "/z"}) {
      const auto noise = e.other_noise.find(unit.sensor + axis);
      if (noise != e.other_noise.end()) noise->second.sigma /= std::abs(unit.scale);
    }
  }
  return e;
}

}  // namespace hrp::diagnosis::floating
