// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/urdf_scan.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <tinyxml2.h>

#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "servers/model_parser/xml_values.h"

namespace hrp {
namespace {

// Sums and products of these stay far from the ends of what a double holds.
constexpr double kLargestMass = 1e6, kSmallestMass = 1e-9;  // [kg]
constexpr double kLargestSize = 1e4;                        // [m]

using Element = tinyxml2::XMLElement;

class Scanner {
 public:
  Scanner(UrdfScan* scan, Diagnostics* diagnostics) : scan_(scan), diagnostics_(diagnostics) {}
  void scan_robot(const Element& robot);

 private:
  void error(const Element& at, const std::string& owner, const std::string& message);
  std::string read_name(const Element& element, const std::string& kind);
  // `count` finite numbers in an attribute; returns them, empty after a complaint.
  std::vector<double> read_numbers(const Element& element, const std::string& owner, const char* attribute,
                                   size_t count, bool required);
  void scan_origin(const Element& parent, const std::string& owner);
  void scan_link(const Element& element);
  void scan_inertial(const Element& element, const std::string& owner);
  void scan_geometry(const Element& parent, const std::string& owner);
  void scan_joint(const Element& element);
  void scan_spring(const Element& element, const std::string& owner, JointScan* joint);
  void scan_joint_numbers(const Element& element, const std::string& owner, JointScan* joint);
  std::string read_link_reference(const Element& joint, const std::string& owner, const char* tag);

  UrdfScan* scan_;
  Diagnostics* diagnostics_;
};

void Scanner::error(const Element& at, const std::string& owner, const std::string& message) {
  const std::string name = at.Name(), tag = "<" + name + ">";
  const bool owns = name == "link" || name == "joint";
  diagnostics_->add_error({scan_->file,
                           owner.empty() ? tag
                           : owns        ? owner
                                         : owner + " " + tag,
                           at.GetLineNum()},
                          message);
}

std::string Scanner::read_name(const Element& element, const std::string& kind) {
  std::string name = get_attribute(element, "name");
  if (name.empty()) error(element, "", "has no name; every " + kind + " needs one");
  // Scenarios are UTF-8 and could not say it. Comments may be in any encoding.
  const size_t at = find_strange_byte(name);
  if (at != std::string::npos) error(element, "", describe_strange_byte(name, at));
  return name;
}

std::vector<double> Scanner::read_numbers(const Element& element, const std::string& owner, const char* attribute,
                                          size_t count, bool required) {
  const char* text = element.Attribute(attribute);
  if (text == nullptr) {
    if (required) error(element, owner, std::string("attribute '") + attribute + "' is missing");
    return {};
  }
  std::vector<double> numbers = parse_numbers(text, count);
  if (!numbers.empty()) return numbers;
  error(element, owner,
        std::string(attribute) + " is '" + text + "', expected " + std::to_string(count) +
            (count == 1 ? " finite number" : " finite numbers"));
  return {};
}

void Scanner::scan_origin(const Element& parent, const std::string& owner) {
  const Element* origin = parent.FirstChildElement("origin");
  if (origin == nullptr) return;
  for (double v : read_numbers(*origin, owner, "xyz", 3, false)) {
    if (std::abs(v) > kLargestSize) return error(*origin, owner, "is further away than 10 km; expected metres");
  }
  read_numbers(*origin, owner, "rpy", 3, false);
}

void Scanner::scan_inertial(const Element& element, const std::string& owner) {
  scan_origin(element, owner);
  const Element* mass = element.FirstChildElement("mass");
  const Element* inertia = element.FirstChildElement("inertia");
  if (mass == nullptr) error(element, owner, "has no <mass value=\"...\"/>");
  if (inertia == nullptr) error(element, owner, "has no <inertia ixx=... />");
  if (mass != nullptr) {
    const auto value = read_numbers(*mass, owner, "value", 1, true);
    if (!value.empty() && value[0] < 0.0) error(*mass, owner, "value is negative, expected a mass >= 0 [kg]");
    if (!value.empty() && (value[0] > kLargestMass || (value[0] > 0.0 && value[0] < kSmallestMass))) {
      error(*mass, owner, std::string("value is '") + mass->Attribute("value") + "', expected 0 or 1e-9 to 1e6 [kg]");
    }
  }
  if (inertia == nullptr) return;
  for (const char* name : {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}) read_numbers(*inertia, owner, name, 1, true);
}

void Scanner::scan_geometry(const Element& parent, const std::string& owner) {
  const Element* geometry = parent.FirstChildElement("geometry");
  const Element* shape = geometry == nullptr ? nullptr : geometry->FirstChildElement();
  if (shape == nullptr) return error(parent, owner, "has no <geometry> with a shape");
  const std::string kind = shape->Name();
  std::vector<double> sizes;
  const auto take = [&](const char* attribute, size_t count) {
    for (double v : read_numbers(*shape, owner, attribute, count, true)) sizes.push_back(v);
  };
  if (kind == "box") {
    take("size", 3);
  } else if (kind == "sphere") {
    take("radius", 1);
  } else if (kind == "cylinder") {
    take("radius", 1);
    take("length", 1);
  } else if (kind == "mesh") {
    if (get_attribute(*shape, "filename").empty()) error(*shape, owner, "attribute 'filename' is missing");
    read_numbers(*shape, owner, "scale", 3, false);
  } else {
    error(*shape, owner, "is no known shape, expected box, sphere, cylinder or mesh");
  }
  for (double size : sizes) {
    if (size < 0.0) return error(*shape, owner, "has a negative size");
    if (size > kLargestSize) return error(*shape, owner, "is larger than 10 km; expected metres");
  }
}

void Scanner::scan_link(const Element& element) {
  LinkScan link;
  link.name = read_name(element, "link");
  link.line = element.GetLineNum();
  const std::string owner = "link '" + link.name + "'";
  if (!link.name.empty() && scan_->find_link_line(link.name) > 0) {
    error(element, owner, "stands here again; first in line " + std::to_string(scan_->find_link_line(link.name)));
  }
  if (const Element* inertial = element.FirstChildElement("inertial")) {
    link.inertial_line = inertial->GetLineNum();
    scan_inertial(*inertial, owner);
  }
  for (const Element* c = element.FirstChildElement("collision"); c != nullptr;
       c = c->NextSiblingElement("collision")) {
    link.collision_lines.push_back(c->GetLineNum());
    scan_origin(*c, owner);
    scan_geometry(*c, owner);
  }
  scan_->add(link);
}

std::string Scanner::read_link_reference(const Element& joint, const std::string& owner, const char* tag) {
  const Element* element = joint.FirstChildElement(tag);
  std::string link = element == nullptr ? "" : get_attribute(*element, "link");
  if (link.empty()) {
    error(joint, owner, std::string("has no <") + tag + " link=\"...\"/>");
    return "";
  }
  if (scan_->find_link_line(link) == 0) {
    std::vector<std::string> names;
    for (const LinkScan& l : scan_->links) names.push_back(l.name);
    error(*element, owner, "names link '" + link + "', which is not in the file" + suggest(link, names));
  }
  return link;
}

void Scanner::scan_joint_numbers(const Element& element, const std::string& owner, JointScan* joint) {
  scan_origin(element, owner);
  if (const Element* axis = element.FirstChildElement("axis")) {
    const auto xyz = read_numbers(*axis, owner, "xyz", 3, true);
    if (xyz.size() == 3 && xyz[0] * xyz[0] + xyz[1] * xyz[1] + xyz[2] * xyz[2] < 1e-12 && joint->type != "fixed") {
      error(*axis, owner, "has length zero, expected a direction");
    }
  }
  if (const Element* limit = element.FirstChildElement("limit")) {
    const auto lower = read_numbers(*limit, owner, "lower", 1, false);
    const auto upper = read_numbers(*limit, owner, "upper", 1, false);
    for (const char* name : {"effort", "velocity"}) {
      const auto value = read_numbers(*limit, owner, name, 1, joint->type != "fixed");
      if (!value.empty() && value[0] < 0.0)
        error(*limit, owner, std::string(name) + " is negative, expected a limit >= 0 (0: not known)");
    }
    const bool crossed = !lower.empty() && !upper.empty() && lower[0] > upper[0];
    if (crossed && joint->type != "continuous") error(*limit, owner, "lower is above upper");
  } else if (joint->type == "revolute" || joint->type == "prismatic") {
    error(element, owner, "is " + joint->type + " and has no <limit lower upper effort velocity/>");
  }
  if (const Element* dynamics = element.FirstChildElement("dynamics")) {
    for (const char* name : {"damping", "friction"}) {
      const auto value = read_numbers(*dynamics, owner, name, 1, false);
      if (!value.empty() && value[0] < 0.0) error(*dynamics, owner, std::string(name) + " is negative");
    }
  }
  if (const Element* rotor = element.FirstChildElement("rotor")) {
    const auto value = read_numbers(*rotor, owner, "inertia", 1, true);
    if (!value.empty() && value[0] < 0.0) error(*rotor, owner, "inertia is negative");
    if (!value.empty()) joint->rotor_inertia = value[0];
  }
  if (const Element* spring = element.FirstChildElement("spring")) scan_spring(*spring, owner, joint);
  joint->unactuated = element.FirstChildElement("unactuated") != nullptr;
  if (const Element* mimic = element.FirstChildElement("mimic")) {
    joint->mimic_line = mimic->GetLineNum();
    if (get_attribute(*mimic, "joint").empty()) error(*mimic, owner, "attribute 'joint' is missing");
    read_numbers(*mimic, owner, "multiplier", 1, false);
    read_numbers(*mimic, owner, "offset", 1, false);
  }
}

void Scanner::scan_spring(const Element& element, const std::string& owner, JointScan* joint) {
  const auto stiffness = read_numbers(element, owner, "stiffness", 1, true);
  const auto rest = read_numbers(element, owner, "rest", 1, false);
  if (!stiffness.empty() && stiffness[0] < 0.0) error(element, owner, "stiffness is negative");
  if (!stiffness.empty()) joint->spring.stiffness = stiffness[0];
  if (!rest.empty()) joint->spring.rest = rest[0];
}

void Scanner::scan_joint(const Element& element) {
  JointScan joint;
  joint.name = read_name(element, "joint");
  joint.line = element.GetLineNum();
  joint.type = get_attribute(element, "type");
  const std::string owner = "joint '" + joint.name + "'";
  if (!joint.name.empty() && scan_->find_joint_line(joint.name) > 0) {
    error(element, owner, "stands here again; first in line " + std::to_string(scan_->find_joint_line(joint.name)));
  }
  static const std::set<std::string> known = {"revolute", "continuous", "prismatic", "fixed"};
  if (joint.type == "planar" || joint.type == "floating") {
    error(element, owner,
          "is of type '" + joint.type +
              "', which is not supported; a floating base is asked for by the scenario (base: floating)");
  } else if (known.count(joint.type) == 0) {
    error(element, owner, "is of type '" + joint.type + "', expected revolute, continuous, prismatic or fixed");
  }
  joint.parent = read_link_reference(element, owner, "parent");
  joint.child = read_link_reference(element, owner, "child");
  scan_joint_numbers(element, owner, &joint);
  scan_->add(joint);
}

void Scanner::scan_robot(const Element& robot) {
  for (const Element* e = robot.FirstChildElement("link"); e != nullptr; e = e->NextSiblingElement("link"))
    scan_link(*e);
  // <joint> also stands in <transmission>; only those right below <robot> are joints of the tree.
  for (const Element* e = robot.FirstChildElement("joint"); e != nullptr; e = e->NextSiblingElement("joint"))
    scan_joint(*e);
  if (scan_->links.empty()) error(robot, "", "has no <link>");
  scan_->loops = scan_loops(robot, *scan_, diagnostics_);
}

// Each link is walked through once: from it up to a root, or to one that was walked through before.
void check_cycles(const UrdfScan& scan, const std::map<std::string, const JointScan*>& joint_of_child,
                  Diagnostics* diagnostics) {
  std::set<std::string> walked;
  for (const LinkScan& link : scan.links) {
    std::set<std::string> seen;
    std::string at = link.name;
    auto joint = joint_of_child.find(at);
    while (joint != joint_of_child.end() && walked.count(at) == 0 && seen.insert(at).second) {
      at = joint->second->parent;
      joint = joint_of_child.find(at);
    }
    const bool cycle = joint != joint_of_child.end() && walked.count(at) == 0;
    walked.insert(seen.begin(), seen.end());
    if (!cycle) continue;
    diagnostics->add_error({scan.file, "joint '" + joint->second->name + "'", joint->second->line},
                           "is part of a cycle of parents and children");
  }
}

// One root, one parent a link, no cycle.
void check_tree(UrdfScan* scan, Diagnostics* diagnostics) {
  std::map<std::string, const JointScan*> joint_of_child;
  for (const JointScan& joint : scan->joints) {
    const auto [it, fresh] = joint_of_child.emplace(joint.child, &joint);
    if (fresh) continue;
    diagnostics->add_error(
        {scan->file, "joint '" + joint.name + "'", joint.line},
        "moves link '" + joint.child + "', which joint '" + it->second->name + "' (line " +
            std::to_string(it->second->line) +
            ") moves already: a link has one parent; close the chain with a <loop> (docs/scenario.md)");
  }
  std::vector<const LinkScan*> roots;
  for (const LinkScan& link : scan->links) {
    if (joint_of_child.count(link.name) == 0) roots.push_back(&link);
  }
  for (size_t i = 1; i < roots.size(); ++i) {
    diagnostics->add_error({scan->file, "link '" + roots[i]->name + "'", roots[i]->line},
                           "has no parent joint, and neither has '" + roots[0]->name + "' (line " +
                               std::to_string(roots[0]->line) + "): a robot has one root");
  }
  if (!roots.empty()) scan->root = roots[0]->name;
  check_cycles(*scan, joint_of_child, diagnostics);
}

void remove_children(tinyxml2::XMLElement* parent, const char* name) {
  while (tinyxml2::XMLElement* child = parent->FirstChildElement(name)) parent->DeleteChild(child);
}

std::string print_bare(tinyxml2::XMLDocument* document, tinyxml2::XMLElement* robot) {
  for (const char* name : {"material", "gazebo", "transmission", "sensor", "loop"}) remove_children(robot, name);
  for (auto* link = robot->FirstChildElement("link"); link != nullptr; link = link->NextSiblingElement("link")) {
    remove_children(link, "visual");
  }
  tinyxml2::XMLPrinter printer(nullptr, true);
  document->Print(&printer);
  return printer.CStr();
}

}  // namespace

void UrdfScan::add(const LinkScan& link) {
  links.push_back(link);
  link_lines_.emplace(link.name, link.line);
}

void UrdfScan::add(const JointScan& joint) {
  joints.push_back(joint);
  joint_lines_.emplace(joint.name, joint.line);
}

int UrdfScan::find_link_line(const std::string& name) const {
  const auto found = link_lines_.find(name);
  return found == link_lines_.end() ? 0 : found->second;
}

int UrdfScan::find_joint_line(const std::string& name) const {
  const auto found = joint_lines_.find(name);
  return found == joint_lines_.end() ? 0 : found->second;
}

std::string find_root_element(const std::string& text) {
  tinyxml2::XMLDocument document;
  if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS) return "";
  const Element* root = document.RootElement();
  return root == nullptr ? "" : root->Name();
}

UrdfScan scan_urdf(const std::string& text, const std::string& file, Diagnostics* diagnostics) {
  UrdfScan scan;
  scan.file = file;
  tinyxml2::XMLDocument document;
  if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS) {
    add_xml_error(document, text, file, diagnostics);
    return scan;
  }
  Element* robot = document.FirstChildElement("robot");
  if (robot == nullptr) {
    diagnostics->add_error(file, "has no <robot>, <mujoco> or <sdf> element: neither URDF, MJCF nor SDF");
    return scan;
  }
  Scanner scanner(&scan, diagnostics);
  scanner.scan_robot(*robot);
  if (!diagnostics->has_errors()) check_tree(&scan, diagnostics);
  scan.bare_xml = print_bare(&document, robot);
  return scan;
}

}  // namespace hrp
