#include "embree_api.h"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>

namespace dacrt::tests {
namespace {

/// `function` in `library`, which was opened from `path`.
void* FindFunction(void* library, const std::string& path, const char* function) {
  void* const address = dlsym(library, function);
  if (!address) throw std::runtime_error(path + " does not export " + function);
  // Proof that it is this library's own and not one of the other library with the same SONAME.
  Dl_info found{};
  if (!dladdr(address, &found) || !std::filesystem::equivalent(found.dli_fname, path)) {
    throw std::runtime_error(std::string(function) + " was looked up in " + path +
                             " and found in " + (found.dli_fname ? found.dli_fname : "?"));
  }
  return address;
}

}  // namespace

EmbreeApi LoadEmbree(const std::string& path) {
  if (path.find('/') == std::string::npos) {
    throw std::runtime_error("a path with a slash is needed, not " + path);
  }
  // RTLD_LOCAL keeps either library's names out of the other's look-ups.
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) throw std::runtime_error(dlerror());

  EmbreeApi api;
  api.path = path;
#define DACRT_TESTS_FIND(name) \
  api.name = reinterpret_cast<decltype(&::name)>(FindFunction(library, path, #name));
  DACRT_TESTS_EMBREE_FUNCTIONS(DACRT_TESTS_FIND)
#undef DACRT_TESTS_FIND
  return api;
}

}  // namespace dacrt::tests
