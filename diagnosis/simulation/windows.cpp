// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/simulation/windows.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/base/parallel_for.h"

namespace hrp::diagnosis {
namespace {

struct Window {
  int recording = 0;
  size_t begin = 0, end = 0;  // samples
};

void add_windows(const Experiment& e, const SmoothRecording& smooth, int recording, std::vector<Window>* list) {
  const std::vector<double>& time = e.recordings[static_cast<size_t>(recording)].time;
  size_t begin = smooth.start;
  for (size_t k = begin; k < time.size(); ++k) {
    if (time[k] - time[begin] < kWindow) continue;
    if (time[k] - time[begin] < 1.5 * kWindow) list->push_back({recording, begin, k});  // no gap within
    begin = k;
  }
}

std::vector<Window> choose(const std::vector<Window>& all) {
  if (all.size() <= kMostWindows) return all;
  std::vector<Window> out;
  for (size_t i = 0; i < kMostWindows; ++i) out.push_back(all[all.size() * i / kMostWindows]);
  return out;
}

// Sums of squared errors and counts by joint.
struct Sums {
  std::vector<double> square, count;
  int finite = 0;
};

std::vector<double> cut(const std::vector<double>& v, const Window& w) {
  return v.empty()
             ? v
             : std::vector<double>(v.begin() + static_cast<long>(w.begin), v.begin() + static_cast<long>(w.end + 1));
}

// Copies the part of a recording that a window needs.
Recording cut(const Recording& in, const Window& w) {
  Recording out;
  out.spec = in.spec;
  out.time = cut(in.time, w);
  for (const JointColumns& joint : in.joints) {
    JointColumns own;
    for (size_t q = 0; q < kQuantities; ++q) own.signal[q] = cut(joint.signal[q], w);
    own.command = cut(joint.command, w);
    own.command_rate = cut(joint.command_rate, w);
    out.joints.push_back(std::move(own));
  }
  return out;
}

SmoothRecording cut(const SmoothRecording& in, const Window& w) {
  SmoothRecording out;
  for (const SmoothJoint& joint : in.joints) {
    SmoothJoint own = joint;
    own.q = cut(joint.q, w);
    own.qd = cut(joint.qd, w);
    own.qdd = cut(joint.qdd, w);
    out.joints.push_back(std::move(own));
  }
  for (const std::vector<double>& effort : in.effort) out.effort.push_back(cut(effort, w));
  return out;
}

// `plant`: with the loads and forces by hand in this recording.
bool simulate(const Plant& plant, const Recording& recording, const SmoothRecording& smooth, const Window& w,
              std::vector<double>* readings) {
  RolloutOptions options;
  options.free_running = true;
  readings->assign(recording.size() * recording.joints.size() * kQuantities, 0.0);
  return simulate_recording(plant, recording, cut(smooth, w), options, readings);
}

void add_window(const Plant& plant, const Experiment& e, const SmoothRecording& smooth, const Window& w, Sums* sums) {
  const Recording recording = cut(e.recordings[static_cast<size_t>(w.recording)], w);
  const size_t n = static_cast<size_t>(e.num_joints()), width = n * kQuantities;
  std::vector<double> readings;
  const bool ok = simulate(plant, recording, smooth, w, &readings);
  sums->finite += ok;
  for (size_t j = 0; j < n; ++j) {
    const std::vector<double>& q = recording.joints[j].signal[0];
    for (size_t k = 1; k < q.size(); ++k) {
      if (!std::isfinite(q[k])) continue;
      const double error =
          ok ? std::min(2.0 * M_PI, std::abs(q[k] - readings[k * width + j * kQuantities])) : 2.0 * M_PI;
      sums->square[j] += error * error;
      sums->count[j] += 1.0;
    }
  }
}

}  // namespace

WindowErrors calc_window_errors(const Plant& plant, const Experiment& e, const std::vector<SmoothRecording>& smooth,
                                const std::vector<int>& recordings, int jobs) {
  std::vector<Window> all;
  std::map<int, Plant> held;  // by recording
  for (int r : recordings) {
    add_windows(e, smooth[static_cast<size_t>(r)], r, &all);
    held.emplace(r, add_by_hand(plant, e.recordings[static_cast<size_t>(r)].spec));
  }
  const std::vector<Window> windows = choose(all);
  const size_t n = static_cast<size_t>(e.num_joints());
  std::vector<Sums> parts(windows.size());
  parallel_for(jobs, static_cast<int>(windows.size()), [&](int i) {
    const Window& w = windows[static_cast<size_t>(i)];
    Sums& sums = parts[static_cast<size_t>(i)];
    sums.square.assign(n, 0.0);
    sums.count.assign(n, 0.0);
    add_window(held.at(w.recording), e, smooth[static_cast<size_t>(w.recording)], w, &sums);
  });
  WindowErrors out;
  std::vector<double> square(n, 0.0), count(n, 0.0);
  for (const Sums& s : parts) {  // in order, so that sums are reproducible to the bit
    out.windows += s.finite;
    for (size_t j = 0; j < n; ++j) {
      square[j] += s.square[j];
      count[j] += s.count[j];
    }
  }
  for (size_t j = 0; j < n; ++j) out.rms.push_back(count[j] > 0.0 ? std::sqrt(square[j] / count[j]) : std::nan(""));
  return out;
}

bool simulate_windows(const Plant& plant, const Experiment& e, const SmoothRecording& smooth, int recording,
                      std::vector<double>* readings) {
  const Recording& whole = e.recordings[static_cast<size_t>(recording)];
  const size_t width = whole.joints.size() * kQuantities;
  readings->assign(whole.size() * width, 0.0);
  for (size_t c = 0; c < width; ++c) {
    const std::vector<double>& column = whole.joints[c / kQuantities].signal[c % kQuantities];
    for (size_t k = 0; k < column.size(); ++k) (*readings)[k * width + c] = column[k];
  }
  std::vector<Window> windows;
  add_windows(e, smooth, recording, &windows);
  const Plant held = add_by_hand(plant, whole.spec);
  for (const Window& w : windows) {
    std::vector<double> own;
    if (!simulate(held, cut(whole, w), smooth, w, &own)) return false;
    std::copy(own.begin() + static_cast<long>(width), own.end(),
              readings->begin() + static_cast<long>((w.begin + 1) * width));
  }
  return true;
}

}  // namespace hrp::diagnosis
