#include "acquisition/record/manifest.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "acquisition/record/run_parts.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"

namespace gyrotherm {
namespace {

std::string name_of(const std::string& path) { return std::filesystem::path(path).filename().string(); }

Result<std::string> hash_of(const std::string& path) {
  const auto file = open_regular_file(path);
  if (!file) return failure(file.error());
  Sha256 hash;
  std::array<char, 65536> piece;
  for (std::uint64_t left = file->size; left > 0;) {
    const auto count = ::read(file->descriptor.number(), piece.data(), std::min<std::uint64_t>(piece.size(), left));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failure(FaultKind::bad_file, path, std::string("cannot be read: ") + std::strerror(errno));
    if (count == 0) return failure(FaultKind::bad_file, path, "cannot be read: it became shorter meanwhile");
    hash.add({piece.data(), static_cast<std::size_t>(count)});
    left -= static_cast<std::uint64_t>(count);
  }
  return hex(hash.digest());
}

}  // namespace

std::string manifest_path(const std::string& record_path) { return record_path + ".sha256"; }

Result<void> write_manifest(const std::string& record_path, int last_part) {
  std::string text;
  for (int part = 1; part <= last_part; ++part)
    for (const char* suffix : {"", "-wal"}) {
      const auto path = part_path(record_path, part) + suffix;
      if (!is_there(path)) continue;
      const auto hash = hash_of(path);
      if (!hash) return failure(FaultKind::storage, hash.error().where, hash.error().what);
      text += fmt::format("{}  {}\n", *hash, name_of(path));
    }
  return replace_own_file(manifest_path(record_path), text);
}

Result<std::optional<std::set<std::string>>> check_manifest(const std::string& record_path) {
  const auto refuse = [&](const char* why) { return failure(FaultKind::bad_file, manifest_path(record_path), why); };
  const auto text = read_text_file_if_any(manifest_path(record_path));
  if (!text) return failure(text.error());
  if (!*text) return std::nullopt;
  const auto folder = std::filesystem::path(record_path).parent_path();
  std::istringstream lines(**text);
  std::set<std::string> names;
  for (std::string line; std::getline(lines, line);) {
    constexpr std::size_t kName = 66;  // after 64 digits and two blanks
    if (line.size() <= kName) return refuse("is no manifest");
    const auto name = name_of(line.substr(kName));
    const auto path = (folder / name).string();
    const auto hash = hash_of(path);
    if (!hash) return failure(hash.error());
    if (*hash != line.substr(0, 64))
      return failure(FaultKind::bad_file, path, "is not as it was when the run was closed");
    names.insert(name);
  }
  if (!names.contains(name_of(record_path))) return refuse("does not name the record");
  for (const auto& name : names)
    if (const auto log = name + "-wal"; !names.contains(log) && is_there((folder / log).string()))
      return failure(FaultKind::bad_file, (folder / log).string(), "was not there when the run was closed");
  return names;
}

}  // namespace gyrotherm
