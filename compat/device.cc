#include "device.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <string>
#include <utility>

#include "boundary.h"
#include "ranks.h"

namespace dacrt::compat {
namespace {

/// The errors that a thread has not read yet, by device. They stand in the thread's own memory,
/// because that there is no other may be the error. A thread that leaves errors unread in more
/// devices than there are places loses the oldest.
class UnreadErrors {
 public:
  /// An earlier error stays.
  void Add(uint64_t device, RTCError code) {
    if (Find(device)) return;
    Error* const free = Find(0);
    Error* const place = free ? free : &errors_.back();
    std::copy_backward(errors_.data(), place, place + 1);
    errors_[0] = {device, code};
  }

  RTCError Take(uint64_t device) {
    Error* const error = Find(device);
    return error ? std::exchange(*error, {}).code : RTC_ERROR_NONE;
  }

 private:
  struct Error {
    uint64_t device = 0;  ///< 0: none
    RTCError code = RTC_ERROR_NONE;
  };

  Error* Find(uint64_t device) {
    const auto place = std::find_if(errors_.begin(), errors_.end(),
                                    [&](const Error& error) { return error.device == device; });
    return place == errors_.end() ? nullptr : &*place;
  }

  std::array<Error, 16> errors_{};  ///< latest first
};

thread_local UnreadErrors unread_errors;

uint64_t NextNumber() {
  static std::atomic<uint64_t> last{0};
  return ++last;
}

}  // namespace

Device::Device(const Config& config)
    : ignore_masks_(config.ignore_masks),
      is_verbose_(config.verbose >= 1),
      is_divided_(config.mpi_mode == mpi::Mode::kDivide),
      ranks_(OpenRanks(config)),
      first_geometry_id_(ranks_ ? static_cast<uint32_t>(ranks_->rank()) * config.mpi_geometry_ids
                                : 0),
      number_(NextNumber()),
      engine_(std::make_shared<dacrt::Device>(
          config.settings, [this](std::ptrdiff_t bytes) { return Announce(bytes); })) {
  if (is_verbose_) {
    std::printf("dacrt %s in place of Embree %s, instruction set %s%s\n",
                std::string(Version()).c_str(), RTC_VERSION_STRING,
                std::string(Name(engine_->instruction_set())).c_str(),
                ignore_masks_ ? ", ray masks ignored" : "");
    std::fflush(stdout);
    if (ranks_) NoteRanks(*ranks_);
  }
}

void Device::NoteSceneStays() {
  if (!is_verbose_ || ranks_->size() == 1 || has_noted_.exchange(true)) return;
  std::fprintf(stderr, "dacrt: scenes with callbacks are traced on rank 0 alone\n");
}

Device::~Device() { HandleTable<Device>::Instance().Forget(this); }

void Device::Report(RTCError code, const char* message) {
  Callback<RTCErrorFunction> callback;
  {
    const std::lock_guard lock(mutex_);
    callback = error_callback_;
  }
  // Outside the lock: the callback may call the API.
  if (callback.function) callback.function(callback.user_pointer, code, message);
  unread_errors.Add(number_, code);
}

RTCError Device::TakeError() { return unread_errors.Take(number_); }

void Device::SetErrorFunction(RTCErrorFunction function, void* user_pointer) {
  const std::lock_guard lock(mutex_);
  error_callback_ = {function, user_pointer};
}

void Device::AnnounceAllocation(std::size_t bytes) {
  if (!Announce(static_cast<std::ptrdiff_t>(bytes))) {
    throw ApiError(RTC_ERROR_OUT_OF_MEMORY, "the memory monitor refused ", bytes, " bytes");
  }
}

void Device::AnnounceFree(std::size_t bytes) { Announce(-static_cast<std::ptrdiff_t>(bytes)); }

bool Device::Announce(std::ptrdiff_t bytes) {
  Callback<RTCMemoryMonitorFunction> monitor;
  {
    const std::lock_guard lock(mutex_);
    monitor = memory_monitor_;
  }
  return !monitor.function || monitor.function(monitor.user_pointer, bytes, bytes < 0);
}

void Device::SetMemoryMonitorFunction(RTCMemoryMonitorFunction function, void* user_pointer) {
  const std::lock_guard lock(mutex_);
  memory_monitor_ = {function, user_pointer};
}

ssize_t Device::Property(RTCDeviceProperty property) const {
  switch (property) {
    case RTC_DEVICE_PROPERTY_VERSION:
      return RTC_VERSION;
    case RTC_DEVICE_PROPERTY_VERSION_MAJOR:
      return RTC_VERSION_MAJOR;
    case RTC_DEVICE_PROPERTY_VERSION_MINOR:
      return RTC_VERSION_MINOR;
    case RTC_DEVICE_PROPERTY_VERSION_PATCH:
      return RTC_VERSION_PATCH;

#include "features.inc"  // a case for each property in features.txt
  }
  throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "prop = ", static_cast<int>(property),
                 " is no readable property");
}

}  // namespace dacrt::compat
