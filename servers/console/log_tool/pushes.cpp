// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "common/base/exact_number.h"
#include "common/messages/logged_description.h"
#include "common/messages/topics.h"
#include "servers/console/log_tool/commands.h"
#include "servers/console/log_tool/log_file.h"

namespace hrp {
namespace {

// A push that stays the same from one state to another.
struct Stretch {
  msg::PushForce push;
  uint64_t first = 0, last = 0;  // states: it acts from the first one to the last one
};

using Numbers = std::array<double, 6>;
Numbers get_numbers(const msg::PushForce& p) {
  return {p.p_LQ().x(), p.p_LQ().y(), p.p_LQ().z(), p.force().x(), p.force().y(), p.force().z()};
}

// States come in order; those of the scenario's own pushes and hands have names.
class StretchFinder {
 public:
  void take(const msg::RobotState& state) {
    const uint64_t step = state.header().step();
    if (step > 0) time_step_ = state.header().time() / static_cast<double>(step);
    for (const msg::PushForce& push : state.pushes()) {
      if (push.name().empty()) add(push, step);
    }
  }
  const std::vector<Stretch>& stretches() const { return stretches_; }
  double time_step() const { return time_step_; }

 private:
  // The forces of state k acted over the step that began at state k - 1.
  void add(const msg::PushForce& push, uint64_t step) {
    const auto open = open_.find(push.link());
    if (open != open_.end()) {
      Stretch& stretch = stretches_[open->second];
      if (stretch.last + 1 == step && get_numbers(stretch.push) == get_numbers(push)) {
        stretch.last = step;
        return;
      }
    }
    open_[push.link()] = stretches_.size();
    stretches_.push_back({push, step - 1, step});
  }

  std::vector<Stretch> stretches_;
  std::map<std::string, size_t> open_;  // the newest of each link
  double time_step_ = 0.0;
};

std::string format_vector(const msg::Vector3& v) {
  return "[" + format_exact(v.x()) + ", " + format_exact(v.y()) + ", " + format_exact(v.z()) + "]";
}

}  // namespace

int show_pushes(const std::string& file) {
  LogFile log(file);
  log.find_topic(topics::kRobotState.name);  // refuses logs of something else
  StretchFinder finder;
  log.reader().read_messages(
      [&](const mcap::Message& message) {
        msg::RobotState state;
        decode_logged(get_bytes(message), &state);
        finder.take(state);
        return true;
      },
      {topics::kRobotState.name});
  if (finder.stretches().empty()) {
    std::printf("# nobody pushed the robot in %s\n", file.c_str());
    return say_damage(log.reader());
  }
  std::printf("# Live pushes of %s. In its scenario, they repeat the run to the bit.\npushes:\n", file.c_str());
  size_t number = 0;
  for (const Stretch& stretch : finder.stretches()) {
    const double dt = finder.time_step();
    std::printf("  live_%zu: {link: %s, xyz: %s, force: %s, start: %s, duration: %s}\n", ++number,
                stretch.push.link().c_str(), format_vector(stretch.push.p_LQ()).c_str(),
                format_vector(stretch.push.force()).c_str(),
                format_exact(static_cast<double>(stretch.first) * dt).c_str(),
                format_exact(static_cast<double>(stretch.last - stretch.first) * dt).c_str());
  }
  return say_damage(log.reader());
}

}  // namespace hrp
