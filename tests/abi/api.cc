#include "api.h"

#include <dlfcn.h>

#include <stdexcept>

namespace dacrt::tests {
namespace {

void* FindFunction(void* library, const char* function) {
  void* const address = dlsym(library, function);
  if (!address) throw std::runtime_error(dlerror());
  return address;
}

Api Load(const char* name, const char* path) {
  // RTLD_LOCAL keeps each library's names out of the other's look-ups.
  void* const library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (!library) throw std::runtime_error(dlerror());
  Api api;
  api.name = name;
#define X(name) api.name = reinterpret_cast<decltype(&::name)>(FindFunction(library, #name));
#include "exports.inc"
#undef X
  return api;
}

}  // namespace

const Api& RealEmbree() {
  static const Api api = Load("embree", DACRT_REAL_EMBREE);
  return api;
}

const Api& DropIn() {
  static const Api api = Load("dacrt", DACRT_DROP_IN);
  return api;
}

}  // namespace dacrt::tests
