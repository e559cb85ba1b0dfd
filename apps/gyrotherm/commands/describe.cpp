// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/console/command.hpp"
#include "core/file.hpp"
#include "core/shipped.hpp"
#include "core/text.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/line/line_address.hpp"

namespace gyrotherm::app {
namespace {

struct DescribeOptions {
  std::string file;
  /// Address of an instrument; empty to print the description.
  std::string line;
  /// Item whose question is sent; the first question if empty.
  std::string item;
};

/// Bytes that were exchanged with an instrument.
struct ExchangedBytes {
  std::string sent, received;
};

/// Keeps a copy of all bytes that pass.
class CopyingStream final : public drivers::ByteStream {
 public:
  CopyingStream(std::unique_ptr<drivers::ByteStream> line, ExchangedBytes& bytes)
      : line_(std::move(line)), bytes_(bytes) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    auto size = line_->read(buffer, within);
    if (size) bytes_.received.append(reinterpret_cast<const char*>(buffer.data()), *size);
    return size;
  }
  Result<void> write(std::span<const std::byte> bytes, Duration within) override {
    bytes_.sent.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return line_->write(bytes, within);
  }
  void end_rest() override { line_->end_rest(); }

 private:
  std::unique_ptr<drivers::ByteStream> line_;
  ExchangedBytes& bytes_;
};

Result<drivers::RegisterMap> read_description(const std::string& file) {
  const auto path = resolve_path(file, kShippedChamberMap);
  if (!path) return failure(path.error());
  const auto text = read_text_file(*path);
  if (!text) return failure(text.error());
  auto map = drivers::parse_register_map(*text, *path);
  if (map && !map->text_link)
    return failure(FaultKind::usage, *path,
                   "describes registers, expected a text instrument (schema gyrotherm-text/1)");
  return map;
}

std::string list_items(const drivers::RegisterMap& map) {
  std::string text = fmt::format("{} {}\n", map.vendor, map.name);
  for (const auto& query : map.text_link->queries) {
    std::vector<std::string> names;
    for (const auto& cell : query.cells) names.push_back(map.items[cell.item].name);
    text += fmt::format("  {:<28} {}\n", plain(query.ask), fmt::join(names, ", "));
  }
  for (const auto& command : map.text_link->commands) {
    const auto& item = map.items[command.item];
    text += fmt::format("  {:<28} writes {}{}\n", plain(command.tell.format({{"value", std::string("…")}})), item.name,
                        command.acknowledged.empty() ? "; not acknowledged" : "");
  }
  return text + drivers::describe_confidence(map) + "\n";
}

const drivers::TextQuery* find_question(const drivers::RegisterMap& map, const std::string& item) {
  const auto& queries = map.text_link->queries;
  if (item.empty()) return queries.empty() ? nullptr : &queries.front();
  const auto* found = map.find(item);
  return found ? map.text_link->find_query(found->address) : nullptr;
}

std::string show_value(const drivers::RegisterItem& item, std::span<const std::uint16_t> words) {
  if (item.type == drivers::RegisterType::text) return fmt::format("\"{}\"", decode_text(item.text, words));
  const auto value = decode(item, words);
  if (!value) return value.error().what;
  return item.codes.empty() ? fmt::format("{:.10g}", *value) : drivers::meaning(item, *value);
}

/// Sends one question and prints the bytes, the values in the answer, or the reason why there are none.
Result<Exit> ask_instrument(Console& console, const DescribeOptions& options) {
  const auto map = read_description(options.file);
  if (!map) return failure(map.error());
  const auto line = drivers::parse_line(options.line);
  if (!line || !drivers::is_byte_line(*line))
    return failure(FaultKind::usage, "--talk",
                   fmt::format("\"{}\" is not the address of a line, such as tcp://10.0.0.7 or serial:/dev/ttyUSB0",
                               options.line));
  const auto linked = select_link_for(*map, *line);
  if (!linked) return failure(linked.error());
  const auto* query = find_question(*linked, options.item);
  if (!query)
    return failure(FaultKind::usage, "--item", fmt::format("no question reads the item \"{}\"", options.item));
  ExchangedBytes bytes;
  auto stream = std::make_unique<CopyingStream>(make_text_stream(*line, *linked), bytes);
  const auto registers = make_text_registers(*linked, std::move(stream), linked->name);
  const auto words = registers->read(drivers::ReadFunction::holding_registers, query->first, query->count);
  console.print(fmt::format("sent      {}\nreceived  {}\n", plain(bytes.sent), plain(bytes.received)));
  if (!words) return failure(words.error());
  for (const auto& cell : query->cells) {
    const auto& item = linked->items[cell.item];
    const auto its = std::span(*words).subspan(static_cast<std::size_t>(item.address - query->first), word_count(item));
    console.print(fmt::format("{:<20} {}\n", item.name, show_value(item, its)));
  }
  return Exit::done;
}

}  // namespace

void add_describe(Program& program) {
  auto options = std::make_shared<DescribeOptions>();
  auto& command = add_command(program, "describe",
                              "Lists the questions and commands of a text instrument's description, or sends one "
                              "question to the instrument and shows the bytes and the values.",
                              "gyrotherm describe weiss_simserv --talk tcp://10.0.0.7 --item set_point");
  command.add_option("description", options->file, "Description: a file, or the name of a shipped one")
      ->required()
      ->type_name(value::kMap);
  auto* talk = command.add_option("--talk", options->line, "Line of the instrument to which the question is sent")
                   ->type_name("LINE");
  command.add_option("--item", options->item, "Item whose question is sent; by default the first question")
      ->type_name("ITEM")
      ->needs(talk);
  command.callback([&program, options] {
    if (!options->line.empty()) {
      program.outcome = ask_instrument(program.console, *options);
      return;
    }
    const auto map = read_description(options->file);
    if (map) program.console.print(list_items(*map));
    program.outcome = map ? Result<Exit>(Exit::done) : failure(map.error());
  });
}

}  // namespace gyrotherm::app
