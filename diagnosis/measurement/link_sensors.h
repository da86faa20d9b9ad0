// SPDX-License-Identifier: BSD-3-Clause
// Which sensors on the link's side of the gears an experiment's recordings have, and how their readings stand beside the
// predicted ones: on the even grid and with the filter of the missing torque (torque.h).
#pragma once

#include "diagnosis/measurement/link_readings.h"
#include "diagnosis/model/effect.h"
#include "diagnosis/measurement/torque.h"

namespace hrp::diagnosis {

struct LinkSensors {
  std::vector<LinkSensor> sensors;   // that are compared
  std::vector<int> link_encoders;    // joints with a second encoder
  std::vector<std::string> notes;    // what is recorded and cannot be compared, and why
  bool any() const { return !sensors.empty() || !link_encoders.empty(); }
  bool has_torque(int joint) const;
  bool has_encoder(int joint) const;
};

// Of a robot on a fixed base. Throws InputError where a declared sensor was not recorded, or a column names a joint that
// the robot has not.
LinkSensors find_link_sensors(const Experiment& experiment);

// One recording, sample by sample of its full grid.
struct LinkRecording {
  size_t index = 0;  // in the experiment
  bool train = true;
  double step = 0.0;              // [s]
  long stride = 1, trim = 0;      // kept samples, as in TorqueRecording
  Eigen::MatrixXd q, v, a;        // link side where a second encoder is, else as the joint's encoder says
  Eigen::MatrixXd read, predicted;  // sample x reading
};

struct LinkData {
  const Experiment* experiment = nullptr;
  double cutoff = 0.0;  // [Hz] of every signal
  std::vector<LinkRecording> recordings;
};

// `predict` is left at the motion of the last sample.
LinkData make_link_data(const Experiment& experiment, const TorqueData& motion, const LinkSensors& sensors,
                        const std::vector<Effect>& known, LinkReadings* predict);

// The robot's bodies as the experiment states them, rotors and drives left out, with `known` effects of links.
LinkReadings make_link_readings(const Experiment& experiment, const LinkSensors& sensors, const std::vector<Effect>& known);

// Refuses (InputError) readings that are a known factor of the predicted ones: degrees, g, mN m, the other sign.
void check_units(const LinkData& data, const LinkReadings& predict);

}  // namespace hrp::diagnosis
