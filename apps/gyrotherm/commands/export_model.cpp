// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "analysis/model/model_export.hpp"
#include "apps/console/command.hpp"
#include "apps/gyrotherm/bias_tracking.hpp"
#include "apps/gyrotherm/output_file.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "core/file.hpp"
#include "core/json.hpp"

namespace gyrotherm::app {
namespace {

struct ExportModelArguments {
  std::string model, as, out, run;
  bool force = false, unverified = false;
  data::AxisChoice axis;
  BiasTrackingArguments tracking;
};

Result<void> write_text(Console& console, const std::string& path, const std::string& text) {
  if (path.empty()) {
    console.print(text);
    return {};
  }
  return replace_text_file(path, text).map([&] {
    if (console.json) console.print(json_text(Json{{"file", path}}) + "\n");
  });
}

Result<void> export_data(Console& console, const ExportModelArguments& options, const model::Model& model) {
  const auto recorded = load_recorded_run(console, options.run,
                                          {.unverified = options.unverified,
                                           .axis = axis_for(model, options.axis),
                                           .cluster_length_s = model.cluster_length_s});
  if (!recorded) return failure(recorded.error());
  const auto rows = to_libsvm_data(model, recorded->clusters);
  if (!rows) return failure(rows.error());
  return write_text(console, options.out, *rows);
}

/// Writes the C source and, next to it, its header. Both are named after the output file.
Result<void> export_c(Console& console, const ExportModelArguments& options, const model::Model& model) {
  const std::filesystem::path source = options.out;
  if (source.extension() != ".c") {
    return failure(FaultKind::usage, "--out",
                   "the name of a C source must end in .c; its header is written next to it");
  }
  const auto stem = source.stem().string();
  if (std::ranges::any_of(stem, [](unsigned char c) { return c >= 0x80; }))
    return failure(FaultKind::usage, "--out",
                   fmt::format("\"{}\" is not plain ASCII; the functions in the C source have this name", stem));
  const auto noise =
      find_tracking_noise(console, model, options.tracking, {.unverified = options.unverified, .axis = options.axis});
  if (!noise) return failure(noise.error());
  const auto program = to_c(model, model::c_name(source.stem().string()), *noise);
  if (!program) return failure(program.error());
  auto header = source;
  header.replace_filename(model::c_name(source.stem().string()) + ".h");
  if (auto free = check_is_free(header.string(), options.force); !free) return free;
  if (auto written = replace_text_file(header.string(), program->header); !written) return written;
  if (auto written = replace_text_file(source.string(), program->source); !written) return written;
  const double within = c_tolerance_deg_per_h(model);
  if (console.json)
    console.print(
        json_text(Json{{"file", source.string()}, {"header", header.string()}, {"agrees_to_deg_per_h", within}}) +
        "\n");
  else
    console.print_message(
        fmt::format("wrote {} and {}; their self-test checks that they agree with this program to {:.2g} °/h",
                    source.string(), header.string(), within));
  return {};
}

Result<void> write_export(Console& console, const ExportModelArguments& options, const model::Model& model) {
  if (!options.run.empty()) return export_data(console, options, model);
  if (options.as == "c") return export_c(console, options, model);
  const auto text = to_libsvm(model);
  if (!text) return failure(text.error());
  return write_text(console, options.out, *text);
}

Result<Exit> export_model(Console& console, const ExportModelArguments& options) {
  if (options.as == "c" && !options.run.empty()) {
    return failure(FaultKind::usage, "--data",
                   "only valid with --as libsvm; the self-test of a C export contains its own inputs");
  }
  if (options.as != "c" && (options.tracking.track || !options.tracking.noise.empty())) {
    return failure(FaultKind::usage, "--track", "only valid with --as c");
  }
  if (console.json && options.as != "c" && options.out.empty())
    return failure(FaultKind::usage, "--json", "the model itself is written to stdout; name a file for it with --out");
  if (!options.out.empty())
    if (auto free = check_is_free(options.out, options.force); !free) return failure(free.error());
  const auto model = load_model(options.model);
  if (!model) return failure(model.error());
  if (auto written = write_export(console, options, *model); !written) return failure(written.error());
  return Exit::done;
}

}  // namespace

void add_export_model(Program& program) {
  auto [command, options] = add_command(program, "export-model",
                                        "Exports a model for another program: as libsvm for svm-predict, or as a C99 "
                                        "source and header for a navigation computer.",
                                        "gyrotherm export-model model.json --as c --out compensation.c", export_model);
  command.add_option("model", options.model, "the model")->type_name(value::kModel)->required();
  command.add_option("--as", options.as, "output format: libsvm or c")
      ->required()
      ->check(CLI::IsMember({"libsvm", "c"}));
  command.add_option("--out", options.out, "the file (default for libsvm: standard output)")
      ->check(reject_dash())
      ->type_name(value::kCode);
  add_force_flag(command, options.force);
  command
      .add_option("--data", options.run,
                  "write the clusters of this record as inputs of the model, instead of the model")
      ->type_name(value::kRecord);
  add_tracking_options(command, options.tracking,
                       "for c: also export a Kalman filter that tracks the residual bias while the gyro is at rest");
  add_axis_options(command, options.axis);
  add_unverified_flag(command, options.unverified);
}

}  // namespace gyrotherm::app
