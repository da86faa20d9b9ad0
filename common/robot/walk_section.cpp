// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/walk_section.h"

namespace hrp {
namespace {

constexpr Bound kAny = Bound::kAny, kPos = Bound::kPositive, kNotNeg = Bound::kNotNegative;

void read_laws(YamlMap& map, StabilizerSpec* s) {
  map.child("body_inclination", [&](YamlMap& law) {
    s->inclination = true;
    law.flag("on", &s->inclination);
    law.number("gain", &s->inclination_gain, kNotNeg, "");
    law.number("rate", &s->inclination_rate, kNotNeg, "s");
    law.number("integral", &s->inclination_integral, kNotNeg, "1/s");
    law.number("limit", &s->inclination_limit, kNotNeg, "rad");
  });
  map.child("zmp_damping", [&](YamlMap& law) {
    s->zmp_damping = true;
    law.flag("on", &s->zmp_damping);
    law.number("gain", &s->zmp_gain, kNotNeg, "1/s");
    law.number("return", &s->zmp_return, kNotNeg, "1/s");
    law.number("limit", &s->zmp_limit, kNotNeg, "m");
  });
  map.child("foot_adjusting", [&](YamlMap& law) {
    s->foot_adjusting = true;
    law.flag("on", &s->foot_adjusting);
    law.number("damping", &s->foot_damping, kPos, "N m s/rad");
    law.number("return", &s->foot_return, kPos, "s");
    law.number("limit", &s->foot_limit, kNotNeg, "rad");
    law.number("height_damping", &s->height_damping, kPos, "N s/m");
    law.number("height_return_double", &s->height_return_double, kPos, "s");
    law.number("height_return_single", &s->height_return_single, kPos, "s");
    law.number("height_limit", &s->height_limit, kNotNeg, "m");
  });
  map.child("tracking", [&](YamlMap& law) {
    s->tracking = true;
    law.flag("on", &s->tracking);
    law.number("position", &s->tracking_position, kNotNeg, "");
    law.number("velocity", &s->tracking_velocity, kNotNeg, "s");
    law.number("integral", &s->tracking_integral, kNotNeg, "1/s");
  });
  map.child("landing", [&](YamlMap& law) {
    s->landing = true;
    law.flag("on", &s->landing);
    law.number("force", &s->landing_force, kPos, "N");
    law.number("return", &s->landing_return, kPos, "s");
  });
  map.number("force_filter", &s->force_filter, kNotNeg, "s");
  map.number("rate_filter", &s->rate_filter, kNotNeg, "s");
}

void read_step_adjustment(YamlMap& map, StepAdjustmentSpec* s) {
  s->on = true;
  map.flag("on", &s->on);
  map.number("gain", &s->gain, kNotNeg, "");
  map.number("follow", &s->follow, kNotNeg, "rad/s");
  map.number("dead_band", &s->dead_band, kNotNeg, "m");
  map.number("limit", &s->limit, kNotNeg, "m");
  map.number("freeze", &s->freeze, kNotNeg, "s");
}

void read_limits(YamlMap& map, WalkSpec* walk) {
  map.number("max_length", &walk->max_length, kPos, "m");
  map.number("min_width", &walk->min_width, kNotNeg, "m");
  map.number("max_width", &walk->max_width, kPos, "m");
  map.number("max_turn", &walk->max_turn, kPos, "rad");
  map.number("max_rise", &walk->max_rise, kNotNeg, "m");
}

void read_plan(YamlMap& map, WalkSpec* walk) {
  map.choice("first", &walk->first, {"left", "right"});
  unsigned long long count = 0;
  map.integer("count", &count);
  if (count > 10000) map.error("count", "is " + std::to_string(count) + ", expected at most 10000");
  walk->count = static_cast<int>(count > 10000 ? 10000 : count);
  map.number("length", &walk->length, kAny, "m");
  map.number("side", &walk->side, kAny, "m");
  map.number("turn", &walk->turn, kAny, "rad");
  map.list("footsteps", [&](size_t, YamlMap& item) {
    FootstepSpec step;
    item.text("frame", &step.frame);
    item.text("side", &step.side);
    item.number("x", &step.x, kAny, "m");
    item.number("y", &step.y, kAny, "m");
    item.number("z", &step.z, kAny, "m");
    item.number("theta", &step.theta, kAny, "rad");
    walk->footsteps.push_back(step);
  });
}

}  // namespace

void read_walk(YamlMap& map, WalkSpec* walk) {
  for (const char* key : {"left_foot", "right_foot"}) map.require(key, "the link of that foot");
  map.text("left_foot", &walk->left_foot);
  map.text("right_foot", &walk->right_foot);
  map.text("left_sensor", &walk->left_sensor);
  map.text("right_sensor", &walk->right_sensor);
  map.text("imu", &walk->imu);
  map.number("com_height", &walk->com_height, kNotNeg, "m");
  map.number("single_support", &walk->single_support, kPos, "s");
  map.number("double_support", &walk->double_support, kNotNeg, "s");
  map.number("settle", &walk->settle, kPos, "s");
  map.number("transfer", &walk->transfer, kPos, "s");
  map.number("swing_height", &walk->swing_height, kNotNeg, "m");
  map.number("landing_speed", &walk->landing_speed, kNotNeg, "m/s");
  map.number("zmp_x", &walk->zmp_x, kAny, "m");
  map.number("zmp_y", &walk->zmp_y, kAny, "m");
  map.number("placement_position", &walk->placement_position, kNotNeg, "");
  map.number("placement_velocity", &walk->placement_velocity, kNotNeg, "");
  map.number("base_pitch", &walk->base_pitch, kAny, "rad");
  map.flag("measured_ground", &walk->measured_ground);
  map.child("plan", [&](YamlMap& plan) { read_plan(plan, walk); });
  map.child("limits", [&](YamlMap& limits) { read_limits(limits, walk); });
  map.child("step_adjustment", [&](YamlMap& law) { read_step_adjustment(law, &walk->step_adjustment); });
  map.child("attitude_filter", [&](YamlMap& filter) {
    walk->attitude_filter.on = true;
    filter.flag("on", &walk->attitude_filter.on);
    filter.number("time_constant", &walk->attitude_filter.time_constant, kPos, "s");
  });
  map.child("stabilizer", [&](YamlMap& laws) { read_laws(laws, &walk->stabilizer); });
}

}  // namespace hrp
