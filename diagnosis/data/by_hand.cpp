// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/by_hand.h"

#include <algorithm>

#include "common/base/diagnostics.h"
#include "common/base/rounding.h"
#include "diagnosis/data/gaps.h"
#include "diagnosis/data/stretches.h"

namespace hrp::diagnosis {
namespace {

constexpr double kHand = 0.3;  // [s] uncertainty of the times at which a force starts and ends

[[noreturn]] void refuse(const Experiment& e, const RecordingSpec& spec, const std::string& what,
                         const std::string& text) {
  refuse_input({e.path, spec.name + "." + what, spec.line}, text);
}

// Converts a link name and a point in its frame to the moving link.
void resolve(const Experiment& e, const RecordingSpec& spec, const char* what, std::string* link, Vector3d* p) {
  const TreeSpec& tree = e.robot.tree;
  const int frame = tree.find_frame(*link);
  if (frame < 0 && tree.find_link(*link) < 0) refuse(e, spec, what, "the robot has no link '" + *link + "'");
  if (frame < 0) return;
  const FrameSpec& f = tree.frames[static_cast<size_t>(frame)];
  *p = f.X_LF * *p;
  *link = tree.links[static_cast<size_t>(f.link)].name;
}

// Start and end of a force [s], with the uncertain time around them.
struct Change {
  double start, end;
};

std::vector<Change> list_unknown(const Experiment& e, const RecordingSpec& spec) {
  std::vector<Change> list;
  for (const HandPush& push : spec.pushes) {
    if (!push.known || e.scenario.floating_base) {
      list.push_back({push.start - kHand, push.end + kHand});
      continue;
    }
    if (push.start > 0.0) list.push_back({push.start - kHand, push.start + kHand});
    list.push_back({push.end - kHand, push.end + kHand});
  }
  return list;
}

bool is_in(const std::vector<Change>& list, double t) {
  return std::any_of(list.begin(), list.end(), [&](const Change& c) { return t >= c.start && t <= c.end; });
}

std::vector<HandPush> list_acting(const std::vector<HandPush>& all, double t) {
  std::vector<HandPush> acting;
  for (const HandPush& push : all) {
    if (push.known && t >= push.start && t <= push.end) acting.push_back(push);
  }
  return acting;
}

void warn_of_pushes_beyond(const Recording& r, std::vector<std::string>* warnings) {
  for (const HandPush& push : r.spec.pushes) {
    if (push.start <= r.duration() && push.end >= 0.0) continue;
    warnings->push_back(r.spec.name + ": a push from " + number(push.start, 4) + " to " + number(push.end, 4) +
                        " s lies beyond the recording's " + number(r.duration(), 4) +
                        " s; its times count from the first sample");
  }
}

}  // namespace

void resolve_by_hand(const Experiment& e, Recording* recording) {
  RecordingSpec& spec = recording->spec;
  if (!spec.loads.empty() && e.scenario.floating_base)
    refuse(e, spec, "loads", "a load by hand is predicted on a fixed base only; leave the recording out");
  for (LoadSpec& load : spec.loads) resolve(e, spec, "loads", &load.link, &load.p_LC);
  for (HandPush& push : spec.pushes) {
    if (!push.link.empty()) resolve(e, spec, "pushes", &push.link, &push.p_LQ);
  }
}

std::vector<Recording> cut_at_pushes(const Experiment& e, const Recording& r, std::vector<std::string>* warnings) {
  warn_of_pushes_beyond(r, warnings);
  const std::vector<Change> unknown = list_unknown(e, r.spec);
  if (unknown.empty()) return {r};
  std::vector<Recording> pieces;
  double lost = 0.0;
  for (size_t begin = 0; begin < r.size();) {
    const bool out = is_in(unknown, r.time[begin] - r.time.front());
    size_t end = begin + 1;
    while (end < r.size() && is_in(unknown, r.time[end] - r.time.front()) == out) ++end;
    const double seconds = r.time[end - 1] - r.time[begin];
    if (out || seconds < kShortestPart) {
      lost += seconds;
    } else {
      pieces.push_back(begin == 0 && end == r.size() ? r : cut_recording(r, begin, end));
      pieces.back().spec.pushes = list_acting(r.spec.pushes, r.time[begin] - r.time.front());
    }
    begin = end;
  }
  if (lost > 0.0)
    warnings->push_back(r.spec.name + ": " + number(lost, 3) + " s with a force that is not known are left out");
  return pieces;
}

}  // namespace hrp::diagnosis
