// SPDX-License-Identifier: BSD-3-Clause
// What a world file adds to a scenario, written into the scenario's text, which is what every server reads.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/robot/scenario.h"

namespace hrp {

struct WorldSpec {
  std::vector<ObstacleSpec> obstacles;  // files absolute
  GroundSpec ground;                    // type, pose and friction
};

// `text` with these obstacles beside its own, and with this ground unless it has a `ground`; without its key `world`,
// so that nobody reads the world twice. Numbers keep their bits.
std::string add_world(const std::string& text, const WorldSpec& world);

// `scenario` with obstacles and ground of the text that the model parser has made of it: what every server has.
Scenario adopt_world(const Scenario& scenario, const std::string& merged);

}  // namespace hrp
