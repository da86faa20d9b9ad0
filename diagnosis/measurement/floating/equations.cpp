// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/equations.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/multibody/kinematics.h"
#include "common/multibody/regressor.h"
#include "diagnosis/measurement/floating/candidates.h"
#include "diagnosis/measurement/floating/foot_rows.h"
#include "diagnosis/measurement/floating/imu_rows.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kCell = 0.04;     // [s] of a row: two or three kernels' deviations, errors of neighbours are nearly free
constexpr double kSpacing = 0.008; // [s] between the samples of a cell: finer ones repeat what the kernel passes
constexpr double kBlock = 0.5;     // [s] errors of blocks are independent
constexpr double kTurn = 1e-5;     // [rad] of a joint, for differences
constexpr double kLittle = 0.003;  // [m] times the weight: a torque that hardly holds teeth on one side
constexpr double kScrape = 0.02;   // of the way from air to stance by which a reading may leave the air's
constexpr double kNear = 0.06;     // [s] from a foot's lifting and landing
constexpr double kSlowest = 0.004;  // share of a joint's largest speed at which dry friction has its direction

// A wrench on a link: [moment about p; force] in base axes.
struct PointWrench {
  int link = 0;
  Vector3d p, force, moment;
  bool whole = true;  // else joints are not to see it
};

class EquationMaker {
 public:
  EquationMaker(const LeggedLog& log, const Contacts& contacts)
      : log_(log), contacts_(contacts), layout_(log), table_(layout_.count()) {}

  RowTable run() {
    find_speeds();
    add_channels();
    FootRows feet(log_, contacts_, layout_, &table_);
    ImuRows imus(log_, contacts_, layout_, &table_);
    int block = 0;
    for (size_t c = 0; c < log_.clips.size(); ++c) {
      run_clip(c, &feet, &imus, &block);
    }
    table_.finish();
    return std::move(table_);
  }

 private:
  // Directions of motion as the torque that they cause is smoothed.
  void find_ways() {
    ways_.assign(slow_.size(), {});
    for (size_t j = 0; j < slow_.size(); ++j) {
      for (double v : clip_->position[j].rate) ways_[j].push_back(std::tanh(v / slow_[j]));
      ways_[j] = smooth_evenly(ways_[j], clip_->step, clip_->sigma);
    }
  }

  void run_clip(size_t c, FootRows* feet, ImuRows* imus, int* block) {
    const Clip& clip = log_.clips[c];
    clip_ = &clip, clip_index_ = c;
    find_ways();
    BodyMotion motion(log_, clip);
    motion_ = &motion;
    const auto stride = static_cast<size_t>(std::max(1L, std::lround(kSpacing / clip.step)));
    const auto per_cell = static_cast<size_t>(std::max(1L, std::lround(kCell / (clip.step * static_cast<double>(stride)))));
    double block_end = clip.time[clip.edge] + kBlock;
    for (size_t begin = clip.edge; begin + clip.edge + per_cell * stride < clip.size(); begin += per_cell * stride) {
      if (clip.time[begin] > block_end) ++*block, block_end += kBlock;
      double rough = 0;
      for (size_t i = 0; i < per_cell; ++i) rough += std::pow(clip.roughness[begin + i * stride], 2);
      table_.begin_cell({clip.time[begin + per_cell * stride / 2], static_cast<int>(clip.recording), *block,
                         contacts_.find_phase(c, begin), clip.train, static_cast<int>(per_cell), rough / static_cast<double>(per_cell)});
      for (size_t i = 0; i < per_cell; ++i) {
        const size_t k = begin + i * stride;
        if (!motion.update(k)) continue;
        imus->add(c, k, &motion);
        add_sample(k);
        feet->add(c, k, sides_, &motion);
      }
      table_.end_cell();
    }
    ++*block;
  }

  // Largest speeds of joints: what "slow" is.
  void find_speeds() {
    slow_.assign(static_cast<size_t>(log_.num_joints()), 1e-6);
    for (const Clip& clip : log_.clips) {
      for (size_t j = 0; j < slow_.size(); ++j) {
        if (clip.position[j].empty()) continue;
        for (size_t k = clip.edge; k + clip.edge < clip.size(); ++k) {
          slow_[j] = std::max(slow_[j], kSlowest * std::abs(clip.position[j].rate[k]));
        }
      }
    }
  }

  // Sensors whose wrench on the robot is known whenever their foot may be loaded.
  bool is_known(const Foot& foot) const {
    if (foot.sensor < 0) return false;
    const ForceSensor& s = log_.sensors[static_cast<size_t>(foot.sensor)];
    return s.has_wrench() || (s.has_force() && !foot.flat);
  }

  // Whether joints above the sensor see its wrench; else they are compared only while its foot is in the air.
  bool is_whole(const ForceSensor& s) const {
    return s.has_wrench() || (s.has_force() && (s.foot < 0 || !log_.feet[static_cast<size_t>(s.foot)].flat));
  }

  // Feet whose vertical force is recorded.
  void find_felt() {
    for (const Foot& foot : log_.feet) felt_.push_back(foot.sensor >= 0 && log_.sensors[static_cast<size_t>(foot.sensor)].axis[2]);
  }

  // Whether feet that nothing feels are in the air: then the others carry all of the weight.
  bool is_weight_known(size_t k) const {
    const size_t reach = clip_->edge, last = clip_->size() - 1;
    for (size_t f = 0; f < felt_.size(); ++f) {
      const std::vector<char>& loaded = contacts_.loaded[clip_index_][f];
      if (!felt_[f] && (loaded[k > reach ? k - reach : 0] || loaded[k] || loaded[std::min(k + reach, last)])) return false;
    }
    return true;
  }

  bool is_above(int link, int carried) const { return floating::is_above(log_.tree, link, carried); }

  std::vector<int> list_link_columns(int from) const {
    std::vector<int> out;
    for (int l = 0; l < layout_.links; ++l) {
      for (int p = 0; is_above(from, l) && p < kLinkColumns; ++p) out.push_back(layout_.link(l, p));
    }
    return out;
  }

  void add_sensor_columns(int from, std::vector<int>* out) const {
    for (int s = 0; s < layout_.sensors; ++s) {
      const ForceSensor& sensor = log_.sensors[static_cast<size_t>(s)];
      if (!is_above(from, sensor.link) || (from > 0 && !is_whole(sensor))) continue;
      for (int c = 0; c < kSensorColumns; ++c) out->push_back(layout_.sensor(s, c));
    }
  }

  void add_imu_columns(std::vector<int>* out) const {
    const int imu = BodyMotion::find_main_imu(log_);
    for (int c = 0; uses_accelerometer() && c < kGyroScaleColumn; ++c) out->push_back(layout_.imu(imu, c));
    for (int c = kGyroScaleColumn; uses_gyroscope() && c < kAttitudeTurnColumn; ++c) out->push_back(layout_.imu(imu, c));
  }

  void add_offset_columns(std::vector<int>* out) const {
    const std::vector<int> turns = list_turn_columns(log_, layout_);
    out->insert(out->end(), turns.begin(), turns.end());
  }

  void add_pull_columns(int from, std::vector<int>* out) const {
    for (int l : pulled_) {
      for (int c = 0; is_above(from, l) && c < kPullColumns; ++c) out->push_back(layout_.pull(l, c));
    }
    for (int f = 0; f < layout_.feet; ++f) {
      for (int c = 0; is_above(from, log_.feet[static_cast<size_t>(f)].link) && c < kHolds; ++c) out->push_back(layout_.foot(f, kHoldColumn + c));
    }
  }

  bool uses_accelerometer() const { return BodyMotion::find_force_source(log_) == MotionSource::kImu; }
  bool uses_gyroscope() const { return BodyMotion::find_rate_source(log_) == MotionSource::kImu; }

  void add_channels() {
    pulled_ = list_pulled_links(log_);
    std::vector<int> columns = list_link_columns(0);
    add_sensor_columns(0, &columns), add_imu_columns(&columns), add_offset_columns(&columns), add_pull_columns(0, &columns);
    bool all = !log_.feet.empty() && log_.tree.floating_base, vertical = all, forces = all;
    if (vertical) find_felt();
    for (const Foot& foot : log_.feet) {
      all = all && is_known(foot), forces = forces && foot.sensor >= 0 && log_.sensors[static_cast<size_t>(foot.sensor)].has_force();
    }
    vertical = vertical && std::find(felt_.begin(), felt_.end(), 1) != felt_.end();
    const MotionSource source = BodyMotion::find_force_source(log_);
    const bool moves = source != MotionSource::kNone && (source != MotionSource::kFoot || !contacts_.walks);
    const char* const names[] = {"moment x", "moment y", "moment z", "force x", "force y", "force z"};
    // Forces balance without the moments that a flat foot's sensor does not tell.
    for (int i = 0; forces && moves && i < 6; ++i) {
      if (i < 3 && !all) {
        balance_.push_back(-1);
        continue;
      }
      const std::string part = i < 3 ? "torque" : "force";
      balance_.push_back(table_.add_channel({std::string("balance, ") + names[i], "/wrench/" + log_.sensors[0].name + "/" + part,
                                             i < 3 ? "N m" : "N", "link", log_.tree.links[0].name}, columns));
    }
    // A foot that stands tells the base's motion well enough for a weight, in walking, too.
    if (vertical && (forces ? !moves && source == MotionSource::kFoot : source != MotionSource::kNone)) {
      weight_ = table_.add_channel({"weight", "/wrench/" + log_.sensors[0].name + "/force", "N", "link", log_.tree.links[0].name},
                                   columns);
    }
    joint_.assign(static_cast<size_t>(layout_.joints), -1), servo_ = joint_;
    for (int j = 0; j < layout_.joints; ++j) add_joint_channels(j, moves);
  }

  // `moves`: how the base moves is known, which what hangs on it feels.
  void add_joint_channels(int j, bool moves) {
    const auto i = static_cast<size_t>(j);
    const JointSpec& joint = log_.tree.joint(j);
    const bool turns = joint.kind == JointKind::kRevolute;
    const std::string signal = "/joint_states/" + joint.name + "/effort";
    const ChannelInfo info{"joint", signal, turns ? "N m" : "N", "joint", joint.name};
    std::vector<int> columns = list_link_columns(j + 1);
    add_sensor_columns(j + 1, &columns), add_imu_columns(&columns), add_offset_columns(&columns), add_pull_columns(j + 1, &columns);
    for (int c = 0; c < kOffsetColumn; ++c) columns.push_back(layout_.joint(j, c));
    if (!log_.has_effort[i]) columns.push_back(layout_.joint(j, kDelayColumn));
    const bool passive = !joint.actuated && log_.has_position[i];
    // A pose differentiated twice feels a step's impacts too little for torques of legs.
    const bool felt = moves && (!contacts_.walks || BodyMotion::find_force_source(log_) != MotionSource::kPose);
    if (felt && ((log_.is_driven(i) && joint.actuated) || passive)) joint_[i] = table_.add_channel(info, columns);
    if (log_.has_effort[i] && log_.has_law[i] && joint.actuated) {
      servo_[i] = table_.add_channel({"servo", signal, info.unit, "joint", joint.name},
                                     {layout_.joint(j, kDelayColumn), layout_.joint(j, kEffortScaleColumn)});
    }
  }

  // Whether a foot's sensor feels more than the air: one that scrapes along bears what nobody measured in six axes.
  bool touches(size_t foot, size_t k) const {
    const int sensor = log_.feet[foot].sensor;
    if (sensor < 0 || !contacts_.levels[static_cast<size_t>(sensor)].swings) return false;
    const ForceLevels& level = contacts_.levels[static_cast<size_t>(sensor)];
    const double force = calc_vertical_force(log_, *clip_, static_cast<size_t>(sensor), k);
    return std::abs(force - level.air) > kScrape * (level.stance - level.air);
  }

  // Whether a joint's torque can be compared now: no foot beyond it bears an unknown force.
  bool is_joint_known(int j, size_t k) const {
    for (size_t f = 0; f < log_.feet.size(); ++f) {
      if (!is_above(j + 1, log_.feet[f].link) || is_known(log_.feet[f])) continue;
      if (contacts_.loaded[clip_index_][f][k]) return false;
      // What lands or lifts pushes a little before it counts as loaded.
      const size_t reach = clip_->edge, a = k > reach ? k - reach : 0, b = std::min(k + reach, clip_->size() - 1);
      if (contacts_.loaded[clip_index_][f][a] || contacts_.loaded[clip_index_][f][b]) return false;
      if (touches(f, a) || touches(f, k) || touches(f, b)) return false;
    }
    for (const Foot& foot : log_.feet) {
      if (!is_above(j + 1, foot.link)) continue;
      for (const std::string& held : log_.experiment->recordings[clip_->recording].spec.unknown_force) {
        if (held == foot.name) return false;
      }
    }
    const auto& unknown = log_.experiment->recordings[clip_->recording].spec.unknown_force;
    return std::find(unknown.begin(), unknown.end(), log_.tree.joint(j).name) == unknown.end();
  }

  Vector3d get(const Track* xyz, size_t k) const {
    Vector3d v = Vector3d::Zero();
    for (int i = 0; i < 3; ++i) v(i) = xyz[i].empty() ? 0.0 : xyz[i].value[k];
    return v;
  }
  Vector3d get_rate(const Track* xyz, size_t k) const {
    Vector3d v = Vector3d::Zero();
    for (int i = 0; i < 3; ++i) v(i) = xyz[i].empty() ? 0.0 : xyz[i].rate[k];
    return v;
  }

  // Where a sensor's wrench acts and its axes, in base axes. A force without a moment acts where the foot touches.
  void find_sensor_frame(int s, size_t k, Matrix3d* R, Vector3d* p) const {
    const ForceSensor& sensor = log_.sensors[static_cast<size_t>(s)];
    const Transform X = get_pose(motion_->data(), sensor.link);
    *R = sensor.world ? Matrix3d(motion_->find_attitude(k).transpose()) : Matrix3d(X.R * sensor.X_LS.R);
    *p = X * sensor.X_LS.p;
    if (sensor.foot < 0 || sensor.has_wrench()) return;
    const Foot& foot = log_.feet[static_cast<size_t>(sensor.foot)];
    *p = X * foot.p_LC - foot.radius * motion_->find_up(k);
  }

  // Adds what a wrench does to each equation: `column` -1 collects it in y.
  void project(const PointWrench& w, double sign, int column) {
    const Data& data = motion_->data();
    const Vector3d about = w.moment + w.p.cross(w.force);
    for (int i = 0; i < 6 && !balance_.empty(); ++i) {
      put(balance_[static_cast<size_t>(i)], i, sign * (i < 3 ? about(i) : w.force(i - 3)), column);
    }
    if (weight_ >= 0) put(weight_, 3, sign * normal_.dot(w.force), column);
    for (int l = w.whole ? w.link : 0; l > 0; l = log_.tree.links[static_cast<size_t>(l)].parent) {
      const LinkKinematics& at = data.kinematics[static_cast<size_t>(l)];
      const Vector3d axis = small::to_eigen(at.axis);
      const bool turns = log_.tree.joint(l - 1).kind == JointKind::kRevolute;
      const Vector3d arm = w.p - small::to_eigen(at.p);
      put(joint_[static_cast<size_t>(l - 1)], 6 + l - 1, sign * (turns ? axis.dot(w.moment + arm.cross(w.force)) : axis.dot(w.force)), column);
    }
  }

  void put(int channel, int row, double value, int column) {
    if (column < 0) {
      y_(row) += value;
    } else if (channel >= 0 && open_[static_cast<size_t>(row)]) {
      table_.add(channel, column, value);
    }
  }

  // What the sensors say less what the motion takes, by row: 0 to 5 the whole body (weight: 3), 6 + j joints.
  void calc_residuals(size_t k) {
    const int n = layout_.joints, base = motion_->model().num_base();
    y_ = Eigen::VectorXd::Zero(6 + n), measured_ = y_;
    tau_.resize(motion_->model().nv());
    calc_inverse_dynamics(motion_->model(), motion_->vdot(), nullptr, &motion_->data(), &tau_);
    for (int s = 0; s < layout_.sensors; ++s) project(read_wrench(s, k), 1, -1);
    measured_ = y_;
    load_ = tau_.tail(n) - y_.tail(n);
    for (int j = 0; j < n; ++j) {
      const double effort = joint_[static_cast<size_t>(j)] >= 0 ? find_effort(static_cast<size_t>(j), k) : 0.0;
      measured_(6 + j) = effort;
      y_(6 + j) += effort - tau_(base + j);
    }
    if (base == 0) return;
    if (weight_ >= 0) {
      y_(3) += normal_.dot(calc_force_below() - tau_.segment<3>(3));
    } else {
      y_.head<6>() -= tau_.head<6>();
      y_.segment<3>(3) += calc_force_below();
    }
  }

  // [N] What the ground holds of the robot beside what sensors feel.
  Vector3d calc_force_below() const {
    Vector3d sum = Vector3d::Zero();
    for (const ForceSensor& s : log_.sensors) {
      if (s.below.mass <= 0) continue;
      const Vector3d p = get_pose(motion_->data(), s.link) * s.below.p_LLcm_L;
      sum += s.below.mass * calc_point_acceleration(motion_->data(), s.link, p).tail<3>();
    }
    return sum;
  }

  PointWrench read_wrench(int s, size_t k) const {
    PointWrench w;
    Matrix3d R;
    const ForceSensor& sensor = log_.sensors[static_cast<size_t>(s)];
    w.link = sensor.link, w.whole = is_whole(sensor);
    find_sensor_frame(s, k, &R, &w.p);
    w.force = R * get(&clip_->force[6 * static_cast<size_t>(s)], k);
    w.moment = R * get(&clip_->force[6 * static_cast<size_t>(s) + 3], k);
    return w;
  }

  double calc_law(size_t j, size_t k, double* rate) const {
    const Scenario& scenario = log_.experiment->scenario;
    const auto own = scenario.servo_joints.find(log_.tree.joint(static_cast<int>(j)).name);
    const ServoGains& g = own == scenario.servo_joints.end() ? scenario.servo_default : own->second;
    const Track &c = clip_->command[j], &cd = clip_->command_rate[j], &q = clip_->position[j];
    const double speed = cd.empty() ? c.rate[k] : cd.value[k], slope = cd.empty() ? c.second[k] : cd.rate[k];
    *rate = g.kp * speed + g.kd * slope;  // of the command's part
    return std::clamp(g.kp * (c.value[k] - q.value[k]) + g.kd * (speed - q.rate[k]), -g.effort_limit, g.effort_limit);
  }

  double find_effort(size_t j, size_t k) const {
    double rate = 0;
    if (log_.has_effort[j]) return clip_->effort[j].value[k];
    return log_.has_law[j] ? calc_law(j, k, &rate) : 0.0;
  }

  // The mean of the soles' normals, by load: along it the weight is compared where feet tell no other force.
  void find_normal(size_t k) {
    normal_.setZero();
    for (const Foot& foot : log_.feet) {
      if (!foot.flat || foot.sensor < 0) continue;
      Matrix3d R;
      Vector3d p;
      find_sensor_frame(foot.sensor, k, &R, &p);
      normal_ += std::max(0.0, calc_vertical_force(log_, *clip_, static_cast<size_t>(foot.sensor), k)) * R.col(2);
    }
    normal_ = normal_.norm() > 0 ? Vector3d(normal_.normalized()) : motion_->find_up(k);
  }

  void add_sample(size_t k) {
    find_normal(k);
    calc_residuals(k);
    const Eigen::VectorXd y = y_;
    find_sides(k);
    open_.assign(static_cast<size_t>(y.size()), 0);
    for (int i = 0; i < 6 && !balance_.empty(); ++i) {
      if (balance_[static_cast<size_t>(i)] >= 0) open(balance_[static_cast<size_t>(i)], i);
    }
    if (weight_ >= 0 && is_weight_known(k)) open(weight_, 3);
    for (int j = 0; j < layout_.joints; ++j) {
      if (joint_[static_cast<size_t>(j)] >= 0 && is_joint_known(j, k)) open(joint_[static_cast<size_t>(j)], 6 + j);
    }
    add_links();
    add_pulls(k);
    add_drives(k);
    for (int s = 0; s < layout_.sensors; ++s) add_sensor(s, k);
    if (uses_accelerometer()) add_accelerometer(k);
    add_servo(k);
    add_offsets(k, y);
    if (uses_gyroscope()) add_gyroscope(k, y);
  }

  // How far the encoder's side of each transmission is ahead of the link's, by what the link takes.
  void find_sides(size_t k) {
    const double little = kLittle * log_.mass * log_.experiment->scenario.gravity_W.norm();
    sides_.assign(static_cast<size_t>(layout_.joints), {});
    for (int j = 0; j < layout_.joints; ++j) {
      JointSides& s = sides_[static_cast<size_t>(j)];
      s.play = 0.5 * std::tanh(load_(j) / little), s.give = load_(j);
      if (!may_bend(log_, j)) continue;
      const LinkSpec& link = log_.tree.links[static_cast<size_t>(j) + 1];
      const Matrix3d R = get_pose(motion_->data(), link.parent).R * link.joint.X_PF.R;
      const Vector3d moment = calc_moment(j + 1, k);
      for (int a = 0; a < 2; ++a) s.bend[a] = moment.dot(R * get_cross_axis(link.joint, 1 + a));
    }
  }

  // [N m] about a link's origin, base axes: what its parent passes on to it. After inverse dynamics.
  Vector3d calc_moment(int link, size_t k) const {
    Vector3d moment = get_joint_wrench(motion_->data(), link).head<3>();
    const Vector3d p = get_pose(motion_->data(), link).p;
    for (int s = 0; s < layout_.sensors; ++s) {
      if (!is_above(link, log_.sensors[static_cast<size_t>(s)].link)) continue;
      const PointWrench w = read_wrench(s, k);
      moment -= w.moment + (w.p - p).cross(w.force);
    }
    return moment;
  }

  // Forces from outside, columns of 1 N. On links: constant in the world, and by the place of the body, with a symmetric
  // stiffness across the ground as a tether has. On feet: by time from lifting and landing.
  void add_pulls(size_t k) {
    const Matrix3d R_BW = motion_->find_attitude(k).transpose();
    const Vector3d place = motion_->find_place(k);
    const auto pull = [&](int link, const Vector3d& p, int axis, double size, int column) {
      if (size != 0) project({link, p, size * R_BW.col(axis), Vector3d::Zero()}, -1, column);
    };
    for (int l : pulled_) {
      const Vector3d p = get_pose(motion_->data(), l) * log_.tree.links[static_cast<size_t>(l)].inertia.p_LLcm_L;
      for (int a = 0; a < 3; ++a) pull(l, p, a, 1, layout_.pull(l, kPullColumn + a));
      const std::pair<int, int> by[] = {  // axes of the force and of the place
          {0, 0}, {0, 1}, {1, 1}, {2, 0}, {2, 1}};
      for (int i = 0; i < 5; ++i) {
        const auto [axis, along] = by[i];
        pull(l, p, axis, place(along), layout_.pull(l, kPullByPlaceColumn + i));
        if (i == 1) pull(l, p, along, place(axis), layout_.pull(l, kPullByPlaceColumn + i));
      }
    }
    for (int f = 0; f < layout_.feet; ++f) {
      const Foot& foot = log_.feet[static_cast<size_t>(f)];
      const Vector3d p = get_pose(motion_->data(), foot.link) * foot.p_LC;
      for (int c = 0; c < kHolds; ++c) pull(foot.link, p, 2, find_hold(static_cast<size_t>(f), c, k), layout_.foot(f, kHoldColumn + c));
    }
  }

  // Whether a foot is loaded (0), about to lift, just lifted, about to land, just landed (4), smoothed as all signals are.
  double find_hold(size_t f, int which, size_t k) const {
    const std::vector<char>& loaded = contacts_.loaded[clip_index_][f];
    const auto reach = static_cast<long>(clip_->edge), n = static_cast<long>(loaded.size()), at = static_cast<long>(k);
    const auto near = static_cast<long>(std::lround(kNear / clip_->step));
    const auto is = [&](long i) { return loaded[static_cast<size_t>(std::clamp(i, 0L, n - 1))] != 0; };
    double sum = 0, total = 0;
    for (long i = std::max(0L, at - reach); i <= std::min(n - 1, at + reach); ++i) {
      const double w = std::exp(-0.5 * std::pow(static_cast<double>(i - at) * clip_->step / clip_->sigma, 2));
      const bool now = is(i), changed = now != is(i - near), will = now != is(i + near);
      const bool of[] = {now, now && will, !now && changed, !now && will, now && changed};
      sum += of[which] ? w : 0, total += w;
    }
    return sum / total;
  }

  void open(int channel, int row) {
    open_[static_cast<size_t>(row)] = 1;
    table_.begin_row(channel, y_(row), measured_(row));
  }

  void add_links() {
    if (!regressor_) regressor_ = std::make_unique<Regressor>(motion_->model());
    calc_regressor(motion_->model(), motion_->vdot(), &motion_->data(), regressor_.get());
    const Regressor& Y = *regressor_;
    for (int l = 0; l < layout_.links; ++l) {
      for (int p = 0; p < kLinkColumns; ++p) {
        const long at = kInertialParameters * l + p;
        for (int i = 0; i < 6 && !balance_.empty(); ++i) put(balance_[static_cast<size_t>(i)], i, Y.Y_BI(i, at), layout_.link(l, p));
        if (weight_ >= 0) put(weight_, 3, normal_.dot(Y.Y_BI.block<3, 1>(3, at)), layout_.link(l, p));
        for (int j = 0; j < l; ++j) {
          if (Y.Y_JI(j, at) != 0) put(joint_[static_cast<size_t>(j)], 6 + j, Y.Y_JI(j, at), layout_.link(l, p));
        }
      }
    }
  }

  void add_drives(size_t k) {
    for (int j = 0; j < layout_.joints; ++j) {
      const auto i = static_cast<size_t>(j);
      if (joint_[i] < 0 || !open_[static_cast<size_t>(6 + j)]) continue;
      const Track& q = clip_->position[i];
      const double v = q.empty() ? 0 : q.rate[k], a = q.empty() ? 0 : q.second[k], way = q.empty() ? 0 : ways_[i][k];
      const double effort = measured_(6 + j);
      double rate = 0;
      if (log_.has_effort[i]) {
        rate = clip_->effort[i].rate[k];
      } else if (log_.has_law[i]) {
        calc_law(i, k, &rate);
        table_.add(joint_[i], layout_.joint(j, kDelayColumn), rate);
      }
      const double values[] = {v, way, way * std::abs(effort), a, -effort,
                               q.empty() ? 0 : q.value[k], 1.0, rate};
      for (int c = 0; c < kOffsetColumn; ++c) table_.add(joint_[i], layout_.joint(j, c), values[c]);
    }
  }

  // reading = R(turn)^T (scale true + bias), late by a delay.
  void add_sensor(int s, size_t k) {
    const auto i = static_cast<size_t>(s);
    Matrix3d R;
    PointWrench w = read_wrench(s, k);
    Vector3d p;
    find_sensor_frame(s, k, &R, &p);
    const Vector3d none = Vector3d::Zero(), force = w.force, moment = w.moment;
    const auto add = [&](const Vector3d& f, const Vector3d& m, int column) {
      project({w.link, w.p, f, m, w.whole}, 1, layout_.sensor(s, column));
    };
    const bool whole = log_.sensors[i].has_wrench();
    add(force, none, kForceScaleColumn);
    if (whole) add(none, moment, kTorqueScaleColumn);
    for (int a = 0; a < 3; ++a) {
      if (log_.sensors[i].axis[a]) add(R.col(a), none, kForceBiasColumn + a);
      if (whole) add(none, R.col(a), kTorqueBiasColumn + a);
      if (log_.sensors[i].has_force()) add(-R.col(a).cross(force), whole ? Vector3d(-R.col(a).cross(moment)) : none, kWrenchTurnColumn + a);
    }
    add(-(R * get_rate(&clip_->force[6 * i], k)), whole ? Vector3d(-(R * get_rate(&clip_->force[6 * i + 3], k))) : none,
        kWrenchDelayColumn);
  }

  // Specific force moves every equation as a translation of the base does.
  void add_accelerometer(size_t k) {
    const int imu = BodyMotion::find_main_imu(log_);
    const auto i = static_cast<size_t>(imu);
    const Matrix3d R = get_pose(motion_->data(), log_.imus[i].link).R * log_.imus[i].R_LI;
    const Eigen::VectorXd nominal = tau_;
    Eigen::MatrixXd slope(tau_.size(), 3);
    for (int a = 0; a < 3; ++a) {
      Eigen::VectorXd moved = motion_->vdot();
      moved.segment<3>(3) += R.col(a);
      calc_inverse_dynamics(motion_->model(), moved, nullptr, &motion_->data(), &tau_);
      slope.col(a) = nominal - tau_;  // of the residual, by specific force in the IMU's axes
    }
    tau_ = nominal;
    const Vector3d f = get(clip_->imus[i].accelerometer, k), rate = get_rate(clip_->imus[i].accelerometer, k);
    const auto add = [&](const Vector3d& change, int column) {
      const Eigen::VectorXd d = slope * change;
      for (int r = 0; r < 6 && !balance_.empty(); ++r) put(balance_[static_cast<size_t>(r)], r, d(r), layout_.imu(imu, column));
      if (weight_ >= 0) put(weight_, 3, normal_.dot(d.segment<3>(3)), layout_.imu(imu, column));
      for (int j = 0; j < layout_.joints; ++j) put(joint_[static_cast<size_t>(j)], 6 + j, d(6 + j), layout_.imu(imu, column));
    };
    add(f, kAccelerometerScaleColumn);
    for (int a = 0; a < 3; ++a) {
      add(Vector3d::Unit(a), kAccelerometerBiasColumn + a);
      add(-Vector3d::Unit(a).cross(f), kAccelerometerTurnColumn + a);
    }
    add(-rate, kAccelerometerDelayColumn);
  }

  void add_servo(size_t k) {
    for (int j = 0; j < layout_.joints; ++j) {
      const auto i = static_cast<size_t>(j);
      if (servo_[i] < 0) continue;
      double rate = 0;
      const double logged = (clip_->logged.empty() ? clip_->effort : clip_->logged)[i].value[k], law = calc_law(i, k, &rate);
      table_.begin_row(servo_[i], logged - law, logged);
      table_.add(servo_[i], layout_.joint(j, kDelayColumn), -rate);
      table_.add(servo_[i], layout_.joint(j, kEffortScaleColumn), law);
    }
  }

  // y(q) with q = reading - offset: y = offset dy/dq.
  void add_offsets(size_t k, const Eigen::VectorXd& y) {
    for (const JointTurn& turn : list_turns(log_, layout_, sides_)) {
      motion_->turn_joint(turn.joint, turn.axis, kTurn), motion_->update(k);
      calc_residuals(k);
      const Eigen::VectorXd slope = (y_ - y) / kTurn;
      for (const auto& [column, factor] : turn.columns) put_all(factor * slope, column);
      motion_->turn_joint(turn.joint, turn.axis, 0);
    }
    motion_->update(k);
  }

  // Of all equations of a sample: how their residuals change with a column.
  void put_all(const Eigen::VectorXd& slope, int column) {
    for (int r = 0; r < 6 && !balance_.empty(); ++r) put(balance_[static_cast<size_t>(r)], r, slope(r), column);
    if (weight_ >= 0) put(weight_, 3, slope(3), column);
    for (int j = 0; j < layout_.joints; ++j) put(joint_[static_cast<size_t>(j)], 6 + j, slope(6 + j), column);
  }

  // The body turns as the gyroscope says: its rate is in centripetal forces, and the slope of its rate in moments.
  void add_gyroscope(size_t k, const Eigen::VectorXd& y) {
    const int imu = BodyMotion::find_main_imu(log_);
    const Track* gyro = clip_->imus[static_cast<size_t>(imu)].gyro;
    Eigen::MatrixXd slope(y.size(), 6);  // by a more in the rate, by a more in its slope
    for (int i = 0; i < 6; ++i) {
      const Vector3d more = kTurn * Vector3d::Unit(i % 3), none = Vector3d::Zero();
      motion_->add_gyro(i < 3 ? more : none, i < 3 ? none : more), motion_->update(k);
      calc_residuals(k);
      slope.col(i) = (y_ - y) / kTurn;
    }
    motion_->add_gyro(Vector3d::Zero(), Vector3d::Zero()), motion_->update(k);
    const auto add = [&](const Vector3d& change, const Vector3d& of_slope, int column) {
      put_all(slope.leftCols<3>() * change + slope.rightCols<3>() * of_slope, layout_.imu(imu, column));
    };
    const Vector3d w = get(gyro, k), rate = get_rate(gyro, k);
    add(w, rate, kGyroScaleColumn);
    for (int a = 0; a < 3; ++a) {
      add(Vector3d::Unit(a), Vector3d::Zero(), kGyroBiasColumn + a);
      add(-Vector3d::Unit(a).cross(w), -Vector3d::Unit(a).cross(rate), kGyroTurnColumn + a);
    }
    add(-rate, -Vector3d(gyro[0].second[k], gyro[1].second[k], gyro[2].second[k]), kGyroDelayColumn);
  }

  const LeggedLog& log_;
  const Contacts& contacts_;
  ColumnLayout layout_;
  RowTable table_;
  std::vector<double> slow_;  // [rad/s] by joint
  std::vector<std::vector<double>> ways_;  // by joint, by sample of the clip: -1 to 1
  std::vector<int> balance_, joint_, servo_;
  int weight_ = -1;
  std::vector<char> felt_;  // by foot
  std::vector<int> pulled_;  // links that something from outside may pull at
  const Clip* clip_ = nullptr;
  size_t clip_index_ = 0;
  BodyMotion* motion_ = nullptr;
  Eigen::VectorXd y_, measured_, tau_, load_;  // load: what each link takes of its joint [N m]
  std::vector<JointSides> sides_;
  Vector3d normal_{0, 0, 1};
  std::vector<char> open_;
  std::unique_ptr<Regressor> regressor_;
};

}  // namespace

RowTable make_equations(const LeggedLog& log, const Contacts& contacts) { return EquationMaker(log, contacts).run(); }

}  // namespace hrp::diagnosis::floating
