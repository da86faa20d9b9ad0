// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/finding_head.h"

#include "common/base/rounding.h"
#include "diagnosis/estimate/enough.h"

namespace hrp::diagnosis {

using Json = nlohmann::ordered_json;

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

Json state_alternative(const EffectInfo& effect, const Json& where, const Json& parameters, const std::string& motion) {
  Json out{{"effect", effect.name},
           {"family", get_family_name(effect.family)},
           {"where", where},
           {"parameters", parameters}};
  if (!motion.empty()) out["motion_that_would_tell"] = motion;
  return out;
}

}  // namespace hrp::diagnosis
