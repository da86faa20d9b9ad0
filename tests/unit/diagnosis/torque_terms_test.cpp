// SPDX-License-Identifier: BSD-3-Clause
// Terms of the missing torque and of standing robots' equations refer to rows of the table of effects.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "diagnosis/findings/families.h"
#include "diagnosis/measurement/torque/terms.h"
#include "diagnosis/standing/effects.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

constexpr double kRounding = 1e-12;  // of quotients and roots of numbers near one

// Coefficients that make sense in every row: the first positive, all different.
Eigen::VectorXd make_coefficients(const TermRow& row) {
  Eigen::VectorXd x(row.columns);
  for (long c = 0; c < x.size(); ++c) x[c] = 0.4 + 0.1 * static_cast<double>(c);
  return x;
}

TEST(TorqueTerms, CoefficientsComeBackFromTheParametersThatAReportSays) {
  for (const TermRow& row : list_term_rows()) {
    if (row.excess || row.scales_model || (row.make_values && !row.make_coefficients))
      continue;  // reported with another, or not
    // The report of a limit says its shape alone. All of the effort beyond it is missing.
    const Eigen::VectorXd x = row.shape_parameter == 0 ? Eigen::VectorXd::Ones(row.columns) : make_coefficients(row);
    std::vector<double> values = calc_values({&row, 0, 7.0}, x, 0.1 * x).value;
    EXPECT_LE(values.size(), row.effect->parameters.size()) << row.effect->name;
    EXPECT_NEAR((calc_coefficients(row, values) - x).norm(), 0.0, kRounding) << row.effect->name;
  }
}

TEST(TorqueTerms, AGainIsToldFromEitherSideByTheSameParameter) {
  const TermRow &effort = find_term_row(&TermRow::scales_effort), &model = find_term_row(&TermRow::scales_model);
  EXPECT_EQ(effort.effect, model.effect);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(1);
  for (double k : {0.8, 1.0, 1.3}) {
    EXPECT_NEAR(calc_values({&effort}, Eigen::VectorXd::Constant(1, 1.0 - k), none).value[0], k, kRounding);
    EXPECT_NEAR(calc_values({&model}, Eigen::VectorXd::Constant(1, 1.0 / k - 1.0), none).value[0], k, kRounding);
  }
}

TEST(TorqueTerms, TermsOfTheWholeRobotFillRowsAndTermsOfAJointHaveColumns) {
  for (const TermRow& row : list_term_rows()) {
    EXPECT_EQ(row.whole, row.fill_columns != nullptr) << row.effect->name;
    EXPECT_NE(row.whole, row.calc_columns != nullptr) << row.effect->name;
    EXPECT_GT(row.cost, 0.0) << row.effect->name;
  }
}

// A humanoid that moves one arm: no joint feels the mass of the other one.
TEST(TorqueTerms, OnlyLinksThatAJointCarriesWhoseSamplesAreUsedHaveAMassToFind) {
  const Experiment e = simulate_arm("terms_of_links", make_arm_drives());
  TorqueData data = make_torque_data(e);
  for (TorqueRecording& r : data.recordings) r.use.col(kShoulder) = false;
  std::set<int> links;
  for (const Term& term : list_whole_terms(data)) {
    if (term.row->place == PlaceKind::kLink) links.insert(term.place);
  }
  EXPECT_EQ(links, std::set<int>{kFore});
}

TEST(Families, OneEffectIsAskedForByItsPlaceAndWhatItIs) {
  EXPECT_EQ(get_effect_of(PlaceKind::kJoint, EffectFamily::kGain).name, "torque_constant_error");
  EXPECT_EQ(get_effect_of(PlaceKind::kSensor, EffectFamily::kGain).name, "sensor_scale");
  EXPECT_ANY_THROW(get_effect_of(PlaceKind::kJoint, EffectFamily::kPlay));  // elastic, or with play
}

}  // namespace
}  // namespace hrp::diagnosis
