#include "acquisition/record/live_rows.hpp"

#include <fmt/format.h>

#include <limits>

namespace gyrotherm {

tl::unexpected<Fault> LiveRows::mistake(std::size_t column, std::string what) const {
  return failure(FaultKind::bad_file, fmt::format("{}:{}:{}", source_, line_, column), std::move(what));
}

Result<void> LiveRows::take(std::string_view piece) {
  while (true) {
    const std::size_t end = piece.find('\n');
    const bool whole = end != std::string_view::npos;
    std::string_view line = piece.substr(0, end);
    if (line.size() > kLongestLine || line.size() + rest_.size() > kLongestLine) {
      ++line_;
      return mistake(1, fmt::format("more than {} bytes without an end of line", kLongestLine));
    }
    if (!whole || !rest_.empty()) rest_ += line;
    if (!whole) return {};
    if (!rest_.empty()) line = rest_;
    if (auto read = read_line(line); !read) return read;
    rest_.clear();
    piece.remove_prefix(end + 1);
  }
}

Result<void> LiveRows::finish() {
  if (!rest_.empty()) {
    if (auto read = read_line(rest_); !read) return read;
    rest_.clear();
  }
  if (!header_.empty()) return {};
  ++line_;
  return mistake(1, "no input, expected a header");
}

Result<void> LiveRows::read_line(std::string_view line) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (++line_ == 1 && line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  if (trimmed(line).empty()) return {};
  if (auto parted = cut(line, ',', fields_); !parted) {
    parted.error().where = fmt::format("{}:{}:{}", source_, line_, parted.error().where);
    return parted;
  }
  if (!header_.empty()) return read_row();
  for (const Field& field : fields_) header_.emplace_back(field.text);
  return {};
}

Result<void> LiveRows::read_row() {
  if (fields_.size() != header_.size()) {
    return mistake(1, fmt::format("{} fields, expected {}", fields_.size(), header_.size()));
  }
  const std::size_t before = numbers_.size();
  for (const Field& field : fields_) {
    numbers_.push_back(std::numeric_limits<double>::quiet_NaN());
    if (field.text.empty()) continue;
    const auto number = number_in(field.text);
    if (!number) {
      numbers_.resize(before);
      return mistake(field.column, fmt::format("\"{}\", expected a number", field.text));
    }
    numbers_.back() = *number;
  }
  return {};
}

}  // namespace gyrotherm
