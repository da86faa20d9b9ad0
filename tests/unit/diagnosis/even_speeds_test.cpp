// SPDX-License-Identifier: BSD-3-Clause
// A motion at one speed in each direction tells the torque that friction takes there, and not which law it follows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "diagnosis/diagnose_recordings.h"
#include "diagnosis/findings/even_speeds.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

const std::string kRod = R"(<robot name="boom"><link name="base"/><link name="rod"><inertial><mass value="1"/>
  <inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial></link>
  <joint name="boom" type="prismatic"><parent link="base"/><child link="rod"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.12" effort="1000" velocity="1"/></joint></robot>)";

// Position [m] and effort by time [s] and recording: two of 4 s at 57 Hz, without the second from 1.5 s on; an encoder
// of 0.33 mm.
Experiment make_moves(const std::string& name, const std::function<double(double, int)>& position,
                      const std::function<double(double)>& effort) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("hrp_even_" + name);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << kRod;
  std::ofstream yaml(folder / "experiment.yaml");
  yaml << "robot: robot.urdf\nbase: fixed\ndrive: effort\nrecordings:\n";
  for (int file = 0; file < 2; ++file) {
    yaml << "- {file: r" << file << ".csv, role: " << (file < 1 ? "train" : "validate") << "}\n";
    std::ofstream csv(folder / ("r" + std::to_string(file) + ".csv"));
    csv.precision(10);
    csv << "time,/joint_states/boom/position,/joint_states/boom/effort\n";
    TestNoise noise;
    for (int k = 0; k < 228; ++k) {
      const double t = k / 57.0, q = position(t, file) + 1e-4 * noise.draw();
      if (t < 1.5 || t > 2.5) csv << t << "," << 3.3e-4 * std::round(q / 3.3e-4) << "," << effort(t) << "\n";
    }
  }
  yaml.close();
  return load_experiment((folder / "experiment.yaml").string());
}

// A valve that is open in either direction for 1.5 s: after 0.15 s the rod follows at 19 mm/s, and back at 21 mm/s.
double follow_valve(double t, int file) {
  const double up = 0.019 * std::clamp(t - 0.15, 0.0, 1.5), down = 0.021 * std::clamp(t - 2.65, 0.0, 1.5);
  return 0.0606 + 0.004 * file + up - down;
}
double open_valve(double t) { return t < 2.0 ? 2.54 : -2.53; }

TEST(EvenSpeeds, AValveThatIsOpenOrNotMovesItsRodAtOneSpeedInEachDirection) {
  const std::vector<double> speeds = list_speeds(make_moves("valve", follow_valve, open_valve), 0);
  EXPECT_TRUE(is_of_even_speed(speeds));
  for (double v : speeds) EXPECT_NEAR(std::abs(v), 0.02, 0.004);  // an eighth of the way in steps of the encoder
}

TEST(EvenSpeeds, ASineIsSlowAtItsEndsAndTwoSpeedsAreTwo) {
  const auto sine = [](double t, int) { return 0.06 + 0.015 * std::sin(2.0 * t); };
  EXPECT_FALSE(is_of_even_speed(list_speeds(make_moves("sine", sine, open_valve), 0)));
  const auto two = [](double t, int file) { return 0.05 + (file < 1 ? 0.02 : 0.01) * t; };
  EXPECT_FALSE(is_of_even_speed(list_speeds(make_moves("two", two, open_valve), 0)));
}

// Its effort is one number in each direction, and the fluid bears its weight.
TEST(EvenSpeeds, NoFrictionOfSuchARodIsSure) {
  const Json report =
      diagnose_recordings(
          make_moves("report", follow_valve, open_valve), {}, [](const std::string&) {}, [](const Reports&) {})
          .report;
  EXPECT_FALSE(report["findings"].empty());
  for (const Json& f : report["findings"]) EXPECT_EQ(f["grade"], "ambiguous") << f["statement"];
}

Json make_report(const char* effect, const char* parameter, double value) {
  Json report;
  report["findings"] = {{{"effect", effect},
                         {"where", {{"joint", "boom"}}},
                         {"grade", "certain"},
                         {"statement", ""},
                         {"alternatives", Json::array()},
                         {"parameters", {{parameter, {{"value", value}, {"unit", "N"}}}}}}};
  return report;
}

TEST(EvenSpeeds, TheOtherLawIsListedWithTheValueThatTakesTheSameTorque) {
  const Experiment e = make_moves("other", follow_valve, open_valve);
  Json dry = make_report("coulomb_friction", "level", 2.5),
       viscous = make_report("viscous_friction", "coefficient", 125);
  doubt_friction_of_even_speeds(e, &dry);
  doubt_friction_of_even_speeds(e, &viscous);
  for (const Json* report : {&dry, &viscous}) {
    const Json& f = (*report)["findings"][0];
    EXPECT_EQ(f["grade"], "ambiguous");
    ASSERT_EQ(f["alternatives"].size(), 1u);
  }
  // a tenth: speeds of 19 and 21 mm/s, and steps of the encoder
  EXPECT_NEAR(dry["findings"][0]["alternatives"][0]["parameters"]["coefficient"].get<double>(), 125.0, 12.5);
  EXPECT_NEAR(viscous["findings"][0]["alternatives"][0]["parameters"]["level"].get<double>(), 2.5, 0.25);
}

TEST(EvenSpeeds, FrictionOfAMotionAtManySpeedsStaysSure) {
  const auto sine = [](double t, int) { return 0.06 + 0.015 * std::sin(2.0 * t); };
  Json report = make_report("coulomb_friction", "level", 2.5);
  doubt_friction_of_even_speeds(make_moves("sure", sine, open_valve), &report);
  EXPECT_EQ(report["findings"][0]["grade"], "certain");
}

}  // namespace
}  // namespace hrp::diagnosis
