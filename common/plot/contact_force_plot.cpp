// SPDX-License-Identifier: BSD-3-Clause
#include <stdexcept>

#include "common/mcap/reader.h"
#include "common/messages/cdr.h"
#include "common/messages/convert_robot.h"
#include "common/messages/logged_description.h"
#include "common/messages/topics.h"
#include "common/plot/svg_plot.h"
#include "common/robot/movers.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/model.h"

namespace hrp {
namespace {

struct Foot {
  std::string name;  // "L_FOOT", of another robot "partner/L_FOOT"
  int body = -1;
};

// A foot may be a URDF link that is lumped into the moving link which contacts name.
std::vector<Foot> find_feet(const msg::RobotDescription& message) {
  RobotDescription robot;
  from_message(message, &robot);
  std::vector<Foot> feet;
  for (const Mover& each : make_robots(robot, parse_scenario(robot.scenario, robot.scenario_path))) {
    for (const std::string& name : each.scenario.feet) {
      const int frame = each.robot.tree.find_frame(name);
      if (frame < 0) continue;
      const int link = each.robot.tree.frames[static_cast<size_t>(frame)].link;
      feet.push_back({each.name.empty() ? name : each.name + "/" + name, each.first_body + link});
    }
  }
  return feet;
}

double calc_vertical_force(const msg::ContactForces& forces, int body) {
  double force = 0;
  for (const msg::PairForce& pair : forces.pairs()) {
    if (pair.body_a() == body) force += pair.total().force().z();
    if (pair.body_b() == body) force -= pair.total().force().z();
  }
  return force;
}

}  // namespace

void write_contact_force_plot(const std::string& log_path, const std::string& svg_path) {
  mcap::Reader log(log_path);
  std::vector<Foot> feet;
  Plot plot{"Vertical contact force on each foot", "time [s]", "force [N]", {}};
  msg::ContactForces forces;
  const mcap::Channel* description = log.find_channel(topics::kRobotDescription.name);
  const mcap::Channel* contacts = log.find_channel(topics::kContactForces.name);
  if (description == nullptr || contacts == nullptr) throw std::runtime_error(log_path + ": no log of a simulation");
  log.read_messages(
      [&](const mcap::Message& message) {
        const Bytes sample{message.data, message.size};
        if (message.channel_id == description->id) {
          msg::RobotDescription robot;
          decode_logged(sample, &robot);
          feet = find_feet(robot);
          for (const Foot& foot : feet) plot.series.push_back({foot.name, {}, {}});
          return true;
        }
        decode(sample, &forces);
        if (forces.header().step() == 0) return true;  // nothing has acted yet
        for (size_t i = 0; i < feet.size(); ++i) {
          plot.series[i].x.push_back(forces.header().time());
          plot.series[i].y.push_back(calc_vertical_force(forces, feet[i].body));
        }
        return true;
      },
      {topics::kRobotDescription.name, topics::kContactForces.name});
  if (feet.empty()) throw std::runtime_error(log_path + ": its scenario names no feet to plot");
  write_svg(plot, svg_path);
}

}  // namespace hrp
