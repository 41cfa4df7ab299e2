#include "libraries.h"

#include <dlfcn.h>
#include <link.h>

#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace dacrt::compare {
namespace {

namespace fs = std::filesystem;

std::string FindBeside(const std::string& name) {
  const fs::path here = fs::path(OwnPath()).parent_path();
  for (const fs::path& folder : {here, here / DACRT_LIBRARY_DIR}) {
    std::error_code error;
    if (fs::exists(folder / name, error)) return fs::canonical(folder / name).string();
  }
  throw std::runtime_error("there is no " + name + " in " + here.string() + " or " +
                           (here / DACRT_LIBRARY_DIR).lexically_normal().string());
}

}  // namespace

std::string OwnPath() { return fs::read_symlink("/proc/self/exe").string(); }

std::string FindDropIn() { return FindBeside("libembree3.so.3"); }

std::string FindCounter() { return FindBeside("libdacrt_count.so"); }

std::string FindEmbree(const std::string& drop_in) {
  void* const library = dlopen("libembree3.so.3", RTLD_LAZY | RTLD_LOCAL);
  if (!library) {
    throw std::runtime_error(
        "there is no Embree to compare with: the system finds no "
        "libembree3.so.3; name one with --embree");
  }
  const link_map* map = nullptr;
  if (dlinfo(library, RTLD_DI_LINKMAP, &map) != 0) throw std::runtime_error(dlerror());
  if (IsSameFile(map->l_name, drop_in)) {
    throw std::runtime_error(std::string(map->l_name) +
                             ", which the system finds as libembree3.so.3, is dacrt's own; name "
                             "Embree's with --embree");
  }
  return fs::canonical(map->l_name).string();
}

bool IsSameFile(const std::string& a, const std::string& b) {
  std::error_code error;
  return fs::equivalent(a, b, error) && !error;
}

}  // namespace dacrt::compare
