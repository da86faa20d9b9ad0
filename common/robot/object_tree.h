// SPDX-License-Identifier: BSD-3-Clause
// A movable object as a robot of one link, so that everything that is known of robots and the world holds for it, too.
#pragma once

#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"

namespace hrp {

// Of even density: about its middle, along its axes.
LinkInertia calc_object_inertia(const ObjectSpec& object);
CollisionShape make_object_shape(const ObjectSpec& object);

// One link, of the object's name, with the surfaces of the robot's world.
RobotDescription make_object_robot(const ObjectSpec& object, const RobotDescription& robot);
// The world that this link moves in: the scenario's without what belongs to its robot. Of two coefficients of friction the
// smaller one.
Scenario make_object_scenario(const ObjectSpec& object, const Scenario& scenario);

}  // namespace hrp
