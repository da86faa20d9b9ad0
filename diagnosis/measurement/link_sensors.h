// SPDX-License-Identifier: BSD-3-Clause
// Finds the sensors on the link side of the gears, and prepares their readings and predictions: on the uniform grid and
// with the filter of the missing torque (torque.h).
#pragma once

#include "diagnosis/measurement/link_readings.h"
#include "diagnosis/measurement/torque/torque.h"
#include "diagnosis/model/effect.h"

namespace hrp::diagnosis {

struct LinkSensors {
  std::vector<LinkSensor> sensors;  // that are compared with a prediction
  std::vector<int> link_encoders;   // joints with a second encoder
  std::vector<std::string> notes;   // recorded signals that cannot be compared, with the reason
  bool any() const { return !sensors.empty() || !link_encoders.empty(); }
  bool has_torque(int joint) const;
  bool has_encoder(int joint) const;
};

// For a robot on a fixed base; empty for others. Throws InputError if a declared sensor was not recorded or a column
// names an unknown joint.
LinkSensors find_link_sensors(const Experiment& experiment);

// One recording on its full grid.
struct LinkRecording {
  size_t index = 0;  // in the experiment
  bool train = true;
  double step = 0.0;                // [s]
  long stride = 1, trim = 0;        // kept samples, as in TorqueRecording
  Eigen::MatrixXd q, v, a;          // of the link where a second encoder exists, else of the joint's encoder
  Eigen::MatrixXd read, predicted;  // sample x reading
};

struct LinkData {
  const Experiment* experiment = nullptr;
  double cutoff = 0.0;  // [Hz] of the filter of all signals
  std::vector<LinkRecording> recordings;
};

// Readings and predictions of all recordings. `known` corrects encoder zeros. `predict` keeps the motion of the last
// sample.
LinkData make_link_data(const Experiment& experiment, const TorqueData& motion, const LinkSensors& sensors,
                        const std::vector<Effect>& known, LinkReadings* predict);

// Predictor for the bodies as the experiment states, without rotors and drives, with the `known` effects of links.
LinkReadings make_link_readings(const Experiment& experiment, const LinkSensors& sensors,
                                const std::vector<Effect>& known);

// Throws InputError for readings that differ from the prediction by a known factor: degrees, g, mN m, opposite sign.
void check_units(const LinkData& data, const LinkReadings& predict);

}  // namespace hrp::diagnosis
