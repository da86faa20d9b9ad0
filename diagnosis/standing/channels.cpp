// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/channels.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "common/spatial/gravity.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/slopes.h"
#include "diagnosis/standing/effects.h"
#include "diagnosis/standing/layout.h"
#include "diagnosis/standing/motion.h"
#include "diagnosis/standing/slip.h"
#include "diagnosis/standing/sole.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr int kTurning = 5;  // [windows] half of the 0.3 s over which rotations are compared

class Calculator : StandMotion {
 public:
  Calculator(const StandProblem& problem, const Hypothesis& hypothesis, size_t recording, PlayOffsets offsets)
      : StandMotion(problem, hypothesis, recording, std::move(offsets)),
        tau_(model_.nv()),
        rolled_(problem.feet.size(), Vector3d::Zero()) {
    friction_ = terms_.ground.friction > 0 ? terms_.ground.friction : problem.experiment->scenario.ground.friction;
    for (const LinkSpec& link : problem.tree.links) load_ += kTrace * link.inertia.mass * kGravity;
  }

  std::vector<double> run(StandBase* base) {
    add_samples(base);
    size_t first = find_drives(p_);
    for (size_t j = 0; j < joints_.size(); first += count_drive_channels(p_, j++)) {
      if (p_.is_driven(j)) take_out_memory(drives_, r_, j, first, channels_, &out_);
    }
    remove_mean_places();
    add_turning();
    add_gravity();
    for (size_t s = 0; s < known_samples_.size(); ++s) {
      const auto row = out_.begin() + static_cast<long>(s * channels_);
      if (!known_samples_[s]) std::fill(row, row + static_cast<long>(channels_), 0.0);
    }
    if (base) {
      base->residuals = out_;
      base->flat = flat_;
      base->ratios = ratios_;
    }
    return std::move(out_);
  }

  // Channels of all samples with absolute positions. run() subtracts their means and adds the channels over many
  // samples.
  std::vector<double> add_samples(StandBase* base) {
    channels_ = list_channels(p_).size();
    out_.reserve(r_.samples.size() * channels_);
    for (size_t s = 0; s < r_.samples.size(); ++s) {
      read_motion(s);
      add_sample(static_cast<size_t>(r_.samples[s]));
      if (base) base->states.insert(base->states.end(), joints_.begin(), joints_.end());
    }
    return out_;
  }

 private:
  // True if the centre of pressure is inside the sole. At an edge the foot may roll, and its tilt says nothing.
  bool presses_flat(const StandFoot& foot, const Vector3d& force, const Vector3d& torque) const {
    const Vector3d moment = torque - foot.sole.cross(force);
    return force.z() > load_ && std::abs(moment.y() / force.z()) < kNearlyAll * foot.size.x() / 2 &&
           std::abs(moment.x() / force.z()) < kNearlyAll * foot.size.y() / 2;
  }

  // Tilt of a flat foot relative to the ground, minus the rotation of its bush.
  void add_tilt(size_t foot, const Vector3d& normal_W, bool flat) {
    const StandFoot& f = p_.feet[foot];
    const FootTerms& t = terms_.feet[foot];
    const Transform X = get_pose(data_, f.link);
    const Vector3d w_F = X.R.transpose() * get_velocity(data_, f.link).head<3>(), n = X.R.transpose() * normal_W;
    const double angles[2] = {std::atan2(n.y(), n.z()), -std::asin(std::clamp(n.x(), -1.0, 1.0))};  // roll, pitch
    const Vector3d center = f.bush + t.shift;
    // The bush transmits the sensor's wrench and the weight of the foot between them.
    const Vector3d weight = f.mass * (X.R.transpose() * p_.experiment->scenario.gravity_W);
    const Vector3d moment = torque_[foot] - center.cross(force_[foot]) - (f.com - center).cross(weight);
    for (int a = 0; a < 2; ++a) {
      const double bent = -t.inverse_k[a] * (moment(a) + t.moment[a]) - t.c_over_k[a] * w_F(a) -
                          t.hardening * angles[a] * angles[a] * angles[a];
      out_.push_back(flat ? angles[a] - bent : 0);
    }
  }

  // A point of the foot that stays in place: the bush's centre minus its compression, or a ball's centre minus the
  // distance that it rolled.
  Vector3d find_fixed_point(size_t foot, double dt) {
    const StandFoot& f = p_.feet[foot];
    const Transform X = get_pose(data_, f.link);
    if (f.kind == SoleKind::kBall) {
      const Vector3d w_W = get_velocity(data_, f.link).head<3>();
      rolled_[foot] += dt * f.radius * w_W.cross(Vector3d::UnitZ());
      return X * f.bush - rolled_[foot];
    }
    return X * f.bush + Vector3d(0, 0, terms_.feet[foot].inverse_kz * force_[foot].z());
  }

  void add_feet(size_t k) {
    const Vector3d normal_W = make_rotation_from_rpy({terms_.ground.roll, terms_.ground.pitch, 0}) * Vector3d::UnitZ();
    const double dt = flat_.empty() ? 0 : r_.time[k] - r_.time[last_];
    last_ = k;
    std::vector<Vector3d> points;
    bool all_flat = true, slips = false;
    double worst = 0;
    for (size_t foot = 0; foot < p_.feet.size(); ++foot) {
      const bool flat = known_ && presses_flat(p_.feet[foot], force_[foot], torque_[foot]);
      all_flat = all_flat && flat;
      if (p_.feet[foot].kind == SoleKind::kFlat) add_tilt(foot, normal_W, flat);
      points.push_back(find_fixed_point(foot, dt));
      // The ground also carries the foot itself, which is below its sensor.
      const double weight = p_.feet[foot].mass * p_.experiment->scenario.gravity_W.norm();
      const double vertical = std::max(1.0, force_[foot].z() + weight);
      const double ratio = find_asked_friction(p_.feet[foot], force_[foot], torque_[foot], vertical);
      slips = slips || ratio > kNearlyAll * friction_;
      worst = std::max(worst, ratio);
    }
    places_.push_back(get_pose(data_, p_.imu_link) * p_.p_LI - points[0]);
    if (p_.base_pose) add_vector(find_standing_point(k));
    for (size_t foot = 1; foot < p_.feet.size(); ++foot) add_vector(points[foot] - points[0]);
    flat_.push_back(all_flat);
    slips_.push_back(slips);
    ratios_.push_back(worst);
  }

  // Position of the first foot in the world, from the recorded pose of the base.
  Vector3d find_standing_point(size_t k) const {
    const StandFoot& f = p_.feet[0];
    const Vector3d at_B = state_.R_WB.conjugate() * (get_pose(data_, f.link) * f.bush - rolled_[0]);
    const Vector3d sunk(0, 0, terms_.feet[0].inverse_kz * force_[0].z());
    const Vector3d p_WB(r_.base_position[0].value[k], r_.base_position[1].value[k], r_.base_position[2].value[k]);
    return p_WB + read_base_attitude(k) * at_B + sunk;
  }

  Eigen::Quaterniond read_base_attitude(size_t k) const {
    const SmoothSeries* q = r_.base_attitude;
    return Eigen::Quaterniond(q[0].value[k], q[1].value[k], q[2].value[k], q[3].value[k]).normalized();
  }

  void add_vector(const Vector3d& v) {
    for (int i = 0; i < 3; ++i) out_.push_back(v(i));
  }

  void add_base(size_t k) {
    if (!p_.base_pose || !p_.attitude) return;
    // The two headings count from where each sensor likes: half a turn has no sign.
    const auto turn = [](double heading) { return Eigen::AngleAxisd(-heading, Vector3d::UnitZ()); };
    const Eigen::Quaterniond apart = state_.R_WB * read_base_attitude(k).conjugate();
    if (std::isnan(heading_)) heading_ = 2.0 * std::atan2(apart.z(), apart.w());
    const Eigen::Quaterniond off = turn(heading_) * apart;
    add_vector((off.w() < 0 ? -2.0 : 2.0) * off.vec());  // in world axes; run() subtracts the mean heading
    yaw_ += out_.back();
  }

  void add_sample(size_t k) {
    known_samples_.push_back(known_);
    attitudes_.emplace_back(R_WI_);
    rates_.push_back(w_);
    turns_.push_back(dw_);
    add_feet(k);
    calc_inverse_dynamics(model_, vdot_, &wrenches_, &data_, &tau_);
    for (int i = 0; i < 6; ++i) out_.push_back(tau_(i));
    add_base(k);
    for (size_t j = 0; j < joints_.size(); ++j) {
      joints_[j].torque = tau_(6 + static_cast<long>(j));
      drives_.add(j, k, joints_[j], &out_);
    }
    gravity_.push_back(f_ + R_WI_.transpose() * p_.experiment->scenario.gravity_W);
    for (int i = 0; i < 2; ++i) add_vector(Vector3d::Zero());  // add_turning and add_gravity fill these
  }

  // True if a foot may stand elsewhere than at the previous sample. Reasons: between the samples it was lifted, stood
  // on an edge of its sole, or its load along the ground came close to the friction limit.
  bool may_have_moved(size_t k) const {
    for (auto i = static_cast<size_t>(r_.samples[k - 1]); i <= static_cast<size_t>(r_.samples[k]); ++i) {
      for (size_t foot = 0; foot < p_.feet.size(); ++foot) {
        const auto read = [&](size_t axis) { return r_.wrench[6 * foot + axis].value[i]; };
        const Vector3d force(read(0), read(1), read(2)), torque(read(3), read(4), read(5));
        const double asked = find_asked_friction(p_.feet[foot], force, torque, std::max(1.0, force.z()));
        const bool slides = asked > kNearlyAll * friction_;
        if (slides || !presses_flat(p_.feet[foot], force, torque)) return true;
      }
    }
    return false;
  }

  // Positions are known except for a constant. This subtracts the mean over the flat samples, separately for each
  // stretch in which the feet did not move. It also subtracts the mean of the heading between IMU and base pose.
  void remove_mean_places() {
    const size_t n = r_.samples.size(), first = find_places(p_);
    std::vector<size_t> stretch(n, 0);
    size_t count = 1;
    for (size_t k = 1; k < n; ++k) {
      const bool seen = flat_[k] && flat_[k - 1] && follows(k);
      const bool moved = slips_[k] || slips_[k - 1] || (terms_.ground.friction > 0 && !seen) || may_have_moved(k);
      stretch[k] = moved ? count++ : count - 1;
    }
    for (size_t c = first; c < first + count_places(p_); ++c) {
      std::vector<double> sum(count, 0.0), flat(count, 0.0);
      for (size_t k = 0; k < n; ++k) {
        if (flat_[k]) {
          sum[stretch[k]] += out_[k * channels_ + c];
          ++flat[stretch[k]];
        }
      }
      for (size_t k = 0; k < n; ++k) {
        double& place = out_[k * channels_ + c];
        place = flat_[k] && flat[stretch[k]] > 1 ? place - sum[stretch[k]] / flat[stretch[k]] : 0;
      }
    }
    if (!p_.base_pose || !p_.attitude) return;
    for (size_t k = 0; k < n; ++k) out_[k * channels_ + find_drives(p_) - 1] -= yaw_ / static_cast<double>(n);
  }

  // Compares the rotation of the attitude over a stretch with the integral of the gyroscope; a derivative of the
  // attitude would be much noisier. Stretches do not overlap, so their errors are independent; other samples stay 0.
  // The integral is the trapezoidal rule with end correction (Euler-Maclaurin): without it, it errs by 1 % at 2 Hz and
  // 30 ms per sample.
  void add_turning() {
    const auto half = static_cast<size_t>((kTurning * r_.window + r_.step - 1) / r_.step);  // samples
    for (size_t s = half; s + half < r_.samples.size(); s += 2 * half) {
      const auto time = [&](size_t k) { return r_.time[static_cast<size_t>(r_.samples[k])]; };
      const int span = r_.samples[s + half] - r_.samples[s - half];
      if (span > 2 * static_cast<int>(half) * r_.step) continue;  // samples between are left out
      Eigen::Quaterniond turned = Eigen::Quaterniond::Identity();
      for (size_t k = s - half; k < s + half; ++k) {
        const double dt = time(k + 1) - time(k);
        const Vector3d step = 0.5 * dt * (rates_[k] + rates_[k + 1]) + dt * dt / 12 * (turns_[k] - turns_[k + 1]);
        turned = turned * Eigen::Quaterniond(1, step.x() / 2, step.y() / 2, step.z() / 2).normalized();
      }
      const Eigen::Quaterniond seen = attitudes_[s - half].conjugate() * attitudes_[s + half];
      const Eigen::Quaterniond off = turned.conjugate() * seen;
      const Vector3d rate = (off.w() < 0 ? -2.0 : 2.0) * off.vec() / (time(s + half) - time(s - half));
      for (size_t i = 0; i < 3; ++i) out_[s * channels_ + channels_ - 6 + i] = rate(static_cast<long>(i));
    }
  }

  // True if no sample is missing before the k-th. Always false for thinned samples, so channels over a whole run stay
  // 0.
  bool follows(size_t k) const { return r_.samples[k] - r_.samples[k - 1] <= r_.window; }

  // First and end index of the longest run of samples without a gap or a slip.
  std::pair<size_t, size_t> find_longest_run() const {
    std::pair<size_t, size_t> best{0, 0};
    size_t begin = 0;
    for (size_t k = 1; k <= r_.samples.size(); ++k) {
      const bool goes_on = k < r_.samples.size() && follows(k) && !slips_[k];
      if (goes_on) continue;
      if (k - begin > best.second - best.first) best = {begin, k};
      begin = k;
    }
    return best;
  }

  // Weighted mean of specific force plus gravity, minus the mean acceleration of the IMU relative to its foot. The
  // weight w = 1 - cos and its derivative vanish at both ends. By partial integration, the mean of w times the
  // acceleration is the mean of w'' times the position. One sample has it, whatever the run: repeated at every sample,
  // one number would count as much as all that the others measure.
  void add_gravity() {
    const auto [begin, end] = find_longest_run();
    const auto time = [&](size_t k) { return r_.time[static_cast<size_t>(r_.samples[k])]; };
    const double span = end > begin ? time(end - 1) - time(begin) : 0;
    // A position known to 1 mm gives a mean acceleration to 4e-3 m/s^2.
    if (span < kFewestBlocks * kBlock) return;
    const double n = static_cast<double>(end - begin);
    Vector3d sum = Vector3d::Zero();
    double weight = 0;
    for (size_t k = begin; k < end; ++k) {
      const double angle = 2 * M_PI * (static_cast<double>(k - begin) + 0.5) / n;
      const double w = 1 - std::cos(angle), second = std::pow(2 * M_PI / span, 2) * std::cos(angle);
      sum += w * (attitudes_[k] * gravity_[k]) - second * places_[k];
      weight += w;
    }
    sum = attitudes_[(begin + end) / 2].conjugate() * sum;  // summed in world axes, reported in the sensor's axes
    const size_t row = r_.samples.size() / 2;
    for (size_t i = 0; i < 3; ++i) out_[row * channels_ + channels_ - 3 + i] = sum(static_cast<long>(i)) / weight;
  }

  Eigen::VectorXd tau_;
  std::vector<Vector3d> rolled_, gravity_;
  std::vector<Eigen::Quaterniond> attitudes_;
  std::vector<Vector3d> rates_, turns_, places_;
  std::vector<char> known_samples_, flat_, slips_;
  std::vector<double> ratios_, out_;
  double load_ = 0, yaw_ = 0, friction_ = 0;  // [N], [rad], of the ground
  double heading_ = NAN;                      // [rad] of the IMU over the pose's, first sample
  size_t channels_ = 0, last_ = 0;
};

struct PlacedLink {
  std::vector<int> sides;       // by sample: where the torque holds the teeth
  std::vector<double> offsets;  // [rad]
};

// Evaluates the channels with the teeth in the middle and slightly aside. The feet then tell where the link lies.
PlacedLink place_link(const StandProblem& problem, const Hypothesis& hypothesis, size_t recording, PlayOffsets offsets,
                      size_t joint, double gap, double slack) {
  StandBase middle, aside;
  offsets[joint].assign(problem.recordings[recording].samples.size(), 0.0);
  const std::vector<double> at = Calculator(problem, hypothesis, recording, offsets).add_samples(&middle);
  std::fill(offsets[joint].begin(), offsets[joint].end(), kSlopeStep);
  const std::vector<double> moved = Calculator(problem, hypothesis, recording, offsets).add_samples(&aside);
  std::vector<double> torque;
  for (size_t k = joint; k < middle.states.size(); k += offsets.size()) torque.push_back(middle.states[k].torque);
  const size_t places = find_places(problem), channels = list_channels(problem).size();
  PlacedLink out{find_sides(torque, slack), {}};
  const PlayRows rows{at, moved, channels, places + count_places(problem), places};
  out.offsets = place_within_play(rows, problem.noise, out.sides, gap);
  return out;
}

// Torque [N m] above which the teeth are held on one side; infinite if no end of the gap was ever seen.
double choose_slack(const StandProblem& problem, const Effect& backlash) {
  return backlash.p[0] < kMostPlay ? problem.slack[static_cast<size_t>(backlash.place.index)] : 1e300;
}

}  // namespace

double find_play(const StandProblem& problem, const Hypothesis& hypothesis, size_t joint) {
  std::vector<double> seen;
  for (size_t r = 0; r < problem.recordings.size(); ++r) {
    if (!problem.recordings[r].train) continue;
    const std::vector<double> one =
        place_link(problem, hypothesis, r, PlayOffsets(problem.effort.size()), joint, kMostPlay, 1e300).offsets;
    seen.insert(seen.end(), one.begin(), one.end());
  }
  if (seen.empty()) return 0;
  std::sort(seen.begin(), seen.end());
  const size_t few = seen.size() / 20;
  return seen[seen.size() - 1 - few] - seen[few];
}

void find_seen_play(const StandProblem& problem, const Hypothesis& hypothesis, Effect* backlash) {
  const auto joint = static_cast<size_t>(backlash->place.index);
  double low = kMostPlay, high = -kMostPlay;
  long held_low = 0, held_high = 0;
  const auto look = [&](double gap, double slack) {
    for (size_t r = 0; r < problem.recordings.size(); ++r) {
      const PlacedLink link = place_link(problem, hypothesis, r, PlayOffsets(problem.effort.size()), joint, gap, slack);
      for (double offset : link.offsets) {
        low = std::min(low, offset);
        high = std::max(high, offset);
      }
      held_low += std::count(link.sides.begin(), link.sides.end(), -1);
      held_high += std::count(link.sides.begin(), link.sides.end(), 1);
    }
  };
  look(backlash->p[0], choose_slack(problem, *backlash));
  constexpr long kEnough = 10;  // samples
  const bool at_low = held_low > kEnough, at_high = held_high > kEnough;
  if (!at_low && !at_high) {
    backlash->p[0] = kMostPlay;
    low = kMostPlay;
    high = -kMostPlay;
    look(kMostPlay, 1e300);
  }
  backlash->p[3] = at_low && at_high ? 0 : high - low;
}

std::vector<double> calc_channels(const StandProblem& problem, const Hypothesis& hypothesis, size_t recording,
                                  StandBase* base) {
  PlayOffsets offsets(problem.effort.size());
  for (const Effect& e : hypothesis) {
    if (!get_row(e).loose || e.p[0] == 0 || problem.slack.empty()) continue;
    const auto joint = static_cast<size_t>(e.place.index);
    offsets[joint] =
        place_link(problem, hypothesis, recording, offsets, joint, e.p[0], choose_slack(problem, e)).offsets;
  }
  return Calculator(problem, hypothesis, recording, std::move(offsets)).run(base);
}

std::vector<double> calc_drive_channels(const StandProblem& problem, const Hypothesis& hypothesis, size_t recording,
                                        const StandBase& base, int joint) {
  const StandRecording& r = problem.recordings[recording];
  const Terms terms(problem, hypothesis);
  const Drives drives(problem, r, terms);
  const size_t joints = terms.joints.size(), channels = base.residuals.size() / r.samples.size();
  const size_t first = find_drive(problem, static_cast<size_t>(joint));
  std::vector<double> out = base.residuals, added;
  for (size_t s = 0; s < r.samples.size(); ++s) {
    const auto j = static_cast<size_t>(joint);
    added.clear();
    drives.add(j, static_cast<size_t>(r.samples[s]), base.states[s * joints + j], &added);
    std::copy(added.begin(), added.end(), out.begin() + static_cast<long>(s * channels + first));
  }
  if (problem.is_driven(static_cast<size_t>(joint))) {
    take_out_memory(drives, r, static_cast<size_t>(joint), first, channels, &out);
  }
  return out;
}

}  // namespace hrp::diagnosis::standing
