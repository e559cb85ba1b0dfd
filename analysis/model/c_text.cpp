// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/c_text.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cctype>
#include <cstddef>

#include "core/text.hpp"

namespace gyrotherm::model {
namespace {

constexpr std::size_t kLineWidth = 100;

/// Returns the values between braces, on as many lines as needed.
std::string format_braced(const Eigen::Ref<const Eigen::VectorXd>& values, std::string_view indent) {
  std::string text = "{";
  std::size_t line = indent.size() + 1;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const std::string number = c_number(values(i));
    if (i > 0) text += ',';
    if (line + number.size() + 2 > kLineWidth) {
      text += fmt::format("\n{} ", indent);
      line = indent.size() + 1;
    } else if (i > 0) {
      text += ' ';
    }
    text += number;
    line += number.size() + 2;
  }
  return text + "}";
}

}  // namespace

std::string c_fill(std::string_view text, const CPlaceholders& placeholders) {
  std::string filled;
  while (true) {
    const std::size_t begin = text.find('@');
    filled += text.substr(0, begin);
    if (begin == text.npos) return filled;
    const std::size_t end = text.find('@', begin + 1);
    const auto placeholder = placeholders.find(text.substr(begin + 1, end - begin - 1));
    assert(end != text.npos && placeholder != placeholders.end());
    filled += placeholder->second;
    text.remove_prefix(end + 1);
  }
}

std::string c_name(std::string_view text) {
  std::string name;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    name += byte < 0x80 && std::isalnum(byte) != 0 ? c : '_';
  }
  if (name.empty() || std::isalpha(static_cast<unsigned char>(name.front())) == 0) name.insert(0, 1, 'm');
  return name;
}

Result<void> check_c_name(std::string_view name) {
  if (name == c_name(name)) return {};
  return failure(FaultKind::usage, "C export",
                 fmt::format("\"{}\" is not a valid prefix of C names; use \"{}\"", name, c_name(name)));
}

std::string c_number(double value) {
  std::string digits = fmt::format("{:.17g}", value);
  if (digits.find_first_of(".e") == digits.npos) digits += ".0";
  return digits;
}

std::string c_list(const Eigen::Ref<const Eigen::VectorXd>& values, std::string_view between) {
  std::string text;
  for (Eigen::Index i = 0; i < values.size(); ++i) text.append(i > 0 ? between : "").append(c_number(values(i)));
  return text;
}

std::string c_vector(std::string_view name, const Eigen::Ref<const Eigen::VectorXd>& values) {
  return fmt::format("static const double {}[{}] = {};\n", name, values.size(), format_braced(values, "  "));
}

std::string c_table(std::string_view name, const Eigen::Ref<const data::SampleMatrix>& values) {
  std::string text = fmt::format("static const double {}[{}][{}] = {{\n", name, values.rows(), values.cols());
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    const Eigen::VectorXd row = values.row(i);
    text += "  " + format_braced(row, "   ") + (i + 1 < values.rows() ? ",\n" : "\n");
  }
  return text + "};\n";
}

std::string c_comment(std::string_view text) {
  std::string safe;
  for (const char c : text) safe += static_cast<unsigned char>(c) < ' ' || c == '\x7f' ? ' ' : c;
  safe = substitute(substitute(safe, "*/", "* /"), "/*", "/ *");
  // Pairs of question marks overlap: the first pass leaves one in "???", and the second pass leaves none.
  for (int pass = 0; pass < 2; ++pass) safe = substitute(safe, "??", "? ?");
  if (safe.ends_with('\\')) safe += ' ';
  return safe;
}

}  // namespace gyrotherm::model
