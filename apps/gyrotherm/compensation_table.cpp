// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/compensation_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "acquisition/record/csv.hpp"

namespace gyrotherm::app {
namespace {

constexpr std::string_view kBias = "bias", kAtRest = "at_rest", kFirstOfExport = "slot", kTimeOfExport = "time [s]";
/// The end of the comment on the axis of an imported record without an Earth rate.
constexpr std::string_view kNothingRemovedRemark = ", nothing removed";
constexpr std::size_t kSlotColumn = 0;

/// Separates a title such as "A [°C]" into name and unit.
std::string_view name_from_title(std::string_view title) { return title.substr(0, title.rfind(" [")); }
std::string_view unit_from_title(std::string_view title) {
  const auto at = title.rfind(" [");
  return at == std::string_view::npos ? std::string_view() : title.substr(at + 2, title.size() - at - 3);
}

template <class Predicate>
std::optional<std::size_t> find_if(const std::vector<std::string>& header, Predicate matches) {
  const auto at = std::ranges::find_if(header, matches);
  return at == header.end() ? std::nullopt : std::optional<std::size_t>(at - header.begin());
}

std::optional<std::size_t> find(const std::vector<std::string>& header, std::string_view name) {
  return find_if(header, [&](const std::string& title) { return name_from_title(title) == name; });
}

/// Finds a column by name. A thermometer and a gyro may have the same name; the unit distinguishes temperature and
/// rotation.
std::optional<std::size_t> find(const std::vector<std::string>& header, std::string_view name, bool is_temperature) {
  return find_if(header, [&](const std::string& title) {
    return name_from_title(title) == name && (unit_from_title(title) == "°C") == is_temperature;
  });
}

/// Checks the names and units of a plain header. A title without a unit is accepted. Fails with bad_file if a name
/// occurs twice, or if a unit is not the one that the column must have.
Result<void> check_titles(const std::vector<std::string>& header, std::size_t bias) {
  static const std::set<std::string_view> temperature{"", "°C", "C", "degC"}, rate{"", "°/h", "deg/h"};
  std::set<std::string_view> names;
  for (const auto& title : header)
    if (!names.insert(name_from_title(title)).second)
      return failure(FaultKind::bad_file, "stdin:1:1",
                     fmt::format("there are two columns \"{}\"", name_from_title(title)));
  for (std::size_t k = 0; k <= bias; ++k) {
    if (k < bias && !data::is_temperature(name_from_title(header[k]))) continue;
    if ((k == bias ? rate : temperature).contains(unit_from_title(header[k]))) continue;
    return failure(FaultKind::bad_file, "stdin:1:1",
                   fmt::format("column {} is \"{}\", expected {}", k + 1, header[k],
                               k == bias ? "a bias in [°/h]" : "a temperature in [°C]"));
  }
  return {};
}

std::set<std::string> list_inputs(const model::Model& model) {
  std::set<std::string> names;
  for (const data::Term& term : model.terms) {
    for (const data::Factor& factor : term.factors) {
      names.insert(factor.first);
      if (!factor.second.empty()) names.insert(factor.second);
    }
  }
  return names;
}

/// Returns the text of the comment on "thermometer A" or "axis u1.x", or an empty text.
std::string_view find_comment(const std::vector<std::string>& comments, const std::string& what) {
  for (const std::string& comment : comments)
    if (comment.starts_with(what + ": ")) return std::string_view(comment).substr(what.size() + 2);
  return {};
}

/// Returns the number that follows a keyword in a comment.
std::optional<double> number_after(std::string_view comment, std::string_view keyword) {
  const auto at = comment.find(keyword);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view remainder = comment.substr(at + keyword.size());
  return record::number_in(record::trimmed(remainder.substr(0, remainder.find(','))));
}

record::Channel parse_calibration(const std::vector<std::string>& comments, const std::string& thermometer) {
  constexpr std::string_view kPolynomial = "polynomial ";
  record::Channel channel;
  std::string_view comment = find_comment(comments, "thermometer " + thermometer);
  channel.offset.value = number_after(comment, "offset ").value_or(0);
  if (!comment.starts_with(kPolynomial)) return channel;
  comment.remove_prefix(kPolynomial.size());
  while (!comment.empty()) {
    const auto end = std::min(comment.find(' '), comment.size());
    channel.polynomial.push_back(record::number_in(comment.substr(0, end)).value_or(0));
    comment.remove_prefix(std::min(end + 1, comment.size()));
  }
  return channel;
}

/// Returns the title that `export` gives to a value of the axis's unit: "u1.temperature", or without the unit if the
/// rig does not name it.
std::string exported_title(const std::string& input, const data::AxisChoice& axis) {
  const std::string prefix = is_named(axis) ? axis.unit + "." : std::string();
  return prefix + (input == data::kSelf ? "temperature" : input.substr(data::kAux.size()));
}

}  // namespace

Result<CompensationTable> CompensationTable::of(const std::vector<std::string>& header,
                                                const std::vector<std::string>& comments, const model::Model& model,
                                                const data::AxisChoice& axis, bool tracked) {
  CompensationTable table;
  if (header.front() != kFirstOfExport) {
    const bool has_at_rest = tracked && header.back() == kAtRest;
    const std::size_t bias = header.size() - (has_at_rest ? 2 : 1);
    if (bias < 1 || bias >= header.size() || name_from_title(header[bias]) != kBias)
      return failure(
          FaultKind::bad_file, "stdin:1:1",
          fmt::format("expected a header: the names of the thermometers, then \"bias\"{}, separated by commas; or "
                      "a table written by export",
                      tracked ? " and optionally \"at_rest\"" : ""));
    if (auto checked = check_titles(header, bias); !checked) return failure(checked.error());
    for (std::size_t k = 0; k < header.size(); ++k) table.columns_.push_back(k);
    for (std::size_t k = 0; k < bias; ++k) table.thermometers_.emplace_back(name_from_title(header[k]));
    table.has_at_rest_ = has_at_rest;
    return table;
  }
  for (const std::string& input : list_inputs(model)) {
    const bool is_own = data::is_own_value(input);
    const auto column = is_own ? find(header, exported_title(input, axis)) : find(header, input, true);
    if (!column) return failure(FaultKind::usage, "stdin", fmt::format("contains no column \"{}\"", input));
    table.columns_.push_back(*column);
    table.thermometers_.push_back(input);
    table.calibrations_.push_back(is_own ? record::Channel{} : parse_calibration(comments, input));
  }
  const std::string label = is_named(axis) ? qualified_name(axis) : record::kOnlyUnit;
  const auto rotation = find(header, label, false);
  if (!rotation) return failure(FaultKind::usage, "stdin", fmt::format("contains no axis \"{}\"", label));
  const std::string_view comment = find_comment(comments, "axis " + label);
  const auto scale = number_after(comment, "scale ");
  auto earth_rate = number_after(comment, "earth rate ");
  if (!earth_rate && comment.ends_with(kNothingRemovedRemark)) earth_rate = 0;
  if (!scale || !earth_rate)
    return failure(
        FaultKind::bad_file, "stdin",
        fmt::format("the Earth rate on {} is missing, so the bias cannot be computed: the reference of this record "
                    "is the mean of its first hold; state the axis and the latitude in the rig file. Export an "
                    "imported record again",
                    label));
  table.bias_zero_ = *earth_rate == 0 ? "" : "earth rate removed";
  if (comment.ends_with(kNothingRemovedRemark)) table.bias_zero_ = data::kNothingRemoved;
  const auto turned = find_if(header, [](const std::string& title) { return title == record::kTurnedTitle; });
  table.rotation_ =
      Rotation{*scale, *earth_rate, unit_from_title(header[*rotation]).starts_with("pulses"), turned.has_value()};
  table.columns_.push_back(*rotation);
  if (table.rotation_->over_interval) {
    const std::string unit = is_named(axis) ? axis.unit : record::kOnlyUnit;
    const auto interval = find(header, unit + " interval");
    if (!interval) return failure(FaultKind::usage, "stdin", fmt::format("has no column \"{} interval\"", unit));
    table.columns_.push_back(*interval);
  }
  if (turned) table.columns_.push_back(*turned);
  const auto time = find_if(header, [](const std::string& title) { return title == kTimeOfExport; });
  table.columns_.push_back(time.value_or(kSlotColumn));
  table.columns_.push_back(kSlotColumn);
  return table;
}

data::SampleMatrix CompensationTable::temperatures_c(const Eigen::Ref<const data::SampleMatrix>& rows) const {
  data::SampleMatrix temperatures = rows.leftCols(this->temperatures());
  for (std::size_t k = 0; k < calibrations_.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    for (Eigen::Index row = 0; row < rows.rows(); ++row)
      temperatures(row, column) = calibrated(calibrations_[k], Celsius{temperatures(row, column)}).value;
  }
  return temperatures;
}

Eigen::VectorXd CompensationTable::bias_deg_per_h(const Eigen::Ref<const data::SampleMatrix>& rows) const {
  Eigen::VectorXd bias = rows.col(temperatures());
  if (!rotation_) return bias;
  bias *= rotation_->scale;
  if (rotation_->over_interval) bias.array() /= rows.col(temperatures() + 1).array();
  if (!rotation_->may_be_turned) return bias.array() - rotation_->earth_rate_deg_per_h;
  const auto turned = rows.col(temperatures() + (rotation_->over_interval ? 2 : 1)).array();
  return bias.array() - rotation_->earth_rate_deg_per_h * (1 - 2 * turned);
}

bool CompensationTable::is_at_rest(const Eigen::Ref<const data::SampleMatrix>& rows, Eigen::Index row) const {
  return !has_at_rest_ || rows(row, temperatures() + 1) > 0;
}

Eigen::VectorXd CompensationTable::time_s(const Eigen::Ref<const data::SampleMatrix>& rows) const {
  return rows.col(rows.cols() - 2);
}

Eigen::VectorXd CompensationTable::slot(const Eigen::Ref<const data::SampleMatrix>& rows) const {
  return rows.rightCols(1);
}

std::string advice_for_spacing(double interval_s) {
  return interval_s < 1 ? "import the file again with every = \"1 s\" in [time], or use verify"
                        : "no import makes the rows finer; verify applies the model to means of such rows";
}

}  // namespace gyrotherm::app
