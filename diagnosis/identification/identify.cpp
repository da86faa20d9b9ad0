// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/identify.h"

#include <cmath>
#include <stdexcept>

#include "common/base/format.h"
#include "diagnosis/identification/physical_body.h"

namespace hrp::identification {
namespace {

constexpr double kDistortion = 0.1;  // of a simulated robot's description
constexpr unsigned long long kDistortionSeed = 11;
// The zero moves by a hundredth of the offset: the second round changes nothing that shows
constexpr int kZeroRounds = 2;

// Tracks as if observed with other zeros: the moment about the bush loses the difference.
void move_zeros(const std::vector<SensorZero>& from, const std::vector<SensorZero>& to,
                const std::vector<Vector3d>& p_UC, std::vector<MotionTrack>* tracks) {
  for (MotionTrack& track : *tracks) {
    for (size_t f = 0; f < track.feet.size(); ++f) {
      const Vector6d change = to[f].bias - from[f].bias;
      const Vector3d moment = change.tail<3>() - p_UC[f].cross(Vector3d(change.head<3>()));
      for (int a = 0; a < kAxes; ++a) track.feet[f].torque[a].array() -= moment[a];
    }
  }
}

// The feet's weight hangs along the vertical that the accelerometer shows, less its bias: 0.02 m/s^2 are 0.005 N m.
void refine_zeros(const BushObserver& observer, const RobotLog& measured, Observation* o) {
  for (int round = 0; round < kZeroRounds; ++round) {
    const BushFit fit = fit_bush(o->fitted, o->zeros, observer.bush_centres(), o->options);
    RobotLog hanging = measured;
    for (int i = 0; i < 2; ++i) hanging.accelerometer.row(i).array() -= fit.accelerometer_bias[i].value;
    std::vector<HangingAngles> angles;
    for (size_t f = 0; f < fit.feet.size(); ++f) {
      const auto& p = fit.feet[f];
      angles.push_back(observer.calc_hanging(f, {p[0].K.value, p[1].K.value}, {p[0].O.value, p[1].O.value}));
    }
    const std::vector<SensorZero> zeros = observer.calc_zeros(hanging, angles);
    for (auto* tracks : {&o->fitted, &o->unseen}) move_zeros(o->zeros, zeros, observer.bush_centres(), tracks);
    o->zeros = zeros;
  }
}

std::string describe_slip(const MotionTrack& track) {
  return format("%s: a sole slipped (%.1f mm, %.1f mrad): %.1f s left out", track.name.c_str(), 1e3 * track.slip,
                1e3 * track.turn, track.slipped);
}

Observation observe_once(const BushObserver& observer, const std::vector<Source>& sources) {
  Observation o;
  o.zeros.resize(observer.bush_centres().size());
  const RobotLog* hanging = nullptr;
  std::optional<MotionTrack> resting;
  for (const Source& source : sources) {
    if (source.name != kHanging) continue;
    hanging = &source.log;
    o.zeros = observer.calc_zeros(*hanging);
    resting = observer.observe(*hanging, o.zeros);
    o.options.noise = calc_angle_noise(*resting);
    o.zeroed = true;
  }
  for (const Source& source : sources) {
    if (source.name == kHanging) continue;
    MotionTrack track = observer.observe(source.log, o.zeros);
    track.name = source.name;
    (source.train ? o.fitted : o.unseen).push_back(std::move(track));
  }
  std::vector<MotionTrack> all = o.fitted;
  all.insert(all.end(), o.unseen.begin(), o.unseen.end());
  o.vertical = fit_vertical(all, resting);
  o.options.compliance = o.vertical.compliance;
  if (hanging != nullptr && !o.fitted.empty()) refine_zeros(observer, *hanging, &o);
  return o;
}

}  // namespace

Observation observe(const BushObserver& observer, const std::vector<Source>& sources) {
  Observation first = observe_once(observer, sources);
  if (first.fitted.empty()) return first;
  const BushFit fit = fit_bush(first.fitted, first.zeros, observer.bush_centres(), first.options);
  const Eigen::Vector2d bias(fit.accelerometer_bias[0].value, fit.accelerometer_bias[1].value);
  std::vector<Source> mended = sources;
  for (Source& source : mended) source.log.accelerometer.topRows<2>().colwise() -= bias;
  Observation o = observe_once(observer, mended);
  o.taken = bias;
  return o;
}

BodyFit identify_body(const Scenario& scenario, const std::vector<Source>& sources,
                      const std::vector<SensorZero>& given, const BushFit& fit, bool simulated) {
  const BushObserver observer(scenario);
  const BodyRig rig(scenario);
  std::vector<SensorZero> zeros = given;
  for (SensorZero& zero : zeros)
    zero.gyro_bias.head<2>() += Eigen::Vector2d(fit.gyro_bias[0].value, fit.gyro_bias[1].value);
  std::vector<BodyMotion> fitted, unseen;
  for (const Source& source : sources) {
    if (source.name == kHanging || source.is_pushed()) continue;
    RobotLog log = source.log;
    log.name = source.name;
    for (int i = 0; i < 2; ++i) log.accelerometer.row(i).array() -= fit.accelerometer_bias[i].value;
    log.accelerometer.row(2).array() -= zeros[0].lift;  // the hanging robot knows it ten times better
    (source.train ? fitted : unseen).push_back(observe_body(rig, observer, log, zeros));
  }
  BodyOptions options;
  for (const SensorZero& zero : zeros) options.zeros.push_back(zero.covariance);
  options.description = make_inertial_parameters(rig.model);
  if (simulated) options.description = distort_bodies(options.description, kDistortion, kDistortionSeed);
  return fit_body(rig, fitted, unseen, options);
}

Identification identify(const Scenario& scenario, const std::vector<Source>& sources, bool simulated) {
  const BushObserver observer(scenario);
  const std::vector<Vector3d> arms = observer.bush_centres();
  Identification r;
  r.scenario = scenario;
  r.simulated = simulated;
  Observation o = observe(observer, sources);
  for (const auto* list : {&o.fitted, &o.unseen}) {
    for (const MotionTrack& track : *list) {
      if (has_slipped(track)) r.notes.push_back(describe_slip(track));
      r.tracks.push_back(track);
    }
  }
  if (!o.zeroed)
    r.notes.push_back("no recording 'hanging': the force sensors' zero is taken as it is, and offsets hold it");
  r.choice = choose_law(o.fitted, o.zeros, arms, o.options);
  o.options.law = r.choice.law;
  if (o.options.law == BushLaw::kHysteresis) o.options.skip = kForget;
  r.fit = fit_bush(o.fitted, o.zeros, arms, o.options);
  r.vertical = o.vertical;
  for (int i = 0; i < 2; ++i) r.fit.accelerometer_bias[i].value += o.taken[i];
  r.direct = validate(r.fit, o.fitted);
  o.options.yield = r.fit.yield.value;
  for (size_t i = 0; i < o.fitted.size() && o.fitted.size() > 1; ++i) {
    std::vector<MotionTrack> others = o.fitted;
    others.erase(others.begin() + static_cast<long>(i));
    for (const ValidationError& e : validate(fit_bush(others, o.zeros, arms, o.options), {o.fitted[i]}))
      r.cross.push_back(e);
  }
  for (const ValidationError& e : validate(r.fit, o.unseen)) r.cross.push_back(e);
  try {
    r.body = identify_body(scenario, sources, o.zeros, r.fit, simulated);
  } catch (const std::runtime_error& error) {
    r.notes.push_back(std::string("inertial and joint parameters were not identified: ") + error.what());
  }
  for (const std::string& name : r.fit.constrained)
    r.notes.push_back(name + " would have been negative and is held at zero");
  return r;
}

Coverage study_coverage(const Scenario& scenario, const std::vector<Source>& clean, int seeds) {
  const BushObserver observer(scenario);
  Coverage coverage;
  coverage.seeds = seeds;
  for (size_t f = 0; f < scenario.feet.size(); ++f) {
    const FootBushSpec& b = scenario.foot_bush.at(scenario.feet[f]);
    const double truth[kAxes][3] = {{b.k_roll, b.c_roll, b.offset_roll}, {b.k_pitch, b.c_pitch, b.offset_pitch}};
    for (int a = 0; a < kAxes; ++a) {
      for (int i = 0; i < 3; ++i) coverage.rows.push_back({f, a, i, truth[a][i]});
    }
  }
  for (int seed = 1; seed <= seeds; ++seed) {
    std::vector<Source> noisy = clean;
    for (size_t i = 0; i < clean.size(); ++i) {
      noisy[i].log = add_noise(clean[i].log, scenario, 1000ull * static_cast<unsigned>(seed) + i);
    }
    const Observation o = observe(observer, noisy);
    const BushFit fit = fit_bush(o.fitted, o.zeros, observer.bush_centres(), o.options);
    for (Coverage::Row& row : coverage.rows) {
      const BushParameters& p = fit.feet[row.foot][static_cast<size_t>(row.axis)];
      const Estimate& e = row.parameter == 0 ? p.K : row.parameter == 1 ? p.C : p.O;
      const double error = e.value - row.truth;
      row.mean += error / seeds;
      row.spread += error * error / seeds;
      row.stated += e.std / seeds;
      row.worst = std::max(row.worst, std::abs(error));
      row.inside += std::abs(error) < 1.96 * e.std;
    }
  }
  for (Coverage::Row& row : coverage.rows) {
    row.spread = std::sqrt(std::max(0.0, row.spread - row.mean * row.mean));
    row.mean += row.truth;
  }
  return coverage;
}

std::string make_text(const Coverage& coverage, const Scenario& scenario) {
  const char* const names[3] = {"K", "C", "O"};
  std::string text = "| foot | axis | | truth | mean error | spread | stated std | worst error | inside of " +
                     std::to_string(coverage.seeds) + " |\n|---|---|---|---|---|---|---|---|---|\n";
  int inside[3] = {}, count[3] = {};
  for (const Coverage::Row& row : coverage.rows) {
    const double percent = 100.0 / std::abs(row.truth);
    text += format("| %s | %s | %s | %.4g | %+.3f %% | %.3f %% | %.3f %% | %.2f %% | %d |\n",
                   scenario.feet[row.foot].c_str(), kAxisNames[row.axis], names[row.parameter], row.truth,
                   percent * (row.mean - row.truth), percent * row.spread, percent * row.stated, percent * row.worst,
                   row.inside);
    inside[row.parameter] += row.inside;
    ++count[row.parameter];
  }
  for (int i = 0; i < 3; ++i) {
    text += format("%s: the 95 %% interval holds the truth in %.1f of 100\n", names[i],
                   100.0 * inside[i] / std::max(1, count[i] * coverage.seeds));
  }
  return text;
}

}  // namespace hrp::identification
