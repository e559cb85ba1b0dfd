/// The virtual instruments: servers on loopback that speak the real protocols over a world.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/gyro/frame_format.hpp"
#include "simulator/world.hpp"
#include "simulator/world_parameters.hpp"

namespace gyrotherm {

/// One Lake Shore 218 of the virtual rig: which of the world's thermometers are on its inputs, in order (at most 8).
struct VirtualThermometer {
  std::vector<std::string> channels;
};

struct VirtualInstrumentsOptions {
  RegisterMap chamber;
  std::vector<VirtualThermometer> thermometers;
  FrameFormat gyro;
  std::uint16_t first_port = 0;  ///< 0: any free ports; else chamber, thermometers, gyro on consecutive ones
};

/// Serves on 127.0.0.1 from a thread of its own until destroyed. All clients see one world; several clients may connect
/// to each.
class VirtualInstruments {
 public:
  /// Fails with disconnected if a port cannot be bound, or usage if a channel is not a thermometer of the world or an
  /// instrument has too many.
  [[nodiscard]] static Result<std::unique_ptr<VirtualInstruments>> start(World world,
                                                                         VirtualInstrumentsOptions options);
  virtual ~VirtualInstruments() = default;

  /// Lets `seconds` pass, one step each; the gyro sends one frame per second to whoever is connected.
  virtual void advance(int seconds) = 0;
  /// Lets one second per set point pass with the controller at it and nobody listening: how a recorded run is replayed.
  virtual void replay(std::span<const Celsius> set_points) = 0;

  /// Ports on 127.0.0.1.
  [[nodiscard]] virtual std::uint16_t chamber_port() const = 0;
  [[nodiscard]] virtual std::uint16_t thermometer_port(std::size_t index) const = 0;
  [[nodiscard]] virtual std::uint16_t gyro_port() const = 0;
};

}  // namespace gyrotherm
