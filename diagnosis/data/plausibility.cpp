// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/plausibility.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/base/diagnostics.h"
#include "common/base/format.h"
#include "common/base/rounding.h"
#include "diagnosis/data/angle_limits.h"
#include "diagnosis/data/mean.h"
#include "diagnosis/data/range.h"
#include "diagnosis/data/repair.h"
#include "diagnosis/data/servo_gains.h"
#include "diagnosis/data/smooth.h"
#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

std::string text_of(double value) { return format("%.3g", value); }

// Readings and their expected values by sample; empty if unknown.
struct Pair {
  std::vector<double> reading, expected;
};
using Pairs = std::vector<Pair>;  // by joint

// Sums differences from the first value. A constant signal then leaves exactly 0; rounding errors of a sum would look
// like motion.
void remove_mean(std::vector<double>* values) {
  if (values->empty()) return;
  const double first = values->front();
  double sum = 0.0;
  for (double v : *values) sum += v - first;
  for (double& v : *values) v = (v - first) - sum / static_cast<double>(values->size());
}

Pair without_means(Pair pair) {
  remove_mean(&pair.reading);
  remove_mean(&pair.expected);
  return pair;
}

double calc_rms_difference(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size() || a.empty()) return HUGE_VAL;
  double sum = 0.0;
  for (size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

// reading = slope x expected + noise; `fit` is the correlation coefficient.
struct Line {
  double slope = 0.0, fit = 0.0;
};
Line fit_line(const Pair& pair) {
  double xx = 0.0, xy = 0.0, yy = 0.0;
  for (size_t k = 0; k < pair.reading.size(); ++k) {
    xx += pair.expected[k] * pair.expected[k];
    xy += pair.expected[k] * pair.reading[k];
    yy += pair.reading[k] * pair.reading[k];
  }
  if (xx <= 0.0 || yy <= 0.0) return {};
  return {xy / xx, xy / std::sqrt(xx * yy)};
}

bool is_near(double value, double target) { return std::abs(value / target - 1.0) < kDetail; }

// Collects rows whose numbers are all finite, at most about 4000.
Pair collect(size_t count, const std::function<bool(size_t, double*, double*)>& get) {
  Pair pair;
  for (size_t k = 0; k < count; k += 1 + count / 4000) {
    double reading = 0.0, expected = 0.0;
    if (!get(k, &reading, &expected) || !std::isfinite(reading) || !std::isfinite(expected)) continue;
    pair.reading.push_back(reading);
    pair.expected.push_back(expected);
  }
  return pair;
}

// Expectation: positions follow their commands. Means are removed, as an offset is a finding, not a suspicion.
Pair pair_position(const Recording& r, const JointColumns& joint) {
  if (joint.command.empty() || !joint.has(Quantity::kPosition)) return {};
  Pair pair = collect(r.size(), [&](size_t k, double* reading, double* expected) {
    *reading = joint.signal[0][k];
    *expected = joint.command[k];
    return true;
  });
  return without_means(pair);
}

// Expectation: the integral of the velocity over 0.05 s equals the change of position.
Pair pair_velocity(const Recording& r, const JointColumns& joint) {
  if (!joint.has(Quantity::kPosition) || !joint.has(Quantity::kVelocity)) return {};
  const double dt = r.duration() / static_cast<double>(r.size() - 1);
  const size_t span = std::max<size_t>(1, static_cast<size_t>(0.05 / dt));
  if (r.size() <= span + 8) return {};
  return collect(r.size() - span, [&](size_t k, double* reading, double* expected) {
    *expected = joint.signal[0][k + span] - joint.signal[0][k];
    *reading = 0.0;
    for (size_t i = k; i < k + span; ++i)
      *reading += 0.5 * (joint.signal[1][i] + joint.signal[1][i + 1]) * (r.time[i + 1] - r.time[i]);
    return true;
  });
}

// Expectation: logged efforts follow the servo law while it is not at its limit.
Pair pair_effort(const Recording& r, const JointColumns& joint, const ServoGains& gains) {
  if (joint.command.empty() || !joint.has(Quantity::kEffort) || !joint.has(Quantity::kPosition) || gains.kp <= 0.0)
    return {};
  if (gains.kd > 0.0 && (!joint.has(Quantity::kVelocity) || joint.command_rate.empty())) return {};
  return collect(r.size(), [&](size_t k, double* reading, double* expected) {
    *reading = joint.signal[2][k];
    *expected = gains.kp * (joint.command[k] - joint.signal[0][k]);
    if (gains.kd > 0.0) *expected += gains.kd * (joint.command_rate[k] - joint.signal[1][k]);
    return std::abs(*expected) < 0.98 * gains.effort_limit;
  });
}

const char* get_unit_fault(double slope) {
  if (is_near(slope, kDegrees)) return "degrees";
  if (is_near(slope * kDegrees, 1.0)) return "the other is in degrees";
  if (is_near(slope, -1.0)) return "its sign is turned";
  return nullptr;
}

// True if the readings also vary as expected. Constants of joints at rest may be close by chance.
bool varies_with(const std::vector<double>& reading, const std::vector<double>& expected) {
  return reading.size() == expected.size() && fit_line(without_means({reading, expected})).fit > 0.9;
}

// Throws if the reading of each of two joints is that of the other and not its own.
void check_exchange(const Experiment& e, const Recording& r, const Pairs& pairs, Quantity q, const char* expected) {
  for (size_t a = 0; a < pairs.size(); ++a) {
    for (size_t b = a + 1; b < pairs.size(); ++b) {
      const double own_a = calc_rms_difference(pairs[a].reading, pairs[a].expected),
                   own_b = calc_rms_difference(pairs[b].reading, pairs[b].expected);
      const double cross_a = calc_rms_difference(pairs[a].reading, pairs[b].expected),
                   cross_b = calc_rms_difference(pairs[b].reading, pairs[a].expected);
      if (!std::isfinite(own_a) || !std::isfinite(own_b)) continue;
      const bool astray = own_a > 0.5 * calc_rms(pairs[a].expected) && own_b > 0.5 * calc_rms(pairs[b].expected);
      if (!astray || cross_a > 0.3 * own_a || cross_b > 0.3 * own_b) continue;
      if (!varies_with(pairs[a].reading, pairs[b].expected) || !varies_with(pairs[b].reading, pairs[a].expected))
        continue;
      refuse_input(r.find_place(e.signal_name(static_cast<int>(a), q)),
                   std::string("is ") + expected + " of joint " + e.robot.tree.joint(static_cast<int>(b)).name +
                       " rather than its own, and the other way round: are the columns of these two joints exchanged?");
    }
  }
}

// Throws for readings in wrong units. Joints in `sound` are known to have the right units.
void check_units_of(const Experiment& e, const Recording& r, const Pairs& pairs, Quantity q, const char* expected,
                    const std::vector<bool>& sound) {
  for (size_t j = 0; j < pairs.size(); ++j) {
    const Line line = fit_line(pairs[j]);
    if (std::abs(line.fit) < 0.9 || sound[j]) continue;
    const char* fault = get_unit_fault(line.slope);
    if (fault == nullptr) continue;
    refuse_input(r.find_place(e.signal_name(static_cast<int>(j), q)),
                 "is " + text_of(line.slope) + " times " + expected + ": " +
                     (fault[0] == 'd'   ? "degrees instead of rad?"
                      : fault[0] == 't' ? std::string("is ") + expected + " in degrees instead of rad?"
                                        : "is its sign turned?"));
  }
}

// True if the variation has the wrong sign, too. The effort of a joint at rest may only have an offset.
bool is_turned(const Pair& pair) {
  const Line line = fit_line(without_means(pair));
  return line.fit < -0.9 && is_near(line.slope, -1.0);
}

// True if the logged effort is that of the servo, with either sign.
bool follows_law(const Line& line, double sign) { return line.fit * sign > 0.95 && is_near(line.slope, sign); }

// Efforts are in N m whatever unit angles have. With angles in degrees, they are 1/57 of the servo law.
void check_effort_units(const Experiment& e, const Recording& r, const Pairs& pairs) {
  for (size_t j = 0; j < pairs.size(); ++j) {
    const Line line = fit_line(pairs[j]);
    const int joint = static_cast<int>(j);
    if (std::abs(line.fit) < 0.95) continue;
    if (is_near(line.slope * kDegrees, 1.0)) {
      refuse_input(r.find_place(e.signal_name(joint, Quantity::kPosition)),
                   "and its command are too large for the logged effort by " + text_of(1 / line.slope) +
                       " times: degrees instead of rad (or servo gains per degree)?");
    }
    if (is_near(line.slope, -1.0) && is_turned(pairs[j]))
      refuse_input(r.find_place(e.signal_name(joint, Quantity::kEffort)),
                   "is the servo's effort with its sign turned, which it is not in another recording");
    if (is_near(line.slope, 1000.0))
      refuse_input(r.find_place(e.signal_name(joint, Quantity::kEffort)),
                   "is 1000 times the servo's effort: mN m instead of N m?");
  }
}

// Throws if all columns of two joints are exchanged: each effort then follows the law with the other's gains.
void check_exchanged_gains(const Experiment& e, const Recording& r, const Pairs& pairs) {
  const auto gains = [&](size_t j) {
    return get_servo_gains(e.scenario, e.robot.tree.joint(static_cast<int>(j)).name).kp;
  };
  for (size_t a = 0; a < pairs.size(); ++a) {
    for (size_t b = a + 1; b < pairs.size(); ++b) {
      if (pairs[a].reading.empty() || pairs[b].reading.empty()) continue;
      const Line la = fit_line(pairs[a]), lb = fit_line(pairs[b]);
      const double ratio = gains(b) / gains(a);
      // A logged effort follows its law down to the noise. A wrongly logged torque has no other joint with the
      // reciprocal error.
      const bool clear = la.fit > 0.99 && lb.fit > 0.99 && std::abs(std::log(ratio)) > 0.2;
      if (!clear || std::abs(la.slope / ratio - 1) > 0.05 || std::abs(lb.slope * ratio - 1) > 0.05) continue;
      refuse_input(r.find_place(e.signal_name(static_cast<int>(a), Quantity::kEffort)),
                   "obeys the servo gains of joint " + e.robot.tree.joint(static_cast<int>(b)).name +
                       ", and the other way round: are the columns of these two joints exchanged?");
    }
  }
}

// Smallest change that counts. No sensor resolves less, so smaller ones are numerical traces in a column of zeros.
constexpr double kLeastChange = 1e-12;

bool is_still(const std::vector<double>& values) {
  const bool any = std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  return any && calc_range(values) < kLeastChange;
}

// True if the joint's effort is not the same constant in all recordings. A motor that is switched on before the
// recording, or coasts, has a constant effort.
bool changes_between(const Experiment& e, int j) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const Recording& r : e.recordings) {
    for (double effort : r.joints[static_cast<size_t>(j)].signal[static_cast<int>(Quantity::kEffort)]) {
      if (std::isfinite(effort)) {
        low = std::min(low, effort);
        high = std::max(high, effort);
      }
    }
  }
  return high - low >= kLeastChange;
}

// Throws if a position does not change while its command moves by more than a degree: it was not read. Other constant
// columns count as not recorded.
void check_still(Experiment* e, Recording* r, int j) {
  JointColumns& joint = r->joints[static_cast<size_t>(j)];
  const bool moves = calc_range(joint.command) > kHardlyMoved;
  if (moves && is_still(joint.signal[0])) {
    refuse_input(r->find_place(e->signal_name(j, Quantity::kPosition)),
                 "is " + text_of(keep_finite(joint.signal[0]).front()) +
                     " throughout although its command moves: was the encoder read?");
  }
  for (Quantity q : {Quantity::kVelocity, Quantity::kEffort}) {
    std::vector<double>& signal = joint.signal[static_cast<int>(q)];
    if (!is_still(signal) || calc_range(joint.signal[0]) == 0.0) continue;
    if (q == Quantity::kEffort && changes_between(*e, j)) continue;
    const char* advice =
        q == Quantity::kEffort ? "; if the drive did give that, add a recording with another effort" : "";
    e->warnings.push_back(r->spec.name + ": " + e->signal_name(j, q) + " never changes: taken as not recorded" +
                          advice);
    signal.clear();
  }
}

// [rad] Largest angle about one axis by the gyroscope, less its mean rate: that may be its zero.
double calc_turn(const Recording& r, const std::string& gyro) {
  double largest = 0.0;
  for (const char axis : {'x', 'y', 'z'}) {
    const auto at = r.other.find(gyro + "/" + axis);
    if (at == r.other.end()) continue;
    const std::vector<double> read = fill_gaps(at->second);
    const double mean = calc_mean(read);
    std::vector<double> angle{0.0};
    for (size_t k = 1; k < r.size(); ++k)
      angle.push_back(angle.back() + (read[k] - mean) * (r.time[k] - r.time[k - 1]));
    largest = std::max(largest, calc_range(angle));
  }
  return largest;
}

// Drops attitudes that an IMU does not estimate but fills in: always the same although its gyroscope turned.
void drop_still_attitudes(Experiment* e, Recording* r) {
  constexpr double kTurned = 0.05;  // [rad] every estimate shows it, also one of two decimals
  for (const ImuSpec& imu : e->scenario.sensors.imus) {
    const std::string name = "/imu/" + imu.name + "/orientation";
    bool still = true;
    for (const char axis : {'x', 'y', 'z', 'w'}) {
      const auto at = r->other.find(name + "/" + axis);
      still = still && at != r->other.end() && is_still(at->second);
    }
    if (!still || calc_turn(*r, "/imu/" + imu.name + "/angular_velocity") < kTurned) continue;
    e->warnings.push_back(r->spec.name + ": " + name +
                          " never changes although the gyroscope does: taken as not recorded");
    drop_attitude(name, r);
  }
}

std::vector<std::string> list_columns(const Recording& r, const std::string& sensor) {
  std::vector<std::string> columns;
  for (const auto& [column, values] : r.other) {
    if (column.compare(0, sensor.size() + 1, sensor + "/") == 0) columns.push_back(column);
  }
  return columns;
}

// True if a sensor of the body repeats one reading throughout although the joints move. Logs of dead ones look like
// that: it would turn at one rate all the time. Zeros of a force are those of a foot in the air, unless `zeros`.
bool is_dead(const Recording& r, const std::string& sensor, bool zeros) {
  const auto moves = [](const JointColumns& joint) { return calc_range(joint.signal[0]) > kHardlyMoved; };
  if (std::none_of(r.joints.begin(), r.joints.end(), moves)) return false;
  bool still = true, zero = true;
  const std::vector<std::string> columns = list_columns(r, sensor);
  for (const std::string& column : columns) {
    const std::vector<double>& values = r.other.at(column);
    still = still && is_still(values);
    zero = zero && find_largest(values) == 0.0;
  }
  return !columns.empty() && still && (zeros || !zero);
}

// True if the other recordings have the sensor, and can be fitted and, if there was one, held out without those.
bool can_spare(const std::vector<Recording>& recordings, const std::vector<bool>& dead, const std::string& sensor) {
  bool train = false, held_out = false, was_held_out = false;
  for (size_t i = 0; i < recordings.size(); ++i) {
    const Recording& r = recordings[i];
    was_held_out = was_held_out || !r.spec.train;
    if (dead[i]) continue;
    if (list_columns(r, sensor).empty()) return false;
    train = train || r.spec.train;
    held_out = held_out || !r.spec.train;
  }
  return train && (held_out || !was_held_out);
}

// The diagnosis uses a sensor that all recordings have. So that one dead log does not cost it in all of them, the
// recordings in which it is dead are left out. If too few would be left, the sensor goes.
void drop_still_sensor(Experiment* e, const std::string& sensor, bool zeros) {
  std::vector<bool> dead;
  for (const Recording& r : e->recordings) dead.push_back(is_dead(r, sensor, zeros));
  if (std::find(dead.begin(), dead.end(), true) == dead.end()) return;
  const bool spare = can_spare(e->recordings, dead, sensor);
  const char* const consequence = spare                      ? "this recording is left out, so that the others keep it"
                                  : e->recordings.size() > 1 ? "taken as not recorded, also in the other recordings"
                                                             : "taken as not recorded";
  std::vector<Recording> kept;
  for (size_t i = 0; i < dead.size(); ++i) {
    Recording& r = e->recordings[i];
    if (dead[i]) {
      e->warnings.push_back(r.spec.name + ": " + sensor + " never changes although the joints move: " + consequence);
      for (const std::string& column : list_columns(r, sensor)) r.other.erase(column);
    }
    if (!dead[i] || !spare) kept.push_back(std::move(r));
  }
  e->recordings = std::move(kept);
}

void drop_still_sensors(Experiment* e) {
  if (!e->scenario.floating_base) return;
  for (const ImuSpec& imu : e->scenario.sensors.imus) drop_still_sensor(e, "/imu/" + imu.name, true);
  for (const WrenchSpec& wrench : e->scenario.sensors.wrenches) drop_still_sensor(e, "/wrench/" + wrench.name, false);
}

void check_commands(const Experiment& e, const Recording& r, int j) {
  const JointSpec& spec = e.robot.tree.joint(j);
  if (e.scenario.drive != "servo" || e.scenario.floating_base || !spec.actuated) return;
  if (get_servo_gains(e.scenario, e.robot.tree.joint(j).name).kp <= 0.0 ||
      !r.joints[static_cast<size_t>(j)].command.empty())
    return;
  refuse_input(r.find_place("/joint_commands/" + spec.name + "/position"),
               "is missing: the servo of this joint follows it (is the drive 'effort' or 'motion'?)");
}

}  // namespace

std::vector<int> list_turned_by_law(const Experiment& e) {
  std::vector<int> list;
  for (int j = 0; j < e.num_joints(); ++j) {
    const ServoGains gains = get_servo_gains(e.scenario, e.robot.tree.joint(j).name);
    bool turned = false, right = false;
    for (const Recording& r : e.recordings) {
      const Pair pair = pair_effort(r, r.joints[static_cast<size_t>(j)], gains);
      const Line line = fit_line(pair);
      turned = turned || (follows_law(line, -1.0) && is_turned(pair));
      right = right || follows_law(line, 1.0);
    }
    if (turned && !right) list.push_back(j);
  }
  return list;
}

void check_plausibility(Experiment* e) {
  const std::vector<int> turned = list_turned_by_law(*e);
  for (Recording& r : e->recordings) {
    Pairs position, velocity, effort;
    for (int j = 0; j < e->num_joints(); ++j) {
      check_still(e, &r, j);
      check_commands(*e, r, j);
      const JointColumns& joint = r.joints[static_cast<size_t>(j)];
      position.push_back(pair_position(r, joint));
      velocity.push_back(pair_velocity(r, joint));
      effort.push_back(pair_effort(r, joint, get_servo_gains(e->scenario, e->robot.tree.joint(j).name)));
    }
    // A leg whose foot sticks to the ground may follow 1/57 of its command. Its effort then still follows the servo
    // law.
    std::vector<bool> sound, none(effort.size(), false);
    for (const Pair& pair : effort) sound.push_back(follows_law(fit_line(pair), 1.0));
    check_units_of(*e, r, position, Quantity::kPosition, "the command", sound);
    check_units_of(*e, r, velocity, Quantity::kVelocity, "the rate of the position", none);
    check_exchange(*e, r, position, Quantity::kPosition, "the motion");
    check_exchange(*e, r, velocity, Quantity::kVelocity, "the rate");
    for (int j : turned) effort[static_cast<size_t>(j)] = {};  // told as a finding
    check_exchange(*e, r, effort, Quantity::kEffort, "the servo's effort");
    check_effort_units(*e, r, effort);
    check_exchanged_gains(*e, r, effort);
    for (int j = 0; j < e->num_joints(); ++j) {
      check_limits(*e, r, j);
      check_commanded_limits(e, r, j);
    }
    drop_still_attitudes(e, &r);
  }
  drop_still_sensors(e);
}

}  // namespace hrp::diagnosis
