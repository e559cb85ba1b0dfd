// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/text_memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_file_reader.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::uint16_t kMostCharactersOfName = 32;
constexpr int kUsualDecimals = 3;
constexpr int kRegisterCount = 0x10000;

/// Returns the form of a cell in virtual registers.
RegisterItem cell_item(const std::string& field, const FieldForm& form, std::uint16_t name_characters) {
  RegisterItem item;
  item.name = field;
  if (form.kind == FieldForm::Kind::text) {
    item.type = RegisterType::text;
    item.text.characters = name_characters;
    return item;
  }
  item.type = RegisterType::s32;
  if (form.kind == FieldForm::Kind::number)
    item.scale = std::pow(10.0, -(form.decimals < 0 ? kUsualDecimals : form.decimals));
  item.resolution = item.scale;
  return item;
}

class MemoryReader {
 public:
  MemoryReader(const TomlTable& table, const TemplateReader& templates, ProfileMemory& memory)
      : table_(table), templates_(templates), memory_(memory) {}

  std::vector<TextMemoryLine> read() {
    name_characters_ = whole<std::uint16_t>(table_, "name_characters", 1, kMostCharactersOfName, kMostCharactersOfName);
    read_blocks("header", memory_.header, 1);
    const auto begin = lines_.size();
    read_blocks("step", memory_.step, memory_.steps_at_most);
    set_stride(begin);
    read_blocks("footer", memory_.footer, 1);
    return std::move(lines_);
  }

 private:
  void read_blocks(const char* key, std::vector<MemoryBlock>& blocks, int steps) {
    for (const auto& table : table_.tables(key)) {
      auto line = read_line(table);
      line.steps = steps;
      MemoryBlock block;
      block.address = line.first;
      block.count = line.count;
      block.function = WriteFunction::registers;
      block.read_back = line.ask.has_value();
      for (const auto& word : table.texts("for")) {
        const auto kind = std::ranges::find(kStepKinds, word, &decltype(kStepKinds)::value_type::first);
        if (kind == kStepKinds.end())
          table.note_error("for", "expected ramp, soak or end");
        else
          block.kinds.push_back(kind->second);
      }
      for (const auto& cell : line.cells) block.cells.push_back({cell.at, source(table, cell.field), 0, cell.form});
      blocks.push_back(std::move(block));
      lines_.push_back(std::move(line));
    }
  }

  TextMemoryLine read_line(const TomlTable& table) {
    TextMemoryLine line;
    line.first = static_cast<std::uint16_t>(std::min(next_, kRegisterCount - 1));
    line.tell = templates_.read(table, "tell", table.text("tell"));
    line.acknowledged = templates_.read_all(table, "acknowledged");
    add_cells(table, line.tell, line);
    if (table.has("ask")) read_question(table, line);
    if (line.acknowledged.empty() && !line.ask)
      table.note_error("tell", "this command is neither acknowledged nor read back");
    next_ += line.count;
    return line;
  }

  void read_question(const TomlTable& table, TextMemoryLine& line) {
    line.ask = templates_.read(table, "ask", table.text("ask"));
    line.answers = templates_.read_all(table, "answer");
    if (line.answers.empty()) table.note_error("answer", "missing key \"answer\"");
    const auto is_known = [](const std::string& field) {
      return field == kProgramNumberField || field == kProgramStepField;
    };
    for (const auto& field : line.ask->fields())
      if (!is_known(field.name))
        table.note_error("ask", fmt::format("the field \"{}\" has no value here, expected number or step", field.name));
    for (const auto& answer : line.answers) {
      for (const auto& field : answer.fields())
        if (field.name != "_" && field.name != kProgramStepCountField && !line.tell.find(field.name))
          table.note_error("answer", fmt::format("the field \"{}\" is not in \"tell\"", field.name));
      for (const auto& field : line.tell.fields())
        if (field.name != "_" && !is_known(field.name) && !answer.find(field.name))
          table.note_error("answer", fmt::format("the field \"{}\" of \"tell\" is missing", field.name));
      add_cells(table, answer, line);
    }
  }

  /// Adds the fields that the line does not have yet.
  void add_cells(const TomlTable& table, const TextTemplate& form, TextMemoryLine& line) const {
    for (const auto& field : form.fields()) {
      const bool is_known = std::ranges::find(line.cells, field.name, &TextMemoryCell::field) != line.cells.end();
      if (field.name == "_" || is_known) continue;
      TextMemoryCell cell{.field = field.name,
                          .at = line.count,
                          .form = cell_item(field.name, field.form, name_characters_),
                          .codes = {}};
      read_codes(table, cell);
      line.count = static_cast<std::uint16_t>(line.count + word_count(cell.form));
      line.cells.push_back(std::move(cell));
    }
  }

  /// Reads the codes of a field: { ramp = "ON", soak = "OFF" } or numbers.
  static void read_codes(const TomlTable& table, TextMemoryCell& cell) {
    const auto codes = table.table("codes").table(cell.field);
    for (const auto& name : codes.keys()) {
      if (codes.is_text(name)) {
        cell.form.codes[name] = {static_cast<std::int64_t>(cell.codes.size())};
        cell.codes.push_back(codes.text(name));
      } else {
        cell.form.codes[name] = {codes.integer(name)};
      }
    }
    if (!cell.codes.empty()) {
      cell.form.type = RegisterType::s32;
      cell.form.scale = cell.form.resolution = 1;
    }
    if (const auto* key = missing_code(cell))
      table.note_error("codes", fmt::format("the field \"{}\" needs a code named \"{}\"", cell.field, key));
  }

  static const char* missing_code(const TextMemoryCell& cell) {
    const auto lacks = [&](const char* name) { return !cell.form.codes.contains(name); };
    if (cell.field == "kind") return lacks("ramp") ? "ramp" : lacks("soak") ? "soak" : nullptr;
    if (cell.field == "guaranteed_soak") return lacks("off") ? "off" : lacks("on") ? "on" : nullptr;
    return nullptr;
  }

  static CellSource source(const TomlTable& table, const std::string& field) {
    const auto found = std::ranges::find(kCellSources, field, &decltype(kCellSources)::value_type::first);
    if (found != kCellSources.end() && found->second != CellSource::constant) return found->second;
    table.note_error("tell", fmt::format("the field \"{}\" is not a part of a program", field));
    return CellSource::constant;
  }

  /// Sets the distance between steps to the registers that all lines of a step occupy.
  void set_stride(std::size_t begin) {
    int stride = 0;
    for (auto i = begin; i < lines_.size(); ++i) stride += lines_[i].count;
    memory_.stride = static_cast<std::uint16_t>(std::min(stride, kRegisterCount - 1));
    for (auto i = begin; i < lines_.size(); ++i) lines_[i].stride = memory_.stride;
    next_ += stride * (memory_.steps_at_most - 1);
    if (next_ >= kRegisterCount)
      table_.note_error("steps_at_most",
                        fmt::format("{} steps with {} registers each, expected at most {} registers in all",
                                    memory_.steps_at_most, stride, kRegisterCount));
  }

  const TomlTable& table_;
  const TemplateReader& templates_;
  ProfileMemory& memory_;
  std::vector<TextMemoryLine> lines_;
  int next_ = kTextMemoryFirst;
  std::uint16_t name_characters_ = kMostCharactersOfName;
};

std::span<const std::uint16_t> cell_words(const TextMemoryCell& cell, std::span<const std::uint16_t> words) {
  return words.subspan(cell.at, word_count(cell.form));
}

FieldValue to_field(const TextMemoryCell& cell, std::span<const std::uint16_t> words) {
  if (cell.form.type == RegisterType::text) return decode_text(cell.form.text, words);
  const double value = decode_as_written(cell.form, words);
  if (cell.codes.empty()) return value;
  const auto position = static_cast<std::size_t>(std::max(value, 0.0));
  return position < cell.codes.size() ? cell.codes[position] : std::string();
}

std::optional<std::vector<std::uint16_t>> to_words(const TextMemoryCell& cell, const FieldValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  if (cell.form.type == RegisterType::text)
    return text ? std::optional(encode_text(cell.form.text, *text)) : std::nullopt;
  if (!cell.codes.empty()) {
    const auto found = text ? std::ranges::find(cell.codes, *text) : cell.codes.end();
    if (found == cell.codes.end()) return std::nullopt;
    return encode(cell.form, static_cast<double>(found - cell.codes.begin()));
  }
  const auto* number = std::get_if<double>(&value);
  return number && std::isfinite(*number) ? std::optional(encode(cell.form, *number)) : std::nullopt;
}

std::string describe_field(const FieldValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  const auto* number = std::get_if<double>(&value);
  return number ? fmt::format("{:.10g}", *number) : std::string("a list");
}

}  // namespace

FieldValues to_fields(const TextMemoryLine& line, std::span<const std::uint16_t> words) {
  FieldValues fields;
  for (const auto& cell : line.cells) fields[cell.field] = to_field(cell, cell_words(cell, words));
  return fields;
}

std::optional<std::vector<std::uint16_t>> to_words(const TextMemoryLine& line, const FieldValues& fields) {
  std::vector<std::uint16_t> words(line.count);
  for (const auto& cell : line.cells) {
    const auto field = fields.find(cell.field);
    if (field == fields.end()) continue;
    const auto own = to_words(cell, field->second);
    if (!own) return std::nullopt;
    std::ranges::copy(*own, words.begin() + cell.at);
  }
  return words;
}

std::string describe_difference(const TextMemoryLine& line, std::span<const std::uint16_t> found,
                                std::span<const std::uint16_t> expected) {
  for (const auto& cell : line.cells) {
    const auto its = cell_words(cell, found), wanted = cell_words(cell, expected);
    if (!std::ranges::equal(its, wanted))
      return fmt::format("{} is {}, expected {}", cell.field, describe_field(to_field(cell, its)),
                         describe_field(to_field(cell, wanted)));
  }
  return "is equal";
}

std::vector<TextMemoryLine> read_text_memory(const TomlTable& table, const TemplateReader& templates,
                                             RegisterMap& map) {
  auto memory = read_memory_properties(table, map);
  auto lines = MemoryReader(table, templates, memory).read();
  check_steps(table, memory);
  map.memory = std::move(memory);
  return lines;
}

}  // namespace gyrotherm::drivers
