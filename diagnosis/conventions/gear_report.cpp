// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/gear_report.h"

#include <algorithm>

#include "common/effects/effect_info.h"
#include "diagnosis/conventions/effort_units.h"
#include "diagnosis/conventions/list_fit.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/odds.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/findings/finding_head.h"
#include "diagnosis/findings/grading.h"
#include "diagnosis/measurement/joint_zeros.h"

namespace hrp::diagnosis {
namespace {

// What efforts say of a joint's ratio, and by how many nats more than every effect does with angles as logged.
struct Asked {
  GearRatio ratio;
  double gain = 0.0;
  ListFit fit;
};

// Of the first ratios, those beside which the effects of joints and drives explain more than as logged. A choice among
// these effects takes a small part of the time of one among all.
std::vector<GearRatio> list_promising(const Experiment& e, const TorqueDesign& design,
                                      const std::vector<GearRatio>& list, int jobs) {
  const ListFit as_logged = fit_list(design, jobs, Of::kJoints);
  // Several: a wrong angle moves the torques of its neighbours, too.
  std::vector<GearRatio> out(list.begin(), list.begin() + static_cast<long>(std::min(kLookedAt, list.size())));
  const auto is_worse = [&](const GearRatio& r) {
    return compare(fit_list(convert_ratio(e, r), jobs, Of::kJoints), as_logged) <= 0.0;
  };
  out.erase(std::remove_if(out.begin(), out.end(), is_worse), out.end());
  return out;
}

Asked ask(const Experiment& e, const TorqueData& data, const std::vector<GearRatio>& list, int jobs) {
  Asked best;
  const TorqueDesign design = make_torque_design(TorqueData(data));
  const std::vector<GearRatio> promising = list_promising(e, design, list, jobs);
  if (promising.empty()) return best;
  const ListFit as_logged = fit_list(design, jobs);
  for (const GearRatio& ratio : promising) {
    const ListFit fit = fit_list(convert_ratio(e, ratio), jobs);
    const double gain = compare(fit, as_logged) - kOneValue;
    if (gain > best.gain) best = {ratio, gain, fit};
  }
  return best;
}

// [nats] by which the ratio explains more than other zeros or senses of joints, which bend the weight's torque as well.
double compare_with_zeros(const Experiment& e, const TorqueData& data, const Asked& asked, int jobs) {
  const std::vector<JointZero> zeros = find_joint_zeros(data).joints;
  return zeros.empty() ? asked.gain : compare(asked.fit, fit_list(convert_zeros(e, zeros), jobs));
}

// [nats] by which the ratio explains more than another unit does with angles as logged, of this joint's effort or of
// the whole log. While angles are small, torques are in proportion to them: efforts in a unit of the ratio, or with a
// motor's efforts of its square, do the same. On an upright axis they always do.
double compare_with_units(const Experiment& e, const Asked& asked, int jobs) {
  double least = asked.gain;
  EffortUnit unit;
  for (int power = 1; power <= (asked.ratio.of_motor ? 2 : 1); ++power) {
    unit.scale *= asked.ratio.ratio;
    std::vector<EffortUnit> units;
    for (unit.joint = 0; unit.joint < e.num_joints(); ++unit.joint) units.push_back(unit);
    least = std::min(least, compare(asked.fit, fit_list(convert_efforts(e, units), jobs)));
    unit.joint = asked.ratio.joint;
    least = std::min(least, compare(asked.fit, fit_list(convert_efforts(e, {unit}), jobs)));
  }
  return least;
}

std::string name_joint(const Experiment& e, const GearRatio& ratio) { return e.robot.tree.joint(ratio.joint).name; }

std::string say_value(const GearRatio& ratio) {
  return number(ratio.ratio, 4) + " +- " + number(kNinetyFive * ratio.std, 2);
}

Json make_scale(const Experiment& e, const GearRatio& ratio) {
  return state_alternative(get_effect_of(PlaceKind::kSensor, EffectFamily::kGain),
                           {{"sensor", e.signal_name(ratio.joint, Quantity::kPosition)}},
                           {{"scale", make_value(round_to(ratio.ratio, 5), round_to(ratio.std, 3), "1")}});
}

}  // namespace

Ratios find_gear_ratios(const Experiment& e, int jobs) {
  Ratios out;
  Experiment now = e;
  for (int i = 0; i < e.num_joints(); ++i) {
    const TorqueData data = make_torque_data(now);
    const std::vector<GearRatio> list = data.recordings.empty() ? std::vector<GearRatio>{} : list_gear_ratios(data);
    if (list.empty()) break;
    const Asked asked = ask(now, data, list, jobs);
    if (asked.gain < kWholeGain) break;
    const double over_others =
        std::min(compare_with_zeros(now, data, asked, jobs), compare_with_units(now, asked, jobs));
    if (over_others < -kWholeGain) break;
    if (!asked.ratio.agreed || over_others < kWholeGain) {
      out.doubted.push_back(asked.ratio);
      break;
    }
    out.found.push_back(asked.ratio);
    now = convert_ratio(std::move(now), asked.ratio);
  }
  return out;
}

Experiment convert_ratios(Experiment e, const Ratios& ratios) {
  for (const GearRatio& ratio : ratios.found) e = convert_ratio(std::move(e), ratio);
  return e;
}

std::string describe(const Experiment& e, const GearRatio& ratio) {
  return "the angles of " + name_joint(e, ratio) + " divided by " + number(ratio.ratio, 4) +
         (ratio.of_motor ? ", its efforts taken times that" : "");
}

Json make_ratio_finding(const Experiment& e, const GearRatio& ratio) {
  Json f = make_scale(e, ratio);
  f["grade"] = get_grade_name(Grade::kSupported);
  f["probability"] = kSurest;
  f["share"] = f["weight"] = round_to(1.0 - ratio.left, 3);
  f["of_log"] = true;
  f["statement"] =
      e.signal_name(ratio.joint, Quantity::kPosition) + ": the recorded angle is " + say_value(ratio) +
      " times the joint's: the angle of the motor before its gear, or divided by the ratio of another gear." +
      (ratio.of_motor ? " The effort is the motor's, too: it was multiplied by the ratio." : "");
  f["alternatives"] = Json::array();
  return f;
}

void doubt_ratios(const Experiment& e, const Ratios& ratios, Reports* reports) {
  for (const GearRatio& ratio : ratios.doubted) {
    const std::string joint = name_joint(e, ratio);
    const std::string text = e.signal_name(ratio.joint, Quantity::kPosition) +
                             ": the efforts agree better with angles divided by " + say_value(ratio) +
                             "; is this the angle of the motor, or is the gear another one? The recordings do not tell "
                             "it clearly, so nothing was converted";
    reports->report["warnings"].push_back(text);
    reports->series["notes"].push_back(text);
    for (Json& f : reports->report["findings"]) {
      if (f["where"].value("joint", "") != joint && !f["where"].contains("link")) continue;
      make_ambiguous(&f);
      f["statement"] = f.value("statement", "") + " Or the recorded angle of " + joint + " is " +
                       number(ratio.ratio, 3) + " times the joint's.";
      f["alternatives"].push_back(make_scale(e, ratio));
    }
  }
}

}  // namespace hrp::diagnosis
