// SPDX-License-Identifier: BSD-3-Clause
// All links of a robot against all surfaces of a scenario.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/multibody/kinematics.h"
#include "common/robot/scenario.h"
#include "servers/collision_checker/contact_filter.h"
#include "servers/collision_checker/surface_contact.h"

namespace hrp {

class SurfaceWorld {
 public:
  // Throws InputError: an obstacle whose surface the description lacks.
  SurfaceWorld(const RobotDescription& robot, const Scenario& scenario, const ContactFilter& filter);

  // Shapes of feet and their neighbours that are no soles and reach into a surface at the start never touch it, as with
  // the ground.
  void leave_out_start(const RobotDescription& robot, const Data& start);

  // Couples of a link and a surface, by link.
  size_t size() const { return couples_.size(); }
  int get_link(size_t i) const { return couples_[i].link; }
  int get_obstacle(size_t i) const { return couples_[i].obstacle; }
  // Fills `pair` (memory reused); false when they do not touch.
  bool calc_contact(size_t i, const Data& data, ContactPair* pair);

 private:
  struct Place {
    std::unique_ptr<SurfaceMesh> mesh;
    Transform X_WG;
    int obstacle = 0;  // as ContactPair::body_b
    double friction = 0.0;
  };
  struct Part {
    TouchingShape shape;
    int query = 0;
    bool sole = false;
  };
  struct Couple {
    int link = 0, obstacle = 0;
    size_t place = 0;
    Vector3d p_LR;
    std::vector<Part> parts;
  };
  void add_places(const RobotDescription& robot, const Scenario& scenario);
  void add_couples(const RobotDescription& robot, double margin, const ContactFilter& filter);
  void calc_part(const Couple& couple, const Part& part, const Data& data);

  int max_points_ = 4;
  std::vector<Place> places_;
  std::vector<Couple> couples_;
  std::vector<int> faces_;
  std::vector<ContactPoint> points_;  // in the surface's frame
};

}  // namespace hrp
