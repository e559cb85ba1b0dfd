#include "app/command.hpp"
#include "app/evidence.hpp"
#include "core/text_file.hpp"

namespace gyrotherm {
namespace {

struct Options {
  std::string model, as, out, run;
};

Result<void> put(Console& console, const std::string& path, const std::string& text) {
  if (!path.empty()) return replace_text_file(path, text);
  console.data(text);
  return {};
}

Result<Exit> export_model(Console& console, const Options& options) {
  const auto model = load_model(options.model);
  if (!model) return failure(model.error());
  if (!options.run.empty()) {
    const auto evidence = load_evidence(options.run);
    if (!evidence) return failure(evidence.error());
    const auto rows = to_libsvm_data(*model, evidence->clusters);
    if (!rows) return failure(rows.error());
    if (auto written = put(console, options.out, *rows); !written) return failure(written.error());
    return Exit::done;
  }
  const auto text = to_libsvm(*model);
  if (!text) return failure(text.error());
  if (auto written = put(console, options.out, *text); !written) return failure(written.error());
  return Exit::done;
}

}  // namespace

void add_export_model(Program& program) {
  auto options = std::make_shared<Options>();
  auto* command = add_command(program, "export-model", "Writes a model for another program: libsvm, for svm-predict.",
                              "gyrotherm export-model model.json --as libsvm --out model.libsvm");
  command->add_option("model", options->model, "the model")->required();
  command->add_option("--as", options->as, "libsvm")->required()->check(CLI::IsMember({"libsvm"}));
  command->add_option("--out", options->out, "the file (default: standard output)");
  command->add_option("--data", options->run, "instead of the model, write this record's clusters as its inputs");
  set_action(command, program, [&program, options] { return export_model(program.console, *options); });
}

}  // namespace gyrotherm
