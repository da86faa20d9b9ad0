// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/signature.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/model/memory.h"
#include "diagnosis/search/missing.h"

namespace hrp::diagnosis {
namespace {

class Builder {
 public:
  Builder(const Problem& problem, const Hypothesis& base, const Paths* paths)
      : e_(*problem.experiment),
        plant_(make_plant(e_, base)),
        n_(e_.num_joints()),
        missing_(calc_missing_rows(problem, plant_, problem.train, paths)),
        grids_(missing_.grids),
        rows_(missing_.rows),
        sigma_(missing_.sigma),
        residual_(missing_.residual) {}

  Signatures build() {
    for (const Grid& g : grids_)
      held_.push_back(add_by_hand(plant_, e_.recordings[static_cast<size_t>(g.recording)].spec));
    for (int j = 0; j < n_; ++j) add_joint(j);
    if (!plant_.effort_driven) {
      for (int j = 0; j < n_; ++j) add_sensors(j);
    }
    const Plant nominal = make_plant(e_, {});
    for (const Grid& g : grids_) nominal_.push_back(calc_efforts(nominal, g.q, g.qd, g.qdd));
    for (int link = 0; link < e_.robot.tree.num_joints() + 1; ++link) add_link(link);
    finish();
    return std::move(out_);
  }

 private:
  // Adds a column f(grid, sample) in the rows of joint j and of one kind (0: motion, 1: servo). Returns its index.
  int add_column(int j, int kind, const std::function<double(const Grid&, long)>& f) {
    Eigen::VectorXd column = Eigen::VectorXd::Zero(rows_ * 2 * n_);
    const double sigma = sigma_[static_cast<size_t>(kind) * static_cast<size_t>(n_) + static_cast<size_t>(j)];
    long row = 0;
    for (const Grid& g : grids_) {
      for (long k = 0; k < g.q.rows(); ++k, ++row) {
        const long at = row * 2 * n_ + kind * n_ + j;
        column[at] = f(g, k) / sigma;
      }
    }
    for (size_t i = 0; i < columns_.size(); ++i) {  // laws share columns
      if (columns_[i] == column) return static_cast<int>(i);
    }
    columns_.push_back(std::move(column));
    return static_cast<int>(columns_.size()) - 1;
  }

  // Adds a column of changed efforts [sample][joint], one matrix per grid.
  int add_column(const std::vector<Eigen::MatrixXd>& efforts) {
    Eigen::VectorXd column = Eigen::VectorXd::Zero(rows_ * 2 * n_);
    long row = 0;
    for (size_t i = 0; i < grids_.size(); ++i) {
      for (long k = 0; k < grids_[i].q.rows(); ++k, ++row) {
        for (int j = 0; j < n_; ++j) column[row * 2 * n_ + j] = efforts[i](k, j) / sigma_[static_cast<size_t>(j)];
      }
    }
    columns_.push_back(std::move(column));
    return static_cast<int>(columns_.size()) - 1;
  }

  void add_shape(EffectId id, const Place& place, std::vector<int> columns,
                 std::function<bool(const std::vector<double>&, std::vector<double>*)> make_start) {
    out_.shapes.push_back({id, place, std::move(columns), std::move(make_start)});
  }

  // Change of all efforts if the link of joint j is at q - delta(t), as behind an elastic or loose transmission.
  int add_motion_change(
      int j, const std::function<void(const Grid&, Eigen::VectorXd*, Eigen::VectorXd*, Eigen::VectorXd*)>& delta) {
    std::vector<Eigen::MatrixXd> efforts;
    for (size_t i = 0; i < grids_.size(); ++i) {
      const Grid& g = grids_[i];
      Eigen::VectorXd d(g.q.rows()), d1(g.q.rows()), d2(g.q.rows());
      delta(g, &d, &d1, &d2);
      Eigen::MatrixXd q = g.q, qd = g.qd, qdd = g.qdd;
      const double eps = 1e-4 / std::max(1e-12, d.cwiseAbs().maxCoeff());
      q.col(j) -= eps * d;
      qd.col(j) -= eps * d1;
      qdd.col(j) -= eps * d2;
      efforts.push_back((calc_efforts(held_[i], q, qd, qdd) - g.bare) / eps);
    }
    return add_column(efforts);
  }

  // An effect of one parameter: neutral value plus coefficient, within its bounds.
  void add_single(const EffectInfo& row, const Place& place, int column) {
    const EffectParameter& info = row.parameters[0];
    add_shape(row.id, place, {column}, [&info](const std::vector<double>& x, std::vector<double>* p) {
      *p = {info.neutral + x[0]};
      return (*p)[0] > info.low && (*p)[0] < info.high;
    });
  }

  void add_joint(int j) {
    if (!e_.robot.tree.joint(j).actuated) return;
    add_rows(j);
    add_transmissions(j);
    const JointLaws& laws = plant_.laws[static_cast<size_t>(j)];
    for (const EffectInfo& row : list_effects()) {
      if (row.by_command && !plant_.effort_driven) {
        add_single(row, at_joint(j), add_column(j, 1, [j, &laws](const Grid& g, long k) {
                     return -(laws.kp * g.c(k, j) + laws.kd * g.cd(k, j));
                   }));
      }
      if (!row.felt_elsewhere) continue;
      add_single(row, at_joint(j),
                 add_motion_change(j, [](const Grid&, Eigen::VectorXd* d, Eigen::VectorXd* d1, Eigen::VectorXd* d2) {
                   d->setOnes();
                   d1->setZero();
                   d2->setZero();
                 }));
    }
  }

  // Rows of the table that are linear in torque, with all shapes to try.
  void add_rows(int j) {
    double effort = 0.0, speed = 0.0;
    for (const Grid& g : grids_) {
      effort = std::max(effort, g.u.col(j).cwiseAbs().maxCoeff());
      speed = std::max(speed, g.qd.col(j).cwiseAbs().maxCoeff());
    }
    for (const EffectInfo& effect : list_effects()) {
      if (effect.place != PlaceKind::kJoint || (effect.torque.num_columns == 0 && !effect.torque.advance)) continue;
      // without a servo, no command can be late
      if (plant_.effort_driven && effect.family == EffectFamily::kTiming) continue;
      std::vector<std::vector<double>> shapes = effect.torque.shapes;
      if (effect.torque.shape_from_data)
        shapes = find_periods(j);
      else if (shapes.empty())
        shapes.emplace_back();
      for (std::vector<double> shape : shapes) {
        if (effect.torque.shape_of_effort) shape[0] *= effort;
        if (effect.torque.shape_of_speed) shape[1] *= speed;
        add_row(j, effect, shape);
      }
    }
  }

  void add_row(int j, const EffectInfo& effect, const std::vector<double>& shape) {
    const TorqueRegressor& torque = effect.torque;
    std::vector<int> columns;
    std::vector<double> values(static_cast<size_t>(torque.num_columns));
    if (torque.advance) columns.push_back(add_memory(j, effect, shape[0]));
    for (int i = 0; i < torque.num_columns; ++i) {
      columns.push_back(add_column(j, 0, [&](const Grid& g, long k) {
        const double v = g.qd(k, j);
        const JointSample sample{g.q(k, j), v, g.qdd(k, j), calc_direction(v), g.u(k, j), g.u1(k, j)};
        torque.calc_columns(sample, shape.data(), values.data());
        return values[static_cast<size_t>(i)];
      }));
    }
    const size_t size = effect.parameters.size();
    add_shape(effect.id, at_joint(j), columns,
              [&torque, shape, size](const std::vector<double>& x, std::vector<double>* p) {
                p->assign(size, 0.0);
                return torque.make_parameters(x.data(), shape.data(), p->data());
              });
  }

  int add_memory(int j, const EffectInfo& effect, double shape) {
    Eigen::VectorXd state;
    return add_column(j, 0, [&](const Grid& g, long k) {
      if (k == 0) state = calc_memory_state(effect, g.q.col(j), shape);
      return state[k];
    });
  }

  // A rotor inertia, and the lag of the link behind it.
  void add_transmissions(int j) {
    const int inertia = add_column(j, 0, [j](const Grid& g, long k) { return g.qdd(k, j); });
    for (const EffectInfo& row : list_effects()) {
      if (!row.flexible) continue;
      const GiveRegressor& give = row.give;
      const int lag =
          add_motion_change(j, [j, &give](const Grid& g, Eigen::VectorXd* d, Eigen::VectorXd* d1, Eigen::VectorXd* d2) {
            const double most = g.u.col(j).cwiseAbs().maxCoeff();
            double now[3];
            for (long k = 0; k < g.u.rows(); ++k) {
              give.calc_give(g.u(k, j), g.u1(k, j), g.u2(k, j), most, now);
              (*d)[k] = now[0];
              (*d1)[k] = now[1];
              (*d2)[k] = now[2];
            }
          });
      const size_t size = row.parameters.size();
      add_shape(row.id, at_joint(j), {inertia, lag},
                [&give, size](const std::vector<double>& x, std::vector<double>* p) {
                  p->resize(size);
                  give.make_parameters(x[0], x[1], p->data());
                  return x[0] > 0.0 || x[1] > 0.0;
                });
    }
  }

  // Best wave numbers [1/rad] of ripples in the missing effort, at most four.
  std::vector<std::vector<double>> find_periods(int j) const {
    double low = 1e300, high = -1e300;
    for (const Grid& g : grids_) {
      low = std::min(low, g.q.col(j).minCoeff());
      high = std::max(high, g.q.col(j).maxCoeff());
    }
    const double range = high - low;
    if (range < 0.05) return {};
    std::vector<std::pair<double, double>> found;
    for (double periods = 4.0 / range + 2.0; periods < 260.0; periods += 0.7 / range) {
      double ss = 0, sc = 0, cc = 0, s = 0, c = 0, n = 0, r0 = 0, rs = 0, rc = 0;
      long row = 0;
      for (const Grid& g : grids_) {
        for (long k = 0; k < g.q.rows(); ++k, ++row) {
          const double r = residual_[row * 2 * n_ + j], x = std::sin(periods * g.q(k, j)),
                       y = std::cos(periods * g.q(k, j));
          ss += x * x;
          sc += x * y;
          cc += y * y;
          s += x;
          c += y;
          n += 1;
          r0 += r;
          rs += r * x;
          rc += r * y;
        }
      }
      const double mean = r0 / n;
      rs -= mean * s;
      rc -= mean * c;
      const double det = ss * cc - sc * sc;
      if (det > 1e-9) found.push_back({(cc * rs * rs - 2.0 * sc * rs * rc + ss * rc * rc) / det, periods});
    }
    std::sort(found.rbegin(), found.rend());
    std::vector<std::vector<double>> best;
    for (size_t i = 0; i < std::min<size_t>(4, found.size()); ++i) best.push_back({found[i].second});
    return best;
  }

  // A fault of the logged effort appears equally in both kinds of rows. A fault of the logged position, which the servo
  // does not have, appears as a wrong servo effort.
  void add_sensors(int j) {
    if (!missing_.has_effort[static_cast<size_t>(j)]) return;
    const JointLaws& laws = plant_.laws[static_cast<size_t>(j)];
    for (const EffectInfo& row : list_effects()) {
      if (!row.change.any()) continue;
      const ReadingChange& c = row.change;
      const auto of_effort = [j, &c](const Grid& g, long k) {
        return c.constant + c.of_reading * g.servo(k, j) + c.of_rate * g.u1(k, j);
      };
      Eigen::VectorXd both = columns_[static_cast<size_t>(add_column(j, 0, of_effort))];
      both += columns_[static_cast<size_t>(add_column(j, 1, of_effort))];
      columns_.push_back(std::move(both));
      add_single(row, at_sensor(j, Reading::kEffort), static_cast<int>(columns_.size()) - 1);
      add_single(row, at_sensor(j, Reading::kPosition), add_column(j, 1, [j, &c, &laws](const Grid& g, long k) {
                   return laws.kp * (c.constant + c.of_reading * g.q(k, j) + c.of_rate * g.qd(k, j)) +
                          laws.kd * (c.of_reading * g.qd(k, j) + c.of_rate * g.qdd(k, j));
                 }));
    }
  }

  // Change of all efforts per unit of a change of the model.
  int add_model_change(const Effect& change, double per) {
    Hypothesis hypothesis{change};
    const Plant changed = make_plant(e_, hypothesis);
    std::vector<Eigen::MatrixXd> efforts;
    for (size_t i = 0; i < grids_.size(); ++i) {
      const Grid& g = grids_[i];
      efforts.push_back((calc_efforts(changed, g.q, g.qd, g.qdd) - nominal_[i]) / per);
    }
    return add_column(efforts);
  }

  // Effects of links that are linear in all parameters, and a payload. The payload is a mass at the link's origin and
  // the moment of a shifted centre of mass.
  void add_link(int link) {
    if (link == 0) return;
    const double mass = e_.robot.tree.links[static_cast<size_t>(link)].inertia.mass;
    std::vector<int> shift;
    for (const EffectInfo& row : list_effects()) {
      if (row.place != PlaceKind::kLink || !row.linear || row.parameters[0].probe == 0.0) continue;
      if (row.of_whole_link && !(mass > 0.0)) continue;
      std::vector<int> columns;
      for (size_t i = 0; i < row.parameters.size(); ++i) {
        Effect change(row.id, link, {});
        for (const EffectParameter& p : row.parameters) change.p.push_back(p.neutral);
        change.p[i] += row.parameters[i].probe;
        columns.push_back(add_model_change(change, row.parameters[i].probe));
      }
      if (row.vector && row.of_whole_link) shift = columns;
      if (columns.size() == 1) {
        add_single(row, at_link(link), columns[0]);
        continue;
      }
      add_shape(row.id, at_link(link), columns, [](const std::vector<double>& x, std::vector<double>* p) {
        *p = x;
        return true;
      });
    }
    for (const EffectInfo& row : list_effects()) {
      if (row.place == PlaceKind::kLink && row.probe.list && mass > 0.0) add_payload(row, link, mass, shift);
    }
  }

  void add_payload(const EffectInfo& row, int link, double mass, const std::vector<int>& shift) {
    const int at_origin = add_model_change({row.id, link, {1e-3, 0, 0, 0, 0}}, 1e-3);
    add_shape(row.id, at_link(link), {at_origin, shift[0], shift[1], shift[2]},
              [mass](const std::vector<double>& x, std::vector<double>* p) {
                *p = {x[0], 0, 0, 0, 0};
                if (!(x[0] > 1e-3)) return false;
                for (size_t i = 0; i < 3; ++i) (*p)[i + 1] = std::max(-1.0, std::min(1.0, mass * x[i + 1] / x[0]));
                return true;
              });
  }

  void finish() {
    const long p = static_cast<long>(columns_.size());
    Eigen::MatrixXd X(rows_ * 2 * n_, p);
    for (long i = 0; i < p; ++i) X.col(i) = columns_[static_cast<size_t>(i)];
    out_.gram = Eigen::MatrixXd::Zero(p, p);
    out_.gram.selfadjointView<Eigen::Lower>().rankUpdate(X.transpose());
    out_.gram = out_.gram.selfadjointView<Eigen::Lower>();
    out_.projection = X.transpose() * residual_;
    out_.chi2 = residual_.squaredNorm();
    out_.count = static_cast<double>(residual_.size());
    out_.joint_chi2.assign(static_cast<size_t>(n_), 0.0);
    for (long row = 0; row < rows_; ++row) {
      for (int j = 0; j < n_; ++j)
        out_.joint_chi2[static_cast<size_t>(j)] +=
            std::pow(residual_[row * 2 * n_ + j], 2) / static_cast<double>(rows_);
    }
  }

  const Experiment& e_;
  Plant plant_;
  std::vector<Plant> held_;  // by grid: with external forces by hand in that recording
  int n_;
  const MissingRows missing_;
  const std::vector<Grid>& grids_;
  const long rows_;
  const std::vector<double>& sigma_;
  const Eigen::VectorXd& residual_;
  std::vector<Eigen::MatrixXd> nominal_;  // by grid: inverse dynamics of the nominal model
  std::vector<Eigen::VectorXd> columns_;
  Signatures out_;
};

}  // namespace

Signatures calc_signatures(const Problem& problem, const Hypothesis& base, const Paths* paths) {
  return Builder(problem, base, paths).build();
}

}  // namespace hrp::diagnosis
