#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "analysis/verification.hpp"
#include "app/command.hpp"
#include "app/evidence.hpp"

namespace gyrotherm {
namespace {

struct Options {
  std::string model, clusters;
  std::vector<std::string> runs;
};

std::string row(std::string_view what, const Figures& f) {
  return f.count == 0 ? std::string()
                      : fmt::format("  {:<22} {:>9.5f} {:>9.5f} {:>9.5f} {:>9.5f} {:>7}\n", what, f.std, f.mean, f.rmse,
                                    f.max_abs, f.count);
}

std::string words(const std::string& run, const Verification& v) {
  std::string text = fmt::format("{}{}\n  {:<22} {:>9} {:>9} {:>9} {:>9} {:>7}\n", v.simulated ? "SIMULATED " : "", run,
                                 "°/h", "std", "mean", "rmse", "max", "n");
  text += row("raw bias", v.raw) + row("compensated", v.compensated) + row("  ramps", v.ramps) +
          row("  holds", v.holds) + row("  10 min after corners", v.corners);
  text +=
      fmt::format("  noise floor of the record: {:.5f} °/h ({} differences)\n", v.floor.deg_per_h, v.floor.differences);
  for (const auto& warning : v.warnings) text += "  warning: " + warning + "\n";
  return text;
}

nlohmann::ordered_json json_of(const Figures& f) {
  return {{"std_deg_per_h", f.std},
          {"mean_deg_per_h", f.mean},
          {"rmse_deg_per_h", f.rmse},
          {"max_abs_deg_per_h", f.max_abs},
          {"count", f.count}};
}

std::string json(const std::string& run, const Verification& v) {
  const nlohmann::ordered_json object{{"run", run},
                                      {"simulated", v.simulated},
                                      {"trained_on_this", v.trained_on_this},
                                      {"raw", json_of(v.raw)},
                                      {"compensated", json_of(v.compensated)},
                                      {"ramps", json_of(v.ramps)},
                                      {"holds", json_of(v.holds)},
                                      {"corners", json_of(v.corners)},
                                      {"noise_floor_deg_per_h", v.floor.deg_per_h},
                                      {"outside_trained_range", v.outside_trained_range},
                                      {"warnings", v.warnings}};
  return object.dump() + "\n";
}

Result<Exit> verify_all(Console& console, const Options& options) {
  const auto model = load_model(options.model);
  if (!model) return failure(model.error());
  const auto range = parse_cluster_range(options.clusters);
  if (!range) return failure(range.error());
  for (const auto& run : options.runs) {
    const auto evidence = load_evidence(run, *range);
    if (!evidence) return failure(evidence.error());
    const auto verification = verify(*model, evidence->dataset, evidence->clusters);
    if (!verification) return failure(verification.error());
    console.data(console.json ? json(run, *verification) : words(run, *verification));
  }
  return Exit::done;
}

}  // namespace

void add_verify(Program& program) {
  auto options = std::make_shared<Options>();
  auto* command = add_command(program, "verify", "Compensates a record the model has not seen and says how good it is.",
                              "gyrotherm verify model.json random.db");
  command->add_option("model", options->model, "the model")->required();
  command->add_option("runs", options->runs, "the records")->required();
  command->add_option("--clusters", options->clusters, "only these clusters of each record, like 14:21");
  set_action(command, program, [&program, options] { return verify_all(program.console, *options); });
}

}  // namespace gyrotherm
