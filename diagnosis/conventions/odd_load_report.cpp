// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/odd_load_report.h"

#include <algorithm>

#include "common/base/join_words.h"
#include "common/base/rounding.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/findings/finding_head.h"
#include "diagnosis/measurement/torque/terms.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {

namespace {

// "train_1.csv", or "train_1.csv from 5.2 s on".
std::string describe(const Experiment& e, const LoadedPart& part) {
  std::string name;
  double first = HUGE_VAL, last = -HUGE_VAL;
  for (const Recording& r : e.recordings) {
    if (r.spec.file != part.file) continue;
    name = r.spec.name.substr(0, r.spec.name.find(" ("));  // pieces add their times
    first = std::min(first, r.time.front());
    last = std::max(last, r.time.back());
  }
  if (part.whole) return name;
  const double piece = kDetail * (last - first);  // ends are told to a piece of the file
  const std::string from = part.begin > first + piece ? " from about " + number(part.begin, 3) + " s" : "",
                    until = part.end < last - piece ? " until about " + number(part.end, 3) + " s" : " on";
  return name + from + until;
}

}  // namespace

void add_odd_load(const Experiment& e, const OddLoad& load, Reports* reports) {
  const std::string& link = e.robot.tree.links[static_cast<size_t>(load.link)].name;
  const auto list = [](const Vector3d& v) { return std::vector<double>{v.x(), v.y(), v.z()}; };
  std::vector<std::string> where;
  for (const LoadedPart& part : load.parts) where.push_back(describe(e, part));
  const std::string text = link + ": in " + join_words(where) + " the robot carries " + number(load.mass, 3) + " +- " +
                           number(kNinetyFive * load.std, 2) + " kg more than otherwise.";
  const std::string then =
      load.leave_out ? " All else is judged without this part." : " Errors of these recordings contain it.";
  const Json parameters = {{"mass", make_value(round_to(load.mass, 4), round_to(load.std, 3), "kg")},
                           {"com", make_vector(list(load.com_L), list(load.com_std), "m")}};
  Json finding = make_finding_head(*find_term_row(&TermRow::load).effect, {{"link", link}}, parameters,
                                   Grade::kSupported, load.share);
  finding["statement"] = text + then;
  finding["alternatives"] = Json::array();
  finding["only_in"] = where;
  Json& report = reports->report;
  Json findings = Json::array({finding});
  for (const Json& f : report["findings"]) findings.push_back(f);
  report["findings"] = findings;
  report["warnings"].push_back(text + then);
  reports->series["notes"].push_back(text + then);
}

}  // namespace hrp::diagnosis
