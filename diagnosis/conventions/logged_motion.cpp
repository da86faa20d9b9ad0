// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/logged_motion.h"

#include "diagnosis/estimate/shares.h"
#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {

LoggedMotion sample_motion(const TorqueData& data) {
  LoggedMotion out{make_plant(*data.experiment, {}), {}};
  if (data.recordings.empty() || data.behind_gears) return out;
  SampledMotion& rows = out.rows = take_rows(data, list_unloaded_training(data));
  if (rows.tell_nothing()) return out;
  out.left = rows.calc_left(rows.effort - calc_efforts(out.plant, rows.q, rows.v, rows.a));
  out.share = out.left / rows.count_judged();
  return out;
}

std::optional<size_t> find_reading(const LoggedMotion& motion, size_t count,
                                   const std::function<double(size_t)>& calc_left) {
  std::optional<size_t> best;
  double least = kDetail * motion.left;
  for (size_t i = 0; i < count; ++i) {
    const double left = calc_left(i);
    if (left < least) {
      least = left;
      best = i;
    }
  }
  return best;
}

}  // namespace hrp::diagnosis
