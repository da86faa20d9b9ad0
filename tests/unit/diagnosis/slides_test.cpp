// SPDX-License-Identifier: BSD-3-Clause
// A carriage on a rail: no weight tells the unit of its effort, and a rotor looks like the carriage's mass.
#include <gtest/gtest.h>

#include "diagnosis/conventions/effort_units.h"
#include "diagnosis/data/stretches.h"
#include "diagnosis/diagnose_recordings.h"
#include "diagnosis/evidence/torque/findings.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

constexpr double kMass = 95.0, kViscous = 203.0, kDry = 20.0;  // kg, N s/m, N
constexpr double kRipple = 8.0, kPeriods = 2.0 * M_PI / 0.01;  // N, 1/m: a screw with a pitch of 10 mm
constexpr double kRate = 1000.0, kSeconds = 7.0;               // Hz, s
const std::string kSlide = R"(<robot name="slide"><link name="rail"/>
  <link name="carriage"><inertial><mass value="95"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="screw" type="prismatic"><parent link="rail"/><child link="carriage"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="500" velocity="2"/></joint></robot>)";

// A sum of two sines, with the force that moves the carriage along it. `unit`: N of one logged unit.
std::string make_log(double unit, double mass, double phase, double ripple) {
  TestNoise noise;
  std::string csv = "time,/joint_states/screw/position,/joint_states/screw/effort\n";
  for (double t = 0.0; t < kSeconds; t += 1.0 / kRate) {
    double q = 0.0, v = 0.0, a = 0.0;
    for (const auto& [size, rate] : {std::pair{0.08, 2.0}, std::pair{0.03, 7.0}}) {
      q += size * std::sin(rate * t + phase);
      v += size * rate * std::cos(rate * t + phase);
      a -= size * rate * rate * std::sin(rate * t + phase);
    }
    const double force =
        mass * a + kViscous * v + kDry * std::tanh(v / 1e-3) + ripple * std::sin(kPeriods * q) + 0.3 * noise.draw();
    csv += std::to_string(t) + "," + std::to_string(q) + "," + std::to_string(force / unit) + "\n";
  }
  return csv;
}

Experiment make_slide(const std::string& name, double unit, double mass = kMass, double ripple = 0.0) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("hrp_slide_" + name);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << kSlide;
  std::ofstream(folder / "train.csv") << make_log(unit, mass, 0.0, ripple);
  std::ofstream(folder / "held.csv") << make_log(unit, mass, 1.0, ripple);
  std::ofstream(folder / "experiment.yaml") << "robot: robot.urdf\nbase: fixed\ndrive: effort\nrecordings:\n- {file: "
                                               "train.csv, role: train}\n- {file: held.csv, role: validate}\n";
  return load_experiment((folder / "experiment.yaml").string());
}

struct Answered {
  Json report;
};

// The report before the search, which the tool writes for recordings that take time.
Json find_first_answer(const Experiment& e) {
  try {
    diagnose_recordings(
        e, {}, [](const std::string&) {}, [](const Reports& first) { throw Answered{first.report}; });
  } catch (const Answered& first) {
    return first.report;
  }
  return Json();
}

double get_value(const Json& report, const char* effect, const char* parameter) {
  for (const Json& f : report["findings"]) {
    if (f["effect"] == effect && f["grade"] == "supported") return f["parameters"][parameter]["value"];
  }
  return 0.0;
}

// Fourteen seconds of one joint are short, but fourteen thousand samples take a simulation long.
TEST(Slides, AFastLogOfOneJointGetsAFirstAnswerWithItsFriction) {
  const Experiment e = make_slide("first", 1.0);
  const Json first = find_first_answer(e);
  ASSERT_TRUE(first.is_object());
  EXPECT_EQ(first["preliminary"], true);
  // 5 %: interval of an effort whose scale is known to 2 %.
  EXPECT_NEAR(get_value(first, "viscous_friction", "coefficient"), kViscous, 0.05 * kViscous);
  EXPECT_NEAR(get_value(first, "coulomb_friction", "level"), kDry, 0.05 * kDry);
}

// Counts of a PWM, 0.003 N each: a rotor of three hundred carriages was listed without a word of the unit.
TEST(Slides, ARotorMuchLargerThanTheCarriageMayBeTheUnit) {
  const Json first = find_first_answer(make_slide("counts", 0.003));
  ASSERT_TRUE(first.is_object());
  double scale = 0.0;
  for (const Json& f : first["findings"]) {
    if (f["effect"] != "rotor_inertia") continue;
    EXPECT_EQ(f["grade"], "ambiguous");
    for (const Json& a : f["alternatives"]) {
      if (a["effect"] == "torque_constant_error") scale = a["parameters"]["scale"]["value"];
    }
  }
  EXPECT_NEAR(scale, 0.003, 0.05 * 0.003);  // 5 %, as above
}

// By chance, efforts in another unit hardly are what the carriage takes.
TEST(Slides, AForceThatTheCarriageTakesIsInNewtons) {
  EXPECT_TRUE(tells_unit(make_torque_data(make_slide("newtons", 1.0)), 0));
  EXPECT_TRUE(tells_unit(make_torque_data(make_slide("heavier", 1.0, 1.1 * kMass)), 0));
  EXPECT_FALSE(tells_unit(make_torque_data(make_slide("rotor", 1.0, 3.0 * kMass)), 0));
}

// Volts at 35 N each: with a rotor of 20 kg, which looks like the carriage, the unit is a fifth larger than it seems.
TEST(Slides, AUnitIsALowerBoundAndAmbiguousAndWhatIsFoundGrowsWithIt) {
  const Json first = find_first_answer(make_slide("volts", 35.0, kMass + 20.0));
  ASSERT_TRUE(first.is_object());
  EXPECT_EQ(first["least_units"], Json({"screw"}));
  bool unit = false, dry = false;
  for (const Json& f : first["findings"]) {
    if (f["effect"] == "coulomb_friction") dry = f["at_least"];
    if (f["effect"] != "torque_constant_error") continue;
    unit = f["at_least"];
    EXPECT_EQ(f["grade"], "ambiguous");
    EXPECT_NEAR(f["parameters"]["scale"]["value"].get<double>(), 35.0 * kMass / (kMass + 20.0), 1.5);  // 5 %, as above
  }
  EXPECT_TRUE(unit);
  EXPECT_TRUE(dry);
}

// The carriage is at 0.12 to 0.37 m/s half of the time: a ripple of 12 to 37 Hz, of which the filter of 8.5 Hz leaves
// little. What it leaves has nearly one frequency, at which a soft screw would swing.
TEST(Slides, ARippleFasterThanTheFilterIsNoSoftScrew) {
  const Experiment e = make_slide("ripple", 1.0, kMass, kRipple);
  bool named = false;
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    EXPECT_NE(f.effect, "joint_elasticity") << f.statement;
    if (f.effect != "cogging") continue;
    named = true;
    EXPECT_NEAR(f.parameters[0].value[0], kRipple,
                0.1 * kRipple);                            // smoothing takes up to a tenth of what changes fast
    EXPECT_NEAR(f.parameters[1].value[0], kPeriods, 3.0);  // a tenth of a period within the travel of 0.22 m
    EXPECT_EQ(f.parameters[0].unit, "N");
    EXPECT_EQ(f.parameters[2].unit, "rad");  // a phase, though the joint slides
  }
  EXPECT_TRUE(named);
}

}  // namespace
}  // namespace hrp::diagnosis
