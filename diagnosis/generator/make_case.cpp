// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/make_case.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/base/has.h"
#include "diagnosis/generator/dirt_truth.h"
#include "diagnosis/generator/draft.h"
#include "diagnosis/generator/poor.h"

namespace hrp::cases {
namespace {

// An effect counts as present when some signal moves by this many noise deviations (rms).
constexpr double kShows = 4.0;
constexpr int kDraws = 200;     // of robot, effects and motion, before a case is given up
constexpr int kOtherSeeds = 5;  // for a case that was given up

void draw_recordings(Draft& draft, const CaseRequest& request, const CaseOptions& options, Prng& random) {
  std::vector<std::string> kinds = draw_motion_kinds(draft.robot, random);
  if (has(request.effects, "ground_friction")) {
    kinds[2] = kinds[3] = "spread";
  }
  const bool mid_motion = random.chance(0.15);
  const double duration = options.duration * random.uniform(0.6, 1.0);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    RecordingPlan plan;
    plan.role = i < 3 ? "train" : "validate";
    plan.file = plan.role + "_" + std::to_string(i < 3 ? i + 1 : i - 2) + ".csv";
    plan.motion = kinds[i];
    plan.duration = duration;
    plan.start = mid_motion && kinds[i] != "release" ? random.uniform(0.8, 2.5) : 0;
    if (kinds[i] == "release") {
      const double size = 0.035 * 9.81 * draft.robot.links[static_cast<std::size_t>(draft.robot.imu_link)].mass * 3;
      plan.push = {size * random.sign() * random.uniform(0.6, 1.0), size * random.uniform(-0.4, 0.4), 0};
    }
    const std::vector<double> all = draw_row_times(draft.recorder, 0, plan.start + plan.duration, random);
    draft.commands.push_back(make_commands(draft.robot, plan.motion, all, random));
    std::vector<double> rows;
    for (double t : all) {
      if (t >= plan.start) rows.push_back(t);
    }
    draft.times.push_back(rows);
    draft.recordings.push_back(plan);
  }
}

// Places are drawn apart but for `pair_same_joint`, where both effects sit in the first one's joint.
std::vector<Hidden> draw_all_hidden(const CaseRequest& request, const RobotPlan& robot, double boost, Prng& random) {
  std::vector<Hidden> out;
  std::vector<std::string> taken;
  const bool same = request.family.find("same_joint") != std::string::npos;
  for (const std::string& effect : request.effects) {
    std::vector<Hidden> drawn = draw_hidden(effect, robot, taken, boost, random);
    for (int attempt = 0; same && !out.empty() && drawn[0].where != out[0].where && attempt < 200; ++attempt) {
      drawn = draw_hidden(effect, robot, {}, boost, random);
    }
    for (Hidden& h : drawn) {
      if (h.where_kind == "joint") taken.push_back(h.where);
      out.push_back(std::move(h));
    }
  }
  return out;
}

// Sensors behind the gears of an arm: at one of its last links.
void add_sensors(const std::vector<std::string>& sensors, RobotPlan* robot, Prng random) {
  const auto takes = [&](const char* name) { return has(sensors, name); };
  const int last = joint_count(*robot);
  robot->joint_torques = takes("joint_torque");
  robot->link_encoders = takes("link_encoder");
  const auto draw_link = [&] { return random.chance(0.7) ? last : 1 + random.below(last); };
  if (takes("wrench")) {
    robot->wrist = "wrist_ft";
    robot->wrist_link = draw_link();
  }
  if (!takes("imu")) return;
  robot->imu = "arm_imu";
  robot->imu_link = draw_link();
  for (double& x : robot->imu_xyz) x = tidy(random.uniform(-0.06, 0.06));
}

Draft draw_draft(const CaseRequest& request, const CaseOptions& options, double boost, Prng random) {
  Draft draft;
  Prng body = random.fork(1), places = random.fork(2), recorder = random.fork(3), motion = random.fork(4);
  const bool drawn = options.urdf.empty();
  draft.robot = request.biped ? (drawn ? make_biped(body) : make_standing_robot(options.urdf, body))
                              : (drawn ? make_arm(body) : make_hung_robot(options.urdf, body));
  if (!request.biped && !options.sensors.empty()) add_sensors(options.sensors, &draft.robot, random.fork(6));
  draft.hidden = draw_all_hidden(request, draft.robot, boost, places);
  draft.recorder = draw_recorder(draft.robot, draft.hidden, recorder);
  if (request.is_dirty()) {
    Prng dirt = random.fork(5);
    draft.dirt = draw_dirt(draft.robot, draft.hidden, dirt);
    soil_recorder(draft.robot, draft.hidden, &draft.recorder, dirt);
  }
  draw_recordings(draft, request, options, motion);
  return draft;
}

// Dither and rounding of encoders, noise of efforts by joint.
double find_dirty_noise(const Draft& draft, const std::string& column) {
  const RecorderPlan& plan = draft.recorder;
  if (column.find("/position") != std::string::npos)
    return std::hypot(plan.position_noise, plan.encoder_step / std::sqrt(12.0));
  for (std::size_t j = 0; j < plan.effort_noises.size(); ++j) {
    if (column == "/joint_states/" + joint(draft.robot, static_cast<int>(j)).name + "/effort")
      return std::hypot(plan.effort_noises[j], plan.ripples[j].amplitude / std::sqrt(2.0));
  }
  return 0;
}

}  // namespace

std::vector<Hidden> list_listed(const Draft& draft) {
  std::vector<Hidden> all = draft.dirt.background;  // first: what is hidden on top of it has the last word
  all.insert(all.end(), draft.hidden.begin(), draft.hidden.end());
  return all;
}

std::vector<Hidden> list_all(const Draft& draft) {
  std::vector<Hidden> all = list_listed(draft);
  all.insert(all.end(), draft.dirt.unlisted.begin(), draft.dirt.unlisted.end());
  return all;
}

std::vector<Hidden> list_in(const Draft& draft, std::size_t recording) {
  std::vector<Hidden> all = list_all(draft);
  const std::vector<Hidden>& loads = draft.recordings[recording].loads;
  all.insert(all.end(), loads.begin(), loads.end());
  return all;
}

std::vector<Column> record_planned(const Draft& draft, const RecorderPlan& recorder, std::size_t i, Prng& random) {
  return record(draft.robot, list_in(draft, i), recorder, draft.recordings[i], draft.commands[i], draft.times[i],
                random);
}

std::vector<Column> record_clean(const Draft& draft, const std::vector<Hidden>& hidden, std::size_t i, double until) {
  std::vector<double> times;
  for (double t : draft.times[i]) {
    if (t <= draft.recordings[i].start + until) times.push_back(t);
  }
  Prng none(0);
  return record(draft.robot, hidden, without_noise(draft.recorder), draft.recordings[i], draft.commands[i], times,
                none);
}

double find_noise(const Draft& draft, const std::string& column) {
  const RecorderPlan& plan = draft.recorder;
  auto has = [&](const char* part) { return column.find(part) != std::string::npos; };
  if (has("/joint_commands")) return 0;
  if (const double dirty = has("/joint_states/") ? find_dirty_noise(draft, column) : 0; dirty > 0) return dirty;
  if (has("/base/pose")) return plan.pose_noise;
  if (has("/orientation")) return plan.attitude_noise;
  if (has("/angular_velocity")) return plan.rate_noise;
  if (has("/linear_acceleration")) return plan.acceleration_noise;
  if (has("/force/")) return plan.force_noise;
  if (has("/torque/")) return plan.torque_noise;
  if (has("/velocity")) return plan.velocity_noise;
  if (has("/effort")) return plan.effort_noise;
  return has("/position") ? plan.position_noise : 0;
}

namespace {

// Largest rms difference of a column in noise deviations.
double calc_strength(const Draft& draft, const std::vector<Column>& with, const std::vector<Column>& without) {
  double strongest = 0;
  for (std::size_t c = 1; c < with.size(); ++c) {
    const double noise = find_noise(draft, with[c].name);
    if (noise <= 0) continue;
    double sum = 0;
    for (std::size_t k = 0; k < with[c].values.size(); ++k) {
      const double difference = (with[c].values[k] - without[c].values[k]) / noise;
      sum += difference * difference;
    }
    strongest = std::max(strongest, std::sqrt(sum / static_cast<double>(with[c].values.size())));
  }
  return strongest;
}

bool all_show(const std::vector<double>& strengths) {
  return std::all_of(strengths.begin(), strengths.end(), [](double s) { return s >= kShows; });
}

// How strongly each hidden thing shows: the case against the case without it, over a train recording and, where that
// does not tell, another.
std::vector<double> calc_strengths(const Draft& draft) {
  std::vector<double> strengths(draft.hidden.size(), 0.0);
  for (std::size_t i : {std::size_t{0}, std::size_t{2}}) {
    if (all_show(strengths)) break;
    const double until = std::min(4.0, draft.recordings[i].duration);
    const std::vector<Column> with = record_clean(draft, list_all(draft), i, until);
    for (std::size_t h = 0; h < draft.hidden.size(); ++h) {
      if (h > 0 &&
          draft.hidden[h].effect == draft.hidden[h - 1].effect) {  // the other foot: the same story, half the time
        strengths[h] = strengths[h - 1];
        continue;
      }
      std::vector<Hidden> others = list_all(draft);
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(draft.dirt.background.size() + h));
      strengths[h] = std::max(strengths[h], calc_strength(draft, with, record_clean(draft, others, i, until)));
    }
  }
  return strengths;
}

void rename(const RobotPlan& robot, Case& made) {
  for (auto& [file, contents] : made.files) contents = find_outside_name(robot, contents);
  made.truth = nlohmann::ordered_json::parse(find_outside_name(robot, made.truth.dump()));
}

// `usual`: with the recordings that were drawn, whatever was recorded in their place: how much each effect does there.
void add_dirt(const Draft& draft, const Draft& usual, const std::vector<std::vector<Column>>& recorded,
              nlohmann::ordered_json& truth) {
  for (const auto& [key, list] : {std::pair{"background", draft.dirt.background}, {"unlisted", draft.dirt.unlisted}}) {
    truth[key] = nlohmann::ordered_json::array();
    for (const Hidden& h : list) truth[key].push_back(to_json(h));
  }
  truth["influence"] = make_influences(usual);
  truth["drive"] = draft.recorder.effort_driven ? "effort" : "servo";
  const bool same = draft.recordings.size() == usual.recordings.size();
  if (same && !draft.recorder.effort_driven && !draft.robot.floating)
    truth["listed_error"] = make_listed_error(draft, recorded);
}

Case finish(const Draft& draft, const Draft& usual, const CaseRequest& request, const std::vector<double>& strengths,
            const CaseOptions& options, Prng random) {
  Case out;
  const RecorderPlan recorder = options.noise_scale == 0 ? without_noise(draft.recorder) : draft.recorder;
  std::vector<std::vector<Column>> recorded;
  for (std::size_t i = 0; i < draft.recordings.size(); ++i) {
    recorded.push_back(record_planned(draft, recorder, i, random));
    out.files[draft.recordings[i].file] = make_csv(recorded.back());
  }
  out.files["robot.urdf"] = make_urdf(draft.robot);
  out.files["experiment.yaml"] = make_experiment_yaml(draft.robot, draft.recorder, draft.recordings);
  nlohmann::ordered_json hidden = nlohmann::ordered_json::array();
  for (const Hidden& h : draft.hidden) hidden.push_back(to_json(h));
  nlohmann::ordered_json motions = nlohmann::ordered_json::array();
  for (const RecordingPlan& plan : draft.recordings) motions.push_back(plan.motion);
  out.truth = {{"hidden", hidden},
               {"family", request.family},
               {"robot", draft.robot.name},
               {"motions", motions},
               {"strength", strengths},
               {"recorder",
                {{"rate", recorder.rate},
                 {"duration", draft.recordings[0].duration},
                 {"jitter", recorder.jitter},
                 {"dropped", recorder.dropped},
                 {"clock_origin", recorder.clock_origin},
                 {"effort", recorder.with_effort},
                 {"attitude", recorder.with_attitude},
                 {"velocity", recorder.with_velocity},
                 {"noise_stated", recorder.noise_stated},
                 {"start", draft.recordings[0].start}}}};
  if (request.is_dirty()) add_dirt(draft, usual, recorded, out.truth);
  if (draft.robot.floating) rename(draft.robot, out);
  return out;
}

// Robot and hidden physics are those of the usual recordings, so that the effects are known to show in some motion.
void change_recordings(Draft* draft, const CaseOptions& options, Prng random) {
  if (options.poor > 0) impoverish(draft, options.poor, random.fork(1));
  play(draft, options.played, options.multisines, random.fork(2));
}

}  // namespace

Case make_case(const CaseRequest& request, std::uint64_t seed, const CaseOptions& options) {
  if (request.walk) return make_walk_case(request, seed, options);
  Prng random(seed);
  double boost = 1;
  std::string why = "too weak";
  bool played = false;  // another draw would be another robot
  for (int attempt = 0; attempt < kDraws; ++attempt) {
    try {
      Draft draft = draw_draft(request, options, boost, random.fork(static_cast<std::uint64_t>(attempt)));
      const std::vector<double> strengths = calc_strengths(draft);
      const Draft usual = draft;
      const bool changed = options.poor > 0 || !options.played.empty();
      played = all_show(strengths) && changed;
      if (played) change_recordings(&draft, options, Prng(seed));
      if (all_show(strengths)) return finish(draft, usual, request, strengths, options, random.fork(99));
      boost = std::min(2.5, boost * 1.3);
    } catch (const InsaneCase& insane) {
      if (played) throw std::runtime_error("the hidden robot cannot play the motion: " + insane.why);
      why = insane.why;
      boost = std::max(0.7, boost * 0.85);
    }
  }
  throw std::runtime_error("no sane case after " + std::to_string(kDraws) + " draws (last: " + why + ")");
}

Case make_with_other_seeds(const std::function<Case(std::uint64_t seed)>& make, std::uint64_t seed) {
  for (int given_up = 0;; ++given_up) {
    try {
      Case made = make(given_up == 0 ? seed : Prng(seed).fork(static_cast<std::uint64_t>(given_up)).next());
      if (given_up > 0) made.truth["given_up"] = given_up;
      return made;
    } catch (const std::runtime_error&) {
      if (given_up == kOtherSeeds) throw;
    }
  }
}

}  // namespace hrp::cases
