// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/rests.h"

#include <algorithm>

#include "common/base/format.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/checks/weight_check.h"

namespace hrp::diagnosis::floating {
namespace {

// What the feet bear over what the motion asks for, by row.
std::vector<double> list_shares(const ChannelRows& c, const ColumnLayout& layout) {
  std::vector<int> readings;
  for (int s = 0; s < layout.sensors; ++s) {
    const int at = c.find_column(layout.sensor(s, kForceScaleColumn));
    if (at >= 0) readings.push_back(at);
  }
  std::vector<double> out;
  for (size_t i = 0; i < c.rows(); ++i) {
    double sum = 0;
    for (const int r : readings) sum += c.row(i)[r];
    const double asked = sum - c.y[i];
    out.push_back(asked > 0 ? sum / asked : 1.0);  // a body that falls asks for nothing
  }
  return out;
}

// The marked entries of a list of `width` values a row; lists that are not filled stay empty.
template <class T>
void keep(const std::vector<char>& kept, size_t width, std::vector<T>* values) {
  if (values->size() != kept.size() * width) return;
  size_t to = 0;
  for (size_t i = 0; i < kept.size() * width; ++i) {
    if (kept[i / width]) (*values)[to++] = (*values)[i];
  }
  values->resize(to);
}

void keep_rows(const std::vector<char>& kept, ChannelRows* rows) {
  const size_t width = rows->columns.size();
  if (width > 0) {
    keep(kept, width, &rows->x);
    keep(kept, width, &rows->noise_x);
  }
  for (std::vector<double>* v : {&rows->y, &rows->noise_y, &rows->time, &rows->roughness}) keep(kept, 1, v);
  for (std::vector<int>* v : {&rows->recording, &rows->block, &rows->phase}) keep(kept, 1, v);
  keep(kept, 1, &rows->train);
}

// Equations of feet that stand on the ground.
bool is_of_feet(const Equation& e) {
  return e.is_of_whole_body() || e.is(EquationKind::kWeight) || e.is(EquationKind::kJoint) ||
         e.is(EquationKind::kTilt) || e.is(EquationKind::kHeight) || e.is(EquationKind::kGyroscopeOverFeet);
}

}  // namespace

std::vector<Rest> find_rests(const std::vector<ChannelRows>& channels, const ColumnLayout& layout) {
  std::vector<Rest> out;
  const ChannelRows* c = find_weight_equation(channels);
  if (!c) return out;
  const std::vector<double> shares = list_shares(*c, layout);
  const double usual = find_median(shares);
  for (size_t begin = 0, end = 0; begin < c->rows(); begin = end) {
    const auto is_less = [&](size_t i) { return shares[i] < kHalf * usual; };
    const auto follows = [&](size_t i) {
      return c->recording[i] == c->recording[begin] && c->time[i] < c->time[i - 1] + kPause;
    };
    for (end = begin + 1; end < c->rows() && follows(end) && is_less(end) == is_less(begin);) ++end;
    if (!is_less(begin) || c->time[end - 1] - c->time[begin] < kStepTakes) continue;
    const std::vector<double> own(shares.begin() + static_cast<long>(begin), shares.begin() + static_cast<long>(end));
    out.push_back({c->recording[begin], c->time[begin], c->time[end - 1], find_median(own) / usual});
  }
  return out;
}

void drop_rests(const std::vector<Rest>& rests, std::vector<ChannelRows>* channels) {
  if (rests.empty()) return;
  for (ChannelRows& c : *channels) {
    if (!is_of_feet(c.info.equation)) continue;
    std::vector<char> kept;  // not within half a second, in which the body comes to rest or is lifted
    for (size_t i = 0; i < c.rows(); ++i) {
      kept.push_back(std::none_of(rests.begin(), rests.end(), [&](const Rest& r) {
        return r.recording == c.recording[i] && c.time[i] > r.begin - kBlock && c.time[i] < r.end + kBlock;
      }));
    }
    keep_rows(kept, &c);
  }
}

std::string describe(const Rest& rest, const std::string& recording) {
  return recording +
         format(", %.1f to %.1f s: the feet bear %.2f of what they bear otherwise", rest.begin, rest.end, rest.share) +
         ". Something else bears the robot: it lies, hangs or is held. These seconds are left out of the equations of "
         "feet.";
}

}  // namespace hrp::diagnosis::floating
