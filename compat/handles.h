// The handles that programs hold: which of them are alive, and how often each was retained.
#pragma once

#include <embree3/rtcore.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <new>
#include <type_traits>
#include <utility>

#include "pointer_map.h"

namespace dacrt::compat {

class Buffer;
class Device;
class Geometry;
class Scene;

/// A handle is the address of its object, as the API's opaque type.
inline Device* ToObject(RTCDevice handle) { return reinterpret_cast<Device*>(handle); }
inline Buffer* ToObject(RTCBuffer handle) { return reinterpret_cast<Buffer*>(handle); }
inline Geometry* ToObject(RTCGeometry handle) { return reinterpret_cast<Geometry*>(handle); }
inline Scene* ToObject(RTCScene handle) { return reinterpret_cast<Scene*>(handle); }
inline RTCDevice ToHandle(Device* object) { return reinterpret_cast<RTCDevice>(object); }
inline RTCBuffer ToHandle(Buffer* object) { return reinterpret_cast<RTCBuffer>(object); }
inline RTCGeometry ToHandle(Geometry* object) { return reinterpret_cast<RTCGeometry>(object); }
inline RTCScene ToHandle(Scene* object) { return reinterpret_cast<RTCScene>(object); }

template <class Handle>
using ObjectOf = std::remove_pointer_t<decltype(ToObject(std::declval<Handle>()))>;

/// The objects of one type, which derives from std::enable_shared_from_this, that programs have
/// handles of.
///
/// A handle is valid while anything keeps its object alive: references that the program holds,
/// which are counted here, or another object (a scene its geometries, everything its device). So
/// a program may release a geometry once it is attached and go on using the handle.
///
/// Threads: any number at once.
template <class Object>
class HandleTable {
 public:
  static HandleTable& Instance() {
    // Never destroyed: static objects of the program may release handles when it ends. Nor
    // allocated: the first to ask may be an object that ends.
    alignas(HandleTable) static std::byte place[sizeof(HandleTable)];
    static HandleTable* const table = new (place) HandleTable;
    return *table;
  }

  /// Makes `object`'s address a handle of which the program holds one reference.
  Object* Add(std::shared_ptr<Object> object) {
    Object* const handle = object.get();
    const std::lock_guard lock(mutex_);
    // Where there is no memory for the entry, `object` still holds the object, and ends it after
    // the lock: destructors call Forget.
    entries_.Add(handle, {object, object, 1});
    return handle;
  }

  /// Null if `handle` is not alive. Never looks at what it points to.
  std::shared_ptr<Object> Find(const Object* handle) const {
    const std::lock_guard lock(mutex_);
    const Entry* const entry = entries_.Find(handle);
    return entry ? entry->object.lock() : nullptr;
  }

  /// One more reference of the program to `object`, which is alive.
  void Retain(std::shared_ptr<Object> object) {
    const std::lock_guard lock(mutex_);
    Entry& entry = *entries_.Find(object.get());
    if (entry.references++ == 0) entry.held = std::move(object);
  }

  /// One reference less. False if the program holds none, which changes nothing.
  bool Release(const Object* object) {
    std::shared_ptr<Object> last;  // Destroyed after the lock: destructors call Forget.
    const std::lock_guard lock(mutex_);
    Entry& entry = *entries_.Find(object);
    if (entry.references == 0) return false;
    if (--entry.references == 0) last = std::move(entry.held);
    return true;
  }

  /// Called by the object's destructor.
  void Forget(const Object* handle) {
    const std::lock_guard lock(mutex_);
    entries_.Remove(handle);
  }

 private:
  struct Entry {
    std::weak_ptr<Object> object;
    std::shared_ptr<Object> held;  ///< set while references > 0
    std::size_t references = 0;    ///< that the program holds
  };

  mutable std::mutex mutex_;
  PointerMap<Entry> entries_;
};

}  // namespace dacrt::compat
