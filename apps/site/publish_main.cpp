// SPDX-License-Identifier: Apache-2.0
/// The gyrotherm-publish program: sends the runs of this rig to the store of its site.
#include <fmt/format.h>
#include <sys/signalfd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <string>
#include <vector>

#include "apps/site/programs.hpp"
#include "apps/site/publisher.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/program_start.hpp"
#include "core/text.hpp"

namespace gyrotherm::site {
namespace {

struct PublishOptions {
  std::string site;
  bool once = false;
  bool status = false;
  bool json = false;
};

void print_line(const std::string& line) { write_to_stderr(plain(line) + "\n"); }

void print_fault(const Fault& fault) { print_line("gyrotherm-publish: " + text(fault)); }

std::string format_lines(const std::vector<RunLag>& lags) {
  std::string lines;
  for (const auto& lag : lags) {
    const auto where = !lag.error.empty()      ? lag.error
                       : lag.finished_in_store ? "complete in the store"
                       : lag.slot_in_store < 0 ? "not in the store yet"
                                               : fmt::format("{} s behind the rig", lag.seconds());
    lines += fmt::format("{}: {}\n", lag.name, plain(where));
  }
  return lines;
}

std::string format_json(const std::vector<RunLag>& lags) {
  Json list = Json::array();
  for (const auto& lag : lags)
    list.push_back({{"record", lag.name},
                    {"state", lag.state},
                    {"slot", lag.slot_on_rig},
                    {"slot_in_store", lag.slot_in_store},
                    {"lag_s", lag.seconds()},
                    {"finished_in_store", lag.finished_in_store},
                    {"trouble", lag.error}});
  return json_text(list) + "\n";
}

Result<void> publish(const PublishOptions& options, int stop) {
  auto settings = read_site(options.site);
  if (!settings) return failure(settings.error());
  Publisher publisher(*settings, stop, print_line, print_fault);
  if (options.once) return publisher.send_once();
  if (!options.status) return publisher.serve();
  return publisher.read_lags().and_then([&](const std::vector<RunLag>& lags) {
    return write_to_stdout(options.json ? format_json(lags) : format_lines(lags)).and_then([&] {
      return publisher.check_folders();
    });
  });
}

int run_publish(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App cli(
      "Example: gyrotherm-publish --site /etc/gyrotherm/site.toml\n\n"
      "gyrotherm-publish sends the runs of this rig to the PostgreSQL store of its site: finished runs as a whole, "
      "running ones second by second. It only reads records.",
      "gyrotherm-publish");
  cli.set_version_flag("--version", std::string("gyrotherm-publish ") + GYROTHERM_VERSION);
  PublishOptions options;
  cli.add_option("--site", options.site, "site file")->required();
  auto* once = cli.add_flag("--once", options.once, "send all present data and exit");
  auto* status = cli.add_flag("--status", options.status, "print the lag of the store and exit");
  status->excludes(once);
  cli.add_flag("--json", options.json, "print the status as JSON")->needs(status);
  if (const auto code = parse_command_line(cli, argc, argv)) return *code;
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGINT);
  sigaddset(&ends, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  const Descriptor stop(::signalfd(kNoDescriptor, &ends, SFD_CLOEXEC | SFD_NONBLOCK));
  const auto done = publish(options, stop.number());
  return done ? kDoneExit : report_fault(cli.get_name(), done.error());
}

}  // namespace
}  // namespace gyrotherm::site

int main(int argc, char** argv) {
  gyrotherm::open_standard_descriptors();
  return gyrotherm::site::run_publish(argc, argv);
}
