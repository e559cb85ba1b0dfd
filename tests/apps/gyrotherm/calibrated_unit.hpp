// SPDX-License-Identifier: Apache-2.0
/// Fixture of the tests of calibration reports: a laboratory, its order, and a unit that was recorded and trained.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <string>
#include <utility>

#include "core/file.hpp"
#include "report/calibration.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {

inline constexpr const char* kLaboratory = R"(schema = "gyrotherm-laboratory/1"
name = "House of Gyros"
city = "Berlin"
country = "DE"
traceability = "To the SI."
[[person]]
name = "B. Berg"
role = "authorising"
)";

inline constexpr const char* kOrder = R"(schema = "gyrotherm-order/1"
number = "C-1"
received = "2025-12-20"
issued = "2026-01-09"
method = "Ramps and soaks"
[customer]
name = "Navigation <script>alert(1)</script> Works Ναυτιλία"
city = "Hamburg"
[[unit]]
model = "RLG-1"
serial_number = "0042"
condition = "no damage"
[[person]]
name = "K. Kurz"
role = "operator"
[[limit]]
quantity = "whole_run.rmse"
stage = "as_left"
at_most = 0.1
[[limit]]
quantity = "whole_run.std"
stage = "uncompensated"
at_most = 0.0001
)";

[[nodiscard]] inline std::string read_text(const std::string& path) {
  return read_text_file(path, kLargestTable).value_or("");
}

/// Recorded, trained and reported once for all tests.
class CalibrationOfAUnit : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder() = std::make_unique<Folder>();
    std::ofstream(in("laboratory.toml")) << kLaboratory;
    std::ofstream(in("order.toml")) << kOrder;
    for (const auto& [profile, name] : {std::pair{"short-rate", "ramp.db"}, std::pair{"short-random", "random.db"}})
      run("run tests/profiles/" + std::string(profile) + ".toml --rig profiles/rigs/virtual.toml --seed 3 --out " +
          in(name));
    run("train " + in("ramp.db") + " --inputs seven-point,A --method ridge-u --out " + in("model.json"));
    run("report " + in("ramp.db") + " " + in("random.db") + " --model " + in("model.json") + files("order.toml") +
        " --language en,de --out " + in("report"));
  }
  static void TearDownTestSuite() { folder().reset(); }

  static void run(const std::string& arguments) {
    const auto ran = gyrotherm_with(arguments);
    ASSERT_EQ(ran.exit_code, 0) << arguments << ": " << ran.err;
  }
  static std::string files(const std::string& order) {
    return " --laboratory " + in("laboratory.toml") + " --order " + in(order);
  }
  [[nodiscard]] static std::string in(const std::string& name) { return *folder() / name; }
  [[nodiscard]] static report::CalibrationReport read_report(const std::string& name) {
    return report::calibration_from_json(read_text(in(name) + "/calibration.json"), name).value();
  }

 private:
  static std::unique_ptr<Folder>& folder() {
    static std::unique_ptr<Folder> one;
    return one;
  }
};

}  // namespace gyrotherm::app
