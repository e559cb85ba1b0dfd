// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/exported_columns.hpp"

namespace gyrotherm::exchange {

std::vector<double> temperatures_of(const record::Record& record, std::size_t thermometer) {
  std::vector<double> temperatures = record.thermometers_c[thermometer];
  for (double& temperature : temperatures)
    temperature = record::calibrated(record.info.thermometers[thermometer], {temperature}).value;
  return temperatures;
}

std::vector<double> rates_of(const record::Record& record, std::size_t unit, std::size_t axis) {
  const record::AxisInfo& info = record.info.units[unit].axes[axis];
  const record::UnitColumns& columns = record.units[unit];
  std::vector<double> rates = columns.rotation[axis];
  for (std::size_t row = 0; row < rates.size(); ++row)
    rates[row] *= info.kind == record::GyroKind::rate ? info.scale : info.scale / columns.interval_s[row];
  return rates;
}

}  // namespace gyrotherm::exchange
