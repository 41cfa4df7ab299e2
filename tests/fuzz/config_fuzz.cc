// Any text for a configuration: a device, or an error and none.
#include <embree3/rtcore.h>

#include <cstdint>
#include <cstdlib>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, std::size_t count) {
  const std::string text(reinterpret_cast<const char*>(bytes), count);
  // Ranks are found by libdacrt_mpi.so, and threads made by oneTBB: neither is what is tested here.
  if (text.find("mpi") != std::string::npos) return 0;
  const RTCDevice device = rtcNewDevice((text + " threads=1").c_str());
  const RTCError error = rtcGetDeviceError(device);
  if ((device == nullptr) != (error != RTC_ERROR_NONE)) std::abort();
  if (device) rtcReleaseDevice(device);
  return 0;
}
