// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/new_rig/rig_copy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string_view>

#include "apps/gyrotherm/rig_source.hpp"
#include "core/file.hpp"
#include "core/shipped.hpp"
#include "core/text.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {
namespace {

namespace fs = std::filesystem;

/// A line `key = "value"` and what follows the value.
struct TextLine {
  std::string key;
  std::string before;  ///< key, blanks and equals sign
  std::string value;
  std::string after;
};

std::optional<TextLine> split_text_line(const std::string& line) {
  const auto equals = line.find('=');
  const auto first = line.find('"'), last = first == std::string::npos ? first : line.find('"', first + 1);
  if (equals == std::string::npos || last == std::string::npos || line.find('#') < equals) return std::nullopt;
  if (line.find_first_not_of(" \t", equals + 1) != first) return std::nullopt;
  return TextLine{.key = std::string(trimmed(std::string_view(line).substr(0, equals))),
                  .before = line.substr(0, first),
                  .value = line.substr(first + 1, last - first - 1),
                  .after = line.substr(last + 1)};
}

/// Returns the name by which the files of all folders can name this one: that of a shipped file, or an absolute path.
std::string portable_name(const fs::path& path) {
  const auto absolute = fs::weakly_canonical(path);
  const auto folder = fs::path("profiles") / absolute.parent_path().filename() / absolute.filename();
  const auto shipped = find_shipped_file(folder.string());
  if (!shipped.empty() && fs::weakly_canonical(shipped) == absolute) return absolute.stem().string();
  return absolute.string();
}

bool names_other_file(const std::string& value) {
  constexpr std::array<std::string_view, 3> kEndings{".toml", ".xml", ".pem"};
  return std::ranges::any_of(kEndings, [&](std::string_view ending) { return value.ends_with(ending); });
}

/// Returns the line for the new file, without its comment if the path changes. `is_in_table` is true after the first
/// header of a table.
std::string copy_line(const std::string& line, const fs::path& folder, const std::string& name, bool is_in_table) {
  const auto text = split_text_line(line);
  if (!text) return line;
  if (!is_in_table && text->key == "name") return text->before + '"' + name + '"' + text->after;
  const auto path = folder / text->value;
  std::error_code error;
  if (!names_other_file(text->value) || !fs::is_regular_file(path, error)) return line;
  return text->before + '"' + portable_name(path) + '"';
}

}  // namespace

Result<std::string> copy_rig_text(const std::string& given, const std::string& file) {
  const auto path = resolve_path(given, kShippedRig);
  if (!path) return failure(path.error());
  if (const auto rig = load_rig(*path); !rig) return failure(rig.error());
  const auto text = read_text_file(*path);
  if (!text) return failure(text.error());
  const std::string name = fs::path(file).stem().string();
  std::string copy = fmt::format("# A copy of the rig {}.\n", given);
  std::istringstream lines(*text);
  bool is_in_table = false;
  for (std::string line; std::getline(lines, line);) {
    is_in_table = is_in_table || line.starts_with('[');
    copy += copy_line(line, parent_folder(*path), name, is_in_table) + '\n';
  }
  if (const auto rig = rig::parse_rig(copy, file); !rig) return failure(rig.error());
  return copy;
}

}  // namespace gyrotherm::app
