// SPDX-License-Identifier: Apache-2.0
/// Items of a map, read and written over a line: with their decimals and unit as the controller has them set, and each
/// write seen to take effect.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "drivers/chamber/register_item.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/status_turns.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/pauses.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

using ValueOf = std::function<Result<double>(const RegisterItem&)>;

/// The context of `item` as the registers that it names say it; empty if it names none. `value_of` gives such a
/// register's value. Fails as that does, or with corrupted if the value is no count of decimals from 0 to 6 or no unit.
[[nodiscard]] Result<ItemContext> context_of(const RegisterMap& map, const RegisterItem& item, const ValueOf& value_of);

/// The finest step that the controller keeps, in this program's units.
[[nodiscard]] double finest_step(const RegisterItem& item);

/// Returns true if `text` matches `pattern`, in which "*" stands for any characters or none, "?" for one, "[1-4]" for
/// one of those and "[!1-4]" for any other one. A class has an end and at least one character.
[[nodiscard]] bool matches(std::string_view pattern, std::string_view text);
/// A short text that matches `pattern`.
[[nodiscard]] std::string example_of(std::string_view pattern);

/// A unit as it reported itself, and the parts of its identity that were compared with the map.
struct IdentityFound {
  /// Make, model, and the values of its registers: the same words from the same unit with the same settings.
  std::string who;
  std::vector<std::string> verified, not_verified;  ///< in words
};

/// Compares what the register of a fingerprint of the map, which is a number, holds with what it should. Fails with
/// mismatch.
[[nodiscard]] Result<void> check_fingerprint(const RegisterMap& map, const Fingerprint& print, double found);

class ItemExchange {
 public:
  /// All of them outlive it.
  ItemExchange(const RegisterMap& map, Registers& registers, Pauses& pauses);

  /// Takes the line as it is for the one to whose end is written. A break may put another unit there: before the next
  /// write after one the unit is asked again who it is, if it ever was, and the write fails with disconnected unless it
  /// answers as before. write_insisting() sends also to a unit that was recognised within two seconds, and to one that
  /// does not answer the question.
  void trust_line() { trusted_ = registers_.breaks(); }

  [[nodiscard]] const RegisterItem& item(std::string_view name) const;

  /// Asks the unit for the map's fingerprint, for what names this one unit, and for the settings that the map compares;
  /// where the map has no fingerprint, `instead` is read. Fails with mismatch if one of them is another, or like
  /// read(). A setting or number that the unit does not have is listed as not verified.
  [[nodiscard]] Result<IdentityFound> identify(const RegisterItem& instead);
  /// Does the same without the settings.
  [[nodiscard]] Result<IdentityFound> recognise(const RegisterItem& instead);

  /// The items that `items` need to be understood: decimals and units.
  [[nodiscard]] std::vector<const RegisterItem*> needed_by(std::span<const RegisterItem* const> items) const;
  /// What was just read holds for a second: contexts in it are not asked for again meanwhile.
  void know(const Snapshot& found);
  /// Keeps the units and decimals of the snapshot as the last that were read.
  void confirm(const Snapshot& found);
  [[nodiscard]] const ControllerSettings& confirmed() const { return confirmed_; }
  /// Takes settings that another program has read before.
  void assume(const ControllerSettings& settings) { confirmed_ = settings; }
  /// Lets a unit or a number of decimals that cannot be read count as it was last read: one register must not keep a
  /// chamber hot that is being made safe.
  void fall_back() { falls_back_ = true; }
  /// Returns true if nothing of the span is needed as long as it cannot be read: it holds contexts alone, which are
  /// known from before.
  [[nodiscard]] bool can_do_without(const ReadSpan& span) const;

  /// Reads the spans; fails with the first that fails.
  [[nodiscard]] Result<Snapshot> look(std::span<const ReadSpan> spans);
  /// The value of an item in a snapshot that holds it and its context.
  [[nodiscard]] Result<double> value_in(const Snapshot& snapshot, const RegisterItem& item) const;

  /// One number, its context read with it. Fails as Registers::read and decode() do.
  [[nodiscard]] Result<double> read(const RegisterItem& item);
  /// The item with its scale and unit as the controller has them set, which are asked for. Fails as read() does.
  [[nodiscard]] Result<RegisterItem> in_its_context(const RegisterItem& item);
  [[nodiscard]] Result<std::string> read_text(const RegisterItem& item);
  [[nodiscard]] Result<CivilTime> read_date(const RegisterItem& item);

  /// Writes `value`, and what the item's map says with it, then waits until it shows where the map says, within its
  /// time. Fails with out_of_range, and writes nothing, if the register cannot hold it; with mismatch if something else
  /// is read back.
  [[nodiscard]] Result<void> write(const RegisterItem& item, double value) { return write(item, value, 1); }
  /// Likewise, on a bad line: what is not acknowledged is sent again at once, for it is the same whether it arrives
  /// once or three times; and where the item shows the value then, it has arrived, acknowledged or not.
  [[nodiscard]] Result<void> write_insisting(const RegisterItem& item, double value) { return write(item, value, 3); }
  [[nodiscard]] Result<void> write_date(const RegisterItem& item, const CivilTime& time);
  /// As they are, in pieces of the link's limit.
  [[nodiscard]] Result<void> write_words(const RegisterItem& item, std::span<const std::uint16_t> words);

  /// Carries out a command. Fails with the first step that fails, or with timeout where a wait was in vain.
  struct Parameters {
    int program = 0, step = 0;
  };
  [[nodiscard]] Result<void> perform(const Sequence& sequence, const Parameters& parameters);

 private:
  /// Reads an item, in words and as a number. Fails like read().
  struct Shown {
    std::string words;
    std::optional<double> value;  ///< nothing: a text
  };
  [[nodiscard]] Result<Shown> show(const RegisterItem& item);
  [[nodiscard]] Result<void> check(const Fingerprint& print, const Shown& shown) const;
  [[nodiscard]] Result<void> check(const VerifiedSetting& setting, const Shown& shown) const;
  [[nodiscard]] Result<void> add_shown(const std::string& name, const VerifiedSetting* setting, IdentityFound& found);

  enum class Trust { same, another, unanswered };
  /// Asks who answers if the line broke since it was last trusted.
  [[nodiscard]] Trust trust();
  [[nodiscard]] Result<void> write_safe_words(const RegisterItem& item, std::span<const std::uint16_t> words);
  [[nodiscard]] tl::unexpected<Fault> not_sent(const RegisterItem& item) const;
  [[nodiscard]] Result<void> write(const RegisterItem& item, double value, int tries);
  [[nodiscard]] Result<void> write_words(const RegisterItem& item, std::span<const std::uint16_t> words, int tries);
  [[nodiscard]] bool knows(const RegisterItem& item) const;
  [[nodiscard]] Result<double> or_as_before(const RegisterItem& item, Result<double> value) const;
  [[nodiscard]] Result<double> context_value(const RegisterItem& item);
  [[nodiscard]] Result<double> read_in_known_context(const RegisterItem& item);
  [[nodiscard]] Result<std::vector<std::uint16_t>> read_words(const RegisterItem& item);
  [[nodiscard]] Result<std::vector<std::uint16_t>> words_for(const RegisterItem& item, double value);
  [[nodiscard]] Result<void> wait_until_seen(const RegisterItem& written, double value);
  [[nodiscard]] Result<void> wait_until(const Condition& condition, Duration within);
  [[nodiscard]] Result<void> write_step(const SequenceStep& step, const Parameters& parameters);
  [[nodiscard]] Result<void> perform_step(const SequenceStep& step, const Parameters& parameters);

  const RegisterMap& map_;
  Registers& registers_;
  Pauses& pauses_;
  Snapshot known_;
  Duration known_since_{};
  std::uint64_t trusted_ = 0;  ///< breaks, when it was trusted
  Duration recognised_at_{};
  std::string recognised_;                       ///< the last identity; empty: never asked
  const RegisterItem* recognised_by_ = nullptr;  ///< in place of a fingerprint
  std::vector<const RegisterItem*> contexts_;    ///< units and decimals of any item
  ControllerSettings confirmed_;
  bool falls_back_ = false;
};

}  // namespace gyrotherm::drivers
