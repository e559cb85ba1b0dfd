// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/cell_number.hpp"

#include <algorithm>

#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr std::string_view kAllDigits = "0123456789", kNoBreakSpace = "\xC2\xA0", kNarrowSpace = "\xE2\x80\xAF";

bool is_plain(std::string_view text, const NumberStyle& style) {
  return style.decimal == '.' && style.thousands == 0 && style.units.empty() && !text.empty() &&
         static_cast<unsigned char>(text.front()) < 0x80;
}

void replace_all(std::string& text, std::string_view what, std::string_view with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
    text.replace(at, what.size(), with);
}

std::string_view without_unit(std::string_view text, const std::vector<std::string>& units) {
  for (const std::string& unit : units) {
    if (unit.empty() || text.size() <= unit.size() || !text.ends_with(unit)) continue;
    const auto number = trimmed(text.substr(0, text.size() - unit.size()));
    if (kAllDigits.find(number.back()) != std::string_view::npos || number.back() == '.' || number.back() == ',')
      return number;
  }
  return text;
}

}  // namespace

bool has_good_thousands(std::string_view number, char thousands, char decimal) {
  if (number.starts_with('-') || number.starts_with('+')) number.remove_prefix(1);
  const auto whole = number.substr(0, number.find(decimal));
  const auto behind = number.substr(std::min(whole.size(), number.size()));
  if (behind.find(thousands) != std::string_view::npos) return false;
  std::size_t first = whole.find(thousands);
  if (first == std::string_view::npos) return true;
  if (first == 0 || first > 3) return false;
  for (std::size_t at = first; at < whole.size(); at += 4)
    if (whole[at] != thousands || whole.size() < at + 4 ||
        whole.substr(at + 1, 3).find_first_not_of(kAllDigits) != std::string_view::npos)
      return false;
  return true;
}

std::string_view unit_behind_number(std::string_view cell) {
  cell = trimmed(cell);
  for (const auto minus : {kMinusSign, kEnDash})
    if (cell.starts_with(minus)) cell.remove_prefix(minus.size());
  const std::size_t number = cell.find_last_of(kAllDigits);
  if (cell.empty() || number == std::string_view::npos) return {};
  const bool starts_as_number = cell.find_first_of(kAllDigits) <= 1;
  const auto unit = trimmed(cell.substr(number + 1));
  const bool is_number = cell.substr(0, number + 1).find_first_not_of("0123456789.,+-eE") == std::string_view::npos;
  constexpr std::size_t kLongest = 12;
  return starts_as_number && is_number && unit.size() <= kLongest && unit != "." && unit != "," ? unit
                                                                                                : std::string_view();
}

std::string_view NumberStyle::normalised(std::string_view text, std::string& changed) const {
  if (is_plain(text, *this) || text.empty()) return text;
  changed = without_unit(text, units);
  if (static_cast<unsigned char>(changed.front()) >= 0x80 || thousands == ' ') {
    replace_all(changed, kMinusSign, "-");
    replace_all(changed, kEnDash, "-");
    replace_all(changed, kNoBreakSpace, " ");
    replace_all(changed, kNarrowSpace, " ");
  }
  if (changed.starts_with("- ")) changed.erase(1, 1);
  if (thousands != 0) {
    if (!has_good_thousands(changed, thousands, decimal)) return {};
    std::erase(changed, thousands);
  }
  if (decimal == '.') return changed;
  if (changed.find('.') != std::string::npos) return {};
  std::ranges::replace(changed, ',', '.');
  return changed;
}

}  // namespace gyrotherm::exchange
