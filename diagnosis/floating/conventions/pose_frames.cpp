// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/pose_frames.h"

#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/checks/standing_legs.h"
#include "diagnosis/floating/fit/shift_columns.h"

namespace hrp::diagnosis::floating {
namespace {

// What the IMU says of the base, in the base's axes.
struct Moment {
  const Clip* clip = nullptr;
  size_t k = 0;
  Vector3d rate, force;  // [rad/s, m/s^2]
};

std::vector<Moment> list_moments(const LeggedLog& log, Purpose purpose) {
  LeggedLog by_imu = log;
  by_imu.base_pose = false;
  std::vector<Moment> out;
  for (size_t c = 0; c < log.clips.size(); ++c) {
    by_imu.clips = {log.clips[c]};
    walk(by_imu, purpose, [&](const Clip&, size_t k, BodyMotion* motion) {
      out.push_back({&log.clips[c], k, motion->rate(), motion->vdot().segment<3>(3)});
    });
  }
  const size_t stride = purpose == Purpose::kForTurns ? 1 + out.size() / kMostMoments : 1;
  std::vector<Moment> some;
  for (size_t i = 0; i < out.size(); i += stride) some.push_back(out[i]);
  return some;
}

Eigen::Quaterniond put_in_order(Order order, const Eigen::Quaterniond& q) {
  if (order == Order::kScalarFirst) return {q.x(), q.y(), q.z(), q.w()};
  return order == Order::kInverse ? q.conjugate() : q;
}

Eigen::Quaterniond get_quaternion(const Clip& clip, std::vector<double> Track::*part, size_t k) {
  const Track* t = clip.base_attitude;
  return {(t[0].*part)[k], (t[1].*part)[k], (t[2].*part)[k], (t[3].*part)[k]};
}

class PoseFinder {
 public:
  explicit PoseFinder(const LeggedLog& log)
      : log_(log), accelerometer_(BodyMotion::find_force_source(without_pose(log)) == MotionSource::kImu) {}

  PoseFrame run() {
    PoseFrame out;
    const std::vector<Moment> of_turns = list_moments(log_, Purpose::kForTurns);
    if (!is_enough(Purpose::kForTurns, of_turns.size())) return out;
    const double nominal = calc_left(of_turns, out, {});
    if (kPart * nominal > 1.0) find_convention(of_turns, nominal, &out);
    if (accelerometer_ && !out.is_turned()) find_world(of_turns, &out);
    const std::vector<Moment> of_clocks = list_moments(log_, Purpose::kForClocks);
    if (is_enough(Purpose::kForClocks, of_clocks.size())) find_clock(of_clocks, &out);
    return out;
  }

 private:
  static LeggedLog without_pose(LeggedLog log) {
    log.base_pose = false;
    return log;
  }

  // Which axis is up changes no rate: a pose that is late, too, tells it by the force alone.
  enum class Of { kAll, kForce };

  double calc_left(const std::vector<Moment>& moments, const PoseFrame& frame, const Clock& clock,
                   Of of = Of::kAll) const {
    double sum = 0.0;
    const Eigen::Quaterniond q_body(frame.R_body), q_world(frame.R_world);
    for (const Moment& m : moments) {
      const size_t k = shift(m.k, clock, *m.clip, log_);
      const Eigen::Quaterniond q = put_in_order(frame.order, get_quaternion(*m.clip, &Track::value, k)).normalized();
      const Eigen::Quaterniond dq = put_in_order(frame.order, get_quaternion(*m.clip, &Track::rate, k));
      const Vector3d rate = q_body.conjugate() * (2.0 * (q.conjugate() * dq).vec());
      if (of == Of::kAll) sum += (rate - m.rate).squaredNorm() / (kRateOfSoles * kRateOfSoles);
      if (accelerometer_)
        sum += (calc_force(*m.clip, k, q_world * q * q_body, frame.R_world) - m.force).squaredNorm() /
               (kForceOfSoles * kForceOfSoles);
    }
    return sum / static_cast<double>(moments.size()) + 1.0;
  }

  // [m/s^2] Of the base, its axes.
  Vector3d calc_force(const Clip& clip, size_t k, const Eigen::Quaterniond& q_WB, const Matrix3d& R_world) const {
    Vector3d second;
    for (int i = 0; i < 3; ++i) second(i) = clip.base_position[i].second[k];
    return q_WB.conjugate() * (R_world * second - log_.experiment->scenario.gravity_W);
  }

  // One change first; two or three at once have to leave a quarter of what one leaves.
  void find_convention(const std::vector<Moment>& moments, double nominal, PoseFrame* out) const {
    double least = kPart * nominal;
    for (int changes = 1; changes <= 3; ++changes) {
      PoseFrame best = *out;
      double left = least;
      for (const PoseFrame& frame : list_conventions(changes)) {
        const double here = calc_left(moments, frame, {});
        if (here < left) {
          left = here;
          best = frame;
        }
      }
      if (left < least) {
        *out = best;
        out->left = left / nominal;
        least = kPart * left;
      }
    }
  }

  void find_world(const std::vector<Moment>& moments, PoseFrame* out) const {
    const double nominal = calc_left(moments, *out, {}, Of::kForce);
    double least = kPart * nominal;
    for (const Matrix3d& R_world : list_worlds()) {
      const PoseFrame frame{out->order, R_world, out->R_body, 0.0, 1.0};
      const double here = calc_left(moments, frame, {}, Of::kForce);
      if (here < least) {
        least = here;
        *out = frame;
        out->left = here / nominal;
      }
    }
  }

  static std::vector<PoseFrame> list_conventions(int changes) {
    std::vector<PoseFrame> out;
    for (Order order : {Order::kAsNamed, Order::kScalarFirst, Order::kInverse}) {
      for (const Matrix3d& R_world : list_worlds()) {
        for (const Matrix3d& R_body : list_quarter_turns()) {
          const int own = (order != Order::kAsNamed) + !R_world.isIdentity() + !R_body.isIdentity();
          if (own == changes) out.push_back({order, R_world, R_body, 0.0, 1.0});
        }
      }
    }
    return out;
  }

  // Which axis is up. The heading of a world is anything.
  static std::vector<Matrix3d> list_worlds() {
    std::vector<Matrix3d> out;
    for (const Vector3d& up :
         {Vector3d(0, 0, 1), Vector3d(0, 1, 0), Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(-1, 0, 0)})
      out.push_back(Eigen::Quaterniond::FromTwoVectors(up, Vector3d::UnitZ()).toRotationMatrix());
    out.push_back(Vector3d(1, -1, -1).asDiagonal());
    return out;
  }

  void find_clock(const std::vector<Moment>& moments, PoseFrame* out) const {
    const PoseFrame turned = *out;
    const auto measure = [&](const std::vector<Moment>& of) -> Left {
      return [this, &of, &turned](const Matrix3d&, const Clock& clock) { return calc_left(of, turned, clock); };
    };
    BestFrame best = find_best_clock(measure(moments), {});
    if (may_be_far(measure(moments), best))
      best = find_far_clock([this](Purpose side) { return list_moments(log_, side); }, measure, best);
    if (best.late == 0.0) return;
    out->late = best.late;
    out->left = turned.left * best.left;
  }

  const LeggedLog& log_;
  bool accelerometer_;
};

char name_axis(const Matrix3d& R_world) {
  Eigen::Index axis = 0;
  R_world.row(2).cwiseAbs().maxCoeff(&axis);
  return "xyz"[axis];
}

}  // namespace

PoseFrame find_pose_frame(const Experiment& e) {
  if (!e.scenario.floating_base || e.num_joints() == 0) return {};
  const LeggedLog log = make_legged_log(e, Half::kEven);
  const int imu = BodyMotion::find_main_imu(log);
  return log.base_pose && imu >= 0 ? PoseFinder(log).run() : PoseFrame{};
}

std::string describe(const PoseFrame& frame) {
  std::string out;
  const auto add = [&](const std::string& text) { out += (out.empty() ? "" : "; ") + text; };
  if (frame.order == Order::kScalarFirst) add("the quaternion's columns x y z w are taken as w x y z");
  if (frame.order == Order::kInverse) add("the quaternion is taken as its inverse, from the world to the body");
  if (!frame.R_world.isIdentity(1e-9)) {
    const char axis = name_axis(frame.R_world);
    const bool down = frame.R_world.row(2).sum() < 0.0;
    add(std::string("its world is taken as one with ") + axis + (down ? " down" : " up"));
  }
  if (!frame.R_body.isIdentity(1e-9)) add("its body is taken as turned against the base's link");
  return out;
}

Experiment convert_pose(Experiment e, const PoseFrame& frame) {
  if (!frame.any()) return e;
  const Eigen::Quaterniond q_world(frame.R_world), q_body(frame.R_body);
  for (Recording& r : e.recordings) {
    std::vector<double>*p[3], *q[4];
    for (int i = 0; i < 3; ++i) p[i] = &r.other.at(std::string("/base/pose/position/") + "xyz"[i]);
    for (int i = 0; i < 4; ++i) q[i] = &r.other.at(std::string("/base/pose/orientation/") + "wxyz"[i]);
    Eigen::Quaterniond last = Eigen::Quaterniond::Identity();
    for (size_t k = 0; k < p[0]->size(); ++k) {
      const Vector3d at = frame.R_world * Vector3d((*p[0])[k], (*p[1])[k], (*p[2])[k]);
      Eigen::Quaterniond to =
          q_world * put_in_order(frame.order, {(*q[0])[k], (*q[1])[k], (*q[2])[k], (*q[3])[k]}) * q_body;
      if (last.dot(to) < 0.0)
        to.coeffs() = -to.coeffs();  // q and -q are one attitude: lines between samples need one sign
      if (to.coeffs().allFinite()) last = to;
      for (int i = 0; i < 3; ++i) (*p[i])[k] = at(i);
      (*q[0])[k] = to.w();
      (*q[1])[k] = to.x();
      (*q[2])[k] = to.y();
      (*q[3])[k] = to.z();
    }
    if (frame.late != 0.0) shift_columns("/base/pose", frame.late, &r);
  }
  return e;
}

}  // namespace hrp::diagnosis::floating
