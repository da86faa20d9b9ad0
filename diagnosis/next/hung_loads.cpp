// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/hung_loads.h"

#include <algorithm>

#include "common/base/rounding.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/model/tree.h"

namespace hrp::diagnosis {
namespace {

constexpr double kMasses[] = {5.0, 2.0, 1.0, 0.5, 0.2, 0.1};  // [kg]
constexpr double kPlace = 1e-3;  // [m] resolution of a stated place, as precise as people measure

double calc_moving_mass(const TreeSpec& tree, int last) {
  double mass = 0.0;
  for (int link = last; link > 0; link = tree.links[static_cast<size_t>(link)].parent)
    mass += tree.links[static_cast<size_t>(link)].inertia.mass;
  return mass;
}

}  // namespace

std::vector<LoadSpec> list_hung_loads(const TreeSpec& tree, double most) {
  std::vector<LoadSpec> loads;
  for (size_t link = 1; link < tree.links.size() && loads.size() < kLookedAt; ++link) {
    if (!is_last(tree, static_cast<int>(link))) continue;
    const double allowed = std::min(most, kPart * calc_moving_mass(tree, static_cast<int>(link)));
    const auto mass = std::find_if(std::begin(kMasses), std::end(kMasses), [&](double m) { return m <= allowed; });
    if (mass == std::end(kMasses)) continue;
    const Vector3d p = tree.links[link].inertia.p_LLcm_L;
    loads.push_back({tree.links[link].name, *mass, kPlace * (p / kPlace).array().round().matrix()});
  }
  return loads;
}

std::string describe(const LoadSpec& load) {
  const Vector3d& p = load.p_LC;
  return "Hang " + number(load.mass, 3) + " kg on " + load.link + ", its centre at (" + number(p.x(), 4) + ", " +
         number(p.y(), 4) + ", " + number(p.z(), 4) + ") m in the link's frame.";
}

}  // namespace hrp::diagnosis
