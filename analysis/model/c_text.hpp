/// Pieces of C source.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "analysis/svm/svr.hpp"

namespace gyrotherm {

/// A constant that a C compiler reads as exactly this double.
[[nodiscard]] std::string c_number(double value);

/// "static const double NAME[n] = {…};"
[[nodiscard]] std::string c_vector(std::string_view name, const Eigen::Ref<const Eigen::VectorXd>& values);
/// "static const double NAME[rows][columns] = {…};", a line per row.
[[nodiscard]] std::string c_table(std::string_view name, const Eigen::Ref<const SampleMatrix>& values);

/// Text for inside a block comment: on one line, and nothing in it that ends or begins a comment or is a trigraph.
[[nodiscard]] std::string c_comment(std::string_view text);

/// The text with each @word@ replaced by what the word stands for; what is put in is not searched again. Every word of
/// the text must be known.
[[nodiscard]] std::string c_filled(std::string_view text, const std::map<std::string, std::string, std::less<>>& words);

}  // namespace gyrotherm
