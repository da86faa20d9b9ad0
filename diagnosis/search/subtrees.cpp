// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/subtrees.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnosis/estimate/rounds.h"
#include "diagnosis/search/trust.h"

namespace hrp::diagnosis {
namespace {

// Index of the robot's joint in the subtree; -1 if it belongs to another one.
int find_place(const Subtree& subtree, int joint) {
  const auto it = std::find(subtree.joints.begin(), subtree.joints.end(), joint);
  return it == subtree.joints.end() ? -1 : static_cast<int>(it - subtree.joints.begin());
}

// Converts a place between numberings; index -1 if it does not exist there. Link i + 1 moves with joint i.
template <class MapJoint>
Place map_place(Place place, const MapJoint& map_joint) {
  if (place.kind == PlaceKind::kNone) return place;
  const int shift = place.kind == PlaceKind::kLink ? 1 : 0;
  const int joint = place.index >= shift ? map_joint(place.index - shift) : -1;
  place.index = joint < 0 ? -1 : joint + shift;
  return place;
}

TreeSpec make_tree(const TreeSpec& whole, const std::vector<int>& joints) {
  TreeSpec tree = whole;
  tree.links = {whole.links[0]};
  tree.frames.clear();
  std::vector<int> number(whole.links.size(), 0);
  for (size_t i = 0; i < joints.size(); ++i) {
    LinkSpec link = whole.links[static_cast<size_t>(joints[i]) + 1];
    number[static_cast<size_t>(joints[i]) + 1] = static_cast<int>(i) + 1;
    link.parent = number[static_cast<size_t>(link.parent)];
    MimicSpec& mimic = link.joint.mimic;
    if (mimic.joint >= 0) mimic.joint = number[static_cast<size_t>(mimic.joint) + 1] - 1;
    tree.links.push_back(link);
  }
  return tree;
}

template <class T>
std::vector<T> pick(const std::vector<T>& all, const std::vector<int>& which) {
  std::vector<T> some;
  for (int i : which) some.push_back(all[static_cast<size_t>(i)]);
  return some;
}

Subtree make_subtree(const Problem& problem, const std::vector<int>& joints) {
  const Experiment& whole = *problem.experiment;
  auto experiment = std::make_shared<Experiment>();
  experiment->path = whole.path;
  experiment->folder = whole.folder;
  experiment->scenario = whole.scenario;
  experiment->keys = whole.keys;
  experiment->robot.tree = make_tree(whole.robot.tree, joints);
  experiment->sample_time = whole.sample_time;
  experiment->joint_noise = pick(whole.joint_noise, joints);
  for (const Recording& recording : whole.recordings) {
    Recording own;
    own.spec = recording.spec;
    own.time = recording.time;
    own.joints = pick(recording.joints, joints);
    experiment->recordings.push_back(std::move(own));
  }
  Subtree subtree;
  subtree.joints = joints;
  Problem& own = subtree.problem;
  own.options = problem.options;
  own.jobs = problem.jobs;
  own.most_work = problem.most_work;
  own.train = problem.train;
  own.validate = problem.validate;
  for (const SmoothRecording& smooth : problem.smooth) {
    own.smooth.push_back({smooth.start, smooth.judged, pick(smooth.joints, joints), pick(smooth.effort, joints)});
  }
  for (int j : joints) {
    const size_t first = static_cast<size_t>(j) * kQuantities;
    for (size_t q = 0; q < kQuantities; ++q) own.weights.push_back(problem.weights[first + q]);
  }
  own.experiment = experiment.get();
  for (size_t r = 0; r < own.smooth.size(); ++r) own.trust.push_back(find_trust(own, r));
  subtree.experiment = std::move(experiment);
  return subtree;
}

Score join_scores(const Problem& problem, const std::vector<const Score*>& parts) {
  Score whole;
  whole.signal_chi2.assign(problem.weights.size(), 0.0);
  whole.signal_count = whole.signal_chi2;
  for (size_t l = 0; l < parts.size(); ++l) {
    const Score& part = *parts[l];
    whole.chi2 += part.chi2;
    whole.count += part.count;
    whole.ok = whole.ok && part.ok;
    for (size_t c = 0; c < part.signal_chi2.size(); ++c) {
      const size_t joint = static_cast<size_t>(problem.subtrees[l].joints[c / kQuantities]);
      const size_t at = joint * kQuantities + c % kQuantities;
      whole.signal_chi2[at] = part.signal_chi2[c];
      whole.signal_count[at] = part.signal_count[c];
    }
  }
  return whole;
}

// Joins one trial per subtree to one of the whole robot. Clocks are common to all subtrees, so they count once.
Trial join_trials(const Problem& problem, const std::vector<const Trial*>& parts) {
  Trial whole;
  whole.probability = 1.0;
  whole.refined = true;
  bool skewed = false;
  std::vector<const Score*> train, validate;
  for (size_t l = 0; l < parts.size(); ++l) {
    const Trial& part = *parts[l];
    const Hypothesis effects = map_to_robot(part.hypothesis, problem.subtrees[l]);
    for (size_t i = 0; i < effects.size(); ++i) {
      if (effects[i].place == at_all() && std::exchange(skewed, true)) continue;
      whole.hypothesis.push_back(effects[i]);
      whole.std.push_back(get_std(part, i));
    }
    const Hypothesis timing = map_to_robot(part.timing, problem.subtrees[l]);
    whole.timing.insert(whole.timing.end(), timing.begin(), timing.end());
    if (!part.hypothesis.empty()) whole.probability *= part.probability;
    whole.refined = whole.refined && part.refined;
    train.push_back(&part.train);
    validate.push_back(&part.validate);
  }
  whole.train = join_scores(problem, train);
  whole.validate = join_scores(problem, validate);
  whole.rms = whole.validate.rms();
  whole.worst = whole.validate.worst();
  return whole;
}

void keep_parts(const std::vector<const Trial*>& parts, Trial* whole) {
  for (const Trial* part : parts) {
    Trial start;
    start.starts = part->starts;
    start.step_errors = part->step_errors;
    whole->subtrees.push_back(std::move(start));
  }
}

// A subtree without an explanation contributes no effects.
const Trial& get_model(const Outcome& outcome) { return outcome.explained ? outcome.chosen : outcome.nominal; }

// The best set of each subtree; effects of the whole robot appear once.
Hypothesis join_best(const Problem& problem, const std::vector<Outcome>& subtrees) {
  Hypothesis best;
  for (size_t l = 0; l < subtrees.size(); ++l) {
    for (const Effect& effect : map_to_robot(subtrees[l].best, problem.subtrees[l])) {
      if (!contains(best, effect.id, effect.place)) best.push_back(effect);
    }
  }
  return best;
}

// Adds a subtree's other explanations, with their residual for the whole robot, the other subtrees as chosen.
void add_rivals(const Problem& problem, const Trial& model, size_t subtree, const Outcome& own, Outcome* whole) {
  const double count = std::max(1.0, whole->chosen.validate.count);
  const double rest = whole->chosen.validate.chi2 - model.validate.chi2;
  const std::string chosen = get_label(*problem.subtrees[subtree].experiment, model.hypothesis);
  for (const Trial& rival : own.rivals) {
    if (get_label(*problem.subtrees[subtree].experiment, rival.hypothesis) == chosen) continue;
    Trial listed;
    listed.hypothesis = map_to_robot(rival.hypothesis, problem.subtrees[subtree]);
    listed.rms = std::sqrt((rest + rival.rms * rival.rms * model.validate.count) / count);
    listed.worst = rival.worst;
    listed.refined = rival.refined;
    listed.probability = rival.probability;
    listed.std = rival.std;
    listed.distance = rival.distance;
    whole->rivals.push_back(std::move(listed));
  }
  for (Trial other : own.indistinguishable) {
    other.hypothesis = map_to_robot(other.hypothesis, problem.subtrees[subtree]);
    whole->indistinguishable.push_back(std::move(other));
  }
}

Outcome join_outcomes(const Problem& problem, const std::vector<Outcome>& subtrees) {
  Outcome whole;
  std::vector<const Trial*> nominals, models;
  whole.explained = true;
  for (const Outcome& subtree : subtrees) {
    nominals.push_back(&subtree.nominal);
    models.push_back(&get_model(subtree));
    whole.mismatch = whole.mismatch || subtree.mismatch;
    whole.spent = whole.spent || subtree.spent;
    whole.explained = whole.explained && (subtree.explained || !subtree.mismatch);
  }
  whole.explained = whole.explained && whole.mismatch;
  whole.best = join_best(problem, subtrees);
  whole.nominal = join_trials(problem, nominals);
  whole.chosen = join_trials(problem, models);
  if (!whole.chosen.hypothesis.empty()) whole.rivals.push_back(whole.chosen);
  whole.partly = !whole.explained && !whole.chosen.hypothesis.empty();
  keep_parts(nominals, &whole.nominal);
  keep_parts(models, &whole.chosen);
  for (size_t l = 0; l < subtrees.size(); ++l) {
    if (subtrees[l].mismatch) add_rivals(problem, *models[l], l, subtrees[l], &whole);
  }
  std::stable_sort(whole.rivals.begin(), whole.rivals.end(),
                   [](const Trial& a, const Trial& b) { return a.rms < b.rms; });
  if (whole.rivals.size() > kShortList) whole.rivals.resize(kShortList);
  return whole;
}

}  // namespace

std::vector<std::vector<int>> list_subtrees(const TreeSpec& tree) {
  std::vector<size_t> subtree(tree.links.size(), 0);  // by link: first link of its subtree
  for (size_t i = 1; i < tree.links.size(); ++i) {
    const size_t parent = static_cast<size_t>(tree.links[i].parent);
    subtree[i] = parent == 0 ? i : subtree[parent];
  }
  for (size_t i = 1; i < tree.links.size(); ++i) {
    const int followed = tree.links[i].joint.mimic.joint;
    if (followed < 0) continue;
    const size_t other = subtree[static_cast<size_t>(followed) + 1], own = subtree[i];
    std::replace(subtree.begin(), subtree.end(), std::max(own, other), std::min(own, other));
  }
  std::vector<std::vector<int>> subtrees;
  for (size_t first = 1; first < tree.links.size(); ++first) {
    std::vector<int> joints;
    for (size_t i = 1; i < tree.links.size(); ++i) {
      if (subtree[i] == first) joints.push_back(static_cast<int>(i) - 1);
    }
    if (!joints.empty()) subtrees.push_back(std::move(joints));
  }
  return subtrees;
}

void split_subtrees(Problem* problem) {
  const std::vector<std::vector<int>> subtrees = list_subtrees(problem->experiment->robot.tree);
  if (subtrees.size() < 2) return;
  for (const std::vector<int>& joints : subtrees) problem->subtrees.push_back(make_subtree(*problem, joints));
  for (Subtree& subtree : problem->subtrees) subtree.problem.most_work /= static_cast<double>(subtrees.size());
}

Hypothesis select_effects(const Hypothesis& whole, const Subtree& subtree) {
  Hypothesis own;
  for (Effect effect : whole) {
    effect.place = map_place(effect.place, [&](int joint) { return find_place(subtree, joint); });
    if (effect.place.index >= 0) own.push_back(effect);
  }
  return own;
}

Hypothesis map_to_robot(const Hypothesis& own, const Subtree& subtree) {
  Hypothesis whole = own;
  for (Effect& effect : whole) {
    effect.place = map_place(effect.place, [&](int joint) { return subtree.joints[static_cast<size_t>(joint)]; });
  }
  return whole;
}

bool calc_subtree_residuals(const Problem& problem, const Hypothesis& hypothesis, int recording,
                            std::vector<double>* residuals) {
  const size_t rows = problem.experiment->recordings[static_cast<size_t>(recording)].size();
  const size_t width = problem.weights.size();
  residuals->assign(rows * width, 0.0);
  for (const Subtree& subtree : problem.subtrees) {
    std::vector<double> own;
    if (!calc_residuals(subtree.problem, select_effects(hypothesis, subtree), recording, &own)) return false;
    const size_t channels = subtree.problem.weights.size();
    for (size_t c = 0; c < channels; ++c) {
      const size_t at = static_cast<size_t>(subtree.joints[c / kQuantities]) * kQuantities + c % kQuantities;
      for (size_t k = 0; k < rows; ++k) (*residuals)[k * width + at] = own[k * channels + c];
    }
  }
  return true;
}

Outcome search_subtrees(const Problem& problem, const Progress& progress) {
  if (problem.subtrees.empty()) return search(problem, progress);
  std::vector<Outcome> outcomes;
  for (const Subtree& subtree : problem.subtrees) {
    progress("subtree " + std::to_string(outcomes.size() + 1) + " of " + std::to_string(problem.subtrees.size()) +
             ", from " + subtree.experiment->robot.tree.joint(0).name);
    outcomes.push_back(search(subtree.problem, progress));
  }
  return join_outcomes(problem, outcomes);
}

Problem start_as(const Problem& problem, const Trial& trial) {
  Problem own = problem;
  own.starts = trial.starts;
  own.step_errors = trial.step_errors;
  for (size_t l = 0; l < std::min(own.subtrees.size(), trial.subtrees.size()); ++l) {
    own.subtrees[l].problem.starts = trial.subtrees[l].starts;
    own.subtrees[l].problem.step_errors = trial.subtrees[l].step_errors;
  }
  return own;
}

}  // namespace hrp::diagnosis
