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
  return {{"effect", effect.name},
          {"family", get_family_name(effect.family)},
          {"where", where},
          {"parameters", parameters}};
}

}  // namespace hrp::diagnosis
