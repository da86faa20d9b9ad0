// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/estimate_words.h"

#include "common/base/rounding.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {

std::string describe(const std::vector<Estimate>& parameters) {
  std::string text;
  for (const Estimate& e : parameters) {
    std::string value;
    for (size_t i = 0; i < e.value.size(); ++i)
      value += (i > 0 ? ", " : "") +
               (e.is_unseen(i) ? "unseen"
                               : number(e.value[i], 3) + (e.assumed ? "" : " +- " + number(kNinetyFive * e.std[i], 2)));
    text += (text.empty() ? "" : ", ") + e.name + " " + (e.vector ? "(" + value + ")" : value) +
            (e.unit == "1" ? "" : " " + e.unit) + (e.assumed ? " (assumed)" : "");
  }
  return text;
}

}  // namespace hrp::diagnosis
