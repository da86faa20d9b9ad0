// SPDX-License-Identifier: BSD-3-Clause
// MJCF: bodies, joints and actuators under the robot's own names. MuJoCo's joint has armature, damping, frictionloss
// and a spring; the actuator has the servo's law with the true gain.
#include <cmath>
#include <sstream>

#include "common/base/escape_xml.h"
#include "common/base/format.h"
#include "diagnosis/export/take_home.h"
#include "diagnosis/export/unheld.h"

namespace hrp::diagnosis {
namespace {

constexpr Holds kMjcfHolds{true, true, true, false, false};

template <typename Vector>
std::string print_vector(const Vector& v) {
  std::string text;
  for (long i = 0; i < v.size(); ++i) text += format("%s%.12g", i > 0 ? " " : "", v[i]);
  return text;
}

class Writer {
 public:
  explicit Writer(const TakeHome& model) : model_(model), tree_(model.robot.tree) {}

  std::string write() {
    out_ << "<mujoco model=\"" << escape_xml(tree_.name) << "\">\n"
         << make_comment(
                "The model that the recordings ask for. Merge armature, damping, frictionloss and actuators into your "
                "own "
                "model, or run this one. Shapes and meshes are not here.");
    for (const std::string& force : model_.forces) out_ << make_comment("not held: " + force);
    out_ << "<compiler angle=\"radian\" autolimits=\"true\" boundmass=\"0\"/>\n<option gravity=\""
         << print_vector(model_.scenario.gravity_W) << "\" timestep=\"0.001\" integrator=\"implicit\"/>\n<worldbody>\n";
    write_body(0, 1);
    out_ << "</worldbody>\n<actuator>\n";
    for (int j = 0; j < tree_.num_joints(); ++j) write_actuator(j);
    out_ << "</actuator>\n<equality>\n";
    for (int j = 0; j < tree_.num_joints(); ++j) write_mimic(j);
    out_ << "</equality>\n</mujoco>\n";
    return out_.str();
  }

 private:
  static std::string indent(int depth) { return std::string(static_cast<size_t>(2 * depth), ' '); }

  static std::string print_pose(const Transform& X) {
    const Eigen::Quaterniond q(X.R);
    return " pos=\"" + print_vector(X.p) + "\" quat=\"" + print_vector(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z())) +
           "\"";
  }

  void write_body(int link, int depth) {
    const LinkSpec& L = tree_.links[static_cast<size_t>(link)];
    out_ << indent(depth) << "<body name=\"" << escape_xml(name_link(tree_, link)) << "\""
         << (link > 0 ? print_pose(L.joint.X_PF) : "") << ">\n";
    if (link > 0) write_joint(link - 1, depth + 1);
    if (link == 0 && tree_.floating_base) out_ << indent(depth + 1) << "<freejoint name=\"base\"/>\n";
    write_inertia(L.inertia, link > 0, depth + 1);
    for (size_t child = static_cast<size_t>(link) + 1; child < tree_.links.size(); ++child) {
      if (tree_.links[child].parent == link) write_body(static_cast<int>(child), depth + 1);
    }
    out_ << indent(depth) << "</body>\n";
  }

  void write_joint(int j, int depth) {
    const JointSpec& joint = tree_.joint(j);
    const JointLaws& laws = model_.laws[static_cast<size_t>(j)];
    for (const std::string& text : list_unheld(joint, laws, kMjcfHolds))
      out_ << indent(depth) << make_comment(joint.name + ", not held: " + text);
    out_ << indent(depth) << "<joint name=\"" << escape_xml(joint.name) << "\" type=\""
         << (joint.kind == JointKind::kPrismatic ? "slide" : "hinge") << "\" axis=\"" << print_vector(joint.axis_F)
         << "\" armature=\"" << print_value(laws.motor_inertia) << "\" damping=\""
         << print_value(laws.viscous + laws.spring_damping) << "\" frictionloss=\"" << print_value(laws.coulomb)
         << "\"";
    if (laws.spring_stiffness != 0.0)
      out_ << " stiffness=\"" << print_value(laws.spring_stiffness) << "\" springref=\""
           << print_value(laws.spring_rest) << "\"";
    if (std::isfinite(joint.lower) && std::isfinite(joint.upper) && joint.upper > joint.lower)
      out_ << " range=\"" << print_value(joint.lower) << " " << print_value(joint.upper) << "\"";
    out_ << "/>\n";
  }

  void write_inertia(const LinkInertia& inertia, bool moves, int depth) {
    if (inertia.mass <= 0.0) {
      if (moves)
        out_ << indent(depth) << "<inertial mass=\"" << print_value(kLeastMass) << "\" pos=\"0 0 0\" diaginertia=\""
             << print_vector(Vector3d::Constant(kLeastInertia)) << "\"/>\n";
      return;
    }
    const Matrix3d& I = inertia.I_LLcm_L;
    Eigen::Matrix<double, 6, 1> full;
    full << I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2);
    out_ << indent(depth) << "<inertial mass=\"" << print_value(inertia.mass) << "\" pos=\""
         << print_vector(inertia.p_LLcm_L) << "\" fullinertia=\"" << print_vector(full) << "\"/>\n";
  }

  void write_mimic(int j) {
    const JointSpec& joint = tree_.joint(j);
    if (joint.mimic.joint < 0) return;
    out_ << "  <joint joint1=\"" << escape_xml(joint.name) << "\" joint2=\""
         << escape_xml(tree_.joint(joint.mimic.joint).name) << "\" polycoef=\"" << print_value(joint.mimic.offset)
         << " " << print_value(joint.mimic.multiplier) << " 0 0 0\"/>\n";
  }

  // Servo: force = gain (ctrl - kp q - kd qd), ctrl = kp r + kd r'. Effort: force = gain ctrl.
  void write_actuator(int j) {
    const JointSpec& joint = tree_.joint(j);
    const JointLaws& laws = model_.laws[static_cast<size_t>(j)];
    if (!joint.actuated || joint.mimic.joint >= 0) return;
    const bool servo = laws.kp > 0.0;
    // MuJoCo clamps a motor's force before its gear.
    const double k = laws.torque_scale, limit = find_torque_limit(joint, laws) / (servo ? 1.0 : k);
    const std::string range =
        std::isfinite(limit) ? " forcerange=\"" + print_value(-limit) + " " + print_value(limit) + "\"" : "";
    if (servo)
      out_ << "  <general name=\"" << escape_xml(joint.name) << "\" joint=\"" << escape_xml(joint.name)
           << "\" biastype=\"affine\" gainprm=\"" << print_value(k) << "\" biasprm=\"0 " << print_value(-k * laws.kp)
           << " " << print_value(-k * laws.kd) << "\"" << range << "/>  "
           << make_comment("ctrl = " + print_value(laws.kp) + " position + " + print_value(laws.kd) +
                           " velocity of the command");
    else
      out_ << "  <motor name=\"" << escape_xml(joint.name) << "\" joint=\"" << escape_xml(joint.name) << "\" gear=\""
           << print_value(k) << "\"" << range << "/>\n";
  }

  const TakeHome& model_;
  const TreeSpec& tree_;
  std::ostringstream out_;
};

}  // namespace

std::string make_mjcf_model(const TakeHome& model) { return Writer(model).write(); }

}  // namespace hrp::diagnosis
