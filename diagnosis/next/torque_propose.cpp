// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/torque_propose.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/has.h"
#include "common/base/parallel_for.h"
#include "common/effects/units.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/next/candidate.h"
#include "diagnosis/next/expected_intervals.h"
#include "diagnosis/next/plan_list.h"
#include "diagnosis/next/proposal_parts.h"
#include "diagnosis/next/safety.h"
#include "diagnosis/next/torque_rows.h"
#include "diagnosis/next/torque_worlds.h"

namespace hrp::diagnosis {
namespace {

// Rise of chi2 at which the report no longer lists a rival (kOdds, in nats of likelihood).
constexpr double kNeeded = 2.0 * kOdds;

// `comparisons`: by question; `fault`: of a larger size.
struct TorqueCandidate : MotionCandidate {
  Eigen::MatrixXd fisher;  // about the report's model
  std::vector<ConsideredSums> considered;
};

// A motion with its columns.
struct Played {
  std::unique_ptr<TrialMotion> motion;
  MotionRows rows;
};

class TorqueProposer {
 public:
  TorqueProposer(const Experiment& e, const Json& report, const NextOptions& options, const Progress& progress)
      : e_(e),
        options_(options),
        progress_(progress),
        limits_(make_limits(e, options.limits)),
        terms_(find_open_terms(e, report)),
        bare_(e),
        by_effort_(is_effort_driven(e)) {
    bare_.recordings.clear();
  }

  Next run() {
    if (!terms_.any()) {
      next_.nothing = "No joint's torque could be judged along the recordings.";
      return next_;
    }
    rows_ = std::make_unique<TorqueRows>(terms_);
    describe();
    intervals_ = std::make_unique<ExpectedIntervals>(e_, terms_, *rows_, limits_);
    for (const OpenQuestion& q : terms_.questions) known_rival_.push_back(rows_->calc_known(q.rival));
    if (terms_.questions.empty() && is_settled()) {
      next_.nothing =
          terms_.untold.empty()
              ? "Only one explanation fits the recordings, and its values are known to 2 %: nothing is ambiguous."
              : "What is ambiguous is the same in every motion of this robot, and the values are known to 2 %.";
      return next_;
    }
    try_motions();
    choose();
    for (const TorqueCandidate& c : candidates_) {
      const bool there = has(next_.rejected, c.fault);
      if (!c.fault.empty() && !there) next_.rejected.push_back(c.fault);
    }
    if (next_.proposals.empty()) next_.nothing = "No motion is safe within the limits under every explanation.";
    return next_;
  }

 private:
  void describe() {
    next_.explanations.push_back("the report's model");
    for (const OpenQuestion& q : terms_.questions) next_.explanations.push_back(q.label);
    next_.untold = terms_.untold;
    next_.scale = "times what the report's model leaves";
    next_.remarks = Safety(e_, limits_).remarks();
    const std::string rivals = "the " + std::to_string(kShortList) + " rivals that differ most along it";
    if (!by_effort_) {
      next_.checked =
          "Every motion was simulated before it was proposed: under the nominal model, the report's model, the same "
          "with all values at the lower or "
          "upper ends of their intervals, and " +
          rivals + ". Positions, speeds, efforts and collisions stay within the limits. ";
      return;
    }
    next_.checked =
        "No motion was simulated, because the experiment states no servo gains. Along the motion, positions, speeds, "
        "collisions and expected efforts stay "
        "within the limits: under the nominal model, the report's model, both ends of its intervals, and " +
        rivals + ". ";
    next_.remarks.push_back(
        "Your own controller must follow the positions. The expected efforts of the report's model are in the files. "
        "Nothing tells how far the robot "
        "will be from the motion: set a limit for the position error yourself, and begin with --limit speed=0.2");
  }

  // As in a small model: all values are known to 2 %.
  bool is_settled() const {
    return std::all_of(terms_.values.begin(), terms_.values.end(),
                       [](const OpenValue& v) { return v.half_width <= kKnown * std::abs(v.value); });
  }

  // Fills `readings` of the motion under one model; false if the motion leaves all bounds.
  bool predict(const Played& played, const TorqueWorld& world, std::vector<double>* readings) const {
    if (!by_effort_) return simulate_trial(*played.motion, world.side.hypothesis, readings);
    const Recording& r = played.motion->experiment.recordings[0];
    const size_t n = r.joints.size();
    readings->assign(r.size() * n * kQuantities, 0.0);
    const std::vector<std::vector<double>> efforts = predict_efforts(played.rows, world, r.time);
    for (size_t k = 0; k < r.size(); ++k) {
      for (size_t j = 0; j < n; ++j) {
        double* x = &(*readings)[(k * n + j) * kQuantities];
        x[0] = r.joints[j].command[k];
        x[1] = r.joints[j].command_rate[k];
        x[2] = efforts[j][k];
      }
    }
    return true;
  }

  // Efforts [N m] by joint at these times; the largest ones within the intervals if the world is at an end.
  std::vector<std::vector<double>> predict_efforts(const MotionRows& rows, const TorqueWorld& world,
                                                   const std::vector<double>& time) const {
    std::vector<std::vector<double>> efforts(limits_.joints.size(), std::vector<double>(time.size(), 0.0));
    for (size_t i = 0; i < terms_.design.joints.size(); ++i) {
      Eigen::VectorXd y = rows_->predict(rows, world.side, i);
      if (world.end != 0.0) y += world.end * rows_->calc_range(rows, terms_.best, i);
      std::vector<double>& out = efforts[static_cast<size_t>(terms_.design.joints[i].joint)];
      for (size_t k = 0, at = 0; k < time.size() && !rows.time.empty(); ++k) {
        while (at + 1 < rows.time.size() && rows.time[at + 1] <= time[k]) ++at;
        const size_t next = std::min(at + 1, rows.time.size() - 1);
        const double span = rows.time[next] - rows.time[at],
                     share = span > 0.0 ? std::clamp((time[k] - rows.time[at]) / span, 0.0, 1.0) : 0.0;
        out[k] = (1.0 - share) * y[static_cast<long>(at)] + share * y[static_cast<long>(next)];
      }
    }
    return efforts;
  }

  // Plays a motion under the report's model. A robot that is driven by efforts follows it; its efforts come from the
  // terms.
  bool play(const MotionPlan& plan, const Commands& commands, Played* out) const {
    if (!by_effort_) {
      out->motion = make_trial_motion(bare_, e_.recordings[0], commands, terms_.best.hypothesis, plan.loads);
      return out->motion && rows_->measure(out->motion->experiment, &out->rows);
    }
    std::vector<std::vector<double>> efforts(limits_.joints.size(), std::vector<double>(commands.time.size(), 0.0));
    for (int pass = 0; pass < 2; ++pass) {  // columns of the effort need efforts
      out->motion = make_followed_motion(bare_, e_.recordings[0], commands, efforts, plan.loads);
      out->rows = {};
      if (!rows_->measure(out->motion->experiment, &out->rows)) return false;
      efforts = predict_efforts(out->rows, {"", terms_.best, 0.0}, commands.time);
    }
    return true;
  }

  std::string find_fault(const Played& played, const TorqueWorld& world, Safety* safety, std::vector<double>* leave,
                         std::vector<char>* faulty) const {
    std::vector<double> readings;
    if (!predict(played, world, &readings)) return "the simulated robot leaves all bounds";
    return safety->find_fault_of(*played.motion, readings, leave, faulty);
  }

  // The largest sizes, from the plan's own, that are safe under the report's model.
  void try_motion(const MotionPlan& plan, Safety* safety, TorqueCandidate* c) const {
    c->plan = plan;
    c->ok = false;
    MotionPlan& p = c->plan;
    for (std::vector<char> faulty; faulty.empty() || make_smaller(faulty, &p);) {
      faulty.assign(limits_.joints.size(), 0);
      c->commands = make_motion(p, limits_);
      Played played;
      const std::string fault = play(p, c->commands, &played)
                                    ? find_fault(played, {"", terms_.best, 0.0}, safety, nullptr, &faulty)
                                    : "the simulated robot leaves all bounds, or moves no judged joint";
      if (!fault.empty()) {
        c->fault = describe_plan(p) + ": " + fault + " under the report's model";
        continue;
      }
      c->comparisons.clear();
      for (const OpenQuestion& q : terms_.questions)
        c->comparisons.push_back(rows_->compare(played.rows, q.truth, q.rival));
      c->fisher = rows_->compare(played.rows, terms_.best, terms_.best).fisher;
      c->considered = intervals_->sum_along(played.rows);
      c->ok = true;
      c->fault.clear();
      return;
    }
  }

  void try_motions() {
    std::vector<char> concerned(static_cast<size_t>(e_.num_joints()), 0);
    for (const OpenQuestion& q : terms_.questions) mark_difference(q, &concerned);
    const std::vector<MotionPlan> plans = list_plans(e_, limits_, concerned, options_.seconds);
    progress_(std::to_string(terms_.questions.size()) + " questions about the missing torque along " +
              std::to_string(plans.size()) + " motions");
    candidates_.resize(plans.size());
    for (int i = 0; i < options_.jobs; ++i) safety_.push_back(std::make_unique<Safety>(e_, limits_));
    parallel_for(options_.jobs, static_cast<int>(plans.size()), [&](int i, int worker) {
      try_motion(plans[static_cast<size_t>(i)], safety_[static_cast<size_t>(worker)].get(),
                 &candidates_[static_cast<size_t>(i)]);
    });
    for (const TorqueCandidate& c : candidates_) {
      if (c.ok) intervals_->allow(c.considered);
    }
    next_.tried = static_cast<int>(plans.size());
  }

  // Marks the joints of effects that only one side has.
  void mark_difference(const OpenQuestion& q, std::vector<char>* concerned) const {
    for (const Hypothesis* side : {&q.truth.hypothesis, &q.rival.hypothesis}) {
      const Hypothesis& other = side == &q.truth.hypothesis ? q.rival.hypothesis : q.truth.hypothesis;
      for (const Effect& effect : *side) {
        if (!contains(other, effect.id, effect.place)) mark_concerned(e_, {effect}, concerned);
      }
    }
  }

  double calc_left(const TorqueCandidate& c, size_t q) const {
    return calc_projected_power(c.comparisons[q], known_rival_[q]);
  }

  // What is known with another motion. A report fits its values to the recordings for training.
  Gained add(Gained gained, const TorqueCandidate& c) const {
    if (is_held_out(next_.proposals.size())) return gained;
    gained.fisher += c.fisher;
    for (size_t i = 0; i < c.considered.size(); ++i) {
      gained.considered[i].xx += c.considered[i].xx;
      gained.considered[i].moved += c.considered[i].moved;
    }
    for (size_t j = 0; j < c.commands.position.size(); ++j) widen(c.commands.position[j], &gained.ranges[j]);
    return gained;
  }

  double calc_worth_of(const TorqueCandidate& c, const Gained& gained) const {
    double decided = 0.0;
    for (size_t q = 0; q < c.comparisons.size(); ++q)
      decided += calc_decision_probability(calc_left(c, q), kNeeded, 1.0) / static_cast<double>(c.comparisons.size());
    return calc_worth(decided, intervals_->list(gained), intervals_->list(add(gained, c))) *
           calc_drawback(c.plan, next_.proposals);
  }

  // The questions whose answers differ most along the motion, at most kShortList.
  std::vector<size_t> list_largest(const TorqueCandidate& c) const {
    std::vector<size_t> order(c.comparisons.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return c.comparisons[a].power > c.comparisons[b].power; });
    order.resize(std::min(order.size(), kShortList));
    return order;
  }

  std::string find_any_fault(const TorqueCandidate& c, const Played& played, std::vector<double>* leave,
                             std::vector<char>* faulty) const {
    const std::vector<TorqueWorld> worlds = list_torque_worlds(terms_, list_largest(c));
    std::vector<std::string> faults(worlds.size());
    std::vector<std::vector<double>> leaves(worlds.size(), std::vector<double>(limits_.joints.size(), 0.0));
    std::vector<std::vector<char>> marks(worlds.size(), std::vector<char>(limits_.joints.size(), 0));
    parallel_for(options_.jobs, static_cast<int>(worlds.size()), [&](int i, int worker) {
      const size_t w = static_cast<size_t>(i);
      faults[w] = find_fault(played, worlds[w], safety_[static_cast<size_t>(worker)].get(), &leaves[w], &marks[w]);
      if (!faults[w].empty()) faults[w] += worlds[w].label;
    });
    leave->assign(limits_.joints.size(), 0.0);
    faulty->assign(limits_.joints.size(), 0);
    for (const auto& one : marks) {
      for (size_t j = 0; j < one.size(); ++j) (*faulty)[j] |= one[j];
    }
    for (const auto& one : leaves) {
      for (size_t j = 0; j < leave->size(); ++j) (*leave)[j] = std::max((*leave)[j], one[j]);
    }
    const auto fault = std::find_if(faults.begin(), faults.end(), [](const std::string& f) { return !f.empty(); });
    return fault == faults.end() ? "" : *fault;
  }

  // A report asks only what its recordings raise: of a joint that hardly moved, or of an effect that they do not show,
  // it has no question. Several sines of all joints show most of all effects, so the first motion, the one that is
  // fitted, is of this family wherever one is safe. A held-out motion of all joints confirms what the fitted one shows
  // of each.
  bool is_rich(const TorqueCandidate& c) const {
    bool all = true;
    for (size_t j = 0; j < c.plan.moves.size(); ++j)
      all = all && (c.plan.moves[j] || e_.robot.tree.joint(static_cast<int>(j)).mimic.joint >= 0);
    const bool confirms = is_held_out(next_.proposals.size());
    return all && c.plan.loads.empty() && (c.plan.family == Family::kMultisine || confirms);
  }

  TorqueCandidate* find_best(const Gained& gained) {
    const bool wants_rich = next_.proposals.empty() || is_held_out(next_.proposals.size());
    const bool any_rich = std::any_of(candidates_.begin(), candidates_.end(),
                                      [&](const TorqueCandidate& c) { return c.ok && is_rich(c); });
    TorqueCandidate* best = nullptr;
    double most = -1.0;
    for (TorqueCandidate& c : candidates_) {
      if (!c.ok || (wants_rich && any_rich && !is_rich(c))) continue;
      const double worth = calc_worth_of(c, gained);
      if (worth > most) {
        most = worth;
        best = &c;
      }
    }
    return best;
  }

  // Greedy. A motion that is not safe under every model is tried smaller.
  void choose() {
    Gained gained = intervals_->nothing();
    for (size_t check = 0; check < kShortList && static_cast<int>(next_.proposals.size()) < options_.count; ++check) {
      TorqueCandidate* best = find_best(gained);
      if (!best) return;
      Played played;
      std::vector<double> leave;
      std::vector<char> faulty;
      play(best->plan, best->commands, &played);
      const std::string fault = find_any_fault(*best, played, &leave, &faulty);
      if (fault.empty()) {
        best->ok = false;
        best->fault.clear();
        const Gained before = gained;
        gained = add(gained, *best);
        add_proposal(*best, played, before, gained, leave);
        continue;
      }
      best->fault = describe_plan(best->plan) + ": " + fault;
      const std::string larger = best->fault;
      MotionPlan smaller = best->plan;
      if (make_smaller(faulty, &smaller))
        try_motion(smaller, safety_[0].get(), best);
      else
        best->ok = false;
      best->fault = larger;
    }
  }

  void add_proposal(const TorqueCandidate& c, const Played& played, const Gained& before, const Gained& gained,
                    const std::vector<double>& leave) {
    Proposal p = begin_proposal(next_.proposals.size(), c.plan, c.commands, calc_worth_of(c, before));
    for (size_t j = 0; j < c.plan.moves.size(); ++j) {
      if (c.plan.moves[j]) p.moving.push_back(e_.robot.tree.joint(static_cast<int>(j)).name);
    }
    for (size_t q = 0; q < c.comparisons.size(); ++q) {
      const double left = calc_left(c, q);
      p.expected.push_back(
          {terms_.questions[q].label, calc_decision_probability(left, kNeeded, 1.0), calc_rms(c.comparisons[q], left)});
    }
    p.intervals = intervals_->list(gained);
    p.overlay = make_overlay(c, played.rows);
    if (by_effort_) p.effort = predict_efforts(played.rows, {"", terms_.best, 0.0}, c.commands.time);
    for (size_t j = 0; j < leave.size() && !by_effort_; ++j) p.stop.push_back(kStopFactor * leave[j] + kStopMore);
    next_.proposals.push_back(std::move(p));
  }

  // Efforts of the joint at which one of the rivals differs most, as shares of the joint's effort.
  Overlay make_overlay(const TorqueCandidate& c, const MotionRows& rows) const {
    const std::vector<size_t> largest = list_largest(c);
    size_t joint = 0;
    double most = -1.0;
    for (size_t i = 0; i < terms_.design.joints.size(); ++i) {
      for (size_t q : largest) {
        const double differs = calc_difference(rows, q, i) * terms_.design.joints[i].weigh_squares();
        if (differs > most) {
          most = differs;
          joint = i;
        }
      }
    }
    Overlay overlay;
    const int j = terms_.design.joints[joint].joint;
    overlay.signal = e_.signal_name(j, Quantity::kEffort);
    overlay.unit = get_unit_of(j);
    std::vector<Eigen::VectorXd> curves{rows_->predict(rows, terms_.best, joint)};
    overlay.labels.push_back(next_.explanations[0]);
    for (size_t q : largest) {
      if (curves.size() >= kShortList || !(calc_difference(rows, q, joint) > 0.0)) continue;
      curves.push_back(rows_->predict(rows, terms_.questions[q].shown(), joint));
      overlay.labels.push_back(terms_.questions[q].label);
    }
    overlay.curves.resize(curves.size());
    const size_t stride = std::max<size_t>(1, rows.time.size() / 500);
    for (size_t k = 0; k < rows.time.size(); k += stride) {
      overlay.time.push_back(rows.time[k]);
      for (size_t i = 0; i < curves.size(); ++i) overlay.curves[i].push_back(curves[i][static_cast<long>(k)]);
    }
    return overlay;
  }

  // [(N m)^2] squares of the difference of both sides of a question.
  double calc_difference(const MotionRows& rows, size_t q, size_t joint) const {
    const OpenQuestion& question = terms_.questions[q];
    return (rows_->predict(rows, question.truth, joint) - rows_->predict(rows, question.rival, joint)).squaredNorm();
  }

  std::string get_unit_of(int joint) const { return get_joint_unit(e_.robot.tree.joint(joint), "N m"); }

  const Experiment& e_;
  NextOptions options_;
  const Progress& progress_;
  Limits limits_;
  OpenTerms terms_;
  Experiment bare_;
  const bool by_effort_;
  std::unique_ptr<TorqueRows> rows_;
  std::unique_ptr<ExpectedIntervals> intervals_;
  std::vector<Eigen::MatrixXd> known_rival_;     // by question
  std::vector<std::unique_ptr<Safety>> safety_;  // by worker
  std::vector<TorqueCandidate> candidates_;
  Next next_;
};

}  // namespace

Next propose_by_torque(const Experiment& experiment, const Json& report, const NextOptions& options,
                       const Progress& progress) {
  return TorqueProposer(experiment, report, options, progress).run();
}

}  // namespace hrp::diagnosis
