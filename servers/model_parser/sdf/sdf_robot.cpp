// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/sdf/sdf_robot.h"

#include <cmath>
#include <map>

#include "servers/model_parser/sdf/load_sdf.h"

namespace hrp {
namespace {

constexpr double kNoLimit = 1e15;  // SDF writes 1e16 where there is none

double make_limit(double value) {
  return std::abs(value) < kNoLimit ? value : std::copysign(std::numeric_limits<double>::infinity(), value);
}

std::string get_type_name(sdf::JointType type) {
  switch (type) {
    case sdf::JointType::BALL: return "ball";
    case sdf::JointType::GEARBOX: return "gearbox";
    case sdf::JointType::REVOLUTE2: return "revolute2";
    case sdf::JointType::SCREW: return "screw";
    case sdf::JointType::UNIVERSAL: return "universal";
    default: return "unknown";
  }
}

class Converter {
 public:
  Converter(const sdf::Model& model, const std::string& file, Diagnostics* diagnostics)
      : model_(model), file_(file), diagnostics_(diagnostics) {}

  BodyTree convert(bool floating_base) {
    tree_.name = model_.Name();
    for (uint64_t i = 0; i < model_.ModelCount(); ++i) {
      error(find_line(*model_.ModelByIndex(i)), "model '" + model_.ModelByIndex(i)->Name() + "'",
            "nested models are not supported");
    }
    index_joints();
    if (diagnostics_->has_errors()) return {};
    add_root(floating_base);
    for (uint64_t i = 0; i < model_.JointCount() && !diagnostics_->has_errors(); ++i)
      add_child(*model_.JointByIndex(i));
    return std::move(tree_);
  }

 private:
  struct Ends {
    std::string parent, child;  // "world" is a parent, too
  };

  void error(int line, const std::string& field, const std::string& message) {
    diagnostics_->add_error({file_, field, line}, message);
  }
  void take(const sdf::Errors& errors, int line, const std::string& field) {
    for (const sdf::Error& e : errors) error(line, field, e.Message());
  }

  // One joint moves a link; the other one would close a chain.
  void index_joints() {
    for (uint64_t i = 0; i < model_.JointCount(); ++i) {
      const sdf::Joint& joint = *model_.JointByIndex(i);
      const std::string field = "joint '" + joint.Name() + "'";
      Ends ends;
      take(joint.ResolveParentLink(ends.parent), find_line(joint), field);
      take(joint.ResolveChildLink(ends.child), find_line(joint), field);
      const auto [first, fresh] = mover_.emplace(ends.child, joint.Name());
      if (!fresh) {
        error(find_line(joint), field,
              "moves link '" + ends.child + "', which joint '" + first->second +
                  "' moves already: a link has one parent; take one joint out and close the chain in the scenario: "
                  "'loops'");
      }
      ends_[joint.Name()] = ends;
    }
  }

  bool hangs_from_world() const {
    for (const auto& [joint, ends] : ends_) {
      if (ends.parent == "world") return true;
    }
    return false;
  }

  // The first link that no joint moves; or the world, where a joint holds a link to it.
  void add_root(bool floating_base) {
    held_ = hangs_from_world();
    if (held_) {
      if (floating_base)
        error(find_line(model_), "model '" + tree_.name + "'",
              "a joint holds it to the world: the scenario must say 'base: fixed'");
      Body world;
      world.name = "world";
      tree_.bodies.push_back(world);
    }
    for (uint64_t i = 0; i < model_.LinkCount(); ++i) {
      const sdf::Link& link = *model_.LinkByIndex(i);
      if (mover_.count(link.Name()) > 0) continue;
      if (!tree_.bodies.empty()) {
        error(find_line(link), "link '" + link.Name() + "'",
              "hangs from no joint, and neither does '" + tree_.bodies[0].name + "': a robot has one root");
        continue;
      }
      Body root;
      add_link(link, &root);
      tree_.bodies.push_back(root);
    }
    if (tree_.bodies.empty())
      error(find_line(model_), "model '" + tree_.name + "'",
            "has no link that hangs from nothing: its joints form a circle");
  }

  void add_child(const sdf::Joint& joint) {
    const Ends& ends = ends_.at(joint.Name());
    const std::string field = "joint '" + joint.Name() + "'";
    const int line = find_line(joint);
    const sdf::Link& link = *model_.LinkByName(ends.child);
    Body body;
    body.parent = ends.parent;
    ignition::math::Pose3d pose;
    take(link.SemanticPose().Resolve(pose, ends.parent == "world" ? "__model__" : ends.parent), line, field);
    body.X_PB = make_transform(pose);
    add_link(link, &body);
    if (joint.Type() != sdf::JointType::FIXED) add_joint(joint, field, line, &body);
    tree_.bodies.push_back(body);
  }

  void add_joint(const sdf::Joint& joint, const std::string& field, int line, Body* body) {
    const sdf::JointType type = joint.Type();
    const bool turns = type == sdf::JointType::REVOLUTE || type == sdf::JointType::CONTINUOUS;
    if (!turns && type != sdf::JointType::PRISMATIC) {
      return error(line, field,
                   "is of type '" + get_type_name(type) + "', expected revolute, continuous, prismatic or fixed");
    }
    const sdf::JointAxis* axis = joint.Axis(0);
    if (axis == nullptr) return error(line, field, "has no <axis>");
    BodyJoint out;
    out.line = line;
    out.spec.name = joint.Name();
    out.spec.kind = turns ? JointKind::kRevolute : JointKind::kPrismatic;
    ignition::math::Pose3d pose;
    take(joint.SemanticPose().Resolve(pose, body->name), line, field);
    out.X_BF = make_transform(pose);
    ignition::math::Vector3d xyz;
    take(axis->ResolveXyz(xyz), line, field + " <axis>");
    out.spec.axis_F = make_vector(xyz);
    read_axis(*axis, type, &out.spec);
    body->joints.push_back(out);
  }

  static void read_axis(const sdf::JointAxis& axis, sdf::JointType type, JointSpec* spec) {
    if (type != sdf::JointType::CONTINUOUS) {
      spec->lower = make_limit(axis.Lower());
      spec->upper = make_limit(axis.Upper());
    }
    // Negative: no limit, as in SDF 1.6 and before.
    if (axis.Effort() >= 0.0) spec->effort_limit = make_limit(axis.Effort());
    if (axis.MaxVelocity() >= 0.0) spec->velocity_limit = make_limit(axis.MaxVelocity());
    spec->viscous_friction = axis.Damping();
    spec->coulomb_friction = axis.Friction();
    spec->spring.stiffness = axis.SpringStiffness();
    spec->spring.rest = axis.SpringReference();
  }

  void add_link(const sdf::Link& link, Body* body) {
    body->name = link.Name();
    body->line = find_line(link);
    const auto& inertial = link.Inertial();
    body->inertia.mass = inertial.MassMatrix().Mass();
    body->inertia.p_LLcm_L = make_vector(inertial.Pose().Pos());
    const auto I = inertial.Moi();  // about the centre of mass, link axes
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) body->inertia.I_LLcm_L(row, column) = I(row, column);
    }
    for (uint64_t i = 0; i < link.CollisionCount(); ++i) add_shape(*link.CollisionByIndex(i), link, true, body);
    for (uint64_t i = 0; i < link.VisualCount(); ++i) add_shape(*link.VisualByIndex(i), link, false, body);
  }

  template <typename Part>
  void add_shape(const Part& part, const sdf::Link& link, bool touches, Body* body) {
    BodyShape shape;
    shape.touches = touches;
    shape.line = find_line(part);
    const std::string field =
        "link '" + link.Name() + "' <" + (touches ? "collision" : "visual") + " name=\"" + part.Name() + "\">";
    ignition::math::Pose3d pose;
    take(part.SemanticPose().Resolve(pose, link.Name()), shape.line, field);
    shape.shape.X_LG = make_transform(pose);
    if (part.Geom() == nullptr || add_geometry(*part.Geom(), shape, body) || !touches) return;
    error(shape.line, field, "is of a shape that is not supported, expected box, sphere, cylinder, capsule or mesh");
  }

  static bool add_geometry(const sdf::Geometry& geometry, BodyShape shape, Body* body) {
    const auto add = [&](ShapeKind kind, const Vector3d& size) {
      shape.shape.kind = kind;
      shape.shape.size = size;
      body->shapes.push_back(shape);
      return true;
    };
    if (const sdf::Box* box = geometry.BoxShape()) return add(ShapeKind::kBox, make_vector(box->Size()));
    if (const sdf::Sphere* sphere = geometry.SphereShape()) return add(ShapeKind::kSphere, {sphere->Radius(), 0, 0});
    if (const sdf::Cylinder* cylinder = geometry.CylinderShape()) {
      return add(ShapeKind::kCylinder, {cylinder->Radius(), cylinder->Length(), 0});
    }
    if (const sdf::Capsule* capsule = geometry.CapsuleShape()) {
      add_capsule(capsule->Radius(), capsule->Length(), shape, body);
      return true;
    }
    if (const sdf::Mesh* mesh = geometry.MeshShape()) {
      shape.shape.mesh = make_mesh_name(mesh->Uri());
      shape.shape.scale = make_vector(mesh->Scale());
      return add(ShapeKind::kMesh, Vector3d::Zero());
    }
    return geometry.Type() == sdf::GeometryType::EMPTY;
  }

  const sdf::Model& model_;
  const std::string file_;
  Diagnostics* diagnostics_;
  BodyTree tree_;
  bool held_ = false;                         // by the world
  std::map<std::string, std::string> mover_;  // of a link: the joint
  std::map<std::string, Ends> ends_;          // of a joint
};

}  // namespace

BodyTree read_sdf(const std::string& text, const std::string& path, bool floating_base, Diagnostics* diagnostics) {
  sdf::Root root;
  if (!load_sdf(text, path, &root, diagnostics)) return {};
  if (root.Model() != nullptr) return Converter(*root.Model(), path, diagnostics).convert(floating_base);
  diagnostics->add_error(
      path, root.WorldCount() > 0
                ? "has a <world>, expected a <model> right below <sdf>; worlds go into the scenario's 'world'"
                : "has no <model> right below <sdf>");
  return {};
}

}  // namespace hrp
