// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/links/model.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "common/base/has.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/links/columns.h"
#include "diagnosis/model/link_reach.h"

namespace hrp::diagnosis {
namespace {

constexpr double kMostSamples = 8000;  // samples of all recordings together

Columns list_columns(const LinkDesign& design, const LinkTerms& model) {
  Columns columns;
  for (size_t t : model) {
    for (long c = 0; c < design.terms[t].columns; ++c) columns.push_back(design.terms[t].first + c);
  }
  return columns;
}

std::vector<Eigen::VectorXd> split(const LinkDesign& design, const LinkTerms& model, const Eigen::VectorXd& theta) {
  std::vector<Eigen::VectorXd> out;
  long at = 0;
  for (size_t t : model) {
    out.push_back(theta.segment(at, design.terms[t].columns));
    at += design.terms[t].columns;
  }
  return out;
}

// Sum of the groups' normal equations. Weights: independent samples over all samples, divided by the group's mean
// square.
Gram weigh(const LinkDesign& design, const std::vector<double>& square,
           const std::function<const Gram*(const LinkGroup&)>& pick) {
  Gram out(design.width);
  for (size_t g = 0; g < design.groups.size(); ++g) {
    const LinkGroup& group = design.groups[g];
    double n = 0.0;
    for (const Gram& fold : group.train) n += fold.n;
    if (const Gram* gram = pick(group); gram && n > 0.0)
      out.add(*gram, group.effective / (n * std::max(square[g], group.floor)));
  }
  return out;
}

// Normal equations of all groups, weighted.
struct Weighted {
  std::vector<Gram> folds;
  Gram total;
};

Weighted weigh_folds(const LinkDesign& design, const std::vector<double>& square) {
  Weighted w;
  for (size_t f = 0; f < design.groups[0].train.size(); ++f)
    w.folds.push_back(weigh(design, square, [f](const LinkGroup& g) { return &g.train[f]; }));
  w.total = sum(w.folds, design.width);
  return w;
}

// Mean square by group without any term.
std::vector<double> list_nominal(const LinkDesign& design) {
  std::vector<double> out;
  for (const LinkGroup& group : design.groups) {
    double c = 0.0, n = 0.0;
    for (const Gram& fold : group.train) {
      c += fold.c;
      n += fold.n;
    }
    out.push_back(n > 0.0 ? c / n : 0.0);
  }
  return out;
}

std::vector<double> cross_validate_groups(const LinkDesign& design, const Weighted& w, const Columns& columns) {
  std::vector<double> rest(design.groups.size(), 0.0), n(rest);
  for (size_t f = 0; f < w.folds.size(); ++f) {
    Gram others = w.total;
    others.add(w.folds[f], -1.0);
    const Eigen::VectorXd theta = solve(others, columns);
    for (size_t g = 0; g < rest.size(); ++g) {
      rest[g] += calc_rest(design.groups[g].train[f], columns, theta);
      n[g] += design.groups[g].train[f].n;
    }
  }
  for (size_t g = 0; g < rest.size(); ++g) rest[g] = n[g] > 0.0 ? rest[g] / n[g] : 0.0;
  return rest;
}

double calc_evidence(const LinkDesign& design, const LinkTerms& model, const std::vector<double>& cross) {
  double evidence = 0.0;
  for (size_t g = 0; g < cross.size(); ++g)
    evidence -= 0.5 * design.groups[g].effective * std::log(std::max({cross[g], design.groups[g].floor, 1e-300}));
  for (size_t t : model) evidence -= design.terms[t].row->get_cost(design.terms[t].columns);
  return evidence;
}

// Result of one fit with given weights.
struct Trial {
  double evidence = -std::numeric_limits<double>::infinity();
  std::vector<double> cross;
  bool physical = false;
};

Trial judge(const LinkDesign& design, const LinkTerms& model, const Weighted& w) {
  Trial trial;
  const Columns columns = list_columns(design, model);
  const std::vector<Eigen::VectorXd> theta = split(design, model, solve(w.total, columns));
  for (size_t i = 0; i < model.size(); ++i) {
    if (!is_physical(design, design.terms[model[i]], theta[i])) return trial;
  }
  trial.physical = true;
  trial.cross = cross_validate_groups(design, w, columns);
  trial.evidence = calc_evidence(design, model, trial.cross);
  return trial;
}

class Chooser {
 public:
  explicit Chooser(const LinkDesign& design) : design_(design) { accept({}); }

  LinkTerms run() {
    for (int round = 0; round < kRounds; ++round) {
      const bool grown = add();
      const bool changed = exchange() || remove();
      if (!grown && !changed) break;
    }
    return model_;
  }

 private:
  // Accepts a model and updates the weights to its residuals.
  void accept(const LinkTerms& model) {
    model_ = model;
    if (square_.empty()) square_ = list_nominal(design_);
    for (int i = 0; i < 2; ++i) {
      weighted_ = weigh_folds(design_, square_);
      const Trial trial = judge(design_, model_, weighted_);
      if (!trial.physical) break;
      square_ = trial.cross;
      evidence_ = trial.evidence;
    }
  }

  bool take_best(const std::vector<LinkTerms>& candidates, double least) {
    double best = evidence_ + least;
    const LinkTerms* chosen = nullptr;
    for (const LinkTerms& candidate : candidates) {
      const Trial trial = judge(design_, candidate, weighted_);
      if (trial.evidence > best) {
        best = trial.evidence;
        chosen = &candidate;
      }
    }
    if (!chosen) return false;
    accept(*chosen);
    return true;
  }

  bool add() {
    std::vector<LinkTerms> candidates;
    for (size_t t = 0; t < design_.terms.size(); ++t) {
      if (has(model_, t)) continue;
      candidates.push_back(model_);
      candidates.back().push_back(t);
    }
    return take_best(candidates, kOdds);
  }

  bool exchange() {
    std::vector<LinkTerms> candidates;
    for (size_t i = 0; i < model_.size(); ++i) {
      for (size_t t = 0; t < design_.terms.size(); ++t) {
        if (has(model_, t)) continue;
        candidates.push_back(model_);
        candidates.back()[i] = t;
      }
    }
    return take_best(candidates, 0.1);
  }

  bool remove() {
    std::vector<LinkTerms> candidates;
    for (size_t i = 0; i < model_.size(); ++i) {
      candidates.push_back(model_);
      candidates.back().erase(candidates.back().begin() + static_cast<long>(i));
    }
    return take_best(candidates, -kOdds);
  }

  const LinkDesign& design_;
  LinkTerms model_;
  std::vector<double> square_;  // by group: mean square that the model leaves
  Weighted weighted_;
  double evidence_ = 0.0;
};

class DesignMaker {
 public:
  DesignMaker(const LinkData& data, const LinkSensors& sensors, LinkReadings* readings, const LinkPoints& points)
      : data_(data), readings_(*readings) {
    design_.readings = readings;
    design_.experiment = data.experiment;
    design_.terms = list_link_terms(data, sensors, *readings, points);
    for (const LinkTerm& term : design_.terms) design_.width += term.columns;
    for (const ReadingGroup& group : readings->groups()) {
      design_.groups.emplace_back();
      design_.groups.back().reading = group;
    }
  }

  LinkDesign make() {
    long samples = 0;
    for (const LinkRecording& r : data_.recordings) samples += r.q.rows() / std::max(1L, r.stride);
    const long thin = std::max(1L, std::lround(static_cast<double>(samples) / kMostSamples));
    for (LinkRecording r : data_.recordings) {
      r.stride *= thin;
      add(r);
    }
    for (size_t g = 0; g < design_.groups.size(); ++g) finish(g);
    drop_silent_terms();
    return std::move(design_);
  }

 private:
  void add(const LinkRecording& r) {
    const std::vector<Eigen::MatrixXd> columns = calc_link_columns(r, design_.terms, *data_.experiment, &readings_);
    const long kept = static_cast<long>(columns.size());
    design_.has_held = design_.has_held || !r.train;
    for (LinkGroup& group : design_.groups) {
      std::vector<Gram> parts(static_cast<size_t>(kStretches), Gram(design_.width));
      for (long k = 0; k < kept; ++k) {
        const long row = r.trim + k * r.stride;
        Gram& part = parts[static_cast<size_t>(kStretches * k / std::max(1L, kept))];
        const auto x = columns[static_cast<size_t>(k)].middleRows(group.reading.first, group.reading.size);
        const Eigen::VectorXd y = (r.read - r.predicted).row(row).segment(group.reading.first, group.reading.size);
        part.G.selfadjointView<Eigen::Lower>().rankUpdate(x.transpose());
        part.b += x.transpose() * y;
        part.c += y.squaredNorm();
        part.n += static_cast<double>(y.size());
      }
      group.alone.push_back(sum(parts, design_.width));
      if (r.train)
        group.train.insert(group.train.end(), parts.begin(), parts.end());
      else
        group.held.push_back(group.alone.back());
    }
    rows_.push_back(columns);
    used_.push_back(r);
  }

  // Finds spread and noise of the readings. The correlation time of the residual of all terms gives the independent
  // samples.
  void finish(size_t g) {
    LinkGroup& group = design_.groups[g];
    if (group.held.empty()) group.held = group.train;
    double noise = 0.0, square = 0.0, n = 0.0;
    for (int i = 0; i < group.reading.size; ++i) {
      const std::string column = group.reading.name + (group.reading.size == 1 ? "" : std::string("/") + "xyz"[i]);
      const auto it = data_.experiment->other_noise.find(column);
      noise +=
          it == data_.experiment->other_noise.end() ? 0.0 : it->second.sigma * it->second.sigma / group.reading.size;
    }
    for (const LinkRecording& r : used_) {
      const Eigen::MatrixXd read = r.read.middleCols(group.reading.first, group.reading.size);
      square += (read.rowwise() - read.colwise().mean()).squaredNorm();
      n += static_cast<double>(read.size());
    }
    group.spread = std::sqrt(square / std::max(1.0, n));
    const double passed = std::min(1.0, 2.0 * data_.cutoff * used_[0].step);
    group.floor = std::max({noise * passed, std::pow(kAgreement * group.spread, 2), 1e-300});
    group.effective = std::max(1.0, count_train(group) / find_correlation(group));
  }

  static double count_train(const LinkGroup& group) {
    double n = 0.0;
    for (const Gram& fold : group.train) n += fold.n;
    return n;
  }

  double find_correlation(const LinkGroup& group) const {
    Columns all;
    for (long c = 0; c < design_.width; ++c) {
      for (const Gram& fold : group.train) {
        if (fold.get(c, c) > 0.0) {
          all.push_back(c);
          break;
        }
      }
    }
    const Eigen::VectorXd theta = solve(sum(group.train, design_.width), all);
    double time = 0.0, n = 0.0;
    for (size_t r = 0; r < used_.size(); ++r) {
      for (int axis = 0; axis < group.reading.size; ++axis) {
        Eigen::VectorXd left(static_cast<long>(rows_[r].size()));
        for (long k = 0; k < left.size(); ++k) {
          const long row = used_[r].trim + k * used_[r].stride, at = group.reading.first + axis;
          left[k] = used_[r].read(row, at) - used_[r].predicted(row, at);
          for (size_t c = 0; c < all.size(); ++c)
            left[k] -= rows_[r][static_cast<size_t>(k)](at, all[c]) * theta[static_cast<long>(c)];
        }
        if (left.size() > 8) {
          time += calc_correlation_time(left);
          n += 1.0;
        }
      }
    }
    return n > 0.0 ? time / n : 1.0;
  }

  // Removes terms that no reading shows.
  void drop_silent_terms() {
    std::vector<LinkTerm> kept;
    for (const LinkTerm& term : design_.terms) {
      double shows = 0.0;
      for (const LinkGroup& group : design_.groups) {
        for (const Gram& fold : group.train) {
          for (long c = 0; c < term.columns; ++c) shows = std::max(shows, fold.get(term.first + c, term.first + c));
        }
      }
      if (shows > 1e-18) kept.push_back(term);
    }
    design_.terms = kept;
  }

  const LinkData& data_;
  LinkReadings& readings_;
  LinkDesign design_;
  std::vector<std::vector<Eigen::MatrixXd>> rows_;
  std::vector<LinkRecording> used_;
};

}  // namespace

LinkDesign make_link_design(const LinkData& data, const LinkSensors& sensors, LinkReadings* readings,
                            const LinkPoints& points) {
  return DesignMaker(data, sensors, readings, points).make();
}

const LinkPoint* find_point(const LinkPoints& points, const LinkTermRow& row, int index) {
  for (const LinkPoint& point : points) {
    if (point.row == &row && point.index == index) return &point;
  }
  return nullptr;
}

bool is_physical(const LinkDesign& design, const LinkTerm& term, const Eigen::VectorXd& p) {
  const LinkTermRow& row = *term.row;
  return row.allows(term, p, row.needs_reach() ? calc_link_reach(design.experiment->robot.tree, term.index) : 0.0);
}

LinkFit fit_links(const LinkDesign& design, const LinkTerms& model, bool with_covariance) {
  LinkFit fit;
  const Columns columns = list_columns(design, model);
  std::vector<double> square = list_nominal(design);
  Weighted w;
  for (int i = 0; i < 3; ++i) {
    w = weigh_folds(design, square);
    square = cross_validate_groups(design, w, columns);
  }
  const Eigen::VectorXd theta = solve(w.total, columns);
  fit.theta = split(design, model, theta);
  for (size_t i = 0; i < model.size(); ++i)
    fit.physical = fit.physical && is_physical(design, design.terms[model[i]], fit.theta[i]);
  fit.cross = square;
  fit.evidence = calc_evidence(design, model, square);
  for (const LinkGroup& group : design.groups) {
    double rest = 0.0, n = 0.0;
    for (const Gram& part : group.held) {
      rest += calc_rest(part, columns, theta);
      n += part.n;
    }
    fit.held.push_back(n > 0.0 ? rest / n : 0.0);
  }
  if (with_covariance && !columns.empty()) fit.covariance = calc_covariance(w.folds, w.total, columns, theta);
  return fit;
}

std::vector<double> compare_links(const LinkDesign& design, const std::vector<LinkTerms>& models, const LinkFit& fit) {
  const Weighted w = weigh_folds(design, fit.cross);
  std::vector<double> out;
  for (const LinkTerms& model : models) out.push_back(judge(design, model, w).evidence);
  return out;
}

LinkTerms choose_link_terms(const LinkDesign& design) { return Chooser(design).run(); }

LinkAlone fit_alone(const LinkDesign& design, const LinkTerms& model, const LinkFit& fit, size_t recording) {
  const Columns columns = list_columns(design, model);
  const Gram own = weigh(design, fit.cross, [recording](const LinkGroup& g) { return &g.alone[recording]; });
  LinkAlone out;
  out.theta = split(design, model, solve(own, columns));
  out.variance = split(design, model, Eigen::VectorXd(calc_inverse(own, columns).diagonal().cwiseAbs()));
  return out;
}

}  // namespace hrp::diagnosis
