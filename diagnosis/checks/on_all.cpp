// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/checks/on_all.h"

#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/checks/found_terms.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

double sum_seconds(const Experiment& e) {
  double sum = 0.0;
  for (const Recording& r : e.recordings) sum += r.duration();
  return sum;
}

struct Squares {
  double before = 0.0, after = 0.0, n = 0.0;
};

void add_recording(const TorqueData& data, const TorqueRecording& r, const std::vector<FoundTerm>& found,
                   std::vector<Squares>* joints) {
  const Eigen::MatrixXd predicted = predict_found(data, r, found);
  for (long j = 0; j < predicted.cols(); ++j) {
    Squares& s = (*joints)[static_cast<size_t>(j)];
    for (long k = 0; k < r.kept(); ++k) {
      if (!r.use(k, j)) continue;
      const double left = r.missing(k, j) - predicted(k, j);
      s.before += r.missing(k, j) * r.missing(k, j);
      s.after += left * left;
      s.n += 1.0;
    }
  }
}

}  // namespace

Json make_fit_on_all(const TorqueData& data, const Experiment& searched, const Json& findings) {
  const Experiment& all = *data.experiment;
  const std::vector<FoundTerm> found = list_found_terms(all, findings);
  std::vector<Squares> squares(static_cast<size_t>(all.num_joints()));
  for (const TorqueRecording& r : data.recordings) add_recording(data, r, found, &squares);
  Json joints = Json::array();
  for (int j = 0; j < all.num_joints(); ++j) {
    const Squares& s = squares[static_cast<size_t>(j)];
    if (s.n == 0.0) continue;
    joints.push_back({{"joint", all.robot.tree.joint(j).name},
                      {"before", round_to(std::sqrt(s.before / s.n), 4)},
                      {"after", round_to(std::sqrt(s.after / s.n), 4)},
                      {"unit", get_joint_unit(all.robot.tree.joint(j), "N m")}});
  }
  return {
      {"seconds", round_to(sum_seconds(all), 4)}, {"searched", round_to(sum_seconds(searched), 4)}, {"joints", joints}};
}

}  // namespace hrp::diagnosis
