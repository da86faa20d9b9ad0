// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/fit/usable_rows.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis::floating {
namespace {

// Takes all rows out of an equation.
void empty(ChannelRows* c) {
  *c = ChannelRows{c->info, c->columns, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}, c->mean, c->scale};
}

// [unit^2] Of a row, beyond noise and beside each recording's mean.
double calc_change(const ChannelRows& c) {
  std::map<int, std::pair<double, double>> sums;  // by recording: sum, rows
  for (size_t i = 0; i < c.rows(); ++i) {
    auto& [sum, rows] = sums[c.recording[i]];
    sum += c.y[i];
    rows += 1;
  }
  double square = 0;
  for (size_t i = 0; i < c.rows(); ++i) {
    const auto& [sum, rows] = sums[c.recording[i]];
    square += std::pow(c.y[i] - sum / rows, 2) - std::pow(c.noise_y[i], 2);
  }
  return square / static_cast<double>(std::max<size_t>(1, c.rows()));
}

bool is_over_feet(const ChannelRows& c) { return c.info.equation.is(EquationKind::kGyroscopeOverFeet); }

// [rad/s] How fast the body turns about all axes: the spread of its gyroscope.
double calc_turning(const std::vector<ChannelRows>& channels) {
  double square = 0;
  for (const ChannelRows& c : channels) square += is_over_feet(c) ? c.scale * c.scale : 0.0;
  return std::sqrt(square);
}

// Feet that turn do not stand: they tell nothing of a gyroscope. Feet on the ground turn to and fro: a constant is the
// gyroscope's zero. About an axis that nothing turns about, a gyroscope that is mounted askew feels a little of the
// other axes, and encoders have noise. Neither shows that feet turn.
void drop_moving_feet(std::vector<ChannelRows>* channels) {
  const double askew = kDetail * calc_turning(*channels);
  for (ChannelRows& c : *channels) {
    if (is_over_feet(c) && calc_change(c) > std::pow(std::max(kHalf * c.scale, askew), 2)) empty(&c);
  }
}

// What is zero whatever the robot does is no measurement: soles of legs that bend about one axis never roll against
// each other.
void drop_identities(std::vector<ChannelRows>* channels) {
  for (ChannelRows& c : *channels) {
    if (c.scale == 0 && std::all_of(c.y.begin(), c.y.end(), [](double y) { return y == 0; })) empty(&c);
  }
}

}  // namespace

std::vector<ChannelRows> join_halves(const RowTable& even, const RowTable& odd) {
  std::vector<ChannelRows> out = merge_halves(even, odd);
  drop_identities(&out);
  drop_moving_feet(&out);
  return out;
}

void drop_unused(const Used& used, std::vector<ChannelRows>* channels) {
  drop_rests(used.rests, channels);
  for (ChannelRows& c : *channels) {
    const Equation& e = c.info.equation;
    const bool joint = e.is(EquationKind::kJoint), servo = e.is(EquationKind::kServo);
    const bool forces = e.is(EquationKind::kWeight) || joint || e.is_of_whole_body();
    if ((forces && !used.forces) || ((joint || servo) && !used.drives)) empty(&c);
  }
}

}  // namespace hrp::diagnosis::floating
