/// The register map of a Modbus chamber: a TOML file under profiles/chambers, used by the driver and, from the other
/// end of the wire, by the virtual chamber.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm {

enum class RegisterType { u16, s16, u32, s32, f32 };
enum class WordOrder { abcd, cdab, badc, dcba };  ///< −40.25 is C221 0000 in abcd and 0000 C221 in cdab

struct RegisterItem {
  std::string name;  ///< "air_temperature", "set_point", "control_mode", …
  std::uint16_t address{};
  RegisterType type{};
  WordOrder order = WordOrder::abcd;
  double scale = 1;       ///< value = raw × scale
  double resolution = 1;  ///< the finest step that the controller keeps; by default the scale, 0.001 for f32
  bool writable{};
  std::map<std::string, std::int64_t> codes;  ///< names of an enumeration's values: "auto" = 10
  std::string confidence;                     ///< "verified", "manual", "secondary", "unverified"
};

/// What a register holds if the instrument is the one that the map describes.
struct Fingerprint {
  std::string item;
  double value{};
};

/// How conditioning is commanded: a code written to one item, and seen to take effect in another (or the same).
struct ControlMode {
  std::string commanded;
  std::string active;
  std::int64_t on{};
  std::int64_t off{};
};

struct RegisterMap {
  std::string name;
  std::string vendor;
  std::string source;
  std::uint8_t unit = 1;
  std::uint16_t port = 502;
  Duration timeout{};  ///< of one exchange
  std::uint16_t read_at_most = 125;
  bool one_block{};  ///< air_temperature, set_point and the fingerprint may be read as one block, holes included
  std::vector<RegisterItem> items;
  std::optional<Fingerprint> identity;
  std::optional<ControlMode> control;  ///< absent: the chamber conditions whenever it is powered
  std::string text;                    ///< the file, as read

  [[nodiscard]] const RegisterItem* find(std::string_view item) const;
};

/// Fails with bad_file, every mistake with its place. Required items: air_temperature, set_point (writable). Items that
/// identity and control name exist, and have the codes asked for.
/// `word_order`: the user's override for a unit that was set up differently.
[[nodiscard]] Result<RegisterMap> parse_register_map(std::string_view text, const std::string& file,
                                                     std::optional<WordOrder> word_order = {});

/// Words of one item, as on the wire; 1 or 2 of them. `value` must be finite. Rounds to the nearest that the type can
/// hold, and saturates at its range.
[[nodiscard]] std::vector<std::uint16_t> encode(const RegisterItem& item, double value);
/// `words` must hold the item's count. Fails with corrupted (not finite).
[[nodiscard]] Result<double> decode(const RegisterItem& item, std::span<const std::uint16_t> words);
[[nodiscard]] std::uint16_t word_count(RegisterType type);

}  // namespace gyrotherm
