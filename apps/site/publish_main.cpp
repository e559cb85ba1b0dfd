// SPDX-License-Identifier: Apache-2.0
/// The gyrotherm-publish program: sends the runs of this rig to the store of its site.
#include <fmt/format.h>
#include <sys/signalfd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <string>
#include <thread>
#include <vector>

#include "acquisition/record/run_finder.hpp"
#include "apps/site/folders.hpp"
#include "apps/site/live/live_rig.hpp"
#include "apps/site/programs.hpp"
#include "apps/site/publisher.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/process.hpp"
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

void say(const std::string& line) { write_to_stderr(plain(line) + "\n"); }

void complain(const Fault& fault) { say("gyrotherm-publish: " + text(fault)); }

std::string in_lines(const std::vector<RunLag>& lags) {
  std::string lines;
  for (const auto& lag : lags) {
    const auto where = !lag.trouble.empty()    ? lag.trouble
                       : lag.finished_in_store ? "is in the store"
                       : lag.in_store < 0      ? "not in the store yet"
                                               : fmt::format("{} s behind", lag.seconds());
    lines += fmt::format("{}: {}\n", lag.name, plain(where));
  }
  return lines;
}

std::string in_json(const std::vector<RunLag>& lags) {
  Json list = Json::array();
  for (const auto& lag : lags)
    list.push_back({{"record", lag.name},
                    {"state", lag.state},
                    {"slot", lag.here},
                    {"slot_in_store", lag.in_store},
                    {"lag_s", lag.seconds()},
                    {"finished_in_store", lag.finished_in_store},
                    {"trouble", lag.trouble}});
  return text_of(list) + "\n";
}

/// Says once a second how the rig is, until it is stopped; the store may answer or not meanwhile.
void tell_live(LiveRig& rig, const std::vector<std::string>& folders, const std::stop_token& stop) {
  block_signals();
  while (!stop.stop_requested()) {
    const Deadline next(std::chrono::seconds(1));
    std::vector<std::string> records;
    for (const auto& folder : folders_below(folders))
      for (const auto& path : record::records_in(folder)) records.push_back(path);
    rig.look(records);
    sleep_unless_stopped(stop, next.left());
  }
}

Result<void> serve(Publisher& publisher, const SiteSettings& settings) {
  if (!settings.live) return publisher.serve();
  auto rig = LiveRig::connect(*settings.live, {.site = settings.name, .rig = settings.rig}, complain);
  if (!rig) return failure(rig.error());
  const std::jthread telling([&](const std::stop_token& stop) { tell_live(**rig, settings.folders, stop); });
  return publisher.serve();
}

Result<void> publish(const PublishOptions& options, int stop) {
  auto settings = read_site(options.site);
  if (!settings) return failure(settings.error());
  Publisher publisher(*settings, stop, say, complain);
  if (options.once) return publisher.once();
  if (!options.status) return serve(publisher, *settings);
  return publisher.lags().and_then(
      [&](const std::vector<RunLag>& lags) { return write_to_stdout(options.json ? in_json(lags) : in_lines(lags)); });
}

int run_publish(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App cli(
      "Example: gyrotherm-publish --site /etc/gyrotherm/site.toml\n\n"
      "gyrotherm-publish sends the runs of this rig to the PostgreSQL store of its site: finished ones whole, running "
      "ones second by second. It reads records and changes none.",
      "gyrotherm-publish");
  cli.set_version_flag("--version", std::string("gyrotherm-publish ") + GYROTHERM_VERSION);
  PublishOptions options;
  cli.add_option("--site", options.site, "the site file")->required();
  auto* once = cli.add_flag("--once", options.once, "send what is there now, and end");
  auto* status = cli.add_flag("--status", options.status, "say how far the store is behind, and end");
  status->excludes(once);
  cli.add_flag("--json", options.json, "the status as JSON")->needs(status);
  if (const auto code = parsed(cli, argc, argv)) return *code;
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGINT);
  sigaddset(&ends, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  const Descriptor stop(::signalfd(kNoDescriptor, &ends, SFD_CLOEXEC | SFD_NONBLOCK));
  const auto done = publish(options, stop.number());
  return done ? kDoneExit : exit_of(cli.get_name(), done.error());
}

}  // namespace
}  // namespace gyrotherm::site

int main(int argc, char** argv) {
  gyrotherm::open_standard_descriptors();
  return gyrotherm::site::run_publish(argc, argv);
}
