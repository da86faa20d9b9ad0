// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/best_model.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/effort_rows.h"
#include "diagnosis/evidence/plain_model.h"
#include "diagnosis/evidence/polish.h"
#include "diagnosis/findings/odd_sizes.h"
#include "diagnosis/measurement/torque/residual.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/report/report.h"

namespace hrp::diagnosis {
namespace {

// Exponent [1] of the penalty for a model that is worse than plain least squares in one of the two errors. A model that
// is 5 % worse in one error must be about 22 % better in the other (1.05^-5) to have the same cost.
constexpr double kWorse = 4.0;

// Adds the sensor faults of `of`, because the servo's law and comparisons of columns determine them whatever else is in
// the model. The delay of an effort log is left out: it is not determined that way.
Hypothesis add_logs(Hypothesis model, const Hypothesis& of) {
  for (const Effect& e : of) {
    const bool told = e.id != EffectId::kSensorDelay || e.place.reading != Reading::kEffort;
    if (e.place.kind == PlaceKind::kSensor && told && !contains(model, e.id, e.place)) model.push_back(e);
  }
  return model;
}

// Mean of the parameters of two fits of the same effects. Effects that `b` lacks keep the parameters of `a`. Parameters
// that are scanned over decades have no mean: those of `b` stay.
Hypothesis find_middle(Hypothesis a, const Hypothesis& b) {
  for (Effect& effect : a) {
    const auto other =
        std::find_if(b.begin(), b.end(), [&](const Effect& e) { return e.id == effect.id && e.place == effect.place; });
    for (size_t i = 0; other != b.end() && i < effect.p.size(); ++i)
      effect.p[i] = list_infos(effect.id)[i].scanned ? other->p[i] : 0.5 * (effect.p[i] + other->p[i]);
  }
  return a;
}

// Effects of `of` whose family `model` does not have at the same place.
Hypothesis list_other_families(const Hypothesis& model, const Hypothesis& of) {
  Hypothesis others;
  for (const Effect& e : of) {
    const auto is_alike = [&](const Effect& own) {
      return own.place == e.place && get_effect(own.id).family == get_effect(e.id).family;
    };
    if (std::none_of(model.begin(), model.end(), is_alike)) others.push_back(e);
  }
  return others;
}

// Held-out errors [1]: root mean square over the joints, each relative to the spread of the joint's signal.
constexpr double kNoError = 1e300;  // nothing was compared
struct Errors {
  double position = kNoError, effort = kNoError;
  std::vector<double> positions, efforts;  // by joint, in the signal's unit; NaN: not compared
};

// ", efforts miss 3 % of their spread"; empty if nothing was compared: joints without a drive have no effort, and a
// recording shorter than a window has no positions to compare.
std::string describe_miss(const char* what, double error) {
  return error < kNoError ? std::string(what) + " miss " + number(100.0 * error, 3) + " % of their spread" : "";
}

// A model that was compared.
struct Compared {
  Hypothesis hypothesis;
  Errors errors;
};

double join(const Problem& problem, const std::vector<double>& rms, Quantity quantity,
            const std::vector<double>& spreads) {
  double sum = 0.0, n = 0.0;
  for (size_t j = 0; j < rms.size(); ++j) {
    const bool driven = quantity == Quantity::kEffort;
    const double spread =
        driven ? spreads[j] : calc_channel_spread(*problem.experiment, get_judged(problem), j * kQuantities);
    if ((driven ? spread > 0.0 : does_move(spread)) && std::isfinite(rms[j])) {
      sum += rms[j] * rms[j] / (spread * spread);
      n += 1.0;
    }
  }
  return n > 0.0 ? std::sqrt(sum / n) : kNoError;
}

bool has_same_links(const Hypothesis& model, const Hypothesis& links) {
  const Hypothesis own = take_links(model);
  const auto is_same = [](const Effect& a, const Effect& b) {
    return a.id == b.id && a.place == b.place && a.p == b.p;
  };
  return std::equal(own.begin(), own.end(), links.begin(), links.end(), is_same);
}

class Chooser {
 public:
  Chooser(const Problem& problem, const Problem& whole, const Hypothesis& model, double explained,
          const std::function<void(const std::string&)>& progress)
      : problem_(problem),
        whole_(whole),
        model_(model),
        settled_(explained >= 1.0 - kTrace),
        progress_(progress),
        data_(make_torque_data(*whole.experiment)),
        rows_(*whole.experiment, data_) {
    spreads_ = find_effort_spreads();
  }

  Trial run(const Hypothesis& searched) {
    const Hypothesis plain = add_logs(make_plain_model(fit_plain_model(whole_)), model_),
                     geared = add_logs(make_plain_model(fit_plain_model(whole_, true)), model_);
    reference_ = calc_errors(simulate_trial(whole_, plain));
    consider("the nominal model", add_logs({}, model_));
    consider("parameters of the missing torque", model_);
    const double without = consider("friction and rotors by least squares", plain);
    const double with = consider("friction, rotors and gears by least squares", geared);
    const Hypothesis start = settled_ ? Hypothesis{} : find_preslidings(problem_, with < without ? geared : plain);
    if (is_effort_driven(*whole_.experiment)) {
      const CalcResiduals windows = make_window_residuals(whole_);
      const Hypothesis fitted = fit_both(windows, model_, kRounds);
      consider("fitted through short windows", fitted);
      consider("half way there", find_middle(model_, fitted));
      if (!settled_) consider("least squares, fitted through them", fit_both(windows, start, kRounds));
    }
    const Hypothesis fitted = polish_joints(problem_, model_, &data_);
    consider("fitted through each joint's simulation", fitted);
    consider("half way there", find_middle(model_, fitted));  // errors of both fits tend to have opposite signs
    if (!settled_) consider("least squares, fitted through it", polish_joints(problem_, start, &data_));
    if (!searched.empty()) consider_searched(split_asymmetry(searched), plain);
    consider("the best of these with richer laws", polish_joints(problem_, best_.hypothesis, &data_, true));
    consider("the best of these at each joint", mix_joints());
    if (!is_effort_driven(*whole_.experiment)) {
      consider("the best of these, fitted through the whole robot",
               fit_both(make_residuals(whole_), best_.hypothesis, kFewRounds));
    } else if (!settled_) {
      consider("the same, fitted to positions alone", polish_joints(problem_, best_.hypothesis, nullptr, true));
      consider("least squares with richer laws, fitted to positions alone",
               polish_joints(problem_, start, nullptr, true));
    }
    return best_.validate.ok ? best_ : simulate_trial(whole_, model_);
  }

 private:
  // The report does not name the effects of this model, so it must be clearly better (`kNearlyAll`) than models of
  // friction, rotors and gears. A search finds few effects; drives also have friction and rotors. Therefore the second
  // candidate adds them.
  void consider_searched(const Hypothesis& searched, const Hypothesis& plain) {
    consider("the model of the search", searched, kNearlyAll);
    const Hypothesis others = list_other_families(searched, plain);
    if (others.empty()) return;
    Hypothesis joined = searched;
    joined.insert(joined.end(), others.begin(), others.end());
    consider("the same beside friction and rotors", polish_joints(problem_, joined, &data_), kNearlyAll);
  }

  Hypothesis fit_both(const CalcResiduals& residuals, const Hypothesis& start, int iterations) const {
    return polish_whole(whole_, start, rows_.add_to(residuals, whole_.train, start), iterations);
  }

  std::vector<double> find_effort_spreads() const {
    std::vector<double> spreads(static_cast<size_t>(whole_.experiment->num_joints()), 0.0);
    for (size_t j = 0; j < spreads.size(); ++j) {
      Spread spread;
      for (const TorqueRecording& r : data_.recordings) {
        for (double y : r.effort.col(static_cast<long>(j))) spread.add(y);
      }
      spreads[j] = spread.get();
    }
    return spreads;
  }

  Errors calc_errors(const Trial& trial) const {
    if (!trial.validate.ok) return {};
    std::vector<double> positions;
    if (is_effort_driven(*whole_.experiment)) positions = calc_held_windows(whole_, trial.hypothesis).rms;
    for (size_t j = 0; positions.size() < spreads_.size() && j < spreads_.size(); ++j)
      positions.push_back(trial.validate.rms(j * kQuantities) / whole_.weights[j * kQuantities]);
    const std::vector<double> efforts =
        calc_torque_residuals(data_, make_plant(*whole_.experiment, trial.hypothesis), !whole_.validate.empty());
    return {join(whole_, positions, Quantity::kPosition, spreads_), join(whole_, efforts, Quantity::kEffort, spreads_),
            positions, efforts};
  }

  // The drives of several models: at each joint those with the lowest product of the joint's own two errors. Only
  // models with the links of the best one compete, because a link's effects change what every drive has to give.
  Hypothesis mix_joints() const {
    const Hypothesis links = take_links(best_.hypothesis);
    Hypothesis mixed = links;
    for (size_t j = 0; j < spreads_.size(); ++j) {
      const Compared* chosen = nullptr;
      double least = kNoError;
      for (const Compared& one : compared_) {
        const double cost = calc_joint_cost(one.errors, j);
        if (cost < least && has_same_links(one.hypothesis, links)) {
          chosen = &one;
          least = cost;
        }
      }
      const Hypothesis own = take_joint(chosen ? chosen->hypothesis : best_.hypothesis, static_cast<int>(j));
      mixed.insert(mixed.end(), own.begin(), own.end());
    }
    return mixed;
  }

  static double calc_joint_cost(const Errors& errors, size_t j) {
    const bool driven = j < errors.efforts.size() && std::isfinite(errors.efforts[j]);
    return j < errors.positions.size() ? errors.positions[j] * (driven ? errors.efforts[j] : 1.0) : kNoError;
  }

  // Product [1] of position error and effort error, each relative to plain least squares, with a penalty where one is
  // worse.
  double calc_cost(const Errors& e) const {
    const double position = e.position / reference_.position, effort = e.effort / reference_.effort;
    return position * effort * std::pow(std::max({1.0, position, effort}), kWorse);
  }

  // The model replaces the best one if its cost is below `share` times the lowest cost so far. Returns the cost.
  double consider(const char* name, const Hypothesis& hypothesis, double share = 1.0) {
    const std::string odd = find_odd_effect(*whole_.experiment, hypothesis, model_);
    if (!odd.empty()) {
      progress_("    " + std::string(name) + ": hardly possible (" + odd + ")");
      return kNoError;
    }
    if (!list_other_families(hypothesis, model_).empty()) share = std::min(share, kNearlyAll);
    const Trial trial = simulate_trial(whole_, hypothesis);
    const Errors errors = calc_errors(trial);
    if (!trial.validate.ok) return kNoError;
    compared_.push_back({hypothesis, errors});
    progress_("    " + std::string(name) + ": held out" + describe_miss(", positions", errors.position) +
              describe_miss(", efforts", errors.effort));
    const double cost = calc_cost(errors);
    if (cost < share * least_) {
      best_ = trial;
      least_ = cost;
    }
    return cost;
  }

  const Problem &problem_, &whole_;
  const Hypothesis model_;  // displacements before slipping are those of the simulation
  const bool settled_;      // the model leaves hardly a trace of the missing torque
  const std::function<void(const std::string&)>& progress_;
  const TorqueData data_;
  const EffortRows rows_;
  std::vector<double> spreads_;  // [N m] standard deviation of each joint's effort
  Errors reference_;
  std::vector<Compared> compared_;
  Trial best_;
  double least_ = kNoError;
};

// Share [1] of a joint's logged effort that its drive gives, as root mean squares along the recordings. A limit far
// below the efforts takes the drive away: the missing torque is small then, but only as all torques are. 1 without a
// log.
double calc_given_share(const Experiment& e, const JointLaws& laws, size_t joint) {
  double logged = 0.0, given = 0.0;
  for (const Recording& r : e.recordings) {
    const JointColumns& c = r.joints[joint];
    if (!c.has(Quantity::kEffort) || !c.has(Quantity::kVelocity)) continue;
    for (size_t k = 0; k < r.size(); ++k) {
      const double effort = laws.torque_scale * c.signal[2][k],
                   torque = calc_given_torque(laws, c.signal[2][k], c.signal[1][k]);
      if (std::isfinite(effort + torque)) {
        logged += effort * effort;
        given += torque * torque;
      }
    }
  }
  return logged > 0.0 ? std::sqrt(given / logged) : 1.0;
}

}  // namespace

std::string find_odd_effect(const Experiment& e, const Hypothesis& model, const Hypothesis& named) {
  for (const Effect& effect : model) {
    if (contains(named, effect.id, effect.place)) continue;
    const std::string name = get_effect(effect.id).name;
    if (get_effect(effect.id).family == EffectFamily::kLimits && effect.place.kind == PlaceKind::kJoint) {
      const auto j = static_cast<size_t>(effect.place.index);
      const double share = calc_given_share(e, make_plant(e, model).laws[j], j);
      if (share < std::exp(-kFactor))
        return name + ": a drive that gives a factor of " + number(share, 3) + " of its logged effort";
    }
    const std::string why =
        find_odd_size(e.robot.tree, {{"effect", name},
                                     {"where", make_where(e, effect)},
                                     {"parameters", make_estimates(list_estimates(e, effect, {}))}});
    if (!why.empty()) return name + ": " + why;
  }
  return "";
}

Trial simulate_trial(const Problem& problem, const Hypothesis& hypothesis) {
  Trial trial;
  trial.hypothesis = hypothesis;
  trial.refined = true;
  trial.train = calc_score(problem, hypothesis, problem.train);
  trial.validate = calc_score(problem, hypothesis, get_judged(problem));
  trial.rms = trial.validate.rms();
  trial.worst = trial.validate.worst();
  for (const Effect& effect : hypothesis) trial.std.emplace_back(effect.p.size(), 0.0);
  return trial;
}

WindowErrors calc_held_windows(const Problem& problem, const Hypothesis& hypothesis) {
  return calc_window_errors(make_plant(*problem.experiment, hypothesis), *problem.experiment, problem.smooth,
                            get_judged(problem), problem.jobs);
}

Trial choose_best_model(const Problem& problem, const Problem& whole, const Hypothesis& model, double explained,
                        const Hypothesis& searched, const std::function<void(const std::string&)>& progress) {
  // Efforts along the recorded motion would prefer a model with the ripples of their logs.
  return Chooser(problem, whole, drop_ripples_of_logs(problem, find_preslidings(problem, model)), explained, progress)
      .run(searched);
}

}  // namespace hrp::diagnosis
