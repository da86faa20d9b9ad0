// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/scenario_sections.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "common/robot/disturbance_section.h"
#include "common/robot/vision_section.h"
#include "common/robot/walk_section.h"

namespace hrp {
namespace {

struct Absence {
  const char* key;
  const char* text;
};

// What people look for in a scenario and is not there: an unknown key would leave them to search for its name.
void refuse(YamlMap& map, std::initializer_list<Absence> absences) {
  for (const auto& [key, text] : absences) {
    if (!map.has(key)) continue;
    map.ignore(key);
    map.error(key, text);
  }
}

void read_ground_type(YamlMap& map, std::string* type) {
  map.text("type", type);
  if (*type == "mesh" || *type == "height_field") {
    map.error("type",
              "is '" + *type + "', expected plane or none; give an obstacle of shape " + *type + " with 'type: none'");
  } else {
    map.choice("type", type, {"plane", "none"});
  }
}

void read_ground(YamlMap& map, GroundSpec* ground) {
  std::string type = "plane";
  read_ground_type(map, &type);
  ground->present = type == "plane";
  std::string touch = "all";
  map.choice("touch", &touch, {"all", "feet"});
  ground->all_touch = touch == "all";
  map.number("height", &ground->height, Bound::kAny, "m");
  map.number("friction", &ground->friction, Bound::kNotNegative, "");
  map.number("roll", &ground->roll, Bound::kAny, "rad");
  map.number("pitch", &ground->pitch, Bound::kAny, "rad");
  for (const char* key : {"roll", "pitch"}) {
    const double angle = std::string(key) == "roll" ? ground->roll : ground->pitch;
    if (std::abs(angle) > 1.2) map.error(key, "is " + std::to_string(angle) + ", expected at most 1.2 rad either way");
  }
}

void read_contact(YamlMap& map, ContactSpec* contact) {
  map.choice("model", &contact->model, {"spring_damper", "wrench", "impulse"});
  map.number("stiffness", &contact->stiffness, Bound::kPositive, "N/m");
  map.number("exponent", &contact->exponent, Bound::kOneToTen, "");
  map.number("alpha", &contact->alpha, Bound::kNotNegative, "s/m");
  map.number("tangential_damping", &contact->tangential_damping, Bound::kNotNegative, "N s/m");
  map.number("restitution", &contact->restitution, Bound::kUnitInterval, "");
  unsigned long long points = static_cast<unsigned long long>(contact->shared_points);
  map.integer("shared_points", &points);
  if (points < 1 || points > 64) map.error("shared_points", "is " + std::to_string(points) + ", expected 1 to 64");
  contact->shared_points = static_cast<int>(std::min<unsigned long long>(points, 64));
  map.choice("damping", &contact->damping, {"projected", "two_sided"});
  map.number("length_scale", &contact->length_scale, Bound::kPositive, "m");
  map.number("tangential_stiffness", &contact->tangential_stiffness, Bound::kNotNegative, "N/m");
  map.number("margin", &contact->margin, Bound::kNotNegative, "m");
  const bool hard = contact->model == "impulse" || (contact->model == "spring_damper" && contact->exponent != 1.0);
  if (contact->margin > 0.0 && hard) {
    map.error("margin", "goes with model wrench, or spring_damper and exponent 1, only");
  }
}

void read_bush(YamlMap& map, FootBushSpec* bush) {
  map.number("kz", &bush->kz, Bound::kNotNegative, "N/m");
  map.number("cz", &bush->cz, Bound::kNotNegative, "N s/m");
  map.number("k_roll", &bush->k_roll, Bound::kNotNegative, "N m/rad");
  map.number("c_roll", &bush->c_roll, Bound::kNotNegative, "N m s/rad");
  map.number("k_pitch", &bush->k_pitch, Bound::kNotNegative, "N m/rad");
  map.number("c_pitch", &bush->c_pitch, Bound::kNotNegative, "N m s/rad");
  map.number("offset_roll", &bush->offset_roll, Bound::kAny, "N m");
  if (map.has("center")) {
    bush->center = Vector3d::Zero();
    map.vector3("center", &*bush->center, Bound::kAny, "m");
  }
  map.number("upper_mass_ratio", &bush->upper_mass_ratio, Bound::kUnitInterval, "");
  if (bush->upper_mass_ratio == 1.0) map.error("upper_mass_ratio", "is 1: nothing is left for the sole; expected less");
  map.number("hardening_angle", &bush->hardening_angle, Bound::kNotNegative, "rad");
  map.number("offset_pitch", &bush->offset_pitch, Bound::kAny, "N m");
}

void read_surface(YamlMap& map, ObstacleSpec* obstacle) {
  map.require("file",
              obstacle->shape == "mesh" ? "a mesh file (.stl, .obj, .dae)" : "a file of heights (.csv, .png, .pgm)");
  map.text("file", &obstacle->file);
  if (obstacle->shape == "mesh") return map.axes3("scale", &obstacle->scale, Bound::kPositive, "");
  map.require("spacing", "the distance of neighbouring heights [m]");
  map.number("spacing", &obstacle->spacing, Bound::kPositive, "m");
  map.number("low", &obstacle->low, Bound::kAny, "m");
  map.number("high", &obstacle->high, Bound::kAny, "m");
}

// Of a primitive shape.
void read_size(YamlMap& map, const std::string& shape, Vector3d* size) {
  if (shape == "box") {
    map.require("size", "the edges of the box [m]");
    map.vector3("size", size, Bound::kPositive, "m");
    return;
  }
  map.require("radius", "a radius [m]");
  map.number("radius", &size->x(), Bound::kPositive, "m");
  if (shape == "cylinder") map.require("length", "the length along z [m]");
  if (shape == "cylinder") map.number("length", &size->y(), Bound::kPositive, "m");
}

void read_obstacle(YamlMap& map, ObstacleSpec* obstacle) {
  constexpr const char* kFixed = "obstacles are fixed; movable ones are 'objects'";
  refuse(map, {{"mass", kFixed}, {"inertia", kFixed}, {"velocity", kFixed}, {"joint", kFixed}});
  map.choice("shape", &obstacle->shape, {"box", "sphere", "cylinder", "mesh", "height_field"});
  if (obstacle->is_surface()) {
    read_surface(map, obstacle);
  } else {
    read_size(map, obstacle->shape, &obstacle->size);
  }
  Vector3d rpy = Vector3d::Zero();
  map.vector3("position", &obstacle->X_WG.p, Bound::kAny, "m");
  map.vector3("rpy", &rpy, Bound::kAny, "rad");
  obstacle->X_WG.R = make_rotation_from_rpy(rpy);
  map.number("friction", &obstacle->friction, Bound::kNotNegative, "");
  map.vector3("color", &obstacle->color, Bound::kUnitInterval, "");
}

void read_object(YamlMap& map, ObjectSpec* object) {
  map.choice("shape", &object->shape, {"box", "sphere", "cylinder"});
  read_size(map, object->shape, &object->size);
  map.require("mass", "a mass [kg]");
  map.number("mass", &object->mass, Bound::kPositive, "kg");
  map.require("position", "where its middle is at the start [m]");
  Vector3d rpy = Vector3d::Zero(), turning = Vector3d::Zero(), velocity = Vector3d::Zero();
  map.vector3("position", &object->X_WO.p, Bound::kAny, "m");
  map.vector3("rpy", &rpy, Bound::kAny, "rad");
  map.vector3("velocity", &velocity, Bound::kAny, "m/s");
  map.vector3("angular_velocity", &turning, Bound::kAny, "rad/s");
  object->X_WO.R = make_rotation_from_rpy(rpy);
  object->V_WO << turning, velocity;
  map.number("friction", &object->friction, Bound::kNotNegative, "");
  map.vector3("color", &object->color, Bound::kUnitInterval, "");
}

// Names stand in topics and in names of bodies.
bool is_topic_word(const std::string& name) {
  const auto is_good = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  return !name.empty() && std::isalpha(static_cast<unsigned char>(name[0])) != 0 &&
         std::all_of(name.begin(), name.end(), is_good);
}

constexpr size_t kMostOtherRobots = 12;  // of whom the logger keeps topics of their own

void read_placement(YamlMap& map, RobotPlacement* robot) {
  if (!is_topic_word(robot->name)) {
    map.error("",
              "'" + robot->name + "' is no name of a robot, expected a letter, then letters, digits and underscores");
  }
  // Its topics are rt/<robot>/...; these are there already.
  for (const char* topic : {"imu", "wrench"}) {
    if (robot->name == topic)
      map.error("", "'" + robot->name + "' begins the topics of sensors, expected another name");
  }
  map.require("scenario", "the scenario file of this robot");
  map.text("scenario", &robot->scenario);
  map.vector3("position", &robot->position, Bound::kAny, "m");
  map.number("yaw", &robot->yaw, Bound::kAny, "rad");
}

void read_loop(YamlMap& map, LoopSpec* loop) {
  map.choice("kind", &loop->kind, {"ball", "pin", "weld"});
  map.require("link_a", "the name of a link");
  map.text("link_a", &loop->link_a);
  map.text("link_b", &loop->link_b);
  Vector3d rpy_a = Vector3d::Zero(), rpy_b = Vector3d::Zero();
  map.vector3("xyz_a", &loop->X_AF.p, Bound::kAny, "m");
  map.vector3("rpy_a", &rpy_a, Bound::kAny, "rad");
  map.vector3("xyz_b", &loop->X_BF.p, Bound::kAny, "m");
  map.vector3("rpy_b", &rpy_b, Bound::kAny, "rad");
  loop->X_AF.R = make_rotation_from_rpy(rpy_a);
  loop->X_BF.R = make_rotation_from_rpy(rpy_b);
}

void read_gains(YamlMap& map, ServoGains* gains) {
  map.number("kp", &gains->kp, Bound::kNotNegative, "N m/rad or N/m");
  map.number("kd", &gains->kd, Bound::kNotNegative, "N m s/rad or N s/m");
  map.number("effort_limit", &gains->effort_limit, Bound::kNotNegativeOrInfinite, "N m or N");
}

// A motor at a voltage u = kp (q_ref - q) + kd (qd_ref - qd), |u| <= supply, has the current (u - kt qd) / R and the
// torque kt (u - kt qd) / R: a servo with gains kp kt/R, kd kt/R and the limit supply kt/R beside viscous friction
// kt^2/R, the back-EMF. Exact where the inductance is not felt. kt [N m/A] and R [ohm] as the joint sees them.
void read_motor(const std::string& joint, YamlMap& map, ServoGains* gains, Scenario* scenario) {
  double supply = 0.0, resistance = 0.0, constant = 0.0;
  const char* const needed[] = {"supply", "resistance", "torque_constant"};
  for (const char* key : needed)
    map.require(key,
                "a number: 'drive: voltage' gives the torque of a motor from its supply [V], "
                "resistance [ohm] and torque constant [N m/A] at the joint");
  map.number("supply", &supply, Bound::kPositive, "V");
  map.number("resistance", &resistance, Bound::kPositive, "ohm");
  map.number("torque_constant", &constant, Bound::kPositive, "N m/A");
  if (!(resistance > 0.0)) return;
  const double torque = constant / resistance;  // [N m/V]
  gains->kp *= torque;
  gains->kd *= torque;
  gains->effort_limit = std::min(gains->effort_limit, supply * torque);
  scenario->joint_laws[joint].push_back({"viscous_friction", {{"coefficient", constant * torque}}});
}

void read_servo(YamlMap& map, Scenario* scenario) {
  map.child("default", [&](YamlMap& child) { read_gains(child, &scenario->servo_default); });
  map.children("joints", [&](const std::string& joint, YamlMap& child) {
    ServoGains gains = scenario->servo_default;  // what a joint leaves out is the default's
    read_gains(child, &gains);
    if (scenario->drive == "voltage") read_motor(joint, child, &gains, scenario);
    scenario->servo_joints[joint] = gains;
  });
}

void read_initial(YamlMap& map, Scenario* scenario) {
  if (map.has("position")) scenario->initial_height_given = true;
  map.vector3("position", &scenario->initial_position, Bound::kAny, "m");
  map.vector3("rpy", &scenario->initial_rpy, Bound::kAny, "rad");
  map.numbers_by_name("joints", &scenario->initial_joints, Bound::kAny, "rad or m");
}

void read_controller(YamlMap& map, ControllerSpec* controller) {
  if (map.has("motion")) controller->type = "motion";
  map.choice("type", &controller->type, {"hold", "motion", "walk", "none"});
  if (controller->type == "motion") map.require("motion", "the path of a motion file");
  map.text("motion", &controller->motion);
  map.names("joint_order", &controller->joint_order);
  map.choice("on_fault", &controller->on_fault, {"stop", "hold"});
  map.number("timeout", &controller->timeout, Bound::kNotNegative, "s of wall-clock time");
  if (controller->type == "walk") map.require("walk", "the settings of the walk");
  map.child("walk", [&](YamlMap& child) { read_walk(child, &controller->walk); });
}

void read_errors(YamlMap& map, const std::string& unit, SensorErrors* errors) {
  map.axes3("noise", &errors->noise, Bound::kNotNegative, unit);
  map.axes3("bias", &errors->bias, Bound::kAny, unit);
  map.number("delay", &errors->delay, Bound::kNotNegative, "s");
  if (errors->delay > 10.0) map.error("delay", "is " + std::to_string(errors->delay) + " s, expected at most 10 s");
  map.number("clock_skew", &errors->clock_skew, Bound::kAny, "");
  if (std::abs(errors->clock_skew) > 0.1) map.error("clock_skew", "expected at most 0.1 either way");
  map.number("quantum", &errors->quantum, Bound::kNotNegative, unit);
  map.axes3("scale", &errors->scale, Bound::kAny, "");
  map.axes3("misalignment", &errors->misalignment, Bound::kAny, "rad");
}

void read_imu(YamlMap& map, ImuSpec* imu) {
  map.require("link", "the name of a link");
  map.text("link", &imu->link);
  map.vector3("xyz", &imu->p_LS, Bound::kAny, "m");
  map.child("gyro", [&](YamlMap& child) { read_errors(child, "rad/s", &imu->gyro); });
  map.child("accelerometer", [&](YamlMap& child) { read_errors(child, "m/s^2", &imu->accelerometer); });
}

void read_wrench(YamlMap& map, WrenchSpec* wrench) {
  map.require("link", "the name of a link");
  map.text("link", &wrench->link);
  map.ignore("frame");  // says how a recording was written; simulated wrenches are always in link axes
  map.child("force", [&](YamlMap& child) { read_errors(child, "N", &wrench->force); });
  map.child("torque", [&](YamlMap& child) { read_errors(child, "N m", &wrench->torque); });
}

void read_encoders(YamlMap& map, EncoderSpec* encoders) {
  map.number("position_noise", &encoders->position_noise, Bound::kNotNegative, "rad or m");
  map.number("velocity_noise", &encoders->velocity_noise, Bound::kNotNegative, "rad/s or m/s");
  map.number("effort_noise", &encoders->effort_noise, Bound::kNotNegative, "N m or N");
  map.number("position_quantum", &encoders->position_quantum, Bound::kNotNegative, "rad or m");
}

void read_sensors(YamlMap& map, SensorsSpec* sensors) {
  map.named("imu", &sensors->imus, read_imu);
  map.named("wrench", &sensors->wrenches, read_wrench);
  map.child("encoders", [&](YamlMap& child) { read_encoders(child, &sensors->encoders); });
  map.flag("base_pose", &sensors->base_pose);
  map.ignore("base_twist");    // says in which frames a recording has its twist
  map.ignore("joint_torque");  // joints whose recordings have a torque sensor or an encoder behind the gear
  map.ignore("link_encoder");
  read_vision_sensors(map, sensors);
  refuse(map, {{"depth", "a depth camera is a 'camera' with 'depth: true'"}});
}

void read_foot_bush(YamlMap& map, Scenario* scenario) {
  FootBushSpec all_feet;
  if (map.has("default")) {
    map.child("default", [&](YamlMap& child) { read_bush(child, &all_feet); });
    for (const std::string& foot : scenario->feet) scenario->foot_bush[foot] = all_feet;
  }
  map.each([&](const std::string& foot, YamlMap& child) {
    FootBushSpec bush = all_feet;
    read_bush(child, &bush);
    if (!has(scenario->feet, foot)) {
      child.error("", "'" + foot + "' is not in the list of feet");
    }
    scenario->foot_bush[foot] = bush;
  });
}

}  // namespace

void read_world_sections(YamlMap& map, Scenario* scenario) {
  map.child("ground", [&](YamlMap& child) { read_ground(child, &scenario->ground); });
  map.names("feet", &scenario->feet);
  map.children("soles", [&](const std::string& foot, YamlMap& child) {
    SoleSpec sole;
    child.require("box", "the edges of the sole's box [m]");
    child.vector3("box", &sole.box, Bound::kPositive, "m");
    child.vector3("xyz", &sole.p_LG, Bound::kAny, "m");
    child.vector3("rpy", &sole.rpy_LG, Bound::kAny, "rad");
    scenario->soles[foot] = sole;
  });
  unsigned long long points = static_cast<unsigned long long>(scenario->max_sole_points);
  map.integer("max_sole_points", &points);
  if (points < 3 || points > 16) map.error("max_sole_points", "is " + std::to_string(points) + ", expected 3 to 16");
  scenario->max_sole_points = static_cast<int>(std::min<unsigned long long>(points, 16));
  map.child("contact", [&](YamlMap& child) { read_contact(child, &scenario->contact); });
  map.child("foot_bush", [&](YamlMap& child) { read_foot_bush(child, scenario); });
  map.flag("self_collision", &scenario->self_collision);
  map.names_by_name("no_contact", &scenario->no_contact);
  read_disturbance_sections(map, scenario);
  map.named("obstacles", &scenario->obstacles, read_obstacle);
  map.text("world", &scenario->world);
  map.named("objects", &scenario->objects, read_object);
  map.named("robots", &scenario->robots, read_placement);
  if (scenario->robots.size() > kMostOtherRobots) {
    map.error("robots", "names " + std::to_string(scenario->robots.size()) + " robots, expected at most " +
                            std::to_string(kMostOtherRobots));
  }
  const auto refuse_with_impulses = [&](const char* key, bool any) {
    if (any && scenario->contact.model == "impulse")
      map.error(key, "do not go with 'contact: {model: impulse}', expected spring_damper or wrench");
  };
  refuse_with_impulses("objects", !scenario->objects.empty());
  refuse_with_impulses("robots", !scenario->robots.empty());
}

void read_joint_sections(YamlMap& map, Scenario* scenario) {
  map.child("servo", [&](YamlMap& child) { read_servo(child, scenario); });
  map.flag("perfect_joints", &scenario->perfect_joints);
  map.flag("joint_stops", &scenario->joint_stops);
  map.names("unactuated", &scenario->unactuated);
  map.numbers_by_name("rotor_inertia", &scenario->rotor_inertia, Bound::kNotNegative, "kg m^2 or kg");
  map.child("initial", [&](YamlMap& child) { read_initial(child, scenario); });
  map.named("loops", &scenario->loops, read_loop);
  map.child("controller", [&](YamlMap& child) { read_controller(child, &scenario->controller); });
}

void read_sensor_sections(YamlMap& map, Scenario* scenario) {
  map.child("sensors", [&](YamlMap& child) { read_sensors(child, &scenario->sensors); });
  map.child("logging", [&](YamlMap& child) {
    child.text("file", &scenario->logging.file);
    child.choice("compression", &scenario->logging.compression, {"none", "lz4", "zstd"});
    child.flag("pictures", &scenario->logging.pictures);
  });
}

}  // namespace hrp
