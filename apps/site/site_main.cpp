// SPDX-License-Identifier: Apache-2.0
/// The gyrotherm-site program: creates and queries the store of a site, and distributes jobs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <string>
#include <string_view>
#include <vector>

#include "apps/site/job/commands.hpp"
#include "apps/site/migrate.hpp"
#include "apps/site/programs.hpp"
#include "apps/site/queries.hpp"
#include "apps/site/site_file.hpp"
#include "core/json.hpp"
#include "core/program_start.hpp"

namespace gyrotherm::site {
namespace {

struct SiteOptions {
  std::string site_file;
  std::string store;
  std::string passfile;
  bool json = false;
  int to = migrations().back().number;
  QueryOptions query;
};

Result<Postgres> connect_store(const SiteOptions& options) {
  if (!options.store.empty()) return Postgres::connect({options.store, options.passfile}, {});
  if (options.site_file.empty())
    return failure(FaultKind::usage, {}, "the address of the store is missing; give --store ADDRESS or --site FILE");
  return read_store(options.site_file).and_then([](const StoreAddress& store) { return Postgres::connect(store, {}); });
}

/// Prints a warning if the owner of the store may not end the session of a rig that blocks others, or if a rig's role
/// has no connection limit (docs/site.md).
Result<void> warn_about_rig_roles(Postgres& store) {
  const auto permitted = store.query(
      "SELECT pg_has_role(current_user, 'pg_signal_backend', 'MEMBER')"
      " AND pg_has_role(current_user, 'pg_read_all_stats', 'MEMBER')");
  if (!permitted) return failure(permitted.error());
  if (!permitted->boolean(0, 0))
    write_to_stderr(
        "warning: the owner of the store cannot end sessions of rigs that hold locks; "
        "grant it the roles pg_signal_backend and pg_read_all_stats\n");
  const auto unbounded = store.query(
      "SELECT string_agg(rolname, ', ' ORDER BY rolname) FROM pg_roles"
      " WHERE rolcanlogin AND NOT rolsuper AND rolconnlimit < 0 AND pg_has_role(oid, 'gyrotherm_rig', 'MEMBER')");
  if (!unbounded) return failure(unbounded.error());
  if (!unbounded->null(0, 0))
    write_to_stderr(
        fmt::format("warning: roles without a connection limit: {}; set one with ALTER ROLE … CONNECTION LIMIT 8\n",
                    unbounded->text(0, 0)));
  return {};
}

Result<int> run_migrations(const SiteOptions& options) {
  auto store = connect_store(options);
  if (!store) return failure(store.error());
  bool any = false;
  Result<void> printed;
  const auto migrated = migrate(*store, migrations(), options.to, [&](const Migration& step) {
    any = true;
    printed = write_to_stdout(fmt::format("migration {}: {}\n", step.number, step.name));
  });
  if (migrated && !any) printed = write_to_stdout("nothing to do\n");
  return migrated.and_then([&] { return warn_about_rig_roles(*store); }).and_then([&] { return printed; }).map([] {
    return kDoneExit;
  });
}

Result<int> print_result(const SiteOptions& options, const QueryResult& answer) {
  if (answer.rows() == 0 && !options.json) write_to_stderr("no rows\n");
  if (options.query.most > 0 && static_cast<std::size_t>(answer.rows()) == options.query.most)
    write_to_stderr("more rows may exist; use --most 0 to print all\n");
  return write_to_stdout(options.json ? format_rows_as_json(answer) : format_table(answer)).map([] {
    return kDoneExit;
  });
}

/// Prints how many rigs, runs, rows and calibrations the store contains, and its size.
Result<int> show_status(const SiteOptions& options) {
  auto store = connect_store(options);
  if (!store) return failure(store.error());
  const auto answer = store->query(
      "SELECT (SELECT max(number) FROM gyrotherm.migration) AS migration, (SELECT count(*) FROM gyrotherm.rig) AS rigs,"
      " count(*) AS runs, count(*) FILTER (WHERE NOT finished) AS unfinished, coalesce(sum(rows), 0) AS rows,"
      " (SELECT count(*) FROM gyrotherm.calibration) AS calibrations,"
      " pg_size_pretty(pg_database_size(current_database())) AS size FROM gyrotherm.run");
  if (!answer) return failure(answer.error());
  return print_result(options, *answer);
}

void add_common_options(CLI::App& command, SiteOptions& options) {
  auto* store =
      command.add_option("--store", options.store,
                         "address of the store as a libpq connection string, such as \"host=db dbname=gyrotherm\"");
  command.add_option("--passfile", options.passfile, "file with the password (default: ~/.pgpass)")->needs(store);
  command.add_option("--site", options.site_file, "site file, whose [store] table contains address and passfile")
      ->excludes(store);
}

void add_query(CLI::App& cli, const StoreQuery& query, SiteOptions& options, Action& action) {
  auto& command = *cli.add_subcommand(
      query.name, fmt::format("Example: gyrotherm-site {} --site site.toml\n\n{}", query.name, query.help));
  add_common_options(command, options);
  command.add_flag("--json", options.json, "print JSON");
  command.add_flag("--all", options.query.all, "print all rows of the view");
  command.add_option("--most", options.query.most, "largest number of rows; 0: all")->capture_default_str();
  if (has_units(query)) command.add_option("--unit", options.query.unit, "serial number of the only unit to print");
  command.callback([&options, &query, &action] {
    action = [&options, &query]() -> Result<int> {
      auto store = connect_store(options);
      if (!store) return failure(store.error());
      const auto answer = run_query(*store, query, options.query);
      if (!answer) return failure(answer.error());
      return print_result(options, *answer);
    };
  });
}

/// Removes the arguments after "--" from the command line and returns them. They are passed to the commands of a job.
std::vector<std::string> take_trailing_arguments(int& argc, char** argv) {
  const auto end = argv + argc;
  const auto dashes = std::find(argv, end, std::string_view("--"));
  if (dashes == end) return {};
  argc = static_cast<int>(dashes - argv);
  return {dashes + 1, end};
}

int run_site(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App cli(
      "Example: gyrotherm-site rigs --store \"host=db dbname=gyrotherm user=ada sslmode=verify-full\"\n\n"
      "gyrotherm-site creates and queries the store of a site with its rigs and units, and distributes training over a "
      "cluster.",
      "gyrotherm-site");
  cli.set_version_flag("--version", std::string("gyrotherm-site ") + GYROTHERM_VERSION);
  cli.require_subcommand(1);
  SiteOptions options;
  Action action;
  auto& migrating = *cli.add_subcommand(
      "migrate",
      "Example: gyrotherm-site migrate --store \"host=db dbname=gyrotherm user=gyrotherm_owner\"\n\n"
      "Brings the store's schema up to date.");
  add_common_options(migrating, options);
  migrating.add_option("--to", options.to, "last migration to apply")
      ->check(CLI::Range(0, migrations().back().number))
      ->capture_default_str();
  migrating.callback([&] { action = [&] { return run_migrations(options); }; });
  auto& status = *cli.add_subcommand("status",
                                     "Example: gyrotherm-site status --site site.toml\n\nPrints the number of rigs, "
                                     "runs, rows and calibrations in the store, and its size.");
  add_common_options(status, options);
  status.add_flag("--json", options.json, "print JSON");
  status.callback([&] { action = [&] { return show_status(options); }; });
  for (const auto& query : queries()) add_query(cli, query, options, action);
  const auto trailing = take_trailing_arguments(argc, argv);
  add_job_commands(cli, trailing, action);
  if (const auto code = parse_command_line(cli, argc, argv)) return *code;
  if (const auto& command = cli.get_subcommands().front()->get_name(); !trailing.empty() && !passes_arguments(command))
    return report_fault(cli.get_name(),
                        {FaultKind::usage, command,
                         fmt::format("\"{}\" after -- is not expected; only train, seeds, leave-one-out and placement "
                                     "pass arguments on",
                                     trailing.front())});
  const auto done = action();
  return done ? *done : report_fault(cli.get_name(), done.error());
}

}  // namespace
}  // namespace gyrotherm::site

int main(int argc, char** argv) {
  gyrotherm::open_standard_descriptors();
  return gyrotherm::site::run_site(argc, argv);
}
