// SPDX-License-Identifier: BSD-3-Clause
// A torque that ripples with a joint's position is found whatever its period, beside friction and rotors.
#include "diagnosis/measurement/ripple.h"

#include "diagnosis/evidence/torque/findings.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

constexpr double kInLog = 0.6;                                     // [N m] of a log
constexpr double kAmplitude = 1.2, kPeriods = 36.6, kPhase = 1.0;  // [N m], [1/rad] as of no number of poles, [rad]

Experiment make_arm(const std::string& name, bool ripples) {
  Hypothesis hidden{{EffectId::kViscous, kShoulder, {0.8}},
                    {EffectId::kCoulomb, kShoulder, {1.5, 0.0, 5e-4}},
                    {EffectId::kViscous, kElbow, {0.4}},
                    {EffectId::kCoulomb, kElbow, {0.8, 0.0, 5e-4}},
                    {EffectId::kRotorInertia, kElbow, {0.3}}};
  if (ripples) hidden.push_back({EffectId::kCogging, kElbow, {kAmplitude, kPeriods, kPhase}});
  return simulate_arm(name, hidden);
}

// The robot as it is half a second before the end of a recording, held there.
Recording make_still(Recording r) {
  const size_t at = r.size() - 100;
  for (JointColumns& joint : r.joints) {
    std::vector<std::vector<double>*> columns{&joint.command, &joint.command_rate};
    for (std::vector<double>& signal : joint.signal) columns.push_back(&signal);
    for (std::vector<double>* column : columns)
      std::fill(column->begin(), column->end(), column->empty() ? 0.0 : (*column)[at]);
  }
  return r;
}

TEST(Ripples, HaveThePeriodsThatTheMissingTorqueShows) {
  const Experiment e = make_arm("ripple_periods", true);
  const TorqueData data = make_torque_data(e);
  const std::vector<double> found = find_ripples(data, kElbow);
  ASSERT_FALSE(found.empty());
  // The elbow travels 1.2 rad: a tenth of a period more within it.
  EXPECT_NEAR(found[0], kPeriods, 0.5);
  EXPECT_TRUE(find_ripples(data, kShoulder).empty());
}

TEST(Ripples, AreNoneWhereFrictionAndRotorsAreAll) {
  const Experiment e = make_arm("ripple_none", false);
  const TorqueData data = make_torque_data(e);
  EXPECT_TRUE(find_ripples(data, kElbow).empty());
}

// The servo asks for a torque, the joint gets it, and only the file ripples. In most recordings the robot stands still.
TEST(Ripples, ThatTheServosLawFindsInTheLogAreNoTorqueOnTheJoint) {
  Experiment e = make_arm("ripple_of_log", false);
  const auto add_ripple = [](Recording* r) {
    JointColumns& elbow = r->joints[kElbow];
    for (size_t k = 0; k < r->size(); ++k)
      elbow.signal[2][k] += kInLog * std::sin(kPeriods * elbow.signal[0][k] + kPhase);
  };
  for (int copies = 0; copies < 4; ++copies) e.recordings.push_back(make_still(e.recordings[0]));
  const TorqueData clean = make_torque_data(e);
  for (Recording& r : e.recordings) add_ripple(&r);
  const TorqueData data = make_torque_data(e);
  EXPECT_TRUE(find_ripples(data, kElbow).empty());
  double off = 0.0, missing = 0.0;
  for (size_t r = 0; r < 2; ++r) {
    off += (data.recordings[r].missing.col(kElbow) - clean.recordings[r].missing.col(kElbow)).squaredNorm();
    missing += clean.recordings[r].missing.col(kElbow).size();
  }
  EXPECT_LT(std::sqrt(off / missing), 0.2 * kInLog / std::sqrt(2.0)) << "what the log has alone is taken out";
  e.scenario.drive = "effort";  // without the servo's law nothing tells
  EXPECT_FALSE(find_ripples(make_torque_data(e), kElbow).empty());
}

TEST(Ripples, AreReportedWithTheAmplitudeAndPhaseOfTheSimulatorsLaw) {
  const Experiment e = make_arm("ripple_named", true);
  const TorqueVerdict verdict = judge_torque(e, 1);
  bool named = false;
  for (const Finding& f : verdict.evidence.findings) {
    if (f.effect != "cogging") continue;
    named = true;
    EXPECT_EQ(f.where.at("joint"), "elbow");
    EXPECT_NEAR(f.parameters[0].value[0], kAmplitude,
                0.1 * kAmplitude);  // smoothing takes up to a tenth of what changes fast
    const double off = f.parameters[2].value[0] - kPhase;
    EXPECT_NEAR(off - 2.0 * M_PI * std::round(off / (2.0 * M_PI)), 0.0,
                0.3);  // half a period of 0.5 1/rad off over 1.2 rad
  }
  EXPECT_TRUE(named);
}

}  // namespace
}  // namespace hrp::diagnosis
