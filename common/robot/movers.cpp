// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/movers.h"

#include <algorithm>
#include <iterator>

#include "common/base/diagnostics.h"
#include "common/base/format.h"
#include "common/spatial/rpy.h"

namespace hrp {
namespace {

// Of even density: about its middle, along its axes.
LinkInertia calc_object_inertia(const ObjectSpec& object) {
  LinkInertia inertia;
  inertia.mass = object.mass;
  const Vector3d s = object.size.cwiseProduct(object.size);
  Vector3d moments;
  if (object.shape == "box") {
    moments = object.mass / 12.0 * Vector3d(s.y() + s.z(), s.z() + s.x(), s.x() + s.y());
  } else if (object.shape == "sphere") {
    moments.setConstant(0.4 * object.mass * s.x());
  } else {  // radius and length along z
    const double across = object.mass * (3.0 * s.x() + s.y()) / 12.0;
    moments = {across, across, 0.5 * object.mass * s.x()};
  }
  inertia.I_LLcm_L = moments.asDiagonal();
  return inertia;
}

CollisionShape make_object_shape(const ObjectSpec& object) {
  CollisionShape shape;
  shape.name = object.name;
  shape.size = object.size;
  shape.kind = object.shape == "sphere"     ? ShapeKind::kSphere
               : object.shape == "cylinder" ? ShapeKind::kCylinder
                                            : ShapeKind::kBox;
  shape.sole = true;
  return shape;
}

RobotDescription make_object_robot(const ObjectSpec& object, const RobotDescription& robot) {
  RobotDescription result;
  LinkSpec link;
  link.name = object.name;
  link.inertia = calc_object_inertia(object);
  result.tree.name = object.name;
  result.tree.links.push_back(link);
  result.tree.frames.push_back({object.name, 0, Transform(), link.inertia});
  result.shapes.push_back(make_object_shape(object));
  result.visuals.push_back({result.shapes.back(), object.color});
  result.surfaces = robot.surfaces;
  return result;
}

// What all that moves in a scenario shares.
void set_world(const Scenario& world, Scenario* scenario) {
  scenario->gravity_W = world.gravity_W;
  scenario->time_step = world.time_step;
  scenario->control_period = world.control_period;
  scenario->contact = world.contact;
  scenario->ground = world.ground;
  scenario->obstacles = world.obstacles;
  scenario->objects.clear();
  scenario->robots.clear();
}

// Of two coefficients of friction the smaller one.
Scenario make_object_scenario(const ObjectSpec& object, const Scenario& world) {
  Scenario result;
  result.path = world.path;
  result.marks = world.marks;
  set_world(world, &result);
  result.integrator = world.integrator;
  result.contact.model = "spring_damper";
  result.no_contact = world.no_contact;
  result.max_sole_points = world.max_sole_points;
  result.feet = {object.name};
  result.initial_position = object.X_WO.p;
  result.initial_height_given = true;
  result.initial_rpy = calc_rpy(object.X_WO.R);
  result.ground.friction = std::min(world.ground.friction, object.friction);
  for (ObstacleSpec& obstacle : result.obstacles) obstacle.friction = std::min(obstacle.friction, object.friction);
  return result;
}

Mover make_object(const ObjectSpec& object, const RobotDescription& robot, const Scenario& scenario) {
  Mover mover;
  mover.name = object.name;
  mover.robot = make_object_robot(object, robot);
  mover.scenario = make_object_scenario(object, scenario);
  mover.friction = object.friction;
  mover.V_WB = object.V_WO;
  return mover;
}

[[noreturn]] void refuse(const Scenario& scenario, const std::string& key, const std::string& message) {
  throw InputError(scenario.make_diagnostic(key, message));
}

std::string format_period(double seconds) { return format("%g s", seconds); }

// All robots step together, and are asked for commands together.
void check_fits(const Scenario& own, const RobotPlacement& placement, const Scenario& world) {
  const std::string key = "robots." + placement.name + ".scenario";
  const auto check = [&](const char* name, double its, double expected) {
    if (its == expected) return;
    refuse(world, key,
           "'" + own.path + "' has steps." + name + " " + format_period(its) + ", expected " + format_period(expected) +
               " as in this scenario: all robots step together");
  };
  check("time_step", own.time_step, world.time_step);
  check("control_period", own.time_step * own.control_period, world.time_step * world.control_period);
  if (!own.robots.empty())
    refuse(world, key, "'" + own.path + "' has robots of its own; name all of them in this scenario");
  if (own.sensors.has_vision())
    refuse(world, key, "'" + own.path + "' has cameras or lidars, which only the first robot may have");
  const double z = placement.position.z();
  if (z != 0.0 && world.ground.present && own.floating_base && !own.initial_height_given)
    refuse(world, "robots." + placement.name + ".position",
           format("shifts the robot by z = %g m, but its feet are put on the ground, as '", z) + own.path +
               "' has no initial.position: expected z = 0, or initial.position there");
}

Mover make_other_robot(const OtherRobot& other, const RobotPlacement& placement, const RobotDescription& robot,
                       const Scenario& scenario) {
  const Scenario own = parse_scenario(other.description.scenario, other.description.scenario_path);
  check_fits(own, placement, scenario);
  Mover mover;
  mover.name = other.name;
  mover.is_robot = true;
  mover.robot = other.description;
  mover.robot.surfaces = robot.surfaces;
  mover.scenario = place_in_world(own, placement, scenario);
  mover.friction = scenario.ground.friction;
  return mover;
}

}  // namespace

std::string Mover::name_body(int link) const {
  return is_robot ? name + "/" + robot.tree.links[static_cast<size_t>(link)].name : name;
}

std::string find_own_link(const std::string& body, const std::string& mover, bool is_robot, const TreeSpec& tree) {
  if (!is_robot) return body == mover ? tree.links[0].name : "";
  if (body.compare(0, mover.size() + 1, mover + "/") != 0) return "";
  const std::string link = body.substr(mover.size() + 1);
  return tree.find_frame(link) >= 0 || tree.find_link(link) >= 0 ? link : "";
}

bool names_mover(const Scenario& scenario, const std::string& body) {
  return std::any_of(scenario.objects.begin(), scenario.objects.end(),
                     [&](const ObjectSpec& o) { return o.name == body; }) ||
         std::any_of(scenario.robots.begin(), scenario.robots.end(),
                     [&](const RobotPlacement& r) { return body.compare(0, r.name.size() + 1, r.name + "/") == 0; });
}

std::string find_wrong_states(const std::vector<Mover>& movers, const std::vector<State>& states) {
  if (states.size() != movers.size()) {
    return std::to_string(states.size()) + " objects and other robots, the scenario has " +
           std::to_string(movers.size());
  }
  for (size_t k = 0; k < movers.size(); ++k) {
    const int joints = movers[k].robot.tree.num_joints();
    if (states[k].q.size() != joints)
      return std::to_string(states[k].q.size()) + " joints of '" + movers[k].name + "', which has " +
             std::to_string(joints);
  }
  return "";
}

std::vector<std::string> list_robots(const Scenario& scenario) {
  std::vector<std::string> names;
  for (const RobotPlacement& robot : scenario.robots) names.push_back(robot.name);
  return names;
}

std::vector<Mover> make_robots(const RobotDescription& robot, const Scenario& scenario) {
  return make_robots(robot, scenario, make_movers(robot, scenario));
}

std::vector<Mover> make_robots(const RobotDescription& robot, const Scenario& scenario,
                               const std::vector<Mover>& movers) {
  std::vector<Mover> robots(1);
  robots[0].is_robot = true;
  robots[0].robot = robot;
  robots[0].scenario = scenario;
  robots[0].friction = scenario.ground.friction;
  robots[0].first_body = 0;
  std::copy_if(movers.begin(), movers.end(), std::back_inserter(robots),
               [](const Mover& mover) { return mover.is_robot; });
  return robots;
}

const State& find_robot_state(size_t k, const State& first, const ObjectStates& others, const Scenario& scenario) {
  return k == 0 ? first : others.at(scenario.objects.size() + k - 1);
}

ContactForces find_own_forces(const ContactForces& forces, const Mover& robot) {
  ContactForces own;
  for (const PairForce& pair : forces) {
    if (!robot.has(pair.body_a)) continue;
    own.push_back(pair);
    own.back().body_a -= robot.first_body;
    if (robot.has(pair.body_b))
      own.back().body_b -= robot.first_body;
    else if (pair.body_b >= 0)
      own.back().body_b = kFirstObject;
  }
  return own;
}

Scenario place_in_world(const Scenario& own, const RobotPlacement& placement, const Scenario& world) {
  Scenario placed = own;
  set_world(world, &placed);
  placed.initial_rpy.z() += placement.yaw;
  placed.initial_position =
      make_rotation_from_rpy({0.0, 0.0, placement.yaw}) * own.initial_position + placement.position;
  return placed;
}

std::vector<Mover> make_movers(const RobotDescription& robot, const Scenario& scenario) {
  std::vector<Mover> movers;
  for (const ObjectSpec& object : scenario.objects) movers.push_back(make_object(object, robot, scenario));
  if (robot.robots.size() != scenario.robots.size()) {
    refuse(scenario, "robots",
           "names " + std::to_string(scenario.robots.size()) + " robots, the description has " +
               std::to_string(robot.robots.size()));
  }
  for (size_t i = 0; i < robot.robots.size(); ++i)
    movers.push_back(make_other_robot(robot.robots[i], scenario.robots[i], robot, scenario));
  int body = kFirstObject;
  for (Mover& mover : movers) {
    mover.first_body = body;
    body += mover.num_bodies();
    for (PushSpec push : scenario.pushes) {
      push.link = find_own_link(push.link, mover.name, mover.is_robot, mover.robot.tree);
      if (!push.link.empty()) mover.scenario.pushes.push_back(push);
    }
  }
  return movers;
}

}  // namespace hrp
