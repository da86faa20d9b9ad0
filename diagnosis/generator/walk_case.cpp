// SPDX-License-Identifier: BSD-3-Clause
// Cases of robots that walk under our controller, in closed loop, with something hidden.
#include <algorithm>
#include <cmath>
#include <deque>
#include <stdexcept>

#include "common/base/has.h"
#include "diagnosis/generator/dirt_truth.h"
#include "diagnosis/generator/make_case.h"
#include "diagnosis/generator/poor.h"
#include "diagnosis/generator/walk_brain.h"
#include "diagnosis/generator/walk_plan.h"

namespace hrp::cases {
namespace {

constexpr double kPeriod = 0.005;          // [s] of the controller
constexpr double kShortest = 4.0;          // [s] a recording that ends earlier, in a fall, tells too little
constexpr double kNearlyAll = 0.9;         // share of a shorter recording that has to be there
constexpr int kDraws = 60;                 // of robot, effects and walks, before a case is given up
constexpr double kHeldSteps = 30;          // of its encoder, that a joint which is held moves by at most
constexpr int kWalks = 4, kPoorWalks = 2;  // the last one to validate

struct Walk {
  WalkPlan plan;
  bool fell = false;
  std::vector<Column> columns, clean;  // as written; of dirty worlds as it truly was
};

// What the robot's computer sees: readings with their faults, those of late sensors from some periods ago.
class Senses {
 public:
  Senses(const RobotPlan& robot, const std::vector<Hidden>& hidden) : robot_(robot), hidden_(hidden) {}

  BrainInput see(const Reading& reading) {
    past_.push_back(reading);
    if (past_.size() > 64) past_.pop_front();
    const auto list = [](const Vec3& v) { return std::vector<double>{v[0], v[1], v[2]}; };
    BrainInput in;
    in.time = reading.time;
    in.position = reading.position;
    const std::string imu = "/imu/" + robot_.imu;
    const auto& q = at(imu + "/orientation").imu_orientation;
    in.orientation = add_sensor_faults(hidden_, imu + "/orientation", {q[1], q[2], q[3], q[0]});
    in.rate = add_sensor_faults(hidden_, imu + "/angular_velocity", list(at(imu + "/angular_velocity").imu_rate));
    const std::string acceleration = imu + "/linear_acceleration";
    in.acceleration = add_sensor_faults(hidden_, acceleration, list(at(acceleration).imu_acceleration));
    for (std::size_t f = 0; f < robot_.feet.size(); ++f) {
      const std::string foot = "/wrench/" + robot_.feet[f].wrench;
      in.force.push_back(add_sensor_faults(hidden_, foot + "/force", list(at(foot + "/force").foot_force[f])));
      in.torque.push_back(add_sensor_faults(hidden_, foot + "/torque", list(at(foot + "/torque").foot_torque[f])));
    }
    return in;
  }

 private:
  const Reading& at(const std::string& sensor) const {
    const double now = past_.back().time, late = now - find_sensor_time(hidden_, sensor, now);
    const auto back = static_cast<std::size_t>(std::max(0L, std::lround(late / kPeriod)));
    return past_[past_.size() - 1 - std::min(back, past_.size() - 1)];
  }

  const RobotPlan& robot_;
  const std::vector<Hidden>& hidden_;
  std::deque<Reading> past_;
};

// Its recordings are those that were played on the feet after the walks.
struct WalkDraft : Draft {
  std::vector<std::string> missing;
};

Walk make_walk(const WalkDraft& draft, double duration, bool stabilized, Prng& random) {
  Walk walk;
  walk.plan = draw_walk(draft.robot, random);
  walk.plan.stabilized = stabilized;
  walk.plan.count = static_cast<int>((duration - 2.0) / (walk.plan.single_support + walk.plan.double_support));
  std::vector<std::string> joints;
  for (int j = 0; j < joint_count(draft.robot); ++j) joints.push_back(joint(draft.robot, j).name);
  WalkBrain brain(make_urdf(draft.robot), make_walk_scenario(draft.robot, walk.plan), joints);
  const std::vector<Hidden> all = list_all(draft);
  Senses senses(draft.robot, all);
  const auto think = [&](const Reading& reading, std::vector<double>* q) { brain.control(senses.see(reading), q); };
  std::vector<double> times = draw_row_times(draft.recorder, 0, duration, random);
  while (!times.empty() && times.front() < 0.1) times.erase(times.begin());  // late sensors have read nothing before
  const std::vector<double> instants = list_instants(draft.robot, all, draft.recorder, times);
  Commands commands;
  const std::vector<Reading> readings = Reality(draft.robot, all).walk(think, kPeriod, instants, &commands);
  walk.fell = readings.size() < instants.size();
  const double end = readings.empty() ? 0 : readings.back().time;
  while (!times.empty() && times.back() > end) times.pop_back();
  if (times.empty() || times.back() < std::min(kShortest, kNearlyAll * duration)) throw InsaneCase{"falls at once"};
  const Commands given = commands.sample(times);
  walk.columns = make_columns(draft.robot, all, draft.recorder, given, times, instants, readings, random);
  Prng none(0);
  if (!draft.dirt.background.empty())
    walk.clean = make_columns(draft.robot, {}, without_noise(draft.recorder), given, times, instants, readings, none);
  return walk;
}

WalkDraft draw_draft(const CaseRequest& request, const std::string& models, double boost, Prng random) {
  WalkDraft draft;
  Prng body = random.fork(1), places = random.fork(2), recorder = random.fork(3), sensors = random.fork(4);
  draft.robot = make_walker(models, body);
  draft.robot.name_scheme = 0;  // walkers keep their names
  std::vector<std::string> taken;
  for (const std::string& effect : request.effects) {
    for (Hidden& h : draw_walk_hidden(effect, draft.robot, taken, boost, places)) {
      if (h.where_kind == "joint") taken.push_back(h.where);
      draft.hidden.push_back(std::move(h));
    }
  }
  draft.recorder = draw_recorder(draft.robot, draft.hidden, recorder);
  draft.recorder.rate = recorder.pick(std::vector<double>{200, 250, 400, 500});
  draft.recorder.with_base_pose = draft.recorder.with_velocity = draft.recorder.with_effort =
      draft.recorder.with_attitude = true;
  draft.recorder.link_encoder.clear();
  draft.missing = draw_missing(draft.hidden, sensors);
  const auto has = [&](const char* column) { return !is_missing(draft.missing, column); };
  draft.recorder.with_base_pose = has("/base/pose");
  if (request.is_dirty()) {
    Prng dirt = random.fork(5);
    draft.dirt = draw_dirt(draft.robot, draft.hidden, dirt);
    soil_recorder(draft.robot, draft.hidden, &draft.recorder, dirt);
  }
  return draft;
}

// Of what is hidden on top every part counts, however little it shows.
void add_dirt(const WalkDraft& draft, const Walk& held_out, nlohmann::ordered_json* truth) {
  for (const auto& [key, list] :
       {std::pair{"background", &draft.dirt.background}, {"unlisted", &draft.dirt.unlisted}}) {
    (*truth)[key] = nlohmann::ordered_json::array();
    for (const Hidden& h : *list) (*truth)[key].push_back(to_json(h));
  }
  // A joint that is held tells nothing of its drive.
  const double held = kHeldSteps * draft.recorder.encoder_step;
  nlohmann::ordered_json influence = make_background_influences(draft.robot, draft.dirt, held_out.clean, held);
  for (const Hidden& h : draft.hidden)
    influence.push_back({{"effect", h.effect}, {h.where_kind, h.where}, {"share", 1.0}});
  (*truth)["influence"] = std::move(influence);
  (*truth)["drive"] = "servo";
}

std::vector<Column> drop_missing(const std::vector<Column>& columns, const std::vector<std::string>& missing) {
  std::vector<Column> kept;
  for (const Column& c : columns) {
    if (!is_missing(missing, c.name)) kept.push_back(c);
  }
  return kept;
}

Case finish(const WalkDraft& draft, const CaseRequest& request, const std::vector<Walk>& walks, Prng random) {
  Case out;
  nlohmann::ordered_json hidden = nlohmann::ordered_json::array(), motions = hidden;
  for (const Hidden& h : draft.hidden) hidden.push_back(to_json(h));
  std::vector<RecordingPlan> recordings;
  for (std::size_t i = 0; i < walks.size(); ++i) {
    RecordingPlan plan;
    plan.role = i + 1 < walks.size() ? "train" : "validate";
    plan.file = "walk_" + std::to_string(i + 1) + ".csv";
    recordings.push_back(plan);
    const std::vector<Column> columns = drop_missing(walks[i].columns, draft.missing);
    out.files[plan.file] = make_csv(columns);
    motions.push_back(walks[i].plan.name +
                      (walks[i].fell ? ", falls at " + std::to_string(columns[0].values.back()) : ""));
  }
  for (std::size_t i = 0; i < draft.recordings.size(); ++i) {
    recordings.push_back(draft.recordings[i]);
    motions.push_back(draft.recordings[i].motion);
    out.files[draft.recordings[i].file] =
        make_csv(drop_missing(record_planned(draft, draft.recorder, i, random), draft.missing));
  }
  RecorderPlan recorder = draft.recorder;
  const auto misses = [&](const char* column) { return is_missing(draft.missing, column); };
  recorder.with_commands = !(misses("/joint_commands/x/position") && misses("/joint_states/x/effort"));
  out.files["robot.urdf"] = make_urdf(draft.robot);
  out.files["experiment.yaml"] = make_experiment_yaml(draft.robot, recorder, recordings);
  out.truth = {{"hidden", hidden},
               {"family", request.family},
               {"robot", draft.robot.name},
               {"motions", motions},
               {"missing", draft.missing},
               {"recorder", {{"rate", recorder.rate}, {"jitter", recorder.jitter}, {"dropped", recorder.dropped}}}};
  if (request.is_dirty()) add_dirt(draft, walks.back(), &out.truth);
  return out;
}

// Effects that may meet, each where a walk shows it.
std::vector<std::string> draw_pair(Prng& random) {
  static const std::vector<std::string> first{"foot_compliance",  "foot_compliance", "rotor_inertia",
                                              "coulomb_friction", "command_delay",   "ground_slope"},
      second{"rotor_inertia", "coulomb_friction", "viscous_friction", "command_delay",         "payload",
             "mass_error",    "sensor_bias",      "sensor_scale",     "torque_constant_error", "actuator_lag"};
  for (;;) {
    std::vector<std::string> pair{random.pick(first), random.pick(second)};
    if (pair[0] != pair[1]) return pair;
  }
}

}  // namespace

CaseRequest make_walk_request(std::vector<std::string> effects) {
  std::string family = "walk_none";
  for (const std::string& effect : effects) {
    const bool listed = has(walk_effects(), effect) || effect == "load_dependent_friction";
    if (!listed && !has(walk_unknown_effects(), effect)) throw std::invalid_argument("no walk hides '" + effect + "'");
    family = !listed                                                                  ? "walk_unknown"
             : effect.rfind("sensor_", 0) == 0                                        ? "walk_sensor"
             : effect.rfind("foot_", 0) == 0 || effect.rfind("ground_", 0) == 0       ? "walk_foot"
             : effect == "payload" || effect == "mass_error" || effect == "com_error" ? "walk_link"
                                                                                      : "walk_joint";
  }
  if (effects.size() > 1) family = "walk_pair";
  CaseRequest request;
  request.family = family;
  request.biped = true;
  request.effects = std::move(effects);
  request.walk = true;
  return request;
}

// Each single effect once, beside pairs, nothing and unlisted physics in the proportions of a sensible trial.
std::vector<CaseRequest> make_walk_round(Prng& random) {
  std::vector<CaseRequest> round;
  for (const std::string& effect : walk_effects()) round.push_back(make_walk_request({effect}));
  for (int i = 0; i < 6; ++i) round.push_back(make_walk_request(draw_pair(random)));
  for (int i = 0; i < 4; ++i) round.push_back(make_walk_request({}));
  for (const std::string& effect : walk_unknown_effects()) round.push_back(make_walk_request({effect}));
  random.shuffle(round);
  return round;
}

std::vector<CaseRequest> make_dirty_walk_round(Prng& random) {
  std::vector<CaseRequest> round;
  for (int i = 0; i < 9; ++i) {
    CaseRequest request = make_walk_request(draw_on_top(true, random));
    request.family = "walk_dirty";
    round.push_back(std::move(request));
  }
  return round;
}

Case make_walk_case(const CaseRequest& request, std::uint64_t seed, const CaseOptions& options) {
  Prng random(seed);
  double boost = 1;
  std::string why;
  for (int attempt = 0; attempt < kDraws; ++attempt) {
    Prng draw = random.fork(static_cast<std::uint64_t>(attempt));
    bool walked = false;
    try {
      WalkDraft draft = draw_draft(request, options.models, boost, draw.fork(1));
      Prng walking = draw.fork(2);
      const bool poor = options.poor > 0;
      const double duration = poor ? options.poor : options.duration * walking.uniform(0.8, 1.0);
      const bool stabilized = !walking.chance(0.12);
      std::vector<Walk> walks;
      for (int i = 0; i < (poor ? kPoorWalks : kWalks); ++i)
        walks.push_back(make_walk(draft, duration, stabilized, walking));
      walked = true;
      play(&draft, options.played, options.multisines, draw.fork(3));
      return finish(draft, request, walks, draw.fork(4));
    } catch (const InsaneCase& insane) {
      // Another draw would be another robot than the one that the motion was proposed for.
      if (walked) throw std::runtime_error("the hidden robot cannot play the motion: " + insane.why);
      why = insane.why;
      boost = std::max(0.5, boost * 0.9);
    } catch (const std::runtime_error& error) {
      why = error.what();
    }
  }
  throw std::runtime_error("no sane walk after " + std::to_string(kDraws) + " draws (last: " + why + ")");
}

}  // namespace hrp::cases
