// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/findings.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/base/has.h"
#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/free_model.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/balancers.h"
#include "diagnosis/evidence/coupled_drives.h"
#include "diagnosis/evidence/held_commands.h"
#include "diagnosis/evidence/idle_drives.h"
#include "diagnosis/evidence/indistinguishable.h"
#include "diagnosis/evidence/lone_delay.h"
#include "diagnosis/evidence/servo_damping.h"
#include "diagnosis/evidence/soft_joints.h"
#include "diagnosis/evidence/torque/bristles.h"
#include "diagnosis/evidence/torque/gears.h"
#include "diagnosis/evidence/torque/grade.h"
#include "diagnosis/evidence/torque/loads.h"
#include "diagnosis/evidence/torque/misleading.h"
#include "diagnosis/evidence/torque/possible.h"
#include "diagnosis/evidence/torque/samples.h"
#include "diagnosis/evidence/torque/words.h"
#include "diagnosis/evidence/unlisted_friction.h"
#include "diagnosis/measurement/torque/term_rows.h"
#include "diagnosis/search/relation.h"
#include "diagnosis/search/search.h"

namespace hrp::diagnosis {
namespace {

class Judge {
 public:
  Judge(const Experiment& e, TorqueDesign&& design, int jobs) : e_(e), jobs_(jobs), design_(std::move(design)) {
    choice_ = choose_with_placed_loads(jobs, &design_);
    drop_misleading_terms(jobs, Timing::kFree, &design_, &choice_);
    exchange_misleading_zeros(design_, jobs, &choice_);
    choice_.fit = fit_torque(design_, choice_.model);
    graded_ = grade_terms(design_, choice_, jobs);
    if (drop_false_gains(jobs, graded_, &design_, &choice_)) graded_ = grade_terms(design_, choice_, jobs);
    drop_untold_delay(jobs);
    take_simpler_terms(jobs);
    doubt_lone_delays(design_, choice_, &graded_);
    doubt_viscous_of_one_delay(design_, &graded_);
    widen_by_held_commands(design_, &graded_);
  }

  TorqueVerdict run() {
    TorqueVerdict out;
    out.judged = true;
    out.joints = static_cast<int>(design_.joints.size());
    out.frozen = design_.data->frozen;
    drop_lone_excess();
    doubt_gears(design_, choice_, &graded_);
    explain_by_gears(design_, &graded_);
    doubt_balancers(design_, &graded_);
    add_findings(&out);
    for (const SoftGear& gear : design_.data->soft)
      add_soft_gear(e_, gear, design_.data->source[static_cast<size_t>(gear.joint)], &out.evidence.findings,
                    &out.model);
    for (const ServoDelay& delay : design_.data->delays) add_delay(delay, &out);
    for (size_t j = 0; j < design_.data->servo.size(); ++j) add_log(static_cast<int>(j), &out);
    for (size_t j = 0; j < design_.data->velocity.size(); ++j) add_velocity(static_cast<int>(j), &out);
    add_remaining(&out);
    add_resting(&out);
    // In an exact world, an effect that the model does not need does not exist.
    if (out.exact == 0 && !out.evidence.findings.empty()) {
      join_bristles(*design_.data, &out.evidence.findings);
      add_possible(&out);
    }
    sort_findings(&out.evidence.findings);
    out.evidence.method = "torque along the smoothed recorded motion, up to " + number(design_.data->cutoff, 3) + " Hz";
    out.evidence.warnings = design_.data->warnings;
    out.evidence.missing = design_.data->missing;
    doubt_idle_drives(*design_.data, &out.evidence);
    return out;
  }

 private:
  // A servo with damping kd gives a late command (delay T0) the signature of a rotor kd T0, and of friction. One delay
  // in place of a rotor at each joint makes the model smaller. So do delays at several joints. Therefore they stay only
  // if they predict clearly better than friction and rotors; that of a bus must also be supported.
  void drop_untold_delay(int jobs) {
    const auto delay =
        std::find_if(graded_.begin(), graded_.end(), [](const GradedTerm& g) { return g.term.row->is_of_bus(); });
    const auto late =
        std::count_if(graded_.begin(), graded_.end(), [](const GradedTerm& g) { return g.term.row->late; });
    if (delay == graded_.end() && late < 2) return;
    // rows that misled beside the delay may be right without it
    for (JointDesign& joint : design_.joints) joint.barred.clear();
    Choice drives = choose_torque_model(design_, jobs, Timing::kAsRecorded);
    drop_misleading_terms(jobs, Timing::kAsRecorded, &design_, &drives);
    const TorqueFit friction_and_rotors = fit_torque(design_, drop_timing(drives.model));
    const bool told = calc_held_left(design_, choice_.fit) < kPart * calc_held_left(design_, friction_and_rotors);
    if (told && (delay == graded_.end() || delay->grade == Grade::kSupported)) return;
    choice_ = drives;
    choice_.fit = fit_torque(design_, choice_.model);
    graded_ = grade_terms(design_, choice_, jobs);
  }

  // The model without lags and delays of joints, which have the same signature as a bus delay.
  TorqueModel drop_timing(TorqueModel model) const {
    for (size_t i = 0; i < model.own.size(); ++i) {
      const auto is_timing = [&](size_t t) {
        return design_.joints[i].terms[t].effect().family == EffectFamily::kTiming;
      };
      model.own[i].erase(std::remove_if(model.own[i].begin(), model.own[i].end(), is_timing), model.own[i].end());
    }
    return model;
  }

  // A spring that does not differ from none in stiffness is the constant torque that it contains.
  void take_simpler_terms(int jobs) {
    bool any = false;
    for (const GradedTerm& g : graded_) {
      if (g.place.joint < 0 || std::abs(g.parameters[0]) > kNinetyFive * g.width[0]) continue;
      const auto simpler = std::find_if(g.rivals.begin(), g.rivals.end(),
                                        [&](const Rival& r) { return g.term.row->contains(*r.term.row); });
      if (simpler == g.rivals.end()) continue;
      // a joint has one spring, so its list in the rival's model is the same but for this term
      const auto joint = static_cast<size_t>(g.place.joint);
      choice_.model.own[joint] = simpler->model.own[joint];
      any = true;
    }
    if (!any) return;
    choice_.fit = fit_torque(design_, choice_.model);
    graded_ = grade_terms(design_, choice_, jobs);
  }

  // A Stribeck excess without a friction level is no law.
  void drop_lone_excess() {
    for (GradedTerm& g : graded_) {
      if (g.term.row->excess && find_level(g) == nullptr) g.named = false;
    }
  }

  // The named dry friction at the joint of another term, and what a static level has beyond it; null if none.
  const GradedTerm* find_level(const GradedTerm& other) const { return find_named(other, &TermRow::level); }
  const GradedTerm* find_excess(const GradedTerm& level) const { return find_named(level, &TermRow::excess); }
  const GradedTerm* find_named(const GradedTerm& other, bool TermRow::*is_so) const {
    for (const GradedTerm& g : graded_) {
      if (g.term.row->*is_so && g.place.joint == other.place.joint && g.named) return &g;
    }
    return nullptr;
  }

  void add_findings(TorqueVerdict* out) {
    std::set<int> with_drives, any_drives;
    for (const GradedTerm& g : graded_) {
      if (g.helps_held && g.gain > 0.0) add_to_model(g, &out->model);
      if (g.named && g.term.row->is_of_bus()) {
        add_bus_delay(g, out);
        continue;
      }
      if (!g.named) {
        out->evidence.not_identifiable.push_back(make_detail(e_, g));
        continue;
      }
      if (g.term.row->excess) continue;  // reported with its level
      const GradedTerm* excess = g.term.row->level ? find_excess(g) : nullptr;
      std::vector<Alternative> alternatives = list_indistinguishable(*design_.data, g, excess, find_level(g));
      if (const GradedTerm* gear = find_gear(design_, g, &graded_))
        alternatives.insert(alternatives.begin(), make_gear_alternative(*design_.data, g, *gear));
      out->evidence.findings.push_back(make_finding(e_, g, excess, alternatives));
      const bool of_drive = g.term.row->of_motor_and_gear;
      if (of_drive) any_drives.insert(g.place.joint);
      if (of_drive && g.grade == Grade::kSupported) {
        with_drives.insert(g.place.joint);
        ++out->drive_terms;
      }
    }
    out->with_drives = static_cast<int>(with_drives.size());
    out->any_drives = static_cast<int>(any_drives.size());
  }

  // Joints with fewer samples in motion than any model takes.
  void add_resting(TorqueVerdict* out) const {
    for (int j = 0; j < e_.num_joints(); ++j) {
      const auto is_its = [&](const JointDesign& joint) { return joint.joint == j; };
      if (!design_.data->is_judged(j) || std::any_of(design_.joints.begin(), design_.joints.end(), is_its)) continue;
      const JointSpec& joint = e_.robot.tree.joint(j);
      out->evidence.not_identifiable.push_back(
          {get_effect(joint.actuated ? EffectId::kRotorInertia : EffectId::kViscous).name,
           {{"joint", joint.name}},
           "the joint hardly moves: this motion cannot tell its friction and its inertia",
           kReversals});
    }
  }

  void add_possible(TorqueVerdict* out) const {
    for (const GradedTerm& g : list_possible_terms(design_, choice_, graded_, jobs_))
      out->evidence.findings.push_back(
          make_finding(e_, g, nullptr, list_indistinguishable(*design_.data, g, nullptr, find_level(g))));
  }

  // The servo's own law determines this delay, whatever else acts on the joint.
  void add_delay(const ServoDelay& d, TorqueVerdict* out) const {
    const std::string unit = " " + get_joint_unit(e_.robot.tree.joint(d.joint), "N m");
    Finding f = make_finding(get_effect(EffectId::kDelay), {{"joint", e_.robot.tree.joint(d.joint).name}},
                             {make_one("delay", "s", d.delay, d.std)});
    f.grade = Grade::kSupported;
    f.probability = kSurest;
    f.share = f.weight = std::clamp(1.0 - d.after * d.after / std::max(1e-300, d.before * d.before), 0.0, 1.0);
    f.statement = e_.robot.tree.joint(d.joint).name + ": commands arrive " + number(1e3 * d.delay, 3) +
                  " ms late (supported). With that delay the servo's law misses the recorded effort by " +
                  number(d.after, 3) + unit + " (root mean square, held out) instead of " + number(d.before, 3) + unit +
                  ".";
    out->evidence.findings.push_back(std::move(f));
    out->model.push_back({EffectId::kDelay, d.joint, {d.delay}});
  }

  // Differences between an effort log and the servo's law. Faults below 5 % of the residual correct the model but are
  // not reported.
  void add_log(int joint, TorqueVerdict* out) const {
    const ServoReading& log = design_.data->servo[static_cast<size_t>(joint)];
    for (Finding& f : make_log_findings(e_, joint, log)) {
      if (f.share > kMinor) out->evidence.findings.push_back(std::move(f));
    }
    const Place reading = at_sensor(joint, Reading::kEffort);
    if (log.is_scaled()) out->model.push_back({EffectId::kSensorScale, reading, {log.scale}});
    if (log.is_biased()) out->model.push_back({EffectId::kSensorBias, reading, {log.bias}});
  }

  // Faults of a joint's position or velocity column, from the comparison of the two.
  void add_velocity(int joint, TorqueVerdict* out) const {
    const VelocityReading& log = design_.data->velocity[static_cast<size_t>(joint)];
    for (Finding& f : make_velocity_findings(e_, joint, design_.data->velocity))
      out->evidence.findings.push_back(std::move(f));
    if (log.is_scaled())
      out->model.push_back({EffectId::kSensorScale, at_sensor(joint, Reading::kVelocity), {log.scale}});
    if (log.is_biased())
      out->model.push_back({EffectId::kSensorBias, at_sensor(joint, Reading::kVelocity), {log.bias}});
    if (log.late == 0.0) return;
    const Reading late = log.is_late() ? Reading::kVelocity : Reading::kPosition;
    out->model.push_back({EffectId::kSensorDelay, at_sensor(joint, late), {std::abs(log.late)}});
  }

  void add_to_model(const GradedTerm& g, Hypothesis* model) const {
    if (g.term.row->excess) return;  // its level contains it
    const GradedTerm* excess = g.term.row->level ? find_excess(g) : nullptr;
    const std::optional<Effect> effect = make_effect(g, excess);
    if (!effect) return;
    if (!g.term.row->is_of_bus())
      model->push_back(*effect);
    else
      for (int joint : list_servo_joints()) model->push_back({effect->id, joint, effect->p});
  }

  std::vector<int> list_servo_joints() const {
    std::vector<int> list;
    for (const JointDesign& joint : design_.joints) {
      if (design_.data->source[static_cast<size_t>(joint.joint)] == EffortSource::kServoLaw)
        list.push_back(joint.joint);
    }
    return list;
  }

  // Reports a bus delay as one finding per joint, with its share at that joint.
  void add_bus_delay(const GradedTerm& g, TorqueVerdict* out) const {
    const std::vector<int> servo = list_servo_joints();
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      if (!has(servo, design_.joints[i].joint)) continue;
      GradedTerm own = g;
      own.term.place = design_.joints[i].joint;
      own.share = g.joint_share[i];
      own.weight = g.joint_weight[i];
      out->evidence.findings.push_back(make_finding(e_, own, nullptr, {}));
    }
  }

  // Missing torque of a joint that the model leaves, by recording, for samples in use.
  std::vector<Observed> observe(size_t i, bool train, FreeData* free) const {
    std::vector<Observed> list;
    const JointDesign& joint = design_.joints[i];
    const int j = joint.joint;
    std::vector<Eigen::VectorXd> rows;
    std::vector<double> missing;
    for (const TorqueRecording& r : design_.data->recordings) {
      if (r.train != train) continue;
      const Eigen::VectorXd predicted = calc_prediction(i, r), direction = design_.data->calc_direction(r, j);
      Observed o;
      o.x.resize(5);
      for (long k = 0; k < r.kept(); ++k) {
        if (!r.use(k, j)) continue;
        const long row = r.full_row(k);
        const double values[] = {r.q(row, j), r.v(row, j), direction[k], r.tau(row, j), r.time(k)};
        for (size_t c = 0; c < 5; ++c) o.x[c].push_back(values[c]);
        o.time.push_back(r.time(k));
        o.y.push_back(r.missing(k, j) - predicted[k]);
        rows.push_back((Eigen::VectorXd(6) << r.q(row, j), r.v(row, j), direction[k], r.a(row, j), r.tau(row, j),
                        std::abs(r.tau(row, j)) * direction[k])
                           .finished());
        missing.push_back(r.missing(k, j));
        free->fold.push_back(static_cast<int>(list.size() * 4 + static_cast<size_t>(4 * k / std::max(1L, r.kept()))));
      }
      if (!o.y.empty()) list.push_back(o);
    }
    free->x.resize(static_cast<long>(rows.size()), 6);
    for (size_t k = 0; k < rows.size(); ++k) free->x.row(static_cast<long>(k)) = rows[k];
    free->y = Eigen::Map<const Eigen::VectorXd>(missing.data(), static_cast<long>(missing.size()));
    return list;
  }

  Eigen::VectorXd calc_prediction(size_t i, const TorqueRecording& r) const {
    return list_law_columns(design_, choice_.model, i, r) * list_values(i);
  }

  // Coefficients of the model's columns in a joint's rows.
  Eigen::VectorXd list_values(size_t i) const {
    const Slots slots = list_slots(design_, choice_.model);
    std::vector<double> values;
    const auto add = [&](long slot, long count) {
      for (long c = 0; c < count; ++c) values.push_back(choice_.fit.theta[slot + c]);
    };
    for (size_t t = 0; t < choice_.model.own[i].size(); ++t)
      add(slots.own[i][t], design_.joints[i].terms[choice_.model.own[i][t]].columns());
    for (size_t t = 0; t < choice_.model.whole.size(); ++t)
      add(slots.whole[t], design_.whole[choice_.model.whole[t]].columns());
    return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<long>(values.size()));
  }

  // The missing torque follows the motion much more closely than the laws that were found. They may stand in for
  // another law, so the joint's findings become ambiguous.
  static void doubt_law(const Where& where, const std::string& why, TorqueVerdict* out) {
    for (Finding& f : out->evidence.findings) {
      if (f.where != where || f.grade != Grade::kSupported) continue;
      make_ambiguous(&f);
      f.statement += " " + why;
    }
  }

  // The effort of such a drive is not the torque of its joint: what was weighed by it most is not told.
  void doubt_carried(int joint, const CoupledDrives& coupled, TorqueVerdict* out) const {
    for (const GradedTerm& g : graded_) {
      if (g.term.row->place != PlaceKind::kLink || g.joint_share.empty()) continue;
      const auto most = std::max_element(g.joint_share.begin(), g.joint_share.end()) - g.joint_share.begin();
      const int judge = design_.joints[static_cast<size_t>(most)].joint;
      const auto is_judge = [&](const CoupledDrive& d) { return d.other == judge; };
      if (judge != joint && std::none_of(coupled.drives.begin(), coupled.drives.end(), is_judge)) continue;
      doubt_law({{"link", e_.robot.tree.links[static_cast<size_t>(g.term.place)].name}},
                "A drive turns with two joints that carry it, so their efforts are not the torques that they bear.",
                out);
    }
  }

  CoupledDrives find_coupled(size_t i) const {
    return find_coupled_drives(*design_.data, list_laws(design_, choice_.model, i));
  }

  // What is left at a joint, and what it depends on.
  struct Rest {
    Remaining remaining;
    CoupledDrives coupled;
    double free = 0.0;  // share of the squares that a model without physics takes away
  };

  // Says what the rest depends on. A smaller missing torque gets no analysis of what it depends on.
  void describe_rest(size_t i, const std::vector<Observed>& train, const std::vector<Observed>& held,
                     Rest* rest) const {
    static const std::vector<Regressor> quantities{{"position", "its position", "rad"},
                                                   {"velocity", "its velocity", "rad/s"},
                                                   {"direction", "the direction of its motion", ""},
                                                   {"load", "the effort that its motion takes", "N m"},
                                                   {"time", "time", "s"}};
    const JointDesign& joint = design_.joints[i];
    Remaining& r = rest->remaining;
    std::string words;
    if (r.after > kKnown * joint.spread && !held.empty()) {
      rest->coupled = find_coupled(i);
      if (rest->coupled.drives.empty()) {
        const Relation relation = find_relation(quantities, train, held);
        r.depends_on = relation.names;
        words = relation.words;
      } else {
        r.depends_on = {"other joint"};
        words = make_coupled_words(e_, joint.joint, rest->coupled);
      }
    }
    r.statement = make_remaining_words(e_, joint.joint, r, words);
  }

  Rest find_rest(size_t i) const {
    const JointDesign& joint = design_.joints[i];
    FreeData learn, test;
    const std::vector<Observed> train = observe(i, true, &learn), held = observe(i, !design_.has_held, &test);
    Rest rest;
    Remaining& r = rest.remaining;
    r.where = {{"joint", e_.robot.tree.joint(joint.joint).name}};
    r.unit = get_joint_unit(e_.robot.tree.joint(joint.joint), "N m");
    r.before = std::sqrt(calc_nominal_held(joint));
    r.after = std::sqrt(choice_.fit.held[i]);
    describe_rest(i, train, held, &rest);
    rest.free = std::max(find_free_share(learn, test),
                         rest.coupled.drives.empty() ? 0.0 : 1.0 - rest.coupled.left / (r.before * r.before));
    return rest;
  }

  // What a drive takes that turns with two joints looks like a law of either.
  void doubt_coupled(int joint, const Rest& rest, TorqueVerdict* out) const {
    if (rest.coupled.drives.empty()) return;
    const std::string why =
        "What remains follows the friction of a drive that turns with two joints, so this may be a part of it.";
    doubt_law(rest.remaining.where, why, out);
    // Its power acts at both, also where the other joint moves so much like it that nothing shows there.
    for (const CoupledDrive& d : rest.coupled.drives)
      doubt_law({{"joint", e_.robot.tree.joint(d.other).name}}, why, out);
    doubt_carried(joint, rest.coupled, out);
  }

  void add_remaining(TorqueVerdict* out) const {
    double before = 0.0, after = 0.0, reachable = 0.0;
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      const JointDesign& joint = design_.joints[i];
      Rest rest = find_rest(i);
      Remaining& r = rest.remaining;
      doubt_coupled(joint.joint, rest, out);
      if (const std::string why = find_other_damping(design_, choice_.model, i); !why.empty()) {
        r.statement += " " + why;
        doubt_law(r.where, why, out);
      }
      const double scale = joint.weigh_squares(), own = r.before > 0.0 ? 1.0 - r.share() : 0.0;
      before += r.before * r.before * scale;
      after += r.after * r.after * scale;
      // A free model that predicts less than half of what the laws do has failed. Where the rest follows the motion all
      // the same, more than the laws can be predicted.
      const bool more = rest.free < kHalf * own && !r.depends_on.empty();
      reachable += r.before * r.before * scale * (more ? 1.0 : std::max(own, rest.free));
      // A supported law must explain this share of what a model without physics predicts.
      if (own < kLargely * rest.free)
        doubt_law(r.where, "What remains follows the motion closely, so another law may be the true one.", out);
      // Little of its effort is missing, and little of that any model predicts: with enough independent samples to
      // learn from. A joint without a drive may turn freely.
      const bool driven = e_.robot.tree.joint(joint.joint).actuated;
      if (driven && r.before < kDetail * joint.spread && std::max(own, rest.free) < kMinority &&
          joint.effective >= kRowsPerColumn)
        ++out->exact;
      out->torque.push_back({e_.signal_name(joint.joint, Quantity::kEffort), r.unit, r.before, r.after, joint.spread});
      out->evidence.remaining.push_back(std::move(r));
    }
    out->evidence.explained = before > 0.0 ? std::max(0.0, 1.0 - after / before) : 0.0;
    out->evidence.ceiling = before > 0.0 ? std::clamp(reachable / before, 0.0, 1.0) : 0.0;
  }

  const Experiment& e_;
  const int jobs_;
  TorqueDesign design_;
  Choice choice_;
  std::vector<GradedTerm> graded_;
};

}  // namespace

bool may_have_real_drives(const TorqueVerdict& torque) {
  return torque.judged && torque.exact <= (1.0 - kEveryDrive) * torque.joints;
}

bool has_real_drives(const TorqueVerdict& torque) {
  constexpr auto few = static_cast<int>(kLargestSet);
  if (!torque.judged) return false;
  if (torque.drive_terms > few && torque.with_drives >= kEveryDrive * torque.joints) return true;
  // Of fewer joints it may be the single effect of a clean world.
  if (torque.joints < static_cast<int>(kFewestToAgree) || torque.any_drives < kEveryDrive * torque.joints) return false;
  // Of many joints some may hardly move: what little they miss is noise, on real robots too.
  return torque.exact == 0 ? torque.with_drives > 0 : torque.with_drives > few && may_have_real_drives(torque);
}

TorqueVerdict judge_torque(const Experiment& experiment, int jobs) {
  return judge_torque(make_torque_data(experiment), jobs);
}

TorqueVerdict judge_torque(TorqueData&& data, int jobs) {
  const Experiment& experiment = *data.experiment;
  TorqueVerdict nothing;
  nothing.evidence.missing = data.missing;
  if (data.recordings.empty()) return nothing;
  TorqueDesign design = make_torque_design(std::move(data));
  if (design.joints.empty()) return nothing;
  return Judge(experiment, std::move(design), jobs).run();
}

}  // namespace hrp::diagnosis
