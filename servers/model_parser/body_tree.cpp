// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/body_tree.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <set>
#include <sstream>

#include "common/base/escape_xml.h"
#include "common/multibody/joint_motion.h"
#include "common/spatial/rpy.h"

namespace hrp {
namespace {

// URDF has no slide with one limit or none.
constexpr double kFar = 1e9;  // [rad or m]

std::string print(double value) {
  std::ostringstream text;
  text << std::setprecision(17) << value;
  return text.str();
}

std::string print(const Vector3d& v) { return print(v.x()) + " " + print(v.y()) + " " + print(v.z()); }

bool is_identity(const Transform& X) { return X.R.isIdentity(0.0) && X.p.isZero(0.0); }

std::string print_origin(const Transform& X) {
  if (is_identity(X)) return "";
  return "<origin xyz=\"" + print(X.p) + "\" rpy=\"" + print(calc_rpy(X.R)) + "\"/>";
}

class Writer {
 public:
  UrdfText write(const BodyTree& tree, const std::string& source) {
    for (const Body& body : tree.bodies) names_.insert(body.name);
    put(0, "<?xml version=\"1.0\"?>");
    put(0, "<!-- Made from " + escape_xml(source) + ". -->");
    put(0, "<robot name=\"" + escape_xml(tree.name) + "\">");
    for (const Body& body : tree.bodies) write_body(body);
    put(0, "</robot>");
    return std::move(urdf_);
  }

 private:
  void put(int line, const std::string& text) {
    urdf_.text += text + "\n";
    urdf_.source_lines.push_back(line);
  }

  // A name that no link has yet: a number is added to one that is taken.
  std::string claim(const std::string& wanted) {
    std::string name = wanted;
    for (int i = 2; !names_.insert(name).second; ++i) name = wanted + "_" + std::to_string(i);
    return name;
  }

  void write_body(const Body& body) {
    if (!body.parent.empty() || !body.joints.empty()) write_way_to(body);
    write_link(body);
    for (const BodyFrame& frame : body.frames) {
      const std::string name = claim(frame.name);
      put(frame.line, "  <link name=\"" + escape_xml(name) + "\"/>");
      write_fixed(body.name, name, frame.X_BS, frame.line);
    }
  }

  // Joints, and links between them, from the parent to the body.
  void write_way_to(const Body& body) {
    std::string at = body.parent;
    Transform X_CB = body.X_PB;  // the body in the link that was reached, in the pose that the file shows
    for (size_t i = 0; i < body.joints.size(); ++i) {
      const BodyJoint& joint = body.joints[i];
      const bool last = i + 1 == body.joints.size() && is_identity(joint.X_BF);
      const std::string child = last ? body.name : claim(joint.spec.name + "_link");
      if (!last) put(joint.line, "  <link name=\"" + escape_xml(child) + "\"/>");
      write_joint(joint, at, child, X_CB * joint.X_BF * calc_joint_motion(joint.spec, -joint.shown));
      X_CB = joint.X_BF.inverse();
      at = child;
      if (last) return;
    }
    write_fixed(at, body.name, X_CB, body.line);
  }

  void write_fixed(const std::string& parent, const std::string& child, const Transform& X, int line) {
    put(line, "  <joint name=\"" + escape_xml(child) + "_fixed\" type=\"fixed\"><parent link=\"" + escape_xml(parent) +
                  "\"/><child link=\"" + escape_xml(child) + "\"/>" + print_origin(X) + "</joint>");
  }

  void write_joint(const BodyJoint& joint, const std::string& parent, const std::string& child, const Transform& X_PF) {
    const JointSpec& spec = joint.spec;
    const bool slides = spec.kind == JointKind::kPrismatic;
    const bool limited = std::isfinite(spec.lower) || std::isfinite(spec.upper);
    const char* type = slides ? "prismatic" : limited ? "revolute" : "continuous";
    put(joint.line, "  <joint name=\"" + escape_xml(spec.name) + "\" type=\"" + type + "\">");
    put(joint.line, "    <parent link=\"" + escape_xml(parent) + "\"/><child link=\"" + escape_xml(child) + "\"/>" +
                        print_origin(X_PF));
    put(joint.line, "    <axis xyz=\"" + print(spec.axis_F) + "\"/>");
    std::string limits;
    if (slides || limited) {
      limits =
          "lower=\"" + print(std::max(spec.lower, -kFar)) + "\" upper=\"" + print(std::min(spec.upper, kFar)) + "\" ";
    }
    put(joint.line, "    <limit " + limits + "effort=\"" + print_limit(spec.effort_limit) + "\" velocity=\"" +
                        print_limit(spec.velocity_limit) + "\"/>");
    write_laws(joint);
    put(joint.line, "  </joint>");
  }

  // 0: no limit, as URDF readers take it.
  static std::string print_limit(double limit) { return std::isfinite(limit) ? print(limit) : "0"; }

  void write_laws(const BodyJoint& joint) {
    const JointSpec& spec = joint.spec;
    if (spec.viscous_friction != 0.0 || spec.coulomb_friction != 0.0) {
      put(joint.line, "    <dynamics damping=\"" + print(spec.viscous_friction) + "\" friction=\"" +
                          print(spec.coulomb_friction) + "\"/>");
    }
    if (spec.rotor_inertia != 0.0) put(joint.line, "    <rotor inertia=\"" + print(spec.rotor_inertia) + "\"/>");
    if (spec.spring.stiffness != 0.0) {
      put(joint.line,
          "    <spring stiffness=\"" + print(spec.spring.stiffness) + "\" rest=\"" + print(spec.spring.rest) + "\"/>");
    }
    if (!spec.actuated) put(joint.line, "    <unactuated/>");
    if (!joint.follows.empty()) {
      put(joint.line, "    <mimic joint=\"" + escape_xml(joint.follows) + "\" multiplier=\"" + print(joint.multiplier) +
                          "\" offset=\"" + print(joint.offset) + "\"/>");
    }
  }

  void write_link(const Body& body) {
    put(body.line, "  <link name=\"" + escape_xml(body.name) + "\">");
    if (body.inertia.mass != 0.0) write_inertia(body);
    const bool drawn =
        std::any_of(body.shapes.begin(), body.shapes.end(), [](const BodyShape& s) { return !s.touches; });
    for (const BodyShape& shape : body.shapes) {
      if (shape.touches) write_shape(shape, "collision");
      if (!shape.touches || !drawn) write_shape(shape, "visual");
    }
    put(0, "  </link>");
  }

  void write_inertia(const Body& body) {
    const Matrix3d& I = body.inertia.I_LLcm_L;
    put(body.line, "    <inertial><origin xyz=\"" + print(body.inertia.p_LLcm_L) + "\"/><mass value=\"" +
                       print(body.inertia.mass) + "\"/><inertia ixx=\"" + print(I(0, 0)) + "\" ixy=\"" +
                       print(I(0, 1)) + "\" ixz=\"" + print(I(0, 2)) + "\" iyy=\"" + print(I(1, 1)) + "\" iyz=\"" +
                       print(I(1, 2)) + "\" izz=\"" + print(I(2, 2)) + "\"/></inertial>");
  }

  static std::string print_geometry(const CollisionShape& shape) {
    switch (shape.kind) {
      case ShapeKind::kBox: return "<box size=\"" + print(shape.size) + "\"/>";
      case ShapeKind::kSphere: return "<sphere radius=\"" + print(shape.size.x()) + "\"/>";
      case ShapeKind::kCylinder:
        return "<cylinder radius=\"" + print(shape.size.x()) + "\" length=\"" + print(shape.size.y()) + "\"/>";
      case ShapeKind::kMesh: break;
    }
    return "<mesh filename=\"" + escape_xml(shape.mesh) + "\" scale=\"" + print(shape.scale) + "\"/>";
  }

  void write_shape(const BodyShape& shape, const std::string& as) {
    std::string color;
    if (as == "visual") {
      color = "<material name=\"\"><color rgba=\"" + print(Vector3d(shape.color.head<3>())) + " " +
              print(shape.color[3]) + "\"/></material>";
    }
    put(shape.line, "    <" + as + ">" + print_origin(shape.shape.X_LG) + "<geometry>" + print_geometry(shape.shape) +
                        "</geometry>" + color + "</" + as + ">");
  }

  UrdfText urdf_;
  std::set<std::string> names_;  // of links
};

}  // namespace

void add_capsule(double radius, double length, const BodyShape& shape, Body* body) {
  BodyShape part = shape;
  part.shape.kind = ShapeKind::kCylinder;
  part.shape.size = {radius, length, 0.0};
  body->shapes.push_back(part);
  part.shape.kind = ShapeKind::kSphere;
  part.shape.size = {radius, 0.0, 0.0};
  for (const double z : {-0.5 * length, 0.5 * length}) {
    part.shape.X_LG.p = shape.shape.X_LG * Vector3d(0.0, 0.0, z);
    body->shapes.push_back(part);
  }
}

UrdfText make_urdf(const BodyTree& tree, const std::string& source) { return Writer().write(tree, source); }

}  // namespace hrp
