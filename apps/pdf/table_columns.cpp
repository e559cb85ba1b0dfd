// SPDX-License-Identifier: Apache-2.0
#include "apps/pdf/table_columns.hpp"

#include <algorithm>

namespace gyrotherm::report {
namespace {

double sum_of(const std::vector<ColumnWish>& wishes, double ColumnWish::*part) {
  double sum = 0;
  for (const ColumnWish& wish : wishes) sum += wish.*part;
  return sum;
}

/// The width of a column where none is wider than a level, unless it has to be.
double width_below(const ColumnWish& wish, double level) { return std::clamp(level, wish.least, wish.natural); }

/// All as wide as they would, but the widest no wider than one level that makes them fit.
std::vector<double> levelled(const std::vector<ColumnWish>& wishes, double width) {
  double low = 0, high = width;
  for (int halving = 0; halving < 60; ++halving) {
    const double level = (low + high) / 2;
    double sum = 0;
    for (const ColumnWish& wish : wishes) sum += width_below(wish, level);
    (sum > width ? high : low) = level;
  }
  std::vector<double> widths;
  for (const ColumnWish& wish : wishes) widths.push_back(width_below(wish, low));
  return widths;
}

}  // namespace

bool least_fit(const std::vector<ColumnWish>& wishes, double width) {
  return sum_of(wishes, &ColumnWish::least) <= width;
}

std::vector<double> column_widths(const std::vector<ColumnWish>& wishes, double width) {
  if (!least_fit(wishes, width)) {
    std::vector<ColumnWish> yielding;
    for (const ColumnWish& wish : wishes) yielding.push_back({.least = 0, .natural = wish.least});
    return levelled(yielding, width);
  }
  const double natural = sum_of(wishes, &ColumnWish::natural);
  if (natural > width) return levelled(wishes, width);
  std::vector<double> widths;
  for (const ColumnWish& wish : wishes)
    widths.push_back(natural > 0 ? wish.natural * width / natural : width / static_cast<double>(wishes.size()));
  return widths;
}

}  // namespace gyrotherm::report
