// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/additions.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/slopes.h"
#include "diagnosis/search/regression.h"
#include "diagnosis/search/screen.h"
#include "diagnosis/search/significance.h"
#include "diagnosis/search/step_error.h"

namespace hrp::diagnosis {
namespace {

constexpr size_t kTrain = 2, kHeld = 1;  // numbers of recordings: enough to rank

// Small steps of an effect at one place. `make_start` converts the step sizes that fit the residual to parameters.
struct Probe {
  std::vector<Effect> steps;
  std::function<bool(const Eigen::VectorXd& x, std::vector<double>* p)> make_start;
};

// Rms of a joint's motion and effort over the training recordings.
struct Activity {
  double effort = 0.0, position = 0.0, rate = 0.0, acceleration = 0.0;
};

std::vector<Activity> measure_activity(const Problem& problem) {
  const Experiment& e = *problem.experiment;
  const Plant plant = make_plant(e, {});
  const long n = e.num_joints();
  std::vector<Activity> list(static_cast<size_t>(n));
  double count = 0.0;
  constexpr size_t kThin = 10;  // one of so many rows: means of a recording need no more
  for (int r : problem.train) {
    const std::vector<SmoothJoint>& joints = problem.smooth[static_cast<size_t>(r)].joints;
    const long rows = static_cast<long>(joints[0].q.size() / kThin);
    Eigen::MatrixXd q(rows, n), qd(rows, n), qdd(rows, n);
    for (long k = 0; k < rows; ++k) {
      for (long j = 0; j < n; ++j) {
        const SmoothJoint& joint = joints[static_cast<size_t>(j)];
        const size_t at = static_cast<size_t>(k) * kThin;
        q(k, j) = joint.q[at];
        qd(k, j) = joint.qd[at];
        qdd(k, j) = joint.qdd[at];
      }
    }
    const Eigen::MatrixXd effort = calc_efforts(plant, q, qd, qdd);
    for (long j = 0; j < n; ++j) {
      Activity& a = list[static_cast<size_t>(j)];
      a.effort += effort.col(j).squaredNorm();
      a.position += q.col(j).squaredNorm();
      a.rate += qd.col(j).squaredNorm();
      a.acceleration += qdd.col(j).squaredNorm();
    }
    count += static_cast<double>(rows);
  }
  for (Activity& a : list) {
    for (double* value : {&a.effort, &a.position, &a.rate, &a.acceleration})
      *value = std::max(1e-6, std::sqrt(*value / std::max(1.0, count)));
  }
  return list;
}

class Probes {
 public:
  explicit Probes(const Problem& problem) : e_(*problem.experiment), activity_(measure_activity(problem)) {
    for (int j = 0; j < e_.num_joints(); ++j) {
      if (!e_.robot.tree.joint(j).actuated) continue;
      add_joint(j);
      add_sensors(j);
    }
    for (int link = 1; link < e_.robot.tree.num_joints() + 1; ++link) add_link(link);
    for (const EffectInfo& row : list_effects()) {
      if (row.place == PlaceKind::kSensor && row.parameters[0].probe > 0.0 && !row.change.any())
        add(row, at_all(), row.parameters[0].probe);
    }
  }

  // Ripples over position: no small step finds their wave number, so the best one of the missing effort is used.
  void add_ripples(const Effect& start) {
    const EffectInfo& row = get_effect(start.id);
    const double shape = start.p[static_cast<size_t>(row.periods)];
    const double size = kTrace * activity_[static_cast<size_t>(start.place.index)].effort;
    const auto make = [&row, shape, start](double sine, double cosine) {
      const double x[] = {sine, cosine};
      Effect step = start;
      row.torque.make_parameters(x, &shape, step.p.data());
      return step;
    };
    list_.push_back(
        {{make(size, 0.0), make(0.0, size)}, [make, size](const Eigen::VectorXd& x, std::vector<double>* p) {
           *p = make(size * x[0], size * x[1]).p;
           return true;
         }});
  }

  const std::vector<Probe>& list() const { return list_; }

 private:
  // Steps the first parameter from its neutral value; `rest` are the others.
  void add(const EffectInfo& row, const Place& place, double step, std::vector<double> rest = {}) {
    const double none = row.parameters[0].neutral, low = row.parameters[0].low, high = row.parameters[0].high;
    Effect effect{row.id, place, {none + step}};
    effect.p.insert(effect.p.end(), rest.begin(), rest.end());
    list_.push_back({{effect}, [=](const Eigen::VectorXd& x, std::vector<double>* p) {
                       *p = effect.p;
                       (*p)[0] = none + x[0] * step;
                       return (*p)[0] > low && (*p)[0] < high;
                     }});
  }

  // Steps each component of a vector from zero.
  void add_vector(const EffectInfo& row, const Place& place, double step) {
    Probe probe;
    for (size_t i = 0; i < 3; ++i) {
      probe.steps.push_back({row.id, place, {0.0, 0.0, 0.0}});
      probe.steps.back().p[i] = step;
    }
    probe.make_start = [step](const Eigen::VectorXd& x, std::vector<double>* p) {
      *p = {step * x[0], step * x[1], step * x[2]};
      return true;
    };
    list_.push_back(probe);
  }

  // Uses the steps that the row lists.
  void add_steps(const EffectInfo& row, const Place& place, double size) {
    Probe probe;
    for (const std::vector<double>& p : row.probe.list(size)) probe.steps.push_back({row.id, place, p});
    probe.make_start = [&row, size](const Eigen::VectorXd& x, std::vector<double>* p) {
      return row.probe.combine(x.data(), size, p->data());
    };
    list_.push_back(probe);
  }

  // Steps the laws of one parameter by as much as makes a share of a typical effort.
  void add_joint(int j) {
    const Activity& a = activity_[static_cast<size_t>(j)];
    const double effort = kTrace * a.effort;
    const JointSample typical{a.position, a.rate, a.acceleration, 1.0, a.effort, effort / kTimeStep};
    for (const EffectInfo& row : list_effects()) {
      if (row.place != PlaceKind::kJoint) continue;
      const Place place = at_joint(j);
      if (row.probe.list) {
        add_steps(row, place, effort / a.position);
      } else if (row.parameters[0].probe > 0.0) {
        add(row, place, row.parameters[0].probe);
      } else if (row.torque.advance) {
        for (size_t i = 0; i < row.torque.shapes.size(); i += 2) {
          const double shape = row.torque.shapes[i][0];
          add(row, place, effort / shape, {shape});
        }
      } else if (row.linear && row.torque.num_columns == 1) {
        double column = 0.0;
        row.torque.calc_columns(typical, nullptr, &column);
        std::vector<double> rest;
        for (size_t i = 1; i < row.parameters.size(); ++i) rest.push_back(row.parameters[i].value);
        add(row, place, effort / column, rest);
      }
    }
  }

  void add_sensors(int j) {
    for (int quantity = 0; quantity < kQuantities; ++quantity) {
      const auto& noise = e_.joint_noise[static_cast<size_t>(j)][static_cast<size_t>(quantity)];
      if (!(noise.sigma > 0.0)) continue;
      for (const EffectInfo& row : list_effects()) {
        const double step = row.parameters[0].probe;
        if (row.change.any()) add(row, at_signal(j * kQuantities + quantity), step > 0.0 ? step : noise.sigma);
      }
    }
  }

  void add_link(int link) {
    const double mass = e_.robot.tree.links[static_cast<size_t>(link)].inertia.mass;
    for (const EffectInfo& row : list_effects()) {
      if (row.place != PlaceKind::kLink) continue;
      const bool possible = mass > 0.0 || !(row.of_whole_link || row.probe.list);
      const double step = row.parameters[0].probe;
      if (possible && row.probe.list)
        add_steps(row, at_link(link), kTrace * mass);
      else if (possible && step > 0.0 && row.vector)
        add_vector(row, at_link(link), step);
      else if (possible && step > 0.0)
        add(row, at_link(link), step);
    }
  }

  const Experiment& e_;
  std::vector<Activity> activity_;
  std::vector<Probe> list_;
};

using Columns = std::vector<std::vector<double>>;

// Residuals of one recording and their derivatives with respect to the fitted parameters.
struct Base {
  std::vector<double> residuals, coarse;  // with the problem's steps; with coarser ones
  Columns columns;
};

// Adds sums of products of [columns of fitted parameters, steps, residual].
void add_products(const Base& base, const Columns& steps, Eigen::MatrixXd* gram) {
  std::vector<const std::vector<double>*> all;
  for (const auto& column : base.columns) all.push_back(&column);
  for (const auto& column : steps) all.push_back(&column);
  all.push_back(&base.residuals);
  const long size = static_cast<long>(all.size());
  if (gram->size() == 0) gram->setZero(size, size);
  for (long i = 0; i < size; ++i) {
    for (long j = 0; j <= i; ++j) {
      const std::vector<double>&a = *all[static_cast<size_t>(i)], &b = *all[static_cast<size_t>(j)];
      (*gram)(i, j) += std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
      (*gram)(j, i) = (*gram)(i, j);
    }
  }
}

// Regresses the residual on the first `size` columns.
Regression regress(const Eigen::MatrixXd& gram, long size) {
  return solve_gram(gram.topLeftCorner(size, size), -gram.col(gram.rows() - 1).head(size));
}

// Decrease of chi2 for the step sizes x.
double calc_drop(const Eigen::MatrixXd& gram, const Eigen::VectorXd& x) {
  const long size = x.size(), last = gram.rows() - 1;
  return -2.0 * x.dot(gram.col(last).head(size)) - x.dot(gram.topLeftCorner(size, size) * x);
}

// Keeps only the best start of each effect and place.
void drop_copies(std::vector<Addition>* ranked) {
  std::vector<Addition> kept;
  for (const Addition& addition : *ranked) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Addition& k) {
      return k.start.id == addition.start.id && k.start.place == addition.start.place;
    });
    if (!known) kept.push_back(addition);
  }
  *ranked = kept;
}

class Ranker {
 public:
  Ranker(const Problem& problem, const Hypothesis& fitted)
      : problem_(problem), fitted_(fitted), options_(problem.options) {
    if (std::none_of(fitted.begin(), fitted.end(), [](const Effect& e) { return sticks(e.id); }))
      options_.max_step *= kFiner;  // differences need less accuracy than readings
    take(problem.train, kTrain);
    trained_ = recordings_.size();
    take(problem.validate, kHeld);
  }

  std::vector<Addition> run() {
    std::vector<Addition> ranked;
    if (!make_base()) return ranked;
    Probes probes(problem_);
    for (const Candidate& c : screen(problem_, fitted_).candidates) {
      if (get_effect(c.start.id).torque.shape_from_data) probes.add_ripples(c.start);
    }
    std::vector<Addition> all(probes.list().size());
    parallel_for(problem_.jobs, static_cast<int>(all.size()),
                 [&](int i) { all[static_cast<size_t>(i)] = try_probe(probes.list()[static_cast<size_t>(i)]); });
    for (const Addition& addition : all) {
      if (addition.gain > 0.0) ranked.push_back(addition);
    }
    std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.gain > b.gain; });
    drop_copies(&ranked);
    return ranked;
  }

 private:
  void take(const std::vector<int>& from, size_t most) {
    recordings_.insert(recordings_.end(), from.begin(), from.begin() + static_cast<long>(std::min(most, from.size())));
  }

  // Factor from a sum over some recordings to one over all.
  static double scale_up(const std::vector<int>& all, size_t used) {
    return used == 0 ? 0.0 : static_cast<double>(all.size()) / static_cast<double>(used);
  }

  bool make_base() {
    const std::vector<Move> moves = list_moves(fitted_);
    bases_.resize(recordings_.size());
    std::vector<char> ok(recordings_.size(), 1);
    parallel_for(problem_.jobs, static_cast<int>(recordings_.size()), [&](int i) {
      const size_t r = static_cast<size_t>(i);
      Base& base = bases_[r];
      base.columns.resize(moves.size());
      ok[r] = calc_residuals(problem_, fitted_, recordings_[r], &base.residuals) &&
              simulate(fitted_, options_, r, &base.coarse);
      for (size_t m = 0; m < moves.size() && ok[r]; ++m)
        ok[r] = calc_column(moves[m].hypothesis, moves[m].delta, r, &base.columns[m]);
    });
    return std::all_of(ok.begin(), ok.end(), [](char c) { return c != 0; });
  }

  bool simulate(const Hypothesis& hypothesis, const RolloutOptions& options, size_t r,
                std::vector<double>* residuals) const {
    const size_t recording = static_cast<size_t>(recordings_[r]);
    const StartState* start = problem_.starts.empty() ? nullptr : &problem_.starts[recording];
    return calc_residuals(problem_, hypothesis, recordings_[r], options, start, residuals);
  }

  // Differences must be of simulations with the same steps. Coarse steps miss dry friction, so it uses fine ones.
  bool calc_column(const Hypothesis& moved, double delta, size_t r, std::vector<double>* column) const {
    const bool fine = sticks(moved.back().id);
    const std::vector<double>& from = fine ? bases_[r].residuals : bases_[r].coarse;
    if (!simulate(moved, fine ? problem_.options : options_, r, column)) return false;
    for (size_t k = 0; k < column->size(); ++k) (*column)[k] = ((*column)[k] - from[k]) / delta;
    return true;
  }

  Addition try_probe(const Probe& probe) const {
    Addition addition;
    Eigen::MatrixXd train, held;
    for (size_t r = 0; r < recordings_.size(); ++r) {
      Columns columns(probe.steps.size());
      for (size_t i = 0; i < columns.size(); ++i) {
        Hypothesis moved = fitted_;
        moved.push_back(probe.steps[i]);
        if (!calc_column(moved, 1.0, r, &columns[i])) return addition;
      }
      add_products(bases_[r], columns, r < trained_ ? &train : &held);
    }
    const long before = static_cast<long>(bases_[0].columns.size());
    const long size = before + static_cast<long>(probe.steps.size());
    const Regression without = regress(train, before), with = regress(train, size);
    addition.start = probe.steps[0];
    if (!probe.make_start(with.x.tail(size - before), &addition.start.p)) return addition;
    double gain = scale_up(problem_.train, trained_) * (with.gain - without.gain);
    if (held.size() > 0) {
      const double helps = calc_drop(held, with.x) - calc_drop(held, without.x);
      if (helps < 0.0) return addition;
      gain += scale_up(problem_.validate, recordings_.size() - trained_) * helps;
    }
    addition.gain = gain;
    return addition;
  }

  const Problem& problem_;
  const Hypothesis& fitted_;
  RolloutOptions options_;
  std::vector<int> recordings_;
  size_t trained_ = 0;       // number of training recordings, which come first
  std::vector<Base> bases_;  // by recording
};

}  // namespace

std::vector<Addition> rank_additions(const Problem& problem, const Hypothesis& fitted) {
  return Ranker(problem, fitted).run();
}

}  // namespace hrp::diagnosis
