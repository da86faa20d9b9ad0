// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/checks/per_recording.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/rounding.h"
#include "diagnosis/checks/found_terms.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

struct Solution {
  Eigen::VectorXd value, std;
};

class Fitter {
 public:
  Fitter(const TorqueData& data, const Json& findings)
      : e_(*data.experiment), findings_(findings), data_(data), asked_(list_found_terms(e_, findings)) {}

  Json run() {
    Json list = Json::array();
    if (list_files().size() < 2) return list;
    for (int j = 0; j < e_.num_joints(); ++j) fit_joint(j, &list);
    return list;
  }

 private:
  void fit_joint(int joint, Json* list) const {
    std::vector<const FoundTerm*> own;  // terms of links act on many joints and are left out
    for (const FoundTerm& f : asked_) {
      if (!f.term.whole() && f.term.place == joint && data_.is_judged(joint)) own.push_back(&f);
    }
    if (own.empty()) return;
    std::vector<Json> each(own.size(), Json::array());
    std::vector<std::vector<std::pair<double, double>>> values(own.size());
    for (const std::vector<const TorqueRecording*>& file : list_files()) {
      const std::optional<Solution> s = solve(file, joint, own);
      if (!s) continue;
      long at = 0;
      for (size_t i = 0; i < own.size(); ++i) {
        const long columns = own[i]->term.columns();
        const TermValues own_values =
            calc_values(own[i]->term, s->value.segment(at, columns), s->std.segment(at, columns));
        const double value = own_values.value[0], std = own_values.std[0];
        at += columns;
        if (!(std < kLargely * std::max(std::abs(own[i]->value), std::abs(value)))) continue;
        values[i].emplace_back(value, std);
        const RecordingSpec& spec = e_.recordings[file[0]->index].spec;
        each[i].push_back({{"recording", spec.name.substr(0, spec.name.find(" ("))},
                           {"role", spec.train ? "train" : "validate"},
                           {"value", round_to(value, 4)},
                           {"ci95", {round_to(value - kNinetyFive * std, 4), round_to(value + kNinetyFive * std, 4)}}});
      }
    }
    for (size_t i = 0; i < own.size(); ++i) {
      if (own[i]->parameter.empty() || each[i].size() < 2) continue;
      const Json& finding = findings_[own[i]->finding];
      list->push_back({{"effect", finding["effect"]},
                       {"where", finding["where"]},
                       {"parameter", own[i]->parameter},
                       {"unit", own[i]->unit},
                       {"each", each[i]},
                       {"verdict", do_differ(values[i]) ? "differ" : "agree"}});
    }
  }

  static bool do_differ(const std::vector<std::pair<double, double>>& values) {
    for (const auto& [a, sa] : values) {
      for (const auto& [b, sb] : values) {
        if (std::abs(a - b) > kUnlikely * std::hypot(sa, sb) &&
            std::abs(a - b) > kDetail * std::max(std::abs(a), std::abs(b)))
          return true;
      }
    }
    return false;
  }

  // Groups of recordings that are parts of one file.
  std::vector<std::vector<const TorqueRecording*>> list_files() const {
    std::vector<std::vector<const TorqueRecording*>> files;
    for (const TorqueRecording& r : data_.recordings) {
      const std::string& file = e_.recordings[r.index].spec.file;
      if (files.empty() || e_.recordings[files.back()[0]->index].spec.file != file) files.emplace_back();
      files.back().push_back(&r);
    }
    return files;
  }

  // Fits the joint's terms to the parts of one file. Empty with too few samples.
  std::optional<Solution> solve(const std::vector<const TorqueRecording*>& parts, int joint,
                                const std::vector<const FoundTerm*>& own) const {
    long width = 0;
    for (const FoundTerm* f : own) width += f->term.columns();
    Eigen::MatrixXd G = Eigen::MatrixXd::Zero(width, width);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(width);
    double c = 0.0, n = 0.0, cycles = 0.0, last = 0.0;
    for (const TorqueRecording* part : parts) {
      const TorqueRecording& r = *part;
      Eigen::MatrixXd X(r.kept(), width);
      long at = 0;
      for (const FoundTerm* f : own) {
        X.middleCols(at, f->term.columns()) = calc_joint_columns(data_, r, f->term);
        at += f->term.columns();
      }
      for (long k = 0; k < r.kept(); ++k) {
        if (!r.use(k, joint)) continue;
        const double y = r.missing(k, joint), v = r.v(r.full_row(k), joint);
        G += X.row(k).transpose() * X.row(k);
        b += y * X.row(k).transpose();
        c += y * y;
        n += 1.0;
        cycles += v * last <= 0.0 ? 1.0 : 0.0;
        last = v;
      }
    }
    if (n < static_cast<double>(kFewestOfItsOwn)) return std::nullopt;
    const Eigen::VectorXd scale = G.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
    Eigen::MatrixXd unit = scale.asDiagonal() * G * scale.asDiagonal();
    unit.diagonal().array() += 1e-9;
    const Eigen::MatrixXd inverse = unit.inverse();
    Solution s;
    s.value = scale.cwiseProduct(inverse * scale.cwiseProduct(b));
    const double left = std::max(0.0, c - s.value.dot(b)) / n, looks = std::clamp(kLooks * cycles, 1.0, n);
    s.std = (left * n / looks * scale.array().square() * inverse.diagonal().array()).sqrt();
    return s;
  }

  const Experiment& e_;
  const Json& findings_;
  const TorqueData& data_;
  const std::vector<FoundTerm> asked_;
};

}  // namespace

Json make_per_recording(const TorqueData& data, const Json& findings) { return Fitter(data, findings).run(); }

}  // namespace hrp::diagnosis
