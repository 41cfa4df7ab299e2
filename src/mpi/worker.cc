// Mode::kReplicate, on the ranks that work for another's program.
#include <cstring>
#include <map>
#include <vector>

#include "greeting.h"
#include "link.h"
#include "patience.h"
#include "pieces.h"
#include "scene_message.h"
#include "wire.h"

namespace dacrt::mpi {
namespace {

constexpr int kProgramRank = 0;

class Worker {
 public:
  Worker(MPI_Comm communicator, const Options& options) : link_(communicator) {
    Message hello;
    hello.Put(own_);
    link_.Send(kProgramRank, kTagGreeting, std::move(hello));
    Message verdict = WaitFor(kTagVerdict, options.timeout_seconds);
    Reader reader(verdict);
    program_ = reader.Take<Greeting>();
    const std::string refusal = reader.TakeText();
    if (!refusal.empty()) throw Fault("refused by rank 0: " + refusal);
    const std::string own_refusal = Refusal(own_, program_, Role::kProgram, kProgramRank);
    if (!own_refusal.empty()) throw Fault(own_refusal);
  }

  /// Until rank 0 tells it to stop.
  Ending Run() {
    for (bool has_failed = false;;) {
      const Message message = WaitFor(kTagCommand, /*timeout_seconds=*/0);
      Reader reader(message);
      const auto command = reader.Take<Command>();
      if (command == Command::kStop) return reader.Take<Ending>();
      if (has_failed) continue;
      try {
        Obey(command, reader);
      } catch (const std::exception& error) {
        // Rank 0 goes on without this one, which waits to be stopped: an MPI job ends as a whole.
        Message failure;
        failure.Put(Answer::kFailure);
        failure.PutText(std::string("cannot go on: ") + error.what());
        link_.Send(kProgramRank, kTagAnswer, std::move(failure));
        has_failed = true;
      }
    }
  }

 private:
  struct WorkerScene {
    std::shared_ptr<Device> device;
    Settings settings;
    std::shared_ptr<const Scene> scene;  ///< keeps its arrays
  };
  struct HeldArray {
    std::shared_ptr<std::byte[]> arriving;  ///< until a scene refers to it
    std::weak_ptr<std::byte[]> in_use;
  };

  /// The next message with `tag`; throws Fault after `timeout_seconds`, if not 0, and if rank 0 has
  /// ended.
  Message WaitFor(int tag, double timeout_seconds) {
    constexpr double kLookSeconds = 0.1;
    const Clock::time_point start = Clock::now();
    Clock::time_point looked = start;
    for (Idle idle;;) {
      if (link_.Progress()) idle.Reset();
      if (auto arrival = link_.Receive(tag); arrival && arrival->from == kProgramRank) {
        return std::move(arrival->message);
      }
      idle.Pause();
      if (timeout_seconds > 0 && SecondsSince(start) > timeout_seconds) {
        throw Fault("rank 0 has not answered");
      }
      if (program_.process == 0 || SecondsSince(looked) < kLookSeconds) continue;
      looked = Clock::now();
      if (HasEnded(own_, program_)) throw Fault("rank 0 has ended");
    }
  }

  void Obey(Command command, Reader& reader) {
    switch (command) {
      case Command::kEcho:
        return Echo(reader);
      case Command::kArray:
        return TakeArray(reader);
      case Command::kScene:
        return MakeScene(reader);
      case Command::kForget:
        scenes_.erase(reader.Take<uint64_t>());
        return;
      case Command::kPiece:
        return TracePiece(reader);
      case Command::kStop:
        return;
    }
    throw CutMessage();
  }

  void Echo(Reader& reader) {
    const auto bytes = reader.Take<uint64_t>();
    Message message;
    message.Put(Answer::kEcho);
    std::memcpy(message.Extend(bytes), reader.Take(bytes), bytes);
    link_.Send(kProgramRank, kTagAnswer, std::move(message));
  }

  void TakeArray(Reader& reader) {
    const auto name = reader.Take<ArrayName>();
    const auto offset = reader.Take<uint64_t>();
    HeldArray& held = arrays_[name];
    if (!held.arriving) {
      held.arriving = std::make_shared_for_overwrite<std::byte[]>(name.bytes);
      held.in_use = held.arriving;
    }
    const std::size_t bytes = reader.left();
    if (offset > name.bytes || bytes > name.bytes - offset) throw CutMessage();
    std::memcpy(held.arriving.get() + offset, reader.Take(bytes), bytes);
  }

  std::shared_ptr<const std::byte[]> FindArray(const ArrayName& name) {
    const auto place = arrays_.find(name);
    auto array = place == arrays_.end() ? nullptr : place->second.in_use.lock();
    if (!array) throw CutMessage();
    return array;
  }

  void MakeScene(Reader& reader) {
    std::shared_ptr<Device> device;
    UnpackedScene unpacked = UnpackScene(
        reader, [this](const ArrayName& name) { return FindArray(name); },
        [&](uint64_t number) {
          const WorkerScene& instanced = scenes_.at(number);
          device = instanced.device;  // an instance and its scene have one
          return instanced.scene;
        });
    if (!device) device = DeviceWith(unpacked.settings);
    scenes_[unpacked.number] = {device, unpacked.settings, SceneWithArrays(device, unpacked)};
    for (auto& [name, held] : arrays_) held.arriving.reset();
    std::erase_if(arrays_, [](const auto& place) { return place.second.in_use.expired(); });
  }

  /// With all that it refers to: scenes that have an instance of it may outlive it here.
  static std::shared_ptr<const Scene> SceneWithArrays(const std::shared_ptr<Device>& device,
                                                      UnpackedScene& unpacked) {
    struct Holder {
      Holder(const std::shared_ptr<Device>& device, UnpackedScene& unpacked)
          : used(std::move(unpacked.used)), scene(device, unpacked.geometries, unpacked.options) {}
      const std::vector<std::shared_ptr<const void>> used;
      const Scene scene;
    };
    const auto holder = std::make_shared<Holder>(device, unpacked);
    return {holder, &holder->scene};
  }

  std::shared_ptr<Device> DeviceWith(const Settings& settings) {
    for (const auto& [number, scene] : scenes_) {
      if (std::memcmp(&scene.settings, &settings, sizeof(settings)) == 0) return scene.device;
    }
    auto device = std::make_shared<Device>(settings);
    if (device->instruction_set() != settings.instruction_set) {
      throw Fault("its best instruction set is " + std::string(Name(device->instruction_set())) +
                  ", that of rank 0 is " + std::string(Name(settings.instruction_set)) +
                  ": limit it with isa");
    }
    return device;
  }

  void TracePiece(Reader& reader) {
    UnpackedPiece piece(reader);
    const auto scene = scenes_.find(piece.scene());
    if (scene == scenes_.end()) throw CutMessage();
    scene->second.scene->Trace(piece.query(), piece.view());
    link_.Send(kProgramRank, kTagAnswer, piece.PackHits());
  }

  Link link_;
  const Greeting own_ = MakeGreeting(Role::kWorker);
  Greeting program_{};
  std::map<uint64_t, WorkerScene> scenes_;
  std::map<ArrayName, HeldArray> arrays_;
};

}  // namespace

Ending Serve(MPI_Comm communicator, const Options& options) {
  return Worker(communicator, options).Run();
}

}  // namespace dacrt::mpi
