// SPDX-License-Identifier: BSD-3-Clause
// What an expert would say first of a report: what is missing and where, how much nearer the model comes, what is left.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/page/text.h"

namespace hrp::diagnosis::html {

// Plain sentences, most important first. Three findings or fewer keep the statements of the engine that found them;
// more are grouped by effect.
std::vector<std::string> make_headline(const json& report);

// Findings of one effect with the same values at several places (one bus that is late for all joints) count as one.
struct FindingGroup {
  std::vector<const json*> findings;
  bool is_shared() const { return findings.size() > 1; }
};
std::vector<FindingGroup> list_shared(const json& report);

// "Stribeck friction, payload": what the recordings cannot tell a finding from.
std::string list_alternatives(const json& finding);

// "joint elbow", "12 joints".
std::string describe_places(const std::vector<const json*>& findings);

}  // namespace hrp::diagnosis::html
