// SPDX-License-Identifier: BSD-3-Clause
// Says when a robot falls: from the attitude and height of its base and from what touches the ground.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/robot/ground_plane.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "common/robot/signals.h"

namespace hrp {

struct FallEvent {
  bool fall = false;               // else: something that is no foot touches the ground
  std::vector<std::string> links;  // that touch the ground and are no feet
  double tilt = 0.0;               // [rad] of the base against its attitude in the first state
  double height = 0.0;             // [m] of the base above the ground
  std::string text;
};

// Equal states and forces give equal events, so dynamics server and logger find the same ones. A robot has fallen when
//   its base is tilted by more than 60 deg, or is lower than a fifth of its height at the start, whatever touches; or
//   something that is no foot touches the ground while it is tilted by more than 30 deg, or lower than half its height.
// While it is tilted by less than 15 deg and higher than 0.8 of its height nothing is looked at: standing costs
// nothing.
//
// Without a plane, obstacles are the ground. Heights are then above the lowest point that was touched last, and the
// height at the start is that at the first touch: a robot that walks downstairs has not fallen, one that walks over the
// edge has.
class FallWatch {
 public:
  FallWatch() = default;  // sees nothing
  // `name`: of a robot beside others, for the text of its events.
  FallWatch(const RobotDescription& robot, const Scenario& scenario, const std::string& name = "");
  // At step 0 of each epoch, with its state.
  void reset(const Eigen::Quaterniond& R_WB, const Vector3d& p_WB);
  // Whether contacts can make an event of this state; update() only then.
  bool is_due(const Eigen::Quaterniond& R_WB, const Vector3d& p_WB);
  // After is_due(): an event, at most one for each new link that touches the ground, and one fall in an epoch.
  std::optional<FallEvent> update(const ContactForces& forces);

 private:
  bool is_foot(int link) const { return feet_[static_cast<size_t>(link)] != 0; }
  void update_foothold(const ContactForces& forces);
  bool is_upright() const;
  bool has_fallen() const;
  std::string describe(const FallEvent& event, const std::string& newest) const;

  bool watching_ = false;  // a floating base over a ground
  bool stands_ = true;     // the height at the start is known
  std::string name_;
  std::vector<std::string> names_;
  std::vector<char> feet_;  // by link
  GroundPlane ground_;
  Vector3d up_B_ = Vector3d::UnitZ();       // the ground's normal in the base at the start
  double start_height_ = 0.0;               // [m]
  double tilt_ = 0.0, cosine_ = 1.0;        // [rad], its cosine
  double height_ = 0.0;                     // [m]
  double base_z_ = 0.0, foothold_z_ = 0.0;  // [m] without a plane: of the base, and of the lowest point touched last
  std::vector<char> touched_;               // by link, in this epoch
  bool fallen_ = false;
};

}  // namespace hrp
