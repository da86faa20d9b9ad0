// SPDX-License-Identifier: BSD-3-Clause
// The one table of effects: physics or a sensor's fault that a model of a robot may lack. Scenario reader, simulator,
// diagnosis, report and documents read it; docs/scenario.md lists what each does.
//
// A row is read by its fields. Nothing may depend on the text of a name or on the order of rows.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

namespace hrp {

struct EffectTarget;  // common/effects/effect_target.h

// Rows that some code mentions by themselves. A row that nobody mentions needs no enumerator: it gets the next number.
enum class EffectId : int {
  kViscous,
  kCoulomb,
  kStribeck,
  kLoadFriction,
  kRotorInertia,
  kElasticity,
  kBacklash,
  kTorqueConstant,
  kSaturation,
  kLag,
  kDelay,
  kSpring,
  kCogging,
  kHysteresis,
  kJointOffset,
  kPayload,
  kMassError,
  kComError,
  kExternalForce,
  kSensorBias,
  kSensorScale,
  kSensorDelay,
  kClockSkew,
  kTiming,       // of the drives' own loops: never reported, fitted along with everything else
  kDriveTiming,  // the same of one drive alone, behind a transmission that gives
  kInertiaError,
  kFootCompliance,
  kFootHardening,
  kGroundSlope,
  kGroundFriction,
  kRestitution,
  kSensorMisalignment,
  kAirDrag,  // never reported: what slows a tossed body beside the ground
  kNamed     // count of the above
};
constexpr EffectId kNoEffect = EffectId::kNamed;  // where an effect may be absent

enum class PlaceKind {
  kJoint,
  kLink,
  kFoot,
  kGround,
  kSensor,
  kNone  // the whole recording
};

// What is claimed when recordings cannot tell the single law.
enum class EffectFamily {
  kDryFriction,
  kSpeedLoss,  // speed-dependent loss
  kReflectedInertia,
  kMass,  // mass and its place
  kGain,
  kTiming,
  kPlay,  // give and play
  kTorqueOverPosition,
  kZero,
  kLimits,
  kContact,
  kSensorGeometry
};
const char* get_family_name(EffectFamily family);  // "dry friction"

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// One number of an effect. A vector is three of them with one name and axes 0, 1, 2.
struct EffectParameter {
  std::string name;
  std::string unit;  // SI; empty: that of the sensor's reading
  int axis = -1;     // of a vector; -1: a number
  // Value at which the effect is absent; NaN: the parameter only shapes the effect.
  double neutral = std::numeric_limits<double>::quiet_NaN();
  double value = 0.0;                              // taken where an optional one is not stated
  double lower = -kUnbounded, upper = kUnbounded;  // beyond them the law means nothing: scenarios are refused
  double low = -1e9, high = 1e9;                   // a search stays within; never beyond lower and upper
  double step = 0.01;                              // natural size: finite differences and first values
  bool required = true;                            // a scenario must state it
  bool stated = true;     // belongs to the effect: a scenario may have it. Else it is of the tool's predictions only
  bool nuisance = false;  // fitted, not reported
  bool scanned = false;   // readings are no smooth function of it: the best of a few values
  bool walked = false;    // fitted, but from the best of the values around
  int not_below = -1;     // index of the parameter that this one is at least
  // Where else a fit may start, because readings are no smooth function of it or have many minima: at factors of the
  // value that was found, at values of such things, and where the rotor of that index swings against its link.
  std::vector<double> start_factors, start_values;
  int swings_with = -1;
  double probe = 0.0;   // a small step from neutral that shows what a residual asks for; 0: none of its own
  bool angle = false;   // in radians, also where the joint slides: a phase
  bool factor = false;  // multiplies: a factor of e either way is as good as impossible beforehand (log-normal prior)
  bool by_direction = false;  // the first parameter is 1 + this times its value forward, 1 - this times it backward

  // For rows to be written in one expression.
  EffectParameter(std::string name_in, std::string unit_in) : name(std::move(name_in)), unit(std::move(unit_in)) {}
  std::string key() const;  // name, with _x, _y or _z for a vector's axis
  EffectParameter& absent_at(double x);
  EffectParameter& bounds(double lower_in, double upper_in);  // of the law, and of the search as far as finite
  EffectParameter& search(double low_in, double high_in);
  EffectParameter& size(double step_in);
  EffectParameter& optional(double value_in);
  EffectParameter& internal();  // not stated; a nuisance
  EffectParameter& as_nuisance();
  EffectParameter& as_scanned();
  EffectParameter& as_walked();
  EffectParameter& as_angle();
  EffectParameter& as_factor();     // absent at 1
  EffectParameter& of_direction();  // a nuisance
  EffectParameter& starts(std::vector<double> factors, std::vector<double> values = {});
  EffectParameter& swings(int rotor);
  EffectParameter& at_least(int index);
  EffectParameter& probed_by(double step_in);
};

// One joint at one instant of a recording.
struct JointSample {
  double q = 0.0, v = 0.0, a = 0.0;        // [rad], [rad/s], [rad/s^2]
  double direction = 0.0;                  // of motion, -1 to 1, smooth through rest
  double effort = 0.0, effort_rate = 0.0;  // [N m], [N m/s] of the drive
};

// What one unit of a sensor's fault adds to its reading: a constant, and in proportion to the reading and to its rate.
struct ReadingChange {
  double constant = 0.0, of_reading = 0.0, of_rate = 0.0;
  bool any() const { return constant != 0.0 || of_reading != 0.0 || of_rate != 0.0; }
};

// A simpler effect that another one contains: for each of its parameters the index in the other; -1: its default.
struct EffectPart {
  EffectId id = kNoEffect;
  std::vector<int> from;
};

// Which simpler effect one has become by its values.
struct SpecialCase {
  EffectId id = kNoEffect;
  std::vector<double> p;
};

// How an effect shows in a joint's missing torque (recorded effort less that of the nominal model along the recorded
// motion), where that is linear: missing = sum of x_i column_i, at fixed shape parameters.
struct TorqueRegressor {
  int num_columns = 0;  // 0: not linear in torque, or no function of one instant
  // Shapes to be tried (values of the shape parameters); none: the law has no shape. With `shape_of_effort` they are
  // shares of the largest effort.
  std::vector<std::vector<double>> shapes;
  bool shape_of_effort = false;
  bool shape_from_data = false;  // shapes have to be found in the data (periods of cogging)
  void (*calc_columns)(const JointSample& sample, const double* shape, double* columns) = nullptr;
  // All parameters from coefficients; false when they make no sense, for instance by their sign.
  bool (*make_parameters)(const double* x, const double* shape, double* p) = nullptr;
  bool shape_of_speed = false;  // the second number of a shape is a share of the largest speed
  // With memory: state behind a small step of the joint [rad] from that before it; the state is the only column.
  double (*advance)(double state, double step, const double* shape) = nullptr;
};

// How a transmission that gives shows beside its rotor: how far the link is behind the rotor under a torque u, with two
// derivatives, for one unit of give. `most`: the largest torque.
struct GiveRegressor {
  void (*calc_give)(double u, double u1, double u2, double most, double* give) = nullptr;
  // All parameters from the rotor's inertia and the units of give.
  void (*make_parameters)(double inertia, double give, double* p) = nullptr;
  // Where to start behind a rotor, from a stiffness that lets it swing.
  void (*start_at)(double inertia, double stiffness, double* p) = nullptr;
};

// Small steps of an effect that is linear in other numbers than its parameters.
struct ProbeSteps {
  std::vector<std::vector<double>> (*list)(double size) = nullptr;     // values of all parameters
  bool (*combine)(const double* x, double size, double* p) = nullptr;  // from how much of each step is asked for
};

struct EffectInfo {
  EffectId id = EffectId::kNamed;
  std::string name;  // in scenarios and reports
  PlaceKind place = PlaceKind::kJoint;
  EffectFamily family = EffectFamily::kZero;
  std::string phrase;  // completes "Joint x: ..."
  std::vector<EffectParameter> parameters;
  // Writes values, in the order of `parameters` (NaN: not stated), into what is at the effect's place.
  void (*apply)(const double* values, const EffectTarget& target) = nullptr;
  TorqueRegressor torque;
  GiveRegressor give;
  ReadingChange change;
  ProbeSteps probe;
  std::vector<EffectPart> parts;
  // `speed`: range of the joint's; `mass`: of the link.
  SpecialCase (*find_special_case)(const double* p, double speed, double mass) = nullptr;
  std::vector<std::vector<double>> start_scales;  // other starts, as factors of all parameters
  void (*normalise)(double* p) = nullptr;         // of values that mean the same, the usual ones
  int periods = -1;                               // index of the parameter that says how often torque repeats [1/rad]
  bool reported = true;                           // false: of the tool's predictions only, no scenario may state it
  bool linear = false;          // predictions are linear in all parameters but those without neutral value
  bool dry = false;             // friction with a dry part of its own: there is one of these in a joint
  bool sticks = false;          // holds a joint at rest: readings are a jagged function of its parameters
  bool flexible = false;        // the link moves against the rotor
  bool smooth = true;           // no friction at rest, memory, play or limit
  bool vector = false;          // one quantity in axes that somebody chose
  bool always_shows = false;    // has no absent value that a fit could come near
  bool of_whole_link = false;   // of the link's own mass: what is lumped into another link cannot have it
  bool by_command = false;      // shows only where a servo follows commands
  bool felt_elsewhere = false;  // at a joint, and moves the links of the whole robot
  int rotor = -1;               // index of the parameter that is a rotor's inertia [kg m^2]
};

// All rows, by number.
const std::vector<EffectInfo>& list_effects();
const EffectInfo& get_effect(EffectId id);
const EffectInfo* find_effect(const std::string& name);                 // null: there is none
int find_parameter(const EffectInfo& effect, const std::string& name);  // the first of that name; -1: none

// The parameters that count at a place that is read as one number: the first axis of each.
const std::vector<EffectParameter>& list_scalar_parameters(EffectId id);

// An effect as a scenario states it; parameters by key.
struct StatedEffect {
  std::string effect;
  std::map<std::string, double> parameters;
};

// What is wrong with a stated effect; no message: nothing.
struct ValueFault {
  std::string parameter, message;
};

// All values in the order of the row, those that are not stated at their defaults.
ValueFault find_values(const EffectInfo& effect, const std::map<std::string, double>& stated,
                       std::vector<double>* values);

// "is 1.2, expected 0 to 1" for a stated value out of its bounds, else empty.
std::string find_fault(const EffectParameter& parameter, double value);

}  // namespace hrp
