#include <fmt/format.h>

#include <algorithm>

#include "simulator/laboratory_file.hpp"

namespace gyrotherm {
namespace {

void expect_not_negative(const TomlTable& table, const char* key, double value) {
  if (table.has(key) && !(value >= 0)) table.mistake(key, fmt::format("{} is below 0", value));
}

void expect_step(const TomlTable& table, const char* key, double value) {
  if (table.has(key) && !(value >= 1))
    table.mistake(key, fmt::format("{} s, expected at least the step of 1 s", value));
}

}  // namespace

double positive(const TomlTable& table, const char* key) {
  const double value = table.number(key);
  if (table.has(key) && !(value > 0)) table.mistake(key, fmt::format("{} is not above 0", value));
  return value;
}

double not_negative(const TomlTable& table, const char* key) {
  const double value = table.number(key);
  expect_not_negative(table, key, value);
  return value;
}

double not_negative(const TomlTable& table, const char* key, double fallback) {
  const double value = table.number(key, fallback);
  expect_not_negative(table, key, value);
  return value;
}

double time_constant_s(const TomlTable& table, const char* key) {
  const double value = table.number(key);
  expect_step(table, key, value);
  return value;
}

double time_constant_s(const TomlTable& table, const char* key, double fallback) {
  const double value = table.number(key, fallback);
  expect_step(table, key, value);
  return value;
}

std::vector<double> numbers(const TomlTable& table, const char* key, std::size_t count, double least) {
  auto values = table.numbers(key);
  if (values.size() != count) {
    table.mistake(key, fmt::format("{} numbers, expected {}", values.size(), count));
  } else if (const auto low = std::ranges::find_if(values, [&](double v) { return v < least; }); low != values.end()) {
    table.mistake(key, fmt::format("{}, expected at least {}", *low, least));
  }
  values.resize(count);
  return values;
}

}  // namespace gyrotherm
