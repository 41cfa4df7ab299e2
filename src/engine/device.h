// What the calls of a device share.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "dacrt/dacrt.h"
#include "engine/call_plan.h"
#include "engine/kernels.h"
#include "engine/prepared_scenes.h"
#include "runtime/spare_pages.h"
#include "runtime/tasks.h"
#include "runtime/workspace.h"

namespace dacrt {

// Hidden, although the class that it is in is exported.
class __attribute__((visibility("hidden"))) Device::Implementation {
 public:
  Implementation(const Settings& settings, MemoryMonitor monitor);

  /// Whether scenes keep their partitions, and in how many bytes, with leaves that are prepared if
  /// the scene is small, or without.
  bool Keeps() const;
  std::size_t BudgetBytes(const GeometryTable& geometries, Keep keep, bool prepares) const;

  /// What splitting a scene of that many triangles takes besides the workspaces.
  std::size_t GridBytes(std::size_t triangles) const;

  /// What a call needs on each thread, and on all of them, one of which gets what is reserved when
  /// a scene is made.
  WorkspaceShape Shape(const CallPlan& plan, std::size_t triangles, const SceneTraits& scene) const;
  std::size_t PlanBytes(const CallPlan& plan, std::size_t triangles,
                        const SceneTraits& scene) const;

  /// See Device::WorkspaceBytes.
  std::size_t CallBytes(std::size_t triangles, std::size_t rays) const;

  /// A call that is being worked on, as long as this lives. Calls that run at once share the
  /// threads: programs that call from many threads have work for all of them already.
  class RunningCall {
   public:
    explicit RunningCall(Implementation& device) : device_(device), calls_(++device.calls_) {}
    ~RunningCall() { --device_.calls_; }
    RunningCall(const RunningCall&) = delete;
    RunningCall& operator=(const RunningCall&) = delete;

    std::size_t threads() const {
      return std::max<std::size_t>(device_.tasks.threads() / calls_, 1);
    }

   private:
    Implementation& device_;
    const std::size_t calls_;
  };

  Settings settings;
  InstructionSet instruction_set;
  const Kernels kernels;
  MemoryAccount memory;
  SparePages spare_pages;  ///< of partitions that have gone
  WorkspacePool workspaces;
  TaskPool tasks;
  PreparedScenes prepared_scenes;

 private:
  std::atomic<std::size_t> calls_{0};
};

}  // namespace dacrt
