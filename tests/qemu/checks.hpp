// SPDX-License-Identifier: Apache-2.0
/// Checks inside the emulated machine, which has no test framework. Each check prints its result.
#pragma once

#include <fmt/format.h>

#include <string_view>

namespace gyrotherm::tests {

class Checks {
 public:
  void expect(bool right, std::string_view what) {
    fmt::print("{} {}\n", right ? "ok   " : "WRONG", what);
    if (!right) ++wrong_;
  }
  [[nodiscard]] int exit_code() const { return wrong_ == 0 ? 0 : 1; }

 private:
  int wrong_ = 0;
};

}  // namespace gyrotherm::tests
