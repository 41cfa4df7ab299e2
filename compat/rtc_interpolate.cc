// rtcore_geometry.h: interpolation.
#include <embree3/rtcore.h>

#include "boundary.h"
#include "device.h"
#include "geometry.h"
#include "interpolate.h"

using namespace dacrt::compat;

RTC_API void rtcInterpolate(const RTCInterpolateArguments* args) {
  Guarded(__func__, nullptr, [&] { CheckPointer(args, "args"); });
  if (!args) return;
  OnObject(__func__, args->geometry, "args->geometry", [&](Geometry& geometry) {
    Interpolate(geometry, args->primID, args->u, args->v, args->bufferType, args->bufferSlot,
                args->valueCount, 1,
                {args->P, args->dPdu, args->dPdv, args->ddPdudu, args->ddPdvdv, args->ddPdudv});
  });
}

RTC_API void rtcInterpolateN(const RTCInterpolateNArguments* args) {
  Guarded(__func__, nullptr, [&] { CheckPointer(args, "args"); });
  if (!args) return;
  OnObject(__func__, args->geometry, "args->geometry", [&](Geometry& geometry) {
    const auto* const valid = static_cast<const int*>(args->valid);
    for (unsigned int i = 0; i < args->N; ++i) {
      if (valid && !valid[i]) continue;
      // Value j of point i stands at [j * N + i].
      const auto at = [i](float* values) { return values ? values + i : nullptr; };
      Interpolate(geometry, args->primIDs[i], args->u[i], args->v[i], args->bufferType,
                  args->bufferSlot, args->valueCount, args->N,
                  {at(args->P), at(args->dPdu), at(args->dPdv), at(args->ddPdudu),
                   at(args->ddPdvdv), at(args->ddPdudv)});
    }
  });
}
