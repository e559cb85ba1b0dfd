// SPDX-License-Identifier: Apache-2.0
/// Finds the function definitions in a C++ source. The house rule for the length of functions uses it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace gyrotherm {

/// Function definition at namespace or class scope. Lines are numbered from 1.
struct SourceFunction {
  /// Text up to the opening brace in one line, with literals removed.
  std::string signature;
  std::size_t first_line{};  ///< includes the template line
  std::size_t last_line{};

  [[nodiscard]] std::size_t lines() const { return last_line - first_line + 1; }
};

struct ScannedSource {
  std::vector<SourceFunction> functions;
  /// False if a brace is unbalanced. Functions behind that brace are then unknown.
  bool is_balanced{};
};

/// Replaces comments, literals and preprocessor directives by blanks. Keeps the line breaks.
[[nodiscard]] std::string blank_literals(const std::string& source);

/// Finds every function with a body at namespace or class scope. Local classes and lambdas are part of the enclosing
/// function or initialiser.
[[nodiscard]] ScannedSource scan_functions(const std::string& source);

}  // namespace gyrotherm
