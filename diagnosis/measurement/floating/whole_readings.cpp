// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/whole_readings.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/floating/contacts.h"

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

// A log that keeps no negative forces reads the same for every foot in the air. What the feet carry together tells then:
// the weight of the robot, or that less the feet's. `below` [kg]: of all sensors.
bool carries_whole_feet(double sum, double mass, double below, double g) { return sum > (mass - kHalf * below) * g; }

// A foot that hangs on its sensor pulls it down by its weight. The whole foot in the air feels nothing.
bool reads_whole_foot(const ForceLevels& level, double weight) {
  return level.swings && level.air_spread < weight && std::abs(level.air) < kPart * weight;
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
    all_below += r.mass, cut = cut && contacts.levels[s].cut;
  }
  if (cut && !carries_whole_feet(sum, log.mass, all_below, g)) {
    for (WholeReading& r : out) r.cut = true;
  }
  return out;
}

// The foot stays part of the leg, and nothing is below the sensor.
Experiment convert_whole_readings(Experiment e, const std::vector<WholeReading>& readings) {
  for (const WholeReading& r : readings) {
    if (r.cut) continue;
    for (const WrenchSpec& spec : e.scenario.sensors.wrenches) {
      const int frame = e.robot.tree.find_frame(spec.link);
      if (spec.name == r.sensor && frame >= 0) e.robot.tree.frames[static_cast<size_t>(frame)].below = {};
    }
  }
  return e;
}

}  // namespace hrp::diagnosis::floating
