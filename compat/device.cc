#include "device.h"

#include <atomic>
#include <cstdio>

#include "boundary.h"
#include "ranks.h"

namespace dacrt::compat {
namespace {

/// A number of the calling thread that no later thread gets, unlike std::thread::id.
uint64_t ThreadNumber() {
  static std::atomic<uint64_t> next{0};
  thread_local const uint64_t number = next++;
  return number;
}

}  // namespace

Device::Device(const Config& config)
    : ignore_masks_(config.ignore_masks),
      is_verbose_(config.verbose >= 1),
      is_divided_(config.mpi_mode == mpi::Mode::kDivide),
      ranks_(OpenRanks(config)),
      first_geometry_id_(
          ranks_ ? static_cast<uint32_t>(ranks_->rank()) * config.mpi_geometry_ids : 0),
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

void Device::Report(RTCError code, const std::string& message) {
  Callback<RTCErrorFunction> callback;
  {
    const std::lock_guard lock(mutex_);
    callback = error_callback_;
  }
  // Outside the lock: the callback may call the API.
  if (callback.function) callback.function(callback.user_pointer, code, message.c_str());
  const std::lock_guard lock(mutex_);
  unread_errors_.try_emplace(ThreadNumber(), code);
}

RTCError Device::TakeError() {
  const std::lock_guard lock(mutex_);
  const auto unread = unread_errors_.extract(ThreadNumber());
  return unread ? unread.mapped() : RTC_ERROR_NONE;
}

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
