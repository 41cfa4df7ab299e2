// Under mpirun beside a faulty_rank: calls return in time, with an error through Embree's channel,
// and records that are complete (replicate) or untouched (divide); later calls do, too.
//
// usage: fault_test MODE FAULT
#include <dlfcn.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "bits.h"
#include "contest.h"

namespace dacrt::tests {
namespace {

/// The rank that hangs is given up after this time.
constexpr int kTimeout = 2;

bool failed = false;

void Expect(bool holds, const std::string& what) {
  if (holds) return;
  std::printf("FAILED: %s\n", what.c_str());
  failed = true;
}

std::string last_message;

void NoteError(void*, RTCError, const char* message) { last_message = message; }

/// The table of functions does not have this one.
void SetErrorFunction(const EmbreeDevice& device) {
  void* const library = dlopen(device.api().path.c_str(), RTLD_NOW | RTLD_NOLOAD);
  const auto set = reinterpret_cast<decltype(&rtcSetDeviceErrorFunction)>(
      dlsym(library, "rtcSetDeviceErrorFunction"));
  set(device.handle(), NoteError, nullptr);
}

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// One call, on records of which the answers are known.
void CheckCall(const EmbreeDevice& device, const EmbreeScene& scene,
               const std::vector<RTCRayHit>& before, const std::vector<RTCRayHit>& expected,
               const std::string& name, double most_seconds) {
  std::vector<RTCRayHit> records = before;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  last_message.clear();
  const auto start = std::chrono::steady_clock::now();
  scene.api().rtcIntersect1M(scene.handle(), &context, records.data(),
                             static_cast<unsigned>(records.size()), sizeof(RTCRayHit));
  const double seconds = SecondsSince(start);
  std::printf("%s: %.2f s, '%s'\n", name.c_str(), seconds, last_message.c_str());
  Expect(seconds < most_seconds, name + " takes too long");
  Expect(last_message.find("rank 1 ") != std::string::npos, name + " does not blame rank 1");
  Expect(scene.api().rtcGetDeviceError(device.handle()) == RTC_ERROR_UNKNOWN,
         name + " sets no error");
  Expect(FirstDifference(records, expected) == records.size(), name + " has half done its work");
}

int Run(const std::string& mode, const std::string& fault) {
  const EmbreeApi& api = DropIn();
  const std::string config =
      "threads=1,dacrt_mpi_least_rays=1,dacrt_mpi_piece_rays=500,"
      "dacrt_mpi_timeout=" +
      std::to_string(kTimeout) + ",dacrt_mpi=" + mode;
  const auto start = std::chrono::steady_clock::now();
  if (fault == "orphan") {
    api.rtcNewDevice(config.c_str());
    raise(SIGKILL);
  }
  if (fault == "version" || fault == "byte_order") {
    Expect(!api.rtcNewDevice(config.c_str()), "a rank of another kind is accepted");
    Expect(api.rtcGetDeviceError(nullptr) == RTC_ERROR_UNKNOWN, "there is no error");
    Expect(!api.rtcNewDevice(config.c_str()), "a second device is made");
    Expect(SecondsSince(start) < kTimeout + 1, "the refusal takes too long");
    return failed;
  }

  const TestScene scene = MakeScene("soup");
  const EmbreeDevice one(api, "threads=1,dacrt_mpi=none");
  const EmbreeScene one_scene(one, scene);
  const RayGenerator generator(scene, one_scene);
  const std::vector<RTCRayHit> rays = MixedRays(generator, 1000, 1);
  const bool completes = mode == "replicate";
  const std::vector<RTCRayHit> expected =
      completes ? Trace(one_scene, {Form::Call::kRecords}, Query::kClosest, rays) : rays;

  const EmbreeDevice several(api, config);
  SetErrorFunction(several);
  const EmbreeScene several_scene(several, scene);
  CheckCall(several, several_scene, rays, expected, "the call", kTimeout + 2);
  Expect(fault != "stranger" || last_message.find("a ray of rank 1000") != std::string::npos,
         "a ray of a rank that there is not is taken");
  CheckCall(several, several_scene, rays, expected, "the next call", 1);
  if (!completes) sleep(1);  // the other rank may still be looking
  return failed;
}

}  // namespace
}  // namespace dacrt::tests

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const int code = dacrt::tests::Run(argv[1], argv[2]);
  if (code == 0) std::printf("fault_test: all is well\n");
  return code;
}
