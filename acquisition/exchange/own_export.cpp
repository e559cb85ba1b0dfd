// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/own_export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "acquisition/exchange/column_names.hpp"
#include "acquisition/exchange/table_sample.hpp"
#include "acquisition/record/csv.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr std::string_view kCelsius = "°C";

/// A title "name [unit]" in two parts.
struct Title {
  std::string name{}, unit{};
};

Title split_title(const std::string& title) {
  const auto bracket = title.rfind(" [");
  if (bracket == std::string::npos || !title.ends_with(']')) return {title, ""};
  return {title.substr(0, bracket), title.substr(bracket + 2, title.size() - bracket - 3)};
}

/// Removes the beginning and the end of a text. Returns nothing if it has others.
std::optional<std::string> text_between(std::string_view text, std::string_view beginning, std::string_view end) {
  if (text.size() <= beginning.size() + end.size() || !text.starts_with(beginning) || !text.ends_with(end))
    return std::nullopt;
  return std::string(text.substr(beginning.size(), text.size() - beginning.size() - end.size()));
}

/// Returns the text after "NAME: KEY " in a comment "KIND NAME: KEY TEXT"; nothing if no comment has it.
std::optional<std::string> find_in_comments(const std::vector<std::string>& comments, const std::string& beginning) {
  for (const auto& comment : comments)
    if (comment.starts_with(beginning)) return comment.substr(beginning.size());
  return std::nullopt;
}

OwnColumns::Thermometer make_thermometer(const std::string& name, const std::string& column,
                                         const std::vector<std::string>& comments) {
  OwnColumns::Thermometer thermometer{.name = name, .column = column};
  if (const auto offset = find_in_comments(comments, "thermometer " + name + ": offset "))
    thermometer.offset = record::number_in(*offset).value_or(0);
  const auto polynomial = find_in_comments(comments, "thermometer " + name + ": polynomial ");
  if (!polynomial) return thermometer;
  std::vector<double> terms;
  std::vector<record::Field> fields;
  if (record::split_line(*polynomial, ' ', fields))
    for (const auto& field : fields) terms.push_back(record::number_in(field.text).value_or(0));
  terms.resize(std::max<std::size_t>(terms.size(), 2));
  thermometer.offset = terms[0];
  thermometer.scale = terms[1];
  thermometer.is_nonlinear = std::any_of(terms.begin() + 2, terms.end(), [](double term) { return term != 0; });
  return thermometer;
}

/// Returns the part of a label before its last point.
std::string_view label_prefix(std::string_view label) { return label.substr(0, label.rfind('.')); }

/// Returns the title with the counting times of an axis; empty if there is none.
std::string find_interval(const std::vector<std::string>& titles, std::string_view axis_label) {
  const auto title = fmt::format("{} interval [s]", label_prefix(axis_label));
  return std::ranges::find(titles, title) == titles.end() ? "" : title;
}

/// Splits a list of thermometers: "A, B". Returns nothing if the table does not have all of them.
std::vector<std::string> split_thermometers(std::string_view list, const OwnColumns& columns) {
  std::vector<record::Field> fields;
  std::vector<std::string> names;
  if (list.empty() || !record::split_line(list, ',', fields)) return names;
  for (const auto& field : fields) {
    names.emplace_back(field.text);
    if (std::ranges::find(columns.thermometers, names.back(), &OwnColumns::Thermometer::name) ==
        columns.thermometers.end())
      return {};
  }
  return names;
}

/// Returns the axis of a title such as "u1.x [0.1 °/h]" or "gyro [pulses of 0.1 arcsec]"; nothing for other titles.
std::optional<OwnColumns::Axis> parse_axis(const std::string& title, const std::vector<std::string>& comments) {
  const auto [label, unit] = split_title(title);
  const auto pulses = text_between(unit, "pulses of ", " arcsec");
  const auto scale = pulses ? pulses : text_between(unit, "", " °/h");
  if (!scale || !record::number_in(*scale)) return std::nullopt;
  OwnColumns::Axis axis{.label = label,
                        .column = title,
                        .kind = pulses ? record::GyroKind::pulse_count : record::GyroKind::rate,
                        .scale = *scale};
  const auto constants = find_in_comments(comments, "axis " + label + ": ").value_or("");
  constexpr std::string_view kEarthRate = ", earth rate ";
  if (const auto at = constants.find(kEarthRate); at != std::string::npos)
    axis.earth_rate = constants.substr(at + kEarthRate.size());
  return axis;
}

std::string axis_text(const OwnColumns::Axis& axis) {
  const bool is_increment = axis.kind == record::GyroKind::pulse_count;
  auto text =
      fmt::format("column = {}\nkind = \"{}\"\nscale = {}        # {} per unit of the column\n", toml_text(axis.column),
                  is_increment ? "increment" : "rate", axis.scale, is_increment ? "arcsec" : "°/h");
  if (!axis.earth_rate.empty()) text += fmt::format("earth_rate = {}\n", axis.earth_rate);
  return text;
}

std::string names_text(std::string_view key, const std::vector<std::string>& names) {
  if (names.empty()) return "";
  std::vector<std::string> texts;
  for (const auto& name : names) texts.push_back(toml_text(name));
  return fmt::format("{} = [{}]\n", key, fmt::join(texts, ", "));
}

/// Returns the keys of a unit that are not those of an axis.
std::string unit_text(const OwnColumns::Axis& first) {
  if (first.interval.empty()) return "";
  return fmt::format("interval_column = {}        # counting time in s\n", toml_text(first.interval));
}

std::string value_text(const OwnColumns::Value& value) {
  return fmt::format("\n[[gyro.value]]\nname = {}\ncolumn = {}\n{}\n", toml_text(value.name), toml_text(value.column),
                     value.unit == kCelsius ? "temperature = true" : "unit = " + toml_text(value.unit));
}

/// A range of axes of one unit.
struct UnitAxes {
  std::string name{};
  std::size_t first{}, last{};  ///< index after the last axis
};

/// Groups consecutive axes whose labels differ only after the last point.
std::vector<UnitAxes> group_axes(const std::vector<OwnColumns::Axis>& axes) {
  std::vector<UnitAxes> units;
  for (std::size_t i = 0; i < axes.size();) {
    std::size_t end = i + 1;
    const auto prefix = label_prefix(axes[i].label);
    const bool has_prefix = prefix.size() < axes[i].label.size();
    while (has_prefix && end < axes.size() && label_prefix(axes[end].label) == prefix &&
           prefix.size() < axes[end].label.size())
      ++end;
    units.push_back({end > i + 1 ? std::string(prefix) : axes[i].label, i, end});
    i = end;
  }
  return units;
}

std::string gyro_sections(const OwnColumns& columns) {
  const auto units = group_axes(columns.axes);
  constexpr std::string_view kOnlyUnit = "gyro";
  const bool is_only = units.size() == 1 && units.front().name == kOnlyUnit;
  std::string text;
  for (const UnitAxes& unit : units) {
    text += is_only ? "\n[gyro]\n" : fmt::format("\n[[gyro]]\nname = {}\n", toml_text(unit.name));
    const auto& first = columns.axes[unit.first];
    if (!is_only) text += names_text("thermometers", first.gradients) + names_text("three_point", first.three_point);
    text += unit_text(first);
    const bool has_one = unit.last == unit.first + 1;
    if (has_one) text += axis_text(columns.axes[unit.first]);
    for (std::size_t i = unit.first; i < unit.last && !has_one; ++i)
      text += fmt::format("\n[[gyro.axis]]\nname = {}\n{}",
                          toml_text(columns.axes[i].label.substr(unit.name.size() + 1)), axis_text(columns.axes[i]));
    for (auto value : columns.values)
      if (value.name.starts_with(unit.name + ".")) {
        value.name.erase(0, unit.name.size() + 1);
        text += value_text(value);
      }
  }
  if (!is_only) return text;
  const auto lists = names_text("gradients", columns.axes.front().gradients) +
                     names_text("three_point", columns.axes.front().three_point);
  return lists.empty() ? text : text + "\n[analysis]\n" + lists;
}

/// Returns the columns of `export --compensated`: calibrated temperatures and the bias. The compensated bias is a
/// result and not a reading.
std::optional<OwnColumns> find_compensated_columns(const std::vector<std::string>& titles) {
  constexpr std::string_view kTime = "time [s]", kBias = "bias [°/h]", kCompensated = "compensated [°/h]";
  const auto bias = std::ranges::find(titles, kBias);
  if (titles.empty() || titles.front() != kTime || bias == titles.end() || bias + 1 == titles.end() ||
      *(bias + 1) != kCompensated)
    return std::nullopt;
  OwnColumns columns{.time = titles.front()};
  for (auto title = titles.begin() + 1; title != bias; ++title)
    if (const auto [name, unit] = split_title(*title); unit == kCelsius)
      columns.thermometers.push_back({.name = name, .column = *title});
  columns.axes.push_back({.label = "gyro", .column = *bias, .kind = record::GyroKind::rate, .scale = "1"});
  return columns;
}

/// Returns the axis with its number of pulses and its counting time instead of the rate, if the file has both.
std::optional<OwnColumns::Axis> find_counts(OwnColumns::Axis axis, const std::vector<NetcdfVariable>& variables) {
  const auto find = [&](const std::string& long_name) {
    return std::ranges::find(variables, long_name, &NetcdfVariable::long_name);
  };
  const auto pulses = find("pulses of " + axis.label);
  const auto interval = find(fmt::format("time over which pulses of {} were counted", label_prefix(axis.label)));
  if (pulses == variables.end() || interval == variables.end() || pulses->arcsec_per_pulse.empty()) return std::nullopt;
  axis.column = pulses->name;
  axis.kind = record::GyroKind::pulse_count;
  axis.scale = pulses->arcsec_per_pulse;
  axis.interval = interval->name;
  return axis;
}

/// Replaces the rates of each unit by the numbers of pulses and their counting times, if the file has them for every
/// axis of the unit.
void use_counts(std::vector<OwnColumns::Axis>& axes, const std::vector<NetcdfVariable>& variables) {
  for (const UnitAxes& unit : group_axes(axes)) {
    std::vector<OwnColumns::Axis> counted;
    for (std::size_t i = unit.first; i < unit.last; ++i)
      if (auto axis = find_counts(axes[i], variables)) counted.push_back(std::move(*axis));
    if (counted.size() == unit.last - unit.first)
      std::ranges::move(counted, axes.begin() + static_cast<std::ptrdiff_t>(unit.first));
  }
}

}  // namespace

std::optional<OwnColumns> find_own_columns(const std::vector<std::string>& titles,
                                           const std::vector<std::string>& comments) {
  if (auto compensated = find_compensated_columns(titles)) return compensated;
  constexpr std::array<std::string_view, 5> kFirst{"slot", "time [s]", "set point [°C]", "chamber air [°C]",
                                                   "chamber set point [°C]"};
  if (titles.size() < kFirst.size() || !std::equal(kFirst.begin(), kFirst.end(), titles.begin())) return std::nullopt;
  OwnColumns columns{.time = titles[1]};
  for (std::size_t i = kFirst.size(); i < titles.size() && titles[i] != "segment"; ++i) {
    const auto& title = titles[i];
    const auto [name, unit] = split_title(title);
    if (title.empty() || title.starts_with("chamber ") || (name.ends_with(" interval") && unit == "s")) continue;
    if (name == "true bias" || name.ends_with(" true bias")) continue;
    if (auto axis = parse_axis(title, comments)) {
      if (axis->kind == record::GyroKind::pulse_count) axis->interval = find_interval(titles, axis->label);
      columns.axes.push_back(std::move(*axis));
    } else if (columns.axes.empty() && unit == kCelsius) {
      columns.thermometers.push_back(make_thermometer(name, title, comments));
    } else if (!columns.axes.empty()) {
      columns.values.push_back({name, title, unit});
    }
  }
  for (auto& axis : columns.axes) {
    const auto names = [&](const char* list) {
      const auto beginning = fmt::format("unit {}: {} ", label_prefix(axis.label), list);
      return split_thermometers(find_in_comments(comments, beginning).value_or(""), columns);
    };
    axis.gradients = names("gradients");
    axis.three_point = names("three point");
  }
  columns.has_turned = std::ranges::find(titles, record::kTurnedTitle) != titles.end();
  return columns.axes.empty() ? std::nullopt : std::optional(columns);
}

std::optional<OwnColumns> find_own_columns(const std::vector<NetcdfVariable>& variables) {
  OwnColumns columns{.time = "time"};
  for (const NetcdfVariable& variable : variables) {
    const auto& channel = variable.channel.empty() ? variable.name : variable.channel;
    if (const auto label = text_between(variable.long_name, "rate about ", ", including the Earth rate")) {
      columns.axes.push_back({.label = *label,
                              .column = variable.name,
                              .kind = record::GyroKind::rate,
                              .scale = "1",
                              .earth_rate = variable.earth_rate});
    } else if (variable.long_name == "temperature of " + channel) {
      columns.thermometers.push_back({.name = channel, .column = variable.name});
    } else if (variable.long_name.ends_with(" reported by the unit")) {
      columns.values.push_back(
          {channel, variable.name, variable.units == "degC" ? std::string(kCelsius) : variable.units});
    }
    columns.has_turned = columns.has_turned || variable.name == record::kTurnedTitle;
  }
  for (auto& axis : columns.axes) {
    const auto variable = std::ranges::find(variables, axis.column, &NetcdfVariable::name);
    axis.gradients = split_thermometers(variable->gradients, columns);
    axis.three_point = split_thermometers(variable->three_point, columns);
  }
  use_counts(columns.axes, variables);
  return columns.axes.empty() ? std::nullopt : std::optional(columns);
}

std::string own_sections(const OwnColumns& columns) {
  std::string text = fmt::format("[time]\ncolumn = {}\n", toml_text(columns.time));
  if (columns.time != "time") text += "unit = \"s\"\n";
  for (const auto& thermometer : columns.thermometers) {
    text += fmt::format("\n[[thermometer]]\nname = {}\ncolumn = {}\n", toml_text(thermometer.name),
                        toml_text(thermometer.column));
    if (thermometer.is_nonlinear)
      text +=
          "# The table has the reading. Its correction also has terms of a higher order, which are left out here.\n";
    if (thermometer.scale != 1) text += fmt::format("scale = {}\n", thermometer.scale);
    if (thermometer.offset != 0)
      text += fmt::format("offset = {}        # correction of the reading\n", thermometer.offset);
  }
  if (columns.has_turned)
    text += "\n# The unit was turned during the run. The sign of the Earth rate changes with the column \"turned\".\n";
  return text + gyro_sections(columns);
}

}  // namespace gyrotherm::exchange
