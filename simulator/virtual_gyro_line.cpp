// SPDX-License-Identifier: Apache-2.0
#include "simulator/virtual_gyro_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gyrotherm::simulator {
namespace {

Result<GyroLineSources::Axis> find_source(const VirtualGyroLine::Axis& wanted, const VirtualLaboratory& laboratory) {
  const auto& units = laboratory.units();
  const auto unit = static_cast<std::size_t>(std::ranges::find(units, wanted.unit) - units.begin());
  if (unit == units.size())
    return failure(FaultKind::usage, "virtual gyro",
                   fmt::format("unit \"{}\" is not one of {}", wanted.unit, fmt::join(units, ", ")));
  const auto& axes = laboratory.axes(unit);
  if (axes.front().empty()) return GyroLineSources::Axis{.unit = unit, .axis = 0};
  const auto axis = static_cast<std::size_t>(std::ranges::find(axes, wanted.axis) - axes.begin());
  if (axis == axes.size())
    return failure(
        FaultKind::usage, "virtual gyro",
        fmt::format("axis \"{}\" of unit \"{}\" is not one of {}", wanted.axis, wanted.unit, fmt::join(axes, ", ")));
  return GyroLineSources::Axis{.unit = unit, .axis = axis};
}

/// Returns the axes of the laboratory's only unit.
std::vector<VirtualGyroLine::Axis> all_axes(const VirtualLaboratory& laboratory) {
  std::vector<VirtualGyroLine::Axis> all;
  if (laboratory.units().size() == 1)
    for (const auto& axis : laboratory.axes()) all.push_back({laboratory.units().front(), axis});
  return all;
}

std::optional<GyroLineSources::Value> find_value(const drivers::FrameField& field,
                                                 const std::vector<std::size_t>& units,
                                                 const VirtualLaboratory& laboratory) {
  const auto find = [&](std::size_t unit, const std::string& prefix, const std::string& name) {
    const auto values = laboratory.values(unit);
    const auto found = std::ranges::find_if(values, [&](const auto& one) { return prefix + one.name == name; });
    const auto value = static_cast<std::size_t>(found - values.begin());
    return found == values.end() ? std::nullopt : std::optional(GyroLineSources::Value{.unit = unit, .value = value});
  };
  for (const auto unit : units)
    if (const auto own = find(unit, laboratory.units()[unit] + "_", field.name)) return own;
  if (const auto plain = find(units.front(), "", field.name)) return plain;
  return field.role == drivers::FieldRole::temperature ? find(units.front(), "", kOwnTemperature) : std::nullopt;
}

}  // namespace

Result<GyroLineSources> find_sources(const VirtualGyroLine& line, const VirtualLaboratory& laboratory) {
  const auto wanted = line.axes.empty() ? all_axes(laboratory) : line.axes;
  if (wanted.empty() || wanted.size() != line.frame.gyros().size())
    return failure(FaultKind::usage, "virtual gyro",
                   fmt::format("the line has {} axes, but its frame has {}", wanted.size(), line.frame.gyros().size()));
  GyroLineSources sources;
  for (const auto& axis : wanted) {
    const auto found = find_source(axis, laboratory);
    if (!found) return failure(found.error());
    sources.axes.push_back(*found);
    if (std::ranges::find(sources.units, found->unit) == sources.units.end()) sources.units.push_back(found->unit);
  }
  for (const auto* field : line.frame.values()) sources.values.push_back(find_value(*field, sources.units, laboratory));
  return sources;
}

PacedGyroLine::PacedGyroLine(VirtualGyroLine line, GyroLineSources sources, FramePace pace, double arcsec_per_pulse,
                             Descriptor listener)
    : sources_(std::move(sources)),
      server_(std::move(listener),
              StreamWriter(pace == FramePace::full_rate ? line.frame : slow_to_one_frame_per_second(line.frame),
                           std::vector(sources_.axes.size(), arcsec_per_pulse)),
              std::move(line.commands)),
      frames_a_second_(pace == FramePace::full_rate && line.frame.rate_hz > 0 ? line.frame.rate_hz : 1),
      sent_(sources_.axes.size()),
      lost_(sources_.axes.size()),
      values_(sources_.values.size(), std::numeric_limits<double>::quiet_NaN()) {}

PacedGyroLine::AxisCounts PacedGyroLine::read_counts(const VirtualLaboratory& laboratory) const {
  AxisCounts counts{.device_time_us = laboratory.device_time_us(sources_.units.front())};
  for (const auto& axis : sources_.axes) counts.pulses.push_back(laboratory.pulses(axis.unit)[axis.axis]);
  return counts;
}

/// Returns whether all units of the line are silent.
bool PacedGyroLine::is_silent(const VirtualLaboratory& laboratory) const {
  return std::ranges::all_of(sources_.units,
                             [&](std::size_t unit) { return laboratory.is_silent(unit) || laboratory.is_off(unit); });
}

/// Updates the sent pulse count of each axis to fraction `share` of the current second.
void PacedGyroLine::count(const VirtualLaboratory& laboratory, double share) {
  const bool all_are_silent = is_silent(laboratory);
  for (std::size_t i = 0; i < sent_.size(); ++i) {
    const auto from = static_cast<double>(before_.pulses[i]);
    const double here = from + share * static_cast<double>(after_.pulses[i] - before_.pulses[i]);
    if (!all_are_silent && laboratory.is_silent(sources_.axes[i].unit))
      lost_[i] = here - sent_[i];
    else
      sent_[i] = here - lost_[i];
  }
}

void PacedGyroLine::gather_values(const VirtualLaboratory& laboratory) {
  for (std::size_t i = 0; i < values_.size(); ++i)
    if (const auto& source = sources_.values[i]) values_[i] = laboratory.values(source->unit)[source->value].value;
}

void PacedGyroLine::send(const VirtualLaboratory& laboratory, double share) {
  ++frames_;
  const bool is_off = std::ranges::all_of(sources_.units, [&](std::size_t unit) { return laboratory.is_off(unit); });
  server_.set_powered(!is_off);
  if (is_off) return serve_clients();
  count(laboratory, share);
  if (is_silent(laboratory)) {
    serve_clients();
    return server_.skip(sent_);
  }
  gather_values(laboratory);
  const double time_us = static_cast<double>(before_.device_time_us) +
                         share * static_cast<double>(after_.device_time_us - before_.device_time_us);
  server_.send(sent_, std::llround(time_us), 1 / frames_a_second_, values_);
}

void PacedGyroLine::skip(const VirtualLaboratory& laboratory) {
  before_ = after_ = read_counts(laboratory);
  count(laboratory, 1);
  server_.skip(sent_);
}

}  // namespace gyrotherm::simulator
