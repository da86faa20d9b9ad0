// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/torque/terms.h"

#include <algorithm>

#include "diagnosis/data/drives.h"
#include "diagnosis/measurement/torque/term_rows.h"
#include "diagnosis/model/tree.h"

namespace hrp::diagnosis {
namespace {

// Adds one term for each shape to try at a joint or link.
void add_terms(const TorqueData& data, const TermRow& row, int place, std::vector<Term>* terms) {
  for (double shape : row.list_shapes ? row.list_shapes(data, place) : std::vector<double>{0.0})
    terms->push_back({&row, place, shape});
}

// By joint: whether any of its samples are used.
std::vector<char> list_used(const TorqueData& data) {
  std::vector<char> used(data.source.size(), false);
  for (const TorqueRecording& r : data.recordings) {
    for (size_t j = 0; j < used.size(); ++j) used[j] = used[j] || r.use.col(static_cast<long>(j)).any();
  }
  return used;
}

// True if some used joint carries the link. No other joint feels it: a humanoid that moves one arm does not show the
// other.
bool is_felt(const TreeSpec& tree, const std::vector<char>& used, int link) {
  for (size_t j = 0; j < used.size(); ++j) {
    if (used[j] && is_above(tree, static_cast<int>(j) + 1, link)) return true;
  }
  return false;
}

// True if a zero of this joint moves a link of some used joint, or the weight on one.
bool is_zero_felt(const TreeSpec& tree, const std::vector<char>& used, int joint) {
  for (size_t j = 0; j < used.size(); ++j) {
    if (used[j] &&
        (is_above(tree, static_cast<int>(j) + 1, joint + 1) || is_above(tree, joint + 1, static_cast<int>(j) + 1)))
      return true;
  }
  return false;
}

// Linear interpolation of a signal at sample i of the full grid.
double read_between(const Eigen::MatrixXd& signal, long joint, double i) {
  const long low = static_cast<long>(i), high = std::min(low + 1, signal.rows() - 1);
  return signal(low, joint) + (i - static_cast<double>(low)) * (signal(high, joint) - signal(low, joint));
}

}  // namespace

int Term::columns() const { return row->columns; }
bool Term::whole() const { return row->whole; }
const EffectInfo& Term::effect() const { return *row->effect; }

double calc_late(const TorqueRecording& r, long joint, long k, double delay) {
  const double samples = std::min(delay / r.step, static_cast<double>(k));
  const long whole = static_cast<long>(samples);
  if (samples <= 0.0) return r.command_rate(k, joint);
  double sum = 0.0;  // trapezoidal rule; the last interval may be a part
  for (long i = 0; i < whole; ++i) sum += 0.5 * (r.command_rate(k - i, joint) + r.command_rate(k - i - 1, joint));
  const double rest = samples - static_cast<double>(whole), end = static_cast<double>(k) - samples;
  sum += 0.5 * rest * (read_between(r.command_rate, joint, end) + r.command_rate(k - whole, joint));
  return sum / samples;
}

double calc_gone(const TorqueRecording& r, long joint, long k, double delay) {
  const double end = std::max(static_cast<double>(k) - delay / r.step, 0.0);
  if (!(end < static_cast<double>(k))) return r.effort_rate(k, joint);
  return (r.effort(k, joint) - read_between(r.effort, joint, end)) / ((static_cast<double>(k) - end) * r.step);
}

CalcLate find_late(const TorqueData& data, int joint) {
  return data.source[static_cast<size_t>(joint)] == EffortSource::kRecorded ? calc_gone : calc_late;
}

double calc_coming(const TorqueRecording& r, long joint, long k, double delay) {
  const long last = r.effort.rows() - 1;
  const double end = std::min(static_cast<double>(k) + delay / r.step, static_cast<double>(last));
  if (!(end > static_cast<double>(k))) return r.effort_rate(k, joint);
  return (read_between(r.effort, joint, end) - r.effort(k, joint)) / ((end - static_cast<double>(k)) * r.step);
}

std::vector<Term> list_joint_terms(const TorqueData& data, int joint) {
  std::vector<Term> terms;
  if (!data.is_judged(joint) || find_fast_speed(data, joint) <= 0.0) return terms;
  const bool driven = data.experiment->robot.tree.joint(joint).actuated;
  for (const TermRow& row : list_term_rows()) {
    if (!row.whole && (driven || !row.needs_drive)) add_terms(data, row, joint, &terms);
  }
  return terms;
}

std::vector<Term> list_whole_terms(const TorqueData& data) {
  std::vector<Term> terms;
  const std::vector<char> used = list_used(data);
  const TreeSpec& tree = data.experiment->robot.tree;
  // On a moving base, the balance of the whole body determines links and zeros much better than drives with friction
  // do.
  const bool fixed = !data.experiment->scenario.floating_base && !data.behind_gears;
  const bool driven = has_drive(tree);
  // Measured forces at the feet give the scale that a drive's torque gives elsewhere.
  const auto is_measured = [&](int link) {
    return tree.links[static_cast<size_t>(link)].joint.actuated || !data.feet.empty();
  };
  for (int link = 1; fixed && link < static_cast<int>(tree.links.size()); ++link) {
    if (!is_felt(tree, used, link)) continue;
    for (const TermRow& row : list_term_rows()) {
      if (row.whole && row.place == PlaceKind::kLink && (is_measured(link) || !row.needs_drive))
        add_terms(data, row, link, &terms);
    }
  }
  for (const TermRow& row : list_term_rows()) {
    if (!row.whole || row.place == PlaceKind::kLink || !(fixed || row.late) || (row.needs_drive && !driven)) continue;
    const int places = row.place == PlaceKind::kJoint && !row.late ? tree.num_joints() : 1;
    for (int place = 0; place < places; ++place) {
      if (row.place != PlaceKind::kJoint || row.late || is_zero_felt(tree, used, place))
        add_terms(data, row, place, &terms);
    }
  }
  return terms;
}

Eigen::MatrixXd calc_joint_columns(const TorqueData& data, const TorqueRecording& r, const Term& term) {
  return term.row->calc_columns(data, r, term);
}

TermValues calc_values(const Term& term, const Eigen::VectorXd& x, const Eigen::VectorXd& s) {
  if (term.row->make_values) return term.row->make_values(term, x, s);
  return {{x.data(), x.data() + x.size()}, {s.data(), s.data() + s.size()}};
}

Eigen::VectorXd calc_coefficients(const TermRow& row, const std::vector<double>& values) {
  if (row.make_coefficients) return row.make_coefficients(values);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), row.columns);
}

}  // namespace hrp::diagnosis
