// SPDX-License-Identifier: BSD-3-Clause
// All cameras and lidars of a scenario: what they see of one state depends on nothing but the state and its step.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "servers/vision/camera.h"
#include "servers/vision/lidar.h"

namespace hrp {

// Sensors are numbered as in common/robot/vision_spec.h.
struct Look {
  uint64_t step = 0;
  State state;
  ObjectStates objects;
  std::vector<size_t> sensors;  // that look
};

struct LookResult {
  std::vector<CameraPicture> pictures;  // of each camera; those that did not look keep what they had
  std::vector<Points> scans;            // of each lidar
};

class PictureMaker {
 public:
  // Throws std::runtime_error when the renderer cannot be started.
  PictureMaker(const RobotDescription& robot, const Scenario& scenario);
  const std::vector<CameraSpec>& cameras() const { return sensors_.cameras; }
  const std::vector<LidarSpec>& lidars() const { return sensors_.lidars; }
  size_t num_sensors() const { return cameras().size() + lidars().size(); }
  // What could not be drawn.
  const std::vector<std::string>& notes() const { return world_.notes(); }

  // Throws std::invalid_argument for a state of another robot.
  void look(const Look& look, LookResult* result);

 private:
  SensorsSpec sensors_;
  unsigned long long seed_;
  VisibleWorld world_;
  RayCaster caster_;
};

}  // namespace hrp
