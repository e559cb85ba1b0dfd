#include "acquisition/export.hpp"

#include "app/command.hpp"

namespace gyrotherm {
namespace {

struct Options {
  std::string run, out;
};

}  // namespace

void add_export(Program& program) {
  auto options = std::make_shared<Options>();
  auto* command =
      add_command(program, "export", "Writes a record as a text table.", "gyrotherm export random.db --out random.csv");
  command->add_option("run", options->run, "the record")->required();
  command->add_option("--out", options->out, "the table")->required();
  set_action(command, program, [options]() -> Result<Exit> {
    if (auto done = export_record(options->run, options->out); !done) return failure(done.error());
    return Exit::done;
  });
}

}  // namespace gyrotherm
