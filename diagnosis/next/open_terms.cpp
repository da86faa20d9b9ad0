// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/open_terms.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/has.h"
#include "common/effects/units.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/findings/grading.h"
#include "diagnosis/next/explanations.h"
#include "diagnosis/next/limits.h"

namespace hrp::diagnosis {
namespace {

// Terms of the design that stand for one effect.
struct Found {
  int joint = -1;             // of the design; -1: of the whole robot
  std::vector<size_t> terms;  // the first one has the effect's first parameter
};

std::vector<size_t>& get_list(TorqueModel& model, const Found& found) {
  return found.joint < 0 ? model.whole : model.own[static_cast<size_t>(found.joint)];
}

void remove(const Found& found, TorqueModel* model) {
  std::vector<size_t>& list = get_list(*model, found);
  for (size_t term : found.terms) list.erase(std::remove(list.begin(), list.end(), term), list.end());
}

void insert(const Found& found, TorqueModel* model) {
  remove(found, model);
  std::vector<size_t>& list = get_list(*model, found);
  list.insert(list.end(), found.terms.begin(), found.terms.end());
  std::sort(list.begin(), list.end());
}

class Finder {
 public:
  Finder(const Experiment& e, const Json& report) : e_(e), report_(report) {}

  OpenTerms run() {
    TorqueData data = make_torque_data(e_);
    if (data.recordings.empty()) return {};
    out_.design = make_torque_design(std::move(data));
    if (!out_.any()) return {};
    read_best();
    for (const Json& finding : report_.value("findings", Json::array())) add_finding(finding);
    return std::move(out_);
  }

 private:
  // The term of a list with this effect, at this place, whose shape is the nearest.
  std::optional<size_t> find_term(const std::vector<Term>& terms, const EffectInfo& info, int place,
                                  double shape) const {
    std::optional<size_t> best;
    for (size_t t = 0; t < terms.size(); ++t) {
      if (terms[t].row->effect != &info || terms[t].place != place || terms[t].row->scales_model) continue;
      if (!best || std::abs(terms[t].shape - shape) < std::abs(terms[*best].shape - shape)) best = t;
    }
    return best;
  }

  std::optional<Found> find(const Effect& effect) const {
    const EffectInfo& info = get_effect(effect.id);
    if (effect.place.kind == PlaceKind::kLink || effect.place.kind == PlaceKind::kNone) {
      const auto term = find_term(out_.design.whole, info, effect.place.index, 0.0);
      return term ? std::optional<Found>(Found{-1, {*term}}) : std::nullopt;
    }
    const bool of_log = effect.place.kind == PlaceKind::kSensor && effect.place.reading == Reading::kEffort;
    if (effect.place.kind != PlaceKind::kJoint && !of_log) return std::nullopt;
    for (size_t i = 0; i < out_.design.joints.size(); ++i) {
      if (out_.design.joints[i].joint == effect.place.index) return find_own(effect, info, i);
    }
    return std::nullopt;
  }

  // A law with a Stribeck excess is a level of dry friction and the excess.
  std::optional<Found> find_own(const Effect& effect, const EffectInfo& info, size_t i) const {
    const std::vector<Term>& terms = out_.design.joints[i].terms;
    const auto row = std::find_if(terms.begin(), terms.end(), [&](const Term& t) { return t.row->effect == &info; });
    if (row == terms.end()) return find_common(info, effect.place.index);
    const int shape = row->row->shape_parameter;
    const auto term =
        find_term(terms, info, effect.place.index, shape >= 0 ? effect.p[static_cast<size_t>(shape)] : effect.p[0]);
    if (!term) return std::nullopt;
    Found found{static_cast<int>(i), {*term}};
    if (!terms[*term].row->excess) return found;
    const auto level = std::find_if(terms.begin(), terms.end(), [](const Term& t) { return t.row->level; });
    if (level == terms.end()) return std::nullopt;
    found.terms.insert(found.terms.begin(), static_cast<size_t>(level - terms.begin()));
    return found;
  }

  // An encoder's zero is at a joint and in the rows of every joint.
  std::optional<Found> find_common(const EffectInfo& info, int place) const {
    const auto term = find_term(out_.design.whole, info, place, 0.0);
    return term ? std::optional<Found>(Found{-1, {*term}}) : std::nullopt;
  }

  TorqueSide make_side(TorqueModel model, Hypothesis hypothesis) const {
    TorqueSide side{std::move(model), {}, {}, std::move(hypothesis)};
    side.fit = fit_torque(out_.design, side.model);
    side.slots = list_slots(out_.design, side.model);
    return side;
  }

  bool is_finding(const Effect& effect) const {
    const Json findings = report_.value("findings", Json::array());
    return std::any_of(findings.begin(), findings.end(), [&](const Json& finding) {
      Effect found;
      return read_effect(e_, finding, &found) && found.id == effect.id && found.place == effect.place;
    });
  }

  // The report's model has terms for every joint. Those of a joint that did not move cancel each other at rest (a level
  // of friction and a constant torque), so their values are arbitrary. With these values each motion of this joint
  // would seem to need too large efforts, and the joint would stay as unknown as it is.
  bool is_arbitrary(const Effect& effect) const {
    return effect.place.kind == PlaceKind::kJoint && calc_travel(e_, effect.place.index) < kStill &&
           !is_finding(effect);
  }

  void read_best() {
    TorqueModel model;
    model.own.resize(out_.design.joints.size());
    Hypothesis all = read_model(e_, report_);
    all.erase(std::remove_if(all.begin(), all.end(), [&](const Effect& effect) { return is_arbitrary(effect); }),
              all.end());
    for (const Effect& effect : all) {
      if (const auto found = find(effect)) insert(*found, &model);
    }
    out_.best = make_side(std::move(model), all);
  }

  bool has(const Found& found) const {
    TorqueModel model = out_.best.model;
    const std::vector<size_t>& list = get_list(model, found);
    return std::all_of(found.terms.begin(), found.terms.end(), [&](size_t t) { return hrp::has(list, t); });
  }

  void add_finding(const Json& finding) {
    Effect effect;
    if (!read_effect(e_, finding, &effect)) return;
    const auto found = find(effect);
    const std::string label = get_label(e_, effect);
    if (!found) return add_untold(finding, label);
    TorqueSide with = out_.best;
    const bool added = !has(*found);
    if (added) {
      insert(*found, &with.model);
      Hypothesis hypothesis = with.hypothesis;
      hypothesis.push_back(effect);
      with = make_side(with.model, hypothesis);
    } else {
      add_values(finding, effect, *found, label);
    }
    TorqueSide rest = with;
    remove(*found, &rest.model);
    rest.hypothesis.erase(std::remove_if(rest.hypothesis.begin(), rest.hypothesis.end(),
                                         [&](const Effect& e) { return e.id == effect.id && e.place == effect.place; }),
                          rest.hypothesis.end());
    size_t rivals = 0;
    for (Json other : finding.value("alternatives", Json::array())) {
      if (!other.contains("where") || other["where"].empty()) other["where"] = finding["where"];
      rivals += add_alternative(other, label, with, rest) ? 1 : 0;
    }
    if (rivals == 0 && is_ambiguous(finding))
      out_.questions.push_back(
          {(added ? "also " : "no ") + label, with, make_side(rest.model, rest.hypothesis), added});
  }

  bool add_alternative(const Json& alternative, const std::string& label, const TorqueSide& truth,
                       const TorqueSide& rest) {
    Effect other;
    const bool known = read_effect(e_, alternative, &other);
    const auto found = known ? find(other) : std::nullopt;
    const std::string name = known ? get_label(e_, other) : alternative.value("effect", "");
    if (!found) {
      out_.untold.push_back(label + ", or " + name + ": these motions do not tell the two apart" +
                            get_motion(alternative));
      return false;
    }
    // An effect that the model has already takes over what it can: the rival is the rest.
    TorqueModel model = rest.model;
    Hypothesis hypothesis = rest.hypothesis;
    if (!has(*found)) {
      insert(*found, &model);
      hypothesis.push_back(other);
    }
    add_question(name, label, truth, make_side(std::move(model), std::move(hypothesis)));
    return true;
  }

  // Rivals with the same terms are one.
  void add_question(const std::string& name, const std::string& label, const TorqueSide& truth, TorqueSide&& rival) {
    const std::string end = " instead of " + label;
    for (OpenQuestion& q : out_.questions) {
      const bool same = q.rival.model.own == rival.model.own && q.rival.model.whole == rival.model.whole;
      const size_t at = q.label.rfind(end);
      if (!same || at == std::string::npos) continue;
      q.label.insert(at, " or " + name);
      return;
    }
    out_.questions.push_back({name + end, truth, std::move(rival), false});
  }

  static std::string get_motion(const Json& alternative) {
    const std::string motion = alternative.value("motion_that_would_tell", "");
    return motion.empty() ? "" : ". What would: " + motion;
  }

  void add_untold(const Json& finding, const std::string& label) {
    for (const Json& other : finding.value("alternatives", Json::array()))
      out_.untold.push_back(label + ", or " + other.value("effect", "") + ": these motions do not tell the two apart" +
                            get_motion(other));
  }

  // Values whose parameters are those of the columns, in their order. Shapes of laws have no column.
  void add_values(const Json& finding, const Effect& effect, const Found& found, const std::string& label) {
    const std::vector<EffectParameter>& infos = list_infos(effect.id);
    const Json parameters = finding.value("parameters", Json::object());
    std::vector<long> slots = list_own_slots(found);
    for (size_t i = 0; i < std::min(infos.size(), slots.size()); ++i) {
      const Json said = parameters.value(infos[i].name, Json());
      const Json ends = said.is_object() ? said.value("ci95", Json()) : Json();
      const bool plain = infos[i].axis < 0 && ends.size() == 2 && ends[0].is_number() && ends[1].is_number() &&
                         said["value"].is_number();
      if (!plain) continue;
      std::string unit = infos[i].unit;
      if (effect.place.kind == PlaceKind::kJoint) unit = get_joint_unit(e_.robot.tree.joint(effect.place.index), unit);
      out_.values.push_back({effect.id, effect.place, label, infos[i].name, unit, said["value"].get<double>(),
                             0.5 * (ends[1].get<double>() - ends[0].get<double>()), slots[i],
                             is_dry_slot(found, i) ? effect.place.index : -1});
    }
  }

  // Whether the `at`-th slot of an effect is the level of a dry friction of a joint that turns.
  bool is_dry_slot(const Found& found, size_t at) const {
    if (found.joint < 0) return false;
    const JointDesign& joint = out_.design.joints[static_cast<size_t>(found.joint)];
    if (e_.robot.tree.joint(joint.joint).kind != JointKind::kRevolute) return false;
    size_t first = 0;
    for (size_t term : found.terms) {
      if (at == first) return joint.terms[term].row->is_dry();
      first += static_cast<size_t>(joint.terms[term].columns());
    }
    return false;
  }

  std::vector<long> list_own_slots(const Found& found) const {
    TorqueModel model = out_.best.model;
    const std::vector<size_t>& list = get_list(model, found);
    const std::vector<long>& first =
        found.joint < 0 ? out_.best.slots.whole : out_.best.slots.own[static_cast<size_t>(found.joint)];
    std::vector<long> slots;
    for (size_t term : found.terms) {
      const size_t at = static_cast<size_t>(std::find(list.begin(), list.end(), term) - list.begin());
      const Term& of =
          found.joint < 0 ? out_.design.whole[term] : out_.design.joints[static_cast<size_t>(found.joint)].terms[term];
      for (int c = 0; c < of.columns(); ++c) slots.push_back(first[at] + c);
    }
    return slots;
  }

  const Experiment& e_;
  const Json& report_;
  OpenTerms out_;
};

std::string get_name(const Json& where) { return where.empty() ? "" : where.begin()->get<std::string>() + ": "; }

}  // namespace

OpenTerms find_open_terms(const Experiment& experiment, const Json& report) { return Finder(experiment, report).run(); }

std::vector<std::string> list_motion_words(const Json& report) {
  std::vector<std::string> list;
  for (const Json& finding : report.value("findings", Json::array())) {
    std::string names = finding.value("effect", ""), motion;
    for (const Json& other : finding.value("alternatives", Json::array())) {
      names += " or " + other.value("effect", "");
      if (motion.empty()) motion = other.value("motion_that_would_tell", "");
    }
    if (!motion.empty()) list.push_back(get_name(finding.value("where", Json::object())) + names + ": " + motion);
  }
  return list;
}

}  // namespace hrp::diagnosis
