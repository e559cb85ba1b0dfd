// SPDX-License-Identifier: Apache-2.0
/// Reads the tables that the files of all text instruments have: [parameter], [link] and the pattern of [identity].
/// Errors are noted in the tables.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_link.hpp"
#include "drivers/line/text_template.hpp"

namespace gyrotherm::drivers {

/// Maximum number of virtual registers in one read of a text unit.
inline constexpr std::uint16_t kTextReadAtMost = 250;

/// Longest time limit of an answer of a chamber or supply, which one second of a run may wait for. After two such times
/// without an answer, the guard takes the program for hung.
inline constexpr Duration kLongestTextTimeout = std::chrono::seconds(4);
/// Longest time limit of an answer of an instrument that is read in the background.
inline constexpr Duration kLongestScanTimeout = std::chrono::seconds(10);

/// Formats the value of a parameter that is a number.
[[nodiscard]] std::string format_parameter(double number);
/// Reads a table of parameters: texts and numbers.
[[nodiscard]] TextParameters read_text_parameters(const TomlTable& table);

/// Reads a text or a list of texts. The result is empty if the key is absent.
[[nodiscard]] std::vector<std::string> texts_at(const TomlTable& table, const char* key);

/// Reads the templates of a file, with its parameters inserted.
class TemplateReader {
 public:
  /// Reads [parameter]. `parameters` replace those of the file; a name that the file does not have is ignored.
  TemplateReader(const TomlTable& file, TextEncoding encoding, const TextParameters& parameters);

  /// Returns a reader with one more parameter.
  [[nodiscard]] TemplateReader with(const std::string& name, const std::string& value) const;

  /// Parses `text`, which was read at `key`.
  [[nodiscard]] TextTemplate read(const TomlTable& table, const char* key, const std::string& text) const;
  [[nodiscard]] std::vector<TextTemplate> read_all(const TomlTable& table, const char* key) const;
  /// Parses a line without fields.
  [[nodiscard]] std::string read_constant(const TomlTable& table, const char* key, const std::string& text) const;
  /// Replaces each "{channels:s}" by the parameter `channels`.
  [[nodiscard]] std::string with_parameters(std::string text) const;

  /// Returns the parameters in effect.
  [[nodiscard]] const TextParameters& parameters() const { return parameters_; }

 private:
  TextEncoding encoding_;
  TextParameters parameters_;
};

/// Requires that an answer on a link without terminator cannot be taken for whole when its end is lost.
void check_answer_ends(const TomlTable& table, const std::vector<TextTemplate>& answers, const RegisterMap& unit);

/// Reads the encoding in [link].
[[nodiscard]] TextEncoding read_text_encoding(const TomlTable& link);
/// Reads the links of a unit, [link.tcp] and [link.serial], and selects the usual one.
void read_text_links(const TomlTable& link, const TemplateReader& templates, Duration longest_timeout,
                     RegisterMap& unit);
void read_text_refusals(const TomlTable& link, const TemplateReader& templates, TextLink& text);
/// Reads the regular expression in [identity], with its parameters inserted. After an error, the result is a valid
/// expression too.
[[nodiscard]] std::string read_identity_pattern(const TomlTable& identity, const TemplateReader& templates);

}  // namespace gyrotherm::drivers
