// SPDX-License-Identifier: BSD-3-Clause
// Missing torque of a legged robot's joints (measurement/torque/torque.h), standing or walking, from whatever sensors
// tell how the base moves. A joint is judged while no foot beyond it bears an unknown force: with six-axis force
// sensors always, without any in the swing.
#pragma once

#include "diagnosis/floating/log/contacts.h"
#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis::many_drives {

// A log in two forms of the same clips.
struct LeggedLogs {
  floating::LeggedLog raw;     // Half::kAll, corrected for faults of sensors
  floating::LeggedLog smooth;  // of which `contacts` were found
  floating::Contacts contacts;
};

// Empty (no recordings) if nothing tells how the base moves.
TorqueData make_legged_torques(const LeggedLogs& logs);

}  // namespace hrp::diagnosis::many_drives
