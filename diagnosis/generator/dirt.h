// SPDX-License-Identifier: BSD-3-Clause
// What a real machine has everywhere: losses and rotors in every drive, a little of what no list holds, sensors that
// resolve so much and no more.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/generator/recorder.h"

namespace hrp::cases {

struct Dirt {
  std::vector<Hidden> background;  // of the tool's list: friction and a rotor in every joint, efforts a little off
  std::vector<Hidden> unlisted;    // friction that varies over position, friction that fades with time
};

// None to two effects of the list, to be hidden on top of the dirt.
std::vector<std::string> draw_on_top(bool biped, Prng& random);

// The rotor behind a hidden transmission is the joint's: it turns whether the transmission gives or not.
Dirt draw_dirt(const RobotPlan& robot, const std::vector<Hidden>& hidden, Prng& random);

// Encoders of 12 to 16 bits, efforts with ripple and noise by joint, a clock that stamps late and early.
void soil_recorder(const RobotPlan& robot, const std::vector<Hidden>& hidden, RecorderPlan* plan, Prng& random);

}  // namespace hrp::cases
