// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/fit/law_values.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/report/words.h"
#include "diagnosis/standing/sole.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kCentreHeight = 0.02;  // [m] of the point about which a sole turns, over or below its face

Estimate make_three(const std::string& name, const std::string& unit, const Eigen::VectorXd& x,
                    const Eigen::VectorXd& std) {
  Estimate e;
  e.name = name;
  e.unit = unit;
  e.vector = true;
  e.value.assign(x.data(), x.data() + x.size());
  e.std.assign(std.data(), std.data() + std.size());
  return e;
}

Estimate make_stiffness(const char* name, const char* unit, double give, double std) {
  return make_one(name, unit, 1 / give, std / (give * give));
}

// A give that is not told apart from none has no stiffness to report.
bool is_told(const Eigen::VectorXd& x, const Eigen::VectorXd& std, long at) { return x(at) > kAboveNoise * std(at); }

}  // namespace

Estimates make_plain(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  const std::vector<EffectParameter>& row = c.info().parameters;
  const auto unit = [&](const EffectParameter& p) { return p.unit.empty() ? c.unit : p.unit; };
  if (x.size() > 1 && row[0].axis >= 0) return {make_three(row[0].name, unit(row[0]), x, std)};
  Estimates out;
  for (long i = 0; i < x.size(); ++i) {
    const EffectParameter& p = row[static_cast<size_t>(i)];
    out.push_back(make_one(p.name, unit(p), (std::isfinite(p.neutral) ? p.neutral : 0) + x(i), std(i)));
  }
  return out;
}

Estimates make_reading_scale(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  const double factor = 1 / (1 + x(0));
  return {make_value(c.info(), factor, std(0) * factor * factor)};
}

Estimates make_payload(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  const Vector3d com = x.tail<3>() / x(0);
  const Vector3d s = ((std.tail<3>() / x(0)).array().square() + (com * std(0) / x(0)).array().square()).sqrt();
  return {make_one("mass", "kg", x(0), std(0)), make_three("com", "m", com, s)};
}

Estimates make_spring(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  return {make_one("stiffness", "N m/rad", x(0), std(0)),
          make_one("rest", "rad", -x(1) / x(0), std::hypot(std(1), x(1) / x(0) * std(0)) / x(0))};
}

Estimates make_elasticity(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  if (!is_told(x, std, 0)) return {};
  return {make_stiffness("stiffness", "N m/rad", x(0), std(0))};
}

Estimates make_point_foot(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  if (!is_told(x, std, 0)) return {};
  return {make_stiffness("kz", "N/m", x(0), std(0))};
}

Estimates make_flat_sole(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  Estimates out;
  for (const auto& [axis, give, damp] : {std::tuple("roll", kRollGiveColumn, kRollDampColumn),
                                         std::tuple("pitch", kPitchGiveColumn, kPitchDampColumn)}) {
    if (!is_told(x, std, give)) continue;
    out.push_back(make_stiffness((std::string("k_") + axis).c_str(), "N m/rad", x(give), std(give)));
    out.push_back(
        make_one(std::string("c_") + axis, "N m s/rad", std::max(0.0, x(damp) / x(give)), std(damp) / x(give)));
  }
  if (!is_told(x, std, kSinkColumn)) return out;
  const double z = x(kSinkColumn);
  out.push_back(make_stiffness("kz", "N/m", z, std(kSinkColumn)));
  // A damping that is not told apart from none is left out.
  const double damping = x(kSinkDampColumn) / (z * z), error = std(kSinkDampColumn) / (z * z);
  if (damping > kAboveNoise * error)
    out.push_back(make_one("cz", "N s/m", damping, std::hypot(error, 2 * damping * std(kSinkColumn) / z)));
  return out;
}

Estimates make_bend(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  Estimates out;
  for (long i = 0; i < x.size(); ++i) {
    if (is_told(x, std, i))
      out.push_back(make_stiffness(i == 0 ? "stiffness" : "other_stiffness", "N m/rad", x(i), std(i)));
  }
  return out;
}

Estimates make_pull(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  const long n = std::min(3L, x.size());
  return {make_three("force", "N", x.head(n), std.head(n))};
}

Estimates make_hold(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  return {make_one("force", "N", x(0), std(0))};
}

bool is_small_angle(const Candidate&, const Eigen::VectorXd& x) { return x.norm() < kLargestAngle; }

bool is_payload_near(const Candidate&, const Eigen::VectorXd& x) { return x.tail<3>().norm() / x(0) < kReach; }

bool is_mass_within_link(const Candidate& c, const Eigen::VectorXd& x) {
  return x.norm() < kReach && (c.center + x).norm() < c.extent;
}

bool is_soft_sole(const Candidate&, const Eigen::VectorXd& x) {
  const auto [least, most] = std::minmax(x(kRollGiveColumn), x(kPitchGiveColumn));
  return most > standing::kRigidTilt && least > -standing::kRigidTilt;
}

bool is_soft_point(const Candidate&, const Eigen::VectorXd& x) { return x(0) > kRigidHeight; }

// A transmission does not turn by radians: it gives less than its prior.
bool is_stiff_enough(const Candidate& c, const Eigen::VectorXd& x) { return c.prior.empty() || x(0) < c.prior[0]; }

bool is_bend(const Candidate&, const Eigen::VectorXd& x) {
  // Noise may make the give about one axis negative.
  return x.maxCoeff() > 0 && x.minCoeff() > -kHalf * x.maxCoeff();
}

bool refine_payload(const ColumnLayout& layout, const Eigen::VectorXd& x, Candidate* c) {
  if (!x.allFinite() || x(0) <= 0) return false;
  const std::vector<double> prior = make_place_prior(x(0));
  const bool known = c->prior.size() == prior.size() && std::abs(c->prior[1] - prior[1]) < kTrace * prior[1];
  c->prior = prior;
  const Vector3d at = x.tail<3>() / x(0);
  if (at.norm() > kReach) return !known;
  *c = make_load(*c, layout, at);
  return true;
}

// A person's push leans a robot with a force in proportion to the moment of its soles. Their gives are told all the
// same, because the point about which a sole turns is near its face.
bool refine_sole(const ColumnLayout&, const Eigen::VectorXd& x, Candidate* c) {
  if (!x.allFinite()) return false;
  bool changed = false;
  for (const auto& [give, shift] :
       {std::pair(kRollGiveColumn, kRollShiftColumn), std::pair(kPitchGiveColumn, kPitchShiftColumn)}) {
    double& height = c->prior[static_cast<size_t>(shift) + 1];
    const double about = std::max(standing::kRigidTilt, std::abs(x(give))) * kCentreHeight;
    if (std::abs(about - height) < kMinority * height) continue;
    height = about;
    changed = true;
  }
  return changed;
}

bool refine_moved_mass(const ColumnLayout& layout, const Eigen::VectorXd& x, Candidate* c) {
  const Vector3d by = x.head<3>();
  if (!by.allFinite() || by.norm() > kReach) return false;
  *c = make_moved(*c, layout, by);
  return true;
}

}  // namespace hrp::diagnosis::floating
