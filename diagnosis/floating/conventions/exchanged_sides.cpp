// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/exchanged_sides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "common/base/rounding.h"
#include "common/multibody/kinematics.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/checks/imu_over_legs.h"
#include "diagnosis/floating/checks/load_share.h"
#include "diagnosis/floating/conventions/sides.h"
#include "diagnosis/floating/log/clip_maker.h"
#include "diagnosis/floating/log/contacts.h"
#include "diagnosis/floating/log/foot_sensors.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kPlace = 0.02;  // [m] to which masses and middles of soles tell where a robot presses

enum Way { kAsNamed, kFeet, kLegs, kBoth, kWays };
const char* const kWayNames[] = {"", "force sensors of feet alone", "joints of legs alone",
                                 "joints of legs and force sensors of feet"};

// What the ground does, about the base's origin and in its axes, by forces in any one unit. Without moments, a foot is
// pressed in its middle.
Vector6d sum_wrenches(const LeggedLog& log, const Clip& clip, size_t k, BodyMotion* motion) {
  Vector6d sum = Vector6d::Zero();
  for (const Foot& foot : log.feet) {
    if (foot.sensor < 0) continue;
    const auto s = static_cast<size_t>(foot.sensor);
    const ForceSensor& sensor = log.sensors[s];
    const Transform X = get_pose(motion->data(), foot.link);
    Vector6d own;
    if (sensor.has_wrench()) {
      const Matrix3d R = X.R * sensor.X_LS.R;
      const Vector3d force = R * get_values(&clip.force[6 * s], k);
      own << R * get_values(&clip.force[6 * s + 3], k) + (X * sensor.X_LS.p).cross(force), force;
    } else {
      const Vector3d force = calc_vertical_force(log, clip, s, k) * X.R.col(2);
      own << (X * foot.p_LC).cross(force), force;
    }
    sum += own;
  }
  return sum;
}

// [m] Over the lowest foot: the mean by what feet are loaded with. Feet in the air bear nothing.
double find_raised_load(const LeggedLog& log, const Clip& clip, size_t k, const Vector3d& up, BodyMotion* motion) {
  std::vector<double> heights;
  for (const Foot& foot : log.feet)
    heights.push_back(up.dot(get_pose(motion->data(), foot.link) * foot.p_LC) - foot.radius);
  const double lowest = *std::min_element(heights.begin(), heights.end());
  double sum = 0.0, total = 0.0;
  for (size_t f = 0; f < heights.size(); ++f) {
    const double load = std::max(0.0, calc_vertical_force(log, clip, static_cast<size_t>(log.feet[f].sensor), k));
    sum += load * (heights[f] - lowest);
    total += load;
  }
  return total > 0.0 ? sum / total : 0.0;
}

Vector3d find_middle_of_feet(const LeggedLog& log, BodyMotion* motion) {
  Vector3d sum = Vector3d::Zero();
  for (const Foot& foot : log.feet) sum += get_pose(motion->data(), foot.link) * foot.p_LC;
  return sum / static_cast<double>(log.feet.size());
}

struct Pressure {
  Instant at;
  Vector3d off;       // [m] from where the motion asks for pressure to where the feet press, base axes
  double raised = 0;  // [m] what is loaded is over the lowest foot
};

// NaN in the air, where nothing is pressed.
std::vector<Pressure> list_pressures(const LeggedLog& log) {
  std::vector<Pressure> out;
  Eigen::VectorXd tau;
  const double least = kMuch * log.mass * log.experiment->scenario.gravity_W.norm();
  walk(log, Purpose::kForTurns, [&](const Clip& clip, size_t k, BodyMotion* motion) {
    tau.resize(motion->model().nv());
    calc_inverse_dynamics(motion->model(), motion->vdot(), nullptr, &motion->data(), &tau);
    const Vector6d pressed = sum_wrenches(log, clip, k, motion);
    const Vector3d up = motion->find_up(k), p = find_middle_of_feet(log, motion);
    Vector3d off = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    if (up.dot(tau.segment<3>(3)) > least && up.dot(pressed.tail<3>()) > 0)
      off = calc_zero_moment_point(pressed.head<3>(), pressed.tail<3>(), up, p) -
            calc_zero_moment_point(tau.head<3>(), tau.segment<3>(3), up, p);
    out.push_back({{&clip, k}, off, find_raised_load(log, clip, k, up, motion)});
  });
  return out;
}

// Moments at which every way tells it.
std::vector<size_t> list_told(const std::array<std::vector<Pressure>, kWays>& ways) {
  std::vector<size_t> out;
  for (size_t i = 0; i < ways[kAsNamed].size(); ++i) {
    if (std::all_of(ways.begin(), ways.end(),
                    [&](const std::vector<Pressure>& w) { return w.empty() || w[i].off.allFinite(); }))
      out.push_back(i);
  }
  return out;
}

// [1] By moment. The mean of each clip is left out: a mass beside its place is constant, and is no exchange.
std::vector<double> list_left(const std::vector<Pressure>& moments, const std::vector<size_t>& told) {
  std::map<const Clip*, std::pair<Vector3d, double>> sums;
  for (size_t i : told) {
    auto& [sum, count] = sums.try_emplace(moments[i].at.clip, Vector3d::Zero(), 0.0).first->second;
    sum += moments[i].off;
    count += 1.0;
  }
  std::vector<double> left;
  for (size_t i : told) {
    const auto& [sum, count] = sums.at(moments[i].at.clip);
    left.push_back(std::hypot((moments[i].off - sum / count).norm() / kPlace, moments[i].raised / kRaisedFoot));
  }
  return left;
}

LeggedLog exchange(const LeggedLog& log, int way, const SidePairs& feet, const SidePairs& legs) {
  LeggedLog out = way & kFeet ? exchange_feet(log, feet) : log;
  return way & kLegs ? exchange_legs(std::move(out), legs) : out;
}

// What each way leaves; empty where it cannot be.
struct Trial {
  std::vector<Instant> at;
  std::array<std::vector<double>, kWays> left;
};

Trial try_ways(const LeggedLog& log, const SidePairs& feet, const SidePairs& legs) {
  Trial out;
  std::array<std::vector<Pressure>, kWays> ways;
  for (int way = kAsNamed; way < kWays; ++way) {
    if (((way & kFeet) && feet.empty()) || ((way & kLegs) && legs.empty())) continue;
    const LeggedLog exchanged = exchange(log, way, feet, legs);
    std::vector<Pressure>& moments = ways[static_cast<size_t>(way)] = list_pressures(exchanged);
    for (Pressure& p : moments) p.at.clip = &log.clips[static_cast<size_t>(p.at.clip - exchanged.clips.data())];
  }
  const std::vector<size_t> told = list_told(ways);
  if (!is_enough(Purpose::kForClocks, told.size())) return out;
  for (size_t i : told) out.at.push_back(ways[kAsNamed][i].at);
  for (size_t way = 0; way < kWays; ++way) {
    if (!ways[way].empty()) out.left[way] = list_left(ways[way], told);
  }
  return out;
}

// The way that leaves least; kAsNamed unless it leaves a quarter, as any convention must.
int find_best_way(const Trial& trial) {
  int best = kAsNamed;
  for (int way = kFeet; way < kWays; ++way) {
    const std::vector<double>& left = trial.left[static_cast<size_t>(way)];
    if (!left.empty() && find_square(left) < find_square(trial.left[static_cast<size_t>(best)])) best = way;
  }
  const std::vector<double>&least = trial.left[static_cast<size_t>(best)], &nominal = trial.left[kAsNamed];
  const bool told = find_square(least) < kPart * find_square(nominal) && calc_odds(trial.at, least, nominal) > kOdds;
  return told ? best : kAsNamed;
}

std::string find_rival(const Trial& trial, int best) {
  for (int way = kFeet; way < kWays; ++way) {
    const std::vector<double>& left = trial.left[static_cast<size_t>(way)];
    if (way == best || left.empty() || find_square(left) > kPart * find_square(trial.left[kAsNamed])) continue;
    if (calc_odds(trial.at, trial.left[static_cast<size_t>(best)], left) < kOdds) return kWayNames[way];
  }
  return "";
}

bool tells_pressure(const LeggedLog& log) {
  const bool forces = log.feet.size() > 1 && all_feel(log, [](const ForceSensor& s) { return !s.world; });
  return forces && BodyMotion::find_force_source(log) != MotionSource::kNone;
}

}  // namespace

ExchangedSides find_exchanged_sides(const Experiment& e) {
  ExchangedSides out;
  if (!e.scenario.floating_base || e.num_joints() == 0) return out;
  const LeggedLog log = make_legged_log(e, Half::kEven);
  const SidePairs feet = list_sensor_pairs(log), legs = list_leg_pairs(log);
  if (!tells_pressure(log) || feet.empty()) return out;
  const Trial trial = try_ways(log, feet, legs);
  const int way = trial.at.empty() ? kAsNamed : find_best_way(trial);
  if (way == kAsNamed) return out;
  for (const auto& [a, b] : feet) {
    if (way & kFeet) out.feet.emplace_back(log.sensors[a].name, log.sensors[b].name);
  }
  for (const auto& [a, b] : legs) {
    if (way & kLegs) out.legs.emplace_back(static_cast<int>(a), static_cast<int>(b));
  }
  out.left = find_square(trial.left[static_cast<size_t>(way)]) / find_square(trial.left[kAsNamed]);
  out.rival = find_rival(trial, way);
  return out;
}

Experiment convert_sides(Experiment e, const ExchangedSides& exchanged) {
  for (Recording& r : e.recordings) {
    for (const auto& [a, b] : exchanged.legs)
      std::swap(r.joints[static_cast<size_t>(a)], r.joints[static_cast<size_t>(b)]);
    for (const auto& [a, b] : exchanged.feet) {
      for (int axis = 0; axis < 6; ++axis) {
        const auto one = r.other.find(get_force_column(a, axis)), other = r.other.find(get_force_column(b, axis));
        if (one != r.other.end() && other != r.other.end()) std::swap(one->second, other->second);
      }
    }
  }
  return e;
}

std::string describe(const ExchangedSides& x) {
  const int way = (x.feet.empty() ? kAsNamed : kFeet) | (x.legs.empty() ? kAsNamed : kLegs);
  return std::string("columns of left and right are exchanged: ") + kWayNames[way] +
         (x.feet.empty() ? "" : " (/wrench/" + x.feet[0].first + " and /wrench/" + x.feet[0].second + ")") +
         ". They are taken the other way round. What the motion asks of the feet, and how high they are, then differs "
         "from what they "
         "bear by " +
         number(std::sqrt(x.left), 2) + " of what it does as logged" +
         (x.rival.empty() ? "" : ". It does not tell whether it is the " + x.rival);
}

}  // namespace hrp::diagnosis::floating
