// SPDX-License-Identifier: BSD-3-Clause
// Time of the multibody algorithms against the number of joints, 10 to 200: PREFIX.csv and PREFIX.svg.
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>
#include <memory>

#include "common/multibody/forward_dynamics.h"
#include "common/plot/svg_plot.h"
#include "tests/unit/multibody/random_tree.h"

namespace hrp {
namespace {

using testing::Random;

// Links in `limbs` chains of equal length on a floating base.
TreeSpec make_limbs(int joints, int limbs) {
  TreeSpec spec = testing::make_random_tree(1, joints, true);
  for (int i = 1; i <= joints; ++i) {
    LinkSpec& link = spec.links[static_cast<size_t>(i)];
    link.parent = (i - 1) % (joints / limbs) == 0 ? 0 : i - 1;
    link.joint.kind = JointKind::kRevolute;
  }
  return spec;
}

double get_cpu_time() {  // [us] of this thread
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

// [us of processor time a call]
double measure(const std::function<void()>& call) {
  constexpr int kCalls = 50;
  const double start = get_cpu_time();
  for (int i = 0; i < kCalls; ++i) call();
  return (get_cpu_time() - start) / kCalls;
}

struct Case {
  explicit Case(const TreeSpec& spec) : model(spec), data(model), out(model.nv()) {
    Random random(1);
    state = testing::make_random_state(model, &random);
    effort = random.values(model.num_joints(), 1);
    vdot = random.values(model.nv(), 1);
  }
  double time_forward() {
    return measure([this] {
      update_kinematics(model, state, &data);
      failed = failed || calc_forward_dynamics(model, effort, nullptr, {}, &data, &out) != Status::kOk;
    });
  }
  double time_inverse() {
    return measure([this] {
      update_kinematics(model, state, &data);
      calc_inverse_dynamics(model, vdot, nullptr, &data, &out);
    });
  }
  Model model;
  Data data;
  State state;
  Eigen::VectorXd effort, vdot, out;
  bool failed = false;
};

// Share of the variance that a straight line explains.
double calc_linearity(const PlotSeries& series) {
  const Eigen::Map<const Eigen::VectorXd> x(series.x.data(), static_cast<Eigen::Index>(series.x.size()));
  const Eigen::Map<const Eigen::VectorXd> y(series.y.data(), x.size());
  const Eigen::VectorXd dx = x.array() - x.mean(), dy = y.array() - y.mean();
  return dx.dot(dy) * dx.dot(dy) / (dx.squaredNorm() * dy.squaredNorm());
}

// The least of many rounds over all sizes: other programs only ever add, and they come and go during a round.
void measure_all(std::vector<std::unique_ptr<Case>>* chains, std::vector<std::unique_ptr<Case>>* limbs, Plot* plot) {
  for (int round = 0; round < 60; ++round) {
    for (size_t i = 0; i < chains->size(); ++i) {
      const double times[3] = {(*chains)[i]->time_forward(), (*limbs)[i]->time_forward(), (*chains)[i]->time_inverse()};
      for (size_t k = 0; k < 3; ++k) plot->series[k].y[i] = std::min(plot->series[k].y[i], times[k]);
    }
  }
}

void write_csv(const Plot& plot, const std::string& path) {
  std::ofstream csv(path);
  csv << "joints,forward_chain_us,forward_limbs_us,inverse_chain_us\n";
  for (size_t i = 0; i < plot.series[0].x.size(); ++i) {
    csv << plot.series[0].x[i];
    for (const PlotSeries& series : plot.series) csv << "," << series.y[i];
    csv << "\n";
  }
}

int run(const std::string& prefix) {
  Plot plot;
  plot.title = "Cost against number of joints";
  plot.x_label = "joints";
  plot.y_label = "time [us]";
  plot.series = {{"forward dynamics, one chain", {}, {}},
                 {"forward dynamics, five limbs", {}, {}},
                 {"inverse dynamics, one chain", {}, {}}};
  std::vector<std::unique_ptr<Case>> chains, limbs;
  for (int joints = 10; joints <= 200; joints += 10) {
    chains.push_back(std::make_unique<Case>(make_limbs(joints, 1)));
    limbs.push_back(std::make_unique<Case>(make_limbs(joints, 5)));
    for (PlotSeries& series : plot.series) {
      series.x.push_back(joints);
      series.y.push_back(1e300);
    }
  }
  measure_all(&chains, &limbs, &plot);
  for (const PlotSeries& series : plot.series) {
    std::printf("%-30s %6.3f us a joint, straight line explains %.4f of the variance\n", series.label.c_str(),
                (series.y.back() - series.y.front()) / 190, calc_linearity(series));
  }
  for (size_t i = 0; i < chains.size(); ++i) {
    if (chains[i]->failed || limbs[i]->failed) return 1;
  }
  write_csv(plot, prefix + ".csv");
  write_svg(plot, prefix + ".svg");
  return 0;
}

}  // namespace
}  // namespace hrp

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: multibody_scaling PREFIX   (writes PREFIX.csv and PREFIX.svg)\n");
    return 2;
  }
  return hrp::run(argv[1]);
}
