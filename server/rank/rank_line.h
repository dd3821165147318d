// What the ranks of a parallel job say to each other, over MPI: orders from the first to all, replies from each to the first, and a word on
// which all must agree. Waiting never spins: it looks again after sleeps that grow to a hundredth of a second.
#pragma once

#include <mpi.h>

#include <functional>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "worker/rank_messages.h"

namespace isostrata {

/// One in a process, from its beginning to its end. The first rank's threads take turns by mutex(), which they hold at every call; the other
/// ranks have one thread that calls.
class RankLine {
 public:
  /// Starts MPI. All ranks. Throws unavailable if the ranks run different builds of this program, MPI forbids threads, or it does not join what the launcher has started.
  RankLine(int& argc, char**& argv);
  ~RankLine();
  RankLine(const RankLine&) = delete;
  RankLine& operator=(const RankLine&) = delete;

  int rank() const { return rank_; }
  int count() const { return count_; }
  /// That this rank computes with: as many as are asked for, else its share of the cores that ranks of its node may use.
  int threads(int asked) const;
  const std::string& node() const { return node_; }
  /// Ends the job: for a rank that cannot go on, whose replies the others would wait for.
  void abort();
  MPI_Comm communicator() const { return all_; }
  std::mutex& mutex() { return mutex_; }

  /// By the first rank. Returns once the message is on its way.
  void send(const RankOrder& order);
  /// By the others: waits for the next order; `meanwhile` is called between two looks and may reply.
  RankOrder receive(const std::function<void()>& meanwhile);
  /// By the others.
  void reply(RankReply reply);
  /// By the first rank: what has come since, never waiting for more.
  std::vector<RankReply> collect();

  /// By all ranks: the least of what they say.
  int agree(int word);
  /// By all ranks: the least of each number, on the first one.
  void least(std::vector<float>& numbers);

 private:
  void wait(MPI_Request& request, const std::function<void()>& meanwhile = {});
  void drop_sent();
  void check_builds();

  MPI_Comm all_ = MPI_COMM_NULL;
  int rank_ = 0, count_ = 1, core_share_ = 1;
  std::string node_;
  std::mutex mutex_;
  struct Sent {
    std::string bytes;
    MPI_Request request;
  };
  std::list<Sent> sent_;  // replies on their way
};

/// Sleeps that grow, for whoever looks whether something has come.
class GrowingSleep {
 public:
  void sleep();

 private:
  double next_us_ = 20, slept_us_ = 0;
};

}  // namespace isostrata
