// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/link_effects.h"

#include "common/base/diagnostics.h"

namespace hrp {
namespace {

[[noreturn]] void fail(const std::string& field, const std::string& message) {
  Diagnostic diagnostic;
  diagnostic.field = field;
  diagnostic.message = message;
  throw InputError(diagnostic);
}

int find_moving_link(const TreeSpec& tree, const std::string& name, Transform* X_LF) {
  const int frame = tree.find_frame(name);
  if (frame < 0) return tree.find_link(name);
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

void change_parts(const std::string& field, const std::string& name, const LinkLawSpec& law, TreeSpec* tree) {
  const std::vector<LinkInertia*> parts = find_parts(name, tree);
  if (parts.empty()) fail(field, "'" + name + "' is fixed to another link and has no mass of its own here");
  for (LinkInertia* inertia : parts) {
    if (law.effect == "mass_error") scale_mass(law.number, inertia);
    if (law.effect == "com_error") move_centre_of_mass(law.vector, inertia);
  }
}

}  // namespace

void add_payload(double mass, const Vector3d& p_LP, LinkInertia* inertia) {
  const double total = inertia->mass + mass;
  if (!(total > 0.0)) return;
  // Two bodies about their common centre of mass: the reduced mass on the distance between their centres.
  const Vector3d d = p_LP - inertia->p_LLcm_L;
  const double reduced = inertia->mass * mass / total;
  inertia->I_LLcm_L += reduced * (d.squaredNorm() * Matrix3d::Identity() - d * d.transpose());
  inertia->p_LLcm_L += mass / total * d;
  inertia->mass = total;
}

void scale_mass(double scale, LinkInertia* inertia) {
  inertia->mass *= scale;
  inertia->I_LLcm_L *= scale;
}

void move_centre_of_mass(const Vector3d& offset, LinkInertia* inertia) { inertia->p_LLcm_L += offset; }

std::vector<SteadyForce> apply_link_laws(const Scenario& scenario, TreeSpec* tree) {
  std::vector<SteadyForce> forces;
  for (const auto& [name, laws] : scenario.link_laws) {
    Transform X_LF;
    const int link = find_moving_link(*tree, name, &X_LF);
    if (link < 0) fail("link_laws." + name, "the robot has no such link");
    LinkInertia& inertia = tree->links[static_cast<size_t>(link)].inertia;
    for (const LinkLawSpec& law : laws) {
      const std::string field = "link_laws." + name + "." + law.effect;
      if (law.effect == "payload") {
        if (!(law.number > 0.0)) fail(field, "the mass must be positive");
        add_payload(law.number, X_LF * law.vector, &inertia);
      } else if (law.effect == "mass_error" || law.effect == "com_error") {
        if (law.effect == "mass_error" && !(law.number > 0.0)) fail(field, "the scale must be positive");
        change_parts(field, name, law, tree);
      } else if (law.effect == "external_force") {
        forces.push_back({link, Vector3d::Zero(), law.vector});
      } else {
        fail(field, "unknown effect");
      }
    }
  }
  // After every change of mass: the force acts at the centre of mass as it is.
  for (SteadyForce& force : forces) force.p_LQ = tree->links[static_cast<size_t>(force.link)].inertia.p_LLcm_L;
  return forces;
}

}  // namespace hrp
