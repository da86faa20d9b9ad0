// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/mjcf/mjcf_robot.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "servers/model_parser/mjcf/compiled_model.h"
#include "servers/model_parser/mjcf/mjcf_text.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp {
namespace {

Vector3d get_vector(const mjtNum* v) { return {v[0], v[1], v[2]}; }

Transform get_pose(const mjtNum* p, const mjtNum* quaternion) {
  const Eigen::Quaterniond q(quaternion[0], quaternion[1], quaternion[2], quaternion[3]);
  return {q.normalized().toRotationMatrix(), get_vector(p)};
}

class Converter {
 public:
  Converter(const mjModel& model, const mjModel* with_spheres, const MjcfText& text, const std::string& file,
            Diagnostics* diagnostics)
      : m_(model), with_spheres_(with_spheres), text_(text), file_(file), diagnostics_(diagnostics) {}

  BodyTree convert(bool floating_base) {
    name_bodies();
    refuse_constraints();
    tree_.name = m_.names[0] == '\0' ? "robot" : m_.names;
    choose_root(floating_base);
    read_actuators();
    for (int b = 1; b < m_.nbody; ++b) {
      if (belongs(b)) add_body(b);
    }
    return std::move(tree_);
  }

 private:
  std::string get_name(mjtObj kind, int id) const {
    const char* name = mj_id2name(&m_, kind, id);
    return name == nullptr ? "" : name;
  }
  std::string get_body_name(int b) const { return names_[static_cast<size_t>(b)]; }
  std::string get_joint_name(int j) const {
    const std::string name = get_name(mjOBJ_JOINT, j);
    return name.empty() ? get_body_name(m_.jnt_bodyid[j]) + "_joint" +
                              (m_.body_jntnum[m_.jnt_bodyid[j]] > 1 ? std::to_string(j) : "")
                        : name;
  }

  void add(const std::string& kind, const std::string& name, const std::string& message, bool is_error) {
    const InputPlace place(file_, "<" + kind + " name=\"" + name + "\">", text_.find_line(kind, name));
    is_error ? diagnostics_->add_error(place, message) : diagnostics_->add_warning(place, message);
  }
  void error(const std::string& kind, const std::string& name, const std::string& message) {
    add(kind, name, message, true);
  }

  // MuJoCo lets bodies be without names.
  void name_bodies() {
    std::set<std::string> taken;
    for (int b = 0; b < m_.nbody; ++b) taken.insert(get_name(mjOBJ_BODY, b));
    for (int b = 0; b < m_.nbody; ++b) {
      std::string name = get_name(mjOBJ_BODY, b);
      for (int i = b; name.empty(); ++i) {
        if (taken.insert("body_" + std::to_string(i)).second) name = "body_" + std::to_string(i);
      }
      names_.push_back(name);
    }
  }

  void refuse_constraints() {
    for (int t = 0; t < m_.ntendon; ++t) error("tendon", get_name(mjOBJ_TENDON, t), "tendons are not supported");
    for (int e = 0; e < m_.neq; ++e) {
      if (m_.eq_active[e] && m_.eq_type[e] != mjEQ_JOINT) refuse_equality(e);
    }
  }

  void refuse_equality(int e) {
    const bool bodies = m_.eq_type[e] == mjEQ_CONNECT || m_.eq_type[e] == mjEQ_WELD;
    const char* kind = m_.eq_type[e] == mjEQ_CONNECT ? "connect" : m_.eq_type[e] == mjEQ_WELD ? "weld" : "equality";
    std::string between;
    if (bodies)
      between = " between bodies '" + get_body_name(m_.eq_obj1id[e]) + "' and '" + get_body_name(m_.eq_obj2id[e]) + "'";
    error(kind, get_name(mjOBJ_EQUALITY, e),
          "this equality constraint" + between + " is not supported" +
              (bodies ? "; take it out and close the chain in the scenario: 'loops'" : ""));
  }

  bool is_free(int b) const { return m_.body_jntnum[b] == 1 && m_.jnt_type[m_.body_jntadr[b]] == mjJNT_FREE; }
  bool belongs(int b) const { return root_ == 0 || m_.body_rootid[b] == root_; }

  // One body that floats is the robot, with all that hangs from it; otherwise everything that hangs from the world.
  void choose_root(bool floating_base) {
    std::vector<int> tops, floating;
    for (int b = 1; b < m_.nbody; ++b) {
      if (m_.body_parentid[b] != 0) continue;
      tops.push_back(b);
      if (is_free(b)) floating.push_back(b);
    }
    if (tops.empty()) return error("worldbody", "", "has no <body>: there is no robot");
    for (size_t i = 1; i < floating.size(); ++i) {
      error("body", get_body_name(floating[i]),
            "floats, and so does '" + get_body_name(floating[0]) + "': a scenario has one robot");
    }
    const bool floats = !floating.empty();
    if (!floats && floating_base) {
      error("body", get_body_name(tops[0]),
            "has no <freejoint/>, it is held by the world: the scenario must say 'base: fixed'");
    }
    const bool alone = tops.size() == 1 && (floats || is_plain(tops[0]));
    root_ = floats ? floating[0] : alone ? tops[0] : 0;
    warn_of_world(tops.size() > 1 && floats);
    if (root_ == 0) add_world();
  }

  // Held by the world without a joint and at its origin: it is the root itself.
  bool is_plain(int b) const {
    const Transform X = get_pose(m_.body_pos + 3 * b, m_.body_quat + 4 * b);
    return m_.body_jntnum[b] == 0 && X.R.isIdentity(0.0) && X.p.isZero(0.0);
  }

  void warn_of_world(bool other_bodies) {
    if (m_.body_geomnum[0] == 0 && !other_bodies) return;
    diagnostics_->add_warning({file_, "<worldbody>"},
                              "what stands in the world is left out: ground and obstacles are the scenario's");
  }

  void add_world() {
    Body world;
    world.name = names_[0].empty() ? "world" : names_[0];
    tree_.bodies.push_back(world);
  }

  void add_body(int b) {
    Body body;
    body.name = get_body_name(b);
    body.line = text_.find_line("body", body.name);
    if (b != root_) {
      body.parent = m_.body_parentid[b] == 0 ? tree_.bodies[0].name : get_body_name(m_.body_parentid[b]);
      body.X_PB = get_pose(m_.body_pos + 3 * b, m_.body_quat + 4 * b);
      for (int i = 0; i < m_.body_jntnum[b]; ++i) add_joint(m_.body_jntadr[b] + i, &body);
    }
    const Transform X_BI = get_pose(m_.body_ipos + 3 * b, m_.body_iquat + 4 * b);
    body.inertia.mass = m_.body_mass[b];
    body.inertia.p_LLcm_L = X_BI.p;
    const Matrix3d I = X_BI.R * get_vector(m_.body_inertia + 3 * b).asDiagonal() * X_BI.R.transpose();
    body.inertia.I_LLcm_L = 0.5 * (I + I.transpose());
    for (int i = 0; i < m_.body_geomnum[b]; ++i) add_geom(m_.body_geomadr[b] + i, &body);
    add_sites(b, &body);
    tree_.bodies.push_back(body);
  }

  void add_joint(int j, Body* body) {
    BodyJoint joint;
    JointSpec& spec = joint.spec;
    spec.name = get_joint_name(j);
    joint.line = text_.find_line("joint", spec.name);
    if (m_.jnt_type[j] != mjJNT_HINGE && m_.jnt_type[j] != mjJNT_SLIDE) {
      return error("joint", spec.name,
                   std::string("of body '") + body->name + "' is of type '" +
                       (m_.jnt_type[j] == mjJNT_BALL ? "ball" : "free") +
                       "', expected hinge or slide, or free at the root");
    }
    spec.kind = m_.jnt_type[j] == mjJNT_SLIDE ? JointKind::kPrismatic : JointKind::kRevolute;
    spec.axis_F = get_vector(m_.jnt_axis + 3 * j);
    joint.X_BF.p = get_vector(m_.jnt_pos + 3 * j);
    joint.shown = m_.qpos0[m_.jnt_qposadr[j]];
    if (m_.jnt_limited[j]) {
      spec.lower = m_.jnt_range[2 * j];
      spec.upper = m_.jnt_range[2 * j + 1];
    }
    const int dof = m_.jnt_dofadr[j];
    spec.rotor_inertia = m_.dof_armature[dof];
    spec.viscous_friction = m_.dof_damping[dof];
    spec.coulomb_friction = m_.dof_frictionloss[dof];
    spec.spring.stiffness = m_.jnt_stiffness[j];
    spec.spring.rest = m_.qpos_spring[m_.jnt_qposadr[j]];
    spec.actuated = m_.nu == 0 || drives_[static_cast<size_t>(j)].any;
    if (drives_[static_cast<size_t>(j)].limited) spec.effort_limit = drives_[static_cast<size_t>(j)].limit;
    follow(j, &joint);
    body->joints.push_back(joint);
  }

  // q1 - shown1 = c0 + c1 (q2 - shown2)
  void follow(int j, BodyJoint* joint) {
    for (int e = 0; e < m_.neq; ++e) {
      if (!m_.eq_active[e] || m_.eq_type[e] != mjEQ_JOINT || m_.eq_obj1id[e] != j) continue;
      const mjtNum* c = m_.eq_data + mjNEQDATA * e;
      const int followed = m_.eq_obj2id[e];
      if (followed < 0 || c[2] != 0.0 || c[3] != 0.0 || c[4] != 0.0 || !joint->follows.empty()) {
        return error("joint", get_name(mjOBJ_EQUALITY, e),
                     "this equality constraint of joint '" + joint->spec.name +
                         "' is not supported, expected one that follows another joint linearly");
      }
      joint->follows = get_joint_name(followed);
      joint->multiplier = c[1];
      joint->offset = c[0] + joint->shown - c[1] * m_.qpos0[m_.jnt_qposadr[followed]];
    }
  }

  struct Drive {
    bool any = false, limited = true;
    double limit = 0.0;  // [N m or N] of all actuators of the joint
  };

  void read_actuators() {
    drives_.assign(static_cast<size_t>(m_.njnt), Drive());
    bool servo = false;
    for (int a = 0; a < m_.nu; ++a) {
      const int j = m_.actuator_trnid[2 * a];
      const bool at_joint = m_.actuator_trntype[a] == mjTRN_JOINT || m_.actuator_trntype[a] == mjTRN_JOINTINPARENT;
      if (!at_joint || j < 0 || j >= m_.njnt) {
        error("actuator", get_name(mjOBJ_ACTUATOR, a), "does not act on a joint, which is all that is supported");
        continue;
      }
      Drive& drive = drives_[static_cast<size_t>(j)];
      drive.any = true;
      const double limit = calc_limit(a);
      drive.limited = drive.limited && std::isfinite(limit);
      drive.limit += limit;
      servo = servo || m_.actuator_biastype[a] != mjBIAS_NONE || m_.actuator_dyntype[a] != mjDYN_NONE;
    }
    for (Drive& drive : drives_) drive.limited = drive.limited && drive.any;
    if (servo) warn_of_laws();
  }

  // Largest effort at the joint [N m or N]: the larger one of both directions.
  double calc_limit(int a) const {
    const double gear = std::abs(m_.actuator_gear[6 * a]);
    const auto largest = [](const mjtNum* range) { return std::max(std::abs(range[0]), std::abs(range[1])); };
    if (m_.actuator_forcelimited[a]) return gear * largest(m_.actuator_forcerange + 2 * a);
    const bool motor = m_.actuator_gaintype[a] == mjGAIN_FIXED && m_.actuator_biastype[a] == mjBIAS_NONE;
    if (m_.actuator_ctrllimited[a] && motor) {
      return gear * std::abs(m_.actuator_gainprm[mjNGAIN * a]) * largest(m_.actuator_ctrlrange + 2 * a);
    }
    return std::numeric_limits<double>::infinity();
  }

  void warn_of_laws() {
    diagnostics_->add_warning({file_, "<actuator>"},
                              "gains and dynamics of actuators are left out: the scenario's 'servo' drives the joints");
  }

  void add_sites(int b, Body* body) {
    for (int s = 0; s < m_.nsite; ++s) {
      const std::string name = get_name(mjOBJ_SITE, s);
      if (m_.site_bodyid[s] != b || name.empty()) continue;
      body->frames.push_back(
          {name, get_pose(m_.site_pos + 3 * s, m_.site_quat + 4 * s), text_.find_line("site", name)});
    }
  }

  void add_geom(int g, Body* body) {
    BodyShape shape;
    shape.touches = m_.geom_contype[g] != 0 || m_.geom_conaffinity[g] != 0;
    shape.shape.X_LG = get_pose(m_.geom_pos + 3 * g, m_.geom_quat + 4 * g);
    const std::string name = get_name(mjOBJ_GEOM, g);
    shape.line = name.empty() ? body->line : text_.find_line("geom", name);
    for (int i = 0; i < 4; ++i) shape.color[i] = m_.geom_rgba[4 * g + i];
    const mjtNum* half = m_.geom_size + 3 * g;
    switch (m_.geom_type[g]) {
      case mjGEOM_BOX: return add_shape(ShapeKind::kBox, 2.0 * get_vector(half), shape, body);
      case mjGEOM_SPHERE: return add_shape(ShapeKind::kSphere, {half[0], 0, 0}, shape, body);
      case mjGEOM_CYLINDER: return add_shape(ShapeKind::kCylinder, {half[0], 2.0 * half[1], 0}, shape, body);
      case mjGEOM_CAPSULE: return add_capsule(half[0], 2.0 * half[1], shape, body);
      case mjGEOM_MESH: return add_mesh(g, name, shape, body);
      default: break;
    }
    const char* what = m_.geom_type[g] == mjGEOM_ELLIPSOID ? "an ellipsoid"
                       : m_.geom_type[g] == mjGEOM_PLANE   ? "a plane"
                                                           : "a height field";
    if (shape.touches) {
      error("geom", name,
            "of body '" + body->name + "' is " + what + ", expected box, sphere, cylinder, capsule or mesh");
    }
  }

  static void add_shape(ShapeKind kind, const Vector3d& size, BodyShape shape, Body* body) {
    shape.shape.kind = kind;
    shape.shape.size = size;
    body->shapes.push_back(shape);
  }

  void add_mesh(int g, const std::string& name, BodyShape shape, Body* body) {
    const auto mesh = text_.meshes.find(get_name(mjOBJ_MESH, m_.geom_dataid[g]));
    const bool known = mesh != text_.meshes.end() && with_spheres_ != nullptr && with_spheres_->ngeom == m_.ngeom &&
                       with_spheres_->geom_type[g] == mjGEOM_SPHERE;
    if (!known) {
      if (shape.touches) {
        add("geom", name,
            std::string("of body '") + body->name +
                "' is a mesh without a file of its own, or with a class, refpos or refquat, "
                "or of an included file" +
                kWithoutMesh,
            false);
      }
      return;
    }
    shape.shape.X_LG = get_pose(with_spheres_->geom_pos + 3 * g, with_spheres_->geom_quat + 4 * g);
    shape.shape.mesh = mesh->second.file;
    shape.shape.scale = mesh->second.scale;
    add_shape(ShapeKind::kMesh, Vector3d::Zero(), shape, body);
  }

  const mjModel& m_;
  const mjModel* with_spheres_;
  const MjcfText& text_;
  const std::string file_;
  Diagnostics* diagnostics_;
  BodyTree tree_;
  std::vector<std::string> names_;  // of bodies
  std::vector<Drive> drives_;       // of joints
  int root_ = 0;                    // body that is the base; 0: the world
};

// MuJoCo says the line at the end: "..., line = 7, column = -1" or "Element 'joint', line 7".
int find_line(const std::string& message) {
  const size_t at = message.rfind("line ");
  if (at == std::string::npos) return 0;
  const size_t digit = message.find_first_of("0123456789", at);
  return digit == std::string::npos || digit > at + 8 ? 0 : std::atoi(message.c_str() + digit);
}

Diagnostic make_refusal(const std::string& path, std::string message) {
  Diagnostic d;
  d.file = path;
  d.line = find_line(message);
  while (!message.empty() && message.back() == '\n') message.pop_back();
  std::replace(message.begin(), message.end(), '\n', ' ');
  d.message = "MuJoCo refuses it: " + message;
  return d;
}

}  // namespace

BodyTree read_mjcf(const std::string& text, const std::string& path, bool floating_base, Diagnostics* diagnostics) {
  const MjcfText source = read_mjcf_text(text);
  CompiledModel model, with_spheres;
  try {
    model = compile_mjcf(text, path);
    if (model->nmesh > 0 && !source.with_spheres.empty()) with_spheres = compile_mjcf(source.with_spheres, path);
  } catch (const std::exception& error) {
    diagnostics->add_error(make_refusal(path, error.what()));
    return {};
  }
  return Converter(*model, with_spheres.get(), source, path, diagnostics).convert(floating_base);
}

}  // namespace hrp
