// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "app/command.hpp"
#include "app/interrupt.hpp"
#include "app/places.hpp"
#include "app/thermal/commands.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "thermal/difference_fit.hpp"
#include "thermal/gyro_model.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kFitSchema = "gyrotherm-thermal-fit/1";

struct FitArguments {
  std::string gyro;
  double difference_k = 3.5;
  double ambient_c = 20;
};

std::string words(const std::vector<thermal::FittedDifference>& family, const FitArguments& options) {
  auto text =
      fmt::format("calibrated to {:g} K: one number, met by each of these alone; it says nothing of which is true\n",
                  options.difference_k);
  for (const auto& fit : family)
    text += fmt::format("  {:<18} {:>10.4g}  {:.3f} K, warmest thermometer {:.2f} °C{}\n",
                        thermal::kFitParameterNames[static_cast<std::size_t>(fit.parameter)], fit.value,
                        fit.difference_k, fit.warmest_place_c, fit.reached ? "" : "  (cannot give it)");
  return text;
}

std::string json(const std::vector<thermal::FittedDifference>& family, const FitArguments& options) {
  Json json{{"schema", kFitSchema},
            {"simulated", true},
            {"wanted_k", options.difference_k},
            {"ambient_c", options.ambient_c},
            {"calibration", Json::array()}};
  for (const auto& fit : family)
    json["calibration"].push_back({{"parameter", thermal::kFitParameterNames[static_cast<std::size_t>(fit.parameter)]},
                                   {"value", fit.value},
                                   {"difference_k", fit.difference_k},
                                   {"warmest_place_c", fit.warmest_place_c},
                                   {"reached", fit.reached}});
  return json.dump(2) + "\n";
}

Result<Exit> fit(Console& console, const FitArguments& options) {
  const std::string path = options.gyro.empty() ? shipped("profiles/gyros/calibrated.toml") : options.gyro;
  const auto text = read_text_file(path);
  if (!text) return failure(text.error());
  const auto model = thermal::parse_gyro(*text, path);
  if (!model) return failure(model.error());
  watch_for_interrupts(SecondInterrupt::ends);
  const auto family =
      thermal::fit_family(*model, options.difference_k, {.ambient_c = options.ambient_c}, console.sink());
  if (!family) return failure(family.error());
  console.data(console.json ? json(*family, options) : words(*family, options));
  return Exit::done;
}

}  // namespace

void add_thermal_fit(Program& program) {
  auto options = std::make_shared<FitArguments>();
  auto command = add_command(program, "fit",
                             "Which value of each parameter alone gives a difference between gain and non-gain areas.",
                             "gyrotherm-thermal fit --difference 3.5");
  command.option("--gyro", options->gyro, "the gyro file; profiles/gyros/calibrated.toml if not given");
  command.option("--difference", options->difference_k, "wanted between gain and non-gain areas, K")
      .within(0.01, 100.0);
  command.option("--ambient", options->ambient_c, "temperature of the air around the cabinet, °C")
      .within(-100.0, 150.0);
  command.action([&program, options] { return fit(program.console, *options); });
}

}  // namespace gyrotherm::app
