// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/monitor.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <csignal>
#include <filesystem>
#include <list>
#include <memory>
#include <optional>
#include <thread>

#include "apps/monitor/notifier.hpp"
#include "apps/monitor/site_answers.hpp"
#include "apps/monitor/state_folder.hpp"
#include "apps/monitor/web_server.hpp"
#include "core/clock.hpp"
#include "core/process.hpp"
#include "core/sanitizer.hpp"

namespace gyrotherm::monitor {
namespace {

using std::chrono_literals::operator""s;
using std::chrono_literals::operator""ms;

constexpr auto kScanInterval = 500ms;
constexpr auto kReadInterval = 100ms;
constexpr auto kNotifyInterval = 1s;

/// Limits the resources of the process, so a flood of requests cannot impair other programs. The memory limit applies
/// to allocated memory including thread stacks; the systemd unit has a lower limit for used memory. Under a sanitizer,
/// which reserves terabytes, memory is not limited.
void limit_resources() {
  constexpr rlim_t kMaxDataBytes = rlim_t{192} * 1024 * 1024, kMaxFiles = 180;
  constexpr std::size_t kStackBytes = std::size_t{1024} * 1024;
  const rlimit data{kMaxDataBytes, kMaxDataBytes}, files{kMaxFiles, kMaxFiles};
  ::setrlimit(RLIMIT_NOFILE, &files);
  if (kIsSanitizerBuild) return;
  ::setrlimit(RLIMIT_DATA, &data);
  ::mallopt(M_ARENA_MAX, 2);
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStackBytes);
  pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

struct Address {
  std::string host;
  int port{};
  [[nodiscard]] bool is_loopback() const { return host == "127.0.0.1" || host == "::1"; }
};

Result<Address> parse_address(const std::string& option, const std::string& text) {
  const auto invalid = [&] {
    return failure(FaultKind::usage, option + " " + text, "expected ADDRESS:PORT, such as 127.0.0.1:8321");
  };
  const auto colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0) return invalid();
  Address address{.host = text.substr(0, colon)};
  if (address.host.starts_with('[') && address.host.ends_with(']'))
    address.host = address.host.substr(1, address.host.size() - 2);
  if (address.host == "localhost") address.host = "127.0.0.1";
  const auto* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data() + colon + 1, end, address.port);
  if (error != std::errc{} || rest != end || address.port < 0 || address.port > 65535) return invalid();
  return address;
}

/// Returns the command that adds a user, for a message. It names the state folder, which under systemd is not the
/// default of the reader of the message.
std::string add_user_command(const std::string& state_folder, const char* role) {
  return fmt::format("gyrotherm-monitor user add NAME --role {} --state {}", role, state_folder);
}

Result<void> check_options(const MonitorOptions& options, const Address& address, bool has_users,
                           const std::string& state_folder) {
  const auto refuse = [](std::string where, std::string what) {
    return failure(FaultKind::usage, std::move(where), std::move(what));
  };
  std::error_code error;
  if (options.folders.empty()) return refuse("--folder", "is missing; give a folder with records");
  for (const auto& folder : options.folders)
    if (!std::filesystem::is_directory(folder, error)) return refuse("--folder " + folder, "is not a folder");
  if (options.certificate.empty() != options.key.empty())
    return refuse("--certificate", "must be given together with --key");
  if (options.control && !has_users)
    return refuse("--control", "requires users: " + add_user_command(state_folder, "operator"));
  if (options.behind_proxy && !options.certificate.empty())
    return refuse("--behind-proxy", "cannot be combined with --certificate; the proxy has the certificate");
  if (options.behind_proxy && !address.is_loopback())
    return refuse("--behind-proxy", "requires --listen on 127.0.0.1 or [::1]");
  if (address.is_loopback()) return {};
  if (!has_users)
    return refuse("--listen " + options.listen,
                  "access from other machines requires users: " + add_user_command(state_folder, "viewer"));
  if (options.certificate.empty())
    return refuse("--listen " + options.listen,
                  "access from other machines requires TLS: --certificate and --key, or --behind-proxy on 127.0.0.1");
  return {};
}

/// Returns whether one of these blocked signals is pending.
bool is_any_pending(const sigset_t& signals) {
  sigset_t waiting;
  sigpending(&waiting);
  return (sigismember(&signals, SIGINT) == 1 && sigismember(&waiting, SIGINT) == 1) ||
         (sigismember(&signals, SIGTERM) == 1 && sigismember(&waiting, SIGTERM) == 1);
}

std::string url_host(const std::string& host) { return host.find(':') == std::string::npos ? host : "[" + host + "]"; }

/// A thread that calls a function at intervals. The destructor stops it.
class PeriodicThread {
 public:
  template <class Work>
  PeriodicThread(Duration interval, Work work)
      : thread_([this, interval, work = std::move(work)] {
          block_signals();
          while (!stopped_) {
            work();
            for (Duration slept{}; slept < interval && !stopped_; slept += 50ms)
              std::this_thread::sleep_for(std::min<Duration>(interval, 50ms));
          }
        }) {}
  ~PeriodicThread() {
    stopped_ = true;
    thread_.join();
  }
  PeriodicThread(const PeriodicThread&) = delete;
  PeriodicThread& operator=(const PeriodicThread&) = delete;

 private:
  std::atomic<bool> stopped_{false};
  std::thread thread_;
};

/// Blocks SIGINT and SIGTERM in this thread and in threads that it starts later. Returns these signals.
sigset_t block_end_signals() {
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGINT);
  sigaddset(&ends, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  return ends;
}

/// Loads the certificate, or returns nothing if the options have none. Fails like TlsServer::load.
Result<std::optional<TlsServer>> load_tls(const MonitorOptions& options) {
  if (options.certificate.empty()) return std::optional<TlsServer>();
  auto loaded = TlsServer::load(options.certificate, options.key);
  if (!loaded) return failure(loaded.error());
  return std::optional(std::move(*loaded));
}

/// The parts that need a site file; null without one.
struct SiteParts {
  std::unique_ptr<SiteOverview> overview;
  std::unique_ptr<Notifier> notifier;
};

/// Reads the site file. Fails like read_site and Notifier::load.
Result<SiteParts> open_site(const MonitorOptions& options, const std::string& memory_file,
                            const RunCatalogue& catalogue, const Clock& clock,
                            const std::function<void(const Fault&)>& report_fault) {
  SiteParts parts;
  if (options.site_file.empty()) return parts;
  auto site = read_site(options.site_file);
  if (!site) return failure(site.error());
  parts.overview = std::make_unique<SiteOverview>(site->name, site->has_store ? options.site_file : "");
  parts.notifier = std::make_unique<Notifier>(std::move(*site), memory_file, catalogue, clock, report_fault);
  if (auto loaded = parts.notifier->load(); !loaded) return failure(loaded.error());
  return parts;
}

/// The web server with all parts that answer its requests.
class PageServer {
 public:
  /// Creates the server. `tls` and `overview` may be null.
  PageServer(const MonitorOptions& options, const Address& address, const TlsServer* tls, Users& users,
             Sessions& sessions, const RunCatalogue& catalogue, RunFeed& feed, SiteOverview* overview,
             const Clock& clock)
      : access_({.control = options.control, .allows_guests = address.is_loopback() && !options.behind_proxy}, users,
                sessions, clock),
        runs_(catalogue, feed, [this] { return server_.is_stopping(); }),
        control_(access_, catalogue, clock),
        site_(access_, runs_, control_, catalogue, feed, overview),
        server_({.address = address.host,
                 .port = address.port,
                 .hosts = options.hosts,
                 .tls = tls,
                 .behind_proxy = options.behind_proxy},
                [this](const WebRequest& request) { return site_.answer(request); }) {}

  [[nodiscard]] WebServer& server() { return server_; }
  [[nodiscard]] RunAnswers& runs() { return runs_; }

 private:
  AccessControl access_;
  RunAnswers runs_;
  RunControl control_;
  SiteAnswers site_;
  WebServer server_;
};

/// Runs the threads of the monitor until one of the signals `ends` arrives. Calls `started` once the threads run.
/// `notifier` may be null.
void serve_until_signal(const sigset_t& ends, PageServer& page, RunCatalogue& catalogue, RunFeed& feed,
                        Notifier* notifier, const std::function<void()>& started) {
  auto& server = page.server();
  std::list<PeriodicThread> scan_threads;
  for (const auto& records : catalogue.folders())
    scan_threads.emplace_back(kScanInterval,
                              [&, records] { catalogue.scan_folder(records, [&] { return server.is_stopping(); }); });
  const PeriodicThread feed_thread(kReadInterval, [&] { feed.read(); });
  const PeriodicThread overview_thread(kReadInterval, [&] { page.runs().update_overviews(); });
  const PeriodicThread notifier_thread(kNotifyInterval, [&] {
    if (notifier != nullptr) notifier->notify_due();
  });
  std::thread server_thread([&] {
    block_signals();
    server.serve();
  });
  started();
  int signal = 0;
  sigwait(&ends, &signal);
  feed.stop();
  server.stop();
  server_thread.join();
}

}  // namespace

Result<void> serve(const MonitorOptions& options, const std::function<void(const std::string&)>& report_address,
                   const std::function<void(const Fault&)>& report_fault) {
  limit_resources();
  const auto ends = block_end_signals();
  const auto folder = resolve_state_folder(options.state_folder);
  if (auto made = make_state_folder(folder); !made) return made;
  const SteadyClock clock;
  Users users(folder + "/" + kUsersFile);
  if (auto loaded = users.load(); !loaded) return loaded;
  Sessions sessions(folder + "/" + kSessionsFile, clock);
  if (auto loaded = sessions.load(); !loaded) return loaded;
  const auto address = parse_address("--listen", options.listen);
  if (!address) return failure(address.error());
  if (auto good = check_options(options, *address, users.has_any(), folder); !good) return good;
  const auto tls = load_tls(options);
  if (!tls) return failure(tls.error());

  RunCatalogue catalogue(options.folders);
  const auto site = open_site(options, folder + "/" + kNotificationsFile, catalogue, clock, report_fault);
  if (!site) return failure(site.error());
  RunFeed feed(catalogue);
  PageServer page(options, *address, *tls ? &**tls : nullptr, users, sessions, catalogue, feed, site->overview.get(),
                  clock);
  const auto port = page.server().bind();
  if (!port) return failure(port.error());
  catalogue.scan([&] { return is_any_pending(ends); });
  if (is_any_pending(ends)) return {};
  serve_until_signal(ends, page, catalogue, feed, site->notifier.get(), [&] {
    report_address(fmt::format("{}://{}:{}/", *tls ? "https" : "http", url_host(address->host), *port));
  });
  return {};
}

}  // namespace gyrotherm::monitor
