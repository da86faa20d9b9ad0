// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/dirt_truth.h"

#include <algorithm>
#include <cmath>

namespace hrp::cases {
namespace {

using Json = nlohmann::ordered_json;
using Series = std::vector<double>;

constexpr std::size_t kHeld = 3;    // recordings from here on are held out
constexpr double kLongest = 6.0;    // [s] of a recording are enough to tell shares
constexpr double kStartTime = 0.6;  // [s] in which a start state settles: not compared
constexpr double kSlow = 1e-3;      // [rad/s] below it friction holds, in no direction

const Series& find(const std::vector<Column>& columns, const std::string& name) {
  static const Series none;
  for (const Column& column : columns) {
    if (column.name == name) return column.values;
  }
  return none;
}

double mean_square(const Series& x) {
  double sum = 0;
  for (double value : x) sum += value * value;
  return x.empty() ? 0 : sum / static_cast<double>(x.size());
}

Series subtract(const Series& a, const Series& b) {
  Series out(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) out[k] = a[k] - b[k];
  return out;
}

// Motion of one joint as it truly was.
struct Motion {
  Series time, q, v, a, effort;
};

Motion take_motion(const std::vector<Column>& columns, const std::string& joint) {
  const std::string base = "/joint_states/" + joint;
  Motion m{columns[0].values,
           find(columns, base + "/position"),
           find(columns, base + "/velocity"),
           {},
           find(columns, base + "/effort")};
  m.a.assign(m.v.size(), 0);
  for (std::size_t k = 1; k + 1 < m.v.size(); ++k) m.a[k] = (m.v[k + 1] - m.v[k - 1]) / (m.time[k + 1] - m.time[k - 1]);
  return m;
}

// Effort that a law of the joint takes at one moment, without what no list holds [N m].
double calc_taken(const Hidden& h, const Motion& m, std::size_t k) {
  const double direction = std::abs(m.v[k]) < kSlow ? 0 : m.v[k] > 0 ? 1.0 : -1.0;
  if (h.effect == "viscous_friction") return h.get("coefficient") * m.v[k];
  if (h.effect == "rotor_inertia") return h.get("inertia") * m.a[k];
  if (h.effect == "coulomb_friction") return h.get("level") * direction;
  if (h.effect == "load_dependent_friction") return h.get("ratio") * std::abs(m.effort[k]) * direction;
  if (h.effect == "sensor_scale") return (h.get("scale") - 1) * m.effort[k];
  if (h.effect != "stribeck_friction") return 0;
  const double s = m.v[k] / h.get("stribeck_velocity");
  return direction * (h.get("coulomb") + (h.get("static") - h.get("coulomb")) * std::exp(-s * s));
}

Series calc_taken(const Hidden& h, const Motion& m) {
  Series out(m.v.size());
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = calc_taken(h, m, k);
  return out;
}

bool is_of(const Hidden& h, const std::string& joint) {
  return h.where == joint || h.where == "/joint_states/" + joint + "/effort";
}

Json make_entry(const Hidden& h, double share) {
  return {{"effect", h.effect}, {h.where_kind, h.where}, {"share", tidy(share)}};
}

// What the background takes of a joint's effort, all of it.
Series sum_background(const Dirt& dirt, const std::string& joint, const Motion& motion) {
  Series sum(motion.v.size(), 0);
  for (const Hidden& h : dirt.background) {
    if (!is_of(h, joint)) continue;
    const Series taken = calc_taken(h, motion);
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += taken[k];
  }
  return sum;
}

// Appends the shares of the background at a joint of `missing` [(N m)^2], and by what factor each torque exceeds the
// `noise` [N m] of the joint's effort (root mean square; 0: not known).
void add_background(const Dirt& dirt, const std::string& joint, const Motion& motion, double missing, double noise,
                    Json* list) {
  for (const Hidden& h : dirt.background) {
    if (!is_of(h, joint)) continue;
    const double square = mean_square(calc_taken(h, motion));
    list->push_back(make_entry(h, square / missing));
    if (noise > 0) list->back()["over_noise"] = tidy(std::sqrt(square) / noise);
  }
}

struct Sums {
  double missed = 0, y = 0, yy = 0, n = 0;
};

class Influences {
 public:
  explicit Influences(const Draft& draft) : draft_(draft) {
    draft_.recorder.with_velocity = draft_.recorder.with_effort = draft_.recorder.with_commands = true;
    const std::vector<Hidden> all = list_all(draft_);
    with_ = run(all);
    nominal_ = run({});
    for (const Hidden& h : draft_.hidden) {
      std::vector<Hidden> rest;
      for (const Hidden& other : all) {
        if (other.effect != h.effect || other.where != h.where) rest.push_back(other);
      }
      without_.push_back(run(rest));
    }
  }

  Json make() {
    std::vector<double> on_top(draft_.hidden.size(), 0);
    Json list = Json::array();
    for (int j = 0; j < joint_count(draft_.robot); ++j) {
      const std::string& name = joint(draft_.robot, j).name;
      const double missing = find_missing(name);
      const Motion motion = take_motion(with_, name);
      add_background(draft_.dirt, name, motion, missing, find_noise(draft_, "/joint_states/" + name + "/effort"),
                     &list);
      for (std::size_t h = 0; h < on_top.size(); ++h) on_top[h] = std::max(on_top[h], find_share(h, name, missing));
    }
    for (std::size_t h = 0; h < on_top.size(); ++h) {
      const std::string& kind = draft_.hidden[h].where_kind;
      const bool of_joints = kind == "joint" || kind == "link";
      list.push_back(make_entry(draft_.hidden[h], of_joints ? on_top[h] : 1.0));
    }
    return list;
  }

 private:
  std::vector<Column> run(const std::vector<Hidden>& hidden) const {
    return record_clean(draft_, hidden, kHeld, std::min(kLongest, draft_.recordings[kHeld].duration));
  }

  Series differ(std::size_t h, const std::string& signal) const {
    return subtract(find(with_, signal), find(without_[h], signal));
  }

  // Mean square of all that the joint's effort has to do beside the nominal motion [(N m)^2].
  double find_missing(const std::string& joint) const {
    Series sum = sum_background(draft_.dirt, joint, take_motion(with_, joint));
    for (std::size_t h = 0; h < without_.size(); ++h) {
      const Series more = differ(h, "/joint_states/" + joint + "/effort");
      for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += more[k];
    }
    return std::max(1e-300, mean_square(sum));
  }

  double find_share(std::size_t h, const std::string& joint, double missing) const {
    const std::string q = "/joint_states/" + joint + "/position", y = "/joint_states/" + joint + "/effort";
    const double moved = mean_square(subtract(find(with_, q), find(nominal_, q)));
    return std::max(mean_square(differ(h, y)) / missing, mean_square(differ(h, q)) / std::max(1e-300, moved));
  }

  Draft draft_;
  std::vector<Column> with_, nominal_;
  std::vector<std::vector<Column>> without_;
};

}  // namespace

Json make_influences(const Draft& draft) { return Influences(draft).make(); }

Json make_background_influences(const RobotPlan& robot, const Dirt& dirt, const std::vector<Column>& columns,
                                double least_travel) {
  Json list = Json::array();
  for (int j = 0; j < joint_count(robot); ++j) {
    const std::string& name = joint(robot, j).name;
    const Motion motion = take_motion(columns, name);
    const auto [low, high] = std::minmax_element(motion.q.begin(), motion.q.end());
    if (motion.q.empty() || *high - *low < least_travel) continue;
    add_background(dirt, name, motion, std::max(1e-300, mean_square(sum_background(dirt, name, motion))), 0, &list);
  }
  return list;
}

Json make_listed_error(const Draft& draft, const std::vector<std::vector<Column>>& recorded) {
  std::map<std::string, Sums> sums;
  for (std::size_t i = kHeld; i < recorded.size(); ++i) {
    const std::vector<Column> listed = record_clean(draft, list_listed(draft), i, 1e9);
    for (std::size_t c = 1; c < recorded[i].size(); ++c) {
      const std::string& name = recorded[i][c].name;
      if (name.rfind("/joint_states/", 0) != 0) continue;
      const Series& model = find(listed, name);
      for (std::size_t k = 0; k < model.size(); ++k) {
        if (draft.times[i][k] < draft.recordings[i].start + kStartTime) continue;
        const double y = recorded[i][c].values[k];
        Sums& s = sums[name];
        s.missed += (y - model[k]) * (y - model[k]);
        s.y += y;
        s.yy += y * y;
        s.n += 1;
      }
    }
  }
  Json out = Json::object();
  for (const auto& [name, s] : sums) {
    const double spread = std::sqrt(std::max(0.0, s.yy / s.n - s.y * s.y / (s.n * s.n)));
    out[name] = {
        {"error", tidy(std::sqrt(s.missed / s.n))}, {"noise", tidy(find_noise(draft, name))}, {"spread", tidy(spread)}};
  }
  return out;
}

}  // namespace hrp::cases
