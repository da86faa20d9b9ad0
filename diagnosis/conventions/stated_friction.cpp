// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/stated_friction.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/data/urdf_text.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/model.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/findings/finding_head.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {
namespace {

double& get_stated(TreeSpec* tree, int joint, bool dry) {
  JointSpec& spec = tree->joint(joint);
  return dry ? spec.coulomb_friction : spec.viscous_friction;
}

// What every drive has; a gain, too, where it shows: a drive that gives more than its log says makes friction look
// smaller.
TorqueModel make_model(const TorqueDesign& design) {
  TorqueModel model{list_usual_terms(design), {}};
  for (size_t i = 0; i < design.joints.size(); ++i) {
    const JointDesign& joint = design.joints[i];
    for (size_t t = 0; t < joint.terms.size() && joint.loaded; ++t) {
      if (joint.terms[t].row->scales_effort) model.own[i].push_back(t);
    }
    std::sort(model.own[i].begin(), model.own[i].end());
  }
  return model;
}

// Mean square of a joint's missing torque without some friction, over that with it; training.
double calc_share(const JointDesign& joint, long column, double x) {
  const Gram& g = joint.total;
  const double after = g.c - 2.0 * x * g.b[column] + x * x * g.get(column, column);
  return g.c > 0.0 ? std::clamp(1.0 - after / g.c, 0.0, 1.0) : 0.0;
}

class Refuter {
 public:
  explicit Refuter(const TorqueDesign& design)
      : design_(design),
        model_(make_model(design)),
        fit_(fit_torque(design, model_, true)),
        slots_(list_slots(design, model_)) {}

  // Of a joint of whose friction one part is refuted, the other goes, too, unless the recordings confirm it: they were
  // written down together. What there is of it is found again.
  std::vector<RefutedFriction> run(const TreeSpec& tree) const {
    std::vector<RefutedFriction> out;
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      std::vector<RefutedFriction> stated;
      bool refuted = false;
      for (size_t t = 0; t < model_.own[i].size(); ++t) {
        const TermRow& row = *design_.joints[i].terms[model_.own[i][t]].row;
        if (row.level || row.effect->family == EffectFamily::kSpeedLoss)
          refuted = add(tree, i, t, *row.effect, &stated) || refuted;
      }
      if (refuted) out.insert(out.end(), stated.begin(), stated.end());
    }
    return out;
  }

 private:
  // Whether it is refuted.
  bool add(const TreeSpec& tree, size_t i, size_t t, const EffectInfo& effect,
           std::vector<RefutedFriction>* out) const {
    const JointDesign& joint = design_.joints[i];
    const long slot = slots_.own[i][t], column = joint.first[model_.own[i][t]];
    const JointSpec& spec = tree.joint(joint.joint);
    const double stated = effect.dry ? spec.coulomb_friction : spec.viscous_friction, more = fit_.theta[slot];
    if (!(stated > 0.0)) return false;
    const double std = std::sqrt(std::max(0.0, fit_.covariance(slot, slot)));
    const double size = std::sqrt(joint.total.get(column, column) / std::max(1.0, joint.total.n)) * -more;
    const bool confirmed = std::abs(more) < kNinetyFive * std && stated > kUnlikely * std;
    if (!confirmed)
      out->push_back(
          {joint.joint, &effect, stated, std::max(0.0, stated + more), std, calc_share(joint, column, more)});
    return -more > std::max(kSignificantInJoint * std, kPart * stated) && size > kBlur * joint.spread;
  }

  const TorqueDesign& design_;
  const TorqueModel model_;
  const TorqueFit fit_;
  const Slots slots_;
};

bool states_friction(const TreeSpec& tree) {
  for (int j = 0; j < tree.num_joints(); ++j) {
    if (tree.joint(j).viscous_friction > 0.0 || tree.joint(j).coulomb_friction > 0.0) return true;
  }
  return false;
}

std::string describe(const Experiment& e, const RefutedFriction& r) {
  const JointSpec& joint = e.robot.tree.joint(r.joint);
  const std::string unit = get_joint_unit(joint, r.unit());
  return std::string(r.effect->dry ? "dry" : "viscous") + " friction of " + number(r.stated, 3) + " " + unit + " at " +
         joint.name + "; the recordings show " + number(r.found, 3) + " +- " + number(kNinetyFive * r.std, 2) + " " +
         unit;
}

Json make_finding(const Experiment& e, const RefutedFriction& r) {
  const EffectInfo& effect = *r.effect;
  const JointSpec& joint = e.robot.tree.joint(r.joint);
  const std::string unit = get_joint_unit(joint, r.unit());
  const Json value = make_value(round_to(r.found, 5), round_to(r.std, 3), unit);
  Json f = make_finding_head(effect, {{"joint", joint.name}}, {{effect.parameters[0].name, value}}, Grade::kSupported,
                             r.share);
  f["statement"] = joint.name + ": the model states " + describe(e, r) + ".";
  f["alternatives"] = Json::array();
  f["replaces"] = round_to(r.stated, 5);
  return f;
}

// Whatever friction was found at a place takes the place of what was stated there.
bool has_friction(const Json& findings, const Json& where) {
  return std::any_of(findings.begin(), findings.end(), [&](const Json& f) {
    const EffectInfo* effect = find_effect(f["effect"].get<std::string>());
    return effect && f["where"] == where &&
           (effect->family == EffectFamily::kDryFriction || effect->family == EffectFamily::kSpeedLoss);
  });
}

}  // namespace

std::vector<RefutedFriction> find_refuted_friction(const Experiment& e) {
  if (!states_friction(e.robot.tree)) return {};
  TorqueData data = make_torque_data(e);
  if (data.recordings.empty()) return {};
  const TorqueDesign design = make_torque_design(std::move(data));
  return design.joints.empty() ? std::vector<RefutedFriction>{} : Refuter(design).run(e.robot.tree);
}

Experiment drop_friction(Experiment e, const std::vector<RefutedFriction>& refuted) {
  for (const RefutedFriction& r : refuted) {
    get_stated(&e.robot.tree, r.joint, r.effect->dry) = 0.0;
    e.robot.urdf = set_joint_attribute(e.robot.urdf, e.robot.tree.joint(r.joint).name, "dynamics",
                                       r.effect->dry ? "friction" : "damping", "0");
  }
  return e;
}

void add_refuted_friction(const Experiment& e, const std::vector<RefutedFriction>& refuted, Reports* reports) {
  if (refuted.empty()) return;
  Json& report = reports->report;
  for (const RefutedFriction& r : refuted) {
    const Json finding = make_finding(e, r);
    const auto same = std::find_if(report["findings"].begin(), report["findings"].end(), [&](const Json& f) {
      return f["effect"] == finding["effect"] && f["where"] == finding["where"];
    });
    if (same == report["findings"].end()) {
      if (!has_friction(report["findings"], finding["where"])) report["findings"].push_back(finding);
    } else {
      (*same)["statement"] =
          same->value("statement", "") + " The model states " + number(r.stated, 3) + "; this is all that is there.";
      (*same)["replaces"] = finding["replaces"];
    }
    report["warnings"].push_back("the model states " + describe(e, r) +
                                 ": it was taken out, also for the errors called nominal, and of updated/robot.urdf");
    reports->series["notes"].push_back(report["warnings"].back());
  }
  add_to_verdict(&report);
}

}  // namespace hrp::diagnosis
