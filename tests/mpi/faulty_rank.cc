// A rank that goes wrong in the way that its argument names: under mpirun, beside fault_test.
#include <mpi.h>
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <string>

#include "divided_call.h"
#include "greeting.h"
#include "link.h"
#include "members.h"
#include "patience.h"
#include "wire.h"

using namespace dacrt::mpi;

namespace {

Greeting GreetingFor(const std::string& fault, Role role) {
  Greeting greeting = MakeGreeting(role);
  if (fault == "version") std::strcpy(greeting.version, "0.0.9");
  if (fault == "byte_order") greeting.byte_order = __builtin_bswap32(greeting.byte_order);
  return greeting;
}

Message Wait(Link& link, int tag) {
  for (Idle idle;; idle.Pause()) {
    link.Progress();
    if (auto arrival = link.Receive(tag)) return std::move(arrival->message);
  }
}

/// Sends what is due, whole or but for its last four bytes; or does not come so far.
template <class Send>
void GoWrong(const std::string& fault, Message message, const Send& send) {
  if (fault == "die") raise(SIGKILL);
  if (fault == "cut") {
    message.Shrink(message.size() - 4);
    send(std::move(message));
  }
  if (fault == "stranger") send(std::move(message));
  for (;;) sleep(1);
}

/// Works until the first rays come.
void RunWorker(const std::string& fault) {
  Link link(MPI_COMM_WORLD);
  Message hello;
  hello.Put(GreetingFor(fault, Role::kWorker));
  link.Send(0, kTagGreeting, std::move(hello));
  const Message verdict = Wait(link, kTagVerdict);
  Reader reader(verdict);
  reader.Take<Greeting>();
  if (!reader.TakeText().empty()) return;
  for (;;) {
    const Message message = Wait(link, kTagCommand);
    if (Reader(message).Take<Command>() != Command::kPiece) continue;
    Message answer;
    answer.Put(Answer::kHits);
    GoWrong(fault, std::move(answer), [&](Message cut) {
      link.Send(0, kTagAnswer, std::move(cut));
      link.Progress();
    });
  }
}

/// Commits with the others, and does not do its part of the first call.
void RunMember(const std::string& fault) {
  MPI_Comm communicator;
  MPI_Comm_dup(MPI_COMM_WORLD, &communicator);
  if (fault == "version" || fault == "byte_order") {
    Link link(communicator);
    for (int rank = 0; rank < link.size(); ++rank) {
      Message hello;
      hello.Put(GreetingFor(fault, Role::kMember));
      if (rank != link.rank()) link.Send(rank, kTagGather, std::move(hello));
    }
    for (int other = 1; other < link.size(); ++other) Wait(link, kTagGather);
    return;
  }
  Members members(communicator, {});
  members.Together([&] {
    const float everywhere = 1e10f;
    members.Gather(
        PartSummary{{{-everywhere, -everywhere, -everywhere}, {everywhere, everywhere, everywhere}},
                    0,
                    dacrt::Device().instruction_set()});
  });
  BundleHead head{};
  head.scene = 1;
  head.count = 1;
  Message rays;
  rays.Put(head);
  // Of a rank that there is not.
  RayRecord ray{};
  Luggage luggage{};
  luggage.home = 1000;
  PutRay(ray, luggage, RayKind(), rays.Extend(RayKind().bytes()));
  GoWrong(fault, std::move(rays), [&](Message cut) {
    members.link().Send(0, kTagRays, std::move(cut));
    members.link().Progress();
  });
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  int level;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &level);
  const std::string mode = argv[1], fault = argv[2];
  mode == "replicate" ? RunWorker(fault) : RunMember(fault);
  MPI_Finalize();
}
