// A function that is called for each thread at its end.
#pragma once

#include <pthread.h>

namespace dacrt {

/// For one object of the whole program: so many as a process has keys, a thousand or so. Not by a
/// destructor of what is of the thread: to be told of one the C library may ask for memory, and
/// ends the program where there is none; and a library whose threads are to call destructors stays
/// in memory when it is closed.
class AtThreadEnd {
 public:
  explicit AtThreadEnd(void (*function)(void* of_thread))
      : has_key_(pthread_key_create(&key_, function) == 0) {}
  ~AtThreadEnd() {
    if (has_key_) pthread_key_delete(key_);
  }
  AtThreadEnd(const AtThreadEnd&) = delete;
  AtThreadEnd& operator=(const AtThreadEnd&) = delete;

  /// The function is called with `of_thread` when the calling thread ends, other than with the
  /// program; not where there is no room to note that.
  void Call(void* of_thread) const {
    if (has_key_) pthread_setspecific(key_, of_thread);
  }

 private:
  pthread_key_t key_;
  bool has_key_;
};

}  // namespace dacrt
