// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/log/contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/multibody/kinematics.h"

#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/slopes.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kShortest = 0.04;  // [s] of a spell: shorter ones are chatter

ForceLevels find_levels(const LeggedLog& log, size_t sensor) {
  std::vector<double> all;
  for (const Clip& clip : log.clips) {
    for (size_t k = 0; k < clip.size(); ++k) all.push_back(calc_vertical_force(log, clip, sensor, k));
  }
  ForceLevels levels;
  levels.stance = find_quantile(all, 0.75);
  levels.air = find_quantile(all, 0.02);
  levels.swings = levels.air < kPart * levels.stance;
  if (!levels.swings) {
    levels.air = 0;
    return levels;  // never in the air: its zero is not known
  }
  // In the air the reading stays near its lowest: the mean of what does.
  std::vector<double> low;
  for (double v : all) {
    if (v < levels.air + 0.5 * kDetail * (levels.stance - levels.air)) low.push_back(v);
  }
  levels.air = find_quantile(low, 0.5);
  levels.air_spread = 0.5 * (find_quantile(low, 0.84) - find_quantile(low, 0.16));
  levels.cut = levels.air - find_quantile(low, 0.05) <= kRounding * levels.stance;  // smoothed equal readings
  return levels;
}

// Spells shorter than kShortest join their neighbours.
void clean(double step, std::vector<char>* loaded) {
  const auto least = static_cast<size_t>(std::ceil(kShortest / step));
  for (size_t begin = 0; begin < loaded->size();) {
    size_t end = begin;
    while (end < loaded->size() && (*loaded)[end] == (*loaded)[begin]) ++end;
    if (end - begin < least && begin > 0 && end < loaded->size()) {
      std::fill(loaded->begin() + static_cast<long>(begin), loaded->begin() + static_cast<long>(end),
                (*loaded)[begin - 1]);
    }
    begin = end;
  }
}

bool has_vertical_force(const LeggedLog& log, const Foot& foot) {
  return foot.sensor >= 0 && log.sensors[static_cast<size_t>(foot.sensor)].axis[2];
}

std::vector<char> find_by_force(const LeggedLog& log, const Clip& clip, size_t sensor, const ForceLevels& l) {
  std::vector<char> loaded(clip.size(), 1);  // with more than a detail of its force in stance
  for (size_t k = 0; l.swings && k < clip.size(); ++k) {
    loaded[k] = calc_vertical_force(log, clip, sensor, k) > l.air + kDetail * (l.stance - l.air);
  }
  return loaded;
}

// Feet near the height of the lowest one. An attitude that is off, ground that slopes and tyres or soles that give
// raise one foot above another in the model all the time: up to a slope of kMinor (3 degrees), each foot's own lowest
// height is that of the ground below it.
std::vector<std::vector<char>> find_by_kinematics(const LeggedLog& log, const Clip& clip) {
  std::vector<std::vector<char>> out(log.feet.size(), std::vector<char>(clip.size(), 0));
  if (out.empty()) return out;
  BodyMotion motion(log, clip);
  std::vector<std::vector<double>> raised(log.feet.size(),
                                          std::vector<double>(clip.size()));             // [m] above the lowest one
  std::vector<double> ground(log.feet.size(), std::numeric_limits<double>::infinity());  // [m] the least of it
  std::vector<Vector3d> sole(log.feet.size());
  for (size_t k = 0; k < clip.size(); ++k) {
    motion.update(k);
    const Vector3d up = motion.find_up(k);
    for (size_t f = 0; f < sole.size(); ++f)
      sole[f] = get_pose(motion.data(), log.feet[f].link) * log.feet[f].p_LC - log.feet[f].radius * up;
    const Vector3d lowest = *std::min_element(
        sole.begin(), sole.end(), [&](const Vector3d& a, const Vector3d& b) { return up.dot(a) < up.dot(b); });
    for (size_t f = 0; f < sole.size(); ++f) {
      raised[f][k] = up.dot(sole[f] - lowest);
      if (raised[f][k] <= kMinor * (sole[f] - lowest).norm()) ground[f] = std::min(ground[f], raised[f][k]);
    }
  }
  for (size_t f = 0; f < sole.size(); ++f) {
    const double level = std::isfinite(ground[f]) ? ground[f] : 0.0;
    for (size_t k = 0; k < clip.size(); ++k) out[f][k] = raised[f][k] < level + kRaisedFoot;
  }
  return out;
}

// Each foot by its own force, else by how high it is.
std::vector<std::vector<char>> find_loaded(const LeggedLog& log, const Clip& clip, const Contacts& contacts) {
  std::vector<std::vector<char>> out;
  if (!contacts.from_forces) out = find_by_kinematics(log, clip);
  out.resize(log.feet.size());
  for (size_t f = 0; f < log.feet.size(); ++f) {
    const auto s = static_cast<size_t>(log.feet[f].sensor);
    if (has_vertical_force(log, log.feet[f])) out[f] = find_by_force(log, clip, s, contacts.levels[s]);
    clean(clip.step, &out[f]);
  }
  return out;
}

void add_spells(size_t clip, const std::vector<std::vector<char>>& loaded, Contacts* contacts) {
  for (size_t f = 0; f < loaded.size(); ++f) {
    for (size_t begin = 0; begin < loaded[f].size();) {
      size_t end = begin;
      while (end < loaded[f].size() && loaded[f][end] == loaded[f][begin]) ++end;
      contacts->spells.push_back({clip, f, begin, end, loaded[f][begin] != 0});
      contacts->walks = contacts->walks || !loaded[f][begin];
      begin = end;
    }
  }
}

}  // namespace

// A foot's axis along the leg carries the load; what it leaves out is second order in its tilt. A sensor that hangs
// upside down in the model, as those of the iCub do, reads a foot that is pressed as negative along its own z axis.
double calc_vertical_force(const LeggedLog& log, const Clip& clip, size_t sensor, size_t k) {
  const ForceSensor& s = log.sensors[sensor];
  const auto read = [&](size_t axis) { return clip.force[6 * sensor + axis].value[k]; };
  if (s.world) return s.axis[2] ? read(2) : 0;
  if (s.has_force()) return s.X_LS.R.row(2).dot(Vector3d(read(0), read(1), read(2)));
  return s.axis[2] ? std::copysign(1.0, s.X_LS.R(2, 2)) * read(2) : 0;
}

Vector3d move_to_sole(const ForceSensor& sensor, const Foot& foot, const Vector3d& force_S, const Vector3d& moment_S) {
  return sensor.X_LS.R * moment_S + (sensor.X_LS.p - foot.p_LC).cross(sensor.X_LS.R * force_S);
}

int Contacts::find_phase(size_t clip, size_t k) const {
  int phase = 0;
  for (size_t f = 0; f < loaded[clip].size(); ++f) phase |= loaded[clip][f][k] ? 1 << f : 0;
  return phase;
}

const char* Contacts::find_phase_name(int phase) const {
  int count = 0;
  for (int rest = phase; rest != 0; rest &= rest - 1) ++count;
  const auto feet = loaded.empty() ? 0 : static_cast<int>(loaded[0].size());
  if (count == 0) return "flight";
  if (count == feet) return walks ? "double support" : "stance";
  return count == 1 ? "single support" : "partial support";
}

Contacts find_contacts(const LeggedLog& log) {
  Contacts contacts;
  for (size_t s = 0; s < log.sensors.size(); ++s) contacts.levels.push_back(find_levels(log, s));
  contacts.from_forces = !log.feet.empty();
  for (const Foot& foot : log.feet) contacts.from_forces = contacts.from_forces && has_vertical_force(log, foot);
  for (size_t c = 0; c < log.clips.size(); ++c) {
    contacts.loaded.push_back(find_loaded(log, log.clips[c], contacts));
    add_spells(c, contacts.loaded.back(), &contacts);
  }
  return contacts;
}

}  // namespace hrp::diagnosis::floating
