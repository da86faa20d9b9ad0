// SPDX-License-Identifier: BSD-3-Clause
// What whole recordings of robots on their feet say: each alone, and their rests.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "diagnosis/floating/diagnose.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr size_t kHeld = 2;         // recording
constexpr double kRestsFrom = 5.0;  // [s] of 8

// Vertical forces alone, in counts.
Recorded make_counts() {
  Recorded recorded = kLeans;
  recorded.six_axes = false;
  recorded.unit = 7.0;
  return recorded;
}

// In one recording, from a time on, the feet read so much less.
void scale_from(double begin, double factor, size_t recording, Experiment* e) {
  Recording& r = e->recordings[recording];
  for (const char* sensor : {"l", "r"}) {
    std::vector<double>& force = r.other.at("/wrench/" + std::string(sensor) + "/force/z");
    for (size_t k = 0; k < force.size(); ++k) force[k] *= r.time[k] - r.time[0] > begin ? factor : 1.0;
  }
}

bool says(const std::vector<std::string>& notes, const std::string& text) {
  return std::any_of(notes.begin(), notes.end(),
                     [&](const std::string& note) { return note.find(text) != std::string::npos; });
}

TEST(Rests, OfARobotThatLiesOnItsTrunkAreSaidAndTellNothingOfItsFeet) {
  Experiment e = make_biped({}, make_counts());
  scale_from(kRestsFrom, 0.2, kHeld, &e);
  const Evidence evidence = diagnose_legged(e, nullptr).evidence;
  const auto rest = std::find_if(evidence.remaining.begin(), evidence.remaining.end(), [](const Remaining& r) {
    return r.statement.find("the feet bear 0.20") != std::string::npos;
  });
  ASSERT_NE(rest, evidence.remaining.end());
  EXPECT_NE(rest->statement.find(e.recordings[kHeld].spec.name + ", 5."), std::string::npos) << rest->statement;
  for (const Finding& f : evidence.findings) {
    if (f.effect != "sensor_scale") continue;
    EXPECT_LT(f.parameters[0].std[0], 0.2) << f.statement;
  }
}

TEST(Rests, AreNotWhatFeetOfAWalkDoInTurn) {
  const Evidence evidence = diagnose_biped({}, {.lifts = true});
  for (const Remaining& r : evidence.remaining)
    EXPECT_EQ(r.statement.find("the feet bear"), std::string::npos) << r.statement;
}

TEST(Recordings, SayEachWhatTheFeetCarryThere) {
  Recorded recorded = kLeans;
  recorded.six_axes = false;
  recorded.imu = true;
  Experiment e = make_biped({}, recorded);
  scale_from(-1, 1.1, kHeld, &e);
  const Evidence evidence = diagnose_legged(e, nullptr).evidence;
  const auto carry = [&](size_t r, const std::string& share) {
    return e.recordings[r].spec.name + ": the feet carry " + share;
  };
  EXPECT_TRUE(says(evidence.warnings, carry(0, "1.00")));
  EXPECT_TRUE(says(evidence.warnings, carry(kHeld, "1.10")) || says(evidence.warnings, carry(kHeld, "1.09")));
  EXPECT_TRUE(says(evidence.warnings, "of the rate that it is compared with"));
}

}  // namespace
}  // namespace hrp::diagnosis::floating
