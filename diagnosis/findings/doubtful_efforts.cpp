// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/doubtful_efforts.h"

#include <set>
#include <string>

#include "common/effects/effect_info.h"
#include "diagnosis/data/range.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/findings/finding_head.h"
#include "diagnosis/findings/grading.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kRests = 0.05;  // [rad or m] over all recordings: friction of gears does not change its side within

bool is_of_family(const Json& finding, EffectFamily family) {
  return finding.value("family", "") == get_family_name(family);
}

// The joint whose drive or effort a finding is about; -1: none.
int find_joint_of_effort(const Experiment& e, const Json& finding) {
  for (int j = 0; j < e.num_joints(); ++j) {
    if (finding["where"].value("joint", "") == e.robot.tree.joint(j).name ||
        finding["where"].value("sensor", "") == e.signal_name(j, Quantity::kEffort))
      return j;
  }
  return -1;
}

Json state_friction(const std::string& joint, const char* motion) {
  return state_alternative(get_constant_friction(), {{"joint", joint}}, Json::object(), motion);
}

std::set<std::string> list_joints_with_losses(const Json& findings) {
  std::set<std::string> joints;
  for (const Json& f : findings) {
    const bool loss = is_of_family(f, EffectFamily::kDryFriction) || is_of_family(f, EffectFamily::kSpeedLoss);
    if (loss && f["where"].contains("joint")) joints.insert(f["where"]["joint"].get<std::string>());
  }
  return joints;
}

// Squares of what is missing in the joints' equations, the joint with most of it, and how many joints have any.
struct JointSquares {
  double before = 0.0, after = 0.0, most = 0.0;
  std::string joint;
  size_t joints = 0;
};

JointSquares sum_up(const Experiment& e, const Json& report) {
  JointSquares sum;
  const Json signals = report.value("fit", Json::object()).value("per_signal", Json::object());
  for (int j = 0; j < e.num_joints(); ++j) {
    bool any = false;  // the links' equation, the servo's, or both
    for (const auto& [signal, fit] : signals.items()) {
      if (signal.rfind(e.signal_name(j, Quantity::kEffort), 0) != 0 || !fit.contains("rms_before")) continue;
      const double before = fit["rms_before"], after = fit["rms_after"];
      sum.before += before * before;
      sum.after += after * after;
      any = true;
      if (before > sum.most) {
        sum.most = before;
        sum.joint = e.robot.tree.joint(j).name;
      }
    }
    if (any) ++sum.joints;
  }
  return sum;
}

}  // namespace

void doubt_efforts_at_rest(const Experiment& e, Json* report) {
  for (Json& f : (*report)["findings"]) {
    const int j = find_joint_of_effort(e, f);
    if (j < 0 || is_ambiguous(f)) continue;
    if (!is_of_family(f, EffectFamily::kZero) && !is_of_family(f, EffectFamily::kGain)) continue;
    const double range = calc_position_range(e, static_cast<size_t>(j));
    if (range <= 0.0 || range > kRests) continue;
    const std::string joint = e.robot.tree.joint(j).name;
    make_ambiguous(&f);
    f["statement"] = f.value("statement", "") + " " + joint +
                     " rests in all recordings: its dry friction may hold as much, in either direction.";
    f["alternatives"].push_back(state_friction(joint, "motion of this joint in both directions"));
  }
}

void doubt_common_scale(const Experiment& e, Json* report) {
  Json& findings = (*report)["findings"];
  const JointSquares sum = sum_up(e, *report);
  if (sum.after < kTrace * sum.before || 2 * list_joints_with_losses(findings).size() > sum.joints) return;
  for (Json& f : findings) {
    const bool all = is_of_family(f, EffectFamily::kGain) && f["where"].value("sensor", "") == "/joint_states";
    if (!all || is_ambiguous(f) || read_number(f["parameters"], "scale", 0.0) <= 1.0) continue;
    make_ambiguous(&f);
    f["statement"] = f.value("statement", "") +
                     " Friction and rotors of all drives also make efforts larger than what the links need.";
    const char* motion = "slow motion under load: there a scale makes as much, and rotors nothing";
    f["alternatives"].push_back(state_friction(sum.joint, motion));
  }
}

}  // namespace hrp::diagnosis
