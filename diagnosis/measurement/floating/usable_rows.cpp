// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/usable_rows.h"

#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/floating/equations/imu_rows.h"

namespace hrp::diagnosis::floating {
namespace {

// Takes all rows out of an equation.
void empty(ChannelRows* c) {
  *c = ChannelRows{c->info, c->columns, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}, c->mean, c->scale};
}

// Feet that turn do not stand: they tell nothing of a gyroscope.
void drop_moving_feet(std::vector<ChannelRows>* channels) {
  for (ChannelRows& c : *channels) {
    if (c.info.kind.rfind(kOverFeet, 0) != 0) continue;
    double square = 0;
    for (double y : c.y) square += y * y;
    if (square > std::pow(kHalf * c.scale, 2) * static_cast<double>(c.rows())) empty(&c);
  }
}

}  // namespace

std::vector<ChannelRows> join_halves(const RowTable& even, const RowTable& odd) {
  std::vector<ChannelRows> out = merge_halves(even, odd);
  drop_moving_feet(&out);
  return out;
}

void drop_unused(const Used& used, std::vector<ChannelRows>* channels) {
  for (ChannelRows& c : *channels) {
    const bool joint = c.info.kind == "joint", servo = c.info.kind == "servo";
    const bool forces = c.info.kind == "weight" || joint || c.info.kind.rfind("balance", 0) == 0;
    if ((forces && !used.forces) || ((joint || servo) && !used.drives)) empty(&c);
  }
}

}  // namespace hrp::diagnosis::floating
