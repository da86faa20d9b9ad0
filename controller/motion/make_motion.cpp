// SPDX-License-Identifier: BSD-3-Clause
// hrp-make-motion OUT.csv: the squat and sway that models/scenarios/squat.yaml plays on the HRP-2P-like robot. The feet
// stay where they are in half-sitting; the pelvis moves, upright, by smooth functions of time.
#include <cmath>
#include <cstdio>

#include "common/base/version.h"
#include "common/spatial/minimum_jerk.h"
#include "controller/motion/leg.h"

namespace {

const hrp::LegGeometry kLeft{0.3, 0.3, 0.035};
const hrp::LegGeometry kRight{0.3, 0.3, -0.035};

// 0 before t0, 1 after t1, two derivatives continuous.
double calc_ramp(double t, double t0, double t1) { return hrp::calc_minimum_jerk((t - t0) / (t1 - t0)); }

// Displacement of the pelvis [m]: down 8 cm and up again from 0.5 to 4.5 s, then a sway of 4 cm, period 2.5 s, to 9.5
// s.
Eigen::Vector3d calc_pelvis(double t) {
  const double depth = 0.08 * (calc_ramp(t, 0.5, 2.5) - calc_ramp(t, 2.5, 4.5));
  const double amplitude = 0.04 * (calc_ramp(t, 4.5, 5.75) - calc_ramp(t, 8.25, 9.5));
  return {0.0, amplitude * std::sin(2.0 * M_PI * (t - 4.5) / 2.5), -depth};
}

// Half-sitting (hip -26, knee 50, ankle -24 degrees): ankle from hip.
Eigen::Vector3d calc_rest(double offset) {
  const double hip = -26.0 * M_PI / 180.0, shank = 24.0 * M_PI / 180.0;
  return {-0.3 * std::sin(hip) - 0.3 * std::sin(shank), offset, -0.3 * std::cos(hip) - 0.3 * std::cos(shank)};
}

}  // namespace

int main(int argc, char** argv) {
  const char usage[] =
      "Usage: hrp-make-motion OUT.csv\nWrites the default squat and sway of the HRP-2P-like robot; --version says "
      "which program this is.";
  if (hrp::answer_questions(argc, argv, "hrp-make-motion", usage)) return 0;
  if (argc != 2 || argv[1][0] == '-') {
    std::fprintf(stderr, "%s\n", usage);
    return 2;
  }
  std::FILE* out = std::fopen(argv[1], "w");
  if (out == nullptr) {
    std::perror(argv[1]);
    return 2;
  }
  std::fprintf(out,
               "# Squat and sway of the HRP-2P-like robot from half-sitting, made by hrp-make-motion. [s], [rad]\n");
  std::fprintf(out, "time,R_HIP_R,R_HIP_P,R_KNEE,R_ANKLE_P,R_ANKLE_R,L_HIP_R,L_HIP_P,L_KNEE,L_ANKLE_P,L_ANKLE_R\n");
  for (int k = 0; k <= 500; ++k) {
    const double t = 0.02 * k;
    const Eigen::Matrix3d level = Eigen::Matrix3d::Identity();
    const auto right = hrp::solve_leg(kRight, {level, calc_rest(kRight.ankle_offset) - calc_pelvis(t)});
    const auto left = hrp::solve_leg(kLeft, {level, calc_rest(kLeft.ankle_offset) - calc_pelvis(t)});
    if (!right || !left) return 1;
    std::fprintf(out, "%.2f", t);
    for (const hrp::LegAngles& leg : {*right, *left}) {
      // + 0.0 turns a negative zero into a plain one.
      for (double angle : leg.tail<5>()) std::fprintf(out, ",%.8f", std::round(angle * 1e8) / 1e8 + 0.0);
    }
    std::fprintf(out, "\n");
  }
  return std::fclose(out) == 0 ? 0 : 1;
}
