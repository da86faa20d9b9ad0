// SPDX-License-Identifier: BSD-3-Clause
#include "controller/walking/walk_controller.h"

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"
#include "controller/walking/pattern.h"
#include "controller/walking/stabilizer.h"
#include "controller/walking/whole_body.h"

namespace hrp {
namespace {

using namespace walking;

// Small turns about world x and y.
Matrix3d make_turn(const Vector2d& roll_pitch) { return make_rotation_from_rpy({roll_pitch.x(), roll_pitch.y(), 0.0}); }

class WalkController : public Controller {
 public:
  explicit WalkController(const Robot& robot)
      : spec_(robot.settings.walk), laws_(spec_.stabilizer), body_(*robot.description, spec_, robot.initial_q) {
    sensor_[kLeft] = find_sensor(robot, spec_.left_sensor);
    sensor_[kRight] = find_sensor(robot, spec_.right_sensor);
    for (size_t i = 0; i < robot.imus.size() && imu_ < 0; ++i) {
      if (spec_.imu.empty() || spec_.imu == robot.imus[i]) imu_ = static_cast<int>(i);
    }
    if (imu_ < 0)
      refuse_input({"", "sensors.imu"}, "walking needs an IMU" + (spec_.imu.empty() ? "" : " '" + spec_.imu + "'"));
    imu_frame_ = body_.find_frame(robot.sensors.imus[static_cast<size_t>(imu_)].link);
    for (int side : {kLeft, kRight}) {
      sensor_frame_[side] = body_.find_frame(robot.sensors.wrenches[static_cast<size_t>(sensor_[side])].link);
    }
    const Vector3d& gravity_W = robot.gravity_W;
    if (gravity_W.head<2>().norm() > 0.0 || !(gravity_W.z() < 0.0))
      refuse_input({"", "gravity"}, "walking needs gravity straight down, such as [0, 0, -9.81]");
    gravity_ = -gravity_W.z();
    weight_ = body_.mass() * gravity_;
  }

  void start(const Robot&) override {
    pattern_.reset();
    attitude_.reset();
    last_q_.resize(0);
    solved_.resize(0);
    for (int side : {kLeft, kRight}) {
      load_[side] = FootLoad();
      foot_turn_[side].setZero();
    }
    rate_.setZero();
    inclination_.setZero();
    body_offset_.setZero();
    com_error_.setZero();
    com_speed_error_.setZero();
    tracking_integral_.setZero();
    follower_ = Follower();
    lift_ = 0.0;
    for (int side : {kLeft, kRight}) {
      landing_lift_[side] = 0.0;
      touched_[side] = false;
    }
    have_com_error_ = false;
  }

  std::unique_ptr<Controller> clone() const override { return std::make_unique<WalkController>(*this); }

  JointCommand control(const SensorData& sensors, const Robot& robot) override {
    dt_ = robot.period;
    measure(sensors);
    if (!pattern_) make_pattern(sensors);
    // Commands are reached at the end of the period that begins now.
    const double t = sensors.time - start_time_;
    PatternSample now = pattern_->sample(t);
    now.com.head<2>() += follower_.x - now.shift;
    if (sensors.step > 0) observe(now, t);
    PatternSample goal = pattern_->sample(t + dt_);
    follower_ = update_follower(follower_, goal.shift, spec_.step_adjustment.follow, dt_);
    goal.com.head<2>() += follower_.x - goal.shift;
    Eigen::VectorXd q = robot.initial_q;  // joints without a drive keep it
    Vector3d com = goal.com;
    Matrix3d R_WB = goal.R_WB;
    Transform soles[2] = {goal.soles[0], goal.soles[1]};
    if (sensors.step > 0) stabilize(now, goal, &com, &R_WB, soles);
    // From the last solution: joints outside the legs keep their place, whatever their encoders say.
    if (solved_.size() != q.size()) solved_ = robot.initial_q;
    body_.update(solved_);
    body_.solve(com, R_WB, soles, &solved_);
    for (int i = 0; i < q.size(); ++i) {
      if (!robot.description->tree.joint(i).actuated) continue;
      // The first half of the settling leads from where the joints are: feet that do not stand level are not jerked.
      const double blend = calc_blend(2.0 * (sensors.time + dt_ - start_time_) / spec_.settle);
      const double wanted = start_q_[i] + blend * (solved_[i] - start_q_[i]);
      q[i] = std::min(std::max(wanted, robot.lower[i]), robot.upper[i]);
    }
    JointCommand command;
    command.q = q;
    command.qd = last_q_.size() ? Eigen::VectorXd((q - last_q_) / dt_) : Eigen::VectorXd::Zero(q.size());
    last_q_ = q;
    return command;
  }

 private:
  int find_sensor(const Robot& robot, const std::string& name) const {
    for (size_t i = 0; i < robot.wrenches.size(); ++i) {
      if (robot.wrenches[i] == name) return static_cast<int>(i);
    }
    refuse_input({"", "sensors.wrench"}, "walking needs a force sensor '" + name + "'");
  }

  Matrix3d find_attitude(const ImuSample& imu) {
    if (!spec_.attitude_filter.on) return imu.R_WS.toRotationMatrix();
    if (attitude_)
      attitude_->update(imu.angular_velocity, imu.linear_acceleration, dt_);
    else
      attitude_.emplace(spec_.attitude_filter.time_constant);
    if (!pattern_) attitude_->reset(calc_level_attitude(imu.linear_acceleration));
    return attitude_->get();
  }

  // Encoders, attitude, loads of the feet.
  void measure(const SensorData& sensors) {
    body_.update(sensors.q);
    const ImuSample& imu = sensors.imus[static_cast<size_t>(imu_)];
    const Matrix3d R_BI = body_.get_frame(imu_frame_).R;
    const Matrix3d R_WS = find_attitude(imu);
    R_WB_ = R_WS * R_BI.transpose();
    rate_W_ = R_WS * imu.angular_velocity;
    com_B_ = body_.get_com();
    const double blend = laws_.force_filter > 0.0 ? std::min(1.0, dt_ / laws_.force_filter) : 1.0;
    for (int side : {kLeft, kRight}) {
      sole_B_[side] = body_.get_sole(static_cast<Side>(side));
      const Transform X_FS = body_.get_frame(sensor_frame_[side]).inverse() * sole_B_[side];
      const FootLoad raw = calc_foot_load(sensors.wrenches[static_cast<size_t>(sensor_[side])], X_FS);
      load_[side].force += blend * (raw.force - load_[side].force);
      load_[side].torque += blend * (raw.torque - load_[side].torque);
    }
  }

  // World of the pattern: level as the IMU says, heading of the feet, origin between the soles.
  void make_pattern(const SensorData& sensors) {
    start_time_ = sensors.time;
    start_q_ = sensors.q;
    R_PW_ = calc_pattern_axes(body_, R_WB_);
    const PatternStart start = make_pattern_start(body_, R_PW_ * R_WB_);
    const double zc = spec_.com_height > 0.0 ? spec_.com_height : start.com.z();
    pattern_.emplace(spec_, start, zc, gravity_);
  }

  // Roll and pitch of the body beyond the reference, pattern axes; their rates.
  void find_lean(const PatternSample& now, const PatternSample& goal, Vector2d* lean, Vector2d* rate) {
    // Heading is not controlled: the reference is compared with the measured body turned to the same heading.
    const Matrix3d R = R_PW_ * R_WB_;
    const Vector3d up_body = R * now.R_WB.transpose() * Vector3d::UnitZ();
    *lean = Vector2d(-up_body.y(), up_body.x());
    const Vector3d w = R_PW_ * rate_W_;
    const Eigen::AngleAxisd turn(goal.R_WB * now.R_WB.transpose());
    const Vector2d raw = w.head<2>() - (turn.angle() / dt_ * turn.axis()).head<2>();
    rate_ += std::min(1.0, dt_ / std::max(laws_.rate_filter, dt_)) * (raw - rate_);
    *rate = rate_;
  }

  // How far the body is from the reference; where it will not come back, the reference and the next footholds give way.
  void observe(const PatternSample& now, double t) {
    const bool left = now.support != Support::kRight, right = now.support != Support::kLeft;
    update_com_error(now, distribute(now.zmp, now.soles, left, right, weight_).force[kLeft] / weight_);
    find_touch(now, left, right);
    const StepAdjustmentSpec& spec = spec_.step_adjustment;
    // A foot that has touched before its time stays there, and its knock is no motion of the body.
    if (!spec.on || touched_[kLeft] || touched_[kRight]) return;
    // Against the place and speed that the body is on its way to.
    const Vector2d coming = now.shift - follower_.x;
    const double Tc = pattern_->pendulum().calc_time_constant();
    const Vector2d error = com_error_ - coming + Tc * (com_speed_error_ + follower_.v);
    if (pattern_->find_remaining(t) > spec.freeze) pattern_->move_step(t, calc_step_shift(spec, error));
  }

  // Centre of mass from the soles that carry, turned as the IMU says.
  void update_com_error(const PatternSample& now, double share) {
    const Matrix3d R = R_PW_ * R_WB_;
    const Vector3d from_left = now.soles[kLeft].p + R * (com_B_ - sole_B_[kLeft].p);
    const Vector3d from_right = now.soles[kRight].p + R * (com_B_ - sole_B_[kRight].p);
    const Vector2d error = (share * from_left + (1.0 - share) * from_right - now.com).head<2>();
    if (have_com_error_) {
      constexpr double kCutoff = 2.0 * M_PI * 6.0;  // [rad/s] noise and the seams of steps above 6 Hz are no motion
      const double blend = dt_ * kCutoff / (1.0 + dt_ * kCutoff);
      com_speed_error_ += blend * ((error - com_error_) / dt_ - com_speed_error_);
    }
    com_error_ = error;
    have_com_error_ = true;
  }

  void stabilize(const PatternSample& now, const PatternSample& goal, Vector3d* com, Matrix3d* R_WB,
                 Transform soles[2]) {
    const bool left = now.support != Support::kRight, right = now.support != Support::kLeft;
    Vector2d lean, rate;
    find_lean(now, goal, &lean, &rate);
    Vector3d zmp_command = now.zmp;
    if (laws_.tracking) {
      tracking_integral_ = clamp(tracking_integral_ + dt_ * laws_.tracking_integral * com_error_, 0.05);
      zmp_command.head<2>() +=
          laws_.tracking_position * com_error_ + laws_.tracking_velocity * com_speed_error_ + tracking_integral_;
    }
    const double least = 0.2 * weight_;
    Vector3d zmp = zmp_command;
    const bool grounded = calc_zmp(load_, now.soles, least, &zmp);
    if (laws_.landing) land(now, goal, soles);
    if (laws_.foot_adjusting && grounded) adjust_feet(now, zmp_command, left, right, soles);
    if (laws_.zmp_damping) {
      const Vector2d error = grounded ? Vector2d((zmp - zmp_command).head<2>()) : Vector2d(Vector2d::Zero());
      body_offset_ = update_zmp_damping(laws_, error, dt_, body_offset_);
      com->head<2>() += body_offset_;
    }
    if (laws_.inclination) {
      const Matrix3d turn = make_turn(calc_inclination_turn(laws_, lean, rate, dt_, &inclination_));
      // About the ankles over the zero moment point: turning about the ground itself would push the hips sideways.
      const double height = -0.5 * (body_.sole_in_foot(kLeft).p.z() + body_.sole_in_foot(kRight).p.z());
      const Vector3d pivot = goal.zmp + Vector3d(0.0, 0.0, height);
      *com = pivot + turn * (*com - pivot);
      *R_WB = turn * *R_WB;
    }
  }

  // A foot may meet the ground from the middle of its swing on, when it is on its way down.
  void find_touch(const PatternSample& now, bool left, bool right) {
    for (int side : {kLeft, kRight}) {
      const bool swinging = !(side == kLeft ? left : right);
      const double sink = swing_height_[side] - now.soles[side].p.z();
      swing_height_[side] = now.soles[side].p.z();
      touched_[side] = swinging && sink > 0.0 && (touched_[side] || load_[side].force.z() > laws_.landing_force);
    }
  }

  void land(const PatternSample& now, const PatternSample& goal, Transform soles[2]) {
    for (int side : {kLeft, kRight}) {
      const double descent = now.soles[side].p.z() - goal.soles[side].p.z();
      landing_lift_[side] = update_landing(laws_, touched_[side], descent, dt_, landing_lift_[side]);
      soles[side].p.z() += landing_lift_[side];
    }
  }

  void adjust_feet(const PatternSample& now, const Vector3d& zmp_command, bool left, bool right, Transform soles[2]) {
    const LoadReference reference = distribute(zmp_command, now.soles, left, right, weight_);
    for (int side : {kLeft, kRight}) {
      const Vector2d error = load_[side].torque.head<2>() - reference.torque[side];
      foot_turn_[side] = update_foot_turn(laws_, error, dt_, foot_turn_[side]);
      soles[side].R = soles[side].R * make_turn(foot_turn_[side]);
    }
    const double error =
        (load_[kLeft].force.z() - load_[kRight].force.z()) - (reference.force[kLeft] - reference.force[kRight]);
    // What a foot that has come too early carries is no fault of the other's.
    const bool early = laws_.landing && (touched_[kLeft] || touched_[kRight]);
    lift_ = update_foot_lift(laws_, early ? 0.0 : error, left && right, dt_, lift_);
    soles[kLeft].p.z() += 0.5 * lift_;
    soles[kRight].p.z() -= 0.5 * lift_;
  }

  WalkSpec spec_;
  StabilizerSpec laws_;
  WholeBody body_;
  int sensor_[2] = {-1, -1}, sensor_frame_[2] = {-1, -1}, imu_ = -1, imu_frame_ = -1;
  double gravity_ = kGravity, weight_ = 0.0, dt_ = 0.005;
  std::optional<WalkPattern> pattern_;
  std::optional<AttitudeFilter> attitude_;
  Matrix3d R_PW_ = Matrix3d::Identity();  // pattern from the IMU's world: heading only
  double start_time_ = 0.0;               // [s] of the first sample
  Eigen::VectorXd start_q_, last_q_, solved_;
  // Measured.
  Matrix3d R_WB_ = Matrix3d::Identity();
  Vector3d rate_W_ = Vector3d::Zero(), com_B_ = Vector3d::Zero();
  Transform sole_B_[2];
  FootLoad load_[2];
  // Memories of the laws.
  Vector2d rate_ = Vector2d::Zero(), inclination_ = Vector2d::Zero(), body_offset_ = Vector2d::Zero();
  Vector2d foot_turn_[2] = {Vector2d::Zero(), Vector2d::Zero()};
  double lift_ = 0.0, landing_lift_[2] = {0.0, 0.0}, swing_height_[2] = {0.0, 0.0};
  bool touched_[2] = {false, false};
  Vector2d com_error_ = Vector2d::Zero(), com_speed_error_ = Vector2d::Zero(), tracking_integral_ = Vector2d::Zero();
  bool have_com_error_ = false;
  Follower follower_;  // of the body, after the feet
};

}  // namespace

std::unique_ptr<Controller> make_walk_controller(const Robot& robot) { return std::make_unique<WalkController>(robot); }

}  // namespace hrp
