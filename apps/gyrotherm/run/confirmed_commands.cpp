// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/confirmed_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include "acquisition/record/chain.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/sha256.hpp"
#include "core/toml_text.hpp"
#include "sequencer/rig/line_settings.hpp"

namespace gyrotherm::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSchema = "gyrotherm-confirmed-command/1";
constexpr const char* kTrustHint = "\"gyrotherm resume RUN.db --trust-commands\" starts it anyway";

/// Returns the commands that a real rig starts. A virtual line has no program.
std::vector<drivers::ProgramCommand> list_commands(const rig::RigFile& rig) {
  std::vector<drivers::ProgramCommand> commands;
  for (const auto& thermometer : rig.thermometers)
    if (!thermometer.command.words.empty() && thermometer.line != rig::kVirtualLine)
      commands.push_back(thermometer.command);
  return commands;
}

std::string absolute_path(const std::string& path) {
  std::error_code error;
  const auto whole = fs::absolute(path, error).lexically_normal();
  return whole.has_filename() ? whole.string() : whole.parent_path().string();  // "rigs/." ends with a slash
}

/// Returns the confirmed subject without the content of its files.
std::string confirmed_subject(const std::string& rig_file, const drivers::ProgramCommand& command) {
  std::vector<std::string> words;
  for (const auto& word : command.words) words.push_back(toml_quoted(word));
  return fmt::format("schema = \"{}\"\nrig = {}\nfolder = {}\ncommand = [{}]\n", kSchema,
                     toml_quoted(rig_file.empty() ? "" : absolute_path(rig_file)),
                     toml_quoted(absolute_path(command.folder)), fmt::join(words, ", "));
}

bool is_packaged(const std::string& file) {
  std::error_code error;
  const auto real = fs::canonical(file, error).string();
  return !error && real.starts_with("/usr/") && !real.starts_with("/usr/local/");
}

std::string file_line(const std::string& file) {
  if (is_packaged(file)) return fmt::format("package = {}\n", toml_quoted(file));
  const auto digest = record::file_digest(file);
  return fmt::format("file = [{}, \"{}\"]\n", toml_quoted(file), digest ? *digest : "unreadable");
}

/// Returns the file that an interpreter would run: the first argument that names a file.
std::optional<std::string> find_script(const drivers::ProgramCommand& command) {
  for (std::size_t i = 1; i < command.words.size(); ++i) {
    const auto& word = command.words[i];
    std::error_code error;
    const auto file = fs::path(absolute_path(command.folder)) / word;
    if (!word.empty() && !word.starts_with('-') && fs::is_regular_file(file, error)) return file.string();
  }
  return {};
}

std::string confirmation_path(const std::string& folder, const std::string& rig_file,
                              const drivers::ProgramCommand& command) {
  return fmt::format("{}/{}.toml", folder, sha256(confirmed_subject(rig_file, command)));
}

/// Returns how another user could have written the file, or an empty string.
std::string ownership_problem(const std::string& path) {
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0) return path + " cannot be read";
  if (found.st_uid != ::geteuid() && found.st_uid != 0)
    return fmt::format("{} belongs to {}", path, describe_user(found.st_uid));
  return (found.st_mode & (S_IWGRP | S_IWOTH)) == 0 ? "" : path + " is writable by users other than its owner";
}

Result<void> check_command(const std::string& folder, const std::string& rig_file,
                           const drivers::ProgramCommand& command) {
  const auto refuse = [&](const std::string& why) {
    return failure(FaultKind::refused, "command " + text(command), fmt::format("{}; {}", why, kTrustHint));
  };
  const auto path = confirmation_path(folder, rig_file, command);
  const auto kept = folder.empty() ? std::optional<std::string>()
                                   : read_text_file_if_any(path, kLargestText, Links::refused).value_or(std::nullopt);
  if (!kept)
    return refuse(fmt::format("not started: this user has not confirmed it by a run of the rig file {}",
                              rig_file.empty() ? "of this record, which is not named" : rig_file));
  for (const auto& name : {folder, path})
    if (const auto why = ownership_problem(name); !why.empty()) return refuse("not started: " + why);
  if (*kept != confirmation_text(rig_file, command))
    return refuse("not started: its program or script has changed since it was confirmed");
  return {};
}

}  // namespace

std::string confirmed_commands_folder() {
  constexpr const char* kOwn = "/gyrotherm/confirmed-commands";
  if (const char* state = std::getenv("XDG_STATE_HOME"); state && *state == '/') return std::string(state) + kOwn;
  if (const char* home = std::getenv("HOME"); home && *home == '/') return std::string(home) + "/.local/state" + kOwn;
  return {};
}

std::string confirmation_text(const std::string& rig_file, const drivers::ProgramCommand& command) {
  auto text = confirmed_subject(rig_file, command);
  auto resolved = command;
  resolved.folder = absolute_path(command.folder);
  if (const auto program = drivers::find_program(resolved)) text += file_line(absolute_path(*program));
  if (const auto script = find_script(command)) text += file_line(absolute_path(*script));
  return text;
}

Result<void> confirm_commands(const std::string& rig_file, const rig::RigFile& rig) {
  const auto commands = list_commands(rig);
  if (commands.empty()) return {};
  const auto folder = confirmed_commands_folder();
  if (folder.empty())
    return failure(FaultKind::storage, "confirmed commands", "neither XDG_STATE_HOME nor HOME is set");
  std::error_code error;
  fs::create_directories(fs::path(folder).parent_path(), error);
  ::mkdir(folder.c_str(), S_IRWXU);
  for (const auto& command : commands)
    if (auto kept = replace_own_file(confirmation_path(folder, rig_file, command), confirmation_text(rig_file, command),
                                     Syncing::awaited, Readers::owner);
        !kept)
      return kept;
  return {};
}

Result<void> check_commands(const std::string& rig_file, const rig::RigFile& rig) {
  const auto folder = confirmed_commands_folder();
  for (const auto& command : list_commands(rig))
    if (auto known = check_command(folder, rig_file, command); !known) return known;
  return {};
}

}  // namespace gyrotherm::app
