// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/candidate_laws.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/measurement/floating/words.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kRigidTilt = 2e-5;    // [rad/(N m)] of ground and sole that are taken as rigid: above 5e4 N m/rad
constexpr double kRigidHeight = 1e-6;  // [m/N] likewise: a robot of 100 kg sinks by 1 mm
constexpr double kLargestAngle = 0.5;  // [rad] up to which columns of small angles are taken
constexpr double kStiffAxis = 0.5;     // of the give about one axis, by which noise may turn that about the other negative

Estimate make_three(const std::string& name, const std::string& unit, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  Estimate e;
  e.name = name, e.unit = unit, e.vector = true;
  e.value.assign(x.data(), x.data() + x.size()), e.std.assign(std.data(), std.data() + std.size());
  return e;
}

std::vector<Estimate> make_plain(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  const std::vector<EffectParameter>& row = get_effect(c.effect).parameters;
  const auto unit = [&](const EffectParameter& p) { return p.unit.empty() ? c.unit : p.unit; };
  if (x.size() > 1 && row[0].axis >= 0) return {make_three(row[0].name, unit(row[0]), x, std)};
  std::vector<Estimate> out;
  for (long i = 0; i < x.size(); ++i) {
    const EffectParameter& p = row[static_cast<size_t>(i)];
    out.push_back(make_one(p.name, unit(p), (std::isfinite(p.neutral) ? p.neutral : 0) + x(i), std(i)));
  }
  return out;
}

std::vector<Estimate> make_hung(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  const Vector3d com = x.tail<3>() / x(0);
  const Vector3d s = ((std.tail<3>() / x(0)).array().square() + (com * std(0) / x(0)).array().square()).sqrt();
  return {make_one("mass", "kg", x(0), std(0)), make_three("com", "m", com, s)};
}

std::vector<Estimate> make_spring(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  return {make_one("stiffness", "N m/rad", x(0), std(0)),
          make_one("rest", "rad", -x(1) / x(0), std::hypot(std(1), x(1) / x(0) * std(0)) / x(0))};
}

Estimate make_stiffness(const char* name, const char* unit, double give, double std) {
  return make_one(name, unit, 1 / give, std / (give * give));
}

// A give that is not told apart from none has no stiffness to report.
bool is_told(const Eigen::VectorXd& x, const Eigen::VectorXd& std, long at) { return x(at) > 2 * std(at); }

std::vector<Estimate> make_give(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  if (!is_told(x, std, 0)) return {};
  return {make_stiffness("stiffness", "N m/rad", x(0), std(0))};
}

std::vector<Estimate> make_point(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  if (!is_told(x, std, 0)) return {};
  return {make_stiffness("kz", "N/m", x(0), std(0))};
}

std::vector<Estimate> make_bush(const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  std::vector<Estimate> out;
  for (const auto& [axis, give, damp] : {std::tuple("roll", kRollGiveColumn, kRollDampColumn), std::tuple("pitch", kPitchGiveColumn, kPitchDampColumn)}) {
    if (!is_told(x, std, give)) continue;
    out.push_back(make_stiffness((std::string("k_") + axis).c_str(), "N m/rad", x(give), std(give)));
    out.push_back(make_one(std::string("c_") + axis, "N m s/rad", std::max(0.0, x(damp) / x(give)), std(damp) / x(give)));
  }
  if (!is_told(x, std, kSinkColumn)) return out;
  const double z = x(kSinkColumn);
  out.push_back(make_stiffness("kz", "N/m", z, std(kSinkColumn)));
  // A damping that is not told apart from none is left out.
  const double damping = x(kSinkDampColumn) / (z * z), error = std(kSinkDampColumn) / (z * z);
  if (damping > 2 * error) out.push_back(make_one("cz", "N s/m", damping, std::hypot(error, 2 * damping * std(kSinkColumn) / z)));
  return out;
}

bool is_small(const Candidate&, const Eigen::VectorXd& x, double) { return x.norm() < kLargestAngle; }

bool refine_load(const ColumnLayout& layout, const Eigen::VectorXd& x, double reach, Candidate* c) {
  const Vector3d at = x.tail<3>() / x(0);
  if (!at.allFinite() || x(0) <= 0 || at.norm() > reach) return false;
  *c = make_load(*c, layout, at);
  return true;
}

bool refine_moved(const ColumnLayout& layout, const Eigen::VectorXd& x, double reach, Candidate* c) {
  const Vector3d by = x.head<3>();
  if (!by.allFinite() || by.norm() > reach) return false;
  *c = make_moved(*c, layout, by);
  return true;
}

}  // namespace

const CandidateLaw& get_plain_law() {
  static const CandidateLaw law{&make_plain};
  return law;
}

const CandidateLaw& get_angle_law() {
  static const CandidateLaw law{&make_plain, &is_small};
  return law;
}

const CandidateLaw& get_load_law() {
  static const CandidateLaw law{
      &make_hung, [](const Candidate&, const Eigen::VectorXd& x, double reach) { return x.tail<3>().norm() / x(0) < reach; },
      &refine_load};
  return law;
}

const CandidateLaw& get_moved_law() {
  static const CandidateLaw law{
      &make_plain,
      [](const Candidate& c, const Eigen::VectorXd& x, double reach) { return x.norm() < reach && (c.center + x).norm() < c.extent; },
      &refine_moved};
  return law;
}

const CandidateLaw& get_spring_law() {
  static const CandidateLaw law{&make_spring};
  return law;
}

const CandidateLaw& get_give_law() {
  static const CandidateLaw law{&make_give};
  return law;
}

const CandidateLaw& get_bush_law() {
  static const CandidateLaw law{&make_bush, [](const Candidate&, const Eigen::VectorXd& x, double) {
                                  const auto [least, most] = std::minmax(x(kRollGiveColumn), x(kPitchGiveColumn));
                                  return most > kRigidTilt && least > -kRigidTilt;
                                }};
  return law;
}

const CandidateLaw& get_point_law() {
  static const CandidateLaw law{&make_point, [](const Candidate&, const Eigen::VectorXd& x, double) { return x(0) > kRigidHeight; }};
  return law;
}

const CandidateLaw& get_bend_law() {
  static const CandidateLaw law{
      [](const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
        std::vector<Estimate> out;
        for (long i = 0; i < x.size(); ++i) {
          if (is_told(x, std, i)) out.push_back(make_stiffness(i == 0 ? "stiffness" : "other_stiffness", "N m/rad", x(i), std(i)));
        }
        return out;
      },
      [](const Candidate&, const Eigen::VectorXd& x, double) { return x.maxCoeff() > 0 && x.minCoeff() > -kStiffAxis * x.maxCoeff(); }, nullptr,
      "what carries the joint bends about an axis across it"};
  return law;
}

const CandidateLaw& get_pull_law() {
  static const CandidateLaw law{[](const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
                                  const long n = std::min(3L, x.size());
                                  return std::vector<Estimate>{make_three("force", "N", x.head(n), std.head(n))};
                                },
                                nullptr, nullptr, "something from outside pulls here, by where the robot is"};
  return law;
}

const CandidateLaw& get_hold_law() {
  static const CandidateLaw law{[](const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
                                  return std::vector<Estimate>{make_one("force", "N", x(0), std(0))};
                                },
                                nullptr, nullptr, "something holds the foot to the ground that its force sensor does not feel"};
  return law;
}

bool Candidate::is_listed() const { return law->unlisted == nullptr; }

std::vector<Estimate> make_estimates(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  return c.law->make_estimates(c, x, std);
}

bool is_sensible(const Candidate& c, const Eigen::VectorXd& x, double reach) {
  if (!x.allFinite()) return false;
  if (c.positive && x(0) <= 0) return false;
  if (x(0) < c.low || x(0) > c.high) return false;
  return !c.law->is_sensible || c.law->is_sensible(c, x, reach);
}

}  // namespace hrp::diagnosis::floating
