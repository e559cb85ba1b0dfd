// SPDX-License-Identifier: Apache-2.0
/// Finds the function definitions of a C++ source, for the house rule on the length of functions.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace gyrotherm {

/// Function definition at namespace or class scope. Lines count from 1.
struct SourceFunction {
  /// Lines of the head, up to the opening brace, joined by single blanks. Without literals.
  std::string signature;
  std::size_t first_line{};  ///< template line included
  std::size_t last_line{};

  [[nodiscard]] std::size_t lines() const { return last_line - first_line + 1; }
};

struct ScannedSource {
  std::vector<SourceFunction> functions;
  /// False if a brace is unbalanced. The functions behind it are then unknown.
  bool is_balanced{};
};

/// Replaces comments, literals and preprocessor directives by blanks. Keeps the line breaks.
[[nodiscard]] std::string blank_literals(const std::string& source);

/// Finds every function with a body at namespace or class scope. Skips local classes and lambdas: they are part of the
/// function, or of the initialiser, around them.
[[nodiscard]] ScannedSource scan_functions(const std::string& source);

}  // namespace gyrotherm
