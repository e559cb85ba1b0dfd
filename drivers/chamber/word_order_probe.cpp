// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/word_order_probe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace gyrotherm::drivers {

namespace {

constexpr std::array kOrders{WordOrder::abcd, WordOrder::cdab, WordOrder::badc, WordOrder::dcba};
constexpr double kNextToNothing = 1e-4;

double value_in(RegisterItem item, WordOrder order, std::span<const std::uint16_t> words) {
  item.order = order;
  item.lowest.reset();
  item.highest.reset();
  const auto value = decode(item, words);
  return value ? *value : std::numeric_limits<double>::quiet_NaN();
}

bool is_plausible(double value, const PlausibleCelsius& range) {
  return value >= range.lowest && value <= range.highest && (value == 0 || std::abs(value) >= kNextToNothing);
}

std::string found(const OrderFinding& one) {
  return fmt::format("{} (air {:.2f} °C, set point {:.2f} °C)", name(one.order), one.air_c, one.set_point_c);
}

}  // namespace

std::vector<OrderFinding> probe_word_order(const RegisterItem& air, std::span<const std::uint16_t> air_words,
                                           const RegisterItem& set_point,
                                           std::span<const std::uint16_t> set_point_words,
                                           const PlausibleCelsius& range) {
  std::vector<OrderFinding> findings;
  if (word_count(air.type) < 2 || word_count(set_point.type) < 2) return findings;
  auto orders = kOrders;
  std::stable_partition(orders.begin(), orders.end(), [&](auto order) { return order == air.order; });
  for (const auto order : orders) {
    OrderFinding one{.order = order,
                     .air_c = value_in(air, order, air_words),
                     .set_point_c = value_in(set_point, order, set_point_words)};
    // Two zeros read the same in every order: they say nothing for any of them.
    one.plausible = is_plausible(one.air_c, range) && is_plausible(one.set_point_c, range) &&
                    !(one.air_c == 0 && one.set_point_c == 0);
    findings.push_back(one);
  }
  return findings;
}

std::string in_words(const std::vector<OrderFinding>& findings) {
  if (findings.empty()) return "values of one register: no word order to find";
  std::vector<std::string> fitting;
  for (const auto& one : findings)
    if (one.plausible) fitting.push_back(found(one));
  if (fitting.empty())
    return fmt::format("no word order makes sense of air and set point, the map's {} neither", found(findings.front()));
  if (!findings.front().plausible)
    return fmt::format("the map's word order does not fit: {}; set word_order to {}", found(findings.front()),
                       fmt::join(fitting, " or "));
  if (fitting.size() == 1) return "word order " + fitting.front() + " fits, and no other";
  return fmt::format("word order {} fits, but so does {}: compare with the display", fitting.front(),
                     fmt::join(fitting.begin() + 1, fitting.end(), ", "));
}

const char* name(WordOrder order) {
  switch (order) {
    case WordOrder::abcd: return "abcd";
    case WordOrder::cdab: return "cdab";
    case WordOrder::badc: return "badc";
    case WordOrder::dcba: return "dcba";
  }
  return "";
}

}  // namespace gyrotherm::drivers
