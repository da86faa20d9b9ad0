// SPDX-License-Identifier: BSD-3-Clause
#include "common/messages/convert_robot.h"

#include "common/base/diagnostics.h"
#include "common/messages/cdr.h"
#include "common/messages/convert.h"

namespace hrp {
namespace {

// The rotation of a pose comes back as it was up to rounding; models are made from what came back, on every server the
// same, so runs stay equal to the bit wherever the description was sent through.
void set_link(const LinkSpec& link, msg::LinkDescription* m) {
  m->name(link.name);
  m->parent(link.parent);
  m->mass(link.inertia.mass);
  m->p_LLcm_L(to_message(link.inertia.p_LLcm_L));
  const Matrix3d& I = link.inertia.I_LLcm_L;
  m->inertia_LLcm_L({I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)});
}

LinkSpec get_link(const msg::LinkDescription& m) {
  LinkSpec link;
  link.name = m.name();
  link.parent = m.parent();
  link.inertia.mass = m.mass();
  link.inertia.p_LLcm_L = from_message(m.p_LLcm_L());
  const auto& I = m.inertia_LLcm_L();
  link.inertia.I_LLcm_L << I[0], I[3], I[4], I[3], I[1], I[5], I[4], I[5], I[2];
  return link;
}

void set_joint(const JointSpec& joint, msg::JointDescription* m) {
  m->name(joint.name);
  m->kind(joint.kind == JointKind::kPrismatic ? msg::JOINT_PRISMATIC : msg::JOINT_REVOLUTE);
  m->X_PF(to_message(joint.X_PF));
  m->axis_F(to_message(joint.axis_F));
  m->lower(joint.lower);
  m->upper(joint.upper);
  m->effort_limit(joint.effort_limit);
  m->velocity_limit(joint.velocity_limit);
  m->rotor_inertia(joint.rotor_inertia);
  m->viscous_friction(joint.viscous_friction);
  m->coulomb_friction(joint.coulomb_friction);
  m->actuated(joint.actuated);
  m->mimic_joint(joint.mimic.joint);
  m->mimic_multiplier(joint.mimic.multiplier);
  m->mimic_offset(joint.mimic.offset);
  m->spring_stiffness(joint.spring.stiffness);
  m->spring_damping(joint.spring.damping);
  m->spring_rest(joint.spring.rest);
}

JointSpec get_joint(const msg::JointDescription& m) {
  JointSpec joint;
  joint.name = m.name();
  joint.kind = m.kind() == msg::JOINT_PRISMATIC ? JointKind::kPrismatic : JointKind::kRevolute;
  joint.X_PF = from_message(m.X_PF());
  joint.axis_F = from_message(m.axis_F());
  joint.lower = m.lower();
  joint.upper = m.upper();
  joint.effort_limit = m.effort_limit();
  joint.velocity_limit = m.velocity_limit();
  joint.rotor_inertia = m.rotor_inertia();
  joint.viscous_friction = m.viscous_friction();
  joint.coulomb_friction = m.coulomb_friction();
  joint.actuated = m.actuated();
  joint.mimic = {m.mimic_joint(), m.mimic_multiplier(), m.mimic_offset()};
  joint.spring = {m.spring_stiffness(), m.spring_damping(), m.spring_rest()};
  return joint;
}

msg::ShapeKind to_kind(ShapeKind kind) {
  switch (kind) {
    case ShapeKind::kBox: return msg::SHAPE_BOX;
    case ShapeKind::kSphere: return msg::SHAPE_SPHERE;
    case ShapeKind::kCylinder: return msg::SHAPE_CYLINDER;
    case ShapeKind::kMesh: return msg::SHAPE_MESH;
  }
  return msg::SHAPE_BOX;
}

ShapeKind from_kind(msg::ShapeKind kind) {
  switch (kind) {
    case msg::SHAPE_SPHERE: return ShapeKind::kSphere;
    case msg::SHAPE_CYLINDER: return ShapeKind::kCylinder;
    case msg::SHAPE_MESH: return ShapeKind::kMesh;
    default: return ShapeKind::kBox;
  }
}

void set_shape(const CollisionShape& shape, msg::CollisionShape* m) {
  m->link(shape.link);
  m->name(shape.name);
  m->kind(to_kind(shape.kind));
  m->X_LG(to_message(shape.X_LG));
  m->size(to_message(shape.size));
  m->mesh(shape.mesh);
  m->scale(to_message(shape.scale));
  m->sole(shape.sole);
}

CollisionShape get_shape(const msg::CollisionShape& m) {
  CollisionShape shape;
  shape.link = m.link();
  shape.name = m.name();
  shape.kind = from_kind(m.kind());
  shape.X_LG = from_message(m.X_LG());
  shape.size = from_message(m.size());
  shape.mesh = m.mesh();
  shape.scale = from_message(m.scale());
  shape.sole = m.sole();
  return shape;
}

void set_visual(const VisualShape& visual, msg::VisualShape* m) {
  set_shape(visual.shape, &m->shape());
  m->color({visual.color.x(), visual.color.y(), visual.color.z()});
}

VisualShape get_visual(const msg::VisualShape& m) {
  return {get_shape(m.shape()), Vector3d(m.color()[0], m.color()[1], m.color()[2])};
}

void set_surface(const Surface& surface, msg::SurfaceDescription* m) {
  m->obstacle(surface.obstacle);
  for (const Vector3d& v : surface.mesh.vertices) m->vertices().push_back(to_message(v));
  for (const auto& triangle : surface.mesh.triangles)
    m->triangles().insert(m->triangles().end(), triangle.begin(), triangle.end());
  m->columns(surface.columns);
  m->rows(surface.rows);
  m->spacing(surface.spacing);
  m->heights(surface.heights);
}

[[noreturn]] void refuse(const std::string& field, const std::string& message) {
  refuse_input({"robot_description", field}, message);
}

void check_references(const RobotDescription& robot) {
  const int links = static_cast<int>(robot.tree.links.size());
  if (links == 0) refuse("links", "none");
  for (int i = 1; i < links; ++i) {
    const LinkSpec& link = robot.tree.links[static_cast<size_t>(i)];
    if (link.parent < 0 || link.parent >= i) refuse("link '" + link.name + "'", "its parent does not stand before it");
    if (link.joint.mimic.joint >= links - 1) refuse("joint '" + link.joint.name + "'", "follows an unknown joint");
  }
  for (const FrameSpec& frame : robot.tree.frames) {
    if (frame.link < 0 || frame.link >= links) refuse("frame '" + frame.name + "'", "unknown link");
  }
  for (const CollisionShape& shape : robot.shapes) {
    if (shape.link < 0 || shape.link >= links) refuse("shape '" + shape.name + "'", "unknown link");
  }
  for (const VisualShape& visual : robot.visuals) {
    if (visual.shape.link < 0 || visual.shape.link >= links)
      refuse("visual '" + visual.shape.name + "'", "unknown link");
  }
}

void set_other_robot(const OtherRobot& other, msg::OtherRobotDescription* m) {
  msg::RobotDescription description;
  to_message(other.description, &description);
  std::vector<char> buffer;
  const Bytes bytes = encode(description, &buffer);
  m->name(other.name);
  m->description().assign(bytes.data, bytes.data + bytes.size);
}

// Depth is bounded: of a robot within a robot no further ones are read.
OtherRobot get_other_robot(const msg::OtherRobotDescription& m) {
  msg::RobotDescription description;
  try {
    decode({m.description().data(), m.description().size()}, &description);
  } catch (const DecodeError& error) {
    refuse("robot '" + m.name() + "'", std::string("its description cannot be read: ") + error.what());
  }
  description.robots().clear();
  OtherRobot other;
  other.name = m.name();
  from_message(description, &other.description);
  return other;
}

}  // namespace

Surface from_message(const msg::SurfaceDescription& m) {
  Surface surface;
  surface.obstacle = m.obstacle();
  for (const msg::Vector3& v : m.vertices()) surface.mesh.vertices.push_back(from_message(v));
  for (size_t i = 0; i + 2 < m.triangles().size(); i += 3) {
    surface.mesh.triangles.push_back({m.triangles()[i], m.triangles()[i + 1], m.triangles()[i + 2]});
  }
  surface.columns = m.columns();
  surface.rows = m.rows();
  surface.spacing = m.spacing();
  surface.heights = m.heights();
  const std::string fault = find_surface_fault(surface);
  if (!fault.empty()) refuse("surface '" + surface.obstacle + "'", fault);
  return surface;
}

void to_message(const RobotDescription& robot, msg::RobotDescription* message) {
  const TreeSpec& tree = robot.tree;
  message->name(tree.name);
  message->urdf_path(robot.urdf_path);
  message->urdf(robot.urdf);
  message->scenario_path(robot.scenario_path);
  message->scenario(robot.scenario);
  message->floating_base(tree.floating_base);
  message->links().resize(tree.links.size());
  message->joints().resize(tree.links.empty() ? 0 : tree.links.size() - 1);
  for (size_t i = 0; i < tree.links.size(); ++i) {
    set_link(tree.links[i], &message->links()[i]);
    if (i > 0) set_joint(tree.links[i].joint, &message->joints()[i - 1]);
  }
  message->frames().resize(tree.frames.size());
  for (size_t i = 0; i < tree.frames.size(); ++i) {
    message->frames()[i].name(tree.frames[i].name);
    message->frames()[i].link(tree.frames[i].link);
    message->frames()[i].X_LF(to_message(tree.frames[i].X_LF));
  }
  message->shapes().resize(robot.shapes.size());
  for (size_t i = 0; i < robot.shapes.size(); ++i) set_shape(robot.shapes[i], &message->shapes()[i]);
  message->surfaces().resize(robot.surfaces.size());
  for (size_t i = 0; i < robot.surfaces.size(); ++i) set_surface(*robot.surfaces[i], &message->surfaces()[i]);
  message->visuals().resize(robot.visuals.size());
  for (size_t i = 0; i < robot.visuals.size(); ++i) set_visual(robot.visuals[i], &message->visuals()[i]);
  message->warnings() = robot.warnings;
  message->robots().resize(robot.robots.size());
  for (size_t i = 0; i < robot.robots.size(); ++i) set_other_robot(robot.robots[i], &message->robots()[i]);
}

void from_message(const msg::RobotDescription& message, RobotDescription* robot) {
  TreeSpec& tree = robot->tree;
  tree = TreeSpec{};
  tree.name = message.name();
  tree.floating_base = message.floating_base();
  robot->urdf_path = message.urdf_path();
  robot->urdf = message.urdf();
  robot->scenario_path = message.scenario_path();
  robot->scenario = message.scenario();
  if (message.joints().size() + 1 != message.links().size()) refuse("joints", "their number does not fit the links");
  for (size_t i = 0; i < message.links().size(); ++i) {
    tree.links.push_back(get_link(message.links()[i]));
    if (i > 0) tree.links[i].joint = get_joint(message.joints()[i - 1]);
  }
  for (const msg::FrameDescription& frame : message.frames()) {
    tree.frames.push_back({frame.name(), frame.link(), from_message(frame.X_LF())});
  }
  robot->shapes.clear();
  for (const msg::CollisionShape& shape : message.shapes()) robot->shapes.push_back(get_shape(shape));
  robot->surfaces.clear();
  for (const msg::SurfaceDescription& surface : message.surfaces())
    robot->surfaces.push_back(std::make_shared<Surface>(from_message(surface)));
  robot->visuals.clear();
  for (const msg::VisualShape& visual : message.visuals()) robot->visuals.push_back(get_visual(visual));
  robot->warnings = message.warnings();
  robot->robots.clear();
  for (const msg::OtherRobotDescription& other : message.robots()) robot->robots.push_back(get_other_robot(other));
  check_references(*robot);
}

}  // namespace hrp
