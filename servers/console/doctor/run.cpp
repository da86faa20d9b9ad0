// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/doctor/run.h"

#include <chrono>

#include "common/base/printable.h"
#include "common/messages/pubsub.h"
#include "common/messages/topics.h"
#include "common/node/run_token.h"
#include "hrp_idl/scheduling.h"

namespace hrp {
namespace {

constexpr auto kPatience = std::chrono::seconds(3);  // the scheduler speaks every 0.2 s

std::string join_lines(std::string text) {
  for (char& c : text) c = c == '\n' ? ' ' : c;
  return make_printable_line(text);
}

Finding judge_phase(const msg::RunStatus& status) {
  const std::string place = "step " + std::to_string(status.step());
  const std::string late = make_printable_line(status.late());
  switch (status.phase()) {
    case msg::RUN_RUNNING:
      if (late.empty()) return make_ok("phase", "it runs, " + place);
      return make_problem("phase", "it waits for " + late + " at " + place, "start or mend " + late);
    case msg::RUN_PAUSED:
      return make_problem("phase", "it is paused at " + place + ", so nothing is sent", "build/bin/hrp-run run");
    case msg::RUN_FINISHED: return make_problem("phase", "it has ended", "start another: scripts/simulate.sh");
    case msg::RUN_FAILED:
      return make_problem("phase", "it has failed: " + join_lines(status.message()), "see its terminal");
    default:
      return make_problem("phase", "it waits for " + (late.empty() ? "its servers" : late),
                          "start " + (late.empty() ? "them" : late));
  }
}

}  // namespace

Finding judge_choice(const RunChoice& choice) {
  if (choice.run && choice.run->registered) return make_ok("run", join_lines(describe_entry(choice.run->entry)));
  if (choice.run) {
    const std::string says =
        "domain " + std::to_string(choice.run->entry.domain) + " is no run of this user on this machine";
    if (choice.run->entry.token.empty())
      return make_problem("run", says + ": it may be looked at, not steered",
                          "HRP_RUN_TOKEN of that run, or its domain: build/bin/hrp-run list");
    return make_ok("run", says + "; HRP_RUN_TOKEN is set");
  }
  if (!choice.several.empty())
    return make_problem("run", "several go on, so programs ask which",
                        "add --run " + std::to_string(choice.several[0].process_id) + " (build/bin/hrp-run list)");
  return make_problem("run", join_lines(choice.problem),
                      "scripts/simulate.sh; as the same user, with the same XDG_RUNTIME_DIR");
}

Finding check_phase(Bus& bus, const RunEntry& run) {
  msg::RunStatus status;
  bool heard = false;
  const auto reader =
      subscribe<msg::RunStatus>(bus, topics::kRunStatus, Delivery::kReliable, [&](const msg::RunStatus& m) {
        if (!may_believe(run.token, status, m)) return;
        status = m;
        heard = true;
      });
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < end) {
    {
      std::lock_guard<std::recursive_mutex> lock(bus.mutex());
      if (heard) return judge_phase(status);
    }
    bus.spin(std::chrono::milliseconds(10));
  }
  return make_problem("phase", "no scheduler is heard in domain " + std::to_string(run.domain),
                      "another domain, vendor file or interface; see the lines above");
}

}  // namespace hrp
