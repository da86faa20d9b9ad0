// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/imu_faults.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "common/multibody/kinematics.h"
#include "common/spatial/rpy.h"
#include "common/spatial/turn.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/checks/flat_feet.h"
#include "diagnosis/floating/checks/imu_over_legs.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/report/words.h"
#include "diagnosis/model/made.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr const char* kMotion = "the IMU turned by known angles about three axes";

int find_block(const Clip& clip, size_t k) { return static_cast<int>(std::floor(clip.time[k] / kBlock)); }

// Encoders of legs that may stand.
std::vector<RateMoment> list_by_legs(const LeggedLog& log, size_t imu) {
  std::vector<RateMoment> out;
  for (const Standing& s : list_standing(log, imu, Purpose::kForTurns)) {
    RateMoment m{static_cast<int>(s.at.clip->recording),
                 find_block(*s.at.clip, s.at.k),
                 get_values(s.at.clip->imus[imu].gyro, s.at.k),
                 {}};
    for (const StandingFeet& f : s.feet) m.told.push_back({f.A * s.R_BI, f.turn + f.A * s.more});
    out.push_back(std::move(m));
  }
  return out;
}

// Where an IMU is at a moment, and what the base's pose says of it.
struct Posed {
  const Clip* clip = nullptr;
  size_t k = 0;
  Vector3d rate, up;  // IMU axes by the model
};

std::vector<Posed> list_posed(const LeggedLog& log, size_t imu) {
  std::vector<Posed> out;
  const ImuSensor& sensor = log.imus[imu];
  if (!log.base_pose || !sensor.gyro) return out;
  LeggedLog others = log;
  others.imus.clear();
  for (const Clip& own : log.clips) {
    others.clips = {own};
    walk(others, Purpose::kForTurns, [&](const Clip&, size_t k, BodyMotion* motion) {
      const Matrix3d R_IB = (get_pose(motion->data(), sensor.link).R * sensor.R_LI).transpose();
      const Vector3d up = get_quaternion(own.base_attitude, k).normalized().conjugate() * Vector3d::UnitZ();
      out.push_back({&own, k, R_IB * get_velocity(motion->data(), sensor.link).head<3>(), R_IB * up});
    });
  }
  return out;
}

std::vector<RateMoment> list_by_pose(const std::vector<Posed>& posed, size_t imu) {
  std::vector<RateMoment> out;
  for (const Posed& p : posed) {
    out.push_back({static_cast<int>(p.clip->recording),
                   find_block(*p.clip, p.k),
                   get_values(p.clip->imus[imu].gyro, p.k),
                   {{Matrix3d::Identity(), p.rate}}});
  }
  return out;
}

// [nats] Odds that the accelerometer is turned, too, against that it is not: blocks of the direction that it feels on
// average. Steps shake it for less than a block.
double ask_accelerometer(const std::vector<Posed>& posed, size_t imu, const Matrix3d& R) {
  std::map<std::pair<const Clip*, int>, std::pair<Vector3d, Vector3d>> blocks;
  for (const Posed& p : posed) {
    auto& [felt, up] =
        blocks.try_emplace({p.clip, find_block(*p.clip, p.k)}, Vector3d::Zero(), Vector3d::Zero()).first->second;
    felt += get_values(p.clip->imus[imu].accelerometer, p.k);
    up += p.up;
  }
  std::vector<double> gains;
  for (const auto& [at, sums] : blocks) {
    const Vector3d felt = sums.first.normalized(), up = sums.second.normalized();
    gains.push_back(std::log((kTiltOfSoles + (felt - up).norm()) / (kTiltOfSoles + (R * felt - up).norm())));
  }
  return calc_block_odds(gains);
}

// The same by legs that stand.
double ask_accelerometer(const LeggedLog& log, size_t imu, const Matrix3d& R) {
  std::vector<Instant> at;
  std::vector<double> turned, nominal;
  for (const Standing& s : list_standing(log, imu, Purpose::kForTurns)) {
    const Vector3d rate = s.R_BI * (R * get_values(s.at.clip->imus[imu].gyro, s.at.k)) - s.more,
                   felt = get_values(s.at.clip->imus[imu].accelerometer, s.at.k).normalized();
    at.push_back(s.at);
    turned.push_back(std::sqrt(calc_left(s.feet, rate, s.R_BI * (R * felt))));
    nominal.push_back(std::sqrt(calc_left(s.feet, rate, s.R_BI * felt)));
  }
  return calc_odds(at, turned, nominal);
}

Turned find_what(const LeggedLog& log, const std::vector<Posed>& posed, const ImuFault& fault) {
  if (!log.imus[fault.imu].accelerometer) return Turned::kGyroscope;
  const Matrix3d R = make_turn(fault.map.turn).toRotationMatrix();
  const double odds = posed.empty() ? ask_accelerometer(log, fault.imu, R) : ask_accelerometer(posed, fault.imu, R);
  return odds > kOdds ? Turned::kWhole : odds < -kOdds ? Turned::kGyroscope : Turned::kUnknown;
}

// [nats] Odds by legs that the IMU is turned as the pose has it, against that the pose is turned.
double ask_legs(const GyroMap& by_pose, const GyroMap& by_legs) {
  if (!by_legs.told) return 0;
  const Eigen::LDLT<Matrix3d> inverse(by_pose.turn_covariance + by_legs.turn_covariance);
  const Vector3d away = by_legs.turn - by_pose.turn;
  return 0.5 * (by_legs.turn.dot(inverse.solve(by_legs.turn)) - away.dot(inverse.solve(away)));
}

// Nothing that legs or the pose say of an IMU's turn is a fault of the IMU if the other of them contradicts.
bool find_fault(const LeggedLog& log, size_t imu, ImuFault* out) {
  const std::vector<Posed> posed = list_posed(log, imu);
  const GyroMap by_legs = find_gyro_map(list_by_legs(log, imu)), by_pose = find_gyro_map(list_by_pose(posed, imu));
  out->imu = imu;
  out->by_pose = by_pose.told;
  out->map = by_pose.told ? by_pose : by_legs;
  // Balls roll and slide in step with the turning, which looks like a scale. So do soft soles, by more than any
  // gyroscope errs: they are calibrated to some percent. Wrong units are larger factors, and found before (degrees:
  // 57).
  const bool far = std::abs(std::log(out->map.scale)) > std::log(kClearlyMore);
  if (!out->by_pose && (far || !has_flat_foot(log))) out->map.is_scaled = false;
  if (out->map.may_be_turned) out->what = find_what(log, posed, *out);
  // Where much else is left of the rates, an accelerometer that is turned by the same is a second witness.
  if (out->map.may_be_turned && out->what == Turned::kWhole) out->map.is_turned = true;
  if (out->map.is_turned && out->by_pose) {
    const double odds = ask_legs(by_pose, by_legs);
    if (odds < -kOdds) out->map.is_turned = false;
    out->pose_may_be = odds < kOdds;
  }
  return out->map.is_turned || out->map.is_scaled;
}

// What is smaller than mountings are known is taken as none: gravity over it would be a zero of the accelerometer.
Vector3d keep_mounted(Vector3d turn) {
  for (double& angle : turn) angle = std::abs(angle) < kMountingError ? 0.0 : angle;
  return turn;
}

std::vector<Estimate> make_turn_value(const GyroMap& map) {
  const Vector3d rpy = calc_rpy(make_turn(map.turn).toRotationMatrix());
  const auto std = [&](int a) {
    return std::hypot(std::sqrt(map.turn_covariance(a, a)), kMountingError / kNinetyFive);
  };
  return {{"rpy", "rad", {rpy.x(), rpy.y(), rpy.z()}, {std(0), std(1), std(2)}, true}};
}

// Joints that give let links turn by more than their encoders say.
void add_elasticity(const LeggedLog& log, Finding* f) {
  f->alternatives.push_back(make_alternative(get_laws().elasticity.info(), {{"link", log.tree.links[0].name}}, {},
                                             "the same motion, recorded by motion capture or an attitude"));
}

// `left`: squares beside the fault over those without it.
void grade(double left, Finding* f) {
  f->grade = f->alternatives.empty() ? Grade::kSupported : Grade::kAmbiguous;
  f->probability = 0.9;
  f->share = 1 - left;
  f->weight = 0.5;
}

Finding make_turn_finding(const LeggedLog& log, const ImuFault& fault) {
  const EffectInfo& effect = get_laws().sensor_misalignment.info();
  const std::string whole = "/imu/" + log.imus[fault.imu].name, gyro = whole + "/angular_velocity";
  const std::vector<Estimate> value = make_turn_value(fault.map);
  Finding f = make_finding(effect, {{"sensor", fault.what == Turned::kGyroscope ? gyro : whole}}, value);
  const auto add = [&](const EffectInfo& other, const Where& where, std::vector<Estimate> values, const char* motion) {
    f.alternatives.push_back(make_alternative(other, where, std::move(values), motion));
  };
  if (fault.what == Turned::kUnknown) add(effect, {{"sensor", gyro}}, value, kMotion);
  if (fault.pose_may_be) add(effect, {{"sensor", "/base/pose"}}, {}, kMotion);
  if (!fault.by_pose && fault.what != Turned::kWhole) add_elasticity(log, &f);
  grade(fault.map.turn_left, &f);
  f.statement = (fault.what == Turned::kGyroscope ? gyro : whole) +
                format(" is mounted %.1f degrees otherwise than the model says: so turned, its rates fit those of ",
                       fault.map.turn.norm() * 180 / M_PI) +
                (fault.by_pose ? "the base's pose" : "legs that stand") +
                (fault.what == Turned::kWhole ? ", and its accelerometer feels up where it is." : ".");
  return f;
}

Finding make_scale_finding(const LeggedLog& log, const ImuFault& fault) {
  const EffectInfo& effect = get_laws().sensor_scale.info();
  const std::string gyro = "/imu/" + log.imus[fault.imu].name + "/angular_velocity";
  Finding f = make_finding(effect, {{"sensor", gyro}}, {make_value(effect, fault.map.scale, fault.map.scale_std)});
  if (!fault.by_pose) add_elasticity(log, &f);
  grade(fault.map.scale_left, &f);
  f.statement = gyro +
                format(" reads %.3f +- %.3f times the rate of ", fault.map.scale, kNinetyFive * fault.map.scale_std) +
                (fault.by_pose ? "the base's pose." : "legs that stand.");
  return f;
}

}  // namespace

std::vector<ImuFault> find_imu_faults(const LeggedLog& log) {
  std::vector<ImuFault> out;
  if (!log.tree.floating_base) return out;
  for (size_t i = 0; i < log.imus.size(); ++i) {
    ImuFault fault;
    if (log.imus[i].gyro && find_fault(log, i, &fault)) out.push_back(fault);
  }
  return out;
}

std::vector<std::string> compare_gyros(const LeggedLog& log) {
  std::vector<std::string> out;
  for (size_t i = 0; i < log.imus.size() && log.tree.floating_base && !log.base_pose; ++i) {
    if (!log.imus[i].gyro) continue;
    const GyroMap map = find_gyro_map(list_by_legs(log, i));
    if (!map.told) continue;
    out.push_back("/imu/" + log.imus[i].name + "/angular_velocity" +
                  format(": its rates differ from those of legs that stand by %.3f rad/s (median; %.3f with readings "
                         "of another time). It reads %.2f +- %.2f times their rate",
                         map.usual, map.of_another_time, map.scale, kNinetyFive * map.scale_std) +
                  (has_flat_foot(log) ? "." : "; balls that roll or slide change that factor, too."));
  }
  return out;
}

Eigen::VectorXd list_imu_faults(const ColumnLayout& layout, const std::vector<ImuFault>& faults) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(layout.count());
  for (const ImuFault& f : faults) {
    const int imu = static_cast<int>(f.imu);
    if (f.map.is_scaled) out(layout.imu(imu, kGyroScaleColumn)) = f.map.scale - 1;
    if (!f.map.is_turned) continue;
    const Vector3d turn = keep_mounted(f.map.turn);
    out.segment<3>(layout.imu(imu, kGyroTurnColumn)) = turn;
    if (f.what != Turned::kGyroscope) out.segment<3>(layout.imu(imu, kAccelerometerTurnColumn)) = turn;
  }
  return out;
}

void add_imu_findings(const LeggedLog& log, const ImuFault& fault, std::vector<Finding>* out) {
  if (fault.map.is_turned) out->push_back(make_turn_finding(log, fault));
  if (fault.map.is_scaled) out->push_back(make_scale_finding(log, fault));
}

}  // namespace hrp::diagnosis::floating
