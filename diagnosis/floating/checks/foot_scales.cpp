// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/foot_scales.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/checks/weight_check.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

// Squares about one share for all phases.
double calc_left_by_mass(const std::map<int, Consensus>& phases) {
  double mean = 0, left = 0;
  for (const auto& [phase, k] : phases) mean += k.mean / static_cast<double>(phases.size());
  for (const auto& [phase, k] : phases) left += std::pow(k.mean - mean, 2);
  return left;
}

// Of what all feet bear, the foot's part: each bears as much as the others while all stand.
double find_part(int phase, size_t foot, size_t feet) {
  const bool alone = phase == 1 << foot;
  return alone ? 1.0 : phase == (1 << feet) - 1 ? 1.0 / static_cast<double>(feet) : 0.0;
}

FootScale fit_scale(const std::map<int, Consensus>& phases, size_t foot, size_t feet, double by_mass) {
  double xx = 0, xy = 0, left = 0, noise = 0;
  for (const auto& [phase, k] : phases) {
    const double x = find_part(phase, foot, feet);
    xx += x * x;
    xy += x * (k.mean - 1);
    noise += std::pow(x * k.std, 2);
  }
  const double more = xy / xx;
  for (const auto& [phase, k] : phases) left += std::pow(k.mean - 1 - more * find_part(phase, foot, feet), 2);
  // Phases less the one number that is fitted to them.
  const double scatter = left / static_cast<double>(phases.size() - 1) / xx;
  return {foot, 1 + more, std::sqrt(scatter + noise / (xx * xx)), left / std::max(1e-300, by_mass)};
}

}  // namespace

std::vector<FootScale> list_foot_scales(const std::map<int, Consensus>& phases, size_t feet) {
  std::map<int, Consensus> known;
  for (const auto& [phase, k] : phases) {
    if (phase == (1 << feet) - 1 || (phase & (phase - 1)) == 0) known[phase] = k;
  }
  std::vector<FootScale> out;
  if (feet < 2 || known.size() < feet + 1) return out;
  for (size_t f = 0; f < feet; ++f) {
    const FootScale s = fit_scale(known, f, feet, calc_left_by_mass(known));
    if (s.left < 1) out.push_back(s);
  }
  std::sort(out.begin(), out.end(), [](const FootScale& a, const FootScale& b) { return a.left < b.left; });
  return out;
}

bool take_foot_scale(const LeggedLog& log, const std::vector<FootScale>& scales, const char* motion, Finding* weight) {
  bool taken = false;
  for (const FootScale& s : scales) {
    const int sensor = log.feet[s.foot].sensor;
    if (sensor < 0 || std::abs(s.scale - 1) < std::max(kUnlikely * s.std, kTrace)) continue;
    const EffectInfo& scale = get_laws().sensor_scale.info();
    const Where where{{"sensor", "/wrench/" + log.sensors[static_cast<size_t>(sensor)].name + "/force"}};
    weight->alternatives.push_back(make_alternative(scale, where, {make_value(scale, s.scale, s.std)}, motion));
    if (taken || s.left > kPart) continue;
    Alternative& other = weight->alternatives.back();
    std::swap(weight->effect, other.effect);
    std::swap(weight->family, other.family);
    std::swap(weight->where, other.where);
    std::swap(weight->parameters, other.parameters);
    weight->statement += format(
        " The scale of this foot's sensor leaves %.2f of what a mass leaves of these shares, in squares.", s.left);
    taken = true;
  }
  return taken;
}

}  // namespace hrp::diagnosis::floating
