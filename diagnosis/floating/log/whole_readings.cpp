// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/log/whole_readings.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/multibody/kinematics.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/log/clip_maker.h"
#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr size_t kFewest = 2;  // sensors: the zero of one may happen to be its foot's weight

// What all feet read together [N], mean.
double find_mean_sum(const LeggedLog& log) {
  double sum = 0, count = 0;
  for (const Clip& clip : log.clips) {
    for (size_t k = 0; k < clip.size(); ++k, ++count) {
      for (size_t s = 0; s < log.sensors.size(); ++s) sum += calc_vertical_force(log, clip, s, k);
    }
  }
  return sum / std::max(1.0, count);
}

// A log that keeps no negative forces reads the same for every foot in the air. What the feet carry together tells
// then: the weight of the robot, or that less the feet's. `below` [kg]: of all sensors.
bool carries_whole_feet(double sum, double mass, double below, double g) { return sum > (mass - kHalf * below) * g; }

// A foot that hangs on its sensor pulls it down by its weight. The whole foot in the air feels nothing.
bool reads_whole_foot(const ForceLevels& level, double weight) {
  return level.swings && level.air_spread < weight && std::abs(level.air) < kPart * weight;
}

// Whether the log keeps no smaller forces: most readings in the air are exactly the least one. Smoothed readings do not
// tell it, because noise lifts some of them.
bool is_cut(const Experiment& e, const ForceSensor& sensor, const ForceLevels& level) {
  if (level.cut) return true;
  const double sign = std::copysign(1.0, sensor.X_LS.R(2, 2)), limit = level.air + kMinor * (level.stance - level.air);
  std::vector<double> air;
  for (const Recording& r : e.recordings) {
    const auto column = r.other.find(get_force_column(sensor.name, 2));
    if (column == r.other.end()) continue;
    for (double v : column->second) {
      if (std::isfinite(v) && sign * v < limit) air.push_back(sign * v);
    }
  }
  if (air.empty()) return false;
  const auto least = static_cast<double>(std::count(air.begin(), air.end(), *std::min_element(air.begin(), air.end())));
  return least > kHalf * static_cast<double>(air.size());
}

// [N] What a sensor reads along its z axis while its foot hangs on it, by sample of a clip. The foot is taken as a
// point there.
std::vector<double> calc_hanging(const LeggedLog& log, const Clip& clip, const ForceSensor& sensor, double mass) {
  std::vector<double> out;
  BodyMotion motion(log, clip);
  for (size_t k = 0; k < clip.size(); ++k) {
    motion.update(k);
    const Transform X = get_pose(motion.data(), sensor.link);
    const Vector3d a = calc_point_acceleration(motion.data(), sensor.link, X * sensor.X_LS.p).tail<3>();
    out.push_back(-mass * (X.R * sensor.X_LS.R).col(2).dot(a));
  }
  return out;
}

// Puts back what the log did not keep: readings that are the least one while the foot hangs there.
void fill_cut(const LeggedLog& log, const ForceSensor& sensor, double mass, Experiment* e) {
  const double sign = std::copysign(1.0, sensor.X_LS.R(2, 2));
  for (const Clip& clip : log.clips) {
    Recording& r = e->recordings[clip.recording];
    const auto column = r.other.find(get_force_column(sensor.name, 2));
    if (column == r.other.end() || column->second.empty()) continue;
    std::vector<double>& z = column->second;
    double least = 1e300;
    for (double v : z) least = std::min(least, std::isfinite(v) ? sign * v : least);
    const std::vector<double> hanging = calc_hanging(log, clip, sensor, mass);
    for (size_t i = 0; i < z.size(); ++i) {
      if (sign * z[i] != least || r.time[i] < clip.time.front() || r.time[i] > clip.time.back()) continue;
      const auto after = std::lower_bound(clip.time.begin(), clip.time.end(), r.time[i]) - clip.time.begin();
      // A foot that is thrown up presses its sensor: what is cut is not more than the least reading.
      z[i] = sign * std::min(least, sign * hanging[static_cast<size_t>(after)]);
    }
  }
}

}  // namespace

double find_mass_below(const ForceSensor& sensor) { return sensor.hangs + sensor.below.mass; }  // one of both is 0

std::vector<WholeReading> find_whole_readings(const Experiment& e) {
  if (!e.scenario.floating_base || e.num_joints() == 0) return {};
  const LeggedLog log = make_legged_log(e, Half::kEven);
  const double g = e.scenario.gravity_W.norm();
  std::vector<WholeReading> out;
  for (size_t s = 0; s < log.sensors.size(); ++s) {
    const double below = find_mass_below(log.sensors[s]);
    if (below <= 0 || log.sensors[s].foot < 0) continue;
    out.push_back({log.sensors[s].name, below, 0});
  }
  const double sum = find_mean_sum(log);
  // Raw counts have no weight of a foot to compare.
  if (out.size() < kFewest || std::abs(sum / (log.mass * g) - 1) > kMinority) return {};
  const Contacts contacts = find_contacts(log);
  double all_below = 0;
  bool cut = true;
  for (WholeReading& r : out) {
    size_t s = 0;
    while (log.sensors[s].name != r.sensor) ++s;
    if (!reads_whole_foot(contacts.levels[s], r.mass * g)) return {};
    r.air = contacts.levels[s].air;
    all_below += r.mass;
    cut = cut && is_cut(e, log.sensors[s], contacts.levels[s]);
  }
  if (cut && !carries_whole_feet(sum, log.mass, all_below, g)) {
    for (WholeReading& r : out) r.cut = true;
  }
  return out;
}

// The foot stays part of the leg, and nothing is below the sensor. Where the log keeps no smaller forces, what the
// hanging foot makes the sensor read is put back.
Experiment convert_whole_readings(Experiment e, const std::vector<WholeReading>& readings) {
  if (std::any_of(readings.begin(), readings.end(), [](const WholeReading& r) { return r.cut; })) {
    const LeggedLog log = make_legged_log(e, Half::kAll);
    if (BodyMotion::find_force_source(log) == MotionSource::kNone) return e;
    for (const WholeReading& r : readings) {
      for (const ForceSensor& sensor : log.sensors) {
        if (r.cut && sensor.name == r.sensor && !sensor.world) fill_cut(log, sensor, r.mass, &e);
      }
    }
  }
  for (const WholeReading& r : readings) {
    if (r.cut) continue;
    for (const WrenchSpec& spec : e.scenario.sensors.wrenches) {
      const int frame = e.robot.tree.find_frame(spec.link);
      if (spec.name == r.sensor && frame >= 0) e.robot.tree.frames[static_cast<size_t>(frame)].below = {};
    }
  }
  return e;
}

std::string describe(const WholeReading& w) {
  if (w.cut)
    return "/wrench/" + w.sensor + ": it never reads less than " + number(w.air, 2) +
           " N, although the foot that hangs on it weighs " + number(w.mass, 3) +
           " kg: the log keeps no smaller forces. With the foot in the air, it tells nothing; what the hanging foot "
           "makes it read is put back";
  return "/wrench/" + w.sensor + ": it reads what the ground does to the whole foot: " + number(w.air, 2) +
         " N in the air. The foot's " + number(w.mass, 3) + " kg are taken as above the sensor";
}

}  // namespace hrp::diagnosis::floating
