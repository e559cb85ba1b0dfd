// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/console/command.hpp"
#include "core/file.hpp"
#include "core/shipped.hpp"
#include "core/text.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_client.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/text_unit_file.hpp"
#include "simulator/chamber_registers.hpp"

namespace gyrotherm::app {
namespace {

namespace fs = std::filesystem;

struct DescribeOptions {
  std::string file;
  /// Address of an instrument; empty to print the description.
  std::string line;
  /// Item whose question is sent; the first question if empty.
  std::string item;
  /// Parameters that replace those of the file: "NAME=VALUE".
  std::vector<std::string> parameters;
  /// The lines of [sequence] prepare are sent first.
  bool prepares = false;
  /// The line returns what is sent.
  bool echo = false;
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

constexpr std::string_view kTextSchema = "gyrotherm-text/1";

/// Returns the path of a file. A name is that of a shipped text instrument of any kind.
Result<std::string> find_description(const std::string& given) {
  if (is_path(given)) return given;
  for (const auto& shipped : shipped_folders())
    for (const auto& folder : list_folder(fs::path(shipped) / "profiles")) {
      const auto path = (folder / (given + ".toml")).string();
      const auto text = read_text_file(path);
      if (text && text->find(kTextSchema) != std::string::npos) return path;
    }
  return resolve_path(given, kShippedChamberMap);
}

/// Reads "channels=101:104".
Result<drivers::TextParameters> read_parameters(const std::vector<std::string>& all) {
  drivers::TextParameters parameters;
  for (const auto& one : all) {
    const auto equals = one.find('=');
    if (equals == 0 || equals == std::string::npos)
      return failure(FaultKind::usage, "--parameter", fmt::format("\"{}\" is not NAME=VALUE", one));
    parameters[one.substr(0, equals)] = one.substr(equals + 1);
  }
  return parameters;
}

Result<drivers::TextUnitFile> read_description(const DescribeOptions& options) {
  const auto path = find_description(options.file);
  if (!path) return failure(path.error());
  const auto text = read_text_file(*path);
  if (!text) return failure(text.error());
  const auto parameters = read_parameters(options.parameters);
  if (!parameters) return failure(parameters.error());
  auto file = drivers::read_text_unit_file(*text, *path, *parameters);
  if (!file || file->unit.text.empty()) return file;
  const auto unit = simulator::read_simulated_unit(file->unit, *path);
  if (!unit) return failure(unit.error());
  if (!parameters->empty()) return file;
  if (auto sound = check_simulated_identity(file->unit, *unit, *path); !sound) return failure(std::move(sound.error()));
  return file;
}

/// Returns the names of the items in an answer: "mode, alarm" or "readings_1 … readings_8".
std::string list_names(const drivers::RegisterMap& unit, const drivers::TextQuery& query) {
  constexpr std::size_t kMostNames = 6;
  std::vector<std::string> names;
  for (const auto& cell : query.cells) names.push_back(unit.items[cell.item].name);
  if (names.size() > kMostNames) return names.front() + " … " + names.back();
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Formats a template with the names of its fields in place of their values: "PRGM DATA WRITE,PGM…,STEP…".
std::string show_template(const drivers::TextTemplate& form) {
  drivers::FieldValues values;
  for (const auto& [name, field] : form.fields()) {
    const bool is_digits = field.kind == drivers::FieldForm::Kind::bits;
    values[name] = is_digits ? std::string(static_cast<std::size_t>(field.width), '?') : std::string("…");
  }
  return plain(form.format(values));
}

std::string list_lines(const drivers::TextUnitFile& file) {
  const auto& unit = file.unit;
  std::string text = fmt::format("{} {}\n", unit.vendor, unit.name);
  const auto add = [&](const std::string& line, const std::string& what) {
    text += fmt::format("  {:<28} {}\n", plain(line), what);
  };
  for (const auto& [name, value] : unit.parameters) text += fmt::format("  parameter {} = {}\n", name, plain(value));
  for (const auto& one : file.preparation)
    add(one.line, one.answers.empty() ? "prepares" : "prepares, and is answered");
  for (const auto& query : unit.text_link->queries) {
    for (const auto& command : query.before) add(command, "precedes the next question");
    add(query.ask, list_names(unit, query));
  }
  for (const auto& command : unit.text_link->commands)
    add(show_template(command.tell), fmt::format("writes {}{}", unit.items[command.item].name,
                                                 command.acknowledged.empty() ? "; not acknowledged" : ""));
  for (const auto& stored : unit.text_link->memory) {
    add(show_template(stored.tell), "stores a part of a program");
    if (stored.ask) add(show_template(*stored.ask), "reads it back");
  }
  return text + file.confidence + "\n";
}

/// Returns the questions that read an item; the first question of the file if no item is given. An item of several
/// inputs has one question for each.
std::vector<const drivers::TextQuery*> find_questions(const drivers::RegisterMap& unit, const std::string& item) {
  const auto& queries = unit.text_link->queries;
  std::vector<const drivers::TextQuery*> found;
  if (item.empty() && !queries.empty()) return {&queries.front()};
  for (const auto& query : queries) {
    const auto is_read = [&](const drivers::TextCell& cell) {
      const auto& name = unit.items[cell.item].name;
      return name == item || name.starts_with(item + "_");
    };
    const auto is_named = [&](const drivers::TextCell& cell) { return unit.items[cell.item].name == item; };
    if (std::ranges::any_of(query.cells, is_named)) return {&query};
    if (std::ranges::any_of(query.cells, is_read)) found.push_back(&query);
  }
  return found;
}

std::string show_value(const drivers::RegisterItem& item, std::span<const std::uint16_t> words) {
  if (item.type == drivers::RegisterType::text) return fmt::format("\"{}\"", decode_text(item.text, words));
  const auto value = decode(item, words);
  if (!value) return value.error().what;
  if (item.flags.empty()) return item.codes.empty() ? fmt::format("{:.10g}", *value) : drivers::meaning(item, *value);
  std::vector<std::string> names;
  for (const auto& [name, bit] : item.flags)
    if ((static_cast<std::int64_t>(*value) >> bit & 1) != 0) names.push_back(name);
  return fmt::format("{:.10g} ({})", *value, names.empty() ? "no flag" : fmt::format("{}", fmt::join(names, ", ")));
}

/// Sends the lines of a description to an instrument, and prints the bytes and values.
class Conversation {
 public:
  Conversation(Console& console, const drivers::RegisterMap& unit, const drivers::Line& line)
      : console_(console),
        unit_(unit),
        client_(unit_, std::make_unique<CopyingStream>(make_text_stream(line, unit_), bytes_), unit_.name, nullptr) {}

  /// Sends a line of the preparation.
  Result<void> prepare(const drivers::PreparingLine& line) {
    auto done =
        line.answers.empty() ? client_.tell(line.line) : client_.ask(line.line, line.answers).map([](auto&&) {});
    print_bytes();
    return done;
  }

  /// Asks a question, once more after a damaged answer, and prints the values in the answer.
  Result<void> ask(const drivers::TextQuery& query) {
    auto answer = ask_once(query);
    if (!answer && answer.error().kind == FaultKind::corrupted) answer = ask_once(query);
    print_bytes();
    if (!answer) return failure(answer.error());
    for (const auto& cell : query.cells) {
      const auto& item = unit_.items[cell.item];
      const auto field = answer->fields.find(cell.field);
      const auto words = field == answer->fields.end() ? std::nullopt : to_words(cell, item, field->second);
      const auto value =
          words ? show_value(item, *words)
                : std::string(field == answer->fields.end() ? "not in this form of the answer" : "unknown");
      console_.print(fmt::format("{:<20} {}\n", item.name, value));
    }
    return {};
  }

  /// Returns whether bytes were sent or received.
  [[nodiscard]] bool has_exchanged() const { return has_exchanged_; }

 private:
  Result<drivers::TextAnswer> ask_once(const drivers::TextQuery& query) {
    for (const auto& command : query.before)
      if (auto sent = client_.tell(command); !sent) return failure(std::move(sent.error()));
    return client_.ask(query.ask, query.answers, query.within);
  }

  void print_bytes() {
    if (bytes_.sent.empty() && bytes_.received.empty()) return;  // the line could not be opened
    has_exchanged_ = true;
    console_.print(fmt::format("sent      {}\nreceived  {}\n", plain(bytes_.sent), plain(bytes_.received)));
    bytes_ = {};
  }

  Console& console_;
  const drivers::RegisterMap& unit_;
  ExchangedBytes bytes_;
  bool has_exchanged_ = false;
  drivers::TextClient client_;
};

/// Sends the questions for an item and prints the bytes, the values in the answers, or the reason why there are none.
Result<Exit> ask_instrument(Console& console, const DescribeOptions& options) {
  auto file = read_description(options);
  if (!file) return failure(file.error());
  const auto line = drivers::parse_line(options.line);
  if (!line || !drivers::is_byte_line(*line))
    return failure(FaultKind::usage, "--talk",
                   line ? fmt::format("\"{}\" is not a TCP or serial line", options.line) : line.error().what);
  auto linked = select_link_for(file->unit, *line);
  if (!linked) return failure(linked.error());
  linked->link.modbus.echo = options.echo;
  const auto questions = find_questions(*linked, options.item);
  if (questions.empty())
    return failure(FaultKind::usage, "--item",
                   linked->find(options.item)
                       ? fmt::format("\"{}\" is a command; --talk sends questions only", options.item)
                       : fmt::format("the description has no item \"{}\"", options.item));
  if (options.prepares && file->preparation.empty())
    return failure(FaultKind::usage, "--prepare", "the description has no [sequence] prepare");
  Conversation conversation(console, *linked, *line);
  const auto fail_at_line = [&](Fault fault) {
    if (!conversation.has_exchanged()) fault.where += " at " + options.line;
    return failure(std::move(fault));
  };
  if (options.prepares)
    for (const auto& one : file->preparation)
      if (auto done = conversation.prepare(one); !done) return fail_at_line(std::move(done.error()));
  for (const auto* query : questions)
    if (auto done = conversation.ask(*query); !done) return fail_at_line(std::move(done.error()));
  return Exit::done;
}

}  // namespace

void add_describe(Program& program) {
  auto options = std::make_shared<DescribeOptions>();
  auto& command = add_command(program, "describe",
                              "Lists the questions and commands of a text instrument's description, or sends the "
                              "question of an item to the instrument and shows the bytes and the values.",
                              "gyrotherm describe weiss_simserv --talk tcp://10.0.0.7 --item set_point");
  command.add_option("description", options->file, "Description: a file, or the name of a shipped one")
      ->required()
      ->type_name(value::kMap);
  auto* talk = command.add_option("--talk", options->line, "Line of the instrument to which the question is sent")
                   ->type_name("LINE");
  command.add_option("--item", options->item, "Item whose question is sent; by default the first question")
      ->type_name("ITEM")
      ->needs(talk);
  command
      .add_flag("--echo", options->echo, "The line or its adapter returns what is sent, as echo = true in a rig file")
      ->needs(talk);
  command.add_flag("--prepare", options->prepares, "Sends the lines of [sequence] prepare first")->needs(talk);
  command
      .add_option("--parameter", options->parameters,
                  "Value of a parameter of the description, as in the rig file; may be repeated")
      ->type_name("NAME=VALUE");
  command.callback([&program, options] {
    if (!options->line.empty()) {
      program.outcome = ask_instrument(program.console, *options);
      return;
    }
    const auto file = read_description(*options);
    if (file) program.console.print(list_lines(*file));
    program.outcome = file ? Result<Exit>(Exit::done) : failure(file.error());
  });
}

}  // namespace gyrotherm::app
