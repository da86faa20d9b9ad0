// SPDX-License-Identifier: BSD-3-Clause
// Curves of the effort with what was found: they have to meet the recording where everything was found.
#include "diagnosis/checks/torque_traces.h"

#include "diagnosis/checks/per_recording.h"
#include "diagnosis/measurement/torque/torque.h"
#include "tests/test_places.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kLevel = 1.5, kAsymmetry = 0.3;

double calc_distance(const Json& a, const Json& b) {
  double squares = 0.0;
  for (size_t k = 0; k < a.size(); ++k) squares += std::pow(a[k].get<double>() - b[k].get<double>(), 2);
  return std::sqrt(squares / static_cast<double>(a.size()));
}

TEST(TorqueTraces, WithFrictionThatDiffersByDirectionMeetTheRecordedEffort) {
  const Experiment e = simulate_arm("traces", {{EffectId::kCoulomb, kElbow, {kLevel, kAsymmetry, 5e-4}}});
  const Json found = {{{"effect", "coulomb_friction"},
                       {"where", {{"joint", "elbow"}}},
                       {"parameters", {{"level", {{"value", kLevel}, {"unit", "N m"}}}}},
                       {"also_fitted", {{"asymmetry", kAsymmetry}}}}};
  const Json traces = make_torque_traces(make_torque_data(e), found);
  for (const Json& trace : traces["traces"]) {
    const std::string signal = traces["signals"][trace["signal"].get<size_t>()]["name"];
    if (signal.find("elbow") == std::string::npos) continue;
    const double before = calc_distance(trace["before"], trace["recorded"]);
    EXPECT_GT(before, kLevel * 0.8);
    // Around reversals the direction is known to a few samples: a tenth. Without the asymmetry, 0.3 of the level is
    // left.
    EXPECT_LT(calc_distance(trace["after"], trace["recorded"]), 0.15 * before);
    return;
  }
  FAIL() << "no curve of the elbow";
}

// In one recording of this arm the joint turns one way only: its torque alone says 0.54 N m, of a level of 0.43 +-
// 0.11.
TEST(PerRecording, AgreesOnFrictionThatDiffersByDirectionAlsoWhereTheJointTurnsOneWay) {
  const Experiment e = load_experiment(source_dir() + "/models/experiments/arm/experiment.yaml");
  const TorqueData data = make_torque_data(e);
  Json found = {{{"effect", "coulomb_friction"},
                 {"where", {{"joint", "axis2"}}},
                 {"parameters", {{"level", {{"value", 0.43}, {"unit", "N m"}}}}}}};
  EXPECT_EQ(make_per_recording(data, found)[0]["verdict"], "differ");
  found[0]["also_fitted"] = {{"asymmetry", 0.265}};
  EXPECT_EQ(make_per_recording(data, found)[0]["verdict"], "agree");
}

}  // namespace
}  // namespace hrp::diagnosis
