// SPDX-License-Identifier: Apache-2.0
/// The commands `image` and `fit` of gyrotherm-thermal. `image` computes a steady state and its views; `fit` finds the
/// value of each parameter that yields a required temperature difference.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/thermal/thermal_views.hpp"
#include "core/child_process.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/process.hpp"
#include "core/shipped.hpp"
#include "simulator/thermal/difference_fit.hpp"
#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/steady_state.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kCalibrated = "calibrated";

/// Reads a gyro file, or the shipped one of that name.
Result<thermal::GyroModel> read_gyro(const std::string& given) {
  const auto path = resolve_path(given, kShippedGyro);
  if (!path) return failure(path.error());
  return read_text_file(*path).and_then([&](const std::string& text) { return thermal::parse_gyro(text, *path); });
}

constexpr const char* kFitSchema = "gyrotherm-thermal-fit/1";

struct FitArguments {
  std::string gyro = kCalibrated;
  double difference_k = 3.5;
  double ambient_c = 20;
};

/// Describes the fits to a required difference: the value of each parameter if only that parameter is varied.
std::string describe(const std::vector<thermal::FittedDifference>& family, double wanted_k) {
  auto text =
      fmt::format("calibrated to {:g} K: each line varies one parameter only; they fit equally well\n", wanted_k);
  for (const auto& fit : family)
    text += fmt::format("  {:<18} {:>10.4g}  {:.3f} K, warmest thermometer {:.2f} °C{}\n",
                        thermal::kFitParameterNames[static_cast<std::size_t>(fit.parameter)], fit.value,
                        fit.difference_k, fit.warmest_location_c, fit.reached ? "" : "  (difference not reached)");
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
                                   {"warmest_place_c", fit.warmest_location_c},
                                   {"reached", fit.reached}});
  return json.dump(2) + "\n";
}

Result<Exit> run_fit(Console& console, const FitArguments& options) {
  const auto model = read_gyro(options.gyro);
  if (!model) return failure(model.error());
  watch_for_interrupts(SecondInterrupt::ends);
  const auto family =
      thermal::fit_family(*model, options.difference_k, {.ambient_c = options.ambient_c}, console.sink());
  if (!family) return failure(family.error());
  console.print(console.json ? json(*family, options) : describe(*family, options.difference_k));
  return Exit::done;
}

constexpr const char* kThermalSchema = "gyrotherm-thermal/1";

struct ThermalArguments {
  std::string gyro = kCalibrated, mesh = "medium", out;
  double ambient_c = 20;
  std::optional<double> film, fit;
  bool force = false;
};

/// File that is written last, so the image is complete if it exists.
constexpr const char* kResultFile = "thermal.json";

/// A steady state, its inputs and the time of its computation.
struct SolvedModel {
  thermal::GyroModel model;
  thermal::GyroMesh mesh;
  thermal::SteadyState state;
  double film_w_per_m2_k{};
  double wall_s{};
  /// Results of --fit, otherwise empty. If the first fit reaches the difference, `model` has its parameter value.
  std::vector<thermal::FittedDifference> family;
};

double film_coefficient(const thermal::GyroModel& model, const ThermalArguments& options) {
  if (options.film) return *options.film;
  return model.mode == thermal::GyroMode::block ? model.block_film_w_per_m2_k : model.still_film_w_per_m2_k;
}

/// Reports progress. Fails with interrupted after Ctrl-C. Call it between the stages of the work: the solver itself
/// cannot be interrupted.
Result<void> check_interrupt(Console& console, std::string_view stage, double fraction) {
  if (should_continue(console.sink(), stage, fraction)) return {};
  return failure(FaultKind::interrupted, "thermal", "stopped");
}

Result<SolvedModel> solve(Console& console, thermal::GyroModel model, const ThermalArguments& options) {
  const auto began = std::chrono::steady_clock::now();
  const auto size = std::ranges::find(thermal::kMeshSizeNames, options.mesh) - thermal::kMeshSizeNames.begin();
  SolvedModel solved{.model = std::move(model), .mesh = {}, .state = {}, .family = {}};
  if (options.fit) {
    auto family = fit_family(solved.model, *options.fit, {.ambient_c = options.ambient_c}, console.sink());
    if (!family) return failure(family.error());
    solved.family = std::move(*family);
    if (const auto& first = solved.family.front(); first.reached)
      solved.model = replace_parameter(solved.model, first.parameter, first.value);
    else
      console.print_message(fmt::format("warning: no value of {} yields {:g} K; the model is not calibrated",
                                        thermal::kFitParameterNames[static_cast<std::size_t>(first.parameter)],
                                        *options.fit));
  }
  if (auto running = check_interrupt(console, "steady state", 0); !running) return failure(running.error());
  solved.film_w_per_m2_k = film_coefficient(solved.model, options);
  solved.mesh = make_mesh(solved.model, static_cast<thermal::MeshSize>(size));
  auto state = steady_state(solved.model, solved.mesh,
                            {.ambient_c = options.ambient_c, .film_w_per_m2_k = solved.film_w_per_m2_k});
  if (!state) return failure(state.error());
  solved.state = std::move(*state);
  solved.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return solved;
}

struct AreaMeans {
  double gain_c{}, non_gain_c{};
};

AreaMeans gain_means(const thermal::SteadyState& state) {
  const auto& t = state.outputs_c;
  return {(t[0] + t[1] + t[2]) / 3, (t[5] + t[6] + t[7]) / 3};
}

std::string describe_point(const char* what, const thermal::ExtremePoint& point) {
  return fmt::format("  {:<9} {:7.3f} °C  {} at ({:.1f}, {:.1f}, {:.1f}) mm\n", what, point.temperature_c,
                     thermal::kGyroPartNames[index(point.part)], 1e3 * point.at_m[0], 1e3 * point.at_m[1],
                     1e3 * point.at_m[2]);
}

std::string describe(const SolvedModel& solved, const ThermalArguments& options) {
  const auto& state = solved.state;
  const auto [gain_c, non_gain_c] = gain_means(state);
  auto text = fmt::format("SIMULATED {}, in air of {:g} °C\n", solved.model.title, options.ambient_c);
  for (std::size_t k = 0; k < 8; ++k)
    text += fmt::format("  {} {:.3f}", thermal::kThermalOutputNames[k], state.outputs_c[k]);
  text += fmt::format("  °C\n  gain areas A B C {:.3f} °C, opposite F G H {:.3f} °C: {:.3f} K apart (the paper: 3.5)\n",
                      gain_c, non_gain_c, gain_c - non_gain_c);
  text += describe_point("hottest", state.hottest) + describe_point("coldest", state.coldest);
  text += fmt::format("  energy    {:.6f} W in, {:.6f} W out\n", state.power_in_w, state.power_out_w);
  text += fmt::format("  film      {:g} W/(m²·K); ballast read as \"{}\"\n", solved.film_w_per_m2_k,
                      thermal::kBallastReadingNames[static_cast<std::size_t>(solved.model.ballast_reading)]);
  text += fmt::format(
      "  mesh      {}, {} elements, {} unknowns; {} iterations (hypre BoomerAMG), {:.1f} s, {:.0f} MB\n", options.mesh,
      solved.mesh.element_count, state.unknowns, state.iterations, solved.wall_s, peak_memory_mb());
  if (options.fit) text += describe(solved.family, *options.fit);
  return text;
}

Json make_json(const thermal::ExtremePoint& point) {
  return {{"temperature_c", point.temperature_c},
          {"at_m", point.at_m},
          {"part", thermal::kGyroPartNames[index(point.part)]}};
}

/// Returns the results without values that differ between runs, such as the computing time.
Json json(const SolvedModel& solved, const ThermalArguments& options) {
  const auto& state = solved.state;
  const auto [gain_c, non_gain_c] = gain_means(state);
  Json json{{"schema", kThermalSchema},
            {"simulated", true},
            {"gyro", solved.model.name},
            {"mode", thermal::kGyroModeNames[static_cast<std::size_t>(solved.model.mode)]},
            {"ballast_reading", thermal::kBallastReadingNames[static_cast<std::size_t>(solved.model.ballast_reading)]},
            {"ambient_c", options.ambient_c},
            {"film_w_per_m2_k", solved.film_w_per_m2_k},
            {"temperatures_c", Json::object()}};
  for (std::size_t k = 0; k < thermal::kThermalOutputs; ++k)
    json["temperatures_c"][std::string(thermal::kThermalOutputNames[k])] = state.outputs_c[k];
  json["gain_mean_c"] = gain_c;
  json["non_gain_mean_c"] = non_gain_c;
  json["difference_k"] = gain_c - non_gain_c;
  json["hottest"] = make_json(state.hottest);
  json["coldest"] = make_json(state.coldest);
  json["power_in_w"] = state.power_in_w;
  json["power_out_w"] = state.power_out_w;
  json["mesh"] = options.mesh;
  json["elements"] = solved.mesh.element_count;
  json["unknowns"] = state.unknowns;
  json["iterations"] = state.iterations;
  for (const auto& fit : solved.family) {
    json["calibration"].push_back({{"parameter", thermal::kFitParameterNames[static_cast<std::size_t>(fit.parameter)]},
                                   {"value", fit.value},
                                   {"difference_k", fit.difference_k},
                                   {"reached", fit.reached}});
  }
  return json;
}

/// Converts the SVG of each view to a PNG with gyrotherm-pdf. If that fails, prints a message and skips the remaining
/// views. Fails with interrupted after Ctrl-C.
Result<void> convert_views_to_png(Console& console, const std::filesystem::path& folder,
                                  const std::vector<std::string>& views) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto& view = views[i];
    const auto program = sibling_program_path("gyrotherm-pdf");
    const auto code = run_and_wait({program, "--force", "--width", "1600", "--png", (folder / (view + ".svg")).string(),
                                    "--out", (folder / (view + ".png")).string()});
    const auto fraction = static_cast<double>(i + 1) / static_cast<double>(views.size());
    // Checked first, because Ctrl-C also ends gyrotherm-pdf.
    if (auto running = check_interrupt(console, "pictures", fraction); !running) return running;
    if (code && *code == 0) continue;
    const auto why = code ? fmt::format("exit code {}", *code) : code.error().what;
    console.print_message(fmt::format("cannot convert {}.svg to PNG: {}: {}", view, program, why));
    break;
  }
  return {};
}

Result<void> write_files(Console& console, const SolvedModel& solved, const ThermalArguments& options) {
  const std::filesystem::path folder = options.out;
  std::vector<std::string> views;
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& view : make_views(solved.model, solved.mesh, solved.state)) {
    files.emplace_back(view.file + ".svg", plot::to_svg(view.image));
    views.push_back(view.file);
  }
  std::ostringstream vtu, calculix;
  write_vtu(vtu, solved.mesh, solved.state.field_c);
  files.emplace_back("gyro.vtu", std::move(vtu).str());
  write_calculix_input(calculix, solved.model, solved.mesh,
                       {.ambient_c = options.ambient_c, .coefficients = solved.state.coefficients});
  files.emplace_back("gyro.inp", std::move(calculix).str());
  for (const auto& [name, content] : files) {
    if (auto written = replace_text_file((folder / name).string(), content); !written) return written;
  }
  if (auto drawn = convert_views_to_png(console, folder, views); !drawn) return drawn;
  return replace_text_file((folder / kResultFile).string(), json(solved, options).dump(2) + "\n");
}

Result<Exit> write_image(Console& console, const ThermalArguments& options) {
  std::error_code error;
  const auto result_file = (std::filesystem::path(options.out) / kResultFile).string();
  if (!options.force && std::filesystem::exists(result_file, error))
    return failure(FaultKind::usage, result_file, "exists; --force overwrites it and the files next to it");
  auto model = read_gyro(options.gyro);
  if (!model) return failure(model.error());
  std::filesystem::create_directories(options.out, error);
  if (error) return failure(FaultKind::storage, options.out, error.message());
  watch_for_interrupts(SecondInterrupt::ends);
  const auto solved = solve(console, std::move(*model), options);
  if (!solved) return failure(solved.error());
  auto written =
      check_interrupt(console, "pictures", 0).and_then([&] { return write_files(console, *solved, options); });
  if (!written) return failure(written.error());
  if (!console.json) {
    console.print(describe(*solved, options));
    return Exit::done;
  }
  auto facts = json(*solved, options);
  facts["wall_s"] = solved->wall_s;
  facts["peak_memory_mb"] = peak_memory_mb();
  console.print(facts.dump(2) + "\n");
  return Exit::done;
}

}  // namespace

void add_thermal_fit(Program& program) {
  auto [command, options] = add_command(program, "fit",
                                        "Finds, for one parameter at a time, the value that yields a given temperature "
                                        "difference between gain and non-gain areas.",
                                        "gyrotherm-thermal fit --difference 3.5", run_fit);
  command.add_option("--gyro", options.gyro, "the gyro file (default: calibrated)")->type_name(value::kGyro);
  command.add_option("--difference", options.difference_k, "required difference between gain and non-gain areas, K")
      ->check(CLI::Range(0.01, 100.0));
  command.add_option("--ambient", options.ambient_c, "temperature of the air around the cabinet, °C")
      ->check(CLI::Range(-100.0, 150.0));
}

void add_thermal_image(Program& program) {
  auto [command, options] = add_command(program, "image",
                                        "Computes the finite-element thermal image of the working gyro at rest: "
                                        "pictures, a file for ParaView, an input for CalculiX.",
                                        "gyrotherm-thermal image --mesh medium --out image", write_image);
  command.add_option("--gyro", options.gyro, "the gyro file (default: calibrated)")->type_name(value::kGyro);
  command.add_option("--mesh", options.mesh, "coarse, medium or fine: edges of 4.6, 2.9 or 2.1 mm")
      ->check(CLI::IsMember({"coarse", "medium", "fine"}));
  command.add_option("--ambient", options.ambient_c, "temperature of the air around the cabinet, °C")
      ->check(CLI::Range(-100.0, 150.0));
  command
      .add_option("--film", options.film,
                  "film coefficient of the outside, W/(m²·K) (default: still air, from the gyro file)")
      ->check(CLI::Range(0.01, 10000.0));
  command.add_option("--fit", options.fit, "calibrate to this gain–non-gain difference first, K")
      ->check(CLI::Range(0.01, 100.0));
  command.add_option("--out", options.out, "folder for the results")
      ->check(reject_dash())
      ->type_name(value::kFolder)
      ->required();
  command.add_flag("--force", options.force, "overwrite an existing image");
}

}  // namespace gyrotherm::app
