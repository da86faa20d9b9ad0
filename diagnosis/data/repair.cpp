// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/repair.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/ends_with.h"
#include "common/base/rounding.h"
#include "diagnosis/data/plausibility.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/data/range.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

constexpr double kOfPosition = 0.03;  // least jump relative to the signal's middle 90 %: a link cannot jump
constexpr double kOfOthers = 2.0;     // the same for speeds and efforts; impacts also last one sample

// |x[k] - mean of the neighbours|; NaN beside missing samples.
std::vector<double> calc_second_differences(const std::vector<double>& x) {
  std::vector<double> out(x.size(), std::numeric_limits<double>::quiet_NaN());
  for (size_t k = 1; k + 1 < x.size(); ++k) out[k] = std::abs(x[k] - 0.5 * (x[k - 1] + x[k + 1]));
  return out;
}

// Smallest positive value; 0 if there is none.
double find_smallest(const std::vector<double>& x) {
  double least = 0.0;
  for (double v : x) {
    if (v > 0.0 && (least == 0.0 || v < least)) least = v;
  }
  return least;
}

// Removes the whole turns by which the command differs from the joint's angle.
void align_turns(const std::vector<double>& angle, std::vector<double>* command) {
  std::vector<double> apart;
  for (size_t k = 0; k < std::min(angle.size(), command->size()); ++k) {
    if (std::isfinite(angle[k]) && std::isfinite((*command)[k])) apart.push_back((*command)[k] - angle[k]);
  }
  if (apart.empty()) return;
  const double turns = 2.0 * M_PI * std::round(find_median(std::move(apart)) / (2.0 * M_PI));
  for (double& v : *command) v -= turns;
}

void repair_attitudes(Recording* r, std::vector<std::string>* warnings) {
  std::vector<std::string> names;  // "/imu/trunk/orientation"
  for (const auto& column : r->other) {
    if (ends_with(column.first, "/orientation/w")) names.push_back(column.first.substr(0, column.first.rfind('/')));
  }
  for (const std::string& name : names) {
    std::array<std::vector<double>*, 4> xyzw{};
    for (size_t i = 0; i < 4; ++i) {
      const auto at = r->other.find(name + "/" + "xyzw"[i]);
      xyzw[i] = at == r->other.end() ? nullptr : &at->second;
    }
    if (std::count(xyzw.begin(), xyzw.end(), nullptr) > 0) continue;
    const double norm = repair_attitude(xyzw);
    if (std::isnan(norm)) continue;
    const bool any = std::any_of(xyzw[3]->begin(), xyzw[3]->end(), [](double v) { return std::isfinite(v); });
    warnings->push_back(r->spec.name + ": " + name + ": a quaternion of norm " + number(norm) +
                        " is no attitude, expected 1; " + (any ? "such samples are" : "its columns are") + " left out");
    if (!any) drop_attitude(name, r);
  }
}

}  // namespace

void drop_attitude(const std::string& name, Recording* r) {
  for (const char axis : {'x', 'y', 'z', 'w'}) r->other.erase(name + "/" + axis);
}

double repair_attitude(const std::array<std::vector<double>*, 4>& xyzw) {
  double found = std::nan("");
  std::array<double, 4> last{};
  for (size_t k = 0; k < xyzw[0]->size(); ++k) {
    double square = 0.0, dot = 0.0;
    for (size_t i = 0; i < 4; ++i) {
      square += std::pow((*xyzw[i])[k], 2);
      dot += last[i] * (*xyzw[i])[k];
    }
    if (!std::isfinite(square)) continue;
    const bool unit = std::abs(std::sqrt(square) - 1.0) < kDetail;
    if (!unit && std::isnan(found)) found = std::sqrt(square);
    for (size_t i = 0; i < 4; ++i) {
      double& part = (*xyzw[i])[k];
      part = unit ? std::copysign(1.0, dot) * part : std::nan("");
      if (unit) last[i] = part;
    }
  }
  return found;
}

int unwrap_angle(std::vector<double>* angle) {
  const std::vector<double> values = keep_finite(*angle);
  // An encoder that wraps reads within one turn. Where turns are counted already, a wheel whose encoder is read seldom
  // moves by more than a turn between two readings.
  if (values.empty() || find_quantile(values, 0.99) - find_quantile(values, 0.01) > (1.0 + kDetail) * 2.0 * M_PI)
    return 0;
  int jumps = 0;
  double turns = 0.0, last = std::numeric_limits<double>::quiet_NaN();
  for (double& v : *angle) {
    if (!std::isfinite(v)) continue;
    const double step = v + turns - last;
    if (std::abs(step) > kJump) {
      turns -= 2.0 * M_PI * std::round(step / (2.0 * M_PI));
      ++jumps;
    }
    v += turns;
    last = v;
  }
  return jumps;
}

int drop_spikes(std::vector<double>* signal, double of_spread) {
  const std::vector<double> second = calc_second_differences(*signal), usual = keep_finite(second);
  if (usual.size() < 100) return 0;
  const std::vector<double> values = keep_finite(*signal);
  const double spread = find_quantile(values, 0.95) - find_quantile(values, 0.05);
  const double least =
      std::max({kTenTimes * find_quantile(usual, 0.95), of_spread * spread, kTenTimes * find_smallest(usual)});
  std::vector<size_t> found;
  for (size_t k = 1; k + 1 < signal->size(); ++k) {
    if (second[k] > least && std::abs((*signal)[k + 1] - (*signal)[k - 1]) < kDetail * second[k]) found.push_back(k);
  }
  if (static_cast<double>(found.size()) > kTrace * static_cast<double>(signal->size())) return 0;
  for (size_t k : found) (*signal)[k] = std::numeric_limits<double>::quiet_NaN();
  return static_cast<int>(found.size());
}

void repair_recording(const Experiment& e, Recording* r, std::vector<std::string>* warnings) {
  for (int j = 0; j < e.num_joints(); ++j) {
    JointColumns& joint = r->joints[static_cast<size_t>(j)];
    std::vector<double>& angle = joint.signal[static_cast<int>(Quantity::kPosition)];
    for (int q = 0; q < kQuantities; ++q) {
      const int spikes =
          drop_spikes(&joint.signal[q], q == static_cast<int>(Quantity::kPosition) ? kOfPosition : kOfOthers);
      if (spikes == 0) continue;
      warnings->push_back(
          r->spec.name + ": " + e.signal_name(j, static_cast<Quantity>(q)) + ": " + std::to_string(spikes) +
          (spikes == 1 ? " sample that jumps and returns is left out" : " samples that jump and return are left out"));
    }
    if (e.robot.tree.joint(j).kind != JointKind::kRevolute) continue;
    const int jumps = unwrap_angle(&angle);
    if (jumps == 0) continue;
    unwrap_angle(&joint.command);
    align_turns(angle, &joint.command);
    warnings->push_back(r->spec.name + ": " + e.signal_name(j, Quantity::kPosition) + ": " + std::to_string(jumps) +
                        (jumps == 1 ? " jump" : " jumps") + " by a whole turn; the angle is counted on");
  }
  repair_attitudes(r, warnings);
}

}  // namespace hrp::diagnosis
