// SPDX-License-Identifier: Apache-2.0
#include "core/humidity.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace gyrotherm {
namespace {

/// Published dew points, rounded to 0.1 K. The last one follows from the pressures over water of Goff and Gratch:
/// 0.1891 hPa at -40 °C, 0.1111 hPa at -45 °C.
TEST(Humidity, ReturnsPublishedDewPoints) {
  struct Row {
    double air_c, humidity_percent, dew_point_c;
  };
  for (const auto& row : {Row{20, 50, 9.3}, Row{25, 60, 16.7}, Row{23, 60, 14.8}, Row{30, 40, 14.9}, Row{25, 100, 25.0},
                          Row{20, 10, -12.6}, Row{-10, 80, -12.8}, Row{-40, 60, -44.8}}) {
    const auto found = dew_point({row.air_c}, row.humidity_percent);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->value, row.dew_point_c, 0.06) << row.air_c << " °C, " << row.humidity_percent << " %";
  }
}

/// Saturation pressures of the reference equations, in hPa. The formula deviates by less than 0.4 %.
TEST(Humidity, ReturnsPublishedSaturationPressures) {
  EXPECT_NEAR(saturation_over_water_hpa({0}), 6.112, 1e-3);
  EXPECT_NEAR(saturation_over_water_hpa({20}), 23.39, 0.08);
  EXPECT_NEAR(saturation_over_water_hpa({60}), 199.5, 0.8);
  EXPECT_NEAR(saturation_over_water_hpa({-20}), 1.256, 0.006);
  EXPECT_NEAR(saturation_over_ice_hpa({-20}), 1.032, 0.002);
  EXPECT_NEAR(saturation_over_ice_hpa({-40}), 0.1285, 0.0005);
}

TEST(Humidity, ReturnsFrostPointBelowZero) {
  EXPECT_DOUBLE_EQ(condensation_point({12.5}).value, 12.5);
  EXPECT_NEAR(condensation_point({0}).value, 0, 1e-9);
  // Published pairs of dew point and frost point.
  EXPECT_NEAR(condensation_point({-12.6}).value, -11.2, 0.1);
  EXPECT_NEAR(condensation_point({-10}).value, -8.9, 0.1);
  EXPECT_NEAR(condensation_point({-20}).value, -18.0, 0.1);
  EXPECT_NEAR(condensation_point({-40}).value, -36.5, 0.2);
}

TEST(Humidity, ConvertsBothWays) {
  for (const double air : {-40.0, -5.0, 20.0, 60.0, 95.0})
    for (const double percent : {1.0, 35.0, 99.0})
      EXPECT_NEAR(relative_humidity_percent({air}, dew_point({air}, percent).value()), percent, 1e-9);
}

TEST(Humidity, RefusesValuesOutsideItsRange) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(dew_point({20}, 0));
  EXPECT_FALSE(dew_point({20}, -1));
  EXPECT_FALSE(dew_point({20}, 106));
  EXPECT_FALSE(dew_point({20}, nan));
  EXPECT_FALSE(dew_point({nan}, 50));
  EXPECT_FALSE(dew_point({-45.1}, 50));
  EXPECT_FALSE(dew_point({100.1}, 50));
  EXPECT_DOUBLE_EQ(dew_point({20}, 104)->value, 20) << "a saturated sensor";
}

}  // namespace
}  // namespace gyrotherm
