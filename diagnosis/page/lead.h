// SPDX-License-Identifier: BSD-3-Clause
// What a reader of the page sees first: the verdict in words, and a sentence or two.
#pragma once

#include <string>

#include "diagnosis/page/text.h"

namespace hrp::diagnosis::html {

struct VerdictWords {
  const char* verdict;
  const char* badge;
  const char* sentence;  // used when neither series nor findings say it better
};
const VerdictWords& find_verdict_words(const std::string& verdict);

// The headline, and the fit on held-out recordings in units of the noise.
std::string make_lead(const json& report);

// Parameters of a finding in the order of its row in the table: what the effect is first, details after it.
std::vector<std::pair<std::string, json>> list_parameters(const json& finding);

// "1.03 ± 0.28" of its first parameter, without name and unit.
std::string describe_number(const json& finding);

// Values with their intervals, in one line.
std::string describe_parameters(const json& finding);

// "lab/experiment.yaml" of "/a/b/lab/experiment.yaml"; anything else unchanged.
std::string shorten_path(const std::string& path);

}  // namespace hrp::diagnosis::html
