// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "diagnosis/generator/recorder.h"

namespace hrp::cases {

// What kind of case is wanted: a robot, the effects hidden in it (none: a case without), and the family it counts for.
struct CaseRequest {
  // none, joint, link, sensor, pair, pair_same_joint, triple, unknown for arms; with `stand_` in front for standing
  // robots, where `stand_foot` is what sits below the force sensor. Worlds like reality: arm_dirty, stand_dirty,
  // walk_dirty.
  std::string family;
  bool biped = false;
  std::vector<std::string> effects;
  bool walk = false;  // in closed loop under our controller

  bool is_dirty() const { return family.find("dirty") != std::string::npos; }  // a world like reality
};

// A finished case: file name -> contents, and the truth that goes elsewhere.
struct Case {
  std::map<std::string, std::string> files;
  nlohmann::ordered_json truth;
};

struct CaseOptions {
  double duration = 10;              // [s] of the longest recordings; a case's own is 0.6 to 1 of it
  std::string urdf;                  // robot of the cases, hung up or on its feet; empty: drawn
  std::string models;                // folder of the robots that walk: hrp1s_like/, hrp2p_like/
  std::vector<std::string> sensors;  // of fixed bases, beside encoders: joint_torque, link_encoder, imu, wrench
  double noise_scale = 1;            // 0: recordings without noise (self-check)
  double poor = 0;  // [s] of first recordings that tell little, in the place of the usual ones; 0: usual
  std::vector<std::string> played;  // files of commands: further recordings of the same robot
  bool multisines = false;          // not these commands, but multisines of their lengths
};

// `count` requests that cover every effect evenly, in an order drawn from the seed. `family`: only these, a comma list
// of family names, of `arm`, `stand`, `single` or `dirty`; empty: all but dirty ones. Throws std::invalid_argument
// where nothing is left.
std::vector<CaseRequest> make_case_plan(int count, std::uint64_t seed, const std::string& family = "");

// A request for named effects, such as "coulomb_friction" or "rotor_inertia+cogging" or "none" or "stand:payload".
CaseRequest parse_request(const std::string& text);

// Draws robot, places, sizes, motions and noise until a case runs sanely and each effect shows above the noise.
// The same request and seed give the same bytes.
Case make_case(const CaseRequest& request, std::uint64_t seed, const CaseOptions& options);

// Calls `make` with the seed, then with other ones while it throws std::runtime_error, as make_case does where no draw
// of a robot can do it. The truth says how many were given up ("given_up"). Throws where the last one fails, too.
Case make_with_other_seeds(const std::function<Case(std::uint64_t seed)>& make, std::uint64_t seed);

// The same for a robot that walks; its requests have families that begin with `walk_`.
Case make_walk_case(const CaseRequest& request, std::uint64_t seed, const CaseOptions& options);
std::vector<CaseRequest> make_walk_round(Prng& random);
std::vector<CaseRequest> make_dirty_walk_round(Prng& random);
CaseRequest make_walk_request(std::vector<std::string> effects);

}  // namespace hrp::cases
