// The string that rtcNewDevice takes.
#pragma once

#include <optional>
#include <string_view>

#include "dacrt/mpi.h"
#include "dacrt/settings.h"

namespace dacrt::compat {

struct Config {
  dacrt::Settings settings;
  /// What `isa` asks for, and `max_isa` leaves of it.
  InstructionSet isa = InstructionSet::kBest;
  bool ignore_masks = false;  ///< rays hit geometries whatever the masks say
  int verbose = 0;            ///< 1 and more: a line on the standard output for a new device

  /// How the device works together with other processes, if it does.
  std::optional<mpi::Mode> mpi_mode;
  mpi::Options mpi_options;
  uint32_t mpi_geometry_ids = 0;  ///< rtcAttachGeometry gives rank r IDs from r times this on
};

/// Applies `text` to `config`.
///
/// The grammar is Embree's, observed: assignments `key = value`, in order, separated by any
/// character that neither a key nor a value can contain. Unknown keys are passed over, and so is a
/// known one without "=". Values of Embree's keys have a type; one of another type is
/// RTC_ERROR_UNKNOWN, as in Embree. Most of these keys steer what dacrt does not have and change
/// nothing; `isa` and `max_isa` limit the instruction set, `isa` to one that the processor has to
/// have, as `dacrt_instruction_set` does not.
///
/// Keys that begin with `dacrt_` are dacrt's own, and Embree passes them over:
///   dacrt_ignore_masks=1  for programs that leave the rays' masks unset
///   dacrt_mpi=MODE        replicate, divide or none; see dacrt/mpi.h
///   dacrt_mpi_timeout=SECONDS, dacrt_mpi_least_rays=N, dacrt_mpi_piece_rays=N   mpi::Options
///   dacrt_mpi_geometry_ids=N  see Config
///   dacrt_NAME=VALUE      SetByName(settings, NAME, VALUE)
/// Unknown ones and illegal values are RTC_ERROR_INVALID_ARGUMENT.
void ApplyConfig(Config& config, std::string_view text);

/// The configuration of a new device: the environment variable DACRT_CONFIG, then `text`, which
/// may be null and wins where both speak. RTC_ERROR_UNSUPPORTED_CPU, as in Embree, where `isa`
/// names what the processor does not have.
Config ReadConfig(const char* text);

}  // namespace dacrt::compat
