#include "link.h"

#include <algorithm>
#include <string>

#include "dacrt/mpi.h"

namespace dacrt::mpi {
namespace {

/// Smaller messages are made anew, and of larger ones so many are kept at most.
constexpr std::size_t kLeastRoom = 1 << 16, kMostRooms = 16;

void Check(int code, const char* function) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING];
  int length = 0;
  MPI_Error_string(code, text, &length);
  throw Fault(std::string(function) + ": " + std::string(text, static_cast<std::size_t>(length)));
}

/// Keeps the memory of a request that MPI may still work on.
void LeaveToMpi(std::shared_ptr<const Message> message) {
  new std::shared_ptr<const Message>(std::move(message));
}

}  // namespace

Link::Link(MPI_Comm communicator) : communicator_(communicator) {
  Check(MPI_Comm_set_errhandler(communicator, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
  Check(MPI_Comm_rank(communicator, &rank_), "MPI_Comm_rank");
  Check(MPI_Comm_size(communicator, &size_), "MPI_Comm_size");
}

Link::~Link() {
  for (Transfer& send : sends_) LeaveToMpi(std::move(send.message));
  for (Transfer& receive : receives_) LeaveToMpi(std::move(receive.message));
}

void Link::Send(int to, int tag, std::shared_ptr<const Message> message) {
  Transfer send{to, tag, std::move(message), MPI_REQUEST_NULL};
  Check(MPI_Isend(send.message->data(), static_cast<int>(send.message->size()), MPI_BYTE, to, tag,
                  communicator_, &send.request),
        "MPI_Isend");
  ++messages_sent_;
  bytes_sent_ += send.message->size();
  sends_.push_back(std::move(send));
}

void Link::StartReceives(int tag) {
  for (;;) {
    int is_there = 0;
    MPI_Message handle;
    MPI_Status status;
    Check(MPI_Improbe(MPI_ANY_SOURCE, tag, communicator_, &is_there, &handle, &status),
          "MPI_Improbe");
    if (!is_there) return;
    int bytes = 0;
    Check(MPI_Get_count(&status, MPI_BYTE, &bytes), "MPI_Get_count");
    auto message = std::make_shared<Message>(Room(static_cast<std::size_t>(bytes)));
    message->Extend(static_cast<std::size_t>(bytes));
    Transfer receive{status.MPI_SOURCE, tag, message, MPI_REQUEST_NULL};
    Check(MPI_Imrecv(message->data(), bytes, MPI_BYTE, &handle, &receive.request), "MPI_Imrecv");
    receives_.push_back(std::move(receive));
  }
}

std::optional<Link::Arrival> Link::Receive(int tag) {
  StartReceives(tag);
  for (auto receive = receives_.begin(); receive != receives_.end(); ++receive) {
    if (receive->tag != tag) continue;
    // A later message of the same rank must not overtake one that is still arriving.
    const bool is_first = std::none_of(receives_.begin(), receive, [&](const Transfer& earlier) {
      return earlier.peer == receive->peer && earlier.tag == tag;
    });
    if (!is_first) continue;
    int is_done = 0;
    Check(MPI_Test(&receive->request, &is_done, MPI_STATUS_IGNORE), "MPI_Test");
    if (!is_done) continue;
    ++messages_received_;
    bytes_received_ += receive->message->size();
    // Nobody else knows of it by now.
    Arrival arrival{receive->peer, std::move(const_cast<Message&>(*receive->message))};
    receives_.erase(receive);
    return arrival;
  }
  return std::nullopt;
}

Message Link::Room(std::size_t bytes) {
  const auto room = std::find_if(rooms_.begin(), rooms_.end(), [&](const Message& message) {
    return message.capacity() >= bytes;
  });
  Message message;
  if (room != rooms_.end()) {
    message = std::move(*room);
    rooms_.erase(room);
  } else {
    message.Extend(bytes);
  }
  message.Shrink(0);
  return message;
}

void Link::KeepRoom(Message message) {
  if (message.capacity() >= kLeastRoom && rooms_.size() < kMostRooms) {
    rooms_.push_back(std::move(message));
  }
}

bool Link::Progress() {
  const auto is_done = [&](Transfer& send) {
    int done = 0;
    Check(MPI_Test(&send.request, &done, MPI_STATUS_IGNORE), "MPI_Test");
    // Others may send the same one.
    if (done && send.message.use_count() == 1) {
      KeepRoom(std::move(const_cast<Message&>(*send.message)));
    }
    return done != 0;
  };
  return std::erase_if(sends_, is_done) > 0;
}

std::size_t Link::BytesWaiting(int to) const {
  std::size_t bytes = 0;
  for (const Transfer& send : sends_) bytes += send.peer == to ? send.message->size() : 0;
  return bytes;
}

void Link::Abandon(int rank) {
  const auto abandon = [&](Transfer& transfer) {
    if (transfer.peer != rank) return false;
    LeaveToMpi(std::move(transfer.message));
    return true;
  };
  std::erase_if(sends_, abandon);
  std::erase_if(receives_, abandon);
}

}  // namespace dacrt::mpi
