// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/export/take_home.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>

#include "common/base/join_words.h"
#include "common/base/read_file.h"
#include "common/base/write_file.h"
#include "common/robot/closed_chains.h"
#include "common/robot/yaml_sections.h"
#include "diagnosis/export/unheld.h"
#include "servers/dynamics/joint_effects.h"
#include "servers/dynamics/link_effects.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;

}  // namespace

TakeHome load_take_home(const std::string& scenario_path) {
  TakeHome out;
  out.scenario = load_scenario(scenario_path);
  for (const auto& [foot, bush] : out.scenario.foot_bush)
    out.forces.push_back(foot + ": a sole that gives, " + print_value(bush.kz) + " N/m in height, " +
                         print_value(bush.k_roll) + " and " + print_value(bush.k_pitch) + " N m/rad in roll and pitch");
  out.scenario.foot_bush.clear();
  out.robot = load_robot(out.scenario);
  if (!adopt_loops(out.scenario, out.robot.scenario).loops.empty()) {
    throw InputError(out.scenario.make_diagnostic(
        "loops", "closed chains are not exported; expected a robot without 'loops' and <loop>"));
  }
  for (const SteadyForce& f : apply_link_laws(out.scenario, &out.robot.tree)) {
    std::string text = out.robot.tree.links[static_cast<size_t>(f.link)].name + ": a constant force of (";
    for (int axis = 0; axis < 3; ++axis) text += (axis > 0 ? ", " : "") + print_value(f.force_W[axis]);
    out.forces.push_back(text + ") N along the world's axes");
  }
  out.laws = make_joint_laws(out.scenario, &out.robot.tree);
  return out;
}

// The top-level sections `robot`, `rotor_inertia`, `controller` and `servo` are written anew. What MuJoCo holds of
// `effects` is in them and in robot.urdf; its server refuses the key.
std::string make_mujoco_scenario(const TakeHome& model, const std::string& nominal) {
  std::string text = "# For hrp-dynamics-mujoco: what MuJoCo holds of the model that was found.\nrobot: robot.urdf\n";
  const std::set<std::string> replaced{"robot", "rotor_inertia", "controller", "servo", "unactuated", "effects"};
  bool motion = false;
  for (const YamlSection& section : split_sections(nominal)) {
    motion = motion || section.key == "controller";
    if (replaced.count(section.key) == 0) text += section.text;
  }
  if (motion) text += "controller: {motion: ../motion.csv}\n";
  text += "servo:\n  joints:\n";
  std::string rotors;
  for (int j = 0; j < model.robot.tree.num_joints(); ++j) {
    const JointLaws& laws = model.laws[static_cast<size_t>(j)];
    const std::string& name = model.robot.tree.joint(j).name;
    const double limit = find_torque_limit(model.robot.tree.joint(j), laws);
    text += "    " + name + ": {kp: " + print_value(laws.kp * laws.torque_scale) +
            ", kd: " + print_value(laws.kd * laws.torque_scale) +
            (limit < kUnlimited ? ", effort_limit: " + print_value(limit) : "") + "}\n";
    if (laws.motor_inertia > 0.0) rotors += "  " + name + ": " + print_value(laws.motor_inertia) + "\n";
  }
  const std::string free = join_words(model.scenario.unactuated);
  return text + (rotors.empty() ? "" : "rotor_inertia:\n" + rotors) +
         (free.empty() ? "" : "unactuated: [" + free + "]\n");
}

void write_take_home(const std::string& updated_folder) {
  const fs::path updated(updated_folder), folder = updated / "export";
  fs::create_directories(folder);
  const TakeHome model = load_take_home((updated / "scenario.yaml").string());
  write_file(folder / "robot.xml", make_mjcf_model(model));
  write_file(folder / "robot.urdf", make_urdf_model(model));
  write_file(folder / "robot.sdf", make_sdf_model(model));
  write_file(folder / "isaac_lab.yaml", make_isaac_table(model));
  if (fs::exists(updated / "nominal.yaml"))
    write_file(folder / "mujoco.yaml", make_mujoco_scenario(model, read_input((updated / "nominal.yaml").string())));
}

}  // namespace hrp::diagnosis
