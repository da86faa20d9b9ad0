// SPDX-License-Identifier: BSD-3-Clause
// Faults of sensors. Vectors are along the sensor's axes; a sensor that reads one number has the first of them.
#include <cmath>

#include "common/effects/effect_rows.h"

namespace hrp {
namespace {

using P = EffectParameter;

void set(const double* p, Vector3d* field) {
  for (int i = 0; i < 3; ++i) {
    if (std::isfinite(p[i])) (*field)[i] = p[i];
  }
}

EffectInfo make_bias() {
  EffectInfo row = make_row(EffectId::kSensorBias, "sensor_bias", PlaceKind::kSensor, EffectFamily::kZero,
                            "the reading is shifted by a constant", make_axes(P("value", "").absent_at(0).size(0.01)));
  row.apply = [](const double* p, const EffectTarget& at) { set(p, &at.sensor->bias); };
  row.change.constant = 1.0;
  row.linear = row.vector = true;
  return row;
}

EffectInfo make_scale() {
  EffectInfo row =
      make_row(EffectId::kSensorScale, "sensor_scale", PlaceKind::kSensor, EffectFamily::kGain, "the reading is scaled",
               make_axes(P("scale", "1").as_factor().search(0.01, 100).size(0.01).probed_by(0.01)));
  row.apply = [](const double* p, const EffectTarget& at) { set(p, &at.sensor->scale); };
  row.change.of_reading = 1.0;
  row.linear = true;
  return row;
}

EffectInfo make_delay() {
  EffectInfo row = make_row(EffectId::kSensorDelay, "sensor_delay", PlaceKind::kSensor, EffectFamily::kTiming,
                            "the reading comes late",
                            {P("delay", "s").absent_at(0).bounds(0, 10).search(0, 1).size(0.002).probed_by(5e-4)});
  row.apply = [](const double* p, const EffectTarget& at) { at.sensor->delay = p[0]; };
  row.change.of_rate = -1.0;
  row.linear = true;
  return row;
}

EffectInfo make_misalignment() {
  EffectInfo row = make_row(EffectId::kSensorMisalignment, "sensor_misalignment", PlaceKind::kSensor,
                            EffectFamily::kSensorGeometry, "the sensor is turned against its link",
                            make_axes(P("rpy", "rad").absent_at(0).search(-1, 1).size(1e-3)));
  row.apply = [](const double* p, const EffectTarget& at) { set(p, &at.sensor->misalignment); };
  row.vector = true;
  return row;
}

EffectInfo make_clock_skew() {
  EffectInfo row = make_row(EffectId::kClockSkew, "clock_skew", PlaceKind::kSensor, EffectFamily::kTiming,
                            "the clocks run at different rates",
                            {P("skew", "1").absent_at(0).bounds(-0.2, 0.2).size(0.0005).probed_by(1e-4)});
  row.apply = [](const double* p, const EffectTarget& at) {
    if (at.sensor) at.sensor->clock_skew = p[0];
    if (at.timing) at.timing->clock_skew = p[0];
  };
  return row;
}

}  // namespace

std::vector<EffectInfo> list_sensor_rows() {
  return {make_bias(), make_scale(), make_delay(), make_misalignment(), make_clock_skew()};
}

}  // namespace hrp
