// SPDX-License-Identifier: Apache-2.0
/// Reading and writing of a map's items over a line. Values are converted by the controller's present settings for
/// decimals and unit, and the effect of each write is verified.
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

/// Returns the value of an item.
using ValueOf = std::function<Result<double>(const RegisterItem&)>;

/// Returns the context of `item`: the values of the registers for its decimals and unit, read by `value_of`. The
/// context is empty if the item names no such registers. Fails as `value_of` does, or with corrupted if the number of
/// decimals is not from 0 to 6 or the unit is unknown.
[[nodiscard]] Result<ItemContext> read_context(const RegisterMap& map, const RegisterItem& item,
                                               const ValueOf& value_of);

/// Returns the smallest step that the controller stores, in °C or K.
[[nodiscard]] double finest_step(const RegisterItem& item);

/// Returns whether `text` matches `pattern`. In a pattern, "*" matches any characters or none, "?" matches one, "[1-4]"
/// matches one of a class, and "[!1-4]" matches one outside the class. A class must be closed and not empty.
[[nodiscard]] bool matches(std::string_view pattern, std::string_view text);
/// Returns a short text that matches `pattern`.
[[nodiscard]] std::string make_example(std::string_view pattern);

/// Identity of a unit, the properties that were compared with the map, and those that could not be compared.
struct IdentityFound {
  /// Make, model, and the values of identifying registers. The text is always equal for the same unit with the same
  /// settings.
  std::string who;
  std::vector<std::string> verified, not_verified;
};

/// Compares the number read from a fingerprint's register with the expected one. Fails with mismatch.
[[nodiscard]] Result<void> check_fingerprint(const RegisterMap& map, const Fingerprint& print, double found);

/// Reads and writes the items of one unit. Not thread-safe.
class ItemExchange {
 public:
  /// The arguments must outlive this object.
  ItemExchange(const RegisterMap& map, Registers& registers, Pauses& pauses);

  /// Accepts the unit on the present connection as the one to which values are written. After a connection broke,
  /// another unit may answer. Therefore, if the unit was identified before, the next write first identifies it again
  /// and fails with disconnected unless the identity is unchanged. write_persistently() is less strict: it also writes
  /// to a unit that was identified within the last two seconds, or that does not answer.
  void accept_unit() { accepted_breaks_ = registers_.breaks(); }

  [[nodiscard]] const RegisterItem& item(std::string_view name) const;

  /// Reads the map's fingerprint, registers such as the serial number, and the settings that the map compares. If the
  /// map has no fingerprint, reads the item `instead`. Fails with mismatch if a value differs, or as read() does. A
  /// setting or number that the unit does not have is listed as not verified.
  [[nodiscard]] Result<IdentityFound> identify(const RegisterItem& instead);
  /// Identifies as identify() does, without the settings.
  [[nodiscard]] Result<IdentityFound> recognise(const RegisterItem& instead);

  /// Returns the items for decimals and units that `items` depend on.
  [[nodiscard]] std::vector<const RegisterItem*> find_context_items(std::span<const RegisterItem* const> items) const;
  /// Keeps a snapshot for 1.5 s. Units and decimals in the snapshot are not read again in this time.
  void keep_snapshot(const Snapshot& found);
  /// Stores the units and decimals in the snapshot as the latest known values.
  void cache_latest_settings(const Snapshot& found);
  [[nodiscard]] const ControllerSettings& latest_settings() const { return latest_settings_; }
  /// Sets the latest units and decimals to values that another program has read.
  void set_latest_settings(const ControllerSettings& settings) { latest_settings_ = settings; }
  /// Makes later calls use the latest known value of a unit or number of decimals that cannot be read, because one
  /// unreadable register must not prevent a hot chamber from being made safe.
  void fall_back() { falls_back_ = true; }
  /// Returns whether a span that cannot be read can be skipped, because it contains only units and decimals with a
  /// known latest value.
  [[nodiscard]] bool can_skip(const ReadSpan& span) const;

  /// Reads the spans. Fails at the first span that cannot be read.
  [[nodiscard]] Result<Snapshot> read_spans(std::span<const ReadSpan> spans);
  /// Returns the value of an item from a snapshot that contains it and its context.
  [[nodiscard]] Result<double> value_in(const Snapshot& snapshot, const RegisterItem& item) const;

  /// Reads a number together with its context. Fails as Registers::read() and decode() do.
  [[nodiscard]] Result<double> read(const RegisterItem& item);
  /// Returns the item with the controller's present scale and unit. Reads these if necessary. Fails as read() does.
  [[nodiscard]] Result<RegisterItem> resolve_context(const RegisterItem& item);
  [[nodiscard]] Result<std::string> read_text(const RegisterItem& item);
  [[nodiscard]] Result<CivilTime> read_date(const RegisterItem& item);

  /// Writes `value` to the item and to its `also` and `companion` items, then waits until the register named by the map
  /// shows the value. Fails with out_of_range, without writing, if the register cannot hold the value, and with
  /// mismatch if another value is read back.
  [[nodiscard]] Result<void> write(const RegisterItem& item, double value) { return write(item, value, 1); }
  /// Writes as write() does, but for a bad line: repeats an unacknowledged write immediately, because writing the same
  /// value twice does no harm, and succeeds without an acknowledgement if the value is read back.
  [[nodiscard]] Result<void> write_persistently(const RegisterItem& item, double value) {
    return write(item, value, 3);
  }
  /// Writes `value` to the item and to its `also` and `companion` items without a reply (Registers::write_unconfirmed),
  /// in the latest known unit and decimals. Fails with refused if these are unknown, and with disconnected if another
  /// unit answered the last query of the identity. Nothing is sent in both cases.
  [[nodiscard]] Result<void> write_unconfirmed(const RegisterItem& item, double value);
  [[nodiscard]] Result<void> write_date(const RegisterItem& item, const CivilTime& time);
  /// Writes the words unchanged.
  [[nodiscard]] Result<void> write_words(const RegisterItem& item, std::span<const std::uint16_t> words);

  /// Program and step numbers for a command.
  struct Parameters {
    int program = 0, step = 0;
  };
  /// Executes a command that starts or changes something. Fails at the first step that fails, or with timeout if the
  /// condition of a wait is not met in time.
  [[nodiscard]] Result<void> perform(const Sequence& sequence, const Parameters& parameters);
  /// Executes a command that ends something: tries every step, even after a step that failed, because each step makes
  /// the unit safer. Fails with the first failure.
  [[nodiscard]] Result<void> perform_every_step(const Sequence& sequence);
  /// Executes the writes of a command by write_unconfirmed(), and its pauses. Omits steps with a condition, because
  /// nothing can be read. Returns the first failure after all steps.
  [[nodiscard]] Result<void> perform_unconfirmed(const Sequence& sequence);

 private:
  /// Fails with out_of_range if the unit answered without a value for the item.
  [[nodiscard]] Result<double> decode_answer(const RegisterItem& item, std::span<const std::uint16_t> words) const;

  /// Value of an item as text, and as a number unless it is a text.
  struct Shown {
    std::string words;
    std::optional<double> value;
  };
  [[nodiscard]] Result<Shown> read_shown(const RegisterItem& item);
  [[nodiscard]] Result<void> check(const Fingerprint& print, const Shown& shown) const;
  [[nodiscard]] Result<void> check(const VerifiedSetting& setting, const Shown& shown) const;
  [[nodiscard]] Result<void> add_property(const std::string& name, const VerifiedSetting* setting,
                                          IdentityFound& found);

  enum class UnitCheck { same, another, unanswered };
  /// Identifies the unit again if the connection broke since it was accepted.
  [[nodiscard]] UnitCheck check_unit();
  [[nodiscard]] Result<void> write_safe_words(const RegisterItem& item, std::span<const std::uint16_t> words);
  [[nodiscard]] tl::unexpected<Fault> not_sent_fault(const RegisterItem& item) const;
  [[nodiscard]] Result<void> write(const RegisterItem& item, double value, int tries);
  [[nodiscard]] Result<void> write_words(const RegisterItem& item, std::span<const std::uint16_t> words, int tries);
  [[nodiscard]] bool is_known(const RegisterItem& item) const;
  [[nodiscard]] Result<double> value_or_latest(const RegisterItem& item, Result<double> value) const;
  [[nodiscard]] Result<double> context_value(const RegisterItem& item);
  [[nodiscard]] Result<double> read_in_known_context(const RegisterItem& item);
  [[nodiscard]] Result<std::vector<std::uint16_t>> read_words(const RegisterItem& item);
  [[nodiscard]] Result<std::vector<std::uint16_t>> encode_value(const RegisterItem& item, double value);
  [[nodiscard]] Result<void> wait_until_seen(const RegisterItem& written, double value);
  [[nodiscard]] Result<void> wait_until(const Condition& condition, Duration within);
  [[nodiscard]] Result<void> write_step(const SequenceStep& step, const Parameters& parameters);
  [[nodiscard]] Result<void> perform_step(const SequenceStep& step, const Parameters& parameters);

  const RegisterMap& map_;
  Registers& registers_;
  Pauses& pauses_;
  Snapshot known_;
  Duration known_since_{};
  /// Value of breaks() when the unit's identity was last accepted. If breaks() has changed since, the identity is
  /// checked again.
  std::uint64_t accepted_breaks_ = 0;
  Duration recognised_at_{};
  /// Latest identity; empty if the unit was never identified.
  std::string recognised_;
  /// Item that was read if the map has no fingerprint.
  const RegisterItem* recognised_item_ = nullptr;
  /// Items for the units and decimals of all items.
  std::vector<const RegisterItem*> contexts_;
  ControllerSettings latest_settings_;
  bool falls_back_ = false;
  /// Another unit answered the last query of the identity that was answered.
  bool another_answers_ = false;
};

}  // namespace gyrotherm::drivers
