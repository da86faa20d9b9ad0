// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/air_zeros.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/robust.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/checks/checks.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr size_t kFewestSamples = 5;

double get_sign(const ForceSensor& s) { return std::copysign(1.0, s.X_LS.R(2, 2)); }

class ZeroFinder {
 public:
  ZeroFinder(const LeggedLog& log, const Contacts& contacts) : log_(log), contacts_(contacts) {}

  std::vector<AirZero> run() const {
    std::vector<AirZero> out;
    // Of the robot's weight, which a foot bears: zeros are known no better.
    const double known = kTrace * log_.mass * log_.experiment->scenario.gravity_W.norm();
    for (size_t s = 0; s < log_.sensors.size(); ++s) {
      const ForceLevels& level = contacts_.levels[s];
      if (!tells_zero(log_.sensors[s]) || !level.swings) continue;
      const std::vector<double> swings = list_swings(s);
      const Consensus k = find_consensus(swings, known);
      const double std = k.kept > 1 ? k.std * find_widening(k.kept) : 1e9;
      if (k.kept < kFewestToAgree || std::abs(k.mean) < std::max(known, kUnlikely * std)) continue;
      out.push_back({s, k.kept, get_sign(log_.sensors[s]) * k.mean, std});
    }
    return out;
  }

 private:
  // What hangs below a sensor accelerates. It is subtracted only where the recording tells how.
  bool tells_zero(const ForceSensor& sensor) const {
    if (sensor.has_force() || !sensor.axis[2] || sensor.world) return false;
    return sensor.below.mass <= 0 || BodyMotion::find_force_source(log_) != MotionSource::kNone;
  }

  // [N] The median reading of each swing, as far from landing and lifting as the kernel reaches. A foot that touches
  // the ground on its way reads more for some samples.
  std::vector<double> list_swings(size_t sensor) const {
    std::vector<double> out;
    for (const Contact& spell : contacts_.spells) {
      const Clip& clip = log_.clips[spell.clip];
      if (spell.loaded || log_.feet[spell.foot].sensor != static_cast<int>(sensor)) continue;
      if (spell.end - spell.begin < 2 * clip.edge + kFewestSamples) continue;
      out.push_back(find_reading(sensor, clip, spell.begin + clip.edge, spell.end - clip.edge));
    }
    return out;
  }

  double find_reading(size_t s, const Clip& clip, size_t begin, size_t end) const {
    const ForceSensor& sensor = log_.sensors[s];
    BodyMotion motion(log_, clip);
    std::vector<double> readings;
    for (size_t k = begin; k < end; ++k) {
      readings.push_back(calc_vertical_force(log_, clip, s, k));
      if (sensor.below.mass <= 0) continue;
      motion.update(k);
      const Transform X = get_pose(motion.data(), sensor.link);
      const Vector3d a = calc_point_acceleration(motion.data(), sensor.link, X * sensor.below.p_LLcm_L).tail<3>();
      readings.back() += sensor.below.mass * (X.R.transpose() * a).z();
    }
    return find_median(std::move(readings));
  }

  const LeggedLog& log_;
  const Contacts& contacts_;
};

}  // namespace

std::vector<AirZero> find_air_zeros(const LeggedLog& log, const Contacts& contacts) {
  return ZeroFinder(log, contacts).run();
}

Eigen::VectorXd list_zeros(const ColumnLayout& layout, const std::vector<AirZero>& zeros) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(layout.count());
  for (const AirZero& z : zeros) out(layout.sensor(static_cast<int>(z.sensor), kForceBiasColumn + 2)) = z.value;
  return out;
}

Finding make_zero_finding(const LeggedLog& log, const AirZero& zero) {
  const std::string name = "/wrench/" + log.sensors[zero.sensor].name + "/force";
  const EffectInfo& bias = get_laws().sensor_bias.info();
  Finding f = make_finding(bias, {{"sensor", name}}, {make_value(bias, zero.value, zero.std, "N")});
  f.grade = Grade::kSupported;
  f.probability = 0.95;
  f.share = 1;
  f.weight = 0.5;
  f.statement = name + format(" reads %.1f +- %.1f N while its foot is in the air (%.0f swings): its zero is off.",
                              zero.value, kNinetyFive * zero.std, static_cast<double>(zero.swings));
  return f;
}

}  // namespace hrp::diagnosis::floating
