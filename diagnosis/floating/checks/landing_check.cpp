// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/landing_check.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/checks/weight_check.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

struct Landing {
  int recording = 0;
  double time = 0;  // [s]
};

// Feet that come down after a swing.
std::vector<Landing> list_landings(const LeggedLog& log, const Contacts& contacts) {
  std::vector<Landing> out;
  for (const Contact& spell : contacts.spells) {
    const Clip& clip = log.clips[spell.clip];
    if (spell.loaded || static_cast<double>(spell.end - spell.begin) * clip.step < kLanding || spell.end >= clip.size())
      continue;
    out.push_back({static_cast<int>(clip.recording), clip.time[spell.end]});
  }
  return out;
}

// What is left in the quarter second after each landing, at most and at least [N]; and when no foot lands.
struct LandingRows {
  std::vector<double> most, least, landing, calm;
};

LandingRows split_landings(const ChannelRows& c, const std::vector<Landing>& landings) {
  LandingRows out;
  std::vector<char> lands(c.rows(), 0);
  for (const Landing& l : landings) {
    double most = -1e300, least = 1e300;
    for (size_t i = 0; i < c.rows(); ++i) {
      if (c.recording[i] != l.recording || c.time[i] < l.time - 0.02 || c.time[i] > l.time + kLanding) continue;
      lands[i] = 1;
      most = std::max(most, c.y[i]);
      least = std::min(least, c.y[i]);
    }
    if (most > -1e300) {
      out.most.push_back(most);
      out.least.push_back(least);
    }
  }
  for (size_t i = 0; i < c.rows(); ++i) (lands[i] ? out.landing : out.calm).push_back(c.y[i]);
  return out;
}

// Deviation about the middle.
double calc_spread(const std::vector<double>& y) {
  if (y.empty()) return 0;
  const double middle = find_median(y);
  double sum = 0;
  for (double v : y) sum += std::pow(v - middle, 2);
  return std::sqrt(sum / static_cast<double>(y.size()));
}

}  // namespace

void check_landings(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
                    CheckResult* out) {
  const ChannelRows* c = find_weight_equation(channels);
  if (!c || !contacts.walks || out->raw_counts) return;
  const LandingRows rows = split_landings(*c, list_landings(log, contacts));
  if (rows.most.size() < kFewestToAgree || rows.calm.empty()) return;
  const double weight = log.mass * log.experiment->scenario.gravity_W.norm(), middle = find_median(rows.calm);
  const double calm = calc_spread(rows.calm), landing = calc_spread(rows.landing);
  const double peak = find_median(rows.most) - middle, dip = middle - find_median(rows.least);
  if (landing < kClearlyMore * calm || std::max(peak, dip) < kBlur * weight) return;
  Remaining r;
  r.where = {{"ground", "ground"}};
  r.unit = "N";
  r.before = r.after = landing;
  r.statement = format(
                    "landings (%.0f): in the quarter second after a landing, the feet's force peaks %.0f N above what "
                    "the motion takes, and falls %.0f N below (medians)",
                    static_cast<double>(rows.most.size()), peak, dip) +
                format(
                    ". The rest of the time it differs %.1f times less. Soles, skin or ground that give or rebound do "
                    "that. Which of them it is does not show.",
                    landing / std::max(1e-9, calm));
  out->remaining.push_back(std::move(r));
}

}  // namespace hrp::diagnosis::floating
