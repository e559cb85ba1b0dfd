// SPDX-License-Identifier: Apache-2.0
/// The text of a C program: names, constants, tables, comments, and templates with placeholders for them.
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

/// Replacement text for each placeholder of a template.
using CPlaceholders = std::map<std::string, std::string, std::less<>>;

/// Returns the template with each placeholder, a name between two at-signs, replaced by its text. Replacement texts are
/// not searched for placeholders. Every placeholder must be known.
[[nodiscard]] std::string c_fill(std::string_view text, const CPlaceholders& placeholders);

/// Returns the nearest valid C identifier to begin names with: "7-B" becomes "m7_B".
[[nodiscard]] std::string c_name(std::string_view text);

/// Fails with usage if `name` is not a valid beginning of C identifiers.
[[nodiscard]] Result<void> check_c_name(std::string_view name);

/// Returns a C constant that a compiler reads as exactly this double.
[[nodiscard]] std::string c_number(double value);

/// Returns constants separated by `between`.
[[nodiscard]] std::string c_list(const Eigen::Ref<const Eigen::VectorXd>& values, std::string_view between = ", ");

/// Returns "static const double NAME[n] = {…};".
[[nodiscard]] std::string c_vector(std::string_view name, const Eigen::Ref<const Eigen::VectorXd>& values);

/// Returns "static const double NAME[rows][columns] = {…};", a line per row.
[[nodiscard]] std::string c_table(std::string_view name, const Eigen::Ref<const data::SampleMatrix>& values);

/// Returns the text for use inside a block comment: on one line, without comment delimiters or trigraphs.
[[nodiscard]] std::string c_comment(std::string_view text);

}  // namespace gyrotherm::model
