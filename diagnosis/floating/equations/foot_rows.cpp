// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/foot_rows.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/multibody/kinematics.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/slopes.h"
#include "diagnosis/standing/sole.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kSettled = 0.08;     // [s] after landing and before lifting: the foot is not flat for sure
constexpr double kPlumbError = 3e-3;  // [rad] of an attitude by gravity alone: an acceleration of 0.03 m/s^2 that lasts
constexpr size_t kMostPairs = 4;      // feet that are compared pair by pair

// Roll and pitch of a foot whose axes see the vertical as `up`.
Eigen::Vector2d calc_tilt(const Vector3d& up) {
  return {std::atan2(up.y(), up.z()), -std::asin(std::clamp(up.x(), -1.0, 1.0))};
}

}  // namespace

bool presses_inside(const Foot& foot, const Vector3d& moment, double force) {
  return std::abs(moment.y()) < kNearlyAll * foot.size.x() / 2 * force &&
         std::abs(moment.x()) < kNearlyAll * foot.size.y() / 2 * force;
}

FootRows::FootRows(const LeggedLog& log, const Contacts& contacts, const ColumnLayout& layout, RowTable* table)
    : log_(log),
      contacts_(contacts),
      layout_(layout),
      table_(*table),
      tilt_(2 * log.feet.size(), -1),
      imu_(log.feet.size(), -1) {
  if (!log.tree.floating_base || log.clips.empty()) return;
  const int main = BodyMotion::find_main_imu(log);
  const bool recorded = BodyMotion(log, log.clips[0]).has_attitude();
  // A body that leans slowly feels where up is; steps shake that too much.
  if (!recorded && !contacts.walks && main >= 0 && log.imus[static_cast<size_t>(main)].accelerometer) plumb_ = main;
  const bool upright = recorded || plumb_ >= 0;
  std::vector<int> joints = list_turn_columns(log, layout);
  if (main >= 0 && log.imus[static_cast<size_t>(main)].attitude) attitude_ = main;
  for (int c = kAttitudeTurnColumn; attitude_ >= 0 && c < kImuColumns; ++c) joints.push_back(layout.imu(attitude_, c));
  const auto add_accelerometer = [&](int imu, std::vector<int>* columns) {
    for (int c = 0; imu >= 0 && c < 3; ++c) {
      columns->push_back(layout.imu(imu, kAccelerometerBiasColumn + c));
      columns->push_back(layout.imu(imu, kAccelerometerTurnColumn + c));
    }
  };
  for (size_t f = 0; f < imu_.size(); ++f) {
    for (size_t i = 0; i < log.imus.size(); ++i) {
      if (log.imus[i].link == log.feet[f].link && log.imus[i].accelerometer) imu_[f] = static_cast<int>(i);
    }
  }
  if (!upright) find_ground();
  const auto is_told = [&](size_t f) {
    return upright || imu_[f] >= 0 || (ground_ >= 0 && static_cast<int>(f) != ground_);
  };
  for (size_t f = 0; f < log.feet.size(); ++f) {
    for (int a = 0; log.feet[f].flat && is_told(f) && a < 2; ++a) {
      std::vector<int> columns = joints;
      add_accelerometer(imu_[f] >= 0 ? imu_[f] : plumb_, &columns);
      if (ground_ < 0) {
        columns.push_back(layout.slope(0));
        columns.push_back(layout.slope(1));
      }
      add_sole_columns(f, a, &columns);
      for (int b = 0; ground_ >= 0 && b < 2; ++b) add_sole_columns(static_cast<size_t>(ground_), b, &columns);
      tilt_[2 * f + static_cast<size_t>(a)] =
          table->add_channel({{EquationKind::kTilt, a}, "/joint_states", "rad", "foot", log.feet[f].name}, columns);
    }
  }
  for (size_t a = 0; (upright || ground_ >= 0) && a < log.feet.size() && log.feet.size() <= kMostPairs; ++a) {
    for (size_t b = a + 1; b < log.feet.size(); ++b) {
      if (ground_ >= 0 && static_cast<int>(a) != ground_) continue;
      std::vector<int> columns = joints;
      add_accelerometer(plumb_, &columns);
      if (ground_ < 0) {
        columns.push_back(layout.slope(0));
        columns.push_back(layout.slope(1));
      }
      columns.push_back(layout.foot(static_cast<int>(a), kSinkColumn));
      columns.push_back(layout.foot(static_cast<int>(b), kSinkColumn));
      columns.push_back(layout.foot(static_cast<int>(a), kSinkDampColumn));
      columns.push_back(layout.foot(static_cast<int>(b), kSinkDampColumn));
      pairs_.push_back({a, b,
                        table->add_channel({EquationKind::kHeight, "/joint_states", "m", "foot", log.feet[b].name,
                                            find_height_error(a, b)},
                                           columns)});
    }
  }
}

// Nothing tells the vertical: the first of several flat feet lies on the ground that the others lie on, too. In a walk,
// only forces tell when both do.
void FootRows::find_ground() {
  if (contacts_.walks && !contacts_.from_forces) return;
  const auto flat = std::count_if(log_.feet.begin(), log_.feet.end(), [](const Foot& f) { return f.flat; });
  const bool felt = std::any_of(imu_.begin(), imu_.end(), [](int i) { return i >= 0; });
  for (size_t f = 0; flat > 1 && !felt && ground_ < 0 && f < log_.feet.size(); ++f)
    ground_ = log_.feet[f].flat ? static_cast<int>(f) : -1;
}

// Of a sole whose moment is recorded: how it gives about roll or pitch.
void FootRows::add_sole_columns(size_t f, int axis, std::vector<int>* columns) const {
  const int sensor = log_.feet[f].sensor;
  if (sensor < 0 || !log_.sensors[static_cast<size_t>(sensor)].has_wrench()) return;
  for (int c = 0; c < 2; ++c) {
    columns->push_back(layout_.foot(static_cast<int>(f), 2 * axis + c));
    columns->push_back(layout_.foot(static_cast<int>(f), (axis == 0 ? kRollShiftColumn : kPitchShiftColumn) + c));
  }
}

// [m] Soles sink by tenths of a millimetre. An attitude by gravity alone errs by more over the distance of two feet.
double FootRows::find_height_error(size_t a, size_t b) const {
  if (plumb_ < 0) return 0;
  BodyMotion motion(log_, log_.clips[0]);
  motion.update(log_.clips[0].edge);
  const auto place = [&](size_t f) -> Vector3d {
    return get_pose(motion.data(), log_.feet[f].link) * log_.feet[f].p_LC;
  };
  return kPlumbError * (place(b) - place(a)).norm();
}

bool FootRows::stands(size_t clip, size_t foot, size_t k) const {
  const std::vector<char>& loaded = contacts_.loaded[clip][foot];
  const auto reach = static_cast<size_t>(std::lround(kSettled / log_.clips[clip].step));
  return loaded[k] && loaded[k > reach ? k - reach : 0] && loaded[std::min(k + reach, loaded.size() - 1)];
}

FootRows::Load FootRows::find_load(size_t clip, size_t f, size_t k, BodyMotion*) const {
  Load load;
  const Foot& foot = log_.feet[f];
  load.flat = stands(clip, f, k);
  if (foot.sensor < 0) return load;
  const auto s = static_cast<size_t>(foot.sensor);
  const ForceSensor& sensor = log_.sensors[s];
  const Clip& c = log_.clips[clip];
  load.force = calc_vertical_force(log_, c, s, k);
  load.known = true;
  if (!sensor.has_wrench() || sensor.world) return load;
  const Vector3d force = sensor.X_LS.R * get_values(&c.force[6 * s], k);
  load.moment = move_to_sole(sensor, foot, get_values(&c.force[6 * s], k), get_values(&c.force[6 * s + 3], k));
  // What hangs below a sensor, the sole carries beside the reading. Where the rubber sits is not known: half.
  load.force = force.z() + kHalf * sensor.hangs * log_.experiment->scenario.gravity_W.norm();
  load.rate = (sensor.X_LS.R * get_rates(&c.force[6 * s], k)).z();
  load.whole = force;
  load.flat = load.flat && presses_inside(foot, load.moment, force.z());
  return load;
}

// Tilts of all feet, then heights of all pairs, at the pose that `motion` has.
Eigen::VectorXd FootRows::calc_values(size_t clip, size_t k, const Vector3d& turn, BodyMotion* motion) const {
  Eigen::VectorXd out(static_cast<long>(tilt_.size() + pairs_.size()));
  const auto find_normal = [&](size_t f) -> Vector3d { return get_pose(motion->data(), log_.feet[f].link).R.col(2); };
  const Vector3d up = ground_ >= 0 ? find_normal(static_cast<size_t>(ground_)) : Vector3d(motion->find_up(k) + turn);
  const auto place = [&](size_t f) -> Vector3d {
    return get_pose(motion->data(), log_.feet[f].link) * log_.feet[f].p_LC - log_.feet[f].radius * up;
  };
  for (size_t f = 0; f < log_.feet.size(); ++f) {
    const Matrix3d R = get_pose(motion->data(), log_.feet[f].link).R;
    Vector3d up_F = R.transpose() * up;
    if (imu_[f] >= 0) {  // a foot that stands hardly accelerates: what its IMU feels is its weight
      const auto i = static_cast<size_t>(imu_[f]);
      up_F = (log_.imus[i].R_LI * get_values(log_.clips[clip].imus[i].accelerometer, k)).normalized();
    }
    out.segment<2>(static_cast<long>(2 * f)) = calc_tilt(up_F);
  }
  for (size_t i = 0; i < pairs_.size(); ++i) {
    out(static_cast<long>(tilt_.size() + i)) = up.dot(place(pairs_[i].b) - place(pairs_[i].a));
  }
  return out;
}

// An IMU that is turned by rpy reads an attitude in which the vertical is turned back; one that is late, that of
// before.
void FootRows::add_attitude(size_t clip, size_t k, const Eigen::VectorXd& y, const std::vector<int>& open,
                            BodyMotion* motion) {
  const ImuSensor& imu = log_.imus[static_cast<size_t>(attitude_)];
  const Matrix3d R_BI = get_pose(motion->data(), imu.link).R * imu.R_LI;
  const Vector3d up = R_BI.transpose() * motion->find_up(k);
  const Vector3d rate = get_values(log_.clips[clip].imus[static_cast<size_t>(attitude_)].gyro, k);
  const Vector3d changes[] = {-Vector3d::UnitX().cross(up), -Vector3d::UnitY().cross(up), -Vector3d::UnitZ().cross(up),
                              rate.cross(up)};
  for (int c = 0; c < 4; ++c) {
    const Eigen::VectorXd slope = (calc_values(clip, k, kSlopeStep * (R_BI * changes[c]), motion) - y) / kSlopeStep;
    for (size_t r = 0; r < open.size(); ++r) {
      if (open[r] >= 0)
        table_.add(open[r], layout_.imu(attitude_, kAttitudeTurnColumn + c), slope(static_cast<long>(r)));
    }
  }
}

// The same of a vertical that an accelerometer feels: a bias leans it, and one that is turned reads it turned back.
void FootRows::add_plumb(size_t clip, size_t k, const Eigen::VectorXd& y, const std::vector<int>& open,
                         BodyMotion* motion) {
  const auto add = [&](int i, size_t row, const Vector3d& up, const std::function<double(const Vector3d&)>& slope) {
    const double g = log_.experiment->scenario.gravity_W.norm();
    for (int a = 0; open[row] >= 0 && a < 3; ++a) {
      table_.add(open[row], layout_.imu(i, kAccelerometerBiasColumn + a), slope((Vector3d::Unit(a) - up(a) * up) / g));
      table_.add(open[row], layout_.imu(i, kAccelerometerTurnColumn + a), slope(-Vector3d::Unit(a).cross(up)));
    }
  };
  for (size_t r = 0; r < open.size(); ++r) {
    const int own = r < tilt_.size() ? imu_[r / 2] : -1;
    if (own >= 0) {
      const ImuSensor& imu = log_.imus[static_cast<size_t>(own)];
      const Vector3d up = get_values(log_.clips[clip].imus[static_cast<size_t>(own)].accelerometer, k).normalized();
      add(own, r, up, [&](const Vector3d& change) {
        return (calc_tilt(imu.R_LI * (up + kSlopeStep * change)) - calc_tilt(imu.R_LI * up))(static_cast<long>(r % 2)) /
               kSlopeStep;
      });
    } else if (plumb_ >= 0) {
      const ImuSensor& imu = log_.imus[static_cast<size_t>(plumb_)];
      const Matrix3d R_BI = get_pose(motion->data(), imu.link).R * imu.R_LI;
      add(plumb_, r, R_BI.transpose() * motion->find_up(k), [&](const Vector3d& change) {
        const auto at = static_cast<long>(r);
        return (calc_values(clip, k, kSlopeStep * (R_BI * change), motion)(at) - y(at)) / kSlopeStep;
      });
    }
  }
}

// What a sole that gives adds to a tilt, times `factor`.
void FootRows::add_sole(int channel, size_t f, int axis, double factor, const Load& load, BodyMotion* motion) {
  const Vector3d w = get_pose(motion->data(), log_.feet[f].link).R.transpose() *
                     get_velocity(motion->data(), log_.feet[f].link).head<3>();
  const auto foot = static_cast<int>(f);
  table_.add(channel, layout_.foot(foot, 2 * axis), factor * load.moment(axis));
  table_.add(channel, layout_.foot(foot, 2 * axis + 1), factor * w(axis));
  const int shift = axis == 0 ? kRollShiftColumn : kPitchShiftColumn;
  table_.add(channel, layout_.foot(foot, shift), -factor * load.whole.z());
  table_.add(channel, layout_.foot(foot, shift + 1), -factor * load.whole(axis == 0 ? 1 : 0));
}

void FootRows::add(size_t clip, size_t k, BodyMotion* motion) {
  at_ = {};
  if (pairs_.empty() && std::all_of(tilt_.begin(), tilt_.end(), [](int c) { return c < 0; })) return;
  std::vector<Load> loads;
  for (size_t f = 0; f < log_.feet.size(); ++f) loads.push_back(find_load(clip, f, k, motion));
  const Eigen::VectorXd y = calc_values(clip, k, Vector3d::Zero(), motion);
  const Matrix3d R_BW = motion->find_attitude(k).transpose();
  const Vector3d turned[2] = {R_BW * Vector3d(0, -1, 0), R_BW * Vector3d(1, 0, 0)};  // of the normal, by roll and pitch
  std::vector<int> open(static_cast<size_t>(y.size()), -1);
  for (size_t f = 0; f < log_.feet.size(); ++f) {
    const Transform X = get_pose(motion->data(), log_.feet[f].link);
    for (int a = 0; a < 2; ++a) {
      const int channel = tilt_[2 * f + static_cast<size_t>(a)];
      if (channel < 0 || !loads[f].flat || (ground_ >= 0 && !loads[static_cast<size_t>(ground_)].flat)) continue;
      open[2 * f + static_cast<size_t>(a)] = channel;
      table_.begin_row(channel, y(static_cast<long>(2 * f) + a), y(static_cast<long>(2 * f) + a));
      add_sole(channel, f, a, -1, loads[f], motion);
      for (int b = 0; ground_ >= 0 && b < 2; ++b) {
        const auto g = static_cast<size_t>(ground_);
        const double along = X.R.col(a).dot(get_pose(motion->data(), log_.feet[g].link).R.col(b));
        add_sole(channel, g, b, along, loads[g], motion);
      }
      for (int axis = 0; ground_ < 0 && axis < 2; ++axis) {
        const Vector3d change = X.R.transpose() * turned[axis];
        table_.add(channel, layout_.slope(axis), a == 0 ? -change.y() : change.x());
      }
    }
  }
  for (size_t i = 0; i < pairs_.size(); ++i) {
    const Pair& p = pairs_[i];
    if (!loads[p.a].flat || !loads[p.b].flat) continue;
    open[tilt_.size() + i] = p.channel;
    table_.begin_row(p.channel, y(static_cast<long>(tilt_.size() + i)), y(static_cast<long>(tilt_.size() + i)));
    if (loads[p.a].known) table_.add(p.channel, layout_.foot(static_cast<int>(p.a), kSinkColumn), loads[p.a].force);
    if (loads[p.b].known) table_.add(p.channel, layout_.foot(static_cast<int>(p.b), kSinkColumn), -loads[p.b].force);
    table_.add(p.channel, layout_.foot(static_cast<int>(p.a), kSinkDampColumn), -loads[p.a].rate);
    table_.add(p.channel, layout_.foot(static_cast<int>(p.b), kSinkDampColumn), loads[p.b].rate);
    const Vector3d apart = get_pose(motion->data(), log_.feet[p.b].link) * log_.feet[p.b].p_LC -
                           get_pose(motion->data(), log_.feet[p.a].link) * log_.feet[p.a].p_LC;
    for (int axis = 0; ground_ < 0 && axis < 2; ++axis)
      table_.add(p.channel, layout_.slope(axis), -turned[axis].dot(apart));
  }
  if (attitude_ >= 0) add_attitude(clip, k, y, open, motion);
  add_plumb(clip, k, y, open, motion);
  at_ = {clip, k, y, open};
}

void FootRows::add_turn(const JointTurn& turn, BodyMotion* motion) {
  if (std::all_of(at_.open.begin(), at_.open.end(), [](int c) { return c < 0; })) return;
  const Eigen::VectorXd slope = (calc_values(at_.clip, at_.k, Vector3d::Zero(), motion) - at_.y) / kSlopeStep;
  for (size_t r = 0; r < at_.open.size(); ++r) {
    for (const auto& [column, factor] : turn.columns) {
      if (at_.open[r] >= 0) table_.add(at_.open[r], column, factor * slope(static_cast<long>(r)));
    }
  }
}

}  // namespace hrp::diagnosis::floating
