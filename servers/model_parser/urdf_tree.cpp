// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/urdf_tree.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/base/has.h"
#include "servers/model_parser/inertia_check.h"
#include "servers/model_parser/mesh_path.h"
#include "servers/model_parser/robot_loader.h"
#include "servers/model_parser/upright_feet.h"
#include "servers/model_parser/urdf_model.h"

namespace hrp {
namespace {

class TreeBuilder {
 public:
  TreeBuilder(const urdf::ModelInterface& model, const UrdfScan& scan, const Scenario& scenario,
              RobotDescription* robot, Diagnostics* diagnostics)
      : model_(model), scan_(scan), scenario_(scenario), robot_(*robot), diagnostics_(diagnostics) {}
  void build();

 private:
  struct Place {
    int link = 0;       // moving link that carries the URDF link
    Transform X_LC;     // pose of the URDF link in it
    bool sole = false;  // the URDF link, or one that it is fixed to, is a foot
  };
  void add(int line, const std::string& field, const std::string& message, bool is_error);
  void index_links();
  void place_links();
  void place(const JointScan& joint);
  JointSpec make_joint(const JointScan& joint, const urdf::Joint& parsed, const Place& parent);
  Transform stand_up(const std::string& link, JointSpec* joint) const;
  void lump(const std::string& name, const Place& place);
  void sum_fixed();
  LinkInertia read_inertia(const LinkScan& link);
  void add_shapes();
  void add_shape(const LinkScan& link, const Place& place, size_t index, const urdf::Collision& collision);
  bool is_foot(const std::string& link) const;
  bool is_replaced_by_sole_box(const std::string& link) const;
  void add_sole_boxes();
  void resolve_mimics();
  void check_moving_masses();

  const urdf::ModelInterface& model_;
  const UrdfScan& scan_;
  const Scenario& scenario_;
  RobotDescription& robot_;
  Diagnostics* diagnostics_;
  std::unordered_map<std::string, const LinkScan*> links_;
  // Joints below a link, in the order of the file
  std::unordered_map<std::string, std::vector<const JointScan*>> children_;
  std::unordered_map<std::string, Place> places_;
  std::vector<std::string> placed_;                     // links, parents first
  std::unordered_map<std::string, LinkInertia> fixed_;  // of a link and what is fixed to it, in the link's axes
  std::map<std::string, Matrix3d> upright_;  // R_CL of moving links that are feet and whose z axis does not point up
};

void TreeBuilder::add(int line, const std::string& field, const std::string& message, bool is_error) {
  const InputPlace place(scan_.file, field, line);
  is_error ? diagnostics_->add_error(place, message) : diagnostics_->add_warning(place, message);
}

bool TreeBuilder::is_foot(const std::string& link) const { return has(scenario_.feet, link); }

LinkInertia TreeBuilder::read_inertia(const LinkScan& link) {
  LinkInertia inertia = make_inertia(*model_.getLink(link.name));
  if (inertia.mass == 0.0 && inertia.I_LLcm_L.isZero(0.0)) return inertia;
  const std::string field = "link '" + link.name + "' <inertial>";
  if (inertia.mass == 0.0) {
    add(link.inertial_line, field,
        std::string("has an inertia but no mass") + (scenario_.repair_inertias ? "; ignored" : ""),
        !scenario_.repair_inertias);
    return LinkInertia();
  }
  if (inertia.I_LLcm_L.isZero(0.0)) return inertia;  // a point mass: judged with what it is fixed to
  const std::string fault = find_inertia_fault(inertia);
  if (fault.empty()) return inertia;
  if (!scenario_.repair_inertias) {
    add(link.inertial_line, field, fault + "; the scenario's 'repair_inertias: true' would repair it", true);
    return inertia;
  }
  LinkInertia repaired = repair_inertia(inertia);
  const Vector3d moments = Eigen::SelfAdjointEigenSolver<Matrix3d>(repaired.I_LLcm_L).eigenvalues();
  char text[100];
  std::snprintf(text, sizeof text, "; repaired to %.6g, %.6g, %.6g", moments[0], moments[1], moments[2]);
  add(link.inertial_line, field, fault + text, false);
  return repaired;
}

void TreeBuilder::lump(const std::string& name, const Place& place) {
  LinkInertia& total = robot_.tree.links[static_cast<size_t>(place.link)].inertia;
  total = add_inertias(total, read_inertia(*links_.at(name)), place.X_LC);
  places_[name] = place;
  placed_.push_back(name);
}

// From the leaves: a chain of fixed links costs each link once.
void TreeBuilder::sum_fixed() {
  for (auto name = placed_.rbegin(); name != placed_.rend(); ++name) {
    LinkInertia total = make_inertia(*model_.getLink(*name));
    for (const JointScan* joint : children_[*name]) {
      if (joint->type != "fixed") continue;
      const Transform X = make_transform(model_.getJoint(joint->name)->parent_to_joint_origin_transform);
      total = add_inertias(total, fixed_.at(joint->child), X);
    }
    fixed_[*name] = total;
  }
}

JointSpec TreeBuilder::make_joint(const JointScan& joint, const urdf::Joint& parsed, const Place& parent) {
  JointSpec spec;
  spec.name = joint.name;
  spec.kind = joint.type == "prismatic" ? JointKind::kPrismatic : JointKind::kRevolute;
  spec.X_PF = parent.X_LC * make_transform(parsed.parent_to_joint_origin_transform);
  spec.axis_F = make_vector(parsed.axis).normalized();
  spec.rotor_inertia = joint.rotor_inertia;
  spec.spring = joint.spring;
  // Exporters write zeros where they know no limit. A joint that is locked by its limits still has a drive, or a speed.
  const bool unknown = parsed.limits && parsed.limits->lower == 0.0 && parsed.limits->upper == 0.0 &&
                       parsed.limits->effort == 0.0 && parsed.limits->velocity == 0.0;
  if (unknown && joint.type != "continuous")
    add(joint.line, "joint '" + joint.name + "' <limit>",
        "has zeros only, as exporters write where they know none; taken as without limits", false);
  if (parsed.limits && !unknown) {
    if (joint.type != "continuous") {
      spec.lower = parsed.limits->lower;
      spec.upper = parsed.limits->upper;
    }
    // A drive that can do nothing is said by <unactuated/>.
    if (parsed.limits->effort > 0.0) spec.effort_limit = parsed.limits->effort;
    if (parsed.limits->velocity > 0.0) spec.velocity_limit = parsed.limits->velocity;
  }
  if (parsed.dynamics) {
    spec.viscous_friction = parsed.dynamics->damping;
    spec.coulomb_friction = parsed.dynamics->friction;
  }
  const auto rotor = scenario_.rotor_inertia.find(joint.name);
  if (rotor != scenario_.rotor_inertia.end()) spec.rotor_inertia = rotor->second;
  const auto& passive = scenario_.unactuated;
  spec.actuated = !joint.unactuated && !has(passive, joint.name);
  return spec;
}

// Turns the axes of a foot that moves by `joint` until z points up. Returns the pose of the URDF link in these axes.
Transform TreeBuilder::stand_up(const std::string& link, JointSpec* joint) const {
  const auto up = upright_.find(link);
  if (up == upright_.end()) return Transform();
  const Matrix3d& R_CL = up->second;
  joint->X_PF.R = joint->X_PF.R * R_CL;
  joint->axis_F = R_CL.transpose() * joint->axis_F;
  return {R_CL.transpose(), Vector3d::Zero()};
}

void TreeBuilder::place(const JointScan& joint) {
  const urdf::JointConstSharedPtr parsed = model_.getJoint(joint.name);
  Place place = places_.at(joint.parent);
  if (joint.type == "fixed") {
    place.X_LC = place.X_LC * make_transform(parsed->parent_to_joint_origin_transform);
    place.sole = place.sole || is_foot(joint.child);
  } else {
    LinkSpec link;
    link.name = joint.child;
    link.parent = place.link;
    link.joint = make_joint(joint, *parsed, place);
    robot_.tree.links.push_back(link);
    place = {static_cast<int>(robot_.tree.links.size()) - 1, stand_up(joint.child, &robot_.tree.links.back().joint),
             is_foot(joint.child)};
  }
  lump(joint.child, place);
}

void TreeBuilder::index_links() {
  for (const LinkScan& link : scan_.links) links_[link.name] = &link;
  for (const JointScan& joint : scan_.joints) children_[joint.parent].push_back(&joint);
}

// Joints in the order of the file, but parents first, as if by passes over the file: a joint is placed in the pass of
// its parent when it stands behind it, else in the next one.
void TreeBuilder::place_links() {
  robot_.tree.links.assign(1, LinkSpec());
  robot_.tree.links[0].name = scan_.root;
  lump(scan_.root, {0, Transform(), is_foot(scan_.root)});
  struct Turn {
    int pass;
    const JointScan* joint;  // in the file's order, as they are of one array
  };
  std::vector<Turn> turns;
  for (const JointScan* joint : children_[scan_.root]) turns.push_back({0, joint});
  for (size_t i = 0; i < turns.size(); ++i) {
    const Turn parent = turns[i];
    for (const JointScan* joint : children_[parent.joint->child]) {
      turns.push_back({parent.pass + (joint > parent.joint ? 0 : 1), joint});
    }
  }
  std::sort(turns.begin(), turns.end(),
            [](const Turn& a, const Turn& b) { return a.pass != b.pass ? a.pass < b.pass : a.joint < b.joint; });
  for (const Turn& turn : turns) place(*turn.joint);
}

bool TreeBuilder::is_replaced_by_sole_box(const std::string& link) const {
  const int body = places_.at(link).link;
  for (const auto& [foot, sole] : scenario_.soles) {
    const auto it = places_.find(foot);
    if (it != places_.end() && it->second.link == body && places_.at(link).sole) return true;
  }
  return false;
}

void TreeBuilder::add_shape(const LinkScan& link, const Place& place, size_t index, const urdf::Collision& collision) {
  CollisionShape shape;
  shape.link = place.link;
  shape.name = link.name + (link.collision_lines.size() > 1 ? "#" + std::to_string(index) : "");
  shape.X_LG = place.X_LC * make_transform(collision.origin);
  shape.sole = place.sole;
  const urdf::Geometry& geometry = *collision.geometry;
  if (geometry.type == urdf::Geometry::BOX) {
    shape.kind = ShapeKind::kBox;
    shape.size = make_vector(static_cast<const urdf::Box&>(geometry).dim);
  } else if (geometry.type == urdf::Geometry::SPHERE) {
    shape.kind = ShapeKind::kSphere;
    shape.size.x() = static_cast<const urdf::Sphere&>(geometry).radius;
  } else if (geometry.type == urdf::Geometry::CYLINDER) {
    shape.kind = ShapeKind::kCylinder;
    const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
    shape.size = {cylinder.radius, cylinder.length, 0.0};
  } else {
    const auto& mesh = static_cast<const urdf::Mesh&>(geometry);
    shape.kind = ShapeKind::kMesh;
    shape.scale = make_vector(mesh.scale);
    shape.mesh = find_mesh(mesh.filename, robot_.urdf_path);
    if (shape.mesh.empty()) {
      const std::string field = "link '" + link.name + "' <collision> <mesh>";
      const std::string text = "there is no file '" + mesh.filename + "'";
      add(link.collision_lines[index], field,
          text + (place.sole ? "; a foot needs its geometry: add the mesh, or give the scenario a box: 'soles: {" +
                                   link.name + ": {box: [x, y, z], xyz: [x, y, z]}}'"
                             : kWithoutMesh),
          place.sole);
      return;
    }
  }
  robot_.shapes.push_back(shape);
}

void TreeBuilder::add_shapes() {
  for (const LinkScan& link : scan_.links) {
    const urdf::LinkConstSharedPtr parsed = model_.getLink(link.name);
    const Place& place = places_.at(link.name);
    if (is_replaced_by_sole_box(link.name)) continue;
    for (size_t i = 0; i < parsed->collision_array.size() && i < link.collision_lines.size(); ++i) {
      if (parsed->collision_array[i] && parsed->collision_array[i]->geometry) {
        add_shape(link, place, i, *parsed->collision_array[i]);
      }
    }
  }
  add_sole_boxes();
}

void TreeBuilder::add_sole_boxes() {
  for (const auto& [foot, sole] : scenario_.soles) {
    const auto place = places_.find(foot);
    if (place == places_.end()) continue;  // check_scenario() names it
    CollisionShape shape;
    shape.link = place->second.link;
    shape.name = foot + "#sole";
    shape.X_LG = place->second.X_LC * Transform{make_rotation_from_rpy(sole.rpy_LG), sole.p_LG};
    shape.size = sole.box;
    shape.sole = true;
    robot_.shapes.push_back(shape);
  }
  std::stable_sort(robot_.shapes.begin(), robot_.shapes.end(),
                   [](const CollisionShape& a, const CollisionShape& b) { return a.link < b.link; });
}

// q = multiplier q_followed + offset. A chain of mimics is followed to the joint that moves by itself.
void TreeBuilder::resolve_mimics() {
  for (const JointScan& joint : scan_.joints) {
    if (joint.mimic_line == 0 || joint.type == "fixed") continue;
    MimicSpec mimic{-1, 1.0, 0.0};
    std::set<std::string> seen;
    std::string at = joint.name;
    std::string fault;
    for (auto parsed = model_.getJoint(at); parsed && parsed->mimic; parsed = model_.getJoint(at)) {
      if (!seen.insert(at).second) fault = "follows itself, through '" + at + "'";
      if (!fault.empty()) break;
      mimic.offset += mimic.multiplier * parsed->mimic->offset;
      mimic.multiplier *= parsed->mimic->multiplier;
      at = parsed->mimic->joint_name;
    }
    mimic.joint = robot_.tree.find_joint(at);
    if (fault.empty() && mimic.joint < 0)
      fault = "follows joint '" + at + "', which is not a moving joint of this file";
    if (!fault.empty()) {
      add(joint.mimic_line, "joint '" + joint.name + "' <mimic>", fault, true);
      continue;
    }
    robot_.tree.joint(robot_.tree.find_joint(joint.name)).mimic = mimic;
  }
}

// A link that moves needs mass, its own or of links that it carries; its inertia must be one.
void TreeBuilder::check_moving_masses() {
  const std::vector<LinkSpec>& links = robot_.tree.links;
  std::vector<double> carried(links.size(), 0.0);
  for (size_t i = links.size(); i-- > 0;) {
    carried[i] += links[i].inertia.mass;
    if (links[i].parent >= 0) carried[static_cast<size_t>(links[i].parent)] += carried[i];
  }
  for (size_t i = 0; i < links.size(); ++i) {
    if (i == 0 && !scenario_.floating_base) continue;
    const int line = scan_.find_link_line(links[i].name);
    const std::string field = "link '" + links[i].name + "'";
    const LinkInertia& inertia = links[i].inertia;
    const bool light = inertia.mass == 0.0;
    if (!light && !inertia.I_LLcm_L.isZero(0.0)) continue;
    if (light && i > 0 && (carried[i] != 0.0 || links[i].joint.rotor_inertia != 0.0)) {
      add(line, field, "moves but has no mass of its own", false);
      continue;
    }
    const bool repaired = scenario_.repair_inertias && !(light && i == 0);  // a robot without a base is none
    const std::string fault =
        light ? "moves but has no mass, and carries none"
              : "moves and is a point mass: its inertia is zero, expected one that is positive definite";
    add(line, field,
        fault + (!repaired ? ""
                 : light   ? "; repaired to a small ball of 1 g"
                           : "; repaired to a small ball"),
        !repaired);
    if (repaired) robot_.tree.links[i].inertia = repair_inertia(inertia);
  }
}

void TreeBuilder::build() {
  robot_.tree.name = model_.getName();
  robot_.tree.floating_base = scenario_.floating_base;
  index_links();
  upright_ = find_upright_feet(model_, scan_, scenario_);
  place_links();
  sum_fixed();
  for (const LinkScan& link : scan_.links) {
    const Place& place = places_.at(link.name);
    robot_.tree.frames.push_back({link.name, place.link, place.X_LC, fixed_.at(link.name)});
  }
  add_shapes();
  resolve_mimics();
  check_moving_masses();
}

}  // namespace

void build_tree(const UrdfScan& scan, const Scenario& scenario, RobotDescription* robot, Diagnostics* diagnostics) {
  const std::shared_ptr<urdf::ModelInterface> model = parse_urdf(scan, diagnostics);
  if (model) TreeBuilder(*model, scan, scenario, robot, diagnostics).build();
}

}  // namespace hrp
