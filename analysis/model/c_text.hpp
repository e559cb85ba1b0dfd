// SPDX-License-Identifier: Apache-2.0
/// The text of a C program: names, constants, tables and comments, and templates that are filled with them.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "analysis/data/features.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// The two files of an exported program, NAME.h and NAME.c.
struct CProgram {
  std::string header, source;
};

/// The text for each word of a template.
using CWords = std::map<std::string, std::string, std::less<>>;

/// Returns the template with each word between two at-signs replaced by its text, which is not searched again. Every
/// word of the template must be known.
[[nodiscard]] std::string c_filled(std::string_view text, const CWords& words);

/// Returns the nearest name that can begin the names of a C program: "7-B" becomes "m7_B".
[[nodiscard]] std::string c_name(std::string_view text);

/// Fails with usage if `name` cannot begin the names of a C program.
[[nodiscard]] Result<void> check_c_name(std::string_view name);

/// Returns a constant that a C compiler reads as exactly this double.
[[nodiscard]] std::string c_number(double value);

/// Returns constants with `between` between each two.
[[nodiscard]] std::string c_list(const Eigen::Ref<const Eigen::VectorXd>& values, std::string_view between = ", ");

/// Returns "static const double NAME[n] = {…};".
[[nodiscard]] std::string c_vector(std::string_view name, const Eigen::Ref<const Eigen::VectorXd>& values);

/// Returns "static const double NAME[rows][columns] = {…};", a line per row.
[[nodiscard]] std::string c_table(std::string_view name, const Eigen::Ref<const data::SampleMatrix>& values);

/// Returns text for inside a block comment: it is on one line, and nothing in it ends or begins a comment or is a
/// trigraph.
[[nodiscard]] std::string c_comment(std::string_view text);

}  // namespace gyrotherm::model
