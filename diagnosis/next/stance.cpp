// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/stance.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "common/base/parallel_for.h"
#include "diagnosis/data/mean.h"
#include "diagnosis/data/servo_gains.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/next/candidate.h"
#include "diagnosis/next/limits.h"
#include "diagnosis/next/plan_list.h"
#include "diagnosis/next/proposal_parts.h"
#include "diagnosis/next/stance_motions.h"
#include "diagnosis/next/stance_readings.h"
#include "diagnosis/next/stance_trial.h"
#include "diagnosis/next/stance_worlds.h"
#include "diagnosis/next/walk_motions.h"
#include "diagnosis/search/trial.h"

namespace hrp::diagnosis {
namespace {

// A motion that is safe under every explanation, and its information.
struct StanceCandidate : MotionCandidate {
  std::vector<StanceRun> runs;   // by explanation
  std::vector<double> weights;   // of readings
  std::vector<Readings> slopes;  // by value of the report's model
  double liveliness = 0.0;       // 0 to 1: speeds and accelerations of all joints, relative to the liveliest motion
};

class StanceProposer {
 public:
  StanceProposer(const Experiment& e, const Json& report, const NextOptions& options, const Progress& progress)
      : e_(e),
        options_(options),
        progress_(progress),
        limits_(make_limits(e, options.limits)),
        worlds_(make_stance_worlds(e, report)),
        readings_(e) {
    const Json fit = report.value("fit", Json::object());
    const Json judged = fit.value("validate", Json::object());
    if (judged.contains("after") && judged["after"].is_number())
      discrepancy_ = std::max(1.0, judged["after"].get<double>());
    const std::string verdict = report.value("verdict", "");
    complete_ = verdict == "explained" || verdict == "no_mismatch";
  }

  Next run() {
    next_.remarks = limits_.remarks;
    next_.remarks.insert(next_.remarks.end(), worlds_.remarks.begin(), worlds_.remarks.end());
    leave_out_fallen();
    for (const StanceWorld& world : worlds_.list) next_.explanations.push_back(world.label);
    next_.unseen = worlds_.unseen;
    if (worlds_.list.empty() || (worlds_.values.empty() && worlds_.list.size() < 2 && !is_open_still())) {
      next_.nothing = worlds_.unseen ? "The recordings show no mismatch, and every joint moved: nothing is ambiguous."
                                     : "Nothing was found that can be simulated on the robot's feet.";
      return next_;
    }
    for (const std::vector<Family>& families : list_stages()) {
      if (static_cast<int>(next_.proposals.size()) < options_.count) {
        try_motions(families);
        choose();
      }
    }
    next_.simulated = simulated_;
    if (next_.proposals.empty())
      next_.nothing = "No motion keeps the robot safely on its feet under every explanation.";
    return next_;
  }

 private:
  // True if the report has more to ask although nothing of it can be simulated: joints stood still.
  bool is_open_still() const { return worlds_.still && worlds_.open; }

  StanceRun play(const Scenario& scenario, const StanceCandidate& c) const {
    ++simulated_;
    return run_stance(e_, scenario, c.commands, limits_, c.plan.family == Family::kWalk);
  }

  // Plays a motion in all worlds until it is not safe in one; returns what is wrong there. `first`: the world to begin
  // with, then the one that failed.
  std::string play_all(StanceCandidate* c, size_t* first) const {
    c->runs.assign(worlds_.list.size(), {});
    for (size_t i = 0; i < c->runs.size(); ++i) {
      const size_t w = i == 0 ? *first : i - (i <= *first ? 1 : 0);
      c->runs[w] = play(worlds_.list[w].scenario, *c);
      if (c->runs[w].fault.empty()) continue;
      *first = w;
      return c->runs[w].fault + " if it is " + worlds_.list[w].label;
    }
    return "";
  }

  // Simulates a motion with the largest size that is safe under all explanations. A smaller size is first tried where
  // the larger one failed.
  void try_motion(MotionPlan plan, StanceCandidate* c) const {
    size_t first = 0;
    for (; plan.size >= kLeastStance; plan.size *= kSmallerStance) {
      c->plan = plan;
      c->fault = "a leg does not reach, or a joint would pass its limits";
      c->commands = make_stance_motion(e_, plan, limits_);
      if (c->commands.time.empty()) continue;
      c->fault = play_all(c, &first);
      if (c->fault.empty()) break;
    }
    if (!c->fault.empty()) return;
    c->weights = readings_.make_weights(c->runs[0]);
    for (size_t i = 0; i < worlds_.list.size(); ++i) c->comparisons.push_back(compare(c, i));
    c->ok = true;
  }

  // Starts with the report's model, whose slopes the others share.
  Comparison compare(StanceCandidate* c, size_t i) const {
    std::vector<Readings> slopes;
    const Readings own = readings_.record(c->runs[i], worlds_.list[i].faults);
    for (const StanceMove& move : worlds_.list[i].moves) {
      if (move.shared >= 0)
        slopes.push_back(c->slopes[static_cast<size_t>(move.shared)]);
      else
        slopes.push_back(subtract(readings_.record(move.of_log ? c->runs[i] : play(move.scenario, *c), move.faults),
                                  own, c->weights));
      slopes.back().resize(c->runs[i].readings.size(), 0.0);
    }
    if (i == 0) c->slopes = slopes;
    const Readings difference = subtract(own, readings_.record(c->runs[0], worlds_.list[0].faults), c->weights);
    Comparison out;
    const long p = static_cast<long>(slopes.size());
    out.power = dot(difference, difference);
    out.fisher.resize(p, p);
    out.along.resize(p);
    const auto recorded = std::count_if(c->weights.begin(), c->weights.end(), [](double w) { return w > 0.0; });
    const size_t samples = c->runs[i].readings.size() / readings_.channels();
    out.count = static_cast<double>(samples) * static_cast<double>(recorded);
    for (long a = 0; a < p; ++a) {
      out.along[a] = -dot(slopes[static_cast<size_t>(a)], difference);
      for (long b = 0; b < p; ++b)
        out.fisher(a, b) = dot(slopes[static_cast<size_t>(a)], slopes[static_cast<size_t>(b)]);
    }
    return out;
  }

  // A world in which the robot does not even stand at rest contradicts the recordings, in which it stood. The report's
  // model stays: where that falls, nothing is known.
  void leave_out_fallen() {
    Commands rest;
    rest.time = {0.0, kPeriod};
    for (const JointLimits& joint : limits_.joints) {
      rest.position.emplace_back(2, joint.start);
      rest.velocity.emplace_back(2, 0.0);
    }
    const auto falls = [&](const StanceWorld& world) {
      return !run_stance(e_, world.scenario, rest, limits_).fault.empty();
    };
    for (std::vector<StanceWorld>* list : {&worlds_.list, &worlds_.ends}) {
      for (size_t w = list->size(); w-- > (list == &worlds_.list ? 1 : 0);) {
        if (!falls((*list)[w])) continue;
        next_.remarks.push_back((*list)[w].label +
                                ": the simulated robot does not stand at rest, as the real one did; not checked");
        list->erase(list->begin() + static_cast<long>(w));
      }
    }
  }

  // Where joints stood still, or the report leaves something unexplained: no question of the report is about what it
  // did not see.
  bool is_everything_open() const { return !complete_ || worlds_.still; }

  // Families to try together. The next ones are tried only if no motion of those before is safe.
  std::vector<std::vector<Family>> list_stages() const {
    std::vector<Family> one{Family::kSway, Family::kLean, Family::kSquat, Family::kTurn},
        all{Family::kStir, Family::kSwing};
    // A robot that was never seen to walk does not begin with it here. Nothing corrects a walk that is played: it needs
    // a robot that the simulation describes completely.
    if (complete_ && is_walking(e_)) one.push_back(Family::kWalk);
    if (is_everything_open()) return {all, one};
    one.insert(one.end(), all.begin(), all.end());
    return {one};
  }

  void try_motions(const std::vector<Family>& families) {
    const std::vector<MotionPlan> plans = list_stance_plans(families, limits_.joints.size(), options_.seconds);
    progress_(std::to_string(worlds_.list.size()) + " explanations along " + std::to_string(plans.size()) +
              " motions on the feet");
    candidates_.assign(plans.size(), {});
    parallel_for(options_.jobs, static_cast<int>(plans.size()),
                 [&](int i) { try_motion(plans[static_cast<size_t>(i)], &candidates_[static_cast<size_t>(i)]); });
    next_.tried += static_cast<int>(plans.size());
    find_liveliness();
    for (const StanceCandidate& c : candidates_) {
      if (!c.ok) next_.rejected.push_back(describe_plan(c.plan) + ": " + c.fault);
    }
  }

  // Friction shows by the speed of a joint, a rotor by its acceleration.
  void find_liveliness() {
    const size_t n = limits_.joints.size();
    std::vector<std::vector<double>> sizes;
    std::vector<double> most(2 * n, 0.0);
    for (const StanceCandidate& c : candidates_) {
      sizes.emplace_back(2 * n, 0.0);
      for (size_t j = 0; c.ok && j < n; ++j) {
        sizes.back()[j] = calc_rms(c.commands.velocity[j]);
        sizes.back()[n + j] = calc_rms(calc_rates(c.commands.velocity[j], c.plan.period));
      }
      for (size_t i = 0; i < 2 * n; ++i) most[i] = std::max(most[i], sizes.back()[i]);
    }
    for (size_t c = 0; c < candidates_.size(); ++c) {
      for (size_t i = 0; i < 2 * n; ++i)
        candidates_[c].liveliness += most[i] > 0.0 ? sizes[c][i] / most[i] / static_cast<double>(2 * n) : 0.0;
    }
  }

  // Information of the recordings, in units of the steps of the derivatives: a step is one standard deviation.
  Eigen::MatrixXd make_known(size_t world) const {
    const long p = static_cast<long>(worlds_.list[world].moves.size());
    Eigen::MatrixXd known = Eigen::MatrixXd::Zero(p, p);
    for (long i = 0; world == 0 && i < p; ++i)
      known(i, i) = worlds_.values[static_cast<size_t>(i)].std > 0.0 ? 1.0 : 0.0;
    return known;
  }

  double calc_probability(const StanceCandidate& c, size_t rival) const {
    const double left = calc_projected_power(c.comparisons[rival], make_known(rival));
    return calc_decision_probability(left, calc_dearer(kDetail), discrepancy_);
  }

  Eigen::MatrixXd calc_gain(const StanceCandidate& c) const {
    return c.comparisons[0].fisher * calc_information_factor(discrepancy_, c.comparisons[0].count, 1.0);
  }

  std::vector<ExpectedInterval> list_intervals(const Eigen::MatrixXd& gained) const {
    std::vector<ExpectedInterval> list;
    const long p = gained.rows();
    if (p == 0) return list;
    const Eigen::VectorXd std = calc_expected_std(make_known(0) + gained, Eigen::VectorXd::Constant(p, 1.0 / kMinor));
    for (long i = 0; i < p; ++i) {
      const StanceValue& value = worlds_.values[static_cast<size_t>(i)];
      if (value.std > 0.0)
        list.push_back({value.label, value.parameter, value.unit, value.value, kNinetyFive * value.std,
                        kNinetyFive * value.std * std::min(1.0, std[i])});
    }
    return list;
  }

  // Interval widths only rank motions and are not reported, because reports of standing robots fit equations, not
  // simulations.
  double calc_worth_of(const StanceCandidate& c, const Eigen::MatrixXd& gained) const {
    double decided = 0.0;
    for (size_t i = 1; i < c.comparisons.size(); ++i)
      decided += calc_probability(c, i) / static_cast<double>(c.comparisons.size() - 1);
    // A walk needs room, and somebody beside the robot.
    return calc_worth(decided, list_intervals(gained), list_intervals(gained + calc_gain(c))) *
           (c.plan.family == Family::kWalk ? kDrawback : 1.0);
  }

  // Checks the motion under the nominal model and with values at the ends of their intervals, up to the first one in
  // which it is not safe.
  std::string find_fault(const StanceCandidate& c, std::vector<double>* leave) const {
    std::vector<StanceRun> runs(worlds_.ends.size());
    std::atomic<int> failed{static_cast<int>(runs.size())};  // the first one
    parallel_for(options_.jobs, static_cast<int>(runs.size()), [&](int i) {
      if (i > failed.load()) return;
      StanceRun& run = runs[static_cast<size_t>(i)] = play(worlds_.ends[static_cast<size_t>(i)].scenario, c);
      int before = failed.load();
      while (!run.fault.empty() && i < before && !failed.compare_exchange_weak(before, i)) {
      }
    });
    const auto first = static_cast<size_t>(failed.load());
    if (first < runs.size()) return runs[first].fault + " with " + worlds_.ends[first].label;
    runs.insert(runs.end(), c.runs.begin(), c.runs.end());
    leave->assign(limits_.joints.size(), 0.0);
    for (const StanceRun& run : runs) {
      for (size_t j = 0; j < leave->size(); ++j) (*leave)[j] = std::max((*leave)[j], run.leave[j]);
    }
    return "";
  }

  // If everything is open, a motion that moves all joints comes first, the livelier the better: an effect of a joint
  // that moves in only one of the two kinds of recordings is not named. Without a mismatch there is no question about
  // the legs, so that later motions may move the limbs only.
  double calc_rank(const StanceCandidate& c, const Eigen::MatrixXd& gained) const {
    const double worth = calc_worth_of(c, gained);
    if (!is_everything_open()) return worth;
    const bool limbs = worlds_.unseen && !next_.proposals.empty() && c.plan.family == Family::kSwing;
    return worth + kHalf * c.liveliness + (limbs || c.plan.family == Family::kStir ? 1.0 + kHalf : 0.0);
  }

  void choose() {
    const long p = static_cast<long>(worlds_.list[0].moves.size());
    if (gained_.size() == 0) gained_ = Eigen::MatrixXd::Zero(p, p);
    while (static_cast<int>(next_.proposals.size()) < options_.count) {
      StanceCandidate* best = nullptr;
      double most = -1.0;
      for (StanceCandidate& c : candidates_) {
        const double rank = c.ok ? calc_rank(c, gained_) : -1.0;
        if (rank > most) {
          most = rank;
          best = &c;
        }
      }
      if (!best) return;
      const double worth = calc_worth_of(*best, gained_);
      best->ok = false;
      std::vector<double> leave;
      const std::string fault = find_fault(*best, &leave);
      if (!fault.empty()) {
        next_.rejected.push_back(describe_plan(best->plan) + ": " + fault);
        continue;
      }
      if (!is_held_out(next_.proposals.size())) gained_ += calc_gain(*best);  // as for arms (propose.cpp)
      add_proposal(*best, worth, leave);
    }
  }

  void add_proposal(const StanceCandidate& c, double worth, const std::vector<double>& leave) {
    Proposal p = begin_proposal(next_.proposals.size(), c.plan, c.commands, worth);
    p.overlay = make_overlay(c);
    for (size_t j = 0; j < c.commands.position.size(); ++j) {
      const auto [low, high] = std::minmax_element(c.commands.position[j].begin(), c.commands.position[j].end());
      if (*high - *low > 1e-4) p.moving.push_back(e_.robot.tree.joint(static_cast<int>(j)).name);
    }
    for (size_t i = 1; i < c.comparisons.size(); ++i) {
      const double left = calc_projected_power(c.comparisons[i], make_known(i));
      p.expected.push_back({worlds_.list[i].label, calc_probability(c, i), calc_rms(c.comparisons[i], left)});
    }
    for (double most : leave) p.stop.push_back(kStopFactor * most + kStopMore);
    double margin = 1e300;
    for (const StanceRun& run : c.runs) margin = std::min(margin, run.margin);
    next_.remarks.push_back(p.file + ": the zero-moment point stays " + number(margin, 2) +
                            " m inside the edge of the soles under every explanation");
    next_.proposals.push_back(std::move(p));
  }

  // Predictions of the reading in which the explanations differ most.
  Overlay make_overlay(const StanceCandidate& c) const {
    Readings sums(readings_.channels(), 0.0);
    std::vector<Readings> written;
    for (size_t i = 0; i < c.runs.size(); ++i) written.push_back(readings_.record(c.runs[i], worlds_.list[i].faults));
    for (const Readings& readings : written) {
      const Readings difference = subtract(readings, written[0], c.weights);
      for (size_t k = 0; k < difference.size(); ++k) sums[k % readings_.channels()] += difference[k] * difference[k];
    }
    const size_t channel = static_cast<size_t>(std::max_element(sums.begin(), sums.end()) - sums.begin());
    Overlay overlay;
    overlay.signal = readings_.get_signal(channel);
    overlay.unit = readings_.get_unit(channel);
    overlay.curves.resize(c.runs.size());
    const size_t rows = c.runs[0].readings.size() / readings_.channels();
    for (size_t k = 0; k < rows; ++k) {
      overlay.time.push_back(static_cast<double>(k) / static_cast<double>(rows) * c.commands.time.back());
      for (size_t i = 0; i < c.runs.size(); ++i)
        overlay.curves[i].push_back(written[i][k * readings_.channels() + channel]);
    }
    return overlay;
  }

  const Experiment& e_;
  NextOptions options_;
  const Progress& progress_;
  Limits limits_;
  StanceWorlds worlds_;
  StanceReadings readings_;
  double discrepancy_ = 1.0;
  bool complete_ = false;                    // the report leaves nothing unexplained
  std::vector<StanceCandidate> candidates_;  // of the present stage
  Eigen::MatrixXd gained_;                   // information of the proposals that are fitted
  mutable std::atomic<int> simulated_{0};
  Next next_;
};

std::string find_obstacle(const Experiment& e) {
  if (e.scenario.feet.empty() || !e.scenario.ground.present)
    return "The robot moves freely: motions are proposed for a fixed base, and for feet on level ground.";
  if (std::abs(e.scenario.ground.roll) + std::abs(e.scenario.ground.pitch) > 0.0)
    return "The ground is not level: no motion on the feet is proposed.";
  if (!e.scenario.loops.empty()) return "Joints of this robot close chains: no motion on the feet is proposed.";
  if (e.scenario.drive == "servo") return "";
  for (int j = 0; j < e.num_joints(); ++j) {
    const JointSpec& joint = e.robot.tree.joint(j);
    if (joint.actuated && !(get_servo_gains(e.scenario, joint.name).kp > 0.0))
      return "The recordings have no commands to servos, and no gains are stated for " + joint.name +
             ": no motion can be proposed.";
  }
  return "";
}

}  // namespace

Next propose_stance(const Experiment& experiment, const Json& report, const NextOptions& options,
                    const Progress& progress) {
  Next next;
  next.nothing = find_obstacle(experiment);
  if (!next.nothing.empty()) return next;
  return StanceProposer(experiment, report, options, progress).run();
}

}  // namespace hrp::diagnosis
