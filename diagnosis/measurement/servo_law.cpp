// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/servo_law.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/data/command_reader.h"
#include "diagnosis/data/held_out.h"
#include "diagnosis/data/mean.h"
#include "diagnosis/data/noise.h"
#include "diagnosis/data/range.h"
#include "diagnosis/data/smooth.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/gram.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/estimate/slopes.h"
#include "diagnosis/measurement/law_rest.h"
#include "diagnosis/measurement/servo_rates.h"
#include "diagnosis/measurement/servo_slope.h"
#include "diagnosis/measurement/torque/term_rows.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {
namespace {

bool has_all(const Experiment& e, size_t j) {
  return std::all_of(e.recordings.begin(), e.recordings.end(), [&](const Recording& r) {
    const JointColumns& c = r.joints[j];
    return !c.command.empty() && c.has(Quantity::kPosition) && c.has(Quantity::kEffort);
  });
}

constexpr double kSmooth = 0.015;  // [s] half the smoothing window of a rate that was not recorded

// Rate of the position smoothed over +- `window` [s].
std::vector<double> calc_rate(const Recording& r, size_t j, double window) {
  const JointColumns& c = r.joints[j];
  const double step = r.duration() / static_cast<double>(std::max<size_t>(2, r.size()) - 1);
  std::vector<double> value, rate, second;
  smooth_series(r.time, fill_gaps(c.signal[0]), std::max(3, static_cast<int>(std::lround(window / step))), &value,
                &rate, &second);
  return rate;
}

// Velocity that the servo uses: recorded, else the rate of the position.
std::vector<double> find_rate(const Recording& r, size_t j, double window) {
  const JointColumns& c = r.joints[j];
  return c.has(Quantity::kVelocity) ? c.signal[1] : calc_rate(r, j, window);
}

// A joint's log and its servo.
struct ServoLog {
  const Experiment& e;
  size_t j;
  const JointLaws& laws;
  std::vector<std::vector<double>> rates;  // by recording

  ServoLog(const Experiment& experiment, size_t joint, const JointLaws& of) : e(experiment), j(joint), laws(of) {
    for (const Recording& r : e.recordings) rates.push_back(find_rate(r, j, kSmooth));
  }

  // The same with rates of positions that are smoothed over +- `window` [s].
  ServoLog smooth_rates(double window) const {
    ServoLog out = *this;
    for (size_t i = 0; i < rates.size(); ++i) out.rates[i] = calc_rate(e.recordings[i], j, window);
    return out;
  }

  // The same with rates that come `late` [s].
  ServoLog delay_rates(double late) const {
    ServoLog out = *this;
    for (size_t i = 0; i < rates.size(); ++i) move_series(e.recordings[i].time, -late, &out.rates[i]);
    return out;
  }

  bool has_rates() const {
    return std::all_of(e.recordings.begin(), e.recordings.end(),
                       [&](const Recording& r) { return r.joints[j].has(Quantity::kVelocity); });
  }

  // Calls take(law, effort, position, recording, damping) at every sample of the training (or of the other) recordings
  // that commands with this `delay` [s] cover. `law`: effort by the servo law before its limit [N m]; `damping`: its
  // part by rates.
  template <typename Take>
  void walk(double delay, bool train, const Take& take) const {
    for (size_t i = 0; i < e.recordings.size(); ++i) {
      const Recording& r = e.recordings[i];
      if (r.spec.train != train) continue;
      const JointColumns& c = r.joints[j];
      for (size_t k = 0; k < r.size(); ++k) {
        if (r.time[k] < r.time.front() + kLongest) continue;
        double given = 0.0, rate = 0.0;
        read_command(r.time, c, r.time[k] - delay, k, &given, &rate);
        take(calc_servo_effort(laws, given - c.signal[0][k], rate - rates[i][k], 0.0), c.signal[2][k], c.signal[0][k],
             i, laws.kd * (rate - rates[i][k]));
      }
    }
  }
};

// Mean square [(N m)^2] of the law's residual with commands `delay` [s] late.
double calc_missed(const ServoLog& log, double delay, bool train) {
  double sum = 0.0, n = 0.0;
  log.walk(delay, train, [&](double law, double effort, double, size_t, double) {
    const double missed = effort - std::clamp(law, -log.laws.effort_limit, log.laws.effort_limit);
    if (std::isfinite(missed)) {
      sum += missed * missed;
      n += 1.0;
    }
  });
  return n > 0.0 ? sum / n : 0.0;
}

// Sums of effort over law and a constant, with commands `delay` [s] late, by parts of the training samples.
std::vector<Gram> sum_parts(const ServoLog& log, double delay, size_t parts) {
  std::vector<Eigen::Vector2d> pairs;
  log.walk(delay, true, [&](double law, double effort, double, size_t, double) {
    if (std::isfinite(law + effort))
      pairs.emplace_back(std::clamp(law, -log.laws.effort_limit, log.laws.effort_limit), effort);
  });
  std::vector<Gram> grams(parts, Gram(2));
  for (size_t k = 0; k < pairs.size(); ++k)
    grams[k * parts / pairs.size()].add_row(Eigen::Vector2d(pairs[k][0], 1.0), pairs[k][1]);
  return grams;
}

double calc_missed(const Gram& gram) {
  return gram.n > 0.0 ? calc_rest(gram, {0, 1}, solve(gram, {0, 1})) / gram.n : 0.0;
}

// The same with the best scale and bias of the log, because a wrong scale would bias the delay.
double calc_missed_by_line(const ServoLog& log, double delay) { return calc_missed(sum_parts(log, delay, 1)[0]); }

// Standard error [s] of the best delay: from its spread between parts of the recordings, and from the unknown commands
// between samples.
double find_delay_error(const ServoLog& log, double delay) {
  const std::vector<Gram> before = sum_parts(log, delay - kTimeStep, kFewestBlocks),
                          at = sum_parts(log, delay, kFewestBlocks),
                          after = sum_parts(log, delay + kTimeStep, kFewestBlocks);
  Spread spread;
  for (size_t i = 0; i < kFewestBlocks; ++i) {
    const double left = calc_missed(before[i]), middle = calc_missed(at[i]), right = calc_missed(after[i]);
    const double vertex = calc_vertex(left, middle, right);
    spread.add(kTimeStep * (vertex != 0.0 || (middle < left && middle < right) ? vertex : left < right ? -1.0 : 1.0));
  }
  // Interpolated commands are a detail of a step off.
  return std::hypot(spread.get() / std::sqrt(kFewestBlocks - 1.0), kDetail * log.e.sample_time);
}

// Minimum of f on a grid from 0 to `end`, refined by a parabola through its neighbours.
template <typename F>
double find_least(const F& f, double step, double end) {
  double best = f(0.0), at = 0.0;
  for (double d = step; d <= end; d += step) {
    const double m = f(d);
    if (m < best) {
      best = m;
      at = d;
    }
  }
  return at + step * calc_vertex(f(at - step), best, f(at + step));
}

double calc_spread(const Experiment& e, size_t j) {
  Spread spread;
  for (const Recording& r : e.recordings) {
    for (double y : r.joints[j].signal[2]) spread.add(y);
  }
  return spread.get();
}

ServoPairs list_pairs(const ServoLog& log, double delay) {
  ServoPairs out;
  log.walk(delay, true, [&](double law, double effort, double position, size_t recording, double damping) {
    if (!std::isfinite(law + effort) || std::abs(law) >= log.laws.effort_limit) return;
    out.law.push_back(law);
    out.effort.push_back(effort);
    out.position.push_back(position);
    out.damping.push_back(damping);
    out.recording.push_back(recording);
  });
  return out;
}

// y = theta[0] x + theta[1], with robust standard deviations.
struct Line {
  Eigen::VectorXd theta, std;
};

Line fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<Gram> folds(kFolds, Gram(2));
  for (size_t k = 0; k < x.size(); ++k) folds[k * kFolds / x.size()].add_row(Eigen::Vector2d(x[k], 1.0), y[k]);
  const Gram total = sum(folds, 2);
  Line line{solve(total, {0, 1}), {}};
  line.std = calc_covariance(folds, total, {0, 1}, line.theta).diagonal().cwiseMax(0.0).cwiseSqrt();
  return line;
}

double calc_rms(const ServoPairs& pairs, double scale, double bias) {
  double sum = 0.0;
  for (size_t k = 0; k < pairs.law.size(); ++k) sum += std::pow(pairs.effort[k] - scale * pairs.law[k] - bias, 2);
  return std::sqrt(sum / static_cast<double>(std::max<size_t>(1, pairs.law.size())));
}

// Correlated part of the line's residual [N m].
double calc_wavers(const ServoPairs& pairs, double scale, double bias) {
  const auto left = [&](size_t k) { return pairs.effort[k] - scale * pairs.law[k] - bias; };
  double sum = 0.0;
  for (size_t k = kLaterSamples; k < pairs.law.size(); ++k) sum += left(k) * left(k - kLaterSamples);
  return std::sqrt(std::max(0.0, sum) / static_cast<double>(std::max<size_t>(1, pairs.law.size() - kLaterSamples)));
}

// Adds uncertainties to the slope: of the delay, and of the rates. If the velocity was logged `late` [s], the servo may
// use that velocity or a sharper one. Late damping pushes with the acceleration, so it looks like stiffness. If no
// velocity was logged, positions show its mean between two samples. A servo that gets held commands jerks at each of
// them, and damps with the velocity of an instant. Stiffness and damping nearly cancel while a joint follows its
// command: an error of 1 % in the damping may be a tenth of the effort.
ServoSlope find_slope(const ServoLog& log, const ServoPairs& pairs, const ServoDelay& delay, double late) {
  ServoSlope slope = find_slope(pairs);
  const auto add_doubt = [&](const ServoLog& other, double of_command) {
    slope.std = std::hypot(slope.std, slope.value - find_slope(list_pairs(other, of_command)).value);
  };
  // A window of twice the width shows the effect of smoothing.
  add_doubt(log.smooth_rates(log.has_rates() ? kSmooth : 2.0 * kSmooth), delay.delay);
  if (late > 0.0) add_doubt(log.delay_rates(late), delay.delay);
  if (!log.has_rates()) slope.std = std::hypot(slope.std, slope.value - find_slope_beside_damping(pairs));
  if (delay.delay > 0.0) add_doubt(log, delay.delay + find_delay_error(log, delay.delay));
  return slope;
}

// [N m] Standard deviation of what the encoder's rounding does to the mean of the law. Rounding is a function of the
// position: samples within one step share their error, so a joint that is held has one or two.
double calc_rounding(const ServoLog& log, const ServoPairs& pairs) {
  const double step = find_encoder_step(log.e, log.j);
  if (!(step > 0.0)) return 0.0;
  std::map<long, double> count;
  for (double q : pairs.position) count[std::lround(q / step)] += 1.0;
  double squares = 0.0;
  for (const auto& [cell, n] : count) squares += n * n;
  const double positions = std::pow(static_cast<double>(pairs.position.size()), 2) / squares;
  return log.laws.kp * step / std::sqrt(12.0 * positions);
}

// [N m] Standard deviation of a bias from its differences between recordings, beyond noise: a zero of a log is the same
// in all.
double calc_disagreement(const ServoPairs& pairs, double scale) {
  std::vector<double> means, variances;
  for (size_t begin = 0, end = 0; begin < pairs.law.size(); begin = end) {
    while (end < pairs.law.size() && pairs.recording[end] == pairs.recording[begin]) ++end;
    Eigen::VectorXd off(static_cast<long>(end - begin));
    for (size_t k = begin; k < end; ++k) off[static_cast<long>(k - begin)] = pairs.effort[k] - scale * pairs.law[k];
    const double mean = off.mean(), n = static_cast<double>(off.size());
    off.array() -= mean;
    means.push_back(mean);
    variances.push_back(calc_correlation_time(off) * off.squaredNorm() / (n * n));
  }
  if (means.size() < 2) return 0.0;
  return std::sqrt(calc_variance_between(means, variances) / static_cast<double>(means.size()));
}

double calc_deviation(const std::vector<double>& x) {
  Spread spread;
  for (double value : x) spread.add(value);
  return spread.get();
}

ServoReading read_servo(const ServoLog& log, const ServoDelay& late, double late_rates, double spread) {
  ServoReading out;
  const ServoPairs pairs = list_pairs(log, late.delay);
  if (pairs.law.size() < kLeastServoSamples) return out;
  Line line = fit_line(pairs.law, pairs.effort);
  ServoSlope slope = find_slope(log, pairs, late, late_rates);
  const double rounding = calc_rounding(log, pairs);
  slope.std = std::hypot(slope.std, rounding / std::max(1e-300, calc_deviation(pairs.law)));
  line.std[1] = std::hypot(line.std[1], rounding);
  const double off = slope.value - 1.0, offset = calc_mean(pairs.effort) - slope.value * calc_mean(pairs.law);
  out.before = calc_rms(pairs, 1.0, 0.0);
  out.after = calc_rms(pairs, slope.value, offset);
  out.wavers = calc_wavers(pairs, slope.value, offset);
  // Noise of encoders in the law is no disagreement: a stiff servo makes newton metres of a count.
  if (!(out.wavers < kMuch * calc_deviation(pairs.effort)) || !(slope.value > 0.0)) return out;
  out.slope = slope.value;
  if (!(slope.value > 0.5 && slope.value < 2.0)) return out;
  out.follows = true;
  if (std::abs(off) > std::max(kTrace, kSignificantInJoint * slope.std)) {
    out.scale = slope.value;
    out.scale_std = std::hypot(slope.std, kAgreement);
  }
  // Bias beside the accepted scale. Noise of the law reduces the slope of a plain line, which would look like a bias. A
  // scale that is not significant looks like one, too, where the weight gives the law a mean: the bias beside that
  // scale counts as well.
  const double bias = calc_mean(pairs.effort) - out.scale * calc_mean(pairs.law);
  line.std[1] = std::hypot(line.std[1], calc_disagreement(pairs, out.scale));
  if (std::min(std::abs(bias), std::abs(offset)) > std::max(kTrace * spread, kSignificantInJoint * line.std[1])) {
    out.bias = bias;
    out.bias_std = std::hypot(line.std[1], kAgreement * spread);
  }
  return out;
}

// None: no delay.
ServoDelay find_delay(const std::vector<ServoDelay>& delays, size_t joint) {
  ServoDelay late;
  for (const ServoDelay& d : delays) late = d.joint == static_cast<int>(joint) ? d : late;
  return late;
}

}  // namespace

LawRest list_law_rest(const Experiment& e, int joint, const std::vector<ServoDelay>& late) {
  LawRest out;
  const size_t j = static_cast<size_t>(joint);
  if (e.scenario.drive != "servo" || !has_all(e, j)) return out;
  const Plant plant = make_plant(e, {});
  if (!(plant.laws[j].kp > 0.0)) return out;
  ServoPairs pairs = list_pairs({e, j, plant.laws[j]}, find_delay(late, j).delay);
  if (pairs.law.size() < kLeastServoSamples) return out;
  const Line line = fit_line(pairs.law, pairs.effort);
  out.spread = calc_deviation(pairs.effort);
  for (size_t k = 0; k < pairs.law.size(); ++k)
    out.torque.push_back(pairs.effort[k] - line.theta[0] * pairs.law[k] - line.theta[1]);
  out.position = std::move(pairs.position);
  out.recording = std::move(pairs.recording);
  return out;
}

bool LawRest::follows_but_for(const Eigen::VectorXd& part) const {
  const auto left = [&](size_t k) { return torque[k] - part[static_cast<long>(k)]; };
  double sum = 0.0;
  for (size_t k = kLaterSamples; k < torque.size(); ++k) sum += left(k) * left(k - kLaterSamples);
  return sum < std::pow(kMuch * spread, 2) * static_cast<double>(torque.size());
}

std::vector<ServoReading> find_servo_readings(const Experiment& e, const std::vector<ServoDelay>& delays,
                                              const std::vector<VelocityReading>& velocity) {
  std::vector<ServoReading> list(static_cast<size_t>(e.num_joints()));
  if (e.scenario.drive != "servo") return list;
  const Plant plant = make_plant(e, {});
  for (size_t j = 0; j < plant.laws.size(); ++j) {
    if (!has_all(e, j) || !(plant.laws[j].kp > 0.0)) continue;
    list[j] = read_servo({e, j, plant.laws[j]}, find_delay(delays, j), velocity[j].late, calc_spread(e, j));
    list[j].travel = calc_position_range(e, j);
  }
  return list;
}

std::vector<ServoReading> find_servo_readings(const Experiment& e, const std::vector<ServoDelay>& delays) {
  return find_servo_readings(e, delays, std::vector<VelocityReading>(static_cast<size_t>(e.num_joints())));
}

std::vector<ServoDelay> find_servo_delays(const Experiment& e) {
  std::vector<ServoDelay> list;
  if (e.scenario.drive != "servo") return list;
  const Plant plant = make_plant(e, {});
  const bool held = has_held_out(e.recordings);
  for (size_t j = 0; j < plant.laws.size(); ++j) {
    if (!has_all(e, j) || !(plant.laws[j].kp > 0.0)) continue;
    const ServoLog log(e, j, plant.laws[j]);
    const double delay = find_least([&](double d) { return calc_missed_by_line(log, d); }, kTimeStep, kLongest);
    const double best = calc_missed(log, delay, true);
    if (!(calc_missed(log, 0.0, true) > kSeveralTimes * kSeveralTimes * best) ||
        std::sqrt(best) > kMuch * calc_spread(e, j))
      continue;
    ServoDelay found{static_cast<int>(j), delay, 0.5 * std::min(kTimeStep, e.sample_time), 0.0, 0.0};
    found.before = std::sqrt(calc_missed(log, 0.0, !held));
    found.after = std::sqrt(calc_missed(log, delay, !held));
    list.push_back(found);
  }
  return list;
}

}  // namespace hrp::diagnosis
