// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/simulation_mark.hpp"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <utility>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/netcdf_table.hpp"
#include "acquisition/exchange/text_lines.hpp"
#include "acquisition/record/run_info.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

/// Returns the instruments that a marked text names; nothing if the text has no mark. Characters of comments and the
/// quotes of spreadsheets may be around the mark.
std::vector<std::string> parse_mark(std::string_view text, const std::string& file) {
  constexpr std::string_view kMark = "SIMULATED", kAround = " \t#%;,\"'!";
  text = trimmed(text, kAround);
  if (!text.starts_with(kMark)) return {};
  const auto list = text.find(record::kVirtualInstrumentsText);
  if (list == std::string_view::npos) return {"all those of " + file};
  text.remove_prefix(list + record::kVirtualInstrumentsText.size());
  std::vector<std::string> titles;
  while (!text.empty()) {
    const auto end = std::min(text.find(", "), text.size());
    titles.push_back(plain(trimmed(text.substr(0, end))));
    text.remove_prefix(std::min(end + 2, text.size()));
  }
  return titles;
}

Result<std::vector<std::string>> find_mark(TextLines lines, const std::string& file) {
  constexpr int kSearchedLines = 50;
  for (int i = 0; i < kSearchedLines; ++i) {
    const auto next = lines.next();
    if (!next || !*next) break;  // the reader of the rows reports it
    if (auto titles = parse_mark(lines.line(), file); !titles.empty()) return titles;
  }
  return std::vector<std::string>();
}

}  // namespace

Result<std::vector<std::string>> read_simulation_mark(const std::string& path, FileFormat format) {
  const auto file = plain(std::filesystem::path(path).filename().string());
  if (format == FileFormat::netcdf)
    return read_netcdf_source(path).map([&](const std::string& source) { return parse_mark(source, file); });
  if (format != FileFormat::text) return std::vector<std::string>();
  auto bytes = Bytes::open(path);
  if (!bytes) return failure(bytes.error());
  auto lines = TextLines::open(std::move(*bytes), "");
  return lines ? find_mark(std::move(*lines), file) : std::vector<std::string>();
}

}  // namespace gyrotherm::exchange
