// SPDX-License-Identifier: BSD-3-Clause
// A run in one YAML file. Keys shared with experiment folders (docs/scenario.md lists all of them).
#pragma once

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/diagnostics.h"
#include "common/effects/effect_info.h"
#include "common/effects/world_spec.h"
#include "common/robot/vision_spec.h"
#include "common/robot/walk_spec.h"
#include "common/spatial/transform.h"

namespace hrp {

struct ServoGains {
  double kp = 0.0;                                                // [N m/rad or N/m]
  double kd = 0.0;                                                // [N m s/rad or N s/m]
  double effort_limit = std::numeric_limits<double>::infinity();  // [N m or N]
};

struct ObstacleSpec {
  std::string name;
  std::string shape = "box";          // box, sphere, cylinder, mesh, height_field
  Vector3d size = Vector3d::Zero();   // [m] as CollisionShape::size
  std::string file;                   // of a mesh or height field, absolute after loading
  Vector3d scale = Vector3d::Ones();  // of a mesh
  double spacing = 0.0;               // [m] between neighbours of a height field
  double low = 0.0, high = 0.0;       // [m] heights of black and of white, where an image gives the heights
  Transform X_WG;
  double friction = 0.8;
  Vector3d color{0.72, 0.70, 0.66};  // red, green, blue, 0 to 1

  bool is_surface() const { return shape == "mesh" || shape == "height_field"; }
};

// A rigid body of even density that moves freely.
struct ObjectSpec {
  std::string name;
  std::string shape = "box";         // box, sphere, cylinder
  Vector3d size = Vector3d::Zero();  // [m] as CollisionShape::size
  double mass = 0.0;                 // [kg]
  Transform X_WO;                    // at step 0; O: its middle
  Vector6d V_WO = Vector6d::Zero();  // [rad/s; m/s] at step 0
  double friction = 0.8;             // of two bodies the smaller one counts
  Vector3d color{0.80, 0.55, 0.30};  // red, green, blue, 0 to 1
};

// Another robot in the world of the scenario. What it is and how it is driven stands in a scenario of its own, of the
// same steps; of that file's world (ground, obstacles, objects, gravity, contact) nothing counts.
struct RobotPlacement {
  std::string name;
  std::string scenario;                  // YAML file, absolute after loading
  Vector3d position = Vector3d::Zero();  // [m] added to the start pose of that file, after the turn
  double yaw = 0.0;                      // [rad] turn of that start pose about the world's vertical axis
};

struct ImuSpec {
  std::string name, link;            // link: any URDF link
  Vector3d p_LS = Vector3d::Zero();  // [m]
  SensorErrors gyro, accelerometer;
};

struct WrenchSpec {
  std::string name, link;
  SensorErrors force, torque;
};

struct EncoderSpec {
  double position_noise = 0.0, velocity_noise = 0.0, effort_noise = 0.0;  // standard deviations
  double position_quantum = 0.0;
};

struct SensorsSpec {
  std::vector<ImuSpec> imus;
  std::vector<WrenchSpec> wrenches;
  EncoderSpec encoders;
  bool base_pose = false;
  std::vector<CameraSpec> cameras;
  std::vector<LidarSpec> lidars;
  bool every_picture = false;  // the run waits for its pictures: none is dropped

  bool has_vision() const { return !cameras.empty() || !lidars.empty(); }
};

// A joint that closes a chain. Frame A in link_a and frame B in link_b are kept together.
struct LoopSpec {
  std::string name;
  std::string kind = "pin";    // ball: origins; pin: and z axes; weld: and all axes
  std::string link_a, link_b;  // link_b empty: the world
  Transform X_AF, X_BF;
};

// A flat sole that stands in for the collision geometry of a foot link, say because its mesh is missing.
struct SoleSpec {
  Vector3d box = Vector3d::Zero();     // [m] edges
  Vector3d p_LG = Vector3d::Zero();    // [m] centre of the box in the foot link
  Vector3d rpy_LG = Vector3d::Zero();  // [rad]
};

struct ControllerSpec {
  std::string type = "hold";             // hold (initial pose), motion (a motion file), walk, none
  std::string motion;                    // path of a motion file, absolute after loading
  std::vector<std::string> joint_order;  // joints of a motion file without names (.seq), in its order
  std::string on_fault = "stop";         // stop or hold
  double timeout = 0.0;                  // [s] of wall-clock silence after which on_fault acts; 0 = wait for ever
  WalkSpec walk;                         // of type walk
};

// The simulated robot differs from its description, which the controller knows: to see how robust a run is.
struct VariationSpec {
  double mass = 0.0;  // each link's mass and inertia times 1 + uniform(-mass, mass)
  double pose = 0.0;  // [rad] each driven joint's initial position plus uniform(-pose, pose)
  unsigned long long seed = 1;
};

// A force on a link for some time.
struct PushSpec {
  std::string name, link;
  Vector3d p_LQ = Vector3d::Zero();     // [m] where it acts, link axes
  Vector3d force_W = Vector3d::Zero();  // [N] world axes
  double start = 0.0, duration = 0.0;   // [s]
};

// What a hand adds to its place while it sways: amplitude sin(2 pi frequency t + phase), t since the hand took hold;
// grown and faded over `fade` at both ends by a minimum-jerk ramp.
struct HandWave {
  Vector3d amplitude_W = Vector3d::Zero();         // [m]
  double frequency = 0.0, phase = 0.0;             // [Hz], [rad]
  double start = 0.0, duration = 0.0, fade = 1.0;  // [s] since the hand took hold
};

// The hand is here at this time and at rest.
struct HandPoint {
  double time = 0.0;                   // [s] since the hand took hold
  Vector3d p_QH_W = Vector3d::Zero();  // [m] from where it took hold
};

// A hand that holds a point Q of a link: spring and damper between Q and the moving hand H, three axes. Pulls and
// pushes, does not turn. H starts where Q is in the initial pose.
struct HandSpec {
  std::string name, link;
  Vector3d p_LQ = Vector3d::Zero();                                       // [m] link axes
  Vector3d stiffness_W = Vector3d::Zero(), damping_W = Vector3d::Zero();  // [N/m], [N s/m] along world axes
  double start = 0.0, duration = 0.0;                                     // [s]; duration 0: never lets go
  std::vector<HandPoint> path;                                            // times rise
  std::vector<HandWave> waves;
};

struct LoggingSpec {
  std::string file;                  // empty: chosen by the launcher
  std::string compression = "zstd";  // none, lz4, zstd
  bool pictures = false;             // pictures and scans, too; the run then waits for them
};

struct Scenario {
  // In scenario.cpp: written out wherever a scenario is copied or ends, they were a fortieth of all code.
  Scenario();
  Scenario(const Scenario&);
  Scenario(Scenario&&) noexcept;
  Scenario& operator=(const Scenario&);
  Scenario& operator=(Scenario&&) noexcept;
  ~Scenario();

  std::string path;   // of the YAML file, for messages
  std::string text;   // the YAML text as it was read
  std::string robot;  // URDF, MJCF or SDF file, absolute after loading
  bool floating_base = true;
  std::string drive = "servo";
  Vector3d gravity_W{0, 0, -9.81};  // [m/s^2]
  GroundSpec ground;
  std::vector<std::string> feet;
  ServoGains servo_default;
  std::map<std::string, ServoGains> servo_joints;
  bool perfect_joints = false;                   // joints follow their references exactly
  Vector3d initial_position = Vector3d::Zero();  // [m] base; z is found from the feet when not given
  bool initial_height_given = false;
  Vector3d initial_rpy = Vector3d::Zero();       // [rad]
  std::map<std::string, double> initial_joints;  // [rad or m]
  SensorsSpec sensors;
  std::vector<std::string> unactuated;
  std::map<std::string, double> rotor_inertia;  // [kg m^2] overrides the URDF's
  double time_step = 0.001;                     // [s]
  int control_period = 5;                       // steps between two sensor samples / commands
  double duration = 0.0;                        // [s] 0 = until stopped
  std::string integrator = "implicit";          // implicit, semi_implicit_euler, rk4
  std::string interpolation = "linear";         // of commands within a control period: hold, linear, hermite
  bool joint_stops = false;                     // stops at the joint limits of the URDF
  ContactSpec contact;
  std::map<std::string, FootBushSpec> foot_bush;                // by foot link
  std::map<std::string, std::vector<StatedEffect>> joint_laws;  // by joint
  std::map<std::string, std::vector<StatedEffect>> link_laws;   // by link
  std::vector<LoopSpec> loops;
  bool self_collision = false;
  // Link, obstacle or "ground" -> those that it never touches, or "all"
  std::map<std::string, std::vector<std::string>> no_contact;
  std::vector<ObstacleSpec> obstacles;
  std::vector<ObjectSpec> objects;
  std::vector<RobotPlacement> robots;  // other robots
  std::string world;  // SDF file whose static models become obstacles, absolute after loading; empty: none
  std::map<std::string, SoleSpec> soles;  // by foot link
  int max_sole_points = 4;                // contact points kept per sole and plane, 3 to 16
  bool repair_inertias = false;
  VariationSpec variation;
  std::vector<PushSpec> pushes;
  std::vector<HandSpec> hands;
  ControllerSpec controller;
  LoggingSpec logging;
  unsigned long long seed = 1;

  // Where each key that was read stands: key path -> line, column (both from 1). For messages of later checks.
  std::map<std::string, std::pair<int, int>> marks;
  // A diagnostic that points at `key_path` (or the nearest key above it).
  Diagnostic make_diagnostic(const std::string& key_path, const std::string& message) const;
};

// The scenario in `path`; relative file names in it are taken from its folder. Throws InputError with everything that
// is wrong: file, line, column, key, value, what was expected. Also checks that the files it names exist.
Scenario load_scenario(const std::string& path);

// As load_scenario() from text that was read from `path` before; does not look for the files it names.
Scenario parse_scenario(const std::string& text, const std::string& path);

// `text` with initial.joints set to these positions [rad or m]: YAML that reads as before otherwise.
std::string set_initial_joints(const std::string& text, const std::map<std::string, double>& joints);

}  // namespace hrp
