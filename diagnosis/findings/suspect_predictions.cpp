// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/suspect_predictions.h"

#include "common/base/rounding.h"
#include "diagnosis/findings/grading.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

std::string make_words(const Experiment& e, const SuspectJoint& s) {
  return e.robot.tree.joint(s.joint).name + ": the tool's own prediction is suspect" +
         (s.saturated ? ", its servo hums at the effort limit" : "") + ": with half the step it differs by " +
         number(s.change, 3) + " times the noise, the recordings by " + number(s.left, 3) +
         " times; what differs there is not called physics. A lighter servo or the true inertia of the link may mend "
         "it.";
}

}  // namespace

void warn_of_suspects(const Experiment& e, const std::vector<SuspectJoint>& suspects, Json* report) {
  for (const SuspectJoint& s : suspects) (*report)["warnings"].push_back(make_words(e, s));
}

void doubt_suspects(const Experiment& e, const std::vector<SuspectJoint>& suspects, Json* report) {
  warn_of_suspects(e, suspects, report);
  for (const SuspectJoint& s : suspects) {
    const Json where = {{"joint", e.robot.tree.joint(s.joint).name}};
    for (Json& f : (*report)["findings"]) {
      if (f["where"] == where) make_ambiguous(&f);
    }
    for (Json& u : (*report)["unexplained"]) {
      if (u["where"] == where) {
        u["depends_on"] = Json::array();
        u["statement"] = make_words(e, s);
      }
    }
  }
}

}  // namespace hrp::diagnosis
