// SPDX-License-Identifier: BSD-3-Clause
#include "servers/mujoco_dynamics/mjcf.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace hrp {
namespace {

[[noreturn]] void refuse(const Scenario& scenario, const std::string& key, const std::string& message) {
  throw InputError(scenario.make_diagnostic(key, message));
}

void check_supported(const Scenario& scenario) {
  const char* hint = " is not in the MuJoCo dynamics server; use hrp-dynamics";
  if (scenario.drive != "servo") refuse(scenario, "drive", "drive '" + scenario.drive + "'" + hint);
  if (scenario.perfect_joints) refuse(scenario, "servo", std::string("perfect joints: this") + hint);
  if (!scenario.foot_bush.empty()) refuse(scenario, "foot_bush", std::string("a foot bush") + hint);
  if (!scenario.joint_laws.empty()) refuse(scenario, "joint_laws", std::string("an extra joint law") + hint);
  if (!scenario.link_laws.empty()) refuse(scenario, "link_laws", std::string("an effect of a link") + hint);
  for (const ObstacleSpec& obstacle : scenario.obstacles) {
    if (obstacle.is_surface())
      refuse(scenario, "obstacles." + obstacle.name, std::string("a surface of triangles") + hint);
  }
  if (!scenario.robots.empty())
    refuse(scenario, "robots." + scenario.robots[0].name, std::string("another robot") + hint);
  if (!scenario.objects.empty())
    refuse(scenario, "objects." + scenario.objects[0].name, std::string("a movable object") + hint);
  if (scenario.joint_stops) refuse(scenario, "joint_stops", std::string("a stop at the joints' limits") + hint);
  if (scenario.self_collision) refuse(scenario, "self_collision", std::string("contact between links") + hint);
  if (scenario.variation.mass != 0.0 || scenario.variation.pose != 0.0)
    refuse(scenario, "variation", std::string("a random variation of the robot") + hint);
  if (!scenario.no_contact.empty()) refuse(scenario, "no_contact", std::string("a filter of contacts") + hint);
  if (!scenario.loops.empty())
    refuse(scenario, "loops", std::string("a closed chain ('loops', or <loop> in the URDF)") + hint);
}

class MjcfWriter {
 public:
  MjcfWriter(const RobotDescription& robot, const Scenario& scenario) : robot_(robot), scenario_(scenario) {
    out_ << std::setprecision(17);
  }

  std::string write() {
    // impratio: what sticks creeps at force over damping; a hundred times the normal damping holds what two feet press
    // against each other, as the scenario's tangential spring does.
    out_ << "<mujoco>\n<compiler angle=\"radian\" inertiafromgeom=\"false\" boundmass=\"0\"/>\n<option timestep=\""
         << scenario_.time_step << "\" integrator=\"implicit\" cone=\"elliptic\" impratio=\"100\"";
    put("gravity", scenario_.gravity_W);
    // Soles have the scenario's law where that is a spring and a damper (ground_law.h); this holds for the others.
    // MuJoCo calls two time steps stable.
    out_ << "/>\n<default><geom condim=\"3\" solref=\"" << std::max(0.005, 2 * scenario_.time_step)
         << " 1\" contype=\"0\" conaffinity=\"0\"/></default>\n";
    write_meshes();
    out_ << "<worldbody>\n";
    write_ground();
    for (size_t i = 0; i < scenario_.obstacles.size(); ++i) write_obstacle(i);
    write_body(0);
    out_ << "</worldbody>\n";
    write_mimics();
    write_actuators();
    write_sensors();
    out_ << "</mujoco>\n";
    return out_.str();
  }

 private:
  template <typename Vector>
  void put(const char* name, const Vector& values) {
    out_ << " " << name << "=\"";
    for (Eigen::Index i = 0; i < values.size(); ++i) out_ << (i > 0 ? " " : "") << values[i];
    out_ << "\"";
  }

  void put_pose(const Transform& X) {
    const Eigen::Quaterniond q(X.R);
    put("pos", X.p);
    put("quat", Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()));
  }

  // Sizes of ours are edges and lengths; MuJoCo's are halves.
  void put_shape(const std::string& shape, const Vector3d& size) {
    out_ << " type=\"" << shape << "\"";
    if (shape == "box") put("size", Vector3d(size / 2));
    if (shape == "sphere") out_ << " size=\"" << size.x() << "\"";
    if (shape == "cylinder") put("size", Eigen::Vector2d(size.x(), size.y() / 2));
  }

  void put_friction(double friction) { out_ << " friction=\"" << friction << " 0 0\""; }

  void write_meshes() {
    out_ << "<asset>\n";
    for (size_t i = 0; i < robot_.shapes.size(); ++i) {
      const CollisionShape& shape = robot_.shapes[i];
      if (!shape.sole || shape.kind != ShapeKind::kMesh) continue;
      const std::string ending = shape.mesh.substr(shape.mesh.find_last_of('.') + 1);
      if (ending != "stl" && ending != "STL" && ending != "obj") {
        refuse(scenario_, "robot",
               "sole '" + shape.name + "' is the mesh " + shape.mesh +
                   "; the MuJoCo dynamics server reads .stl and .obj only (soles: gives it a box)");
      }
      out_ << "<mesh name=\"m" << i << "\" file=\"" << shape.mesh << "\"";
      put("scale", shape.scale);
      out_ << "/>\n";
    }
    out_ << "</asset>\n";
  }

  void write_ground() {
    if (!scenario_.ground.present) return;
    const GroundSpec& ground = scenario_.ground;
    const Transform X_WG{make_rotation_from_rpy({ground.roll, ground.pitch, 0}), {0, 0, ground.height}};
    out_ << "<geom name=\"ground\" type=\"plane\" size=\"0 0 1\" contype=\"2\" conaffinity=\"1\"";
    put_pose(X_WG);
    put_friction(ground.friction);
    out_ << "/>\n";
  }

  void write_obstacle(size_t i) {
    const ObstacleSpec& obstacle = scenario_.obstacles[i];
    out_ << "<geom name=\"obstacle" << i << "\" contype=\"2\" conaffinity=\"1\"";
    put_shape(obstacle.shape, obstacle.size);
    put_pose(obstacle.X_WG);
    put_friction(obstacle.friction);
    out_ << "/>\n";
  }

  void write_body(int link) {
    const LinkSpec& L = robot_.tree.links[static_cast<size_t>(link)];
    out_ << "<body name=\"b" << link << "\"";
    if (link > 0)
      put_pose(L.joint.X_PF);
    else if (!robot_.tree.floating_base)
      put_pose({make_rotation_from_rpy(scenario_.initial_rpy), scenario_.initial_position});
    out_ << ">\n";
    if (link > 0) write_joint(L.joint, link - 1);
    if (link == 0 && robot_.tree.floating_base) out_ << "<freejoint name=\"base\"/>\n";
    write_inertia(L.inertia);
    for (size_t i = 0; i < robot_.shapes.size(); ++i) {
      if (robot_.shapes[i].link == link && robot_.shapes[i].sole) write_sole(i);
    }
    write_sites(link);
    for (size_t child = static_cast<size_t>(link) + 1; child < robot_.tree.links.size(); ++child) {
      if (robot_.tree.links[child].parent == link) write_body(static_cast<int>(child));
    }
    out_ << "</body>\n";
  }

  void write_joint(const JointSpec& joint, int i) {
    out_ << "<joint name=\"j" << i << "\" type=\"" << (joint.kind == JointKind::kPrismatic ? "slide" : "hinge") << "\"";
    put("axis", joint.axis_F);
    out_ << " armature=\"" << joint.rotor_inertia << "\" damping=\"" << joint.viscous_friction + joint.spring.damping
         << "\" frictionloss=\"" << joint.coulomb_friction << "\" stiffness=\"" << joint.spring.stiffness
         << "\" springref=\"" << joint.spring.rest << "\"/>\n";
  }

  void write_inertia(const LinkInertia& inertia) {
    if (inertia.mass == 0) return;
    const Matrix3d& I = inertia.I_LLcm_L;
    Eigen::Matrix<double, 6, 1> full;
    full << I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2);
    out_ << "<inertial mass=\"" << inertia.mass << "\"";
    put("pos", inertia.p_LLcm_L);
    put("fullinertia", full);
    out_ << "/>\n";
  }

  void write_sole(size_t i) {
    const CollisionShape& shape = robot_.shapes[i];
    out_ << "<geom contype=\"1\" conaffinity=\"2\"";
    if (shape.kind == ShapeKind::kMesh) {
      out_ << " type=\"mesh\" mesh=\"m" << i << "\"";
    } else {
      put_shape(shape.kind == ShapeKind::kBox      ? "box"
                : shape.kind == ShapeKind::kSphere ? "sphere"
                                                   : "cylinder",
                shape.size);
    }
    put_pose(shape.X_LG);
    put_friction(0.0);  // the larger one of the two counts: that of what is stood on
    out_ << "/>\n";
  }

  const FrameSpec& find_frame(const std::string& key, const std::string& name) const {
    const int frame = robot_.tree.find_frame(name);
    if (frame < 0) refuse(scenario_, key, "no link '" + name + "'");
    return robot_.tree.frames[static_cast<size_t>(frame)];
  }

  void write_sites(int link) {
    const SensorsSpec& sensors = scenario_.sensors;
    for (size_t i = 0; i < sensors.imus.size(); ++i) {
      const FrameSpec& frame = find_frame("sensors.imu", sensors.imus[i].link);
      if (frame.link == link)
        write_site("imu" + std::to_string(i), frame.X_LF * Transform{Matrix3d::Identity(), sensors.imus[i].p_LS});
    }
    for (size_t i = 0; i < sensors.wrenches.size(); ++i) {
      const FrameSpec& frame = find_frame("sensors.wrench", sensors.wrenches[i].link);
      if (frame.link == link) write_site("wrench" + std::to_string(i), frame.X_LF);
    }
  }

  void write_site(const std::string& name, const Transform& X_LS) {
    out_ << "<site name=\"" << name << "\"";
    put_pose(X_LS);
    out_ << "/>\n";
  }

  void write_mimics() {
    out_ << "<equality>\n";
    for (int i = 0; i < robot_.tree.num_joints(); ++i) {
      const MimicSpec& mimic = robot_.tree.joint(i).mimic;
      if (mimic.joint < 0) continue;
      out_ << "<joint joint1=\"j" << i << "\" joint2=\"j" << mimic.joint << "\" polycoef=\"" << mimic.offset << " "
           << mimic.multiplier << " 0 0 0\"/>\n";
    }
    out_ << "</equality>\n";
  }

  // effort = ctrl - kp q - kd qd, clamped, with ctrl = kp q_ref + kd qd_ref + feed-forward. The part in qd is
  // integrated implicitly by the integrator "implicit".
  void write_actuators() {
    out_ << "<actuator>\n";
    for (int i = 0; i < robot_.tree.num_joints(); ++i) {
      const JointSpec& joint = robot_.tree.joint(i);
      const auto found = scenario_.servo_joints.find(joint.name);
      const ServoGains& gains = found == scenario_.servo_joints.end() ? scenario_.servo_default : found->second;
      const double limit = std::isfinite(gains.effort_limit) ? gains.effort_limit : joint.effort_limit;
      const bool driven = joint.actuated && joint.mimic.joint < 0;
      out_ << "<general name=\"j" << i << "\" joint=\"j" << i << "\" biastype=\"affine\" gainprm=\"" << (driven ? 1 : 0)
           << "\" biasprm=\"0 " << (driven ? -gains.kp : 0.0) << " " << (driven ? -gains.kd : 0.0) << "\"";
      if (std::isfinite(limit)) out_ << " forcelimited=\"true\" forcerange=\"" << -limit << " " << limit << "\"";
      out_ << "/>\n";
    }
    out_ << "</actuator>\n";
  }

  void write_sensors() {
    out_ << "<sensor>\n";
    for (size_t i = 0; i < scenario_.sensors.imus.size(); ++i) {
      out_ << "<gyro name=\"imu" << i << "_gyro\" site=\"imu" << i << "\"/>\n<accelerometer name=\"imu" << i
           << "_accelerometer\" site=\"imu" << i << "\"/>\n";
    }
    for (size_t i = 0; i < scenario_.sensors.wrenches.size(); ++i) {
      out_ << "<force name=\"wrench" << i << "_force\" site=\"wrench" << i << "\"/>\n<torque name=\"wrench" << i
           << "_torque\" site=\"wrench" << i << "\"/>\n";
    }
    out_ << "</sensor>\n";
  }

  const RobotDescription& robot_;
  const Scenario& scenario_;
  std::ostringstream out_;
};

}  // namespace

std::string make_mjcf(const RobotDescription& robot, const Scenario& scenario) {
  check_supported(scenario);
  return MjcfWriter(robot, scenario).write();
}

}  // namespace hrp
