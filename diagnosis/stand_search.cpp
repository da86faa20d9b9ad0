// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/stand_search.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis {
namespace {

using Value = StandCandidate::Value;

// Columns are kept as one vector over recordings, samples and rows.
class StandSearch {
 public:
  StandSearch(const Problem& problem, const Progress& progress) : problem_(problem), e_(*problem.experiment), progress_(progress) {}

  StandOutcome run() {
    const size_t n = e_.recordings.size();
    std::vector<std::unique_ptr<StandRecording>> made(n);
    parallel_for(problem_.jobs, static_cast<int>(n), [&](int r) { made[static_cast<size_t>(r)] = std::make_unique<StandRecording>(problem_, r); });
    recordings_ = std::move(made);
    nominal_ = evaluate({});
    name_rows();
    residual_ = collect(nominal_);
    find_sigma();
    whiten(&residual_);
    progress_("standing on paper: " + std::to_string(rows_) + " equations a sample, " + std::to_string(residual_.size() / rows_) + " samples");
    out_.before = calc_rms(residual_);
    summarise(residual_, &out_.train_before, &out_.validate_before, &worst_before_);
    out_.train_after = out_.train_before, out_.validate_after = out_.validate_before, out_.worst_after = worst_before_;
    out_.after = out_.before;
    Eigen::VectorXd left = residual_;
    if (worst_before_ > 1.8 || out_.validate_before > 1.25) {
      out_.mismatch = true;
      make_candidates();
      left = select();
    }
    store(left);
    return std::move(out_);
  }

 private:
  std::vector<StandSeries> evaluate(const StandChange& change) const {
    std::vector<StandSeries> all(recordings_.size());
    parallel_for(problem_.jobs, static_cast<int>(recordings_.size()), [&](int r) { all[static_cast<size_t>(r)] = recordings_[static_cast<size_t>(r)]->evaluate(change); });
    return all;
  }

  size_t feet() const { return nominal_[0].foot_links.size(); }
  size_t joints() const { return static_cast<size_t>(e_.num_joints()); }
  size_t row_joint(size_t j) const { return 6 + j; }
  size_t row_servo(size_t j) const { return 6 + joints() + j; }
  size_t row_gyro(size_t i) const { return 6 + 2 * joints() + i; }
  size_t row_roll(size_t f) const { return 9 + 2 * joints() + 2 * f; }
  size_t row_height(size_t f) const { return 9 + 2 * joints() + 2 * feet() + f; }   // f > 0: against foot 0; or against base z

  void name_rows() {
    rows_ = 9 + 2 * joints() + 3 * feet();
    const std::string imu = "/imu/" + e_.scenario.sensors.imus.front().name;
    out_.row_names = {"moment balance x", "moment balance y", "moment balance z", "force balance x", "force balance y", "force balance z"};
    for (int i = 0; i < 6; ++i) out_.row_signals.push_back("/wrench/" + nominal_[0].foot_sensors[0] + (i < 3 ? "/torque" : "/force"));
    for (size_t j = 0; j < 2 * joints(); ++j) {
      out_.row_names.push_back(std::string(j < joints() ? "effort balance " : "servo balance ") + e_.robot.tree.joint(static_cast<int>(j % joints())).name);
      out_.row_signals.push_back(e_.signal_name(static_cast<int>(j % joints()), Quantity::kEffort));
    }
    for (int i = 0; i < 3; ++i) out_.row_names.push_back("rate of attitude"), out_.row_signals.push_back(imu + "/angular_velocity");
    for (size_t f = 0; f < 2 * feet(); ++f) out_.row_names.push_back("tilt of " + nominal_[0].foot_names[f / 2]), out_.row_signals.push_back(imu + "/orientation");
    for (size_t f = 0; f < feet(); ++f) out_.row_names.push_back("height of " + nominal_[0].foot_names[f]), out_.row_signals.push_back(nominal_[0].has_base_z ? "/base/pose/position" : imu + "/orientation");
  }

  // Rows of all samples in one vector. A foot's rows count while it carries weight.
  Eigen::VectorXd collect(const std::vector<StandSeries>& all) const {
    size_t samples = 0;
    for (const StandSeries& s : all) samples += s.samples.size();
    Eigen::VectorXd y = Eigen::VectorXd::Zero(static_cast<long>(samples * rows_));
    long at = 0;
    for (const StandSeries& series : all) {
      for (const StandSample& s : series.samples) {
        double weight = 0.0;
        for (const FootSample& foot : s.feet) weight += std::max(0.0, foot.force.z());
        y.segment(at, 6 + static_cast<long>(joints())) = s.rows;
        for (size_t j = 0; j < joints(); ++j) y[at + static_cast<long>(row_servo(j))] = s.effort[static_cast<long>(j)] - s.servo[static_cast<long>(j)];
        for (size_t i = 0; i < 3; ++i) y[at + static_cast<long>(row_gyro(i))] = s.gyro_error[static_cast<long>(i)];
        for (size_t f = 0; f < s.feet.size(); ++f) {
          if (s.feet[f].force.z() < 0.15 * weight) continue;
          y[at + static_cast<long>(row_roll(f))] = s.feet[f].roll;
          y[at + static_cast<long>(row_roll(f)) + 1] = s.feet[f].pitch;
          if (series.has_base_z) y[at + static_cast<long>(row_height(f))] = s.base_z + s.feet[f].height - e_.scenario.ground.height;
          else if (f > 0 && s.feet[0].force.z() > 0.15 * weight) y[at + static_cast<long>(row_height(f))] = s.feet[f].height - s.feet[0].height;
        }
        at += static_cast<long>(rows_);
      }
    }
    return y;
  }

  // What a row does within half a second in the quieter half of the data, straight lines taken out.
  void find_sigma() {
    out_.sigma.assign(rows_, 1.0);
    const size_t window = 20;
    for (size_t c = 0; c < rows_; ++c) {
      std::vector<double> spreads;
      size_t first = 0;
      for (const StandSeries& series : nominal_) {
        for (size_t k = 0; k + window <= series.samples.size(); k += window) {
          double n = 0, st = 0, stt = 0, sy = 0, sty = 0, syy = 0;
          for (size_t i = 0; i < window; ++i) {
            const double t = static_cast<double>(i), y = residual_[static_cast<long>((first + k + i) * rows_ + c)];
            n += 1, st += t, stt += t * t, sy += y, sty += t * y, syy += y * y;
          }
          const double b = (n * sty - st * sy) / (n * stt - st * st), a = (sy - b * st) / n;
          spreads.push_back(std::sqrt(std::max(0.0, (syy - a * sy - b * sty) / (n - 2.0))));
        }
        first += series.samples.size();
      }
      std::sort(spreads.begin(), spreads.end());
      const double s = spreads[spreads.size() / 3];
      // Nothing is known better than the encoders and the arithmetic of smoothing allow.
      const double least = c < 6 + joints() ? 2e-3 : c < row_gyro(0) ? 2e-3 : c < row_roll(0) ? 1e-4 : c < row_height(0) ? 2e-5 : 2e-5;
      out_.sigma[c] = 1.15 * std::max(s, least);
    }
  }

  void whiten(Eigen::VectorXd* y) const {
    for (long i = 0; i < y->size(); ++i) (*y)[i] /= out_.sigma[static_cast<size_t>(i) % rows_];
  }

  std::vector<std::vector<double>> calc_rms(const Eigen::VectorXd& y) const {
    std::vector<std::vector<double>> rms;
    long at = 0;
    for (const StandSeries& series : nominal_) {
      std::vector<double> sum(rows_, 0.0);
      for (size_t k = 0; k < series.samples.size(); ++k, at += static_cast<long>(rows_)) {
        for (size_t c = 0; c < rows_; ++c) sum[c] += y[at + static_cast<long>(c)] * y[at + static_cast<long>(c)];
      }
      for (double& s : sum) s = std::sqrt(s / std::max<double>(1.0, static_cast<double>(series.samples.size())));
      rms.push_back(sum);
    }
    return rms;
  }

  bool is_train(size_t r) const { return e_.recordings[r].spec.train; }

  void summarise(const Eigen::VectorXd& y, double* train, double* validate, double* worst) const {
    const auto rms = calc_rms(y);
    double sum[2] = {0, 0}, n[2] = {0, 0};
    std::vector<double> row(rows_, 0.0);
    double count = 0.0;
    for (size_t r = 0; r < rms.size(); ++r) {
      const double samples = static_cast<double>(nominal_[r].samples.size());
      for (size_t c = 0; c < rows_; ++c) {
        sum[is_train(r)] += rms[r][c] * rms[r][c] * samples, n[is_train(r)] += samples;
        row[c] += rms[r][c] * rms[r][c] * samples;
      }
      count += samples;
    }
    *train = std::sqrt(sum[1] / std::max(1.0, n[1]));
    *validate = n[0] > 0.0 ? std::sqrt(sum[0] / n[0]) : *train;
    *worst = 0.0;
    for (double r : row) *worst = std::max(*worst, std::sqrt(r / std::max(1.0, count)));
  }

  int add_column(Eigen::VectorXd column) {
    whiten(&column);
    columns_.push_back(std::move(column));
    return static_cast<int>(columns_.size()) - 1;
  }

  // Change of all rows when something changes, per unit: the residual shrinks by -x times this.
  int add_change(const StandChange& change, double per) { return add_column((collect(nominal_) - collect(evaluate(change))) / per); }

  // A column from a function that adds to the rows of one sample.
  int add_rows(const std::function<void(const StandSample&, double* rows)>& f) {
    Eigen::VectorXd column = Eigen::VectorXd::Zero(residual_.size());
    long at = 0;
    for (const StandSeries& series : nominal_) {
      for (const StandSample& s : series.samples) {
        f(s, column.data() + at);
        at += static_cast<long>(rows_);
      }
    }
    return add_column(std::move(column));
  }

  using Explain = std::function<std::vector<Value>(const Eigen::VectorXd&, const Eigen::MatrixXd&)>;

  void add(const std::string& effect, const std::string& kind, const std::string& where, std::vector<int> columns, Explain explain, const std::string& phrase) {
    StandCandidate c;
    c.effect = effect, c.where_kind = kind, c.where = where, c.columns = std::move(columns), c.explain = std::move(explain), c.phrase = phrase;
    candidates_.push_back(std::move(c));
  }

  static Explain one(const std::string& name, const std::string& unit, double origin = 0.0, double factor = 1.0) {
    return [=](const Eigen::VectorXd& x, const Eigen::MatrixXd& C) -> std::vector<Value> {
      return {{name, unit, {origin + factor * x[0]}, {std::abs(factor) * std::sqrt(C(0, 0))}}};
    };
  }

  static Explain three(const std::string& name, const std::string& unit) {
    return [=](const Eigen::VectorXd& x, const Eigen::MatrixXd& C) -> std::vector<Value> {
      Value v{name, unit, {}, {}};
      for (int i = 0; i < 3; ++i) v.value.push_back(x[i]), v.std.push_back(std::sqrt(C(i, i)));
      return {v};
    };
  }

  void make_candidates() {
    for (size_t j = 0; j < joints(); ++j) add_joint(j);
    for (size_t link = 0; link < e_.robot.tree.links.size(); ++link) add_link(static_cast<int>(link));
    for (size_t f = 0; f < feet(); ++f) add_foot(f), add_wrench(f);
    add_imu();
    const int roll = add_rows([this](const StandSample& s, double* rows) { for (size_t f = 0; f < feet(); ++f) rows[row_roll(f)] = loaded(s, f); });
    const int pitch = add_rows([this](const StandSample& s, double* rows) { for (size_t f = 0; f < feet(); ++f) rows[row_roll(f) + 1] = loaded(s, f); });
    add("ground_slope", "ground", "ground", {roll, pitch}, [](const Eigen::VectorXd& x, const Eigen::MatrixXd& C) -> std::vector<Value> {
      return {{"roll", "rad", {x[0]}, {std::sqrt(C(0, 0))}}, {"pitch", "rad", {x[1]}, {std::sqrt(C(1, 1))}}};
    }, "the ground is inclined");
    progress_(std::to_string(candidates_.size()) + " candidates");
  }

  double loaded(const StandSample& s, size_t f) const {
    double weight = 0.0;
    for (const FootSample& foot : s.feet) weight += std::max(0.0, foot.force.z());
    return s.feet[f].force.z() < 0.15 * weight ? 0.0 : 1.0;
  }

  void add_joint(size_t j) {
    const JointSpec& spec = e_.robot.tree.joint(static_cast<int>(j));
    if (!spec.actuated) return;
    const std::string& name = spec.name;
    const long i = static_cast<long>(j);
    const auto row = [this, j](const std::function<double(const StandSample&)>& f, bool servo = false) {
      const size_t at = servo ? row_servo(j) : row_joint(j);
      return add_rows([&, at](const StandSample& s, double* rows) { rows[at] = f(s); });
    };
    const auto sign = [i](const StandSample& s) { return std::tanh(s.qd[i] / 0.005); };
    const int viscous = row([i](const StandSample& s) { return s.qd[i]; });
    const int dry = row(sign);
    add("viscous_friction", "joint", name, {viscous}, one("coefficient", "N m s/rad"), "viscous friction brakes in proportion to speed");
    add("coulomb_friction", "joint", name, {dry}, one("level", "N m"), "dry friction of constant level");
    add("load_dependent_friction", "joint", name, {row([&](const StandSample& s) { return sign(s) * std::abs(s.effort[i]); })}, one("ratio", "1"), "dry friction that grows with the load");
    add("rotor_inertia", "joint", name, {row([i](const StandSample& s) { return s.qdd[i]; })}, one("inertia", "kg m^2"), "the rotor's reflected inertia is missing");
    add("torque_constant_error", "joint", name, {row([i](const StandSample& s) { return s.effort[i]; })}, one("scale", "1", 1.0, -1.0), "the true torque is a fixed multiple of the logged effort");
    const int q = row([i](const StandSample& s) { return s.q[i]; }), constant = row([](const StandSample&) { return 1.0; });
    add("parallel_spring", "joint", name, {q, constant}, [](const Eigen::VectorXd& x, const Eigen::MatrixXd& C) -> std::vector<Value> {
      const double rest = x[0] != 0.0 ? -x[1] / x[0] : 0.0;
      return {{"stiffness", "N m/rad", {x[0]}, {std::sqrt(C(0, 0))}}, {"rest", "rad", {rest}, {std::sqrt(C(1, 1)) / std::max(1e-9, std::abs(x[0]))}}};
    }, "a spring acts across the joint");
    StandChange change;
    change.effects = {{EffectId::kJointOffset, static_cast<int>(j), {0.004}}};
    add("joint_offset", "joint", name, {add_change(change, 0.004)}, one("offset", "rad"), "the encoder's zero is off");
    const std::string sensor = e_.signal_name(static_cast<int>(j), Quantity::kEffort);
    const auto both = [this, j](const std::function<double(const StandSample&)>& f) {
      return add_rows([&, j](const StandSample& s, double* rows) { rows[row_joint(j)] = f(s), rows[row_servo(j)] = f(s); });
    };
    add("sensor_bias", "sensor", sensor, {both([](const StandSample&) { return 1.0; })}, one("value", "N m"), "the reading is shifted by a constant");
    add("sensor_scale", "sensor", sensor, {both([i](const StandSample& s) { return s.servo[i]; })}, one("scale", "1", 1.0), "the reading is scaled");
  }

  void add_link(int link) {
    const LinkInertia& inertia = e_.robot.tree.links[static_cast<size_t>(link)].inertia;
    const std::string& name = e_.robot.tree.links[static_cast<size_t>(link)].name;
    if (!(inertia.mass > 0.0)) return;
    StandChange change;
    const double mass = inertia.mass;
    change.effects = {{EffectId::kMassError, link, {1.1}}};
    add("mass_error", "link", name, {add_change(change, 0.1)}, one("scale", "1", 1.0), "the link's mass is wrong by a factor");
    std::vector<int> shift, force;
    for (size_t i = 0; i < 3; ++i) {
      std::vector<double> p(3, 0.0);
      p[i] = 2e-3;
      change.effects = {{EffectId::kComError, link, p}};
      shift.push_back(add_change(change, 2e-3));
      p[i] = 1.0;
      change.effects = {{EffectId::kExternalForce, link, p}};
      force.push_back(add_change(change, 1.0));
    }
    add("com_error", "link", name, shift, three("offset", "m"), "the link's centre of mass is elsewhere");
    add("external_force", "link", name, force, three("force", "N"), "a constant force pulls at the link");
    change.effects = {{EffectId::kPayload, link, {0.01, 0, 0, 0, 0}}};
    const int at_origin = add_change(change, 0.01);
    add("payload", "link", name, {at_origin, shift[0], shift[1], shift[2]}, [mass](const Eigen::VectorXd& x, const Eigen::MatrixXd& C) -> std::vector<Value> {
      Value com{"com", "m", {}, {}};
      for (int i = 1; i < 4; ++i) com.value.push_back(mass * x[i] / x[0]), com.std.push_back(mass * std::sqrt(C(i, i)) / std::max(1e-6, std::abs(x[0])));
      return {{"mass", "kg", {x[0]}, {std::sqrt(C(0, 0))}}, com};
    }, "an unmodelled mass is carried");
  }

  // Tilt and height of the sole against the wrench above it: t = -(T - c Fz) / k - (c / k) t'. The bush sits near the
  // centre of the sole; its offset makes the term with Fz.
  void add_foot(size_t f) {
    const Vector3d centre = nominal_[0].sole_centres[f];
    const auto moment = [f, centre](const StandSample& s) -> Vector3d { return s.feet[f].torque - centre.cross(s.feet[f].force); };
    std::vector<int> columns;
    for (int axis = 0; axis < 2; ++axis) {
      const size_t at = row_roll(f) + static_cast<size_t>(axis);
      columns.push_back(add_rows([=](const StandSample& s, double* rows) { rows[at] = -loaded(s, f) * moment(s)[axis]; }));
      columns.push_back(add_rows([=](const StandSample& s, double* rows) { rows[at] = loaded(s, f) * s.feet[f].force.z(); }));
      columns.push_back(add_rate(f, axis));
    }
    const bool absolute = nominal_[0].has_base_z;
    if (absolute || feet() > 1) {
      const auto compress = [=](double* rows, double value, const StandSample& s) {
        if (absolute) rows[row_height(f)] = loaded(s, f) * value;
        else if (f > 0) rows[row_height(f)] = loaded(s, f) * loaded(s, 0) * value;
        else for (size_t g = 1; g < feet(); ++g) rows[row_height(g)] = -loaded(s, g) * loaded(s, 0) * value;
      };
      columns.push_back(add_rows([=](const StandSample& s, double* rows) { compress(rows, -s.feet[f].force.z(), s); }));
      columns.push_back(add_rows([=](const StandSample& s, double* rows) { compress(rows, s.feet[f].force_rate.z(), s); }));
    }
    add("foot_compliance", "foot", nominal_[0].foot_names[f], columns, [](const Eigen::VectorXd& x, const Eigen::MatrixXd& C) {
      std::vector<Value> values;
      const auto invert = [&](const char* name, const char* unit, int i, double sign) {
        const double k = sign / (std::abs(x[i]) > 1e-12 ? x[i] : 1e-12);
        values.push_back({name, unit, {k}, {std::sqrt(C(i, i)) * k * k}});
        return k;
      };
      const double k_roll = invert("k_roll", "N m/rad", 0, 1.0), k_pitch = invert("k_pitch", "N m/rad", 3, 1.0);
      values.push_back({"c_roll", "N m s/rad", {-x[2] * k_roll}, {std::sqrt(C(2, 2)) * std::abs(k_roll)}});
      values.push_back({"c_pitch", "N m s/rad", {-x[5] * k_pitch}, {std::sqrt(C(5, 5)) * std::abs(k_pitch)}});
      if (x.size() > 7) {
        const double kz = invert("kz", "N/m", 6, 1.0);
        values.push_back({"cz", "N s/m", {std::max(0.0, x[7] * kz * kz)}, {std::sqrt(C(7, 7)) * kz * kz}});
      }
      return values;
    }, "the sole gives");
  }

  // Rate of a foot's tilt.
  int add_rate(size_t f, int axis) {
    Eigen::VectorXd column = Eigen::VectorXd::Zero(residual_.size());
    long at = 0;
    for (const StandSeries& series : nominal_) {
      const auto& s = series.samples;
      for (size_t k = 0; k < s.size(); ++k, at += static_cast<long>(rows_)) {
        const size_t a = k > 0 ? k - 1 : k, b = k + 1 < s.size() ? k + 1 : k;
        const double change = axis == 0 ? s[b].feet[f].roll - s[a].feet[f].roll : s[b].feet[f].pitch - s[a].feet[f].pitch;
        column[at + static_cast<long>(row_roll(f)) + axis] = loaded(s[k], f) * change / (s[b].time - s[a].time);
      }
    }
    return add_column(std::move(column));
  }

  void add_wrench(size_t f) {
    const std::string base = "/wrench/" + nominal_[0].foot_sensors[f];
    for (int part = 0; part < 2; ++part) {   // 0: torque, 1: force
      const std::string name = base + (part == 0 ? "/torque" : "/force");
      const auto reading = [f, part](const StandSample& s) -> const Vector3d& { return part == 0 ? s.feet[f].torque : s.feet[f].force; };
      const auto act = [this, f, part](const std::function<Vector3d(const StandSample&)>& v) {
        return add_rows([&, f, part](const StandSample& s, double* rows) {
          Eigen::Map<Eigen::VectorXd>(rows, 6 + static_cast<long>(joints())) = s.feet[f].JT.middleCols(3 * part, 3) * v(s);
        });
      };
      std::vector<int> bias, turn;
      for (int i = 0; i < 3; ++i) {
        bias.push_back(act([i](const StandSample&) -> Vector3d { return Vector3d::Unit(i); }));
        turn.push_back(act([&reading, i](const StandSample& s) -> Vector3d { return -Vector3d::Unit(i).cross(reading(s)); }));
      }
      add("sensor_bias", "sensor", name, bias, three("value", part == 0 ? "N m" : "N"), "the reading is shifted by a constant");
      add("sensor_misalignment", "sensor", name, turn, three("rpy", "rad"), "the sensor is turned against its link");
      add("sensor_scale", "sensor", name, {act([&reading](const StandSample& s) -> Vector3d { return reading(s); })},
          [](const Eigen::VectorXd& x, const Eigen::MatrixXd& C) -> std::vector<Value> {
            const double scale = 1.0 / std::max(0.05, 1.0 - x[0]);   // reading = scale x truth: what is too much is (1 - 1 / scale) of the reading
            return {{"scale", "1", {scale}, {std::sqrt(C(0, 0)) * scale * scale}}};
          }, "the reading is scaled");
      add("sensor_delay", "sensor", name, {act([f, part](const StandSample& s) -> Vector3d { return part == 0 ? Vector3d(-s.feet[f].torque_rate) : Vector3d(-s.feet[f].force_rate); })},
          one("delay", "s"), "the reading comes late");
    }
  }

  void add_imu() {
    const std::string imu = "/imu/" + e_.scenario.sensors.imus.front().name;
    std::vector<int> gyro, acc, turn;
    for (int i = 0; i < 3; ++i) {
      StandChange change;
      change.gyro_bias = 0.01 * Vector3d::Unit(i);
      gyro.push_back(add_change(change, 0.01));
      change = {};
      change.accelerometer_bias = 0.05 * Vector3d::Unit(i);
      acc.push_back(add_change(change, 0.05));
      change = {};
      change.attitude_turn = -0.004 * Vector3d::Unit(i);
      turn.push_back(add_change(change, 0.004));
    }
    add("sensor_bias", "sensor", imu + "/angular_velocity", gyro, three("value", "rad/s"), "the reading is shifted by a constant");
    add("sensor_bias", "sensor", imu + "/linear_acceleration", acc, three("value", "m/s^2"), "the reading is shifted by a constant");
    add("sensor_misalignment", "sensor", imu + "/orientation", turn, three("rpy", "rad"), "the sensor is turned against its link");
  }

  struct Fit {
    double train = 0.0, validate = 0.0;   // sums of squares that are left
    Eigen::VectorXd x;
    Eigen::MatrixXd inverse;
    bool ok = false;
  };

  void make_gram() {
    const long p = static_cast<long>(columns_.size());
    Eigen::MatrixXd X(residual_.size(), p);
    for (long i = 0; i < p; ++i) X.col(i) = columns_[static_cast<size_t>(i)];
    long at = 0;
    for (int t = 0; t < 2; ++t) gram_[t].setZero(p, p), projection_[t].setZero(p), total_[t] = 0.0;
    for (size_t r = 0; r < nominal_.size(); ++r) {
      const long size = static_cast<long>(nominal_[r].samples.size() * rows_);
      const auto block = X.middleRows(at, size);
      const auto y = residual_.segment(at, size);
      const int t = is_train(r);
      gram_[t].selfadjointView<Eigen::Lower>().rankUpdate(block.transpose());
      projection_[t] += block.transpose() * y;
      total_[t] += y.squaredNorm();
      at += size;
    }
    for (int t = 0; t < 2; ++t) gram_[t] = Eigen::MatrixXd(gram_[t].selfadjointView<Eigen::Lower>());
    if (problem_.validate.empty()) gram_[0] = gram_[1], projection_[0] = projection_[1], total_[0] = total_[1];
  }

  Fit solve(const std::vector<size_t>& chosen) const {
    std::vector<long> columns;
    for (size_t c : chosen) for (int i : candidates_[c].columns) columns.push_back(i);
    const long p = static_cast<long>(columns.size());
    Eigen::MatrixXd G(p, p), H(p, p);
    Eigen::VectorXd b(p), d(p), scale(p);
    for (long i = 0; i < p; ++i) scale[i] = 1.0 / std::sqrt(std::max(1e-300, gram_[1](columns[static_cast<size_t>(i)], columns[static_cast<size_t>(i)])));
    for (long i = 0; i < p; ++i) {
      b[i] = projection_[1][columns[static_cast<size_t>(i)]], d[i] = projection_[0][columns[static_cast<size_t>(i)]];
      for (long j = 0; j < p; ++j) G(i, j) = gram_[1](columns[static_cast<size_t>(i)], columns[static_cast<size_t>(j)]), H(i, j) = gram_[0](columns[static_cast<size_t>(i)], columns[static_cast<size_t>(j)]);
    }
    Eigen::MatrixXd S = scale.asDiagonal() * G * scale.asDiagonal();
    S.diagonal().array() += 1e-9;
    Fit fit;
    const Eigen::LDLT<Eigen::MatrixXd> factor(S);
    fit.x = scale.asDiagonal() * factor.solve(scale.asDiagonal() * b);
    fit.inverse = scale.asDiagonal() * factor.solve(Eigen::MatrixXd(scale.asDiagonal()));
    fit.train = total_[1] - 2.0 * fit.x.dot(b) + fit.x.dot(G * fit.x);
    fit.validate = total_[0] - 2.0 * fit.x.dot(d) + fit.x.dot(H * fit.x);
    fit.ok = fit.x.allFinite() && makes_sense(chosen, fit);
    return fit;
  }

  // Friction that drives, springs that push away, feet stiffer than the ground: no explanation.
  bool makes_sense(const std::vector<size_t>& chosen, const Fit& fit) const {
    long at = 0;
    for (size_t c : chosen) {
      const StandCandidate& candidate = candidates_[c];
      const long p = static_cast<long>(candidate.columns.size());
      const Eigen::VectorXd x = fit.x.segment(at, p);
      at += p;
      const std::string& name = candidate.effect;
      if ((name == "viscous_friction" || name == "coulomb_friction" || name == "load_dependent_friction" || name == "rotor_inertia" ||
           name == "parallel_spring" || name == "payload" || name == "sensor_delay") && x[0] <= 0.0) return false;
      if (name == "torque_constant_error" && x[0] > 0.95) return false;
      if (name == "foot_compliance" && (x[0] <= 2e-5 || x[3] <= 2e-5)) return false;
      if (name == "payload" && x.tail(3).norm() * e_.robot.tree.links[0].inertia.mass > 1e3 * x[0]) return false;
    }
    return true;
  }

  double price(const std::vector<size_t>& chosen, const Fit& fit) const {
    double parameters = 0.0;
    for (size_t c : chosen) parameters += static_cast<double>(candidates_[c].columns.size());
    return fit.train + fit.validate + 40.0 * parameters;   // about 40: smoothed samples are correlated over several
  }

  Eigen::VectorXd select() {
    make_gram();
    const double samples = static_cast<double>(residual_.size());
    std::vector<size_t> chosen;
    double now = total_[0] + total_[1];
    for (int round = 0; round < 4; ++round) {
      size_t best = candidates_.size();
      double lowest = now;
      for (size_t c = 0; c < candidates_.size(); ++c) {
        if (std::find(chosen.begin(), chosen.end(), c) != chosen.end()) continue;
        std::vector<size_t> set = chosen;
        set.push_back(c);
        const Fit fit = solve(set);
        if (!fit.ok) continue;
        if (round == 0) out_.rivals.push_back({candidates_[c].effect, candidates_[c].where_kind, candidates_[c].where, fit.validate});
        if (price(set, fit) < lowest) lowest = price(set, fit), best = c;
      }
      // Beyond chance, and at least a twentieth of what stands above the noise.
      const double excess = std::max(0.0, now - samples);
      if (best == candidates_.size() || now - lowest < std::max(0.002 * samples, 0.05 * excess)) break;
      chosen.push_back(best);
      exchange(&chosen);
      const Fit fit = solve(chosen);
      now = price(chosen, fit);
      progress_("  + " + candidates_[best].effect + " at " + candidates_[best].where);
      if (is_enough(chosen, fit)) break;
    }
    prune(&chosen);
    return finish(chosen);
  }

  // Any one of the chosen may be replaced by what does better beside the others.
  void exchange(std::vector<size_t>* chosen) const {
    for (bool changed = true; changed;) {
      changed = false;
      for (size_t i = 0; i < chosen->size(); ++i) {
        double lowest = price(*chosen, solve(*chosen)) - 1.0;
        size_t best = (*chosen)[i];
        for (size_t c = 0; c < candidates_.size(); ++c) {
          if (std::find(chosen->begin(), chosen->end(), c) != chosen->end()) continue;
          std::vector<size_t> set = *chosen;
          set[i] = c;
          const Fit fit = solve(set);
          if (fit.ok && price(set, fit) < lowest) lowest = price(set, fit), best = c;
        }
        if (best != (*chosen)[i]) (*chosen)[i] = best, changed = true;
      }
    }
  }

  void prune(std::vector<size_t>* chosen) const {
    for (size_t i = 0; chosen->size() > 1 && i < chosen->size();) {
      std::vector<size_t> set = *chosen;
      set.erase(set.begin() + static_cast<long>(i));
      const Fit without = solve(set), with = solve(*chosen);
      if (without.ok && price(set, without) - price(*chosen, with) < 0.002 * static_cast<double>(residual_.size())) *chosen = set;
      else ++i;
    }
  }

  Eigen::VectorXd calc_left(const std::vector<size_t>& chosen, const Fit& fit) const {
    Eigen::VectorXd left = residual_;
    long at = 0;
    for (size_t c : chosen) {
      for (int i : candidates_[c].columns) left -= fit.x[at++] * columns_[static_cast<size_t>(i)];
    }
    return left;
  }

  bool is_enough(const std::vector<size_t>& chosen, const Fit& fit) const {
    double train, validate, worst;
    summarise(calc_left(chosen, fit), &train, &validate, &worst);
    return validate < 1.2 && train < 1.2 && worst < 1.6;
  }

  // Scores of the parameters summed over stretches of about half a second: what correlation does to the intervals.
  Eigen::MatrixXd calc_covariance(const std::vector<size_t>& chosen, const Fit& fit, const Eigen::VectorXd& left) const {
    std::vector<int> columns;
    for (size_t c : chosen) for (int i : candidates_[c].columns) columns.push_back(i);
    const long p = static_cast<long>(columns.size());
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(p, p);
    long at = 0;
    for (size_t r = 0; r < nominal_.size(); ++r) {
      const long size = static_cast<long>(nominal_[r].samples.size() * rows_), stretch = static_cast<long>(25 * rows_);
      for (long k = 0; is_train(r) && k < size; k += stretch) {
        const long length = std::min(stretch, size - k);
        Eigen::VectorXd s(p);
        for (long i = 0; i < p; ++i) s[i] = columns_[static_cast<size_t>(columns[static_cast<size_t>(i)])].segment(at + k, length).dot(left.segment(at + k, length));
        B += s * s.transpose();
      }
      at += size;
    }
    return fit.inverse * B * fit.inverse + fit.inverse;
  }

  Eigen::VectorXd finish(const std::vector<size_t>& chosen) {
    if (chosen.empty()) return residual_;
    const Fit fit = solve(chosen);
    const Eigen::VectorXd left = calc_left(chosen, fit);
    summarise(left, &out_.train_after, &out_.validate_after, &out_.worst_after);
    const double before = out_.validate_before * out_.validate_before - 1.0, after = out_.validate_after * out_.validate_after - 1.0;
    out_.explained = (out_.validate_after < 1.3 && out_.worst_after < 2.2) || (after < 0.004 * before && out_.validate_after < 2.0);
    out_.after = calc_rms(left);
    const Eigen::MatrixXd C = calc_covariance(chosen, fit, left);
    long at = 0;
    for (size_t c : chosen) {
      const long p = static_cast<long>(candidates_[c].columns.size());
      out_.chosen.push_back(candidates_[c]);
      out_.values.push_back(candidates_[c].explain(fit.x.segment(at, p), C.block(at, at, p, p)));
      at += p;
    }
    find_twins(chosen);
    const double count = std::max(1.0, static_cast<double>(residual_.size()) * static_cast<double>(problem_.validate.size()) / static_cast<double>(e_.recordings.size()));
    for (auto& rival : out_.rivals) rival.validate = std::sqrt(std::max(0.0, rival.validate) / count);
    std::stable_sort(out_.rivals.begin(), out_.rivals.end(), [](const auto& a, const auto& b) { return a.validate < b.validate; });
    if (out_.rivals.size() > 14) out_.rivals.resize(14);
    return left;
  }

  void find_twins(const std::vector<size_t>& chosen) {
    const double now = price(chosen, solve(chosen));
    for (size_t i = 0; i < chosen.size(); ++i) {
      for (size_t c = 0; c < candidates_.size(); ++c) {
        if (std::find(chosen.begin(), chosen.end(), c) != chosen.end()) continue;
        std::vector<size_t> set = chosen;
        set[i] = c;
        const Fit fit = solve(set);
        if (fit.ok && price(set, fit) < now + 60.0) out_.twins.push_back({candidates_[c].effect, candidates_[c].where_kind, candidates_[c].where, 0.0});
      }
    }
  }

  void store(const Eigen::VectorXd& left) {
    long at = 0;
    for (const StandSeries& series : nominal_) {
      const long samples = static_cast<long>(series.samples.size()), rows = static_cast<long>(rows_);
      Eigen::MatrixXd before(samples, rows), after(samples, rows);
      std::vector<double> times;
      for (long k = 0; k < samples; ++k, at += rows) {
        before.row(k) = residual_.segment(at, rows), after.row(k) = left.segment(at, rows);
        times.push_back(series.samples[static_cast<size_t>(k)].time);
      }
      out_.residual_before.push_back(before), out_.residual_after.push_back(after), out_.times.push_back(times);
    }
  }

  const Problem& problem_;
  const Experiment& e_;
  Progress progress_;
  std::vector<std::unique_ptr<StandRecording>> recordings_;
  std::vector<StandSeries> nominal_;
  size_t rows_ = 0;
  double worst_before_ = 0.0;
  Eigen::VectorXd residual_;
  std::vector<Eigen::VectorXd> columns_;
  std::vector<StandCandidate> candidates_;
  Eigen::MatrixXd gram_[2];
  Eigen::VectorXd projection_[2];
  double total_[2] = {0, 0};
  StandOutcome out_;
};

}  // namespace

StandOutcome search_standing(const Problem& problem, const Progress& progress) { return StandSearch(problem, progress).run(); }

}  // namespace hrp::diagnosis
