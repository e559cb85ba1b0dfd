// SPDX-License-Identifier: Apache-2.0
/// Parses any text as a reduced model. The result must be a usable model or a fault with a position.
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "simulator/thermal/reduced/reduced_transient.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::thermal {

using fuzz::require;

namespace {

void run(std::string_view text) {
  const auto model = parse_reduced_model(text, "fuzz.toml");
  if (!model) return require(!model.error().what.empty() && model.error().where.starts_with("fuzz.toml:"));
  const auto again = parse_reduced_model(reduced_model_text(*model), "again.toml");
  require(again && reduced_model_text(*again) == reduced_model_text(*model));
  ReducedTransient reduced(*model, {});
  reduced.step({25});
  for (const double t_c : reduced.outputs_c()) require(!std::isnan(t_c));
}

constexpr std::string_view kOutputs[] = {"A",
                                         "B",
                                         "C",
                                         "D",
                                         "E",
                                         "F",
                                         "G",
                                         "H",
                                         "shell",
                                         "gain_left",
                                         "gain_right",
                                         "passive_bore",
                                         "preamplifier",
                                         "mirror_b",
                                         "mirror_c",
                                         "mirror_f",
                                         "mirror_h",
                                         "block"};
constexpr std::string_view kInputs[] = {"ambient",      "gain_left",    "gain_right",
                                        "preamplifier", "ballast_left", "ballast_right"};
constexpr std::string_view kConduction[] = {"fixed", "air_lid", "air_side", "air_base", "film"};

/// Returns the text of a number for a byte. Most are small valid numbers, some are invalid.
std::string number_for(std::uint8_t byte) {
  constexpr std::string_view kOdd[] = {"-0.0", "1e308", "5e-324", "inf", "nan", "\"x\"", "[1.0]", "-1.0"};
  if (byte >= 248) return std::string(kOdd[byte - 248]);
  return fmt::format("{}.0", byte % 4);
}

/// Returns the text of a model with one state. With it, random input reaches the checks behind the grammar.
std::string build_model_text(const std::uint8_t* data, std::size_t size) {
  std::size_t at = 0;
  const auto next = [&] { return at < size ? number_for(data[at++]) : std::string("1.0"); };
  std::string text = "schema = \"gyrotherm-reduced-gyro/1\"\ngyro = \"g\"\nmesh = \"m\"\nstates = 1\n";
  text += "source_sha256 = \"" + std::string(64, 'a') + "\"\n";
  text += "film_ambient = [" + next() + "]\nstill_film_w_per_m2_k = 8.0\nchamber_film_w_per_m2_k = 9.0\n";
  text += "[error]\ntransfer_k = 0.0\nramp_k = 0.0\nswitch_on_k = 0.0\n";
  for (const auto* gap : {"lid", "side", "base"})
    text += fmt::format("[air.{}]\nnusselt = 1.0\nemissivity = {}\nwidth_m = 0.02\n", gap, next());
  text += "[powers_w]\n";
  for (const auto name : kInputs)
    if (name != "ambient") text += fmt::format("{} = {}\n", name, next());
  text += "[inputs]\n";
  for (const auto name : kInputs) text += fmt::format("{} = [{}]\n", name, name == "ambient" ? "0.0" : next());
  text += "[outputs]\n";
  for (const auto name : kOutputs) text += fmt::format("{} = [1.0]\n", name);
  text += "[conduction]\n";
  for (const auto name : kConduction)
    text += fmt::format("{} = [[{}]]\n", name, name == "film" ? next() : std::string("0.0"));
  return text;
}

}  // namespace

FUZZ_TARGET(reduced_model, const std::uint8_t* data, std::size_t size) {
  run({reinterpret_cast<const char*>(data), size});
  run(build_model_text(data, size));
  return 0;
}

}  // namespace gyrotherm::thermal
