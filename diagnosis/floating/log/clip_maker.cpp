// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/log/clip_maker.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/base/format.h"
#include "diagnosis/data/gaps.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kSigma = 0.015;   // [s] kernel: passes what a walking body does, below 10 Hz
constexpr double kSamples = 1.2;   // the same in samples, at least: coarser grids alias
constexpr double kSlowest = 0.02;  // [s] of sensors that set the kernel: it would swallow steps of a walk beyond
constexpr double kOfEdge = 4;      // times the kernel's reach that a clip is long: half of it is left

// The columns of a recording by sensor: "/imu/root/angular_velocity" -> its axes.
using Groups = std::map<std::string, std::vector<const std::vector<double>*>>;
Groups find_groups(const Recording& r) {
  Groups groups;
  for (const auto& [name, column] : r.other) groups[name.substr(0, name.rfind('/'))].push_back(&column);
  return groups;
}

class ClipMaker {
 public:
  ClipMaker(const Experiment& e, size_t index, Half half, LeggedLog* log)
      : r_(e.recordings[index]), index_(index), half_(half), log_(*log) {}

  void run() {
    find_fresh();
    find_periods();
    std::vector<Gap> gaps;
    const std::vector<Span> spans =
        find_spans(r_.time, any_fresh_, std::max(kLongestStep, kLostPeriods * step_), &gaps);
    note_gaps(gaps);
    const size_t before = log_.clips.size();
    for (const Span& span : spans) {
      if (span.end > span.begin + 8 && r_.time[span.end - 1] - r_.time[span.begin] > kBlock) add_clip(span);
    }
    if (log_.clips.size() == before) note_short(gaps.size());
  }

 private:
  void find_fresh() {
    any_fresh_.assign(r_.size(), 0);
    std::vector<char> blank(r_.size(), 0);
    const auto merge = [&](const std::vector<char>& fresh) {
      for (size_t k = 0; k < fresh.size(); ++k) any_fresh_[k] |= fresh[k];
    };
    for (const auto& [name, columns] : find_groups(r_)) {
      const std::vector<char> changes = find_new_samples(columns);
      fresh_[name] = find_readings(columns, changes);
      merge(changes);
      note_held(name, fresh_[name], *columns[0]);
      add_period(fresh_[name]);
      add_blanks(columns[0], &blank);
    }
    for (const JointColumns& joint : r_.joints) {
      if (!joint.has(Quantity::kPosition)) continue;
      merge(find_new_samples({&joint.signal[0]}));
      // Encoders that stand still repeat themselves: every sample that is there is a reading.
      std::vector<char> there;
      for (double q : joint.signal[0]) there.push_back(std::isfinite(q));
      add_period(there);
      add_blanks(&joint.signal[0], &blank);
    }
    any_fresh_.front() = any_fresh_.back() = 1;
    for (size_t k = 0; k < blank.size(); ++k) any_fresh_[k] = any_fresh_[k] && !blank[k];
  }

  // Where a sensor wrote nothing for long, no other one's reading stands for it.
  void add_blanks(const std::vector<double>* column, std::vector<char>* blank) const {
    size_t last = 0;
    const double longest = std::max(kLongestStep, kLostPeriods * (periods_.empty() ? 0 : periods_.back()));
    for (size_t k = 1; k <= column->size(); ++k) {
      if (k < column->size() && !std::isfinite((*column)[k])) continue;
      if (k - last > 1 && r_.time[std::min(k, r_.size() - 1)] - r_.time[last] > longest) {
        std::fill(blank->begin() + static_cast<long>(last) + 1, blank->begin() + static_cast<long>(k), 1);
      }
      last = k;
    }
  }

  void add_period(const std::vector<char>& fresh) {
    std::vector<double> steps;
    double last = -1e300;
    for (size_t k = 0; k < fresh.size(); ++k) {
      if (!fresh[k]) continue;
      if (last > -1e300) steps.push_back(r_.time[k] - last);
      last = r_.time[k];
    }
    if (!steps.empty()) periods_.push_back(find_median(std::move(steps)));
  }

  // Sensors with clocks of their own may have rows of their own: the grid is that of the fastest, and the kernel passes
  // nothing that the slowest aliases, as far as steps of a body allow.
  void find_periods() {
    if (periods_.empty()) return;
    step_ = std::max(1e-3, *std::min_element(periods_.begin(), periods_.end()));
    slowest_ = std::max(step_, std::min(*std::max_element(periods_.begin(), periods_.end()), kSlowest));
  }

  void note_held(const std::string& name, const std::vector<char>& fresh, const std::vector<double>& column) {
    size_t count = 0;
    for (size_t k = 0; k < fresh.size(); ++k) count += !fresh[k] && std::isfinite(column[k]);
    if (static_cast<double>(count) < kMinor * static_cast<double>(fresh.size())) return;
    log_.notes.push_back(format("%s: %zu of %zu samples of %s repeat the one before (held); bridged",
                                r_.spec.name.c_str(), count, fresh.size(), name.c_str()));
  }

  void note_gaps(const std::vector<Gap>& gaps) {
    double longest = 0;
    for (const Gap& g : gaps) longest = std::max(longest, g.to - g.from);
    if (gaps.empty()) return;
    log_.notes.push_back(format("%s: %zu gaps without a new reading, up to %.0f ms; nothing is fitted across them",
                                r_.spec.name.c_str(), gaps.size(), 1e3 * longest));
  }

  void note_short(size_t gaps) {
    log_.too_short.push_back(format("%s lasts %.2g s%s: too short, %.2g s without a gap are needed",
                                    r_.spec.name.c_str(), r_.time.back() - r_.time.front(),
                                    gaps > 0 ? ", with gaps" : "", std::max(kBlock, kOfEdge * find_edge() * step_)));
  }

  double find_sigma() const { return half_ == Half::kAll ? 0 : std::max(kSigma, kSamples * 2 * slowest_); }
  double find_edge() const { return std::ceil(4 * find_sigma() / step_); }  // samples that the kernel reaches

  Track read(const Resampler& resampler, const std::string& column) const {
    const auto at = r_.other.find(column);
    if (at == r_.other.end()) return {};
    const auto fresh = fresh_.find(column.substr(0, column.rfind('/')));
    return resampler.run(at->second, fresh == fresh_.end() ? std::vector<char>{} : fresh->second);
  }

  void read_vector(const Resampler& resampler, const std::string& base, Track* xyz) const {
    for (int i = 0; i < 3; ++i) xyz[i] = read(resampler, base + "/" + "xyz"[i]);
  }

  void read_quaternion(const Resampler& resampler, const std::string& base, Track* wxyz) const {
    for (const char axis : {'w', 'x', 'y', 'z'}) {
      if (!r_.has(base + "/" + axis)) return;
    }
    for (int i = 0; i < 4; ++i) wxyz[i] = read(resampler, base + "/" + "wxyz"[i]);
  }

  void read_joints(const Resampler& resampler, Clip* clip) const {
    for (size_t j = 0; j < r_.joints.size(); ++j) {
      const JointColumns& c = r_.joints[j];
      const auto run = [&](const std::vector<double>& v) { return v.empty() ? Track{} : resampler.run(v); };
      clip->position.push_back(run(c.signal[0]));
      clip->effort.push_back(run(c.signal[static_cast<int>(Quantity::kEffort)]));
      clip->command.push_back(run(c.command));
      clip->command_rate.push_back(run(c.command_rate));
    }
  }

  void read_sensors(const Resampler& resampler, Clip* clip) const {
    for (const ForceSensor& s : log_.sensors) {
      for (int i = 0; i < 6; ++i) clip->force.push_back(read(resampler, get_force_column(s.name, i)));
    }
    for (const ImuSensor& imu : log_.imus) {
      ImuTracks t;
      const std::string base = "/imu/" + imu.name;
      read_vector(resampler, base + "/angular_velocity", t.gyro);
      read_vector(resampler, base + "/linear_acceleration", t.accelerometer);
      if (imu.attitude) read_quaternion(resampler, base + "/orientation", t.attitude);
      clip->imus.push_back(std::move(t));
    }
    read_vector(resampler, "/base/pose/position", clip->base_position);
    read_quaternion(resampler, "/base/pose/orientation", clip->base_attitude);
  }

  void add_roughness(const Resampler& resampler, const std::string& column, const Track& smooth, Clip* clip) const {
    const auto at = r_.other.find(column);
    clip->taken_away.push_back(at == r_.other.end() || smooth.empty() ? std::vector<double>(clip->size(), 0.0)
                                                                      : resampler.calc_roughness(at->second, smooth));
  }

  void find_roughness(const Resampler& resampler, Clip* clip) const {
    for (size_t i = 0; i < log_.imus.size(); ++i) {
      for (int a = 0; a < 3; ++a) {
        add_roughness(resampler, "/imu/" + log_.imus[i].name + "/linear_acceleration/" + "xyz"[a],
                      clip -> imus[i].accelerometer[a], clip);
      }
    }
    // An IMU feels every impact. Without one, vertical forces alone have to say where impacts are.
    const bool felt = !log_.imus.empty();
    for (size_t s = 0; s < log_.sensors.size(); ++s) {
      if (log_.sensors[s].has_force() || (!felt && log_.sensors[s].axis[2]))
        add_roughness(resampler, get_force_column(log_.sensors[s].name, 2), clip->force[6 * s + 2], clip);
    }
  }

  void add_clip(Span span) {
    const double sigma = find_sigma();
    const Resampler resampler(r_.time, span, step_, sigma, half_);
    Clip clip;
    clip.recording = index_;
    clip.train = r_.spec.train;
    clip.time = resampler.grid();
    clip.step = step_;
    clip.sigma = sigma;
    clip.edge = static_cast<size_t>(find_edge());
    if (static_cast<double>(clip.size()) < kOfEdge * find_edge()) return;
    read_joints(resampler, &clip);
    read_sensors(resampler, &clip);
    find_roughness(resampler, &clip);
    log_.clips.push_back(std::move(clip));
  }

  const Recording& r_;
  size_t index_;
  Half half_;
  LeggedLog& log_;
  double step_ = 1e-3, slowest_ = 1e-3;  // [s] of the grid; between new readings of the slowest sensor
  std::vector<double> periods_;          // [s] by sensor and joint
  std::map<std::string, std::vector<char>> fresh_;
  std::vector<char> any_fresh_;
};

}  // namespace

std::string get_force_column(const std::string& sensor, int axis) {
  static const char* const kAxes[] = {"force/x", "force/y", "force/z", "torque/x", "torque/y", "torque/z"};
  return "/wrench/" + sensor + "/" + kAxes[axis];
}

void add_clips(const Experiment& e, size_t index, Half half, LeggedLog* log) { ClipMaker(e, index, half, log).run(); }

// Samples of vibrations and impacts stand badly for what is between them: how much more than in the quietest quarter of
// the quietest clip the kernel takes away there; the worst of the columns.
void scale_roughness(LeggedLog* log) {
  const size_t columns = log->clips.empty() ? 0 : log->clips[0].taken_away.size();
  for (Clip& clip : log->clips) clip.roughness.assign(clip.size(), 1.0);
  for (size_t c = 0; c < columns; ++c) {
    double quiet = 1e300;
    for (const Clip& clip : log->clips) {
      std::vector<double> sorted = clip.taken_away[c];
      std::nth_element(sorted.begin(), sorted.begin() + static_cast<long>(sorted.size() / 4), sorted.end());
      if (sorted[sorted.size() / 4] > 0) quiet = std::min(quiet, sorted[sorted.size() / 4]);
    }
    for (Clip& clip : log->clips) {
      for (size_t k = 0; k < clip.size(); ++k)
        clip.roughness[k] = std::max(clip.roughness[k], clip.taken_away[c][k] / quiet);
    }
  }
  for (Clip& clip : log->clips) clip.taken_away.clear();
}

}  // namespace hrp::diagnosis::floating
