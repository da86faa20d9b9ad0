// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/report/finding_head.h"

#include "diagnosis/estimate/enough.h"

namespace hrp::diagnosis {

Json make_finding_head(const EffectInfo& effect, const Json& where, const Json& parameters, Grade grade, double share) {
  return {{"effect", effect.name},
          {"family", get_family_name(effect.family)},
          {"where", where},
          {"parameters", parameters},
          {"grade", get_grade_name(grade)},
          {"probability", kSurest},
          {"share", round_to(share, 3)},
          {"weight", round_to(share, 3)}};
}

Json state_alternative(const EffectInfo& effect, const Json& where, const Json& parameters) {
  return {{"effect", effect.name}, {"family", get_family_name(effect.family)}, {"where", where}, {"parameters", parameters}};
}

Json make_untold(const std::string& effect, const Json& where, const std::string& why, const std::string& motion) {
  Json out{{"effect", effect}};
  if (!where.is_null()) out["where"] = where;
  out["why"] = why, out["motion_that_would_tell"] = motion;
  return out;
}

const char* name_verdict(bool mismatch, bool explained, bool partly) {
  if (!mismatch) return get_verdict_name(Verdict::kNoMismatch);
  return get_verdict_name(explained ? Verdict::kExplained : partly ? Verdict::kPartlyExplained : Verdict::kUnexplained);
}

}  // namespace hrp::diagnosis
