// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/bag_table.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>

#include "common/base/diagnostics.h"
#include "common/base/ends_with.h"
#include "common/base/has.h"
#include "common/base/join_words.h"
#include "common/base/rounding.h"
#include "common/base/suggest.h"
#include "diagnosis/data/gaps.h"
#include "diagnosis/data/repair.h"
#include "diagnosis/data/topic_clock.h"

namespace hrp::diagnosis {
namespace {

// Samples of the same columns: in the order of the bag, later sorted by time.
struct Track {
  const BoundTopic* topic = nullptr;
  std::vector<std::string> columns;         // whole names
  std::vector<double> stamp, time;          // [s]; `time`: receive time, until place()
  std::vector<std::vector<double>> values;  // by column
  PlacedClock clock;

  bool is_states() const { return topic->spec.signal == "joint_states"; }
  bool is_held() const { return topic->spec.signal == "joint_commands"; }
  double gap() const { return find_cutting_gap(clock.period); }  // [s]
};

void reorder(const std::vector<size_t>& order, std::vector<double>* values) {
  std::vector<double> out;
  out.reserve(order.size());
  for (size_t k : order) out.push_back((*values)[k]);
  *values = std::move(out);
}

void keep(const std::vector<size_t>& samples, Track* track) {
  reorder(samples, &track->time);
  if (!track->stamp.empty()) reorder(samples, &track->stamp);
  for (auto& column : track->values) reorder(samples, &column);
}

// Single messages without a stamp, as before a simulator's first clock, are left out. Where most have none, stamps mean
// nothing.
void drop_unstamped(Track* track) {
  std::vector<size_t> stamped;
  for (size_t k = 0; k < track->stamp.size(); ++k) {
    if (std::isfinite(track->stamp[k])) stamped.push_back(k);
  }
  if (stamped.size() == track->stamp.size()) return;
  if (2 * stamped.size() > track->stamp.size())
    keep(stamped, track);
  else
    track->stamp.clear();
}

// Converts times to the reference's clock, increasing. Of samples with equal times, the first is kept.
void place(const TopicClock& reference, Track* track) {
  track->time = place_stamps(track->stamp, track->time, reference, &track->clock);
  std::vector<size_t> order(track->time.size()), kept;
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return track->time[a] < track->time[b]; });
  for (size_t k : order) {
    if (kept.empty() || track->time[k] > track->time[kept.back()]) kept.push_back(k);
  }
  track->stamp.clear();
  keep(kept, track);
}

class BagReader {
 public:
  BagReader(const std::string& path, const TopicMap& map, const BagRobot& robot, const std::string& experiment,
            std::vector<std::string>* notes)
      : bag_(path), robot_(robot), notes_(notes), topics_(bind_topics(bag_, map, robot, experiment, notes)) {}

  std::vector<BagTable> read() {
    take_messages();
    for (Track& track : tracks_) drop_unstamped(&track);
    const Track& leader = find_leader();
    const TopicClock reference = find_topic_clock(leader.stamp, leader.time);
    leader_name_ = leader.topic->spec.topic;
    for (Track& track : tracks_) place(reference, &track);
    report();
    const Track& master = find_master();
    std::vector<BagTable> out;
    const std::vector<std::pair<size_t, size_t>> stretches = find_stretches(master);
    for (const auto& [begin, end] : stretches) out.push_back(make_table(master, begin, end, stretches.size() > 1));
    if (out.empty()) refuse_input({bag_.path(), master.topic->spec.topic}, "has no second of samples without a gap");
    return out;
  }

 private:
  void take_messages() {
    std::set<std::string> names;
    for (const BoundTopic& t : topics_) {
      names.insert(t.spec.topic);
      std::vector<std::string> paths = t.paths;
      paths.insert(paths.end(), {"header.stamp.sec", "header.stamp.nanosec", t.names});
      values_.emplace_back(paths);
      count_.push_back(0);
    }
    const std::string damage = bag_.read(names, [&](const BagMessage& m) {
      if (origin_ == 0) origin_ = m.received;
      for (size_t i = 0; i < topics_.size(); ++i) {
        if (topics_[i].index == m.topic) take(i, m);
      }
    });
    if (!damage.empty()) notes_->push_back(damage);
    for (size_t i = 0; i < topics_.size(); ++i) {
      if (count_[i] == 0)
        refuse_input({bag_.path(), topics_[i].spec.topic}, "has no messages, expected " + topics_[i].spec.signal +
                                                               (damage.empty() ? "" : " (" + damage + ")"));
    }
  }

  void take(size_t i, const BagMessage& message) {
    const BoundTopic& topic = topics_[i];
    RosValues& values = values_[i];
    ++count_[i];
    try {
      values.read(topic.type, message.data);
    } catch (const DecodeError& error) {
      refuse_input({bag_.path(), topic.spec.topic},
                   "message " + std::to_string(count_[i]) + " is no " + topic.type.name() + ": " + error.what());
    }
    Track& track = topic.by_joint ? find_joint_track(i) : find_track(i, topic.columns);
    const double receive = 1e-9 * static_cast<double>(message.received - origin_);
    const auto &sec = values.numbers("header.stamp.sec"), &nanosec = values.numbers("header.stamp.nanosec");
    const bool header = topic.spec.stamps == StampSource::kHeader && !sec.empty() && !nanosec.empty();
    const bool none = header && sec[0] == 0.0 && nanosec[0] == 0.0;
    if (header && !none && !stamp_origin_) stamp_origin_ = sec[0];
    if (header) track.stamp.push_back(none ? kMissing : sec[0] - *stamp_origin_ + 1e-9 * nanosec[0]);
    track.time.push_back(receive);
    topic.by_joint ? add_joints(i, &track) : add_values(i, &track);
  }

  // Messages of one topic may contain different joints (a gripper's driver beside the arm's). Each set of joints is a
  // track.
  Track& find_joint_track(size_t i) {
    const BoundTopic& topic = topics_[i];
    const std::vector<std::string>& names = topic.names.empty() ? topic.spec.joints : values_[i].texts(topic.names);
    std::vector<std::string> columns;
    for (size_t p = 0; p < topic.paths.size(); ++p) {
      const size_t size = values_[i].numbers(topic.paths[p]).size();
      if (size == 0) continue;
      if (size < names.size() || (size > names.size() && topic.spec.fields.empty()))
        refuse_input({bag_.path(), topic.spec.topic},
                     "message " + std::to_string(count_[i]) + ": field '" + topic.paths[p] + "' has " +
                         std::to_string(size) + " elements, expected " + std::to_string(names.size()) +
                         ", one for each joint" +
                         (topic.paths[p].rfind("points", 0) == 0
                              ? " (trajectories of one point are commands, longer ones are plans)"
                              : ""));
      for (const std::string& name : names)
        columns.push_back("/" + topic.spec.signal + "/" + find_model_name(topic, name) + "/" + topic.columns[p]);
    }
    return find_track(i, columns);
  }

  static std::string find_model_name(const BoundTopic& topic, const std::string& name) {
    const auto at = topic.spec.rename.find(name);
    return at == topic.spec.rename.end() ? name : at->second;
  }

  Track& find_track(size_t i, const std::vector<std::string>& columns) {
    for (Track& track : tracks_) {
      if (track.topic == &topics_[i] && track.columns == columns) return track;
    }
    Track track;
    track.topic = &topics_[i];
    track.columns = columns;
    track.values.resize(columns.size());
    tracks_.push_back(std::move(track));
    return tracks_.back();
  }

  void add_joints(size_t i, Track* track) {
    const BoundTopic& topic = topics_[i];
    const size_t joints = topic.names.empty() ? topic.spec.joints.size() : values_[i].texts(topic.names).size();
    size_t column = 0;
    for (const std::string& path : topic.paths) {
      const std::vector<double>& values = values_[i].numbers(path);
      for (size_t j = 0; j < joints && !values.empty(); ++j) track->values[column++].push_back(values[j]);
    }
  }

  void add_values(size_t i, Track* track) {
    for (size_t p = 0; p < topics_[i].paths.size(); ++p) {
      const std::vector<double>& values = values_[i].numbers(topics_[i].paths[p]);
      track->values[p].push_back(values.empty() ? kMissing : values[0]);
    }
  }

  // The track whose clock the table uses: the first topic of joint states, else the first topic.
  const Track& find_leader() const {
    for (const Track& track : tracks_) {
      if (track.is_states()) return track;
    }
    return tracks_.front();
  }

  void report() {
    std::set<std::string> strangers;
    bool any = false;
    for (Track& track : tracks_) {
      notes_->push_back("topic " + track.topic->spec.topic + ", " + describe_clock(track.clock, leader_name_));
      if (!track.topic->by_joint) continue;
      for (size_t c = track.columns.size(); c-- > 0;) {
        const size_t begin = track.columns[c].find('/', 1) + 1;
        const std::string joint = track.columns[c].substr(begin, track.columns[c].rfind('/') - begin);
        const bool known = has(robot_.joints, joint);
        any = any || known;
        if (known) continue;
        strangers.insert(joint);
        track.columns.erase(track.columns.begin() + static_cast<long>(c));
        track.values.erase(track.values.begin() + static_cast<long>(c));
      }
    }
    const std::string list = join_words(strangers);
    if (!strangers.empty() && !any) {
      refuse_input({bag_.path(), tracks_[0].topic->spec.topic},
                   "the robot has no joint of the bag (" + list + ")" + suggest(*strangers.begin(), robot_.joints) +
                       "; names are mapped with 'joints: {name in the bag: name in the model}' under topics");
    }
    if (!strangers.empty()) notes_->push_back("joints that the model does not have were left out: " + list);
  }

  // The fastest topic of joint states, else of all topics.
  const Track& find_master() const {
    const Track* best = nullptr;
    for (const bool states : {true, false}) {
      for (const Track& track : tracks_) {
        if (track.columns.empty() || (states && !track.is_states()) || track.clock.period <= 0.0) continue;
        if (best == nullptr || track.clock.period < best->clock.period) best = &track;
      }
      if (best) return *best;
    }
    refuse_input({bag_.path(), topics_[0].spec.topic}, "has fewer than two samples");
  }

  // Rows [begin, end) of the master in which all topics of joint states send and every command was given at least once.
  std::vector<std::pair<size_t, size_t>> find_stretches(const Track& master) const {
    double from = -HUGE_VAL;
    for (const Track& track : tracks_) {
      if (track.is_held() && !track.columns.empty()) from = std::max(from, track.time.front());
    }
    std::vector<std::pair<size_t, size_t>> out;
    size_t begin = 0;
    const auto close = [&](size_t end) {
      if (end > begin + 1 && master.time[end - 1] - master.time[begin] >= kShortestPart)
        out.emplace_back(begin, end);
      else if (end > begin + 1)
        notes_->push_back("a stretch of " + number(master.time[end - 1] - master.time[begin], 2) +
                          " s between gaps is left out");
    };
    for (size_t k = 0; k < master.time.size(); ++k) {
      const bool jump = k > begin && master.time[k] - master.time[k - 1] > master.gap();
      if (jump) {
        notes_->push_back("topic " + master.topic->spec.topic + " is silent from " + number(master.time[k - 1], 5) +
                          " to " + number(master.time[k], 5) + " s: nothing is carried across");
        close(k);
        begin = k;
      }
      if (master.time[k] >= from && is_covered(master.time[k])) continue;
      close(k);
      begin = k + 1;
    }
    close(master.time.size());
    return out;
  }

  bool is_covered(double t) const {
    return std::all_of(tracks_.begin(), tracks_.end(), [&](const Track& track) {
      if (!track.is_states() || track.columns.empty()) return true;
      const size_t next =
          static_cast<size_t>(std::lower_bound(track.time.begin(), track.time.end(), t) - track.time.begin());
      if (next == track.time.size()) return false;
      return track.time[next] == t || (next > 0 && track.time[next] - track.time[next - 1] <= track.gap());
    });
  }

  BagTable make_table(const Track& master, size_t begin, size_t end, bool several) const {
    BagTable out;
    Table& table = out.table;
    table.file = bag_.path();
    table.names.push_back("time");
    table.columns.emplace_back(master.time.begin() + static_cast<long>(begin),
                               master.time.begin() + static_cast<long>(end));
    for (size_t k = begin; k < end; ++k) table.lines.push_back(static_cast<int>(k) + 2);
    if (several) out.part = " (" + number(master.time[begin], 4) + " to " + number(master.time[end - 1], 4) + " s)";
    const std::vector<double> time = table.columns[0];
    for (const Track& track : tracks_) {
      for (size_t c = 0; c < track.columns.size(); ++c) {
        std::vector<double> values = sample(track, c, time);
        const auto same = std::find(table.names.begin(), table.names.end(), track.columns[c]);
        if (same == table.names.end()) {
          table.names.push_back(track.columns[c]);
          table.columns.push_back(std::move(values));
          continue;
        }
        std::vector<double>& there = table.columns[static_cast<size_t>(same - table.names.begin())];
        for (size_t k = 0; k < there.size(); ++k) there[k] = std::isfinite(there[k]) ? there[k] : values[k];
      }
    }
    return out;
  }

  // A column at the times of rows: commands held, readings linear, NaN across gaps and beyond the ends.
  static std::vector<double> sample(const Track& track, size_t column, const std::vector<double>& time) {
    const std::vector<double>& values = track.values[column];
    const std::string& name = track.columns[column];
    // q and -q are the same attitude, and pi and -pi the same angle. Where one turns into the other, the nearer sample
    // is used.
    const bool turn = name.find("/orientation/") != std::string::npos;
    const bool angle = name.rfind("/joint_states/", 0) == 0 && ends_with(name, "/position");
    const double jump = turn ? 0.5 : angle ? kJump : HUGE_VAL;
    std::vector<double> out(time.size(), kMissing);
    size_t at = 0;
    for (size_t k = 0; k < time.size(); ++k) {
      while (at + 1 < track.time.size() && track.time[at + 1] <= time[k]) ++at;
      if (track.time[at] > time[k]) continue;
      const bool last = at + 1 == track.time.size();
      if (track.is_held() || track.time[at] == time[k]) {
        out[k] = values[at];
      } else if (!last && track.time[at + 1] - track.time[at] <= track.gap()) {
        const double s = (time[k] - track.time[at]) / (track.time[at + 1] - track.time[at]);
        const bool jumps = std::abs(values[at + 1] - values[at]) > jump;
        out[k] = jumps ? values[s < 0.5 ? at : at + 1] : values[at] + s * (values[at + 1] - values[at]);
      }
    }
    return out;
  }

  const RosBag bag_;
  const BagRobot& robot_;
  std::vector<std::string>* notes_;
  const std::vector<BoundTopic> topics_;
  std::vector<RosValues> values_;  // by topic
  std::vector<size_t> count_;      // messages by topic
  std::vector<Track> tracks_;
  int64_t origin_ = 0;                  // [ns] receive time of the first message
  std::optional<double> stamp_origin_;  // [s] whole seconds of the first stamp; 0 s is one, too
  std::string leader_name_;             // topic on whose clock everything is placed
};

}  // namespace

std::vector<BagTable> read_bag(const std::string& path, const TopicMap& map, const BagRobot& robot,
                               const std::string& experiment, std::vector<std::string>* notes) {
  return BagReader(path, map, robot, experiment, notes).read();
}

}  // namespace hrp::diagnosis
