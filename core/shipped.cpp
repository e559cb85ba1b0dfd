// SPDX-License-Identifier: Apache-2.0
#include "core/shipped.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>
#include <system_error>

#include "core/file.hpp"
#include "core/process.hpp"
#include "core/text.hpp"

namespace gyrotherm {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".toml";

/// Resolves links and makes the path relative if it lies in the working directory.
std::string relative_to_working_folder(const fs::path& path) {
  std::error_code error;
  const auto whole = fs::canonical(path, error);
  if (error) return path.string();
  const auto here = fs::current_path(error);
  const auto relative = whole.lexically_relative(here);
  return error || relative.empty() || *relative.begin() == ".." ? whole.string() : relative.string();
}

/// Searches the other kinds for a shipped file with this name. Returns the noun for its kind, or null if there is none.
const char* find_other_kind(const std::string& given, const ShippedKind& kind) {
  for (const auto& other : {kShippedProfile, kShippedRig, kShippedImportMap, kShippedGyro, kShippedChamberMap,
                            kShippedAnalogueMap, kShippedGyroStream, kShippedThermometer, kShippedSupply})
    if (std::string_view(other.folder) != kind.folder &&
        !find_shipped_file(fmt::format("{}/{}{}", other.folder, given, kExtension)).empty())
      return other.what;
  return nullptr;
}

}  // namespace

std::vector<std::string> shipped_folders() {
  const fs::path own = fs::path(sibling_program_path("")).parent_path();
  std::vector<std::string> folders;
  for (const auto& prefix : {own.parent_path(), own, fs::path("/usr/local"), fs::path("/usr")}) {
    auto folder = (prefix / "share/gyrotherm").string();
    if (std::ranges::count(folders, folder) == 0) folders.push_back(std::move(folder));
  }
  return folders;
}

std::string find_shipped_file(const std::string& path) {
  for (const auto& folder : shipped_folders())
    if (std::error_code error; fs::exists(fs::path(folder) / path, error))
      return relative_to_working_folder(fs::path(folder) / path);
  return {};
}

std::vector<std::string> shipped_names(const ShippedKind& kind) {
  std::set<std::string> names;
  for (const auto& folder : shipped_folders())
    for (const auto& path : list_folder(fs::path(folder) / kind.folder))
      if (path.extension() == kExtension) names.insert(path.stem().string());
  return {names.begin(), names.end()};
}

bool is_path(std::string_view given) {
  return given.find('/') != std::string_view::npos || given.ends_with(kExtension);
}

namespace {

/// Returns what a regular file is if it is recognised as another format than TOML, such as a record; otherwise an
/// empty text.
std::string_view recognise_other_format(const std::string& path) {
  constexpr std::size_t kRecognised = 64;
  const auto file = open_regular_file(path);
  if (!file) return {};
  std::string head(kRecognised, '\0');
  head.resize(
      static_cast<std::size_t>(std::max<ssize_t>(read_some(file->descriptor.number(), head.data(), kRecognised), 0)));
  return detect_other_format(head);
}

/// Returns the name in the spelling of shipped files: "watlow_f4t" for "Watlow F4T".
std::string as_file_name(std::string name) {
  for (char& c : name) c = c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

/// Returns the shortest name that contains `part`, or nothing if `part` is too short to mean one.
std::string find_containing(const std::string& part, const std::vector<std::string>& names) {
  constexpr std::size_t kShortestPart = 2;
  std::string best;
  for (const auto& name : names)
    if (part.size() >= kShortestPart && name.find(part) != std::string::npos &&
        (best.empty() || name.size() < best.size()))
      best = name;
  return best;
}

}  // namespace

Result<std::string> resolve_path(const std::string& given, const ShippedKind& kind) {
  if (is_path(given)) return given;
  if (auto found = given.empty() ? "" : find_shipped_file(fmt::format("{}/{}{}", kind.folder, given, kExtension));
      !found.empty())
    return found;
  if (std::error_code error; given.find_first_not_of('.') == std::string::npos && fs::is_directory(given, error))
    return failure(FaultKind::bad_file, given, fmt::format("is a folder, expected a {}", kind.what));
  if (const auto other = recognise_other_format(given); !other.empty())
    return failure(FaultKind::bad_file, given, fmt::format("is {}, expected a {}", other, kind.what));
  const auto names = shipped_names(kind);
  auto what = fmt::format("is not a shipped {}", kind.what);
  if (const auto* other = find_other_kind(given, kind))
    what = fmt::format("is a shipped {}, not a {}", other, kind.what);
  for (const auto& file : {given, given + kExtension})
    if (std::error_code error; !given.empty() && fs::is_regular_file(file, error))
      what += fmt::format("; for the file of that name in this folder, write ./{}", file);
  auto near = find_nearest(as_file_name(given), names);
  if (near.empty()) near = find_containing(as_file_name(given), names);
  if (!near.empty()) what += fmt::format(", did you mean \"{}\"?", near);
  what += names.empty() ? "; none was found"
                        : fmt::format("{} {}", near.empty() ? "; there are" : " There are", fmt::join(names, ", "));
  auto looked_in = shipped_folders();
  for (auto& folder : looked_in) folder += std::string("/") + kind.folder;
  return failure(FaultKind::bad_file, fmt::format("\"{}\"", given),
                 what + fmt::format("; looked in {}", fmt::join(looked_in, ", ")));
}

}  // namespace gyrotherm
