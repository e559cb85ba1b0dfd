// SPDX-License-Identifier: Apache-2.0
/// Record of two thermometers and a gyro, small enough for quick training.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {

inline constexpr int kSmallRecordRows = 4000;

/// Returns rows in the format of `compensate`: two slowly swinging temperatures, B after A, and a bias that follows
/// their difference.
[[nodiscard]] inline std::string small_rows(int rows = kSmallRecordRows) {
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  std::string text = "A,B,bias\n";
  for (int i = 0; i < rows; ++i) {
    const double a = 20 + 15 * std::sin(i / 350.0), b = 20 + 14 * std::sin(i / 350.0 - 0.2);
    text += fmt::format("{:.3f},{:.3f},{:.5f}\n", a, b, 0.3 * (a - b) + 0.1 * std::sin(a) + 0.2 * normal(generator));
  }
  return text;
}

/// Returns the import map of these rows; `time` is the content of its [time] table.
[[nodiscard]] inline std::string small_map(const std::string& time = "interval = \"1 s\"") {
  return R"(schema = "gyrotherm-import/1"
name = "small"
title = "two thermometers on a swing"

[file]
separator = ","
header = true

[time]
)" + time +
         R"(

[[thermometer]]
name = "A"
column = "A"

[[thermometer]]
name = "B"
column = "B"

[gyro]
column = "bias"
kind = "rate"
scale = 1.0

[analysis]
gradients = ["A", "B"]
)";
}

/// Makes record.db and model.json, which is trained on it.
inline void make_small_model(const Folder& folder) {
  std::ofstream(folder / "record.csv") << small_rows();
  std::ofstream(folder / "map.toml") << small_map();
  const auto imported = gyrotherm_with("import " + (folder / "record.csv") + " --map " + (folder / "map.toml") +
                                       " --out " + (folder / "record.db"));
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  const auto trained = gyrotherm_with("train " + (folder / "record.db") +
                                      " --inputs A-B,A --folds blocks --quick --out " + (folder / "model.json"));
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
}

}  // namespace gyrotherm::app
