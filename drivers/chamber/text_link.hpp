// SPDX-License-Identifier: Apache-2.0
/// The text protocol of an instrument that a file describes: questions, commands and answers of its items. Each item of
/// a text unit occupies virtual registers, so the item exchange, the rules and the simulator treat text units as they
/// treat Modbus units. docs/text-instruments.md describes the file format.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "drivers/chamber/register_item.hpp"
#include "drivers/chamber/text_memory.hpp"
#include "drivers/line/text_frame.hpp"
#include "drivers/line/text_template.hpp"

namespace gyrotherm::drivers {

/// Characters of an identity that are compared, because a regular expression needs stack for each character.
inline constexpr std::size_t kLongestIdentity = 128;

struct Condition;
struct RegisterMap;

/// Properties of one kind of line.
struct TextWire {
  std::string question_end = "\n";
  /// If empty, an answer ends with a silence of `silence`.
  std::string answer_end = "\n";
  Duration silence = std::chrono::milliseconds(50);
  /// Required silence before a question, in which a repeated answer is discarded.
  Duration quiet = std::chrono::milliseconds(25);
  /// Pauses after a question's answer, and after a command or its acknowledgement.
  Duration after_read{}, after_write{};
  std::size_t longest_answer = 256;
  /// Precedes each question, and each answer if `answers_have_prefix`; its field "address" is the unit number.
  std::optional<TextTemplate> prefix;
  bool answers_have_prefix = false;
  std::optional<TextFrame> frame;
};

/// Values of the parameters of a text instrument, by name. In a rig file they replace those of the instrument's file.
using TextParameters = std::map<std::string, std::string>;

/// Texts of an item's codes; the position of a text is the value in the register.
using CodeTexts = std::vector<std::string>;

/// Place of a field's value in the virtual registers.
struct TextCell {
  std::string field;
  /// Index of the item in RegisterMap::items.
  std::size_t item{};
  CodeTexts codes;  ///< empty: the field is not a code in text form
  /// Position of the value in a field that is a list; nothing for a single value.
  std::optional<std::size_t> position{};
};

/// One question with its answers. Registers `first` to `first + count − 1` hold the values of an answer.
struct TextQuery {
  std::uint16_t first{}, count{};
  std::string ask;
  /// Other spellings, which only the virtual unit accepts.
  std::vector<std::string> also_asked;
  /// Commands without an answer that precede the question.
  std::vector<std::string> before;
  std::vector<TextTemplate> answers;
  /// Time limit of the answer; that of the link if empty.
  std::optional<Duration> within{};
  std::vector<TextCell> cells;
  /// Fields of items that belong to another question. Only the virtual unit uses them.
  std::vector<TextCell> mirrors;
};

struct TextCommand {
  /// Index of the written item in RegisterMap::items.
  std::size_t item{};
  /// Field "value" is the written value. Any other field has the name of an item, whose present value is sent.
  TextTemplate tell;
  /// The acknowledgement is one of these; empty if the unit sends none.
  std::vector<TextTemplate> acknowledged;
  CodeTexts codes;
  /// Lines without an answer that make the written value effective, such as a start command. They are sent before the
  /// next exchange.
  std::vector<std::string> then;
  /// Condition before the command under which `then` is sent; null: always.
  std::shared_ptr<const Condition> then_when;
};

struct TextLink {
  TextEncoding encoding = TextEncoding::ascii;
  /// Refusals of a question or command. Field "code" is a key of `refusals`; "reason" is shown.
  std::vector<TextTemplate> refused;
  std::map<std::int64_t, std::string> refusals;
  std::vector<TextQuery> queries;
  std::vector<TextCommand> commands;
  std::vector<TextMemoryLine> memory;
  /// Question of the identity item, whose answer resynchronises the line; empty if there is none.
  std::string identity_question;
  std::vector<TextTemplate> identity_answers;
  /// Items with a unit or a scale, whose numbers have a sign.
  std::set<std::string> quantities;

  [[nodiscard]] const TextQuery* find_query(std::uint16_t address) const;
  [[nodiscard]] const TextCommand* find_command(const RegisterMap& map, std::uint16_t address) const;
  /// Returns the line of the profile memory whose registers contain `address`, or null.
  [[nodiscard]] const TextMemoryLine* find_memory_line(std::uint16_t address) const;
};

/// Returns the field's value as the words of its registers, or nothing if it is a text that is not a code, or a list
/// without the position of the cell.
[[nodiscard]] std::optional<std::vector<std::uint16_t>> to_words(const TextCell& cell, const RegisterItem& item,
                                                                 const FieldValue& value);
/// Returns the field for the words of an item.
[[nodiscard]] FieldValue to_field(const RegisterItem& item, const CodeTexts& codes,
                                  std::span<const std::uint16_t> words);

/// Reads the keys of a text unit: name, vendor, source, [parameter], [link], [[item]], [identity]. `parameters` replace
/// those of the file. Errors are noted in the table.
void read_text_unit(const TomlTable& file, const TextParameters& parameters, RegisterMap& map);
/// Reads the same keys of a text instrument of any kind, as far as they describe its lines. An item with `inputs` has
/// one question for each, and the item NAME_INPUT. The values are those on the line. `own_parameters` are those of the
/// kind, which the file does not list.
void read_text_lines(const TomlTable& file, const TextParameters& parameters, const TextParameters& own_parameters,
                     RegisterMap& map);

}  // namespace gyrotherm::drivers
