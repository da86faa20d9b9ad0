// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/checks/torque_traces.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/checks/found_terms.h"
#include "diagnosis/estimate/enough.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kWindow = 10.0;  // [s]
constexpr long kPoints = 600;

const TorqueRecording& find_shown(const TorqueData& data) {
  for (const TorqueRecording& r : data.recordings) {
    if (!r.train) return r;
  }
  return data.recordings.front();
}

// Joints with the largest missing torque relative to their effort, worst first.
std::vector<long> find_worst(const TorqueData& data, const TorqueRecording& r) {
  std::vector<std::pair<double, long>> order;
  for (long j = 0; j < r.missing.cols(); ++j) {
    const double spread = std::sqrt((r.effort.col(j).array() - r.effort.col(j).mean()).square().mean());
    if (!data.is_judged(static_cast<int>(j)) || !(spread > 0.0)) continue;
    order.push_back({-std::sqrt(r.missing.col(j).squaredNorm() / static_cast<double>(r.kept())) / spread, j});
  }
  std::sort(order.begin(), order.end());
  std::vector<long> out;
  for (size_t i = 0; i < std::min(kMostNamed, order.size()); ++i) out.push_back(order[i].second);
  return out;
}

// Kept samples [begin, end) around the largest missing torque.
std::pair<long, long> find_window(const TorqueRecording& r, long joint) {
  long worst = 0;
  r.missing.col(joint).cwiseAbs().maxCoeff(&worst);
  const long width = std::min(r.kept(), std::lround(kWindow / (r.step * static_cast<double>(r.stride))));
  const long begin = std::clamp(worst - width / 2, 0L, r.kept() - width);
  return {begin, begin + width};
}

}  // namespace

Json make_torque_traces(const TorqueData& data, const Json& findings) {
  if (data.recordings.empty()) return Json::object();
  const Experiment& e = *data.experiment;
  const TorqueRecording& r = find_shown(data);
  const Eigen::MatrixXd found = predict_found(data, r, list_found_terms(e, findings));
  Json signals = Json::array(), traces = Json::array();
  for (long j : find_worst(data, r)) {
    const auto [begin, end] = find_window(r, j);
    Json time = Json::array(), recorded = Json::array(), before = Json::array(), after = Json::array();
    for (long k = begin; k < end; k += std::max(1L, (end - begin) / kPoints)) {
      const double y = r.effort(r.full_row(k), j);
      time.push_back(round_to(r.time(k), 6));
      recorded.push_back(round_to(y, 5));
      before.push_back(round_to(y - r.missing(k, j), 5));
      after.push_back(round_to(y - r.missing(k, j) + found(k, j), 5));
    }
    traces.push_back(
        {{"signal", signals.size()}, {"time", time}, {"recorded", recorded}, {"before", before}, {"after", after}});
    signals.push_back({{"name", e.signal_name(static_cast<int>(j), Quantity::kEffort)},
                       {"unit", get_joint_unit(e.robot.tree.joint(static_cast<int>(j)), "N m")}});
  }
  return {{"recording", e.recordings[r.index].spec.name}, {"signals", signals}, {"traces", traces}};
}

}  // namespace hrp::diagnosis
