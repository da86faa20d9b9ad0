// SPDX-License-Identifier: BSD-3-Clause
// Gears that give under the torque that they transmit, found without an encoder behind them (series-elastic joints,
// harmonic drives). The effort tells how far such a gear is twisted, and the links move by that much otherwise than the
// drive:
//
//   u = y - J a - b v - c s - m |load| s     torque on the gear: the drive's effort less rotor and friction
//   q_link = q - u / k                       k: stiffness
//   u = tau(q_link)                          inverse dynamics along the links' motion, in the rows of every joint
//
// The equations are linear in 1/k and J/k as far as the twist is a small angle. They hold at the resonance of link and
// gear, too, because u comes from the effort and not from the motion (Spong, "Modeling and control of elastic joint
// robots", ASME J. Dyn. Syst. Meas. Control 1987, without the damping of the gear).
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// The best single gear that the training recordings ask for, beside friction, rotor and a spring at each joint, and
// beside the gears that are soft in `data` already. Empty if none takes kMinor of the squares that these leave. Only on
// a fixed base without loaded feet.
std::optional<SoftGear> find_soft_gear(const TorqueData& data);

// The data with the links behind this gear moved by its twist.
TorqueData soften(TorqueData data, const SoftGear& gear);

}  // namespace hrp::diagnosis
