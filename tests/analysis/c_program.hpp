// SPDX-License-Identifier: Apache-2.0
/// Compiles and runs exported C programs.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

namespace gyrotherm::model {

inline constexpr const char* kCompile = "gcc -std=c99 -Wall -Wextra -Werror -pedantic";

[[nodiscard]] inline bool has_gcc() { return std::system("gcc --version > /dev/null 2>&1") == 0; }

/// Temporary folder that is removed with the object.
class Workplace {
 public:
  Workplace() : folder_(std::filesystem::path(testing::TempDir()) / ("gyrotherm_c_" + unique())) {
    std::filesystem::create_directories(folder_);
  }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;
  ~Workplace() { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  [[nodiscard]] std::ifstream read(const std::string& name) const { return std::ifstream(folder_ / name); }
  /// Runs a command in this folder and returns its exit code.
  [[nodiscard]] int run(const std::string& command) const {
    const int status = std::system(("cd '" + folder_.string() + "' && " + command).c_str());
    return status / 256;
  }

 private:
  static std::string unique() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    return std::string(test->name()) + std::to_string(std::random_device{}());
  }
  std::filesystem::path folder_;
};

}  // namespace gyrotherm::model
