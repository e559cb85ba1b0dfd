// SPDX-License-Identifier: Apache-2.0
/// The gyrotherm-monitor program: serves the live page of the runs in one or more folders, and manages its users.
#include <fmt/format.h>
#include <pwd.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <iostream>
#include <span>
#include <string>

#include "apps/monitor/monitor.hpp"
#include "apps/monitor/state_folder.hpp"
#include "apps/monitor/users.hpp"
#include "core/file.hpp"
#include "core/program_start.hpp"
#include "core/text.hpp"

namespace gyrotherm::monitor {
namespace {

constexpr int kUsageExit = 2, kFileExit = 4;

int exit_code(const Fault& fault) { return fault.kind == FaultKind::usage ? kUsageExit : kFileExit; }

/// Terminal settings to restore after the password prompt.
termios saved_terminal{};

/// Signal handler during the password prompt. Restores the echo of the terminal and ends the program.
void restore_echo_and_exit(int number) {
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &saved_terminal);
  std::signal(number, SIG_DFL);
  // The signal is delivered when this handler returns.
  std::raise(number);
}

/// Reads a line from stdin. If stdin is a terminal, prints a prompt and hides the input.
std::string read_password() {
  const bool is_terminal = ::isatty(STDIN_FILENO) == 1;
  if (is_terminal) {
    write_to_stderr("Password: ");
    ::tcgetattr(STDIN_FILENO, &saved_terminal);
    for (const int number : {SIGHUP, SIGINT, SIGQUIT, SIGTERM}) std::signal(number, restore_echo_and_exit);
    auto without_echo = saved_terminal;
    without_echo.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &without_echo);
  }
  std::string password;
  std::getline(std::cin, password);
  if (is_terminal) {
    ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &saved_terminal);
    write_to_stderr("\n");
  }
  return password;
}

struct UserArguments {
  std::string state;
  std::string name;
  std::string role = "viewer";
};

/// Fails if root changes a folder that belongs to another user. The file would belong to root, so the monitor could not
/// read it and would refuse all logins.
Result<void> check_owner(const std::string& folder) {
  struct stat facts {};
  if (::geteuid() != 0 || ::stat(folder.c_str(), &facts) != 0 || facts.st_uid == 0) return {};
  const auto* owner = ::getpwuid(facts.st_uid);
  const auto user = owner != nullptr ? std::string(owner->pw_name) : fmt::format("#{}", facts.st_uid);
  return failure(FaultKind::bad_file, folder,
                 fmt::format("belongs to {0}; run the command as that user: sudo -u {0} gyrotherm-monitor …", user));
}

Result<std::string> users_file(const UserArguments& options) {
  const auto folder = resolve_state_folder(options.state);
  return make_state_folder(folder).map([&] { return folder + "/" + kUsersFile; });
}

/// Reads the list of users, applies a change, and writes the list.
template <class Change>
Result<void> change_users(const UserArguments& options, Change change) {
  const auto file = users_file(options);
  if (!file) return failure(file.error());
  if (auto good = check_owner(parent_folder(*file)); !good) return good;
  auto list = read_users(*file);
  if (!list) return failure(list.error());
  if (auto changed = change(*list); !changed) return failure(changed.error());
  return write_users(*file, *list);
}

Result<void> add_user(const UserArguments& options) {
  std::string replaced_role;
  auto changed = change_users(options, [&](UserList& list) {
    const auto known = std::ranges::find(list.users, options.name, &User::name);
    if (known != list.users.end()) replaced_role = name(known->role);
    return add_or_replace_user(list, options.name, *find_role(options.role), read_password());
  });
  if (changed && !replaced_role.empty())
    write_to_stderr(
        fmt::format("{}: replaced the password; role {} → {}\n", options.name, replaced_role, options.role));
  return changed;
}

/// Adds a token and prints it. If it cannot be printed, does not store it.
Result<void> add_token(const UserArguments& options) {
  const auto add = [&](UserList& list) {
    return add_or_replace_token(list, options.name, *find_role(options.role)).and_then([](const std::string& secret) {
      auto printed = write_to_stdout(secret + "\n");
      return printed && is_stdout_closed() ? failure(FaultKind::storage, "stdout", "is closed, so no token was created")
                                           : printed;
    });
  };
  if (auto added = change_users(options, add); !added) return added;
  write_to_stderr(
      "Store this token; it cannot be printed again. A script sends it in the header \"Authorization: Bearer …\".\n");
  return {};
}

Result<void> remove_user(const UserArguments& options) {
  return change_users(options, [&](UserList& list) { return remove_user_or_token(list, options.name); });
}

Result<void> list_users(const UserArguments& options) {
  const auto list = read_users(resolve_state_folder(options.state) + "/" + kUsersFile);
  if (!list) return failure(list.error());
  std::string lines;
  for (const auto& user : list->users) lines += fmt::format("{:<14} {}\n", name(user.role), user.name);
  for (const auto& token : list->tokens) lines += fmt::format("{:<14} {} (token)\n", name(token.role), token.name);
  return write_to_stdout(lines);
}

/// Adds the commands "user" and "token" with their subcommands. Parsing sets `action` to the function of the given one.
void add_user_commands(CLI::App& cli, UserArguments& options, Result<void> (*&action)(const UserArguments&)) {
  const auto add = [&](CLI::App& parent, const char* name, const char* help,
                       Result<void> (*function)(const UserArguments&), bool has_name, bool has_role) {
    auto& command = *parent.add_subcommand(name, help);
    if (has_name) command.add_option("name", options.name, "1 to 64 letters, digits and _ . @ -")->required();
    if (has_role)
      command
          .add_option("--role", options.role,
                      "viewer: views runs; operator: also controls runs; administrator: also ends sessions")
          ->required()
          ->check(CLI::IsMember({"viewer", "operator", "administrator"}));
    command.add_option("--state", options.state, "folder of the monitor's users and sessions");
    command.callback([&action, function] { action = function; });
  };
  auto& user = *cli.add_subcommand("user", "Example: gyrotherm-monitor user add ada --role operator\n\nManages users.");
  user.require_subcommand(1);
  add(user, "add",
      "Adds a user, or changes the role and password of one. Prompts for the password or reads it from stdin.",
      add_user, true, true);
  add(user, "list", "Lists users and tokens.", list_users, false, false);
  add(user, "remove", "Removes a token, or a user together with the user's sessions.", remove_user, true, false);
  auto& token = *cli.add_subcommand(
      "token", "Example: gyrotherm-monitor token add prometheus --role viewer\n\nManages tokens for scripts.");
  token.require_subcommand(1);
  add(token, "add", "Creates a token and prints it. It cannot be printed again.", add_token, true, true);
}

void add_serve_options(CLI::App& cli, MonitorOptions& options) {
  cli.add_option("--folder", options.folders, "folder with records; repeat for further folders");
  cli.add_option("--listen", options.listen, "ADDRESS:PORT; port 0 selects a free port")->capture_default_str();
  cli.add_option("--host", options.hosts, "additional host name of the page")->check([](const std::string& host) {
    return host.find_first_of("/@ ") == std::string::npos
               ? std::string()
               : "\"" + host + "\" is not a host name, expected one such as rig.example.org, without http:// and port";
  });
  cli.add_option("--site", options.site_file, "site file with the notification rules (docs/monitor.md)");
  cli.add_option("--state", options.state_folder, "folder of the monitor's users and sessions");
  cli.add_flag("--control", options.control, "permit operators to control runs");
  cli.add_option("--certificate", options.certificate, "certificate chain in PEM, for TLS");
  cli.add_option("--key", options.key, "private key of the certificate in PEM");
  cli.add_flag("--behind-proxy", options.behind_proxy,
               "accept requests from a proxy on this machine that terminates TLS and forwards the client address");
}

int run(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App cli(
      "Example: gyrotherm-monitor --folder runs --listen 127.0.0.1:8321\n\n"
      "gyrotherm-monitor shows the runs in a folder of records live in a browser. If no users are defined, the page is "
      "read-only and available only on this machine.",
      "gyrotherm-monitor");
  cli.set_version_flag("--version", std::string("gyrotherm-monitor ") + GYROTHERM_VERSION);
  MonitorOptions options;
  UserArguments user;
  Result<void> (*action)(const UserArguments&) = nullptr;
  add_serve_options(cli, options);
  add_user_commands(cli, user, action);
  refuse_invalid_values(cli);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return cli.exit(error);
    const auto cause = find_error_cause(error.what(), cli, std::span(argv, static_cast<std::size_t>(argc)));
    write_to_stderr(fmt::format("gyrotherm-monitor: {}\nRun with --help for more information.\n", cause));
    return kUsageExit;
  }
  if (user.state.empty()) user.state = options.state_folder;
  const auto report_address = [](const std::string& address) {
    [[maybe_unused]] const auto written = write_to_stdout(address + "\n");
  };
  const auto report_fault = [](const Fault& fault) {
    write_to_stderr(fmt::format("gyrotherm-monitor: {}\n", plain(text(fault), Blanks::kept)));
  };
  const auto done = action != nullptr ? action(user) : serve(options, report_address, report_fault);
  if (done) return 0;
  report_fault(done.error());
  return exit_code(done.error());
}

}  // namespace
}  // namespace gyrotherm::monitor

int main(int argc, char** argv) {
  gyrotherm::open_standard_descriptors();
  return gyrotherm::monitor::run(argc, argv);
}
