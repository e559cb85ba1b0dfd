// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/csv.hpp"
#include "app/command.hpp"
#include "app/recorded_run.hpp"

namespace gyrotherm::app {
namespace {

struct ExportArguments {
  std::string run, out;
  bool unverified = false;
};

Result<Exit> export_table(Console& console, const ExportArguments& options) {
  const auto done = check_recorded_run(console, options.run, options.unverified).and_then([&] {
    return record::export_record(options.run, options.out);
  });
  return done ? Result<Exit>(Exit::done) : failure(done.error());
}

}  // namespace

void add_export(Program& program) {
  auto [command, options] = add_command(program, "export", "Writes a record as a text table.",
                                        "gyrotherm export random.db --out random.csv", export_table);
  command.add_option("run", options.run, "the record")->required();
  command.add_option("--out", options.out, "the table")->required();
  add_unverified_flag(command, options.unverified);
}

}  // namespace gyrotherm::app
