// All that is sent and received. Nothing else calls MPI, except the start and end of the module.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "message.h"

namespace dacrt::mpi {

/// Messages between the ranks of a communicator. Nothing here waits, and no message is too large
/// for MPI, because callers keep them far below 2^31 bytes.
///
/// Threads: one at a time.
class Link {
 public:
  /// Makes errors of `communicator` return. It must outlive this.
  explicit Link(MPI_Comm communicator);

  /// Requests that are still open are left to MPI, with their memory: a rank that hangs may yet
  /// read it.
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }

  /// Starts to send. Messages with one tag arrive in the order in which they were sent. Throws
  /// Fault if MPI refuses.
  void Send(int to, int tag, std::shared_ptr<const Message> message);
  void Send(int to, int tag, Message message) {
    Send(to, tag, std::make_shared<const Message>(std::move(message)));
  }

  struct Arrival {
    int from;
    Message message;
  };

  /// The next message with `tag` that is here whole, if any.
  std::optional<Arrival> Receive(int tag);

  /// An empty message with room for `bytes`. That of messages which have been sent, and of those
  /// that are handed back, is used again: fresh memory of megabytes costs as much as filling it.
  Message Room(std::size_t bytes);
  void KeepRoom(Message message);

  /// Lets MPI work on what is being sent. True if something was finished.
  bool Progress();

  /// Whether nothing is on its way from here.
  bool HasSentAll() const { return sends_.empty(); }

  /// Bytes of messages to `to` that have not gone yet.
  std::size_t BytesWaiting(int to) const;

  /// Forgets what is on its way to and from `rank`, which is lost.
  void Abandon(int rank);

  uint64_t messages_sent() const { return messages_sent_; }
  uint64_t messages_received() const { return messages_received_; }
  uint64_t bytes_sent() const { return bytes_sent_; }
  uint64_t bytes_received() const { return bytes_received_; }

 private:
  struct Transfer {
    int peer;
    int tag;
    std::shared_ptr<const Message> message;
    MPI_Request request;
  };

  void StartReceives(int tag);

  const MPI_Comm communicator_;
  int rank_ = 0, size_ = 1;
  std::vector<Transfer> sends_;
  std::deque<Transfer> receives_;  ///< in the order in which they came
  std::vector<Message> rooms_;
  uint64_t messages_sent_ = 0, messages_received_ = 0, bytes_sent_ = 0, bytes_received_ = 0;
};

}  // namespace dacrt::mpi
