// SPDX-License-Identifier: Apache-2.0
/// Reads any bytes as live rows. The result is either complete rows of finite or missing numbers, or a fault with its
/// position. It does not depend on the division into pieces.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "acquisition/record/csv.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::record {

using fuzz::require;

namespace {

bool are_equal(const std::vector<double>& one, const std::vector<double>& other) {
  if (one.size() != other.size()) return false;
  for (std::size_t i = 0; i < one.size(); ++i)
    if (one[i] != other[i] && !(std::isnan(one[i]) && std::isnan(other[i]))) return false;
  return true;
}

Result<void> read_in_pieces(LiveRows& rows, std::string_view text, std::size_t step) {
  for (; !text.empty(); text.remove_prefix(std::min(step, text.size())))
    if (auto read = rows.take(text.substr(0, step)); !read) return read;
  return rows.finish();
}

}  // namespace

FUZZ_TARGET(live_rows, const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  LiveRows whole("fuzz"), pieces("fuzz");
  const auto one = read_in_pieces(whole, text, size);
  const auto other = read_in_pieces(pieces, text, 1 + data[0] % 16);
  require(one.has_value() == other.has_value());
  if (!one) require(one.error().kind == FaultKind::bad_file && one.error().where == other.error().where);
  require(whole.header() == pieces.header() && are_equal(whole.numbers(), pieces.numbers()));
  require(whole.header().empty() ? whole.numbers().empty() : whole.numbers().size() % whole.header().size() == 0);
  for (const double number : whole.numbers()) require(!std::isinf(number));
  LiveRows last("fuzz", [](const std::vector<std::string>& header, const std::vector<std::string>&) {
    return Result<std::vector<std::size_t>>(std::vector<std::size_t>{header.size() - 1});
  });
  const auto one_column = read_in_pieces(last, text, size);
  require(!one || one_column.has_value());
  return 0;
}

}  // namespace gyrotherm::record
