// SPDX-License-Identifier: BSD-3-Clause
// URDF: the robot's own text with <dynamics> of what was found, and SDF, written anew.
#include <cmath>
#include <regex>
#include <sstream>

#include "common/base/escape_xml.h"
#include "common/base/join_words.h"
#include "diagnosis/data/urdf_text.h"
#include "diagnosis/export/take_home.h"
#include "diagnosis/export/unheld.h"

namespace hrp::diagnosis {
namespace {

constexpr Holds kUrdfHolds{};
constexpr Holds kSdfHolds{false, false, true, false, false};

// Where the element of a joint begins and ends; transmissions have elements of that name, too, without a type.
bool find_joint(const std::string& urdf, const std::string& name, size_t* begin, size_t* end) {
  for (size_t at = urdf.find("<joint"); at != std::string::npos; at = urdf.find("<joint", at + 1)) {
    const size_t close = urdf.find('>', at);
    if (close == std::string::npos) return false;
    const std::string head = urdf.substr(at, close - at);
    if (head.find("type") == std::string::npos || is_in_comment(urdf, at)) continue;
    if (head.find("\"" + name + "\"") == std::string::npos && head.find("'" + name + "'") == std::string::npos)
      continue;
    *begin = close + 1;
    *end = urdf.find("</joint>", close);
    return *end != std::string::npos;
  }
  return false;
}

std::string describe_load(const StatedEffect& e) {
  return e.effect + " (" +
         join_words(e.parameters, [](const auto& p) { return p.first + " " + print_value(p.second); }) + ")";
}

std::string print_list(const Vector3d& v) {
  return print_value(v.x()) + " " + print_value(v.y()) + " " + print_value(v.z());
}

class SdfWriter {
 public:
  explicit SdfWriter(const TakeHome& model) : model_(model), tree_(model.robot.tree) {}

  std::string write() {
    out_ << "<?xml version=\"1.0\"?>\n<sdf version=\"1.9\">\n<model name=\"" << escape_xml(tree_.name) << "\">\n"
         << make_comment("The model that the recordings ask for; shapes and meshes are not here.");
    for (const std::string& force : model_.forces) out_ << make_comment("not held: " + force);
    for (size_t i = 0; i < tree_.links.size(); ++i) write_link(tree_.links[i], i);
    for (int j = 0; j < tree_.num_joints(); ++j) write_joint(j);
    if (!tree_.floating_base)
      out_ << "  <joint name=\"to_world\" type=\"fixed\"><parent>world</parent><child>"
           << escape_xml(name_link(tree_, 0)) << "</child></joint>\n";
    out_ << "</model>\n</sdf>\n";
    return out_.str();
  }

 private:
  void write_link(const LinkSpec& link, size_t i) {
    out_ << "  <link name=\"" << escape_xml(name_link(tree_, static_cast<int>(i))) << "\">\n";
    if (i > 0) {
      const Vector3d rpy = link.joint.X_PF.R.eulerAngles(2, 1, 0).reverse();
      out_ << "    <pose relative_to=\"" << escape_xml(name_link(tree_, link.parent)) << "\">"
           << print_list(link.joint.X_PF.p) << " " << print_list(rpy) << "</pose>\n";
    }
    if (link.inertia.mass > 0.0) {
      const Matrix3d& I = link.inertia.I_LLcm_L;
      out_ << "    <inertial><pose>" << print_list(link.inertia.p_LLcm_L) << " 0 0 0</pose><mass>"
           << print_value(link.inertia.mass) << "</mass><inertia><ixx>" << print_value(I(0, 0)) << "</ixx><ixy>"
           << print_value(I(0, 1)) << "</ixy><ixz>" << print_value(I(0, 2)) << "</ixz><iyy>" << print_value(I(1, 1))
           << "</iyy><iyz>" << print_value(I(1, 2)) << "</iyz><izz>" << print_value(I(2, 2))
           << "</izz></inertia></inertial>\n";
    } else {
      const std::string least = print_value(kLeastInertia);
      out_ << "    <inertial><mass>" << print_value(kLeastMass) << "</mass><inertia><ixx>" << least << "</ixx><iyy>"
           << least << "</iyy><izz>" << least << "</izz></inertia></inertial>\n";
    }
    out_ << "  </link>\n";
  }

  void write_joint(int j) {
    const LinkSpec& link = tree_.links[static_cast<size_t>(j) + 1];
    const JointSpec& joint = link.joint;
    const JointLaws& laws = model_.laws[static_cast<size_t>(j)];
    for (const std::string& text : list_unheld(joint, laws, kSdfHolds))
      out_ << "  " << make_comment(joint.name + ", not held: " + text);
    if (joint.mimic.joint >= 0)
      out_ << "  "
           << make_comment(joint.name + ", not held: it follows " + tree_.joint(joint.mimic.joint).name + ", times " +
                           print_value(joint.mimic.multiplier) + " plus " + print_value(joint.mimic.offset));
    out_ << "  <joint name=\"" << escape_xml(joint.name) << "\" type=\""
         << (joint.kind == JointKind::kPrismatic ? "prismatic" : "revolute") << "\">\n    <parent>"
         << escape_xml(name_link(tree_, link.parent)) << "</parent><child>" << escape_xml(name_link(tree_, j + 1))
         << "</child>\n    <axis><xyz>" << print_list(joint.axis_F) << "</xyz><dynamics><damping>"
         << print_value(laws.viscous + laws.spring_damping) << "</damping><friction>" << print_value(laws.coulomb)
         << "</friction><spring_stiffness>" << print_value(laws.spring_stiffness)
         << "</spring_stiffness><spring_reference>" << print_value(laws.spring_rest)
         << "</spring_reference></dynamics>";
    const double limit = find_torque_limit(joint, laws);
    out_ << "<limit>";
    if (std::isfinite(joint.lower)) out_ << "<lower>" << print_value(joint.lower) << "</lower>";
    if (std::isfinite(joint.upper)) out_ << "<upper>" << print_value(joint.upper) << "</upper>";
    if (std::isfinite(limit)) out_ << "<effort>" << print_value(limit) << "</effort>";
    out_ << "</limit></axis>\n  </joint>\n";
  }

  const TakeHome& model_;
  const TreeSpec& tree_;
  std::ostringstream out_;
};

}  // namespace

std::string make_urdf_model(const TakeHome& model) {
  std::string urdf = model.robot.urdf;
  for (int j = 0; j < model.robot.tree.num_joints(); ++j) {
    const std::string& name = model.robot.tree.joint(j).name;
    const JointLaws& laws = model.laws[static_cast<size_t>(j)];
    size_t begin = 0, end = 0;
    // A quote or > may stand as it is.
    if (!find_joint(urdf, escape_xml(name), &begin, &end) && !find_joint(urdf, name, &begin, &end)) continue;
    std::string body = urdf.substr(begin, end - begin);
    body = std::regex_replace(body, std::regex("<dynamics[^>]*/>|<dynamics[^>]*>\\s*</dynamics>"), "");
    body +=
        "  <dynamics damping=\"" + print_value(laws.viscous) + "\" friction=\"" + print_value(laws.coulomb) + "\"/>\n";
    for (const std::string& text : list_unheld(model.robot.tree.joint(j), laws, kUrdfHolds))
      body += "    " + make_comment("not held: " + text);
    urdf.replace(begin, end - begin, body);
  }
  std::string notes;
  for (const std::string& force : model.forces) notes += make_comment("not held: " + force);
  for (const auto& [link, effects] : model.scenario.link_laws) {
    for (const StatedEffect& e : effects)
      notes += make_comment("not held here (see robot.xml): " + link + ", " + describe_load(e));
  }
  const size_t close = urdf.rfind("</robot>");
  return close == std::string::npos ? urdf + notes : urdf.insert(close, notes);
}

std::string make_sdf_model(const TakeHome& model) { return SdfWriter(model).write(); }

}  // namespace hrp::diagnosis
