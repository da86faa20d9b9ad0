// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/many_drives/legged.h"

#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/evidence/torque/report.h"
#include "diagnosis/floating/fit/servo_fit.h"
#include "diagnosis/floating/log/correct_log.h"
#include "diagnosis/many_drives/legged_torques.h"

namespace hrp::diagnosis::many_drives {
namespace {

using floating::Half;
using floating::LeggedReport;

bool has_drives(const floating::LeggedLog& log) {
  for (size_t j = 0; j < static_cast<size_t>(log.num_joints()); ++j) {
    if (log.is_driven(j)) return true;
  }
  return false;
}

// The logs with the sensors and bodies that were found. Contacts stay as they are.
LeggedLogs correct(const LeggedReport& body, LeggedLogs logs) {
  const floating::ColumnLayout layout(logs.raw);
  for (const Eigen::VectorXd& fault : body.faults) floating::correct_log(layout, fault, &logs.raw);
  if (body.found.size() > 0) floating::correct_links(layout, body.found, &logs.raw);
  return logs;
}

template <class T>
void append(const std::vector<T>& more, std::vector<T>* list) {
  list->insert(list->end(), more.begin(), more.end());
}

// Steps repeat each other, so what comes back with each of them looks like a torque over the joint's position.
void doubt_positions(std::vector<Finding>* findings) {
  for (Finding& f : *findings) {
    if (f.grade != Grade::kSupported || f.family != get_family_name(EffectFamily::kTorqueOverPosition)) continue;
    make_ambiguous(&f);
    f.statement += " Steps repeat each other, so another effect that returns with each step may be the true one.";
  }
}

// Findings of bodies, soles and sensors beside those of joints.
Evidence merge(const LeggedReport& legged, const TorqueVerdict& torque) {
  const Evidence& body = legged.evidence;
  Evidence out = torque.evidence;
  if (legged.walks) doubt_positions(&out.findings);
  out.method = "joints: " + out.method +
               ", with the recorded motion of the base and the forces on its feet; bodies, soles and "
               "sensors: equations in which no drive has a part; errors are shares of each effort's spread";
  append(body.findings, &out.findings);
  sort_findings(&out.findings);
  append(body.mismatch, &out.mismatch);
  append(body.remaining, &out.remaining);
  append(body.not_identifiable, &out.not_identifiable);
  append(body.missing, &out.missing);
  append(body.warnings, &out.warnings);
  fill_torque_fit(torque.torque, &out.fit);
  out.verdict = find_verdict(out);
  return out;
}

}  // namespace

bool diagnose_legged(const Experiment& e, int jobs, const std::function<void(const std::string&)>& progress,
                     Reports* out) {
  LeggedLogs logs{{}, make_legged_log(e, Half::kEven), {}};
  if (!has_drives(logs.smooth)) return false;
  if (!floating::find_servos(e).empty())
    return false;  // joints follow commands by servos that the model lacks: those first
  logs.contacts = find_contacts(logs.smooth);
  logs.raw = make_legged_log(e, Half::kAll);
  const TorqueVerdict alone = judge_torque(make_legged_torques(logs), jobs);
  if (!has_real_drives(alone) && !may_have_real_drives(alone)) return false;
  progress("torques are missing in most joints: first the equations in which no drive has a part");
  LeggedReport body = floating::diagnose_legged(e, progress, floating::Robots::kAll, floating::Drives::kLeftOut);
  // The drives are not completely known, so nothing is certain.
  for (Finding& f : body.evidence.findings) {
    if (f.grade == Grade::kCertain) f.grade = Grade::kSupported;
  }
  progress("missing torque of every joint, with what was found");
  const TorqueVerdict torque = judge_torque(make_legged_torques(correct(body, logs)), jobs);
  if (!has_real_drives(torque)) return false;
  const Evidence evidence = merge(body, torque);
  out->report = make_report(evidence);
  out->series = body.series;
  out->report["model"] =
      list_whole_model(e, torque.model, out->report["findings"], make_report(body.evidence)["findings"]);
  return true;
}

}  // namespace hrp::diagnosis::many_drives
