// SPDX-License-Identifier: Apache-2.0
/// Humidity of moist air: saturation pressure, dew point and frost point.
///
/// Formula: Magnus, with the coefficients of the Guide to Instruments and Methods of Observation (WMO-No. 8, volume I,
/// annex 4.B) after Sonntag (1990). For a temperature t in °C, the saturation vapour pressure in hPa is
///
///     over water  6.112 exp(17.62 t / (243.12 + t))   −45 … 60 °C
///     over ice    6.112 exp(22.46 t / (272.62 + t))   −65 … 0 °C
///
/// Within these ranges a dew point deviates from the reference equations by less than 0.1 K. Between 60 and 100 °C air
/// temperature the deviation is less than 1 K. The uncertainty of the sensor is larger: ±3 % relative humidity
/// corresponds to ±0.9 K at 50 %, and to ±4 K at 10 %. Relative humidity refers to water at every temperature, as
/// humidity sensors report it. Pure functions; any thread.
#pragma once

#include <optional>

#include "core/quantity.hpp"

namespace gyrotherm {

/// Return the saturation vapour pressure in hPa.
[[nodiscard]] double saturation_over_water_hpa(Celsius temperature);
[[nodiscard]] double saturation_over_ice_hpa(Celsius temperature);

/// Returns the dew point of air with this relative humidity. Returns nothing for air outside −45 … 100 °C, and for a
/// humidity that is not above 0 or is above 105 %. Treats a humidity between 100 and 105 % as 100 %.
[[nodiscard]] std::optional<Celsius> dew_point(Celsius air, double humidity_percent);

/// Returns the relative humidity, in percent, of air with this dew point.
[[nodiscard]] double relative_humidity_percent(Celsius air, Celsius dew_point);

/// Returns the dew point of air with this vapour pressure.
[[nodiscard]] Celsius dew_point_at(double vapour_hpa);

/// Returns the temperature at which air at this vapour pressure is saturated: the dew point, or the frost point if that
/// is below 0 °C.
[[nodiscard]] Celsius saturation_temperature(double vapour_hpa);

/// Returns the temperature below which a surface is covered by dew or frost. Equal to the dew point if that is not
/// below 0 °C, otherwise the frost point, which is higher.
[[nodiscard]] Celsius condensation_point(Celsius dew_point);

}  // namespace gyrotherm
