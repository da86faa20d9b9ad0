// SPDX-License-Identifier: BSD-3-Clause
// First look at a URDF: what urdfdom does not tell. Lines of elements, order of the file, numbers that are none, names
// that are missing, double or unknown, cycles, several roots, and our elements <rotor>, <spring>, <unactuated> and
// <loop>.
#pragma once

#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/base/diagnostics.h"
#include "common/multibody/tree_spec.h"
#include "servers/model_parser/loop_scan.h"

namespace hrp {

struct LinkScan {
  std::string name;
  int line = 0;
  int inertial_line = 0;  // 0 when there is none
  std::vector<int> collision_lines;
};

struct JointScan {
  std::string name, type, parent, child;
  int line = 0;
  int mimic_line = 0;
  double rotor_inertia = 0.0;  // <rotor inertia="..."/> [kg m^2 or kg], reflected to the joint
  JointSpring spring;          // <spring stiffness="..." rest="..."/>
  bool unactuated = false;     // <unactuated/>: nothing drives it
};

struct UrdfScan {
  std::string file;
  std::vector<LinkScan> links;  // in the order of the file
  std::vector<JointScan> joints;
  std::vector<LoopScan> loops;
  std::string root;
  // The XML without what simulation does not use (visuals, materials, simulator and transmission blocks). urdfdom stops
  // reading a link at a faulty visual and silently drops the collision elements behind it (seen with SR1's chest).
  std::string bare_xml;

  void add(const LinkScan& link);
  void add(const JointScan& joint);
  // Line of the first one of this name, 0 for none.
  int find_link_line(const std::string& name) const;
  int find_joint_line(const std::string& name) const;

 private:
  std::unordered_map<std::string, int> link_lines_, joint_lines_;
};

// Name of the first element: "robot", "mujoco", "sdf". Empty for what is no XML.
std::string find_root_element(const std::string& text);

// Adds errors to `diagnostics`; the scan can be used when there are none.
UrdfScan scan_urdf(const std::string& text, const std::string& file, Diagnostics* diagnostics);

}  // namespace hrp
