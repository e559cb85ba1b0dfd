// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/series_channels.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "acquisition/record/row.hpp"

namespace gyrotherm::monitor {
namespace {

std::string quoted(const std::string& name) { return '"' + name + '"'; }

SeriesChannel channel_of_chamber(const char* column) { return {column, "°C", {}, quoted(column)}; }

/// The rate about an axis as it was read, Earth rate included.
SeriesChannel rate_of(const record::ChannelColumn& column, const record::UnitInfo& unit, const std::string& interval) {
  const auto& axis = unit.axes[column.index];
  constexpr std::size_t kPulses = 6;  // "pulses" at the name's end
  auto name = column.name.substr(0, column.name.size() - std::min(kPulses, column.name.size())) + "rate";
  const bool counts = axis.kind == record::GyroKind::pulse_count;
  auto sql = counts ? fmt::format("{} * {:.17e} / nullif({}, 0)", quoted(column.name), axis.scale * 1e9, interval)
                    : fmt::format("{} * {:.17e}", quoted(column.name), axis.scale);
  return {std::move(name), "°/h", unit.name, std::move(sql)};
}

}  // namespace

std::vector<SeriesChannel> series_channels(const record::RunInfo& info) {
  std::vector<SeriesChannel> channels{channel_of_chamber("set_point_c"), channel_of_chamber("chamber_air_c"),
                                      channel_of_chamber("chamber_set_point_c")};
  const auto columns = record::channel_columns(info);
  for (const auto& column : columns) {
    switch (column.measures) {
      case record::Measures::temperature: {
        const auto& thermometer = info.thermometers[column.index];
        channels.push_back({column.name, thermometer.unit, thermometer.unit_under_test, quoted(column.name)});
        break;
      }
      case record::Measures::rotation: {
        const auto interval = std::ranges::find_if(columns, [&](const auto& other) {
          return other.measures == record::Measures::interval && other.unit == column.unit;
        });
        if (interval != columns.end())
          channels.push_back(rate_of(column, info.units[column.unit], quoted(interval->name)));
        break;
      }
      case record::Measures::value: {
        const auto& unit = info.units[column.unit];
        channels.push_back({column.name, unit.values[column.index].unit, unit.name, quoted(column.name)});
        break;
      }
      case record::Measures::true_bias:
        if (info.simulated) channels.push_back({column.name, "°/h", info.units[column.unit].name, quoted(column.name)});
        break;
      case record::Measures::interval: break;
    }
  }
  return channels;
}

}  // namespace gyrotherm::monitor
