// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "diagnosis/estimate/slopes.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/standing/effect_rows.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr double kLoopStep = 2e-4;      // [s] step of a drive's loop; as large as the timing parameter on fixed bases
constexpr double kMostStamping = 2e-3;  // [s] largest uncertainty of stamps; slower logs stamp well within their step

// Uncertainty [s] of the stamps of velocities and efforts within a step of the log. Smaller delays are no fault.
double find_stamping(const StandProblem& problem) {
  double step = kLoopStep;
  for (const StandRecording& r : problem.recordings) {
    const double all = r.time.back() - r.time.front();
    step = std::max(step, std::min(kMostStamping, 1.2 * all / static_cast<double>(r.time.size() - 1)));
  }
  return step;
}

StandRow make_sensor_row(EffectId id, Reading reading, std::vector<double> neutral, double step) {
  StandRow row = make_row(id, neutral, std::vector<double>(neutral.size(), step));
  row.reading = reading;
  row.all_count = true;
  row.at_drive = reading == Reading::kEffort || reading == Reading::kVelocity;
  return row;
}

bool is_late(const StandProblem& problem, const Effect& e) { return e.p[0] > find_stamping(problem); }

}  // namespace

void add_sensor_rows(std::vector<StandRow>* rows) {
  struct Size {
    Reading reading;
    size_t axes;
    double bias;
  };
  const Size sizes[] = {
      {Reading::kForce, 3, 0.1},         {Reading::kTorque, 3, 0.01}, {Reading::kAngularVelocity, 3, 1e-3},
      {Reading::kAcceleration, 3, 1e-2}, {Reading::kEffort, 1, 0.1},  {Reading::kVelocity, 1, 1e-3},
      {Reading::kPosition, 1, 1e-3}};
  for (const Size& s : sizes) {
    rows->push_back(make_sensor_row(get_effect_of(PlaceKind::kSensor, EffectFamily::kZero).id, s.reading,
                                    std::vector<double>(s.axes, 0), s.bias));
    rows->push_back(
        make_sensor_row(get_effect_of(PlaceKind::kSensor, EffectFamily::kGain).id, s.reading, {1}, kRelativeStep));
    rows->back().noisy = s.reading != Reading::kPosition;  // positions have too little noise to matter
  }
  const std::vector<Reading> of_joint{Reading::kEffort, Reading::kVelocity, Reading::kPosition};
  const std::vector<Reading> of_wrench{Reading::kWrench, Reading::kForce, Reading::kTorque};
  const std::vector<Reading> of_imu{Reading::kImu, Reading::kOrientation, Reading::kAngularVelocity,
                                    Reading::kAcceleration};
  for (const auto* group : {&of_joint, &of_wrench, &of_imu}) {
    const bool one = group == &of_joint;
    for (Reading reading : *group) {
      rows->push_back(make_sensor_row(get_late_reading().id, reading, {0}, 1e-2));
      rows->back().positive = true;
      rows->back().refined = one ? 0 : 2;
      if (one) rows->back().is_sensible = &is_late;
      if (!one)
        rows->push_back(make_sensor_row(get_effect_of(PlaceKind::kSensor, EffectFamily::kSensorGeometry).id, reading,
                                        {0, 0, 0}, 1e-3));
    }
    if (one) continue;
    rows->push_back(make_sensor_row(EffectId::kClockSkew, group->front(), {0}, 3e-3));
    rows->back().drifts = true;
    // Within 10 s the clocks drift so far that a slope at zero skew says nothing.
    rows->back().list_starts = [](const StandProblem&, const StandHints&, size_t) {
      return list_at(0, {0, -0.03, -0.01, 0.01, 0.03});
    };
  }
}

}  // namespace hrp::diagnosis::standing
