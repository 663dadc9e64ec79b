#include "server/jobs/new_calibration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"

namespace axiscal::jobs {
namespace {

// A map of EYC over C with nodes of 3, -4 and 12 um, sigmas of 0.3, 0.4 and 0.5 um, the last two going together by 0.5.
class MapInCalibration : public ::testing::Test {
 protected:
  MapInCalibration() {
    input.machine = machine::testing::TiltingTable();
    result.model = machine::ReadErrors(R"({"terms": [{"symbol": "EYC", "shape": "tabulated", "variable": "C",
        "nodes_deg": [0, 60, 120], "values": [3, -4, 12]}]})",
                                       input.machine)
                       .value();
    const double sigma_um[] = {0.3, 0.4, 0.5};
    const double value_um[] = {3, -4, 12};
    for (size_t i = 0; i < result.model.terms.size(); ++i) {
      identify::Estimate estimate;
      estimate.name = machine::NameOf(input.machine, result.model.terms[i]);
      estimate.unit = "um";
      estimate.factor = 1e-3;
      estimate.value = value_um[i] * 1e-3;
      estimate.sigma = sigma_um[i] * 1e-3;
      estimate.identifiable = true;
      result.covariance.of.push_back(estimate.name);
      result.covariance.sigma.push_back(sigma_um[i]);
      result.estimates.push_back(estimate);
    }
    result.covariance.correlation = Eigen::Matrix3d::Identity();
    result.covariance.correlation(2, 1) = result.covariance.correlation(1, 2) = 0.5;
  }
  // The estimate whose symbol ends so.
  records::Estimate Of(const std::string& ending) const {
    records::Estimate found;
    for (const records::Estimate& one : MakeCalibration(input, {}, {}, result, {}).estimates)
      if (one.symbol.ends_with(ending)) found = one;
    return found;
  }

  MachineInput input;
  identify::Result result;
};

TEST_F(MapInCalibration, IsFollowedByItsRmsAndItsLargestNode) {
  const records::Estimate rms = Of(":tabulated.rms"), largest = Of(":tabulated.max");
  EXPECT_EQ(rms.symbol, "EYC:tabulated.rms");
  // Root of (9 + 16 + 144) / 3; its slopes are value / (3 rms), the cross term 2 x 0.5 x 0.4 x 0.5 x (-4) x 12.
  EXPECT_NEAR(rms.value.value(), std::sqrt(169.0 / 3.0), 1e-9);
  const double squares = 9 * 0.09 + 16 * 0.16 + 144 * 0.25 - 2 * 0.5 * 0.4 * 0.5 * 48;
  EXPECT_NEAR(rms.sigma.value(), std::sqrt(squares) / std::sqrt(3.0 * 169.0), 1e-9);
  EXPECT_NEAR(largest.value.value(), 12.0, 1e-9);
  EXPECT_NEAR(largest.sigma.value(), 0.5, 1e-9);
}

TEST_F(MapInCalibration, HasNoSizeWhereANodeHasNoNumber) {
  result.estimates[1].identifiable = false;
  const records::Estimate rms = Of(":tabulated.rms");
  EXPECT_EQ(rms.symbol, "EYC:tabulated.rms");
  EXPECT_FALSE(rms.identifiable);
  EXPECT_FALSE(rms.value.has_value());
}

}  // namespace
}  // namespace axiscal::jobs
