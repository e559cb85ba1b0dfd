#include "acquisition/export.hpp"

#include "app/command.hpp"

namespace gyrotherm {
namespace {

struct ExportArguments {
  std::string run, out;
};

}  // namespace

void add_export(Program& program) {
  auto options = std::make_shared<ExportArguments>();
  auto command =
      add_command(program, "export", "Writes a record as a text table.", "gyrotherm export random.db --out random.csv");
  command.option("run", options->run, "the record").required();
  command.option("--out", options->out, "the table").required();
  command.action([options]() -> Result<Exit> {
    if (auto done = export_record(options->run, options->out); !done) return failure(done.error());
    return Exit::done;
  });
}

}  // namespace gyrotherm
