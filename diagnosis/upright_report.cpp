// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "diagnosis/upright_search.h"

namespace hrp::diagnosis::upright {
namespace {

using Json = nlohmann::ordered_json;

std::string number(double value, int digits = 3) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

Json make_value(double value, double std, const char* unit) {
  return {{"value", value}, {"std", std}, {"ci95", {value - 1.96 * std, value + 1.96 * std}}, {"unit", unit}};
}

bool is_foot(StandId id) { return id == StandId::kFootCompliance || id == StandId::kFootHardening; }

// The place in the report's words: kind and name.
std::pair<std::string, std::string> find_place(const StandProblem& p, const StandEffect& e) {
  if (e.id <= StandId::kActuatorLag) return {"joint", p.tree.joint(e.place).name};
  if (e.id >= StandId::kEffortBias) return {"sensor", "/joint_states/" + p.tree.joint(e.place).name + "/effort"};
  if (e.id <= StandId::kExternalForce) return {"link", p.tree.links[static_cast<size_t>(e.place)].name};
  if (e.id == StandId::kGroundSlope || e.id == StandId::kGroundFriction) return {"ground", "ground"};
  const std::string imu = "/imu/" + p.imu;
  if (e.id > StandId::kWrenchSkew) {
    const bool gyro = e.id == StandId::kGyroBias || e.id == StandId::kGyroScale;
    const bool accelerometer = e.id == StandId::kAccelerometerBias || e.id == StandId::kAccelerometerScale;
    return {"sensor", imu + (gyro ? "/angular_velocity" : accelerometer ? "/linear_acceleration" : "")};
  }
  const std::string wrench = "/wrench/" + p.feet[static_cast<size_t>(e.place)].sensor;
  const bool force = e.id == StandId::kForceBias || e.id == StandId::kForceScale;
  const bool torque = e.id == StandId::kTorqueBias || e.id == StandId::kTorqueScale;
  return {"sensor", wrench + (force ? "/force" : torque ? "/torque" : "")};
}

// Values a bush's coefficients stand for: k = 1 / a, c = b / a, by first-order propagation.
void add_bush_axis(const StandEffect& e, const Eigen::VectorXd& std, size_t at, const char* axis, Json* out) {
  const double a = e.p[at], b = e.p[at + 1], sa = std(static_cast<long>(at)), sb = std(static_cast<long>(at) + 1);
  (*out)[std::string("k_") + axis] = make_value(1 / a, sa / (a * a), "N m/rad");
  (*out)[std::string("c_") + axis] = make_value(b / a, std::hypot(sb / a, b * sa / (a * a)), "N m s/rad");
}

Json make_bush(const StandEffect& e, const Eigen::VectorXd& std, size_t foot) {
  const bool hard = e.id == StandId::kFootHardening;
  const size_t at = foot * (kFootParameters + (hard ? 1 : 0));
  Json out;
  const double a = e.p[at + 8], s = std(static_cast<long>(at) + 8);
  if (a > 3 * s) out["kz"] = make_value(1 / a, s / (a * a), "N/m");  // else the data do not say how far the foot sinks
  add_bush_axis(e, std, at, "roll", &out);
  add_bush_axis(e, std, at + 4, "pitch", &out);
  if (hard) {
    // tilt = -M/k - h tilt^3: stiffness k (1 + (tilt / angle)^2) with angle = 1 / sqrt(h).
    const double h = e.p[at + 9], sh = std(static_cast<long>(at) + 9);
    out["hardening_angle"] = make_value(1 / std::sqrt(h), 0.5 * sh / (h * std::sqrt(h)), "rad");
  }
  return out;
}

Json make_payload(const StandEffect& e, const Eigen::VectorXd& std) {
  Json out;
  out["mass"] = make_value(e.p[0], std(0), "kg");
  Json value = Json::array(), deviation = Json::array(), interval = Json::array();
  for (long i = 1; i < 4; ++i) {  // written as mass x com
    const double c = e.p[static_cast<size_t>(i)] / e.p[0], s = std::hypot(std(i), c * std(0)) / e.p[0];
    value.push_back(c), deviation.push_back(s), interval.push_back({c - 1.96 * s, c + 1.96 * s});
  }
  out["com"] = {{"value", value}, {"std", deviation}, {"ci95", interval}, {"unit", "m"}};
  return out;
}

Json make_parameters(const StandEffect& e, const Eigen::VectorXd& std) {
  const StandInfo& info = get_stand_info(e.id);
  if (e.id == StandId::kPayload) return make_payload(e, std);
  Json out;
  if (e.id == StandId::kSpring) {
    out["stiffness"] = make_value(e.p[0], std(0), "N m/rad");
    const double rest = -e.p[1] / e.p[0];
    out["rest"] = make_value(rest, std::hypot(std(1), rest * std(0)) / e.p[0], "rad");
    return out;
  }
  if (info.parameters.size() == e.p.size()) {
    for (size_t i = 0; i < e.p.size(); ++i) {
      if (*info.parameters[i]) out[info.parameters[i]] = make_value(e.p[i], std(static_cast<long>(i)), info.units[i]);
    }
    return out;
  }
  Json value = Json::array(), deviation = Json::array(), interval = Json::array();  // one vector
  for (size_t i = 0; i < e.p.size(); ++i) {
    const double s = std(static_cast<long>(i));
    value.push_back(e.p[i]), deviation.push_back(s), interval.push_back({e.p[i] - 1.96 * s, e.p[i] + 1.96 * s});
  }
  out[info.parameters[0]] = {{"value", value}, {"std", deviation}, {"ci95", interval}, {"unit", info.units[0]}};
  return out;
}

const char* find_phrase(StandId id) {
  static const std::map<StandId, const char*> phrases{
      {StandId::kViscous, "friction in proportion to speed is missing"},
      {StandId::kCoulomb, "dry friction is missing: the drive's effort jumps with the direction of motion"},
      {StandId::kRotorInertia, "the rotor's reflected inertia is missing: the effort left over follows the acceleration"},
      {StandId::kSpring, "a spring acts across the joint"},
      {StandId::kTorqueConstant, "the true torque is a fixed multiple of the logged effort"},
      {StandId::kJointOffset, "the encoder's zero is off: feet that stand flat seem tilted, whatever the robot does"},
      {StandId::kCommandDelay, "commands reach the servo late"},
      {StandId::kActuatorLag, "the drive's torque lags behind what is logged"},
      {StandId::kPayload, "an unmodelled mass is carried"},
      {StandId::kMassError, "the link's mass is wrong by a factor"},
      {StandId::kComError, "the link's centre of mass is elsewhere"},
      {StandId::kExternalForce, "a constant force from outside pulls at it"},
      {StandId::kFootCompliance, "the sole gives: the foot tilts in proportion to the moment on it"},
      {StandId::kFootHardening, "the sole gives, and stiffens as it is bent"},
      {StandId::kGroundSlope, "the ground is not level"},
      {StandId::kGroundFriction, "the feet slip: the ground is more slippery than the model's"},
      {StandId::kForceBias, "the force reading is shifted by a constant"},
      {StandId::kTorqueBias, "the torque reading is shifted by a constant"},
      {StandId::kForceScale, "the force reading is scaled"},
      {StandId::kTorqueScale, "the torque reading is scaled"},
      {StandId::kWrenchDelay, "the force sensor's readings come late"},
      {StandId::kWrenchMisalignment, "the force sensor is turned against its link"},
      {StandId::kWrenchSkew, "the force sensor's clock runs at another rate"},
      {StandId::kGyroBias, "the gyroscope is shifted by a constant"},
      {StandId::kAccelerometerBias, "the accelerometer is shifted by a constant"},
      {StandId::kGyroScale, "the gyroscope is scaled"},
      {StandId::kAccelerometerScale, "the accelerometer is scaled"},
      {StandId::kImuDelay, "the IMU's readings come late"},
      {StandId::kImuMisalignment, "the IMU is turned against its link"},
      {StandId::kImuSkew, "the IMU's clock runs at another rate"},
      {StandId::kEffortBias, "the logged effort is shifted by a constant"},
      {StandId::kEffortScale, "the logged effort is scaled"}};
  return phrases.at(id);
}

std::string describe_values(const Json& parameters) {
  std::string out;
  for (const auto& [name, p] : parameters.items()) {
    out += (out.empty() ? "" : ", ") + name + " ";
    if (p["value"].is_array()) {
      out += "(";
      for (size_t i = 0; i < p["value"].size(); ++i) out += (i ? ", " : "") + number(p["value"][i].get<double>());
      out += ")";
    } else {
      out += number(p["value"].get<double>()) + " +- " + number(1.96 * p["std"].get<double>(), 2);
    }
    const std::string unit = p["unit"].get<std::string>();
    if (unit != "1") out += " " + unit;
  }
  return out;
}

const StandTrial* find_runner_up(const StandOutcome& outcome, size_t round, const StandEffect& chosen) {
  if (round >= outcome.rounds.size()) return nullptr;
  for (const StandTrial& t : outcome.rounds[round]) {
    const StandEffect& e = t.fit.hypothesis.back();
    if (t.fit.score < 1e299 && (e.id != chosen.id || e.place != chosen.place)) return &t;
  }
  return nullptr;
}

std::string make_statement(const StandProblem& p, const StandOutcome& o, size_t round, const std::string& where, const StandEffect& e, const Json& parameters) {
  std::string out = where + ": " + find_phrase(e.id) + " (" + describe_values(parameters) + ").";
  if (const StandTrial* second = find_runner_up(o, round, e)) {
    const StandEffect& other = second->fit.hypothesis.back();
    const double worst = *std::max_element(second->fit.channel_rms.begin(), second->fit.channel_rms.end());
    std::string name = get_stand_info(other.id).effect;
    std::replace(name.begin(), name.end(), '_', ' ');
    out += " The next best explanation, " + name + " at " + find_place(p, other).second + ", leaves up to " + number(worst, 2) + " times the noise.";
  }
  return out;
}

void add_findings(const StandProblem& p, const StandOutcome& o, Json* findings) {
  for (size_t i = 0; i < o.chosen.hypothesis.size(); ++i) {
    const StandEffect& e = o.chosen.hypothesis[i];
    const double probability = std::min(0.999, i < o.rounds.size() ? o.rounds[i][0].probability : 1.0);
    const size_t feet = is_foot(e.id) ? p.feet.size() : 1;
    for (size_t f = 0; f < feet; ++f) {
      const auto [kind, name] = is_foot(e.id) ? std::pair<std::string, std::string>{"foot", p.feet[f].name} : find_place(p, e);
      const Json parameters = is_foot(e.id) ? make_bush(e, o.chosen.std[i], f) : make_parameters(e, o.chosen.std[i]);
      findings->push_back({{"effect", get_stand_info(e.id).effect}, {"where", {{kind, name}}}, {"parameters", parameters},
                           {"probability", probability}, {"statement", make_statement(p, o, i, name, e, parameters)}});
    }
  }
}

size_t find_worst(const StandFit& fit) {
  return static_cast<size_t>(std::max_element(fit.channel_rms.begin(), fit.channel_rms.end()) - fit.channel_rms.begin());
}

Json make_where(const Channel& c) {
  if (!c.joint.empty()) return {{"joint", c.joint}};
  if (!c.foot.empty()) return {{"foot", c.foot}};
  if (!c.sensor.empty()) return {{"sensor", c.sensor}};
  return {{"link", c.link}};
}

// Square of the correlation of a residual with one variable's simple shapes.
double calc_share(const std::vector<double>& r, const std::vector<double>& x) {
  double sr = 0, sx = 0, n = static_cast<double>(r.size());
  for (size_t k = 0; k < r.size(); ++k) sr += r[k] / n, sx += x[k] / n;
  double rr = 0, xx = 0, rx = 0;
  for (size_t k = 0; k < r.size(); ++k) rr += (r[k] - sr) * (r[k] - sr), xx += (x[k] - sx) * (x[k] - sx), rx += (r[k] - sr) * (x[k] - sx);
  return rr > 0 && xx > 0 ? rx * rx / (rr * xx) : 0;
}

Json find_dependence(const StandProblem& p, const StandOutcome& o, size_t channel) {
  const int j = p.tree.find_joint(o.channels[channel].joint);
  std::vector<double> residual;
  std::map<std::string, std::vector<double>> variables;
  for (size_t r = 0; r < p.recordings.size(); ++r) {
    const std::vector<double> flat = calc_channels(p, o.chosen.hypothesis, r);
    const StandRecording& rec = p.recordings[r];
    for (size_t s = 0; s < rec.samples.size(); ++s) {
      const auto k = static_cast<size_t>(rec.samples[s]);
      residual.push_back(flat[s * o.channels.size() + channel]);
      variables["time"].push_back(rec.time[k]);
      variables["load"].push_back(rec.wrench.size() > 2 ? rec.wrench[2].value[k] : 0);
      if (j < 0) continue;
      const Series& q = rec.position[static_cast<size_t>(j)];
      variables["position"].push_back(q.value[k]), variables["velocity"].push_back(q.rate[k]), variables["direction"].push_back(q.rate[k] > 0 ? 1 : -1);
    }
  }
  Json out = Json::array();
  for (const auto& [name, x] : variables) {
    if (calc_share(residual, x) > 0.15) out.push_back(name);
  }
  return out;
}

double calc_total(const StandFit& fit) {
  double sum = 0;
  for (double v : fit.channel_rms) sum += v * v;
  return std::sqrt(sum / static_cast<double>(fit.channel_rms.size()));
}

// Root mean square over recordings of one role, and of each channel over the recording's own spread.
double calc_fit(const StandProblem& p, const StandOutcome& o, const StandHypothesis& h, bool train) {
  double sum = 0, count = 0;
  for (size_t r = 0; r < p.recordings.size(); ++r) {
    if (p.recordings[r].train != train) continue;
    const std::vector<double> flat = calc_channels(p, h, r);
    for (size_t k = 0; k < flat.size(); ++k) {
      const double z = flat[k] / o.sigma[k % o.channels.size()];
      sum += z * z, ++count;
    }
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

Json make_fit(const StandProblem& p, const StandOutcome& o) {
  Json fit;
  for (const bool train : {true, false}) {
    const double before = calc_fit(p, o, {}, train), after = calc_fit(p, o, o.chosen.hypothesis, train);
    if (before > 0) fit[train ? "train" : "validate"] = {{"before", before}, {"after", after}};
  }
  Json signals = Json::object();
  for (size_t c = 0; c < o.channels.size(); ++c) {
    const Channel& channel = o.channels[c];
    const std::string& name = channel.signal;
    const double before = o.nominal.channel_rms[c], after = o.chosen.channel_rms[c];
    if (!signals.contains(name) || signals[name]["before"].get<double>() < before) signals[name] = {{"before", before}, {"after", after}, {"equation", channel.kind}};
  }
  fit["per_signal"] = signals;
  return fit;
}

void add_mismatch(const StandProblem& p, const StandOutcome& o, Json* out) {
  for (size_t c = 0; c < o.channels.size(); ++c) {
    if (o.nominal.channel_rms[c] < 2) continue;
    for (size_t r = 0; r < p.recordings.size(); ++r) {
      const std::vector<double> flat = calc_channels(p, {}, r);
      double sum = 0, count = 0, begin = -1, end = -1;
      Json intervals = Json::array();
      for (size_t s = 0; s < p.recordings[r].samples.size(); ++s) {
        const double z = flat[s * o.channels.size() + c] / o.sigma[c], t = p.recordings[r].time[static_cast<size_t>(p.recordings[r].samples[s])];
        sum += z * z, ++count;
        if (std::abs(z) < 4) continue;
        if (begin < 0 || t > end + 0.15) {
          if (begin >= 0) intervals.push_back({begin, end});
          begin = t;
        }
        end = t;
      }
      if (begin >= 0) intervals.push_back({begin, end});
      const double score = std::sqrt(sum / count);
      if (score >= 2) out->push_back({{"signal", o.channels[c].signal}, {"recording", p.recordings[r].file}, {"score", score}, {"intervals", intervals}, {"regime", "stance"}, {"equation", o.channels[c].kind}});
    }
  }
  std::stable_sort(out->begin(), out->end(), [](const Json& a, const Json& b) { return a["score"].get<double>() > b["score"].get<double>(); });
}

}  // namespace

Json make_stand_report(const StandProblem& p, const StandOutcome& o) {
  Json out{{"schema", 1}, {"verdict", !o.mismatch ? "no_mismatch" : o.explained ? "explained" : o.chosen.hypothesis.empty() ? "unexplained" : "partly_explained"},
           {"mismatch", Json::array()}, {"findings", Json::array()}, {"unexplained", Json::array()}, {"not_identifiable", Json::array()}};
  if (o.mismatch) add_mismatch(p, o, &out["mismatch"]);
  add_findings(p, o, &out["findings"]);
  if (o.mismatch && !o.explained) {
    const size_t c = find_worst(o.chosen);
    const Json where = make_where(o.channels[c]);
    out["unexplained"].push_back({{"where", where}, {"depends_on", find_dependence(p, o, c)},
                                  {"statement", "What is left at " + where.begin().value().get<std::string>() + " (equation: " + o.channels[c].kind + ") is up to " +
                                                    number(o.chosen.channel_rms[c], 2) + " times its noise; no known effect explains it."}});
  }
  for (const StandEffect& e : o.chosen.hypothesis) {
    if (!is_foot(e.id)) continue;
    out["not_identifiable"].push_back({{"effect", "foot_compliance.cz"}, {"why", "a standing robot hardly moves up and down on its soles"},
                                       {"motion_that_would_tell", "short vertical bounces above 5 Hz, or a recorded base pose"}});
  }
  out["fit"] = make_fit(p, o);
  out["prediction"] = {{"method", "equations of motion along the recorded motion: attitude and encoders against foot sensors, efforts and servo law"}, {"horizon", 0.0}};
  return out;
}

Json make_stand_series(const StandProblem& p, const StandOutcome& o) {
  Json out{{"schema", 1}, {"robot", p.tree.name}, {"signals", Json::array()}, {"recordings", Json::array()}, {"rivals", Json::array()}};
  for (size_t c = 0; c < o.channels.size(); ++c) {
    out["signals"].push_back({{"name", o.channels[c].kind + " " + (o.channels[c].foot.empty() ? o.channels[c].signal : o.channels[c].foot)}, {"unit", ""}, {"noise", o.sigma[c]}, {"noise_source", "estimated"}});
  }
  for (size_t r = 0; r < p.recordings.size(); ++r) {
    const StandRecording& rec = p.recordings[r];
    const std::vector<double> before = calc_channels(p, {}, r), after = calc_channels(p, o.chosen.hypothesis, r);
    const double start = rec.time[static_cast<size_t>(rec.samples.front())], end = rec.time[static_cast<size_t>(rec.samples.back())];
    const int bins = 120;
    Json rows = Json::array(), traces = Json::array();
    std::vector<std::pair<double, size_t>> worst;
    for (size_t c = 0; c < o.channels.size(); ++c) {
      std::vector<double> b(bins), a(bins), n(bins);
      double total = 0;
      for (size_t s = 0; s < rec.samples.size(); ++s) {
        const double t = rec.time[static_cast<size_t>(rec.samples[s])];
        const auto bin = static_cast<size_t>(std::min(bins - 1.0, (t - start) / (end - start) * bins));
        const double zb = before[s * o.channels.size() + c] / o.sigma[c], za = after[s * o.channels.size() + c] / o.sigma[c];
        b[bin] += zb * zb, a[bin] += za * za, ++n[bin], total += zb * zb;
      }
      Json jb = Json::array(), ja = Json::array();
      for (size_t i = 0; i < static_cast<size_t>(bins); ++i) {
        jb.push_back(n[i] > 0 ? Json(std::sqrt(b[i] / n[i])) : Json()), ja.push_back(n[i] > 0 ? Json(std::sqrt(a[i] / n[i])) : Json());
      }
      rows.push_back({{"signal", c}, {"before", jb}, {"after", ja}});
      worst.push_back({-total, c});
    }
    std::sort(worst.begin(), worst.end());
    for (size_t i = 0; i < std::min<size_t>(4, worst.size()); ++i) {
      const size_t c = worst[i].second;
      Json time = Json::array(), zero = Json::array(), jb = Json::array(), ja = Json::array();
      for (size_t s = 0; s < rec.samples.size(); ++s) {
        time.push_back(rec.time[static_cast<size_t>(rec.samples[s])]), zero.push_back(0.0);
        jb.push_back(before[s * o.channels.size() + c]), ja.push_back(after[s * o.channels.size() + c]);
      }
      traces.push_back({{"signal", c}, {"time", time}, {"recorded", zero}, {"before", jb}, {"after", ja}});
    }
    out["recordings"].push_back({{"file", rec.file}, {"role", rec.train ? "train" : "validate"}, {"start", start}, {"end", end},
                                 {"map", {{"start", start}, {"step", (end - start) / bins}, {"rows", rows}}}, {"traces", traces}});
  }
  for (size_t i = 0; i < o.rounds.size(); ++i) {
    for (const StandTrial& t : o.rounds[i]) {
      if (t.fit.score >= 1e299) continue;
      const StandEffect& e = t.fit.hypothesis.back();
      const auto [kind, name] = find_place(p, e);
      const bool chosen = i < o.chosen.hypothesis.size() && e.id == o.chosen.hypothesis[i].id && e.place == o.chosen.hypothesis[i].place;
      const size_t w = find_worst(t.fit);
      out["rivals"].push_back({{"effect", get_stand_info(e.id).effect}, {"where", {{is_foot(e.id) ? "foot" : kind, is_foot(e.id) ? "all" : name}}}, {"probability", t.probability},
                               {"validate_score", calc_total(t.fit)}, {"complexity", e.p.size()}, {"chosen", chosen},
                               {"why", chosen ? "agrees best with the recordings it was not fitted to" : "leaves " + number(t.fit.channel_rms[w], 2) + " times the noise in " + o.channels[w].kind + " " + o.channels[w].signal}});
    }
  }
  out["notes"] = {"Traces show what is left of each equation; recorded would be zero."};
  return out;
}

}  // namespace hrp::diagnosis::upright
