// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/diagnosis/legged/rows.h"

#include <random>

namespace hrp::diagnosis::floating {

std::vector<ChannelRows> make_calm_and_rough() {
  std::mt19937 random(13);
  std::normal_distribution<double> normal;
  RowHalves rows(2, 900, {{make_joint_channel("A"), {0, 1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const bool rough = (i / 3) % 2 == 1;
    const double swing = rough ? normal(random) : 0.1 * normal(random), shape = rough ? 0 : normal(random);
    const double opposed = rough ? 3 * normal(random) : 0;
    rows.add_cell(i, (rough ? 5.0 : 1.0) + 0.001 * i, [&](RowTable* half, double sign) {
      half->begin_row(0, 100 * swing + shape + 0.1 * normal(random), 20);
      half->add(0, 0, swing);
      half->add(0, 1, shape + sign * opposed);
    });
  }
  return rows.merge();
}

}  // namespace hrp::diagnosis::floating
