// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/even_speeds.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/effect_info.h"
#include "diagnosis/data/gaps.h"
#include "diagnosis/data/range.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/findings/finding_head.h"
#include "diagnosis/findings/grading.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kParts = 8.0;  // of the range: speeds over each are hardly coarser for an encoder's steps

// The parts of one recording. `part` [rad or m].
void add_speeds(const Recording& r, const std::vector<double>& q, double part, double lost, std::vector<double>* out) {
  size_t begin = 0, left = 0;  // of the part, and of its second half
  for (size_t k = 1; k < q.size(); ++k) {
    if (!std::isfinite(q[k])) continue;
    if (r.time[k] - r.time[k - 1] > lost || !std::isfinite(q[begin])) {
      begin = left = k;
      continue;
    }
    const double way = q[k] - q[begin];
    if (std::abs(way) < kHalf * part) left = k;
    if (std::abs(way) < part) continue;
    out->push_back((q[k] - q[left]) / (r.time[k] - r.time[left]));
    begin = left = k;
  }
}

// The slowest and the fastest are left out. Dry friction of real drives changes by a fifth and more along their way and
// as they warm up; while speeds are alike, viscous friction changes by no more than twice that.
bool is_even(std::vector<double> speeds) {
  if (speeds.empty()) return true;
  std::sort(speeds.begin(), speeds.end());
  const auto trim = static_cast<size_t>(kDetail * static_cast<double>(speeds.size()));
  return speeds[speeds.size() - 1 - trim] <= kClearlyMore * speeds[trim];
}

// Torque [N m] of friction at a speed; 0 if it depends on more than that.
double calc_torque(const Json& finding, double speed) {
  const auto get = [&](const char* name) { return read_number(finding["parameters"], name, 0.0); };
  return get("level") + get("coulomb") + get("coefficient") * speed + get("stiffness") * get("yield_angle");
}

bool is_friction(const Json& finding) {
  const EffectInfo* effect = find_effect(finding["effect"].get<std::string>());
  if (!effect || !finding["where"].contains("joint")) return false;
  return effect->family == EffectFamily::kDryFriction || effect->family == EffectFamily::kSpeedLoss ||
         finding["parameters"].contains("yield_angle");  // with memory
}

// `value`: of the law's own parameter, its first.
void list_other(const EffectInfo& other, double value, Json* finding) {
  Json parameters = Json::object();
  if (value > 0.0) parameters[other.parameters[0].name] = round_to(value, 2);
  const Json stated =
      state_alternative(other, (*finding)["where"], parameters, "several constant speeds in both directions");
  Json& list = (*finding)["alternatives"];
  const auto is_listed = [&](const Json& a) { return is_same_effect(a, stated); };
  if (!is_listed(*finding) && std::none_of(list.begin(), list.end(), is_listed)) list.push_back(stated);
}

void doubt_friction(double speed, Json* finding) {
  const double torque = calc_torque(*finding, speed);
  make_ambiguous(finding);
  (*finding)["statement"] = finding->value("statement", "") +
                            " The joint moves at one speed in each direction: that does not tell friction of constant "
                            "level from friction in proportion to speed.";
  list_other(get_constant_friction(), torque, finding);
  list_other(get_effect_of(PlaceKind::kJoint, EffectFamily::kSpeedLoss), torque / speed, finding);
}

}  // namespace

std::vector<double> list_speeds(const Experiment& e, size_t joint) {
  std::vector<double> speeds;
  const double part = calc_position_range(e, joint) / kParts;
  for (const Recording& r : e.recordings) {
    if (part > 0.0 && r.joints[joint].has(Quantity::kPosition))
      add_speeds(r, r.joints[joint].signal[0], part, kGapPeriods * e.sample_time, &speeds);
  }
  return speeds;
}

bool is_of_even_speed(const std::vector<double>& speeds) {
  std::vector<double> forward, backward;
  for (double v : speeds) (v > 0.0 ? forward : backward).push_back(std::abs(v));
  const bool half_way = static_cast<double>(speeds.size()) >= kHalf * kParts;
  return half_way && is_even(forward) && is_even(backward);
}

void doubt_friction_of_even_speeds(const Experiment& e, Json* report) {
  for (Json& f : (*report)["findings"]) {
    if (is_ambiguous(f) || !is_friction(f)) continue;
    for (int j = 0; j < e.num_joints(); ++j) {
      if (f["where"]["joint"] != e.robot.tree.joint(j).name) continue;
      const std::vector<double> speeds = list_speeds(e, static_cast<size_t>(j));
      if (!is_of_even_speed(speeds)) continue;
      double sum = 0.0;
      for (double v : speeds) sum += std::abs(v);
      doubt_friction(sum / static_cast<double>(speeds.size()), &f);
    }
  }
}

}  // namespace hrp::diagnosis
