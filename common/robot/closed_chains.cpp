// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/closed_chains.h"

#include <algorithm>
#include <cmath>

#include <yaml-cpp/yaml.h>

#include "common/base/diagnostics.h"
#include "common/base/exact_number.h"
#include "common/robot/foot_bush.h"

namespace hrp {
namespace {

int find_loop_link(const TreeSpec& tree, const Scenario& scenario, const std::string& field, const std::string& name,
                   Transform* X_LF) {
  const int frame = tree.find_frame(name), link = tree.find_link(name);
  if (frame < 0 && link < 0) throw InputError(scenario.make_diagnostic(field, "the robot has no link '" + name + "'"));
  if (frame < 0) return link;
  *X_LF = tree.frames[static_cast<size_t>(frame)].X_LF * *X_LF;
  return tree.frames[static_cast<size_t>(frame)].link;
}

YAML::Node make_numbers(const Vector3d& values) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (int k = 0; k < 3; ++k) list.push_back(format_exact(values[k]));
  return list;
}

// Roll, pitch, yaw of R = Rz(yaw) Ry(pitch) Rx(roll) [rad]. Looking straight up or down, yaw is taken as zero.
Vector3d calc_rpy(const Matrix3d& R) {
  const double level = std::hypot(R(0, 0), R(1, 0));
  const double pitch = std::atan2(-R(2, 0), level);
  if (level < 1e-9) return {std::atan2(-R(1, 2), R(1, 1)), pitch, 0.0};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

YAML::Node make_section(const std::vector<LoopSpec>& loops) {
  YAML::Node section(YAML::NodeType::Map);
  for (const LoopSpec& loop : loops) {
    YAML::Node entry(YAML::NodeType::Map);
    entry["kind"] = loop.kind;
    entry["link_a"] = loop.link_a;
    entry["link_b"] = loop.link_b;
    entry["xyz_a"] = make_numbers(loop.X_AF.p);
    entry["rpy_a"] = make_numbers(calc_rpy(loop.X_AF.R));
    entry["xyz_b"] = make_numbers(loop.X_BF.p);
    entry["rpy_b"] = make_numbers(calc_rpy(loop.X_BF.R));
    section[loop.name] = entry;
  }
  return section;
}

std::string print_flow(YAML::Node section) {
  YAML::Emitter out;
  out.SetMapFormat(YAML::Flow);
  out.SetSeqFormat(YAML::Flow);
  out << section;
  return out.c_str();
}

}  // namespace

std::vector<LoopConstraint> find_loops(const TreeSpec& tree, const Scenario& scenario) {
  std::vector<LoopConstraint> loops;
  for (const LoopSpec& spec : scenario.loops) {
    LoopConstraint loop;
    const std::string field = "loops." + spec.name;
    loop.kind = spec.kind == "ball" ? LoopKind::kBall : (spec.kind == "weld" ? LoopKind::kWeld : LoopKind::kPin);
    loop.X_AF = spec.X_AF;
    loop.X_BF = spec.X_BF;
    loop.link_a = find_loop_link(tree, scenario, field + ".link_a", spec.link_a, &loop.X_AF);
    if (!spec.link_b.empty()) loop.link_b = find_loop_link(tree, scenario, field + ".link_b", spec.link_b, &loop.X_BF);
    if (loop.link_a == loop.link_b) {
      throw InputError(scenario.make_diagnostic(
          field, "both ends are on the same moving link, '" + tree.links[static_cast<size_t>(loop.link_a)].name + "'"));
    }
    loops.push_back(loop);
  }
  return loops;
}

std::vector<int> find_passive_joints(const TreeSpec& tree) {
  std::vector<int> joints;
  for (int i = 0; i < tree.num_joints(); ++i) {
    const JointSpec& joint = tree.joint(i);
    if (!joint.actuated && joint.mimic.joint < 0 && !is_bush_joint(joint.name)) joints.push_back(i);
  }
  return joints;
}

std::string add_loops(const std::string& text, const std::vector<LoopSpec>& loops) {
  if (loops.empty()) return text;
  YAML::Node root = YAML::Load(text);
  const YAML::Node section = make_section(loops);
  // Usual text gets one line more, so that its comments and line numbers stay; other YAML is written anew.
  if (!root["loops"] && root.Style() == YAML::EmitterStyle::Block && text.find("\n...") == std::string::npos) {
    std::string longer =
        text + (text.empty() || text.back() == '\n' ? "" : "\n") + "loops: " + print_flow(section) + "\n";
    try {
      if (YAML::Load(longer)["loops"].size() == loops.size()) return longer;
    } catch (const YAML::Exception&) {  // say, a text that ends within a block: written anew below
    }
  }
  for (const auto& entry : section) root["loops"][entry.first] = entry.second;
  YAML::Emitter all;
  all << root;
  return std::string(all.c_str()) + "\n";
}

Scenario adopt_loops(const Scenario& scenario, const std::string& merged) {
  Scenario result = scenario;
  if (merged == scenario.text) return result;
  const Scenario read = parse_scenario(merged, scenario.path);
  result.initial_joints.insert(read.initial_joints.begin(), read.initial_joints.end());
  if (!read.loops.empty()) result.loops = read.loops;
  return result;
}

}  // namespace hrp
