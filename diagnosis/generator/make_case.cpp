// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/make_case.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace hrp::cases {
namespace {

// An effect counts as present when some signal moves by this many noise deviations (rms).
constexpr double kShows = 4.0;
constexpr int kDraws = 200;  // of robot, effects and motion, before a case is given up

struct Draft {
  RobotPlan robot;
  std::vector<Hidden> hidden;
  RecorderPlan recorder;
  std::vector<RecordingPlan> recordings;
  std::vector<Commands> commands;
  std::vector<std::vector<double>> times;
};

void draw_recordings(Draft& draft, const CaseRequest& request, const CaseOptions& options, Prng& random) {
  std::vector<std::string> kinds = draw_motion_kinds(draft.robot, random);
  if (std::find(request.effects.begin(), request.effects.end(), "ground_friction") != request.effects.end()) {
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

Draft draw_draft(const CaseRequest& request, const CaseOptions& options, double boost, Prng random) {
  Draft draft;
  Prng body = random.fork(1), places = random.fork(2), recorder = random.fork(3), motion = random.fork(4);
  const bool drawn = options.urdf.empty();
  draft.robot = request.biped ? (drawn ? make_biped(body) : make_standing_robot(options.urdf, body))
                              : (drawn ? make_arm(body) : make_hung_robot(options.urdf, body));
  draft.hidden = draw_all_hidden(request, draft.robot, boost, places);
  draft.recorder = draw_recorder(draft.robot, draft.hidden, recorder);
  draw_recordings(draft, request, options, motion);
  return draft;
}

RecorderPlan without_noise(RecorderPlan plan) {
  plan.position_noise = plan.velocity_noise = plan.effort_noise = plan.force_noise = plan.torque_noise = 0;
  plan.rate_noise = plan.acceleration_noise = plan.attitude_noise = plan.pose_noise = 0;
  return plan;
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

// Deviation used to judge a column: what the recorder adds to it.
double find_noise(const RecorderPlan& plan, const std::string& column) {
  auto has = [&](const char* part) { return column.find(part) != std::string::npos; };
  if (has("/joint_commands")) return 0;
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

// Largest rms difference of a column in noise deviations.
double calc_strength(const RecorderPlan& plan, const std::vector<Column>& with, const std::vector<Column>& without) {
  double strongest = 0;
  for (std::size_t c = 1; c < with.size(); ++c) {
    const double noise = find_noise(plan, with[c].name);
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
    const std::vector<Column> with = record_clean(draft, draft.hidden, i, until);
    for (std::size_t h = 0; h < draft.hidden.size(); ++h) {
      if (h > 0 &&
          draft.hidden[h].effect == draft.hidden[h - 1].effect) {  // the other foot: the same story, half the time
        strengths[h] = strengths[h - 1];
        continue;
      }
      std::vector<Hidden> others = draft.hidden;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(h));
      strengths[h] = std::max(strengths[h], calc_strength(draft.recorder, with, record_clean(draft, others, i, until)));
    }
  }
  return strengths;
}

using Names = std::vector<std::pair<std::string, std::string>>;

// Inside the generator a biped's parts have one set of names; outside they have those of its maker.
const std::vector<Names>& name_schemes() {
  static const std::vector<Names> schemes{
      {},
      {{"left_", "l_"}, {"right_", "r_"}, {"_sole_link", "_foot"}, {"_foot_ft", "_ankle_ft"}, {"trunk", "torso"}},
      {{"left_", "L_"},
       {"right_", "R_"},
       {"hip_yaw", "HIP_Y"},
       {"hip_roll", "HIP_R"},
       {"hip_pitch", "HIP_P"},
       {"knee", "KNEE"},
       {"ankle_pitch", "ANKLE_P"},
       {"ankle_roll", "ANKLE_R"},
       {"hips", "PELVIS"}},
      {{"left_", "leg0-"}, {"right_", "leg1-"}, {"trunk_imu", "imu"}, {"waist", "torso_joint"}}};
  return schemes;
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
}

void rename(int scheme, Case& made) {
  const auto& schemes = name_schemes();
  std::string truth = made.truth.dump();
  for (const auto& [from, to] : schemes[static_cast<std::size_t>(scheme) % schemes.size()]) {
    for (auto& [file, contents] : made.files) replace_all(contents, from, to);
    replace_all(truth, from, to);
  }
  made.truth = nlohmann::ordered_json::parse(truth);
}

Case finish(const Draft& draft, const CaseRequest& request, const std::vector<double>& strengths,
            const CaseOptions& options, Prng random) {
  Case out;
  const RecorderPlan recorder = options.noise_scale == 0 ? without_noise(draft.recorder) : draft.recorder;
  for (std::size_t i = 0; i < draft.recordings.size(); ++i) {
    out.files[draft.recordings[i].file] = make_csv(
        record(draft.robot, draft.hidden, recorder, draft.recordings[i], draft.commands[i], draft.times[i], random));
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
  if (draft.robot.floating) rename(draft.robot.name_scheme, out);
  return out;
}

}  // namespace

Case make_case(const CaseRequest& request, std::uint64_t seed, const CaseOptions& options) {
  Prng random(seed);
  double boost = 1;
  std::string why = "too weak";
  for (int attempt = 0; attempt < kDraws; ++attempt) {
    try {
      const Draft draft = draw_draft(request, options, boost, random.fork(static_cast<std::uint64_t>(attempt)));
      const std::vector<double> strengths = calc_strengths(draft);
      if (all_show(strengths)) return finish(draft, request, strengths, options, random.fork(99));
      boost = std::min(2.5, boost * 1.3);
    } catch (const InsaneCase& insane) {
      why = insane.why;
      boost = std::max(0.7, boost * 0.85);
    }
  }
  throw std::runtime_error("no sane case after " + std::to_string(kDraws) + " draws (last: " + why + ")");
}

}  // namespace hrp::cases
