// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "diagnosis/search/relation.h"

namespace hrp::diagnosis {
namespace {

using Names = std::vector<std::string>;

// A joint that swings in two ways at once, seen every 4 ms for 6 s.
struct Swing {
  double t, q, v, load;
};
using Law = std::function<double(const Swing&)>;

Observed observe(double phase, const Law& law, double noise) {
  std::mt19937 random(static_cast<unsigned>(100.0 * phase) + 1);
  std::normal_distribution<double> normal;
  Observed o;
  o.x.resize(5);
  for (double t = 0.0; t < 6.0; t += 0.004) {
    Swing s{t, 0.5 * std::sin(2.1 * t + phase) + 0.3 * std::sin(5.3 * t + 2.0 * phase),
            1.05 * std::cos(2.1 * t + phase) + 1.59 * std::cos(5.3 * t + 2.0 * phase), 0.0};
    s.load = 4.0 * std::sin(s.q + 0.4) - std::sin(7.0 * t + phase);
    o.time.push_back(t);
    o.y.push_back(law(s) + noise * normal(random));
    const double values[] = {s.q, s.v, s.v > 0.0 ? 1.0 : -1.0, s.load, t};
    for (size_t i = 0; i < 5; ++i) o.x[i].push_back(values[i]);
  }
  return o;
}

const std::vector<Regressor> kQuantities{{"position", "its position", "rad"},
                                         {"velocity", "its velocity", "rad/s"},
                                         {"direction", "its direction", ""},
                                         {"load", "its load", "N m"},
                                         {"time", "time", "s"}};

Relation find(const Law& law, double noise = 0.02) {
  return find_relation(kQuantities, {observe(0.0, law, noise), observe(0.7, law, noise), observe(1.9, law, noise)},
                       {observe(2.6, law, noise), observe(4.0, law, noise)});
}

TEST(Relation, AStopFollowsPositionBeyondItsAngle) {
  const Relation r = find([](const Swing& s) { return 8.0 * std::max(0.0, s.q - 0.5); });
  EXPECT_EQ(r.names, Names{"position"});
  EXPECT_NE(r.words.find("above 0.5"), std::string::npos) << r.words;
}

TEST(Relation, DragOfTheSquareOfSpeedIsSaidToBeItsSecondPower) {
  const Relation r = find([](const Swing& s) { return 0.4 * s.v * std::abs(s.v); });
  EXPECT_EQ(r.names, Names{"velocity"});
  EXPECT_NE(r.words.find("power 2"), std::string::npos) << r.words;
}

TEST(Relation, FrictionAtOnePlaceFollowsPositionAndDirection) {
  const Relation r = find([](const Swing& s) { return std::abs(s.q - 0.1) < 0.1 ? (s.v > 0.0 ? 1.0 : -1.0) : 0.0; });
  EXPECT_EQ(r.names, (Names{"position", "direction"}));
  EXPECT_NE(r.words.find("between"), std::string::npos) << r.words;
}

TEST(Relation, AnOscillationFollowsTimeAtItsOwnFrequencyWhateverItsPhase) {
  const Relation r = find([](const Swing& s) { return std::sin(2.0 * M_PI * 3.7 * s.t + 0.3); });
  EXPECT_EQ(r.names, Names{"time"});
  EXPECT_NE(r.words.find("3.7 times a second"), std::string::npos) << r.words;
}

TEST(Relation, AMotorThatWeakensWithTimeFollowsLoadAndTime) {
  const Relation r = find([](const Swing& s) { return 0.2 * s.load * s.t / 6.0; });
  EXPECT_EQ(Names(r.names), (r.names[0] == "load" ? Names{"load", "time"} : Names{"time", "load"}));
}

TEST(Relation, TimeIsNoCauseWhereEveryRecordingRepeatsTheMotion) {
  const Law drag = [](const Swing& s) { return 0.4 * s.v * std::abs(s.v); };
  const std::vector<Observed> same{observe(0.7, drag, 0.02), observe(0.7, drag, 0.02)};
  EXPECT_EQ(find_relation(kQuantities, same, same).names, Names{"velocity"});
}

TEST(Relation, NoiseFollowsNothing) {
  const Relation r = find([](const Swing&) { return 0.0; }, 1.0);
  EXPECT_TRUE(r.names.empty()) << r.words;
}

}  // namespace
}  // namespace hrp::diagnosis
