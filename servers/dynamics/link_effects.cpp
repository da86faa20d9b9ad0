// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/link_effects.h"

#include "common/base/diagnostics.h"
#include "common/effects/effect_target.h"

namespace hrp {
namespace {

// Places at a moving link are in its own axes, also where those of a foot are not its file's.
int find_moving_link(const TreeSpec& tree, const std::string& name, Transform* X_LF) {
  const int frame = tree.find_frame(name), own = tree.find_link(name);
  if (frame < 0 || own >= 0) return own;
  *X_LF = tree.frames[static_cast<size_t>(frame)].X_LF;
  return tree.frames[static_cast<size_t>(frame)].link;
}

// The link itself and, where it is a foot with a bush, its sole.
std::vector<LinkInertia*> find_parts(const std::string& name, TreeSpec* tree) {
  std::vector<LinkInertia*> parts;
  for (const std::string& part : {name, name + "_sole"}) {
    const int link = tree->find_link(part);
    if (link >= 0) parts.push_back(&tree->links[static_cast<size_t>(link)].inertia);
    if (link < 0 && part == name) return {};
  }
  return parts;
}

// What an effect of a link acts on. A link that is lumped into another has no mass of its own.
EffectTarget find_target(const EffectInfo& effect, const std::string& field, const std::string& name, TreeSpec* tree) {
  EffectTarget target;
  const int link = find_moving_link(*tree, name, &target.X_LF);
  target.link.push_back(&tree->links[static_cast<size_t>(link)].inertia);
  if (!effect.of_whole_link) return target;
  target.link = find_parts(name, tree);
  if (target.link.empty())
    refuse_input({"", field}, "'" + name + "' is fixed to another link and has no mass of its own here");
  return target;
}

void apply_stated(const std::string& name, const StatedEffect& stated, TreeSpec* tree,
                  std::vector<SteadyForce>* forces) {
  const std::string field = "link_laws." + name + "." + stated.effect;
  const EffectInfo* effect = find_effect(stated.effect);
  if (!effect || effect->place != PlaceKind::kLink || !effect->reported) refuse_input({"", field}, "unknown effect");
  std::vector<double> values;
  const ValueFault fault = find_values(*effect, stated.parameters, &values);
  if (!fault.message.empty()) refuse_input({"", field + "." + fault.parameter}, fault.message);
  EffectTarget target = find_target(*effect, field, name, tree);
  Vector3d force_W = Vector3d::Zero();
  target.force_W = &force_W;
  effect->apply(values.data(), target);
  Transform X_LF;
  if (!force_W.isZero()) forces->push_back({find_moving_link(*tree, name, &X_LF), Vector3d::Zero(), force_W});
}

}  // namespace

std::vector<SteadyForce> apply_link_laws(const Scenario& scenario, TreeSpec* tree) {
  std::vector<SteadyForce> forces;
  for (const auto& [name, laws] : scenario.link_laws) {
    Transform X_LF;
    if (find_moving_link(*tree, name, &X_LF) < 0) refuse_input({"", "link_laws." + name}, "the robot has no such link");
    for (const StatedEffect& law : laws) apply_stated(name, law, tree, &forces);
  }
  // After every change of mass: the force acts at the centre of mass as it is.
  for (SteadyForce& force : forces) force.p_LQ = tree->links[static_cast<size_t>(force.link)].inertia.p_LLcm_L;
  return forces;
}

}  // namespace hrp
