// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/checks/motion.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/conventions/effort_units.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

// Terms that every drive has, its gain and a constant torque; friction first.
std::vector<const TermRow*> make_columns() {
  std::vector<const TermRow*> rows;
  for (const TermRow& row : list_term_rows()) {
    if (row.usual || row.scales_effort || row.is_constant()) rows.insert(row.level ? rows.begin() : rows.end(), &row);
  }
  return rows;
}
const std::vector<const TermRow*>& list_columns() {
  static const std::vector<const TermRow*> columns = make_columns();
  return columns;
}
long count_columns() { return static_cast<long>(list_columns().size()); }
const std::string& get_name(long column) { return list_columns()[static_cast<size_t>(column)]->effect->name; }

const char* get_source_words(EffortSource source) {
  return source == EffortSource::kRecorded   ? "recorded"
         : source == EffortSource::kServoLaw ? "from the servo's law"
                                             : "unknown";
}

// Motion and sums of one joint over training and held-out recordings.
struct Motion {
  std::vector<double> speed, acceleration;
  double low = 1e300, high = -1e300, least_load = 1e300, most_load = -1e300, half_cycles = 0.0, time = 0.0;
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(count_columns(), count_columns());
  Eigen::VectorXd b = Eigen::VectorXd::Zero(count_columns());
  double c = 0.0, n = 0.0, effort = 0.0, effort_squares = 0.0;
};

void add_range(const TorqueRecording& r, int joint, Motion* m) {
  m->low = std::min(m->low, r.q.col(joint).minCoeff());
  m->high = std::max(m->high, r.q.col(joint).maxCoeff());
  m->time += static_cast<double>(r.q.rows()) * r.step;
  double last = 0.0;
  for (long k = 0; k < r.kept(); ++k) {
    const long row = r.full_row(k);
    m->speed.push_back(std::abs(r.v(row, joint)));
    m->acceleration.push_back(std::abs(r.a(row, joint)));
    m->least_load = std::min(m->least_load, r.tau(row, joint));
    m->most_load = std::max(m->most_load, r.tau(row, joint));
    if (!r.use(k, joint)) continue;
    if (r.v(row, joint) * last <= 0.0) m->half_cycles += 1.0;
    last = r.v(row, joint);
  }
}

void add_rows(const TorqueData& data, const TorqueRecording& r, int joint, Motion* m) {
  const bool driven = data.experiment->robot.tree.joint(joint).actuated;
  Eigen::MatrixXd X(r.kept(), count_columns());
  for (long c = 0; c < count_columns(); ++c)
    X.col(c) = calc_joint_columns(data, r, {list_columns()[static_cast<size_t>(c)], joint});
  for (long k = 0; k < r.kept(); ++k) {
    if (!r.use(k, joint)) continue;
    // A joint without a drive has no effort; its torques are those of gravity and motion.
    const double y = r.missing(k, joint), u = (driven ? r.effort : r.tau)(r.full_row(k), joint);
    m->G += X.row(k).transpose() * X.row(k);
    m->b += y * X.row(k).transpose();
    m->c += y * y;
    m->n += 1.0;
    m->effort += u;
    m->effort_squares += u * u;
  }
}

// The other column that is most similar to column i, by the cosine of the angle between them.
long find_most_like(const Eigen::MatrixXd& G, long i) {
  long most_like = i == 0 ? 1 : 0;
  double most = -1.0;
  for (long c = 0; c < count_columns(); ++c) {
    const double likeness = std::abs(G(i, c)) / std::sqrt(std::max(1e-300, G(i, i) * G(c, c)));
    if (c != i && likeness > most) {
      most = likeness;
      most_like = c;
    }
  }
  return most_like;
}

Json make_tells(const JointSpec& joint, const Motion& m) {
  Json list = Json::array();
  if (m.n < static_cast<double>(kFewestToSay)) return list;
  const auto applies = [&](long column) {
    return joint.actuated || !list_columns()[static_cast<size_t>(column)]->needs_drive;
  };
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(count_columns());
  for (long i = 0; i < count_columns(); ++i) {
    if (applies(i) && m.G(i, i) > 0.0) scale[i] = 1.0 / std::sqrt(m.G(i, i));
  }
  Eigen::MatrixXd unit = scale.asDiagonal() * m.G * scale.asDiagonal();
  unit.diagonal().array() += 1e-9;
  const Eigen::MatrixXd inverse = unit.inverse();
  const Eigen::VectorXd theta = inverse * scale.cwiseProduct(m.b);
  const double left = std::max(0.0, m.c - theta.dot(scale.cwiseProduct(m.b))) / m.n;
  const double spread = std::sqrt(std::max(1e-300, m.effort_squares / m.n - std::pow(m.effort / m.n, 2)));
  const double looks = std::clamp(kLooks * m.half_cycles, 1.0, m.n);
  for (long i = 0; i < count_columns(); ++i) {
    if (!applies(i)) continue;
    const double size = std::sqrt(m.G(i, i) / m.n);              // rms of the column
    const double std = std::sqrt(left * inverse(i, i) / looks);  // [N m] standard deviation of the effect's torque
    const double least = size > 0.0 ? kUnlikely * std / size : HUGE_VAL;
    const double share = kUnlikely * std / spread;
    const char* verdict = share < kDetail ? "clear" : share < kMuch ? "weak" : "hidden";
    const std::string& unit_of_turning = list_columns()[static_cast<size_t>(i)]->effect->parameters[0].unit;
    Json entry{{"effect", get_name(i)},
               {"least", std::isfinite(least) ? round_to(least, 2) : 0.0},
               {"unit", get_joint_unit(joint, unit_of_turning)},
               {"verdict", verdict}};
    if (share >= kDetail)
      entry["hidden_by"] = inverse(i, i) > 4.0 ? get_name(find_most_like(m.G, i)) : "too little motion";
    list.push_back(entry);
  }
  return list;
}

}  // namespace

Json make_motion_checks(const Experiment& e) {
  Json list = Json::array();
  const TorqueData data = make_torque_data(e);
  if (data.recordings.empty()) return list;
  for (int j = 0; j < e.num_joints(); ++j) {
    Motion m;
    for (const TorqueRecording& r : data.recordings) {
      add_range(r, j, &m);
      if (data.is_judged(j)) add_rows(data, r, j, &m);
    }
    const JointSpec& joint = e.robot.tree.joint(j);
    list.push_back({{"joint", joint.name},
                    {"unit", get_joint_unit(joint, "rad")},
                    {"travel", round_to(m.high - m.low, 3)},
                    {"speed", round_to(find_quantile(std::move(m.speed), 1.0 - kMinor), 3)},
                    {"acceleration", round_to(find_quantile(std::move(m.acceleration), 1.0 - kMinor), 3)},
                    {"load", {round_to(m.least_load, 3), round_to(m.most_load, 3)}},
                    {"reversals", m.half_cycles},
                    {"effort", get_source_words(data.source[static_cast<size_t>(j)])},
                    {"tells", make_tells(joint, m)}});
    if (joint.actuated && data.source[static_cast<size_t>(j)] == EffortSource::kRecorded)
      list.back()["tells_unit"] = tells_unit(data, j);
  }
  return list;
}

}  // namespace hrp::diagnosis
