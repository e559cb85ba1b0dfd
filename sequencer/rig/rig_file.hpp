// SPDX-License-Identifier: Apache-2.0
/// The description of a rig: instruments, lines, calibrations and limits. One TOML file per rig.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/link_settings.hpp"
#include "drivers/supply/safety_relay.hpp"
#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/interlocks/limits.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/analogue_settings.hpp"
#include "sequencer/rig/check_standard.hpp"
#include "sequencer/rig/gyro_settings.hpp"
#include "sequencer/rig/proof_settings.hpp"
#include "sequencer/rig/supply_settings.hpp"
#include "sequencer/rig/thermometer_certificate.hpp"
#include "sequencer/rig/thermometer_settings.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::rig {

struct Limiter {
  /// Class of DIN 12880: "1", "2", "3.1" (over), "3.2" (under), "3.3" (both).
  std::string protection_class;
  /// Temperatures at which it trips; absent: no limit on that side.
  std::optional<Celsius> lowest, highest;
};

/// Describes when the limiter trips: "class 3.3, below -50 °C, above 75 °C".
[[nodiscard]] std::string describe(const Limiter& limiter);

/// The identification of the units at the start of a run, in addition to the rig file.
struct UnitIdentification {
  /// The number of the order that the units belong to; may be empty.
  std::string order_number{};
  /// The serial numbers of units without one in the rig file, by the unit's name.
  std::map<std::string, std::string> serial_numbers{};
  /// The names of the units whose positions are empty.
  std::vector<std::string> unused{};
};

struct RigFile {
  std::string name;
  std::string title;
  /// Text of the file.
  std::string text;
  /// Path of the file, as given.
  std::string file;
  /// The map, with the link for the line selected.
  drivers::RegisterMap chamber_map;
  std::string chamber_line;
  /// Power switch of the map; may be empty.
  std::string chamber_power;
  /// Replaces the map's settings.
  drivers::LinkSettings chamber_link{};
  /// Replaces the parameters of a text chamber.
  drivers::TextParameters chamber_parameters{};
  /// Replaces the map's word order for this unit.
  std::optional<drivers::WordOrder> chamber_word_order;
  profile::ChamberLimits chamber_limits;
  Celsius safe_set_point;
  std::optional<Limiter> limiter;  ///< the chamber's own
  std::vector<ThermometerSettings> thermometers;
  /// Units under test, at least one.
  std::vector<UnitSettings> units;
  std::vector<GyroLine> gyro_lines;
  std::vector<AnalogueSettings> analogue_inputs;
  std::vector<SupplySettings> supplies;
  std::optional<CheckStandard> check_standard;
  /// The safe state includes switching the chamber off.
  bool safe_off{};
  /// Time for which the watchdog watches the air of a chamber that was made safe; 0: it does not.
  Duration safe_observe = std::chrono::minutes(5);
  /// Relay that the watchdog opens if the chamber cannot be made safe; absent: there is none.
  std::optional<drivers::RelaySettings> safe_also{};
  ProofSettings proof{};
  interlocks::InterlockLimits limits;
  interlocks::RunLimits run_limits;
  /// Every line is "virtual". A rig with both virtual and real lines is an error.
  bool simulated{};
  simulator::GyroModelUsed gyro_model;  ///< virtual rig
  /// Set by identify_units(); the units contain its serial numbers too.
  UnitIdentification identification{};
};

/// Adds the warm-ups that the rig requires to a profile (sequencer/profile/warm_up.hpp). Does nothing for a virtual rig
/// without [room]. Fails with usage as add_warm_ups() does.
[[nodiscard]] Result<void> add_warm_ups(profile::Profile& profile, const RigFile& rig);

/// Return true if the chamber's humidity, or its dew point, is a channel of the rig's records.
[[nodiscard]] bool records_humidity(const RigFile& rig);
[[nodiscard]] bool records_dew_point(const RigFile& rig);

/// Texts of the files that a rig file names, if they are known already. On a resume, these are the copies in the
/// record.
struct NamedTexts {
  std::optional<std::string> chamber_map{};  ///< [chamber] map
  std::optional<std::string> gyro_model{};   ///< [virtual.thermal] gyro
  /// Keys `stream` of [gyro] or [[gyro]], by the unit's name.
  std::map<std::string, std::string> gyro_streams{};
  /// Keys `map` of [[analogue_input]], in order of the file.
  std::vector<std::string> analogue_maps{};
  /// Keys `description` of [[thermometer]], in order of the file.
  std::vector<std::string> thermometer_descriptions{};
  /// Keys `description` of [[supply]], in order of the file.
  std::vector<std::string> supply_descriptions{};
  /// Folder in which commands run; empty: the rig file's.
  std::string folder{};
  /// Channels of the record on a resume. Their calibrations replace those of the certificate files.
  std::optional<std::vector<record::Channel>> channels{};
};

/// Parses a rig file. Reads files that `known` does not contain, relative to `file`. Fails with bad_file and lists
/// every error with its position. parse_laboratory checks the remaining keys of [virtual]. `certificates` reads the
/// certificate files of thermometers.
[[nodiscard]] Result<RigFile> parse_rig(std::string_view text, const std::string& file, const NamedTexts& known = {},
                                        const CertificateReader& certificates = {});
/// Reads and parses a rig file, or the shipped rig of that name.
[[nodiscard]] Result<RigFile> read_rig(const std::string& given, const CertificateReader& certificates = {});

/// Returns the texts of the maps of all analogue inputs, in order of the file.
[[nodiscard]] std::vector<std::string> collect_analogue_map_texts(const RigFile& rig);

/// Returns the texts of the descriptions of all thermometers that have one, in order of the file.
[[nodiscard]] std::vector<std::string> collect_thermometer_texts(const RigFile& rig);

/// Returns the texts of the descriptions of all supplies, in order of the file.
[[nodiscard]] std::vector<std::string> collect_supply_texts(const RigFile& rig);

/// Returns all channels of all thermometers, in order of the file, each with the unit under test that it belongs to. A
/// channel that several units share, or none uses, belongs to the rig.
[[nodiscard]] std::vector<record::Channel> list_channels(const RigFile& rig);

/// Describes a limiter that trips before the interlock on the air acts, with the keys to change; empty if the interlock
/// acts first or the rig file describes no limiter.
[[nodiscard]] std::string describe_limiter_that_trips_first(const RigFile& rig);

/// Returns the line on which the unit numbered `unit` is read.
[[nodiscard]] const GyroLine& find_gyro_line(const RigFile& rig, std::size_t unit);

}  // namespace gyrotherm::rig
