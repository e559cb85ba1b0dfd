// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/lvm_layout.hpp"

#include <algorithm>

#include "acquisition/record/csv.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

std::vector<std::string> split_lvm_line(std::string_view line, char separator) {
  std::vector<std::string> fields;
  for (std::size_t at = 0; at <= line.size();) {
    const auto end = std::min(line.find(separator, at), line.size());
    fields.emplace_back(trimmed(line.substr(at, end - at)));
    at = end + 1;
  }
  return fields;
}

bool is_blank(std::string_view line) { return line.find_first_not_of(" \t,;") == std::string_view::npos; }

/// Reads the header of the file and of the first segment, which may be absent.
class LvmHeaders {
 public:
  LvmHeaders(const std::vector<std::string_view>& lines, LvmLayout& layout) : lines_(lines), layout_(layout) {}

  /// Returns the index of the line after both headers; nothing if a header has no end.
  std::optional<std::size_t> read() {
    auto next = read_one(0);
    while (next && *next < lines_.size() && is_blank(lines_[*next])) ++*next;
    if (next && *next < lines_.size() && lines_[*next].starts_with(kLvmSegment)) next = read_one(*next);
    return next;
  }

  /// Moves the units to the columns of the values, and removes the spacing if there is a column of times.
  void assign(const std::vector<std::string>& names) {
    std::size_t unit = 0;
    layout_.units.assign(names.size(), "");
    for (std::size_t i = 0; i < names.size(); ++i) {
      const bool is_value = !names[i].empty() && names[i] != "X_Value" && names[i] != "Comment";
      if (is_value && unit < units_.size()) layout_.units[i] = units_[unit++];
    }
    if (std::ranges::find(names, "X_Value") == names.end()) layout_.spacing_s = spacing_s_;
  }

 private:
  std::optional<std::size_t> read_one(std::size_t first) {
    for (std::size_t i = first; i < lines_.size(); ++i) {
      if (lines_[i].starts_with(kLvmHeaderEnd)) return i + 1;
      read_line(lines_[i]);
    }
    return std::nullopt;
  }

  void read_line(std::string_view line) {
    const auto begins = [&](std::string_view key) { return line.starts_with(key); };
    if (begins("Separator")) layout_.separator = line.find("Comma") != std::string_view::npos ? ',' : '\t';
    if (begins("Decimal_Separator"))
      layout_.decimal = line.ends_with(',') || line.find("\t,") != std::string_view::npos ? ',' : '.';
    const auto fields = split_lvm_line(line, layout_.separator);
    if (fields.size() < 2) return;
    if (fields[0] == "Y_Unit_Label") units_.assign(fields.begin() + 1, fields.end());
    if (fields[0] != "Delta_X") return;
    auto number = fields[1];
    std::ranges::replace(number, ',', '.');
    if (const auto spacing = record::number_in(number); spacing && *spacing > 0) spacing_s_ = *spacing;
  }

  const std::vector<std::string_view>& lines_;
  LvmLayout& layout_;
  std::vector<std::string> units_{};
  std::optional<double> spacing_s_{};
};

}  // namespace

std::optional<LvmLayout> find_lvm_layout(const std::vector<std::string_view>& lines) {
  if (lines.empty() || !lines.front().starts_with("LabVIEW Measurement")) return std::nullopt;
  LvmLayout layout;
  LvmHeaders headers(lines, layout);
  const auto names = headers.read();
  if (!names || *names >= lines.size()) return std::nullopt;
  layout.names = *names;
  headers.assign(split_lvm_line(lines[*names], layout.separator));
  bool is_in_header = false, are_names = false;
  for (std::size_t i = *names + 1; i < lines.size(); ++i) {
    if (lines[i].starts_with(kLvmSegment)) is_in_header = true;
    const bool is_row = !is_in_header && !are_names && !is_blank(lines[i]);
    if (is_row) layout.rows.push_back(i);
    are_names = is_in_header && lines[i].starts_with(kLvmHeaderEnd);
    if (are_names) is_in_header = false;
  }
  return layout;
}

}  // namespace gyrotherm::exchange
