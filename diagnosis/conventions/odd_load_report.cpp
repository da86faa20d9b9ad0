// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/odd_load_report.h"

#include "common/base/rounding.h"
#include "common/effects/effect_info.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/report/finding_head.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {

void add_odd_load(const Experiment& e, const OddLoad& load, Reports* reports) {
  const std::string& link = e.robot.tree.links[static_cast<size_t>(load.link)].name;
  const auto list = [](const Vector3d& v) { return std::vector<double>{v.x(), v.y(), v.z()}; };
  const std::string text = link + ": in " + load.file + " the robot carries " + number(load.mass, 3) + " +- " + number(kNinetyFive * load.std, 2) +
                           " kg more than in the other recordings.";
  const std::string then = load.leave_out ? " All else is judged without this recording." : " Errors of this recording contain it.";
  const Json parameters = {{"mass", make_value(round_to(load.mass, 4), round_to(load.std, 3), "kg")},
                           {"com", make_vector(list(load.com_L), list(load.com_std), "m")}};
  Json finding = make_finding_head(get_effect(EffectId::kPayload), {{"link", link}}, parameters, Grade::kSupported, load.share);
  finding["statement"] = text + then;
  finding["alternatives"] = Json::array();
  finding["only_in"] = {load.file};
  Json& report = reports->report;
  Json findings = Json::array({finding});
  for (const Json& f : report["findings"]) findings.push_back(f);
  report["findings"] = findings;
  report["warnings"].push_back(text + then), reports->series["notes"].push_back(text + then);
}

}  // namespace hrp::diagnosis
