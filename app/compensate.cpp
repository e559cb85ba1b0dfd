#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <iostream>

#include "analysis/stream.hpp"
#include "app/command.hpp"
#include "app/evidence.hpp"
#include "app/interrupt.hpp"

namespace gyrotherm {
namespace {

constexpr std::string_view kBiasColumn = "bias";

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const auto comma = line.find(',');
    auto field = line.substr(0, comma);
    while (!field.empty() && (field.front() == ' ' || field.front() == '\t')) field.remove_prefix(1);
    while (!field.empty() && (field.back() == ' ' || field.back() == '\t' || field.back() == '\r'))
      field.remove_suffix(1);
    fields.push_back(field);
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

tl::unexpected<Fault> bad_line(std::size_t line, std::size_t column, std::string what) {
  return failure(FaultKind::bad_file, fmt::format("stdin:{}:{}", line, column), std::move(what));
}

/// Numbers of one row; an empty field is a missing reading.
Result<std::vector<double>> numbers_of(std::string_view text, std::size_t count, std::size_t line) {
  const auto fields = fields_of(text);
  if (fields.size() != count) return bad_line(line, 1, fmt::format("{} fields, expected {}", fields.size(), count));
  std::vector<double> numbers(count, NAN);
  for (std::size_t i = 0; i < count; ++i) {
    const auto field = fields[i];
    if (field.empty()) continue;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), numbers[i]);
    if (error != std::errc{} || end != field.data() + field.size() || !std::isfinite(numbers[i]))
      return bad_line(line, static_cast<std::size_t>(field.data() - text.data()) + 1,
                      fmt::format("\"{}\" is not a number", field));
  }
  return numbers;
}

/// The header names the thermometers and, last, "bias".
Result<std::vector<std::string>> header_of(std::string_view line) {
  std::vector<std::string> names;
  for (const auto field : fields_of(line)) names.emplace_back(field);
  if (names.size() < 2 || names.back() != kBiasColumn)
    return bad_line(1, 1, "expected a header: the names of the thermometers, then \"bias\", separated by commas");
  names.pop_back();
  return names;
}

Result<Exit> compensate(Console& console, const std::string& path) {
  const auto model = load_model(path);
  if (!model) return failure(model.error());
  std::string line;
  if (!std::getline(std::cin, line)) return bad_line(1, 1, "no input, expected a header");
  const auto columns = header_of(line);
  if (!columns) return failure(columns.error());
  auto stream = CompensationStream::open(*model, *columns);
  if (!stream) return failure(stream.error());
  console.say(fmt::format("inputs are trailing {:g} s means: the compensation lags by {:g} s", model->cluster_length_s,
                          model->cluster_length_s / 2));
  console.data("compensated_bias_deg_per_h\n");
  for (std::size_t number = 2; !interrupted() && !std::ferror(stdout) && std::getline(std::cin, line); ++number) {
    if (line.empty()) continue;
    auto row = numbers_of(line, columns->size() + 1, number);
    if (!row) return failure(row.error());
    const double bias = row->back();
    row->pop_back();
    const double compensated = stream->push(*row, bias);
    console.data(std::isnan(compensated) ? "\n" : fmt::format("{:.7f}\n", compensated));
  }
  return Exit::done;
}

}  // namespace

void add_compensate(Program& program) {
  auto path = std::make_shared<std::string>();
  auto* command = add_command(program, "compensate",
                              "Reads 1-Hz rows of temperatures (°C) and raw bias (°/h) with a header like "
                              "\"A,B,C,bias\", writes the compensated bias.",
                              "gyrotherm compensate model.json < rows.csv");
  command->add_option("model", *path, "the model")->required();
  set_action(command, program, [&program, path] { return compensate(program.console, *path); });
}

}  // namespace gyrotherm
