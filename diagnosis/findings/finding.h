// SPDX-License-Identifier: BSD-3-Clause
// What the tool says of a robot, whichever measurement it comes from: findings with grades, what remains, the ceiling
// and the verdict. This is report.json, schema 2 (docs/report.md).
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace hrp::diagnosis {

// How far a finding may be trusted, strongest first.
enum class Grade {
  kCertain,    // the model explains the recordings down to their noise, and nothing else does
  kSupported,  // the physics is there and this is its size, though not all around it is known
  kAmbiguous   // something is missing here that one of several effects describes
};
const char* get_grade_name(Grade grade);

enum class Verdict { kNoMismatch, kExplained, kMostlyExplained, kPartlyExplained, kUnexplained, kNotJudged };
const char* get_verdict_name(Verdict verdict);

// A parameter of an effect with its 95 % interval: one number, or one for each axis of a vector.
struct Estimate {
  std::string name;  // of the report: "coefficient", "com"
  std::string unit;
  std::vector<double> value;
  std::vector<double> std;  // with what recordings, halves and regimes differ by
  bool vector = false;      // reported as a list even when it has one element
};

// {"joint": "elbow"}, {"link": "hand"}, {"foot": "l_foot"}, {"sensor": "/wrench/l_ankle/force"}, {} for the ground.
using Where = nlohmann::ordered_json;

// An effect that the recordings cannot tell from a finding.
struct Alternative {
  std::string effect, family;
  Where where;
  std::vector<Estimate> parameters;
  std::string motion;  // that would tell the two apart
};

struct Finding {
  std::string effect, family;
  Where where;
  std::vector<Estimate> parameters;
  Grade grade = Grade::kSupported;
  double probability = 0.0;  // 0 to 1, that this effect is in the best model
  double share = 0.0;        // of its place's held-out mismatch that goes away with it
  double weight = 0.0;       // of the whole mismatch; findings are sorted by it
  std::string statement;     // one sentence with value, unit, place and grade
  std::vector<Alternative> alternatives;
};

// What is left at a place after everything that was found.
struct Remaining {
  Where where;
  std::string unit;                       // of before and after: "N m", "rad", "N"
  double before = 0.0, after = 0.0;       // root mean squares, held-out recordings where there are some
  std::vector<std::string> depends_on;    // position, velocity, load, ...; empty: none of those that were tried
  std::string statement;
  double share() const { return before > 0.0 ? after * after / (before * before) : 0.0; }
};

// A mismatch at a place and time, before anything is added.
struct Mismatch {
  std::string signal, recording;
  double score = 0.0;  // in units of the signal's noise
  std::vector<std::pair<double, double>> intervals;  // [s]
  std::string regime;
};

struct NotIdentifiable {
  std::string effect;
  Where where;
  std::string why, motion;
};

// How well one signal is predicted, root mean squares in `unit`.
struct SignalFit {
  std::string signal, unit;
  double before = 0.0, after = 0.0;
  double spread = 0.0;  // standard deviation of the recording
};

struct Fit {
  double train_before = 0.0, train_after = 0.0;        // over each signal's noise
  double validate_before = 0.0, validate_after = 0.0;  // the same, recordings that nothing was fitted to
  std::vector<SignalFit> signals;
};

struct Evidence {
  Verdict verdict = Verdict::kNotJudged;
  std::string summary;  // of a report without findings: what was compared, or why nothing was
  std::vector<Mismatch> mismatch;
  std::vector<Finding> findings;
  std::vector<Remaining> remaining;
  std::vector<NotIdentifiable> not_identifiable;
  double ceiling = 0.0;    // share of the mismatch that can be predicted at all from what was recorded, 0 to 1
  double explained = 0.0;  // share of the mismatch that the findings take away on held-out recordings
  Fit fit;
  std::string method;    // how readings are predicted
  double horizon = 0.0;  // [s] 0: sample by sample
  std::vector<std::string> missing;   // "l_foot.csv: no column /wrench/l_sole/torque/x: centre of pressure not compared"
  std::vector<std::string> warnings;
};

// By weight, largest first; certain before supported before ambiguous where weights are equal.
void sort_findings(std::vector<Finding>* findings);

// `mostly_explained` from 80 % of the ceiling on, else partly or not at all; for evidence that is not down to the noise.
Verdict find_verdict(const Evidence& evidence);

// report.json, schema 2. Findings must be sorted.
nlohmann::ordered_json make_report(const Evidence& evidence);
nlohmann::ordered_json make_alternatives(const std::vector<Alternative>& alternatives);
nlohmann::ordered_json make_fit(const Fit& fit);
nlohmann::ordered_json make_estimates(const std::vector<Estimate>& parameters);

}  // namespace hrp::diagnosis
