/// The gyro as the virtual laboratory needs it: a body in the chamber's air, with true temperatures and a true bias.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "core/quantity.hpp"

namespace gyrotherm {

inline constexpr std::size_t kBlockPlaces = 8;    ///< A…H, on the block
inline constexpr std::size_t kThermalPlaces = 9;  ///< and "shell": the cabinet's, or the air in it

/// The names of the places, in their order everywhere in this room.
inline constexpr std::array<std::string_view, kThermalPlaces> kPlaceNames{"A", "B", "C", "D",    "E",
                                                                          "F", "G", "H", "shell"};

using BlockTemperatures = std::span<const double, kBlockPlaces>;    ///< °C
using PlaceTemperatures = std::span<const double, kThermalPlaces>;  ///< °C

class VirtualGyro {
 public:
  virtual ~VirtualGyro() = default;
  /// Lets one second pass with the chamber's air at `air`.
  virtual void step(Celsius air) = 0;
  /// True temperatures at the places now: what the thermometers are at.
  [[nodiscard]] virtual PlaceTemperatures places_c() const = 0;
  /// What its temperatures, now and before, make of its bias; without noise, turn-on and rotation.
  [[nodiscard]] virtual DegreesPerHour bias() const = 0;
};

}  // namespace gyrotherm
