// SPDX-License-Identifier: Apache-2.0
/// The gyrotherm program. Reads the command line, runs one command and returns its exit code.
#include <filesystem>
#include <string>

#include "acquisition/record/record_files.hpp"
#include "apps/console/command.hpp"
#include "core/program_start.hpp"

namespace gyrotherm::app {

// Each file in apps/gyrotherm/commands defines one of these functions. kCommands lists them.
void add_qualify(Program& program);
void add_run(Program& program);
void add_go(Program& program);
void add_resume(Program& program);
void add_status(Program& program);
void add_tell(Program& program);
void add_simulate(Program& program);
void add_check(Program& program);
void add_new(Program& program);
void add_plan(Program& program);
void add_prove(Program& program);
void add_release(Program& program);
void add_standard(Program& program);
void add_devices(Program& program);
void add_describe(Program& program);
void add_import(Program& program);
void add_export(Program& program);
void add_thermal(Program& program);
void add_train(Program& program);
void add_type_prior(Program& program);
void add_validate(Program& program);
void add_verify(Program& program);
void add_placement(Program& program);
void add_reduce(Program& program);
void add_compensate(Program& program);
void add_fuse(Program& program);
void add_export_model(Program& program);
void add_report(Program& program);
void add_doctor(Program& program);
void add_site(Program& program);

namespace {

constexpr auto kCommands = {add_qualify,    add_run,          add_go,     add_resume,    add_status,   add_tell,
                            add_simulate,   add_new,          add_check,  add_plan,      add_prove,    add_release,
                            add_describe,   add_devices,      add_doctor, add_import,    add_export,   add_thermal,
                            add_train,      add_type_prior,   add_verify, add_placement, add_reduce,   add_compensate,
                            add_fuse,       add_export_model, add_report, add_standard,  add_validate, add_site,
                            add_completion, add_manual};

namespace fs = std::filesystem;

constexpr int kMostLinks = 40;

bool is_link(const std::string& path) {
  std::error_code error;
  return fs::is_symlink(fs::symlink_status(path, error));
}

/// Resolves a link to a record. The parts, live copy and socket of a record are found by its own name.
std::string resolve_record_link(std::string path) {
  std::error_code error;
  if (!fs::exists(path, error)) return path;  // a new record, no link
  for (int links = 0; links < kMostLinks && is_link(path) && !record::is_live_copy(path); ++links)
    path = (fs::path(path).parent_path() / fs::read_symlink(path, error)).string();
  return path;
}

void follow_links_to_records(CLI::App& app) {
  const auto is_record = [](const CLI::Option* option) { return option->get_type_name().starts_with(value::kRecord); };
  for (auto* option : app.get_options(is_record)) option->transform(resolve_record_link, "");
  for (auto* below : app.get_subcommands([](const CLI::App*) { return true; })) follow_links_to_records(*below);
}

}  // namespace
}  // namespace gyrotherm::app

int main(int argc, char** argv) {
  gyrotherm::open_standard_descriptors();
  gyrotherm::app::Program program(
      "gyrotherm", "gyrotherm runs gyroscopes through temperature profiles and computes their bias compensation.");
  for (const auto add : gyrotherm::app::kCommands) add(program);
  gyrotherm::app::follow_links_to_records(program.cli);
  return run(program, argc, argv);
}
