// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/diagnose.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>

#include "diagnosis/findings/families.h"
#include "diagnosis/measurement/floating/body_motion.h"
#include "diagnosis/measurement/floating/candidate_laws.h"
#include "diagnosis/measurement/floating/checks.h"
#include "diagnosis/measurement/floating/correct_log.h"
#include "diagnosis/measurement/floating/equations/equations.h"
#include "diagnosis/measurement/floating/imu_rows.h"
#include "diagnosis/measurement/floating/joint_turns.h"
#include "diagnosis/measurement/floating/landings.h"
#include "diagnosis/measurement/floating/load_share.h"
#include "diagnosis/measurement/floating/remaining.h"
#include "diagnosis/measurement/floating/search/search.h"
#include "diagnosis/measurement/floating/servo_fit.h"
#include "diagnosis/measurement/floating/words.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kReach = 1.0;       // [m] of a load from its link's origin
constexpr double kToNoise = 3.0;     // times noise and exactness: what is left of all equations together, to be called explained
// What takes away less than both explains nothing: of the whole nominal error, and of an equation's mismatch.
constexpr double kRemains = 0.9, kMain = 0.3;
// With so little explained of all equations, and so much of the held-out error left, another cause may pass for what was found.
constexpr double kLittle = 0.25, kMuchLeft = 0.8;
constexpr double kAlone = 0.8;  // share of an equation's mismatch that a cause takes which nothing else is behind
constexpr double kTurning = 0.5;  // of a gyroscope's spread: feet that turn so much do not stand
constexpr int kRounds = 3;           // of equations about what was found: each leaves a hundredth of the last one's error
constexpr double kSettled = 0.01;    // share by which corrections may still change
constexpr const char* kBends = "link_bending";  // an alternative that the table of effects does not hold
constexpr size_t kTrace = 500;       // points of a curve

std::string describe(const std::vector<Estimate>& parameters) {
  std::string out;
  for (const Estimate& e : parameters) {
    out += (out.empty() ? "" : ", ") + e.name + " ";
    for (size_t i = 0; i < e.value.size(); ++i) out += (i ? ", " : "") + format("%.4g +- %.2g", e.value[i], 1.96 * e.std[i]);
    if (e.unit != "1") out += " " + e.unit;
  }
  return out;
}

std::string get_place(const Where& where) {
  return where.empty() ? std::string("the robot") : where.begin().value().get<std::string>();
}

class Reporter {
 public:
  Reporter(const LeggedLog& log, const Contacts& contacts, const LeggedFitter& fitter, const LeggedOutcome& outcome, const std::vector<SoleLaw>& soles)
      : log_(log), contacts_(contacts), fitter_(fitter), o_(outcome), soles_(soles), model_(fitter.fit(list_stated(outcome.chosen))) {}

  Evidence run(const CheckResult& checks) {
    out_.method =
        "equations of motion along the recorded motion, with every signal that was recorded; means of 40 ms, products "
        "of even with odd samples";
    out_.missing = log_.missing;
    out_.warnings = log_.notes;
    out_.warnings.insert(out_.warnings.end(), checks.notes.begin(), checks.notes.end());
    for (const FoundEffect& f : o_.effects) {
      if (f.effect.is_listed()) out_.findings.push_back(make_finding(f));
    }
    join_rotors();
    add_checks(checks);
    sort_findings(&out_.findings);
    add_fit(checks.units);
    if (leaves_most() || has_free_law()) doubt_findings();
    add_remaining();
    add_mismatch();
    out_.verdict = find_verdict();
    if (out_.verdict != Verdict::kNoMismatch) out_.remaining.insert(out_.remaining.end(), checks.remaining.begin(), checks.remaining.end());
    if (out_.findings.empty()) out_.summary = make_summary();
    return std::move(out_);
  }

 private:
  // What a scenario can hold.
  static std::vector<Candidate> list_stated(const LeggedFit& fit) {
    std::vector<Candidate> out;
    std::copy_if(fit.effects.begin(), fit.effects.end(), std::back_inserter(out), [](const Candidate& c) { return c.is_listed(); });
    return out;
  }

  bool has_free_law() const {
    return std::any_of(o_.effects.begin(), o_.effects.end(), [](const FoundEffect& f) { return !f.effect.is_listed(); });
  }

  // Of each free law its place, its size and what it takes away.
  void add_unlisted() {
    for (const FoundEffect& f : o_.effects) {
      if (f.effect.is_listed()) continue;
      Remaining r;
      const ChannelInfo& info = fitter_.channels()[f.channel].info;
      r.where = f.effect.where, r.unit = info.unit;
      r.before = r.after = std::sqrt(get(model_, f.channel));
      r.statement = get_place(r.where) + ": " + f.effect.law->unlisted + " (" + describe(make_estimates(f.effect, f.x, f.std)) + "). It takes " +
                    format("%.0f %% of the held-out mismatch of the equation '", 100 * f.share) + info.kind + "' away. No scenario can hold it.";
      out_.remaining.push_back(std::move(r));
    }
  }

  size_t count() const { return fitter_.channels().size(); }
  double get(const LeggedFit& fit, size_t c) const { return get_mean_square(fitter_, fit, c); }

  Finding make_finding(const FoundEffect& f) const {
    std::vector<Estimate> parameters = make_estimates(f.effect, f.x, f.std);
    const SoleLaw law = find_sole_law(f.effect);
    const bool lands = put_law(law, &parameters);
    Finding out = floating::make_finding(f.effect.effect, f.effect.where, parameters);
    out.share = f.share, out.probability = std::min(0.99, 1 - 1 / (1 + std::max(0.0, f.gain)));
    out.weight = std::max(0.0, f.gain) / std::max(1.0, fitter_.calc_gain(Part::kHeld, o_.nominal, o_.chosen) + fitter_.calc_gain(Part::kTrain, o_.nominal, o_.chosen));
    for (const Rival& r : f.rivals) {
      out.alternatives.push_back(make_alternative(r.effect.effect, r.effect.where, make_estimates(r.effect, r.x, r.std),
                                                  "wider and faster motion of the joints around it, loaded and unloaded"));
    }
    out.grade = f.rivals.empty() ? Grade::kSupported : Grade::kAmbiguous;
    out.statement = get_place(out.where) + ": " + get_effect(f.effect.effect).phrase + " (" + describe(out.parameters) + "). It takes " +
                    format("%.0f %% of the held-out mismatch of the equation '", 100 * f.share) + fitter_.channels()[f.channel].info.kind +
                    "' away.";
    if (lands) out.statement += format(" How it gives in height is from %.0f landings.", static_cast<double>(law.landings));
    if (f.sums_up) add_other_zeros(f.effect.place, &out);
    if (f.effect.effect == EffectId::kGroundSlope) add_zeros_for_slope(&out);
    if (f.effect.effect == EffectId::kJointOffset) add_slope_for_zero(f.effect.place, &out);
    add_bending_links(&out);
    add_load_at_centre(log_, &out);
    add_give_for_lean(fitter_.channels()[f.channel].info, &out);
    add_give_for_rate(fitter_.channels()[f.channel].info, &out);
    if (!out.alternatives.empty()) {
      out.statement += " As well explained by ";
      for (size_t i = 0; i < out.alternatives.size() && i < 3; ++i) {
        out.statement += (i ? ", or " : "") + out.alternatives[i].effect + " at " + get_place(out.alternatives[i].where);
      }
      out.statement += ".";
    }
    return out;
  }

  SoleLaw find_sole_law(const Candidate& effect) const {
    const auto foot = static_cast<size_t>(std::max(0, effect.place));
    return effect.effect == EffectId::kFootCompliance && effect.place >= 0 && foot < soles_.size() ? soles_[foot] : SoleLaw{};
  }

  // A link beside an elastic joint that bends about the same axis moves all that follows alike: no sensor of these sets
  // tells where it gives. No scenario holds it, so it is never the finding itself.
  void add_bending_links(Finding* f) const {
    const std::string elastic = get_effect(EffectId::kElasticity).name;
    const auto as_alternative = std::find_if(f->alternatives.begin(), f->alternatives.end(), [&](const Alternative& a) { return a.effect == elastic; });
    if (f->effect != elastic && as_alternative == f->alternatives.end()) return;
    const Where& joint = f->effect == elastic ? f->where : as_alternative->where;
    const std::vector<Estimate> stiffness = f->effect == elastic ? f->parameters : as_alternative->parameters;
    const int child = log_.tree.find_joint(get_place(joint)) + 1;
    if (child < 1) return;  // listed for the whole robot, as for a gyroscope
    for (const int link : {log_.tree.links[static_cast<size_t>(child)].parent, child}) {
      f->alternatives.push_back({kBends, get_family_name(EffectFamily::kPlay), {{"link", log_.tree.links[static_cast<size_t>(link)].name}}, stiffness,
                                 "markers of motion capture on the link"});
    }
    f->grade = Grade::kAmbiguous;
  }

  // Where a transmission gives or has play, the rotor before it is one of its parameters: one cause, not two.
  void join_rotors() {
    for (Finding& play : out_.findings) {
      const EffectInfo* row = find_effect(play.effect);
      if (!row || row->rotor < 0 || !row->flexible) continue;
      const auto rotor = std::find_if(out_.findings.begin(), out_.findings.end(), [&](const Finding& f) {
        return is_effect(f.effect, EffectId::kRotorInertia) && f.where == play.where;
      });
      if (rotor == out_.findings.end()) continue;
      play.parameters.push_back(rotor->parameters[0]), play.parameters.back().name = row->parameters[static_cast<size_t>(row->rotor)].name;
      play.weight += rotor->weight;
      play.statement += " The rotor before it: " + describe(rotor->parameters) + ".";
      out_.findings.erase(rotor);
      return join_rotors();
    }
  }

  // A zero or a slope that only the tilt of a foot tells: without the foot's moment, a sole that gives under a moment that
  // hardly changes leans as well, and so does an IMU that is screwed on askew.
  void add_give_for_lean(const ChannelInfo& told_by, Finding* lean) const {
    const bool leans = is_effect(lean->effect, EffectId::kJointOffset) || is_effect(lean->effect, EffectId::kGroundSlope);
    if (!leans || told_by.place != "foot") return;
    const auto foot = std::find_if(log_.feet.begin(), log_.feet.end(), [&](const Foot& f) { return f.name == told_by.name; });
    if (foot == log_.feet.end() || (foot->sensor >= 0 && log_.sensors[static_cast<size_t>(foot->sensor)].has_wrench())) return;
    add_alternative(EffectId::kFootCompliance, {{"foot", foot->name}}, "the foot's moment, recorded", lean);
    add_misaligned_imu("the body leaned to known angles", lean);
  }

  // Of the IMU that the base's attitude comes from.
  void add_misaligned_imu(const char* motion, Finding* f) const {
    const int imu = BodyMotion::find_main_imu(log_);
    if (imu >= 0) add_alternative(EffectId::kSensorMisalignment, {{"sensor", "/imu/" + log_.imus[static_cast<size_t>(imu)].name}}, motion, f);
  }

  static void add_alternative(EffectId effect, const Where& where, const char* motion, Finding* f) {
    const std::string name = get_effect(effect).name;
    const bool there = std::any_of(f->alternatives.begin(), f->alternatives.end(), [&](const Alternative& a) { return a.effect == name && a.where == where; });
    if (!there) f->alternatives.push_back(make_alternative(effect, where, {}, motion));
    f->grade = Grade::kAmbiguous;
  }

  // Only the sum of the feet's forces tells it: another foot's zero, that of all, or a mass does the same.
  void add_other_zeros(int sensor, Finding* zero) const {
    constexpr const char* kMotion = "each foot in the air once; the robot on a scale";
    for (size_t s = 0; s < log_.sensors.size(); ++s) {
      if (static_cast<int>(s) != sensor) add_alternative(EffectId::kSensorBias, {{"sensor", "/wrench/" + log_.sensors[s].name + "/force"}}, kMotion, zero);
    }
    add_alternative(EffectId::kSensorBias, {{"sensor", "/wrench"}}, kMotion, zero);
    add_alternative(EffectId::kMassError, {{"link", log_.tree.links[0].name}}, kMotion, zero);
  }

  // Feet that stay in their places see a slope, a misaligned IMU, and zeros of all legs together as the same constant. Only
  // feet that have turned on the ground tell them apart.
  void add_zeros_for_slope(Finding* slope) const {
    if (contacts_.walks) return;
    constexpr const char* kMotion = "the feet set down again after a quarter turn";
    add_misaligned_imu(kMotion, slope);
    for (const Foot& foot : log_.feet) {
      if (foot.flat && foot.link > 0) add_alternative(EffectId::kJointOffset, {{"joint", log_.tree.joint(foot.link - 1).name}}, kMotion, slope);
    }
  }

  // Two feet tell two tilts. Beside a slope, the zero of a joint of one leg is only the difference of the two tilts: the other
  // leg's zero without a slope is the same.
  void add_slope_for_zero(int joint, Finding* zero) const {
    const bool slopes = std::any_of(o_.effects.begin(), o_.effects.end(), [](const FoundEffect& f) { return f.effect.effect == EffectId::kGroundSlope; });
    if (contacts_.walks || !slopes) return;
    for (const Foot& foot : log_.feet) {
      if (foot.flat && foot.link > 0 && !is_above(log_.tree, joint + 1, foot.link)) add_alternative(EffectId::kJointOffset, {{"joint", log_.tree.joint(foot.link - 1).name}}, "the robot on ground that is level", zero);
    }
  }

  // A scale or a turn of a gyroscope that no other sensor of rates or attitudes tells, but encoders or forces: joints that
  // give under what they bear let links turn by more than encoders say, in step with them. A zero or a delay is no such thing.
  void add_give_for_rate(const ChannelInfo& told_by, Finding* turned) const {
    const bool in_step = is_effect(turned->effect, EffectId::kSensorScale) || is_effect(turned->effect, EffectId::kSensorMisalignment);
    const bool direct = told_by.kind.rfind("gyroscope", 0) == 0 && told_by.kind.rfind(kOverFeet, 0) != 0;
    if (!in_step || direct || turned->where.dump().find("angular_velocity") == std::string::npos) return;
    add_alternative(EffectId::kElasticity, {{"link", log_.tree.links[0].name}}, "the same motion, recorded by motion capture or an attitude", turned);
  }

  // A link that is too heavy, and a load where its mass is, are one in the balance of forces.
  static void add_load_at_centre(const LeggedLog& log, Finding* heavy) {
    if (!is_effect(heavy->effect, EffectId::kMassError) || heavy->grade != Grade::kAmbiguous || heavy->parameters[0].value[0] <= 1) return;
    const bool there = std::any_of(heavy->alternatives.begin(), heavy->alternatives.end(),
                                   [&](const Alternative& a) { return is_effect(a.effect, EffectId::kPayload) && a.where == heavy->where; });
    const auto link = std::find_if(log.tree.links.begin(), log.tree.links.end(), [&](const LinkSpec& l) { return get_place(heavy->where) == l.name; });
    if (there || link == log.tree.links.end()) return;
    const double m = link->inertia.mass, more = heavy->parameters[0].value[0] - 1, std = heavy->parameters[0].std[0];
    const Vector3d c = link->inertia.p_LLcm_L;
    const Estimate mass{"mass", "kg", {more * m}, {std * m}, false}, com{"com", "m", {c.x(), c.y(), c.z()}, {1, 1, 1}, true};
    heavy->alternatives.insert(heavy->alternatives.begin(),
                               make_alternative(EffectId::kPayload, heavy->where, {mass, com}, "turns of the body: a load hangs at one point"));
  }

  // Whether an accelerometer's bias makes at least half of what the feet carry too much or too little.
  bool holds_weight(const Finding& bias, const Finding& weight) const {
    if (!is_effect(bias.effect, EffectId::kSensorBias) || bias.where.dump().find("linear_acceleration") == std::string::npos) return false;
    const auto scale = std::find_if(weight.alternatives.begin(), weight.alternatives.end(), [](const Alternative& a) { return is_effect(a.effect, EffectId::kSensorScale); });
    if (scale == weight.alternatives.end()) return false;
    double square = 0;
    for (double v : bias.parameters[0].value) square += v * v;
    const double g = log_.experiment->scenario.gravity_W.norm();
    return std::sqrt(square) / g > 0.5 * std::abs(scale->parameters[0].value[0] - 1);
  }

  // What whole recordings say, where the equations have not named it already.
  void add_checks(const CheckResult& checks) {
    for (const Finding& f : checks.findings) {
      const bool known = std::any_of(out_.findings.begin(), out_.findings.end(), [&](const Finding& g) {
        if (g.effect == f.effect && g.where == f.where) return true;
        const bool of_weight = f.family == get_family_name(EffectFamily::kMass);
        const bool weighs = of_weight && (g.family == f.family || g.where.dump().find("/wrench") != std::string::npos ||
                                                           (is_effect(g.effect, EffectId::kSensorScale) && g.where.dump().find("linear_acceleration") != std::string::npos));
        if (of_weight && holds_weight(g, f)) return true;
        // Soles that give sink by what they carry: that is no slope.
        const bool slopes = is_effect(f.effect, EffectId::kGroundSlope) && (g.effect == f.effect || is_effect(g.effect, EffectId::kFootCompliance));
        const bool senses = f.where.contains("sensor") && f.where == g.where;
        return weighs || slopes || (senses && !checks.raw_counts);
      });
      if (known) continue;
      out_.findings.push_back(f);
      if (!checks.weight.empty() && f.family == get_family_name(EffectFamily::kMass)) add_weight(checks.weight[0], &out_.findings.back());
    }
  }

  // What the feet carry too much is one number: the fit says what it takes away, whatever its cause.
  void add_weight(const Candidate& mass, Finding* finding) {
    std::vector<Candidate> effects = model_.effects;
    effects.push_back(mass);
    const LeggedFit with = fitter_.fit(effects);
    size_t best = 0;
    for (size_t c = 0; c < count(); ++c) {
      if (get(o_.nominal, c) / fitter_.floor(c) - get(with, c) / fitter_.floor(c) > get(o_.nominal, best) / fitter_.floor(best) - get(with, best) / fitter_.floor(best)) best = c;
    }
    if (!with.x.allFinite() || get(with, best) >= get(o_.chosen, best)) return;
    finding->share = std::clamp(1 - get(with, best) / get(o_.chosen, best), 0.0, 1.0);
    model_ = with;
  }

  // Noise deviations of an equation, squared, before and after.
  void add_fit(const UnitFit& units) {
    double sum[2][2] = {{0, 0}, {0, 0}}, rows[2] = {0, 0}, before = 0, after = 0, could = 0;
    for (size_t c = 0; c < count(); ++c) {
      for (int p = 0; p < 2; ++p) {
        const auto n = static_cast<double>(fitter_.count(p ? Part::kHeld : Part::kTrain, c));
        sum[p][0] += n * (1 + o_.nominal.mean_square[p][c] / fitter_.floor(c));
        sum[p][1] += n * (1 + model_.mean_square[p][c] / fitter_.floor(c)), rows[p] += n;
      }
      const double x = get(o_.nominal, c) / fitter_.floor(c), y = get(model_, c) / fitter_.floor(c);
      if (fitter_.channels()[c].rows() == 0) continue;
      before += std::log1p(x), after += std::log1p(y);
      could += std::log1p(x) - std::log1p(x * (1 - std::max(fitter_.calc_ceiling(c), x > 0 ? 1 - y / x : 0)));
      add_signal(c);
    }
    if (!units.signal.empty()) {
      const int part = units.rows[1] > 0 ? 1 : 0;
      for (int p = 0; p < 2; ++p) {
        sum[p][0] += units.rows[p] * (1 + units.before[p] / units.exact), sum[p][1] += units.rows[p] * (1 + units.after[p] / units.exact), rows[p] += units.rows[p];
      }
      const double gone = std::log1p(units.before[part] / units.exact) - std::log1p(units.after[part] / units.exact);
      before += std::log1p(units.before[part] / units.exact), after += std::log1p(units.after[part] / units.exact), could += gone;
      out_.fit.signals.push_back({units.signal, "N", std::sqrt(units.before[part]), std::sqrt(units.after[part]), 0});
    }
    const auto rms = [](double s, double n) { return n > 0 ? std::sqrt(s / n) : 0; };
    out_.fit.train_before = rms(sum[0][0], rows[0]), out_.fit.train_after = rms(sum[0][1], rows[0]);
    out_.fit.validate_before = rms(sum[1][0], rows[1]), out_.fit.validate_after = rms(sum[1][1], rows[1]);
    out_.explained = before > 0 ? std::clamp((before - after) / before, 0.0, 1.0) : 0;
    out_.ceiling = before > 0 ? std::clamp(could / before, 0.0, 1.0) : 0;
  }

  void add_signal(size_t c) {
    const ChannelInfo& info = fitter_.channels()[c].info;
    SignalFit s{info.signal + " (" + info.kind + ")", info.unit, std::sqrt(get(o_.nominal, c)), std::sqrt(get(model_, c)), fitter_.channels()[c].scale};
    out_.fit.signals.push_back(s);
  }

  // Where a verdict without findings stands on effects that were not of one size, the report says where they were.
  void add_remaining() {
    std::vector<size_t> unsteady;
    if (out_.findings.empty()) unsteady = list_unsteady();
    add_unlisted();
    for (Remaining& r : list_remaining(fitter_, o_.nominal, has_free_law() ? o_.chosen : model_, unsteady)) out_.remaining.push_back(std::move(r));
  }

  std::vector<size_t> list_unsteady() const {
    std::vector<size_t> out;
    std::copy_if(o_.unsteady.begin(), o_.unsteady.end(), std::back_inserter(out), [this](size_t c) {
      const bool gone = has_free_law() && get(o_.chosen, c) < kRemains * kRemains * get(o_.nominal, c);
      return !gone && !is_of_soles(fitter_.channels()[c].info);
    });
    return out;
  }

  void add_mismatch() {
    for (size_t c = 0; c < count(); ++c) {
      if (fitter_.channels()[c].rows() == 0) continue;
      const double score = std::sqrt(get(o_.nominal, c) / fitter_.floor(c));
      const bool told = is_left(fitter_, o_.nominal, c) || get(model_, c) < 0.7 * get(o_.nominal, c);
      if (score < 1 || !told) continue;
      add_intervals(c, score);
    }
    std::stable_sort(out_.mismatch.begin(), out_.mismatch.end(), [](const Mismatch& a, const Mismatch& b) { return a.score > b.score; });
    if (out_.mismatch.size() > 24) out_.mismatch.resize(24);
  }

  void add_intervals(size_t c, double score) {
    const ChannelRows& rows = fitter_.channels()[c];
    const double limit = 2 * std::sqrt(get(o_.nominal, c) + fitter_.floor(c));
    std::map<int, Mismatch> found;
    std::map<int, std::map<int, int>> phases;
    for (size_t i = 0; i < rows.rows(); ++i) {
      if (std::abs(rows.y[i]) < limit) continue;
      Mismatch& m = found[rows.recording[i]];
      ++phases[rows.recording[i]][rows.phase[i]];
      if (!m.intervals.empty() && rows.time[i] < m.intervals.back().second + 0.15) {
        m.intervals.back().second = rows.time[i];
      } else if (m.intervals.size() < 12) {
        m.intervals.emplace_back(rows.time[i], rows.time[i]);
      }
    }
    for (auto& [r, m] : found) {
      int phase = 0, most = 0;
      for (const auto& [p, n] : phases[r]) {
        if (n > most) most = n, phase = p;
      }
      m.signal = rows.info.signal, m.score = score, m.regime = contacts_.find_phase_name(phase);
      m.recording = log_.experiment->recordings[static_cast<size_t>(r)].spec.name;
      out_.mismatch.push_back(m);
    }
  }

  bool is_anything_left() const {
    for (size_t c = 0; c < count(); ++c) {
      if (fitter_.channels()[c].rows() > 0 && is_left(fitter_, model_, c)) return true;
    }
    return false;
  }

  bool leaves_most() const {
    const double after = out_.fit.validate_after;
    return (is_anything_left() || after > kToNoise) && out_.explained < kLittle && after > kMuchLeft * out_.fit.validate_before;
  }

  void doubt_findings() {
    for (Finding& f : out_.findings) {
      const EffectInfo* row = find_effect(f.effect);
      const bool alone = f.share >= kAlone;  // its own equation is right: what is left elsewhere has a cause of its own
      // Friction and rotors have shapes of their own. A zero has none: the mean of any unknown force is one.
      const bool shaped = row && is_expected(row->id) && row->family != EffectFamily::kZero;
      if (alone || shaped || f.grade == Grade::kAmbiguous) continue;
      f.grade = Grade::kAmbiguous, f.probability = std::min(f.probability, 0.5);
      f.statement += " Most of what stands out is left beside it: another cause may be behind both.";
    }
  }

  Verdict find_verdict() const {
    const bool left = is_anything_left();
    if (out_.findings.empty()) return has_free_law() || left || !list_unsteady().empty() ? Verdict::kUnexplained : Verdict::kNoMismatch;
    if (o_.effects.empty()) return Verdict::kPartlyExplained;
    const bool gone = out_.fit.validate_after < kRemains * out_.fit.validate_before ||
                      std::any_of(out_.findings.begin(), out_.findings.end(), [](const Finding& f) { return f.share > kMain; });
    if (!left && gone && out_.fit.validate_after < kToNoise) return Verdict::kExplained;
    return out_.explained >= 0.8 * out_.ceiling && !leaves_most() ? Verdict::kMostlyExplained : Verdict::kPartlyExplained;
  }

  // Without findings.
  std::string make_summary() const {
    std::string compared;
    for (const ChannelRows& c : fitter_.channels()) {
      const std::string kind = c.info.kind.substr(0, c.info.kind.find_first_of(", "));
      if (c.rows() > 0 && compared.find(kind) == std::string::npos) compared += (compared.empty() ? "" : ", ") + kind;
    }
    return (out_.verdict == Verdict::kNoMismatch ? "Nothing stands out of what could be compared: "
                                                 : "Something is missing that no known effect explains; compared were: ") +
           compared + ".";
  }

  const LeggedLog& log_;
  const Contacts& contacts_;
  const LeggedFitter& fitter_;
  const LeggedOutcome& o_;
  const std::vector<SoleLaw>& soles_;  // by foot, or empty
  LeggedFit model_;  // what was chosen, and a weight that is one number
  Evidence out_;
};

// Curves of the equations that say most: what they lacked, and what is left.
nlohmann::ordered_json make_series(const Experiment& e, const LeggedFitter& fitter, const LeggedOutcome& o, const Evidence& evidence) {
  using Json = nlohmann::ordered_json;
  Json series{{"schema", 1}, {"experiment", e.path}, {"robot", e.robot.tree.name}};
  std::vector<size_t> order;
  for (size_t c = 0; c < fitter.channels().size(); ++c) {
    if (fitter.channels()[c].rows() > 0) order.push_back(c);
  }
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return o.nominal.mean_square[1][a] / fitter.floor(a) > o.nominal.mean_square[1][b] / fitter.floor(b);
  });
  if (order.size() > 6) order.resize(6);
  Json signals = Json::array(), recordings = Json::array();
  for (size_t c : order) {
    const ChannelInfo& info = fitter.channels()[c].info;
    signals.push_back({{"name", info.signal + ": " + info.name + ", " + info.kind}, {"unit", info.unit}, {"noise", std::sqrt(fitter.floor(c))}, {"noise_source", "estimated"}});
  }
  for (size_t r = 0; r < e.recordings.size(); ++r) {
    const Recording& recording = e.recordings[r];
    Json traces = Json::array();
    for (size_t s = 0; s < order.size(); ++s) {
      const ChannelRows& rows = fitter.channels()[order[s]];
      const std::vector<double> left = fitter.calc_residuals(o.chosen, order[s]);
      Json time = Json::array(), recorded = Json::array(), before = Json::array(), after = Json::array();
      const size_t skip = rows.rows() / kTrace + 1;
      for (size_t i = 0; i < rows.rows(); i += skip) {
        if (rows.recording[i] != static_cast<int>(r)) continue;
        time.push_back(rows.time[i]), recorded.push_back(rows.y[i]), before.push_back(0.0), after.push_back(rows.y[i] - left[i]);
      }
      traces.push_back({{"signal", s}, {"time", time}, {"recorded", recorded}, {"before", before}, {"after", after}});
    }
    recordings.push_back({{"file", recording.spec.name}, {"role", recording.spec.train ? "train" : "validate"}, {"start", recording.time.front()}, {"end", recording.time.back()}, {"traces", traces}});
  }
  series["signals"] = signals, series["recordings"] = recordings;
  series["notes"] = e.warnings;
  for (const std::string& text : evidence.warnings) series["notes"].push_back(text);
  for (const std::string& text : evidence.missing) series["notes"].push_back("missing: " + text);
  return series;
}

}  // namespace

namespace {

// Takes all rows out of an equation.
void empty(ChannelRows* c) { *c = ChannelRows{c->info, c->columns, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}, c->mean, c->scale}; }

// Forces in an unknown unit tell nothing of masses and torques.
void drop_forces(std::vector<ChannelRows>* channels) {
  for (ChannelRows& c : *channels) {
    const bool forces = c.info.kind == "weight" || c.info.kind == "joint" || c.info.kind.rfind("balance", 0) == 0;
    if (forces) empty(&c);
  }
}

// Feet that turn half as much as the gyroscope does not stand: they tell nothing of it.
void drop_moving_feet(std::vector<ChannelRows>* channels) {
  for (ChannelRows& c : *channels) {
    if (c.info.kind.rfind(kOverFeet, 0) != 0) continue;
    double square = 0;
    for (double y : c.y) square += y * y;
    if (square > std::pow(kTurning * c.scale, 2) * static_cast<double>(c.rows())) empty(&c);
  }
}

std::vector<ChannelRows> join_halves(const RowTable& even, const RowTable& odd) {
  std::vector<ChannelRows> out = merge_halves(even, odd);
  drop_moving_feet(&out);
  return out;
}

// What the chosen effects say of sensors and drives, by column.
Eigen::VectorXd find_correction(const ColumnLayout& layout, const LeggedFit& fit) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(layout.count());
  long at = 0;
  for (const Candidate& e : fit.effects) {
    for (const Terms& t : e.terms) {
      for (const auto& [column, factor] : t) {
        if (is_correctable(layout, column)) out(column) += factor * fit.x(at);
      }
      ++at;
    }
  }
  return out;
}

// Of soles that were found to give; empty where none was, or where a leg's joint gives, too: then the height of a foot tells
// their sum.
std::vector<SoleLaw> find_sole_laws(const Experiment& e, const ColumnLayout& layout, const Eigen::VectorXd& about, const LeggedOutcome& outcome) {
  std::vector<char> soft(static_cast<size_t>(layout.feet), 0);
  for (const FoundEffect& f : outcome.effects) {
    const EffectId effect = f.effect.effect;
    if (effect == EffectId::kElasticity || effect == EffectId::kBacklash) return {};
    if (effect == EffectId::kFootCompliance && f.effect.place >= 0) soft[static_cast<size_t>(f.effect.place)] = 1;
  }
  if (std::count(soft.begin(), soft.end(), 1) == 0) return {};
  LeggedLog all = make_legged_log(e, Half::kAll);
  correct_log(layout, about, &all);
  return fit_landings(list_landings(all), soft);
}

bool is_same_correction(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  for (long i = 0; i < a.size(); ++i) {
    if (std::abs(a(i) - b(i)) > kSettled * std::max(std::abs(a(i)), std::abs(b(i)))) return false;
  }
  return true;
}

// Equations about the values `about`, by column, with what these effects do added back: the fit gives whole values.
std::vector<ChannelRows> make_channels(LeggedLog even, LeggedLog odd, const Contacts& contacts, const ColumnLayout& layout,
                                       const Eigen::VectorXd& about, bool raw_counts) {
  correct_log(layout, about, &even), correct_log(layout, about, &odd);
  RowTable a = make_equations(even, contacts), b = make_equations(odd, contacts);
  a.add_back(about), b.add_back(about);
  std::vector<ChannelRows> out = join_halves(a, b);
  if (raw_counts) drop_forces(&out);
  return out;
}

}  // namespace

LeggedReport diagnose_legged(const Experiment& e, const std::function<void(const std::string&)>& progress, bool only_walks) {
  LeggedReport out;
  const LeggedLog even = make_legged_log(e, Half::kEven), odd = make_legged_log(e, Half::kOdd);
  const Contacts contacts = find_contacts(even);
  if (only_walks && !contacts.walks) return out;
  const RowTable rows = make_equations(even, contacts), others = make_equations(odd, contacts);
  std::vector<ChannelRows> channels = join_halves(rows, others);
  out.walks = contacts.walks;
  out.judged = std::any_of(channels.begin(), channels.end(), [](const ChannelRows& c) { return c.rows() >= 8; });
  out.evidence.missing = even.missing, out.evidence.warnings = even.notes;
  if (!out.judged) return out;
  const ColumnLayout layout(even);
  CheckResult checks = run_checks(even, contacts, channels, layout);
  if (!checks.raw_counts) {
    for (std::string& note : compare_loads(even)) checks.notes.push_back(std::move(note));
  }
  for (Finding& servo : find_servos(e)) checks.findings.push_back(std::move(servo));
  if (checks.raw_counts) drop_forces(&channels);
  size_t equations = 0;
  for (const ChannelRows& c : channels) equations += c.rows() > 0;
  if (progress) progress("robot on its feet" + std::string(out.walks ? ", walking" : "") + ": " + std::to_string(equations) + " equations");
  const std::vector<Candidate> candidates = list_candidates(even, contacts, layout);
  auto fitter = std::make_unique<LeggedFitter>(std::move(channels), rows.num_columns());
  LeggedOutcome outcome = search_legged(fitter.get(), candidates, layout, kReach, progress);
  Eigen::VectorXd about = Eigen::VectorXd::Zero(layout.count());
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::VectorXd next = find_correction(layout, outcome.chosen);
    if (is_same_correction(about, next)) break;
    about = next;
    if (progress) progress("again, about the faults of sensors that were found");
    fitter = std::make_unique<LeggedFitter>(make_channels(even, odd, contacts, layout, about, checks.raw_counts), rows.num_columns());
    outcome = search_legged(fitter.get(), candidates, layout, kReach, progress);
  }
  const std::vector<SoleLaw> soles = find_sole_laws(e, layout, about, outcome);
  out.evidence = Reporter(even, contacts, *fitter, outcome, soles).run(checks);
  out.series = make_series(e, *fitter, outcome, out.evidence);
  return out;
}

}  // namespace hrp::diagnosis::floating
