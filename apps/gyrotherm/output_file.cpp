// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/output_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "acquisition/record/record_files.hpp"
#include "acquisition/record/status.hpp"
#include "core/file.hpp"
#include "sequencer/control/control_socket.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"

namespace gyrotherm::app {
namespace {

namespace fs = std::filesystem;

/// Returns whether a run is writing a record with this name, or died while it wrote one.
bool has_run_files(const std::string& path) {
  return record::path_exists(record::status_path(path)) || record::path_exists(control::control_socket_path(path)) ||
         record::path_exists(watchdog::safe_state_path(path));
}

/// Returns the record that a file belongs to by its name: "run.db" for "run.db-wal". Returns an empty string for other
/// names.
std::string owning_record(const std::string& path) {
  const auto ending = record::reserved_ending(path);
  return ending.empty() ? std::string() : path.substr(0, path.size() - ending.size());
}

Result<void> check_not_record(const std::string& path) {
  const auto refused = [&](std::string_view what) {
    return failure(FaultKind::usage, path, fmt::format("{}, and a record is never overwritten", what));
  };
  std::error_code error;
  const auto target = fs::weakly_canonical(path, error).string();
  if (record::is_live_copy(path)) return refused("is the live copy of a record");
  if (has_run_files(path) || has_run_files(target)) return refused("is the name of a run's record");
  const auto sqlite = begins_with(path, kSqliteBeginning);
  if (!sqlite) return failure(sqlite.error());
  if (*sqlite) return refused("is an SQLite file, like a record");
  const auto record = owning_record(path);
  if (record.empty()) return {};
  const auto belongs = begins_with(record, kSqliteBeginning);
  if (!belongs) return failure(belongs.error());
  return *belongs ? refused("belongs to " + record) : Result<void>{};
}

}  // namespace

void add_force_flag(CLI::App& command, bool& force) {
  command.add_flag("--force", force, "overwrite an existing file, but never a record");
}

Result<void> check_can_create(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return failure(FaultKind::usage, path, "is a folder, expected the name of a file");
  if (const auto folder = parent_folder(path); !fs::is_directory(folder, error))
    return failure(FaultKind::usage, path, fmt::format("the folder {} does not exist", folder));
  if (const auto folder = parent_folder(path); ::access(folder.c_str(), W_OK) != 0)
    return failure(
        FaultKind::storage, path,
        fmt::format("the folder {} cannot be written to: {}", folder, std::generic_category().message(errno)));
  return {};
}

Result<void> check_is_toml(const std::string& path, const char* content) {
  if (path.ends_with(".toml")) return {};
  return failure(FaultKind::usage, "--out", fmt::format("{} does not end in .toml, as {} does", path, content));
}

Result<void> check_is_free(const std::string& path, bool force) {
  if (auto can_create = check_can_create(path); !can_create) return can_create;
  if (auto free = check_not_record(path); !free) return free;
  if (path.ends_with(".db"))
    return failure(FaultKind::usage, path, "ends in .db, as a record does; expected another ending");
  std::error_code error;
  if (force || !fs::exists(path, error)) return {};
  return failure(FaultKind::usage, path, "exists; --force overwrites it");
}

}  // namespace gyrotherm::app
