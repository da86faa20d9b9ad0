// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/propose.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/effects/units.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/measurement/torque/terms.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/next/candidate.h"
#include "diagnosis/next/ends.h"
#include "diagnosis/next/open_terms.h"
#include "diagnosis/next/plan_list.h"
#include "diagnosis/next/proposal_parts.h"
#include "diagnosis/next/safety.h"
#include "diagnosis/next/stance.h"
#include "diagnosis/next/torque_propose.h"
#include "diagnosis/search/starts.h"
#include "diagnosis/search/trial.h"

namespace hrp::diagnosis {
namespace {

constexpr double kWide = 100.0;  // natural sizes of a parameter: its uncertainty without recordings

class Proposer {
 public:
  Proposer(const Experiment& experiment, const NextOptions& options, const Progress& progress)
      : e_(experiment),
        options_(options),
        progress_(progress),
        limits_(make_limits(experiment, options.limits)),
        problem_(make_problem(experiment, options.jobs)),
        safety_(experiment, limits_),
        bare_(experiment) {
    bare_.recordings.clear();
    prepare_paths(&problem_);
    for (size_t r = 0; r < e_.recordings.size(); ++r) all_.push_back(static_cast<int>(r));
  }

  Next run(const Json& report) {
    explanations_ = find_explanations(problem_, report, progress_);
    next_.unseen = explanations_.unseen;
    next_.remarks = safety_.remarks();
    for (const Explanation& one : explanations_.list) next_.explanations.push_back(one.label);
    if (explanations_.list.size() < 2 && explanations_.list[0].hypothesis.empty()) {
      next_.nothing = explanations_.unseen
                          ? "The recordings show no mismatch, and every joint moved: nothing is ambiguous."
                          : "Nothing was found that a motion could tell more about.";
      return next_;
    }
    known_.resize(explanations_.list.size());
    parallel_for(options_.jobs, static_cast<int>(known_.size()), [&](int i) {
      known_[static_cast<size_t>(i)] =
          calc_fisher(problem_, explanations_.list[static_cast<size_t>(i)].hypothesis, all_, explanations_.discrepancy);
    });
    if (explanations_.list.size() < 2 && is_settled(report)) {
      next_.nothing =
          "Only one explanation fits the recordings, and its values are known to 2 %: nothing is ambiguous.";
      return next_;
    }
    try_motions();
    choose();
    if (next_.proposals.empty()) next_.nothing = "No motion is safe within the limits under every explanation.";
    return next_;
  }

 private:
  // True if the recordings are explained and all values are known, by the report's intervals if it has them. Shape
  // parameters of laws do not count.
  bool is_settled(const Json& report) const {
    if (report.value("verdict", "") != "explained" || !is_narrow(report)) return false;
    const std::vector<ExpectedInterval> now = list_intervals(Eigen::MatrixXd::Zero(known_[0].rows(), known_[0].cols()));
    return std::all_of(now.begin(), now.end(),
                       [](const ExpectedInterval& i) { return i.before <= kKnown * std::abs(i.value); });
  }

  static bool is_narrow(const Json& report) {
    for (const Json& finding : report.value("findings", Json::array())) {
      for (const Json& one : finding.value("parameters", Json::object())) {
        const Json ends = one.is_object() ? one.value("ci95", Json()) : Json();
        if (ends.size() != 2 || !ends[0].is_number() || !ends[1].is_number() || !one["value"].is_number()) continue;
        if (ends[1].get<double>() - ends[0].get<double>() > 2.0 * kKnown * std::abs(one["value"].get<double>()))
          return false;
      }
    }
    return true;
  }

  // Joints at which the possible effects act, and joints that carry such links.
  std::vector<char> find_concerned() const {
    std::vector<char> moves(static_cast<size_t>(e_.num_joints()), 0);
    for (const Explanation& one : explanations_.list) mark_concerned(e_, one.hypothesis, &moves);
    return moves;
  }

  bool is_safe(const TrialMotion& motion, Safety* safety, std::vector<char>* faulty) const {
    return std::all_of(explanations_.list.begin(), explanations_.list.end(), [&](const Explanation& one) {
      return safety->find_fault(motion, one.hypothesis, nullptr, faulty).empty();
    });
  }

  // Simulates a motion with the largest sizes that are safe under all explanations.
  void try_motion(const MotionPlan& plan, Safety* safety, MotionCandidate* candidate) const {
    candidate->plan = plan;
    MotionPlan& p = candidate->plan;
    for (std::vector<char> faulty; faulty.empty() || make_smaller(faulty, &p);) {
      faulty.assign(limits_.joints.size(), 0);
      candidate->commands = make_motion(p, limits_);
      const auto motion =
          make_trial_motion(bare_, e_.recordings[0], candidate->commands, explanations_.list[0].hypothesis, p.loads);
      if (!motion || !is_safe(*motion, safety, &faulty)) continue;
      prepare_paths(&motion->problem);
      const double rate = kPeriod / std::max(1e-4, e_.sample_time);
      compare(motion->problem, explanations_, rate, candidate);
      weigh(candidate);
      return;
    }
  }

  // The residual of the best explanation above the noise is correlated along a motion, which reduces the information.
  void weigh(MotionCandidate* candidate) const {
    const double samples =
        static_cast<double>(candidate->commands.time.size()) * kPeriod / std::max(1e-4, e_.sample_time);
    candidate->comparisons[0].fisher *= calc_information_factor(explanations_.discrepancy, samples, kIndependent);
  }

  void try_motions() {
    const std::vector<MotionPlan> plans = list_plans(e_, limits_, find_concerned(), options_.seconds);
    progress_(std::to_string(explanations_.list.size()) + " explanations along " + std::to_string(plans.size()) +
              " motions");
    candidates_.resize(plans.size());
    std::vector<std::unique_ptr<Safety>> own(static_cast<size_t>(options_.jobs));
    for (auto& safety : own) safety = std::make_unique<Safety>(e_, limits_);
    parallel_for(options_.jobs, static_cast<int>(plans.size()), [&](int i, int worker) {
      try_motion(plans[static_cast<size_t>(i)], own[static_cast<size_t>(worker)].get(),
                 &candidates_[static_cast<size_t>(i)]);
    });
    next_.tried = static_cast<int>(plans.size());
  }

  // Uses the search's own rule for the cost difference at which a rival is no longer listed.
  double calc_probability(const Comparison& c, size_t rival) const {
    const Hypothesis &best = explanations_.list[0].hypothesis, &other = explanations_.list[rival].hypothesis;
    const double readings = count_readings(problem_) + c.count;
    const double needed = calc_dearer(kDetail) - calc_own_price(other, readings) + calc_own_price(best, readings);
    return calc_decision_probability(calc_projected_power(c, known_[rival]), needed, explanations_.discrepancy);
  }

  Eigen::VectorXd list_sizes() const {
    std::vector<double> sizes;
    for (const Effect& effect : explanations_.list[0].hypothesis) {
      for (const EffectParameter& info : list_infos(effect.id)) {
        if (!info.scanned) sizes.push_back(kWide * info.step);
      }
    }
    return Eigen::Map<Eigen::VectorXd>(sizes.data(), static_cast<long>(sizes.size()));
  }

  std::vector<ExpectedInterval> list_intervals(const Eigen::MatrixXd& gained) const {
    std::vector<ExpectedInterval> list;
    const Hypothesis& best = explanations_.list[0].hypothesis;
    if (known_[0].size() == 0) return list;
    const Eigen::VectorXd sizes = list_sizes(), before = calc_expected_std(known_[0], sizes),
                          after = calc_expected_std(known_[0] + gained, sizes);
    long at = 0;
    for (const Effect& effect : best) {
      const std::vector<EffectParameter>& infos = list_infos(effect.id);
      for (size_t i = 0; i < infos.size(); ++i) {
        if (infos[i].scanned) continue;
        const long k = at++;
        if (infos[i].nuisance) continue;
        const double floor = kAgreement * effect.p[i];
        std::string unit = infos[i].unit;
        if (effect.place.kind == PlaceKind::kJoint)
          unit = get_joint_unit(e_.robot.tree.joint(effect.place.index), unit);
        list.push_back({get_label(e_, effect), infos[i].key(), unit, effect.p[i],
                        kNinetyFive * std::hypot(before[k], floor), kNinetyFive * std::hypot(after[k], floor),
                        kNinetyFive * std::abs(floor)});
      }
    }
    return list;
  }

  double calc_worth_of(const MotionCandidate& c, const Eigen::MatrixXd& gained) const {
    double decided = 0.0;
    for (size_t i = 1; i < c.comparisons.size(); ++i)
      decided += calc_probability(c.comparisons[i], i) / static_cast<double>(c.comparisons.size() - 1);
    return calc_worth(decided, list_intervals(gained), list_intervals(gained + c.comparisons[0].fisher)) *
           calc_drawback(c.plan, next_.proposals);
  }

  // Reason why a motion is not safe, or empty. Checks the nominal model, every explanation, and every explanation with
  // a value at an end of its interval.
  std::string find_fault(const MotionCandidate& c, std::vector<double>* leave) {
    const auto motion =
        make_trial_motion(bare_, e_.recordings[0], c.commands, explanations_.list[0].hypothesis, c.plan.loads);
    if (!motion) return "the simulated robot leaves all bounds";
    leave->assign(limits_.joints.size(), 0.0);
    std::string fault = safety_.find_fault(*motion, {}, leave);
    if (!fault.empty()) return fault + " under the nominal model";
    for (size_t i = 0; i < explanations_.list.size(); ++i) {
      const Explanation& one = explanations_.list[i];
      fault = safety_.find_fault(*motion, one.hypothesis, leave);
      if (!fault.empty()) return fault + " if it is " + one.label;
      for (const Hypothesis& end :
           list_ends(one.hypothesis, known_[i], i == 0 ? Hypothesis{} : explanations_.list[0].hypothesis)) {
        fault = safety_.find_fault(*motion, end, leave);
        if (!fault.empty()) return fault + " if it is " + one.label + " with a value at the end of its interval";
      }
    }
    return "";
  }

  // Chooses motions that are useful on their own: the second one validates what the first one teaches. It narrows no
  // interval, because the report fits values to the recordings for training.
  void choose() {
    std::vector<char> used(candidates_.size(), 0);
    Eigen::MatrixXd gained = Eigen::MatrixXd::Zero(known_[0].rows(), known_[0].cols());
    while (static_cast<int>(next_.proposals.size()) < options_.count) {
      int best = -1;
      double most = -1.0;
      for (size_t i = 0; i < candidates_.size(); ++i) {
        if (used[i] || !candidates_[i].ok) continue;
        const double worth = calc_worth_of(candidates_[i], gained);
        if (worth > most) {
          most = worth;
          best = static_cast<int>(i);
        }
      }
      if (best < 0) return;
      used[static_cast<size_t>(best)] = 1;
      const MotionCandidate& chosen = candidates_[static_cast<size_t>(best)];
      std::vector<double> leave;
      const std::string fault = find_fault(chosen, &leave);
      if (!fault.empty()) {
        next_.rejected.push_back(describe_plan(chosen.plan) + ": " + fault);
        continue;
      }
      if (!is_held_out(next_.proposals.size())) gained += chosen.comparisons[0].fisher;
      next_.proposals.push_back(make_proposal(chosen, most, gained));
      for (double most_foreseen : leave) next_.proposals.back().stop.push_back(kStopFactor * most_foreseen + kStopMore);
    }
  }

  Proposal make_proposal(const MotionCandidate& c, double worth, const Eigen::MatrixXd& gained) const {
    Proposal p = begin_proposal(next_.proposals.size(), c.plan, c.commands, worth);
    for (size_t j = 0; j < c.plan.moves.size(); ++j) {
      if (c.plan.moves[j]) p.moving.push_back(e_.robot.tree.joint(static_cast<int>(j)).name);
    }
    for (size_t i = 1; i < c.comparisons.size(); ++i) {
      const double left = calc_projected_power(c.comparisons[i], known_[i]);
      p.expected.push_back(
          {explanations_.list[i].label, calc_probability(c.comparisons[i], i), calc_rms(c.comparisons[i], left)});
    }
    p.intervals = list_intervals(gained);
    p.overlay = make_overlay(c);
    return p;
  }

  // Predictions of the signal in which the explanations differ most.
  Overlay make_overlay(const MotionCandidate& c) const {
    Overlay overlay;
    const auto motion =
        make_trial_motion(bare_, e_.recordings[0], c.commands, explanations_.list[0].hypothesis, c.plan.loads);
    std::vector<std::vector<double>> readings(explanations_.list.size());
    for (size_t i = 0; i < readings.size(); ++i)
      simulate_trial(*motion, explanations_.list[i].hypothesis, &readings[i]);
    const size_t width = problem_.weights.size(), first = motion->problem.smooth[0].judged,
                 rows = c.commands.time.size();
    size_t channel = 0;
    double most = -1.0;
    for (size_t s = 0; s < width; ++s) {
      if (e_.recordings[0].joints[s / kQuantities].signal[s % kQuantities].empty()) continue;
      double sum = 0.0;
      for (const auto& other : readings) {
        for (size_t k = first; k < rows; ++k)
          sum += std::pow((other[k * width + s] - readings[0][k * width + s]) * problem_.weights[s], 2);
      }
      if (sum > most) {
        most = sum;
        channel = s;
      }
    }
    overlay.signal =
        e_.signal_name(static_cast<int>(channel / kQuantities), static_cast<Quantity>(channel % kQuantities));
    static const char* const units[] = {"rad", "rad/s", "N m"};
    overlay.unit =
        get_joint_unit(e_.robot.tree.joint(static_cast<int>(channel / kQuantities)), units[channel % kQuantities]);
    overlay.curves.resize(readings.size());
    for (size_t k = first; k < rows; k += 5) {
      overlay.time.push_back(c.commands.time[k]);
      for (size_t i = 0; i < readings.size(); ++i) overlay.curves[i].push_back(readings[i][k * width + channel]);
    }
    return overlay;
  }

  const Experiment& e_;
  NextOptions options_;
  const Progress& progress_;
  Limits limits_;
  Problem problem_;
  Safety safety_;
  Experiment bare_;
  std::vector<int> all_;
  Explanations explanations_;
  std::vector<Eigen::MatrixXd> known_;  // by explanation: Fisher information of the recordings
  std::vector<MotionCandidate> candidates_;
  Next next_;
};

// True if the report judges joints by their missing torque, and most of these have friction or a rotor that the model
// lacks. Replacing these effects one by one in a simulation would take minutes, and would not be the report's
// comparison.
bool has_losses_everywhere(const Experiment& e, const Json& report) {
  std::set<std::string> judged, lossy;
  for (const Json& one : report.value("remaining", Json::array())) {
    if (one["where"].contains("joint")) judged.insert(one["where"]["joint"].get<std::string>());
  }
  for (const Effect& effect : read_model(e, report)) {
    const std::vector<TermRow>& rows = list_term_rows();
    const bool of_drive = std::any_of(
        rows.begin(), rows.end(), [&](const TermRow& r) { return r.of_motor_and_gear && r.effect->id == effect.id; });
    if (of_drive && effect.place.kind == PlaceKind::kJoint) lossy.insert(e.robot.tree.joint(effect.place.index).name);
  }
  return !judged.empty() && static_cast<double>(lossy.size()) >= kEveryDrive * static_cast<double>(judged.size());
}

// Reason why no motion can be proposed; empty if one can.
std::string find_obstacle(const Experiment& e) {
  if (e.num_joints() == 0) return "The robot has no joints.";
  if (e.scenario.drive != "servo" && e.scenario.drive != "voltage" && !is_effort_driven(e))
    return "The recordings are driven by " + e.scenario.drive +
           ", not by commands to servos: no command can be proposed without the servo's gains.";
  for (int j = 0; j < e.num_joints() && is_effort_driven(e); ++j) {
    const JointSpec& joint = e.robot.tree.joint(j);
    if (!joint.actuated) return joint.name + " has no drive: no motion of it can be commanded.";
  }
  for (const JointColumns& joint : e.recordings[0].joints) {
    if (joint.has(Quantity::kPosition)) return "";
  }
  return "No joint position was recorded.";
}

Next propose_fixed(const Experiment& e, const Json& report, const NextOptions& options, const Progress& progress) {
  Next next;
  next.nothing = find_obstacle(e);
  if (!next.nothing.empty()) return next;
  if (is_effort_driven(e) || has_losses_everywhere(e, report)) return propose_by_torque(e, report, options, progress);
  return Proposer(e, options, progress).run(report);
}

}  // namespace

Next propose(const Experiment& experiment, const Json& report, const NextOptions& options, const Progress& progress) {
  const bool floating = experiment.scenario.floating_base;
  Next next = floating ? propose_stance(experiment, report, options, progress)
                       : propose_fixed(experiment, report, options, progress);
  if (!next.nothing.empty()) next.words = list_motion_words(report);
  return next;
}

}  // namespace hrp::diagnosis
