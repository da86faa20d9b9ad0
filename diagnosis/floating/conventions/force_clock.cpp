// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/force_clock.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/robust.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/checks/imu_over_legs.h"
#include "diagnosis/floating/conventions/frame_search.h"
#include "diagnosis/floating/equations/body_sample.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/log/contacts.h"
#include "diagnosis/floating/log/foot_sensors.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

struct Told {
  double value = 0, std = 0;  // [s]
};

// Sums of products of what feet feel and what the motion takes.
struct Products {
  double ff = 0, fn = 0, nn = 0, count = 0;
  void add(const Products& o, double sign = 1) {
    ff += sign * o.ff;
    fn += sign * o.fn;
    nn += sign * o.nn;
    count += sign * o.count;
  }
  // Share of the forces' square that is left beside a factor, which scales of sensors and a body that shakes make; none
  // is negative.
  double find_left() const { return 1 - (fn > 0 && nn > 0 ? fn * fn / nn / ff : 0.0); }
};

using Curve = std::vector<Products>;  // by shift

struct Block {
  int recording = 0;
  Curve curve;
};

size_t count_shifts() { return 2 * static_cast<size_t>(std::lround(kNearForce / kClockStep)) + 1; }
double get_shift(double i) { return -kNearForce + kClockStep * i; }
size_t find_nearest(double shift) { return static_cast<size_t>(std::lround((shift + kNearForce) / kClockStep)); }

// Less its mean over a block about each stamp: slower differences are scales and zeros.
std::vector<double> drop_slow(const std::vector<double>& v, double step) {
  const auto half = static_cast<long>(std::lround(0.5 * kBlock / step)), n = static_cast<long>(v.size());
  std::vector<double> out(v.size(), std::numeric_limits<double>::quiet_NaN());
  for (long k = half; k + half < n; ++k) {
    double sum = 0;
    for (long i = k - half; i <= k + half; ++i) sum += v[static_cast<size_t>(i)];
    out[static_cast<size_t>(k)] = v[static_cast<size_t>(k)] - sum / static_cast<double>(2 * half + 1);
  }
  return out;
}

// The force of the feet that are shifted, and that of the others.
std::vector<double> sum_feet(const PressedStretch& s, std::optional<size_t> foot, bool shifted) {
  std::vector<double> out(s.needed.size(), 0.0);
  for (size_t f = 0; f < s.force.size(); ++f) {
    const bool is_shifted = !foot || f == *foot;
    for (size_t k = 0; k < out.size() && is_shifted == shifted; ++k) out[k] += s.force[f][k];
  }
  return out;
}

void add_blocks(const PressedStretch& s, std::optional<size_t> foot, std::vector<Block>* out) {
  const std::vector<double> force = drop_slow(sum_feet(s, foot, true), s.step),
                            rest = drop_slow(sum_feet(s, foot, false), s.step), needed = drop_slow(s.needed, s.step);
  const auto reach = static_cast<size_t>(std::ceil(kNearForce / s.step)),
             length = static_cast<size_t>(std::lround(kBlock / s.step));
  for (size_t begin = reach; begin + length + reach < force.size(); begin += length) {
    Block block{s.recording, Curve(count_shifts())};
    for (size_t i = 0; i < block.curve.size(); ++i) {
      Products& p = block.curve[i];
      for (size_t k = begin; k < begin + length; ++k) {
        const double f = rest[k] + calc_between(force.data(), force.size(),
                                                static_cast<double>(k) + get_shift(static_cast<double>(i)) / s.step),
                     m = needed[k];
        if (std::isfinite(f) && std::isfinite(m)) p.add({f * f, f * m, m * m, 1});
      }
    }
    if (std::all_of(block.curve.begin(), block.curve.end(), [](const Products& p) { return p.count > 0; }))
      out->push_back(std::move(block));
  }
}

using Sums = std::map<int, Curve>;  // by recording

Sums sum_blocks(const std::vector<Block>& blocks) {
  Sums out;
  for (const Block& b : blocks) {
    Curve& sum = out.try_emplace(b.recording, Curve(count_shifts())).first->second;
    for (size_t i = 0; i < sum.size(); ++i) sum[i].add(b.curve[i]);
  }
  return out;
}

// Log of what is left, of errors whose size each recording has of its own: one that tells nothing is flat.
double calc_cost(const Sums& sums, size_t shift) {
  double cost = 0;
  for (const auto& [recording, curve] : sums)
    cost += curve[shift].count * std::log(std::max(1e-300, curve[shift].find_left()));
  return cost;
}

// [s] The shift that leaves least, between the tried ones by a parabola. NaN: at an end.
double find_best(const Sums& sums) {
  std::vector<double> cost;
  for (size_t i = 0; i < count_shifts(); ++i) cost.push_back(calc_cost(sums, i));
  const auto best = static_cast<size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  if (best == 0 || best + 1 == cost.size()) return std::numeric_limits<double>::quiet_NaN();
  return get_shift(static_cast<double>(best) + calc_vertex(cost[best - 1], cost[best], cost[best + 1]));
}

// [s] Of the best shift without one block at a time (jackknife): errors of different blocks are independent.
double find_spread(const std::vector<Block>& blocks, double best, Sums sums) {
  double square = 0;
  for (const Block& b : blocks) {
    Curve& own = sums.at(b.recording);
    for (size_t i = 0; i < own.size(); ++i) own[i].add(b.curve[i], -1);
    square += std::pow(find_best(sums) - best, 2);
    for (size_t i = 0; i < own.size(); ++i) own[i].add(b.curve[i]);
  }
  const auto n = static_cast<double>(blocks.size());
  return std::sqrt(square * (n - 1) / n) * find_widening(blocks.size());
}

// NaN where the best shift lies at an end, with or without some block.
Told find_shift(const std::vector<Block>& blocks) {
  const Sums sums = sum_blocks(blocks);
  const double best = find_best(sums);
  return {best, blocks.size() > 1 ? find_spread(blocks, best, sums) : std::numeric_limits<double>::quiet_NaN()};
}

// The shifts of the recordings that tell one to half of `shift` [s]: one without motion knows nothing.
std::vector<Told> list_told(const std::vector<Block>& blocks, double shift) {
  std::map<int, std::vector<Block>> each;
  for (const Block& b : blocks) each[b.recording].push_back(b);
  std::vector<Told> told;
  for (const auto& [recording, own] : each) {
    const Told t = find_shift(own);
    if (t.std > 0 && t.std < kHalf * std::abs(shift)) told.push_back(t);
  }
  return told;
}

bool is_same_everywhere(const std::vector<Told>& told, double shift) {
  return std::all_of(told.begin(), told.end(),
                     [&](const Told& t) { return t.value / shift > 0.5 && t.value / shift < 2; });
}

// [s] By how much recordings differ beyond their own errors, as an error of the mean of all (Birge's ratio).
double find_difference(const std::vector<Told>& told) {
  double weight = 0, mean = 0, square = 0;
  for (const Told& t : told) {
    weight += 1 / (t.std * t.std);
    mean += t.value / (t.std * t.std);
  }
  if (told.size() < 2) return 0;
  mean /= weight;
  for (const Told& t : told) square += std::pow((t.value - mean) / t.std, 2);
  const double ratio = square / static_cast<double>(told.size() - 1);
  return ratio > 1 ? std::sqrt(ratio / weight) : 0;
}

// Share of the forces' squares that follows the motion at a shift, recordings by what they know.
double find_agreement(const Sums& sums, double shift) {
  const size_t at = find_nearest(shift);
  double left = 0, all = 0;
  for (const auto& [recording, curve] : sums) {
    left += curve[at].ff * curve[at].find_left();
    all += curve[at].ff;
  }
  return 1 - left / std::max(1e-300, all);
}

double calc_nats(const std::vector<Block>& blocks, const Sums& sums, double shift) {
  const size_t at = find_nearest(shift);
  double nats = 0;
  for (const Block& b : blocks) nats -= 0.5 * std::log(std::max(1e-300, sums.at(b.recording)[at].find_left()));
  return nats;
}

ForceClock find_clock(const std::vector<PressedStretch>& stretches, std::optional<size_t> foot, double sample_time) {
  std::vector<Block> blocks;
  for (const PressedStretch& s : stretches) add_blocks(s, foot, &blocks);
  if (blocks.size() < kFewestBlocks) return {};
  const Told all = find_shift(blocks);
  if (!std::isfinite(all.std)) return {};
  const Sums sums = sum_blocks(blocks);
  const std::vector<Told> told = list_told(blocks, all.value);
  ForceClock out{foot,
                 all.value,
                 std::hypot(all.std, find_difference(told)),
                 find_agreement(sums, all.value),
                 find_agreement(sums, 0),
                 calc_nats(blocks, sums, all.value),
                 false,
                 {}};
  const bool sure = std::abs(all.value) > std::max(kUnlikely * all.std, kHalf * sample_time);
  out.found = sure && !told.empty() && is_same_everywhere(told, all.value) &&
              1 - out.agreement < kNearlyAll * (1 - out.as_logged);
  return out;
}

// Every foot has a sensor of the vertical force alone. Whole force sensors are late one by one: the search finds which.
bool is_felt(const LeggedLog& log) { return !log.feet.empty() && log.tree.floating_base && all_feel_it_alone(log); }

PressedStretch press(const LeggedLog& log, size_t c) {
  const Clip& clip = log.clips[c];
  PressedStretch out{
      static_cast<int>(clip.recording), clip.step, std::vector<std::vector<double>>(log.feet.size()), {}};
  BodyMotion motion(log, clip);
  Eigen::VectorXd tau(motion.model().nv());
  for (size_t k = clip.edge; k + clip.edge < clip.size(); ++k) {
    for (size_t f = 0; f < log.feet.size(); ++f)
      out.force[f].push_back(calc_vertical_force(log, clip, static_cast<size_t>(log.feet[f].sensor), k));
    out.needed.push_back(std::numeric_limits<double>::quiet_NaN());
    if (!motion.update(k)) continue;
    calc_inverse_dynamics(motion.model(), motion.vdot(), nullptr, &motion.data(), &tau);
    const BodySample at{log, clip, c, k, motion};
    out.needed.back() = find_normal(at).dot(tau.segment<3>(3) - calc_force_below(at));
  }
  return out;
}

// [nats] Odds that the IMU has the encoders' clock against that it is ahead of it as it is ahead of the forces.
double ask_encoders(const LeggedLog& log, size_t imu, double ahead) {
  const std::vector<Standing> standing = list_standing(log, imu, Purpose::kForClocks);
  if (standing.empty()) return 0;
  return calc_odds(list_instants(standing), list_left(log, imu, standing, {}),
                   list_left(log, imu, standing, {{}, {-ahead, 0}, 1}));
}

std::string name_feet(const LeggedLog& log, std::optional<size_t> foot) {
  if (!foot) return "/wrench";
  return "/wrench/" + log.sensors[static_cast<size_t>(log.feet[*foot].sensor)].name + "/force";
}

std::string describe_clock(const LeggedLog& log, const ForceClock& clock) {
  const std::string size = format(" %.0f +- %.0f ms late", 1e3 * std::abs(clock.late), 1e3 * kNinetyFive * clock.std);
  const std::string whose =
      clock.foot ? "The force of " + log.feet[*clock.foot].name + " follows" : "The feet's forces follow";
  const std::string text = (clock.late > 0 ? whose + " the acceleration of the body"
                                           : "The acceleration of the body follows the feet's forces") +
                           size;
  return text + format(": so shifted, %.0f %% of their changes within half a second are the same, not %.0f %%.",
                       100 * clock.agreement, 100 * clock.as_logged);
}

}  // namespace

ForceClock find_force_clock(const std::vector<PressedStretch>& stretches, double sample_time) {
  std::vector<ForceClock> all{find_clock(stretches, std::nullopt, sample_time)};
  const size_t feet = stretches.empty() ? 0 : stretches[0].force.size();
  for (size_t foot = 0; foot < feet && feet > 1; ++foot) all.push_back(find_clock(stretches, foot, sample_time));
  // One foot that is ahead is the others' delay, of which there may be several.
  all.erase(
      std::remove_if(all.begin(), all.end(), [](const ForceClock& c) { return !c.found || (c.foot && c.late < 0); }),
      all.end());
  if (all.empty()) return {};
  std::stable_sort(all.begin(), all.end(), [](const ForceClock& a, const ForceClock& b) { return a.nats > b.nats; });
  ForceClock best = all[0];
  for (size_t i = 1; i < all.size() && all[i].nats > best.nats - kOdds; ++i) best.rivals.push_back(all[i]);
  return best;
}

std::vector<PressedStretch> list_pressed(const LeggedLog& log, MotionSource source) {
  std::vector<PressedStretch> out;
  const MotionSource known = BodyMotion::find_force_source(log);
  if (!is_felt(log) || known == MotionSource::kNone || (source != MotionSource::kNone && known != source)) return out;
  for (size_t c = 0; c < log.clips.size(); ++c) out.push_back(press(log, c));
  return out;
}

Finding make_clock_finding(const LeggedLog& log, const ForceClock& clock) {
  const EffectInfo& effect = get_laws().sensor_delay.info();
  const auto main = static_cast<size_t>(BodyMotion::find_main_imu(log));
  const std::string imu = "/imu/" + log.imus[main].name;
  const double odds = ask_encoders(log, main, clock.late);
  const auto value = [&](const ForceClock& c) {
    return std::vector<Estimate>{make_value(effect, std::abs(c.late), c.std)};
  };
  const auto add = [&](const std::string& sensor, const ForceClock& c, Finding* f) {
    f->alternatives.push_back(make_alternative(effect, {{"sensor", sensor}}, value(c),
                                               "a jolt that all sensors feel, with the robot hung up"));
  };
  const bool forces = clock.late > 0, all = !clock.foot;
  // Encoders that agree with the IMU leave the other of the two. Encoders that agree with neither tell nothing. One
  // foot's clock is no question of the IMU.
  Finding f = make_finding(effect,
                           {{"sensor", forces          ? name_feet(log, clock.foot)
                                       : odds < -kOdds ? imu
                                                       : imu + "/linear_acceleration"}},
                           value(clock));
  if (all && forces && odds < kOdds) add("/joint_states", clock, &f);
  if (all && !forces && std::abs(odds) < kOdds) add(imu, clock, &f);
  for (const ForceClock& rival : clock.rivals) add(name_feet(log, rival.foot), rival, &f);
  f.grade = clock.agreement > kMostly && f.alternatives.empty() ? Grade::kSupported : Grade::kAmbiguous;
  f.probability = 0.9;
  f.share = (clock.agreement - clock.as_logged) / (1 - clock.as_logged);
  f.weight = 0.5;
  f.statement = describe_clock(log, clock);
  if (all && odds > kOdds) f.statement += " Encoders of standing legs turn with the IMU: its clock is not the cause.";
  if (clock.agreement <= kMostly) f.statement += " A body that shakes elsewhere than at its IMU can look so, too.";
  return f;
}

}  // namespace hrp::diagnosis::floating
