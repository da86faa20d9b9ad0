// SPDX-License-Identifier: BSD-3-Clause
#include "servers/collision_checker/contact_filter.h"

#include <algorithm>

#include "common/robot/signals.h"

namespace hrp {
namespace {

std::vector<int> list_bodies(const Mover& mover) {
  std::vector<int> bodies;
  for (int link = 0; link < mover.num_bodies(); ++link) bodies.push_back(mover.first_body + link);
  return bodies;
}

std::vector<int> list_all(const TreeSpec& tree, const Scenario& scenario, const std::vector<Mover>& movers) {
  std::vector<int> bodies{kGround};
  for (size_t i = 0; i < tree.links.size(); ++i) bodies.push_back(static_cast<int>(i));
  for (size_t k = 0; k < scenario.obstacles.size(); ++k) bodies.push_back(make_obstacle_index(static_cast<int>(k)));
  for (const Mover& mover : movers) {
    for (const int body : list_bodies(mover)) bodies.push_back(body);
  }
  return bodies;
}

std::vector<int> find_bodies(const TreeSpec& tree, const Scenario& scenario, const std::vector<Mover>& movers,
                             const std::string& name) {
  if (name == "all") return list_all(tree, scenario, movers);
  if (name == "ground") return {kGround};
  for (size_t k = 0; k < scenario.obstacles.size(); ++k) {
    if (scenario.obstacles[k].name == name) return {make_obstacle_index(static_cast<int>(k))};
  }
  for (const Mover& mover : movers) {
    if (mover.name == name) return list_bodies(mover);
  }
  const int frame = tree.find_frame(name);
  return frame < 0 ? std::vector<int>{} : std::vector<int>{tree.frames[size_t(frame)].link};
}

}  // namespace

ContactFilter::ContactFilter(const TreeSpec& tree, const Scenario& scenario, const std::vector<Mover>& movers) {
  for (const auto& [name, others] : scenario.no_contact) {
    for (const int a : find_bodies(tree, scenario, movers, name)) {
      for (const std::string& other : others) {
        for (const int b : find_bodies(tree, scenario, movers, other)) never_.insert(std::minmax(a, b));
      }
    }
  }
}

bool ContactFilter::may_touch(int body_a, int body_b) const { return never_.count(std::minmax(body_a, body_b)) == 0; }

}  // namespace hrp
