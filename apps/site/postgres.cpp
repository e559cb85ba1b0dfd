// SPDX-License-Identifier: Apache-2.0
#include "apps/site/postgres.hpp"

#include <fmt/format.h>
#include <libpq-fe.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <array>
#include <charconv>
#include <cstring>

#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/text.hpp"

namespace gyrotherm::site {
namespace {

/// Joins the lines of a libpq message, which ends with a line break.
std::string join_lines(const char* message) {
  std::string line;
  for (const char* at = message; *at != '\0'; ++at) line += *at == '\n' ? ' ' : *at;
  return std::string(trimmed(line, " \t"));
}

/// Returns the fault kind for an SQLSTATE.
FaultKind fault_kind(std::string_view state) {
  if (state.size() != 5) return FaultKind::disconnected;
  const auto group = state.substr(0, 2);
  for (const char* permanent : {"0A", "22", "23", "28", "42", "P0", "3D", "3F"})
    if (group == permanent) return FaultKind::refused;
  return group == "08" || group == "57" ? FaultKind::disconnected : FaultKind::storage;
}

/// Checks the passfile. libpq ignores a passfile that other users may read, and would report a missing password.
Result<void> check_passfile(const std::string& path) {
  struct stat facts {};
  if (::stat(path.c_str(), &facts) != 0) return failure(FaultKind::bad_file, "passfile " + path, std::strerror(errno));
  if (!S_ISREG(facts.st_mode)) return failure(FaultKind::bad_file, "passfile " + path, "is not a regular file");
  if ((facts.st_mode & 077) != 0)
    return failure(FaultKind::bad_file, "passfile " + path, "is accessible to other users, expected mode 0600");
  return {};
}

/// Copies a credential to a private file in memory, which libpq accepts as a passfile.
Result<Descriptor> copy_credential(const std::string& path) {
  const auto content = read_text_file(path);
  if (!content) return failure(FaultKind::bad_file, "passfile " + path, content.error().what);
  Descriptor copy(::memfd_create("passfile", MFD_CLOEXEC));
  if (!copy.is_open() || ::fchmod(copy.number(), S_IRUSR | S_IWUSR) != 0 || !write_all(copy.number(), *content))
    return failure(FaultKind::storage, "passfile " + path, std::strerror(errno));
  return copy;
}

/// Returns whether `ports` are the ports of one or more hosts, such as "5432" or "5432,5433". An empty one is the
/// default.
bool are_ports(std::string_view ports) {
  for (;;) {
    const auto comma = ports.find(',');
    const auto one = ports.substr(0, comma);
    std::uint16_t port{};
    const auto [end, error] = std::from_chars(one.data(), one.data() + one.size(), port);
    if (!one.empty() && (error != std::errc{} || end != one.data() + one.size() || port == 0)) return false;
    if (comma == std::string_view::npos) return true;
    ports.remove_prefix(comma + 1);
  }
}

}  // namespace

Result<void> check_conninfo(const std::string& conninfo) {
  char* why = nullptr;
  const std::unique_ptr<PQconninfoOption, decltype(&PQconninfoFree)> options(PQconninfoParse(conninfo.c_str(), &why),
                                                                             PQconninfoFree);
  const std::unique_ptr<char, decltype(&PQfreemem)> message(why, PQfreemem);
  if (!options)
    return failure(FaultKind::usage, "connection to the store",
                   why != nullptr ? join_lines(why) : "is not a libpq connection string");
  for (const auto* option = options.get(); option->keyword != nullptr; ++option) {
    if (option->val != nullptr && std::string_view(option->keyword) == "port" && !are_ports(option->val))
      return failure(FaultKind::usage, "connection to the store",
                     fmt::format("port is \"{}\", expected 1 to 65535", option->val));
    if (option->val != nullptr && std::string_view(option->keyword).ends_with("password"))
      return failure(
          FaultKind::usage, "connection to the store",
          fmt::format("contains \"{}\", which other users can read; use a passfile instead", option->keyword));
  }
  return {};
}

void QueryResult::Clear::operator()(pg_result* result) const { PQclear(result); }

int QueryResult::rows() const { return PQntuples(result_.get()); }

int QueryResult::columns() const { return PQnfields(result_.get()); }

std::string QueryResult::name(int column) const { return PQfname(result_.get(), column); }

bool QueryResult::null(int row, int column) const { return PQgetisnull(result_.get(), row, column) == 1; }

std::string_view QueryResult::text(int row, int column) const { return PQgetvalue(result_.get(), row, column); }

std::int64_t QueryResult::integer(int row, int column) const {
  std::int64_t number{};
  const auto digits = text(row, column);
  std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return number;
}

bool QueryResult::boolean(int row, int column) const { return text(row, column) == "t"; }

unsigned QueryResult::type(int column) const { return PQftype(result_.get(), column); }

void Postgres::Finish::operator()(pg_conn* connection) const { PQfinish(connection); }

tl::unexpected<Fault> Postgres::make_connection_fault() const {
  const auto why = join_lines(PQerrorMessage(connection_.get()));
  return failure(FaultKind::disconnected, kStore, why.empty() ? "the connection is lost" : why);
}

Result<void> Postgres::wait(short events, Duration within) {
  std::array<pollfd, 2> lines{pollfd{PQsocket(connection_.get()), events, 0}, pollfd{limits_.stop, POLLIN, 0}};
  const Deadline deadline(within);
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline.left());
    const int found = ::poll(lines.data(), lines.size(), static_cast<int>(left.count()));
    if (found < 0 && errno == EINTR) continue;
    if (found < 0) return failure(FaultKind::disconnected, kStore, std::strerror(errno));
    if (lines[1].revents != 0) return failure(FaultKind::interrupted, kStore, "stopped");
    if (found > 0) return {};
    return failure(FaultKind::timeout, kStore, fmt::format("no response within {}", format_duration(within)));
  }
}

Result<void> Postgres::wait_until_connected() {
  const Deadline deadline(limits_.connect);
  if (PQstatus(connection_.get()) == CONNECTION_BAD) return make_connection_fault();
  for (auto doing = PGRES_POLLING_WRITING; doing != PGRES_POLLING_OK; doing = PQconnectPoll(connection_.get())) {
    if (doing == PGRES_POLLING_FAILED) return make_connection_fault();
    if (deadline.has_passed())
      return failure(FaultKind::timeout, kStore,
                     fmt::format("no connection within {}", format_duration(limits_.connect)));
    if (auto ready = wait(doing == PGRES_POLLING_READING ? POLLIN : POLLOUT, deadline.left()); !ready) return ready;
  }
  return {};
}

Result<Postgres> Postgres::connect(const StoreAddress& address, const WaitLimits& limits) {
  if (auto good = check_conninfo(address.conninfo); !good) return failure(good.error());
  auto passfile = address.passfile;
  Descriptor copy;  // libpq reads the passfile in PQconnectStartParams()
  if (address.is_credential) {
    auto copied = copy_credential(address.passfile);
    if (!copied) return failure(copied.error());
    copy = std::move(*copied);
    passfile = fmt::format("/proc/self/fd/{}", copy.number());
  } else if (!passfile.empty()) {
    if (auto good = check_passfile(passfile); !good) return failure(good.error());
  }
  std::vector<const char*> keys{"dbname", "application_name", "client_encoding"};
  std::vector<const char*> values{address.conninfo.c_str(), "gyrotherm", "UTF8"};
  if (!passfile.empty()) {
    keys.push_back("passfile");
    values.push_back(passfile.c_str());
  }
  keys.push_back(nullptr);
  values.push_back(nullptr);
  constexpr int kFirstIsConninfo = 1;
  Postgres made(PQconnectStartParams(keys.data(), values.data(), kFirstIsConninfo), limits);
  if (!made.connection_) return failure(FaultKind::storage, kStore, "no memory");
  if (auto connected = made.wait_until_connected(); !connected) {
    auto fault = connected.error();
    // libpq names the file whose password was wrong.
    if (const auto at = passfile.empty() ? std::string::npos : fault.what.find(passfile); at != std::string::npos)
      fault.what.replace(at, passfile.size(), address.passfile);
    return failure(std::move(fault));
  }
  PQsetnonblocking(made.connection_.get(), 1);
  PQsetNoticeProcessor(
      made.connection_.get(), [](void*, const char*) {}, nullptr);
  // JIT compilation of a query costs more time than it saves.
  if (auto set = made.execute("SET timezone = 'UTC'; SET datestyle = 'ISO'; SET jit = off"); !set)
    return failure(set.error());
  return made;
}

Result<void> Postgres::flush() {
  for (;;) {
    const int left = PQflush(connection_.get());
    if (left < 0) return make_connection_fault();
    if (left == 0) return {};
    if (auto ready = wait(POLLIN | POLLOUT, limits_.answer); !ready) return ready;
    if (PQconsumeInput(connection_.get()) == 0) return make_connection_fault();
  }
}

Result<void> Postgres::send(const std::string& statement, const std::vector<Parameter>& parameters) {
  std::vector<const char*> values;
  values.reserve(parameters.size());
  for (const auto& parameter : parameters) values.push_back(parameter ? parameter->c_str() : nullptr);
  constexpr int kText = 0;
  if (PQsendQueryParams(connection_.get(), statement.c_str(), static_cast<int>(values.size()), nullptr, values.data(),
                        nullptr, nullptr, kText) == 0)
    return make_connection_fault();
  return flush();
}

Result<QueryResult> Postgres::read_result() {
  std::optional<QueryResult> answer;
  std::optional<Fault> refused;
  for (;;) {
    while (PQisBusy(connection_.get()) != 0) {
      if (auto ready = wait(POLLIN, limits_.answer); !ready) return failure(ready.error());
      if (PQconsumeInput(connection_.get()) == 0) return make_connection_fault();
    }
    auto* result = PQgetResult(connection_.get());
    if (result == nullptr) break;
    answer.emplace(result);
    const auto status = PQresultStatus(result);
    if (status == PGRES_TUPLES_OK || status == PGRES_COMMAND_OK || refused) continue;
    const char* state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
    const char* message = PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
    refused = Fault{fault_kind(state != nullptr ? state : ""), kStore,
                    join_lines(message != nullptr ? message : PQresultErrorMessage(result))};
  }
  if (refused) return failure(std::move(*refused));
  if (!answer) return make_connection_fault();
  return std::move(*answer);
}

Result<QueryResult> Postgres::query(const std::string& statement, const std::vector<Parameter>& parameters) {
  return send(statement, parameters).and_then([&] { return read_result(); });
}

Result<void> Postgres::execute(const std::string& statements) {
  if (PQsendQuery(connection_.get(), statements.c_str()) == 0) return make_connection_fault();
  return flush().and_then([&] { return read_result(); }).map([](const QueryResult&) {});
}

bool Postgres::is_broken() const { return PQstatus(connection_.get()) != CONNECTION_OK; }

std::string Postgres::describe() const {
  const char* host = PQhost(connection_.get());
  const char* tls = PQsslAttribute(connection_.get(), "protocol");
  return fmt::format("host={} dbname={} user={}{}", host != nullptr ? host : "", PQdb(connection_.get()),
                     PQuser(connection_.get()), tls != nullptr ? fmt::format(", {}", tls) : ", without TLS");
}

}  // namespace gyrotherm::site
