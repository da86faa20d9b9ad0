// SPDX-License-Identifier: BSD-3-Clause
// Findings of the tool, from any kind of measurement: findings with grades, remainders, ceiling and verdict. These are
// the contents of report.json, schema 2 (docs/report.md).
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/effects/effect_info.h"

namespace hrp::diagnosis {

// Certainty of a finding, strongest first.
enum class Grade {
  kCertain,    // the model explains the recordings down to the noise, and no other does
  kSupported,  // the effect exists and has this size; other physics may be unknown
  kAmbiguous   // something is missing here, and several effects explain it
};
const char* get_grade_name(Grade grade);

enum class Verdict { kNoMismatch, kExplained, kMostlyExplained, kPartlyExplained, kUnexplained, kNotJudged };
const char* get_verdict_name(Verdict verdict);

// A parameter of an effect with its 95 % interval: one number, or one per axis of a vector.
struct Estimate {
  std::string name;  // in the report: "coefficient", "com"
  std::string unit;
  std::vector<double> value;
  std::vector<double> std;  // contains differences between recordings, halves and regimes; empty: not calculated
  bool vector = false;      // reported as a list even with a single element
  std::vector<std::pair<double, double>> ends = {};  // of the interval, where it does not lie evenly about the value
  bool assumed = false;  // nothing was measured of it: the value is the model's, and std covers every place of a body

  // Nothing of this axis of a vector shows in the recordings: a planar arm does not tell how far a mass is out of its
  // plane.
  bool is_unseen(size_t axis) const {
    return value.size() == 3 && std.size() == 3 && value[axis] == 0.0 && std[axis] == 0.0;
  }
};

// {"joint": "elbow"}, {"link": "hand"}, {"foot": "l_foot"}, {"sensor": "/wrench/l_ankle/force"}, {} for the ground.
using Where = nlohmann::ordered_json;

// An effect that the recordings cannot distinguish from a finding.
struct Alternative {
  std::string effect, family;
  Where where;
  std::vector<Estimate> parameters;
  std::string motion;  // that would distinguish the two
};

struct Finding {
  std::string effect, family;
  Where where;
  std::vector<Estimate> parameters;
  Grade grade = Grade::kSupported;
  double probability = 0.0;  // 0 to 1, that this effect is in the best model
  double share = 0.0;        // of its place's held-out mismatch that it removes
  double weight = 0.0;       // of the whole mismatch; findings are sorted by it
  std::string statement;     // one sentence with value, unit, place and grade
  std::vector<Alternative> alternatives;
  nlohmann::ordered_json also_fitted;  // values that its simulation needs and that nobody judges
};

// A mismatch that no finding explains.
struct Unexplained {
  Where where;
  std::vector<std::string> depends_on;
  std::string statement;
};

// What remains at a place beside all findings.
struct Remaining {
  Where where;
  std::string unit;                     // of before and after: "N m", "rad", "N"
  double before = 0.0, after = 0.0;     // root mean squares, on held-out recordings if there are any
  std::vector<std::string> depends_on;  // position, velocity, load, ...; empty: none of the tested ones
  std::string statement;
  double share() const { return before > 0.0 ? after * after / (before * before) : 0.0; }
};

// A mismatch of the nominal model at a place and time.
struct Mismatch {
  std::string signal, recording;
  double score = 0.0;                                // in units of the signal's noise
  std::vector<std::pair<double, double>> intervals;  // [s]
  std::string regime;
  std::string equation = {};  // empty: the signal itself is predicted
};

// An effect or parameter that the recordings do not determine, and a motion that would.
struct NotIdentifiable {
  std::string effect;
  Where where;  // null: the whole robot
  std::string why, motion;
};

// Errors of the prediction of one signal: root mean squares in `unit`. Without a unit only their ratios to the spread
// are told.
struct SignalFit {
  std::string signal, unit;
  double before = 0.0, after = 0.0;
  double spread = 0.0;        // standard deviation of the recording
  std::string equation = {};  // as in Mismatch
};

// Errors of the prediction, before and after the findings.
struct Fit {
  double train_before = 0.0, train_after = 0.0;
  double validate_before = 0.0, validate_after = 0.0;  // the same on held-out recordings
  std::vector<SignalFit> signals;
  bool over_spread = false;  // errors are over each effort's spread, else over each signal's noise
};

// One number with its deviation.
Estimate make_one(const std::string& name, const std::string& unit, double value, double std);
// A load's centre [m, link] that the recordings do not tell; `p` is the link's own.
Estimate make_assumed_centre(const Eigen::Vector3d& p);

// What every finding and every alternative says of an effect; grade, share and words are the caller's. `motion` would
// tell the alternative from the finding.
Finding make_finding(const EffectInfo& effect, const Where& where, std::vector<Estimate> parameters);
Alternative make_alternative(const EffectInfo& effect, const Where& where, std::vector<Estimate> parameters,
                             const std::string& motion);

struct Evidence {
  Verdict verdict = Verdict::kNotJudged;
  std::string summary;  // of a report without findings: what was compared, or why nothing was
  std::vector<Mismatch> mismatch;
  std::vector<Finding> findings;
  std::vector<Unexplained> unexplained;  // beside the places that remain
  std::vector<Remaining> remaining;
  std::vector<NotIdentifiable> not_identifiable;
  double ceiling = 0.0;    // share (0 to 1) of the mismatch that the recorded signals can predict at all
  double explained = 0.0;  // share of the held-out mismatch that the findings remove
  Fit fit;
  std::string method;                // of the prediction
  double horizon = 0.0;              // [s] 0: sample by sample
  std::vector<std::string> missing;  // "l_foot.csv: no column /wrench/l_sole/torque/x: centre of pressure not compared"
  std::vector<std::string> warnings;
};

// Lowers the grade, in the statement, too.
void make_ambiguous(Finding* finding);
std::string say_ambiguous(std::string statement);

// Sorts by weight, largest first; for equal weights certain, supported, ambiguous.
void sort_findings(std::vector<Finding>* findings);

// Verdict if noise is not reached: `mostly_explained` from 80 % of the ceiling on, otherwise partly or not at all.
Verdict find_verdict(const Evidence& evidence);
// The same of a search for single effects.
Verdict find_verdict(bool mismatch, bool explained, bool partly);

// Adds to the verdict of a report that a log or a model was put right before. In converted recordings nothing was
// missing, or something that has no name: with what counts otherwise, the recordings are explained down to their noise,
// or partly.
void add_to_verdict(nlohmann::ordered_json* report);

// The report (report.json, schema 2). Findings must be sorted.
nlohmann::ordered_json make_report(const Evidence& evidence);
nlohmann::ordered_json make_alternatives(const std::vector<Alternative>& alternatives);
nlohmann::ordered_json make_fit(const Fit& fit);
nlohmann::ordered_json make_estimate(const Estimate& estimate);
nlohmann::ordered_json make_estimates(const std::vector<Estimate>& parameters);

}  // namespace hrp::diagnosis
