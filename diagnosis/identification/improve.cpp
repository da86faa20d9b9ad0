// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/improve.h"

#include <algorithm>
#include <filesystem>

#include "diagnosis/next/information.h"
#include "diagnosis/next/stance_motions.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::identification {
namespace {

namespace next = hrp::diagnosis;

constexpr double kUnknown = 1e6;    // [N m/rad], [N m s/rad] and [N m]: nothing is known before the motions
constexpr double kUsualRate = 5.0;  // [rad/s] at which stiffness and damping matter alike
constexpr double kFrame = 0.01;     // [s] between frames of motion files
constexpr double kWorth = 0.95;     // of the largest deviation: a motion that leaves more is not worth its time

// The robot as it stands at the beginning of a motion.
next::Experiment make_standing(const std::string& scenario_path) {
  next::Experiment e;
  e.scenario = load_scenario(scenario_path);
  e.robot = load_robot(e.scenario);
  return e;
}

Motion make_played(const next::Experiment& e, const next::Commands& commands) {
  Motion motion;
  motion.times = commands.time;
  motion.positions.resize(e.num_joints(), static_cast<Eigen::Index>(commands.time.size()));
  for (int j = 0; j < e.num_joints(); ++j) {
    motion.joints.push_back(e.robot.tree.joint(j).name);
    motion.positions.row(j) =
        Eigen::Map<const Eigen::RowVectorXd>(commands.position[static_cast<size_t>(j)].data(), motion.positions.cols());
  }
  return motion;
}

class Proposer {
 public:
  Proposer(const Scenario& base, const std::string& folder, double seconds)
      : base_(base),
        folder_(folder),
        seconds_(seconds),
        standing_(make_standing(write_motion(find_upright(), base, folder))),
        limits_(next::make_limits(standing_, {})) {}

  // As large as it is safe; not ok where no size is.
  ProposedMotion try_motion(next::Family family, unsigned seed) const {
    next::MotionPlan plan;
    plan.family = family;
    plan.seed = seed;
    plan.seconds = seconds_;
    plan.period = kFrame;
    ProposedMotion out;
    out.name = next::get_family_word(family) + std::to_string(seed);
    out.meaning = next::get_family_sentence(family);
    for (; plan.size >= next::kLeastStance; plan.size *= next::kSmallerStance) {
      const next::Commands commands = next::make_stance_motion(standing_, plan, limits_);
      if (commands.time.empty()) continue;
      // Seeds of noise beyond those of our own motions.
      out.check = check_motion(write_motion(make_played(standing_, commands), out.name, out.meaning,
                                            100 * static_cast<unsigned>(family) + seed, base_, folder_));
      if (out.check.ok()) break;
    }
    return out;
  }

 private:
  static MotionPlan find_upright() {
    for (const MotionPlan& plan : make_paper_plans()) {
      if (plan.name == "squat") return plan;
    }
    return make_paper_plans().back();
  }

  const Scenario& base_;
  std::string folder_;
  double seconds_;
  next::Experiment standing_;
  next::Limits limits_;
};

}  // namespace

double find_largest_deviation(const std::vector<MotionCheck>& checks) {
  double most = 0.0;
  for (int f = 0; f < 2; ++f) {
    for (int a = 0; a < 2; ++a) {
      Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
      for (const MotionCheck& check : checks) sum += check.fisher[f][a];
      const Eigen::VectorXd std = next::calc_expected_std(sum, Eigen::VectorXd::Constant(3, kUnknown));
      most = std::max({most, std[0], kUsualRate * std[1]});
    }
  }
  return most;
}

std::vector<ProposedMotion> propose_motions(const Scenario& base, std::vector<MotionCheck> known, int seeds,
                                            double seconds, const std::string& folder) {
  const Proposer proposer(base, folder, seconds);
  std::vector<ProposedMotion> tried, chosen;
  for (int f = static_cast<int>(next::Family::kSway); f <= static_cast<int>(next::Family::kStir); ++f) {
    for (int seed = 1; seed <= seeds; ++seed) {
      tried.push_back(proposer.try_motion(static_cast<next::Family>(f), static_cast<unsigned>(seed)));
      if (!tried.back().check.ok()) tried.pop_back();
    }
  }
  for (double least = find_largest_deviation(known); !tried.empty();) {
    for (ProposedMotion& motion : tried) {
      known.push_back(motion.check);
      motion.largest = find_largest_deviation(known);
      known.pop_back();
    }
    const auto best =
        std::min_element(tried.begin(), tried.end(),
                         [](const ProposedMotion& a, const ProposedMotion& b) { return a.largest < b.largest; });
    if (best->largest > kWorth * least) break;
    least = best->largest;
    known.push_back(best->check);
    chosen.push_back(*best);
    tried.erase(best);
  }
  return chosen;
}

}  // namespace hrp::identification
