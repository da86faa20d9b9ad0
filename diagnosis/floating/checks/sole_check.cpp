// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/sole_check.h"

#include <algorithm>
#include <map>

#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/floating/checks/weight_check.h"
#include "diagnosis/floating/report/words.h"
#include "diagnosis/model/made.h"

namespace hrp::diagnosis::floating {
TiltByRecording list_tilts(const std::vector<ChannelRows>& channels, const std::string& foot) {
  std::map<int, std::vector<double>> angles[2];
  for (const ChannelRows& c : channels) {
    if (c.info.name != foot || !c.info.equation.is(EquationKind::kTilt)) continue;
    angles[c.info.equation.axis] = split_by_recording(c);
  }
  TiltByRecording out;
  for (const auto& [recording, roll] : angles[0]) {
    const auto pitch = angles[1].find(recording);
    if (roll.size() < kFewestToTell || pitch == angles[1].end() || pitch->second.size() < kFewestToTell) continue;
    out[recording] = {find_median(roll), find_median(pitch->second)};
  }
  return out;
}

namespace {

std::string describe(const Eigen::Vector2d& tilt) {
  return format("roll %.1f, pitch %.1f mrad", 1e3 * tilt.x(), 1e3 * tilt.y());
}

}  // namespace

void check_soles(const std::vector<ChannelRows>& channels, const std::vector<std::string>& recordings,
                 CheckResult* out) {
  std::vector<std::string> feet;
  for (const ChannelRows& c : channels) {
    if (c.info.equation == Equation(EquationKind::kTilt, 0)) feet.push_back(c.info.name);
  }
  for (const std::string& foot : feet) {
    const TiltByRecording tilts = list_tilts(channels, foot);
    const auto less = [](const auto& a, const auto& b) { return a.second.norm() < b.second.norm(); };
    const auto [least, most] = std::minmax_element(tilts.begin(), tilts.end(), less);
    if (tilts.empty() || most->second.norm() < kMountingError) continue;
    Remaining r;
    r.where = {{"foot", foot}};
    r.unit = "rad";
    r.before = r.after = most->second.norm();
    const auto name = [&](const auto& tilt) { return " in " + recordings[static_cast<size_t>(tilt->first)]; };
    const bool differ = (most->second - least->second).norm() > kMountingError;
    r.statement = foot + ": while it stands, the encoders have its sole askew by " + describe(most->second) +
                  name(most) + (differ ? " and by " + describe(least->second) + name(least) : "") +
                  ". The zeros of the leg's encoders, a sole that gives, the ground or the attitude is off" +
                  (differ ? ", and not by the same in each recording." : ".");
    out->remaining.push_back(std::move(r));
  }
}

}  // namespace hrp::diagnosis::floating
