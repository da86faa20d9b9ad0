// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/topic_clock.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "diagnosis/data/gaps.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"

namespace hrp::diagnosis {
namespace {

constexpr size_t kPieces = 24;         // of the recording: the fastest message of each is a point of the envelope
constexpr double kOtherClock = 0.05;   // [s] offset that latency in a local network does not always explain
constexpr double kDriftShift = 0.002;  // [s] least effect of a drift over the recording

// Smallest receive - stamp in each piece of the recording.
struct Points {
  std::vector<double> x, y;
};

Points find_fastest(const std::vector<double>& stamp, const std::vector<double>& receive) {
  const double begin = stamp.front(), span = std::max(1e-9, stamp.back() - begin);
  std::vector<double> x(kPieces, 0.0), y(kPieces, HUGE_VAL);
  for (size_t k = 0; k < stamp.size(); ++k) {
    const double share = std::clamp((stamp[k] - begin) / span, 0.0, 1.0);
    const size_t piece = std::min(kPieces - 1, static_cast<size_t>(share * kPieces));
    if (receive[k] - stamp[k] < y[piece]) {
      y[piece] = receive[k] - stamp[k];
      x[piece] = stamp[k] - begin;
    }
  }
  Points out;
  for (size_t i = 0; i < kPieces; ++i) {
    if (std::isfinite(y[i])) {
      out.x.push_back(x[i]);
      out.y.push_back(y[i]);
    }
  }
  return out;
}

}  // namespace

// Theil-Sen line through the fastest messages.
TopicClock find_topic_clock(const std::vector<double>& stamp, const std::vector<double>& receive) {
  TopicClock clock;
  clock.stamped = stamp.size() > 1 && stamp.size() == receive.size() && stamp.back() > stamp.front();
  if (!clock.stamped) return clock;
  clock.begin = stamp.front();
  clock.span = stamp.back() - stamp.front();
  const Points p = find_fastest(stamp, receive);
  std::vector<double> slopes, levels, rest;
  for (size_t a = 0; a < p.x.size(); ++a) {
    for (size_t b = a + p.x.size() / 4 + 1; b < p.x.size(); ++b)
      slopes.push_back((p.y[b] - p.y[a]) / std::max(1e-9, p.x[b] - p.x[a]));
  }
  clock.slope = find_median(slopes);
  for (size_t a = 0; a < p.x.size(); ++a) levels.push_back(p.y[a] - clock.slope * p.x[a]);
  clock.level = find_median(levels);
  for (double level : levels) rest.push_back(std::abs(level - clock.level));
  clock.scatter = find_median(rest);
  return clock;
}

std::vector<double> place_stamps(const std::vector<double>& stamp, const std::vector<double>& receive,
                                 const TopicClock& reference, PlacedClock* placed) {
  const TopicClock own = find_topic_clock(stamp, receive);
  placed->stamped = own.stamped;
  std::vector<double> time = own.stamped ? stamp : receive;
  if (own.stamped) {
    const auto move = [&](double t) { return reference.from_receive(own.to_receive(t)); };
    const double end = own.begin + own.span;
    placed->offset = own.begin - move(own.begin);
    const double gained = end - move(end) - placed->offset;
    const bool drifts = std::abs(gained) > std::max(kDriftShift, kOutlier * (own.scatter + reference.scatter));
    placed->drift = drifts ? gained / own.span : 0.0;
    // Where the reference has times of receiving alone, every stamp is on another clock.
    placed->moved = drifts || !reference.stamped || std::abs(placed->offset) > kOtherClock;
    for (double& t : time) t = placed->moved ? move(t) : t;
  } else {
    for (double& t : time) t = reference.from_receive(t);
  }
  placed->period = find_period(time);
  return time;
}

std::string describe_clock(const PlacedClock& c, const std::string& reference) {
  std::string text = c.period > 0.0 ? number(1.0 / c.period, 3) + " Hz" : "one sample";
  if (!c.stamped) return text + "; no stamps of its sender, times of receiving are used";
  if (!c.moved) return text;
  text += "; its clock is " + number(std::abs(c.offset), 4) + (c.offset > 0.0 ? " s ahead of" : " s behind") +
          " that of " + reference;
  if (c.drift != 0.0)
    text += " and " + std::string(c.drift > 0.0 ? "gains " : "loses ") + number(1e6 * std::abs(c.drift), 3) +
            " us in a second";
  return text + ": moved there";
}

}  // namespace hrp::diagnosis
