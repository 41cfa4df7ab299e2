#include "memory_child.h"

#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "geometry_kind.h"

namespace dacrt::bench {
namespace {

// A file in memory. What fails shows when it is read.
class MemoryFile {
 public:
  MemoryFile() : file_(fdopen(memfd_create("dacrt_bench", MFD_CLOEXEC), "w+b"), std::fclose) {
    if (!file_) throw std::runtime_error("there is no memory for a file");
  }

  std::FILE* get() { return file_.get(); }
  int Descriptor() { return fileno(file_.get()); }

 private:
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

template <class Item>
void Write(const Item* items, std::size_t count, std::FILE* file) {
  std::fwrite(&count, sizeof(count), 1, file);
  std::fwrite(items, sizeof(Item), count, file);
}

template <class Item>
void ReadItems(Item* items, std::size_t count, std::FILE* file) {
  if (std::fread(items, sizeof(Item), count, file) != count) {
    throw std::runtime_error("the other process has not written all that it should");
  }
}

std::size_t ReadCount(std::FILE* file) {
  std::size_t count;
  ReadItems(&count, 1, file);
  return count;
}

template <class Item>
std::vector<Item> ReadVector(std::FILE* file) {
  std::vector<Item> items(ReadCount(file));
  ReadItems(items.data(), items.size(), file);
  return items;
}

RayBuffer ReadRays(std::FILE* file) {
  const std::size_t count = ReadCount(file);
  RayBuffer rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    RayRecord ray;
    ReadItems(&ray, 1, file);
    if (i == 0) rays.Begin(ray.tfar);
    rays.Append(ray.org, ray.dir, ray.id);
  }
  return rays;
}

// Runs the child with its standard input and output in these files.
void RunChild(std::vector<std::string> command, MemoryFile& input, MemoryFile& output) {
  std::fflush(input.get());
  std::rewind(input.get());
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, input.Descriptor(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, output.Descriptor(), STDOUT_FILENO);
  std::vector<char*> argv;
  for (std::string& word : command) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t child;
  const int error = posix_spawn(&child, argv[0], &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  int status = 0;
  if (error || waitpid(child, &status, 0) < 0 || status != 0) {
    throw std::runtime_error("measuring memory failed: " + command.front());
  }
  std::rewind(output.get());
}

}  // namespace

MemoryUse MeasureMemoryInChild(const std::string& path, const std::string& config,
                               const BenchScene& scene, const std::string& geometry,
                               RayBuffer& rays, std::vector<std::string> child) {
  rays.Rearm();
  MemoryFile input, output;
  const scenes::Mesh& mesh = scene.mesh;
  Write(mesh.positions.data(), mesh.positions.size(), input.get());
  Write(mesh.indices.data(), mesh.indices.size(), input.get());
  Write(rays.rays().data(), rays.rays().size(), input.get());
  child.insert(child.end(), {path, config, geometry});
  RunChild(std::move(child), input, output);
  MemoryUse use;
  ReadItems(&use, 1, output.get());
  return use;
}

void AnswerMemory(const std::string& path, const std::string& config, const std::string& geometry) {
  BenchScene scene{};
  scene.mesh.positions = ReadVector<float>(stdin);
  scene.mesh.indices = ReadVector<uint32_t>(stdin);
  RayBuffer rays = ReadRays(stdin);
  const SceneContent content = FindGeometryKind(geometry)->make(scene);
  const MemoryUse use = MeasureMemory(path, config, content, rays);
  std::fwrite(&use, sizeof(use), 1, stdout);
}

}  // namespace dacrt::bench
