// SPDX-License-Identifier: Apache-2.0
/// A text instrument without registers, such as a thermometer scanner or a power supply: the tables that the files of
/// such instruments have in common, and its identity and preparation. docs/text-instruments.md describes the format.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_client.hpp"
#include "drivers/chamber/text_file_reader.hpp"
#include "drivers/chamber/text_link.hpp"
#include "drivers/line/text_template.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// Field of an answer that holds the value of its item.
inline constexpr const char* kTextValueField = "value";

/// A line that prepares an instrument.
struct PreparationStep {
  std::string line;
  /// The answer is one of these; empty for a command without an answer.
  std::vector<TextTemplate> answers;
  /// Field of the answer that must have a value, and this value; empty if any answer is accepted.
  std::string field;
  FieldValue required;
};

/// The part of a description that all instruments have.
struct TextInstrumentDescription {
  /// Name, links, identity and text link of the instrument, without items.
  RegisterMap unit;
  /// Sent when the instrument is opened, after each broken connection and after each lost answer.
  std::vector<PreparationStep> preparation;
};

/// Returns whether a field of this form holds a number or a list of numbers.
[[nodiscard]] bool is_numeric_form(const FieldForm& form);

/// Reads name, vendor, source, the parameters in effect, [link], [identity] and [sequence]. Errors are noted in the
/// tables. The caller assigns `text` to the unit.
void read_text_instrument(const TomlTable& file, const TemplateReader& templates, Duration longest_timeout,
                          TextLink& text, TextInstrumentDescription& target);

/// The connection to one instrument. On each connection the identity is asked first and must fit the description. The
/// preparation follows, and is repeated after forget_preparation(), because the instrument may have lost its settings.
class TextInstrument {
 public:
  /// `description` and `clock` must outlive this object. `place` is the location of all faults. A null clock means the
  /// steady clock.
  TextInstrument(const TextInstrumentDescription& description, std::unique_ptr<ByteStream> stream, std::string place,
                 const Clock* clock);

  /// Asks the identity and prepares the instrument. Fails with mismatch if another instrument answers, or if the
  /// instrument refuses its preparation.
  [[nodiscard]] Result<std::string> identify();
  /// Asks the identity only.
  [[nodiscard]] Result<std::string> recognise();
  /// Identifies and prepares the instrument, unless this has been done on the present connection.
  [[nodiscard]] Result<void> make_ready();
  void forget_preparation() { is_prepared_ = false; }
  [[nodiscard]] std::uint64_t breaks() const { return client_.breaks(); }
  [[nodiscard]] TextClient& client() { return client_; }

 private:
  [[nodiscard]] bool is_recognised() const { return recognised_after_ == client_.breaks(); }
  [[nodiscard]] Result<void> prepare();
  [[nodiscard]] Result<void> perform(const PreparationStep& step);

  const TextInstrumentDescription& description_;
  std::string place_;
  TextClient client_;
  /// Number of broken connections before the one on which the instrument was recognised.
  std::optional<std::uint64_t> recognised_after_;
  bool is_prepared_ = false;
};

}  // namespace gyrotherm::drivers
