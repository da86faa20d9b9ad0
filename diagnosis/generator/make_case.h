// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "diagnosis/generator/recorder.h"

namespace hrp::cases {

// What kind of case is wanted: a robot, the effects hidden in it (none: a case without), and the family it counts for.
struct CaseRequest {
  std::string family;  // none, stand_none, joint, link, foot, sensor, stand, unknown, pair, triple
  bool biped = false;
  std::vector<std::string> effects;
};

// A finished case: file name -> contents, and the truth that goes elsewhere.
struct Case {
  std::map<std::string, std::string> files;
  nlohmann::ordered_json truth;
};

struct CaseOptions {
  double duration = 10;    // [s] of a recording
  double noise_scale = 1;  // 0: recordings without noise (self-check)
};

// `count` requests that cover every effect evenly, in an order drawn from the seed.
std::vector<CaseRequest> make_deck(int count, std::uint64_t seed);

// A request for named effects, such as "coulomb_friction" or "rotor_inertia+cogging" or "none" or "stand:payload".
CaseRequest parse_request(const std::string& text);

// Draws robot, places, sizes, motions and noise until a case runs sanely and each effect shows above the noise.
// The same request and seed give the same bytes.
Case make_case(const CaseRequest& request, std::uint64_t seed, const CaseOptions& options);

}  // namespace hrp::cases
