// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/held_feet/held_feet.h"

#include <algorithm>
#include <cmath>

#include "common/effects/units.h"
#include "diagnosis/data/noise.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/evidence/torque/report.h"
#include "diagnosis/held_feet/foot_give.h"

namespace hrp::diagnosis::held_feet {
namespace {

// Of each joint's missing torque at the kept samples [N m or N]: its high frequencies.
std::vector<double> find_noise(const TorqueData& data) {
  std::vector<double> noise(data.source.size(), 0.0);
  for (size_t j = 0; j < noise.size(); ++j) {
    for (const TorqueRecording& r : data.recordings) {
      std::vector<double> series;
      for (long k = 0; k < r.kept(); ++k)
        series.push_back(r.use(k, static_cast<long>(j)) ? r.missing(k, static_cast<long>(j)) : std::nan(""));
      noise[j] = std::max(noise[j], estimate_noise(series));
    }
  }
  return noise;
}

std::vector<Mismatch> list_mismatch(const TorqueData& data, const std::vector<double>& noise) {
  std::vector<Mismatch> list;
  for (size_t j = 0; j < noise.size(); ++j) {
    for (const TorqueRecording& r : data.recordings) {
      double sum = 0.0, n = 0.0, from = 1e300, to = -1e300;
      for (long k = 0; k < r.kept(); ++k) {
        if (!r.use(k, static_cast<long>(j))) continue;
        sum += std::pow(r.missing(k, static_cast<long>(j)), 2);
        n += 1.0;
        from = std::min(from, r.time(k));
        to = std::max(to, r.time(k));
      }
      const double score = n > 0.0 && noise[j] > 0.0 ? std::sqrt(sum / n) / noise[j] : 0.0;
      if (score > kNoiseLeft)
        list.push_back({data.experiment->signal_name(static_cast<int>(j), Quantity::kEffort),
                        data.experiment->recordings[r.index].spec.name,
                        score,
                        {{from, to}},
                        "foot loaded"});
    }
  }
  return list;
}

// The same give, if it were in one joint: k_joint = lever^2 / compliance.
std::vector<Alternative> list_joints_that_give(const Experiment& e, const FootGive& give) {
  std::vector<Alternative> list;
  for (int j = 0; j < e.num_joints(); ++j) {
    const double lever = give.lever[static_cast<size_t>(j)], k = lever * lever / give.compliance;
    if (!e.robot.tree.joint(j).actuated || lever < 1e-3) continue;
    list.push_back(make_alternative(
        get_effect(EffectId::kElasticity), {{"joint", e.robot.tree.joint(j).name}},
        {make_one("stiffness", get_joint_unit(e.robot.tree.joint(j), "N m/rad"), k, k * give.std / give.compliance)},
        "the foot pressed in another posture"));
  }
  return list;
}

Finding make_finding(const Experiment& e, const LoadedFoot& foot, const FootGive& give) {
  const std::string link = e.robot.tree.frames[static_cast<size_t>(foot.frame)].name;
  const double k = 1.0 / give.compliance, std = give.std * k * k, share = 1.0 - std::pow(give.after / give.before, 2);
  Finding f =
      diagnosis::make_finding(get_effect(EffectId::kFootCompliance), {{"foot", link}}, {make_one("kz", "N/m", k, std)});
  f.grade = give.same_everywhere ? Grade::kSupported : Grade::kAmbiguous;
  f.probability = kSurest;
  f.share = share;
  f.alternatives = list_joints_that_give(e, give);
  f.statement = link + ": the foot or what carries it gives, kz " + number(k, 3) + " +- " +
                number(kNinetyFive * std, 2) + " N/m (" + get_grade_name(f.grade) + "). By the encoders the foot is " +
                number(1e6 * give.compliance, 3) + " um lower for every newton on it. It takes away " +
                number(100.0 * share, 2) + " % of the foot height's variance.";
  return f;
}

void add_gives(const Experiment& e, const std::vector<LoadedFoot>& feet, const std::vector<FootGive>& gives,
               Evidence* evidence) {
  for (const FootGive& give : gives) {
    const Finding f = make_finding(e, feet[give.foot], give);
    evidence->findings.push_back(f);
    evidence->fit.signals.push_back(
        {f.where["foot"].get<std::string>() + " height", "m", give.before, give.after, give.before});
    evidence->remaining.push_back({f.where,
                                   "m",
                                   give.before,
                                   give.after,
                                   {},
                                   f.where["foot"].get<std::string>() + ": of " + number(1e3 * give.before, 3) +
                                       " mm spread of the loaded foot's height, " + number(1e3 * give.after, 3) +
                                       " mm remain."});
  }
}

// noise: by joint of the robot; only joints that moved have an error.
Verdict judge(const Experiment& e, const TorqueVerdict& torque, const std::vector<double>& noise) {
  const Evidence& evidence = torque.evidence;
  bool missing = false, left = false;
  for (const SignalFit& error : torque.torque) {
    for (int j = 0; j < e.num_joints(); ++j) {
      if (error.signal != e.signal_name(j, Quantity::kEffort)) continue;
      const double least = kNoiseLeft * noise[static_cast<size_t>(j)];
      missing = missing || error.before > least;
      left = left || error.after > least;
    }
  }
  if (!missing && evidence.findings.empty()) return Verdict::kNoMismatch;
  if (!left && !evidence.findings.empty()) return Verdict::kExplained;
  return find_verdict(evidence);
}

}  // namespace

bool diagnose_held_feet(const Experiment& e, int jobs, const std::function<void(const std::string&)>& progress,
                        Reports* reports, std::string* why) {
  const std::vector<LoadedFoot> feet = list_loaded_feet(e);
  if (feet.empty()) {
    *why = "no force of a foot is in every recording";
    return false;
  }
  TorqueData data = make_torque_data(e);
  if (progress) progress("inverse dynamics along the recorded motion, with the measured forces on the feet");
  const std::vector<double> noise = find_noise(data);
  const std::vector<Mismatch> mismatch = list_mismatch(data, noise);
  TorqueVerdict torque = judge_torque(std::move(data), jobs);
  const std::vector<FootGive> gives = find_foot_gives(e, feet);
  if (!torque.judged && gives.empty()) {
    *why = torque.evidence.missing.empty() ? "the joints hardly move" : torque.evidence.missing[0];
    return false;
  }
  Evidence& evidence = torque.evidence;
  evidence.method += ", with the measured forces on the feet; errors are shares of each effort's spread";
  fill_torque_fit(torque.torque, &evidence.fit);
  evidence.verdict = judge(e, torque, noise);
  add_gives(e, feet, gives, &evidence);
  evidence.mismatch = mismatch;
  sort_findings(&evidence.findings);
  for (const std::string& text : e.warnings) evidence.warnings.push_back(text);
  reports->report = make_report(evidence);
  reports->report["model"] = list_torque_model(e, torque.model, reports->report["findings"]);
  for (const Json& f : reports->report["findings"]) {
    if (f["where"].contains("foot")) reports->report["model"].push_back(make_model_entry(f));
  }
  reports->series = {{"schema", 1}, {"experiment", e.path}, {"robot", e.robot.tree.name}};
  return true;
}

}  // namespace hrp::diagnosis::held_feet
