// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/disturbance_section.h"

namespace hrp {
namespace {

void read_push(YamlMap& map, PushSpec* push) {
  map.require("link", "the name of a link");
  map.require("force", "a list of 3 numbers [N]");
  map.require("duration", "a time [s]");
  map.text("link", &push->link);
  map.vector3("xyz", &push->p_LQ, Bound::kAny, "m");
  map.vector3("force", &push->force_W, Bound::kAny, "N");
  map.number("start", &push->start, Bound::kNotNegative, "s");
  map.number("duration", &push->duration, Bound::kPositive, "s");
}

void read_variation(YamlMap& map, VariationSpec* variation) {
  map.number("mass", &variation->mass, Bound::kUnitInterval, "");
  map.number("pose", &variation->pose, Bound::kNotNegative, "rad");
  map.integer("seed", &variation->seed);
}

void read_wave(YamlMap& map, HandWave* wave) {
  map.require("amplitude", "a list of 3 numbers [m]");
  map.require("frequency", "a frequency [Hz]");
  map.vector3("amplitude", &wave->amplitude_W, Bound::kAny, "m");
  map.number("frequency", &wave->frequency, Bound::kNotNegative, "Hz");
  map.number("phase", &wave->phase, Bound::kAny, "rad");
  map.number("start", &wave->start, Bound::kNotNegative, "s");
  map.number("duration", &wave->duration, Bound::kNotNegative, "s");
  map.number("fade", &wave->fade, Bound::kPositive, "s");
}

void read_point(YamlMap& map, HandPoint* point) {
  map.require("time", "a time [s]");
  map.require("xyz", "a list of 3 numbers [m]");
  map.number("time", &point->time, Bound::kNotNegative, "s");
  map.vector3("xyz", &point->p_QH_W, Bound::kAny, "m");
}

void read_hand(YamlMap& map, HandSpec* hand) {
  map.require("link", "the name of a link");
  map.require("stiffness", "a stiffness [N/m], or one for each world axis");
  map.text("link", &hand->link);
  map.vector3("xyz", &hand->p_LQ, Bound::kAny, "m");
  map.axes3("stiffness", &hand->stiffness_W, Bound::kNotNegative, "N/m");
  map.axes3("damping", &hand->damping_W, Bound::kNotNegative, "N s/m");
  map.number("start", &hand->start, Bound::kNotNegative, "s");
  map.number("duration", &hand->duration, Bound::kNotNegative, "s");
  map.list("path", [&](size_t i, YamlMap& child) {
    HandPoint point;
    read_point(child, &point);
    const double before = i == 0 ? 0.0 : hand->path.back().time;
    if (i > 0 && point.time <= before) child.error("time", "is not later than the point before");
    hand->path.push_back(point);
  });
  map.list("waves", [&](size_t, YamlMap& child) {
    hand->waves.push_back({});
    read_wave(child, &hand->waves.back());
  });
}

}  // namespace

void read_disturbance_sections(YamlMap& map, Scenario* scenario) {
  map.child("variation", [&](YamlMap& child) { read_variation(child, &scenario->variation); });
  map.named("pushes", &scenario->pushes, read_push);
  map.named("hands", &scenario->hands, read_hand);
}

}  // namespace hrp
