#include "rank/rank_line.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "base/core_share.h"
#include "base/program_file.h"
#include "worker/message_bytes.h"

namespace isostrata {
namespace {

constexpr int kReply = 1;  // tag
constexpr double kShortSleepUs = 1000, kLongSleepUs = 10000, kLongAfterUs = 1e6;

/// FNV-1a of the program's file: two builds of one version may differ in their messages.
std::uint64_t build_mark() {
  std::uint64_t mark = 14695981039346656037ull;
  std::ifstream file(program_file(), std::ios::binary);
  std::array<char, 1 << 16> part;
  while (file.read(part.data(), part.size()) || file.gcount() > 0)
    for (std::streamsize i = 0; i < file.gcount(); ++i) mark = (mark ^ static_cast<unsigned char>(part[static_cast<std::size_t>(i)])) * 1099511628211ull;
  return mark;
}

/// What the launcher says of its job's size; 0 if it says nothing.
int told_count() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"})
    if (const char* told = std::getenv(name)) return std::atoi(told);
  return 0;
}

}  // namespace

void GrowingSleep::sleep() {
  std::this_thread::sleep_for(std::chrono::microseconds(static_cast<long>(next_us_)));
  slept_us_ += next_us_;
  next_us_ = std::min(next_us_ * 2, slept_us_ > kLongAfterUs ? kLongSleepUs : kShortSleepUs);
}

RankLine::RankLine(int& argc, char**& argv) {
  int threads = MPI_THREAD_SINGLE;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &threads);
  MPI_Comm_dup(MPI_COMM_WORLD, &all_);
  MPI_Comm_rank(all_, &rank_);
  MPI_Comm_size(all_, &count_);
  std::array<char, MPI_MAX_PROCESSOR_NAME> name{};
  int length = 0;
  MPI_Get_processor_name(name.data(), &length);
  node_.assign(name.data(), static_cast<std::size_t>(length));
  MPI_Comm node = MPI_COMM_NULL;
  MPI_Comm_split_type(all_, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &node);
  const std::vector<int> own = usable_cores();
  std::vector<int> users(own.size());
  MPI_Allreduce(own.data(), users.data(), static_cast<int>(own.size()), MPI_INT, MPI_SUM, node);
  core_share_ = core_share(own, users);
  MPI_Comm_free(&node);
  // Each would take itself for the first rank, and all would write the same files.
  if (const int told = told_count(); count_ == 1 && told > 1)
    throw Error(ErrorCode::unavailable, "the launcher has started " + std::to_string(told) + " processes and MPI does not join them: expected the launcher of the MPI that " +
                                            "isostrata-rank was built with, or srun with the --mpi of that MPI (`srun --mpi=list` says which there are)");
  if (agree(threads) < MPI_THREAD_SERIALIZED)
    throw Error(ErrorCode::unavailable, "this MPI lets one thread alone call it; expected MPI_THREAD_SERIALIZED");
  check_builds();
}

RankLine::~RankLine() {
  for (Sent& of : sent_) wait(of.request);
  MPI_Comm_free(&all_);
  MPI_Finalize();
}

int RankLine::threads(int asked) const { return asked > 0 ? asked : core_share_; }

void RankLine::abort() { MPI_Abort(all_, 1); }

void RankLine::check_builds() {
  const std::uint64_t own = build_mark();
  std::uint64_t first = own;
  MPI_Bcast(&first, 1, MPI_UINT64_T, 0, all_);
  if (agree(first == own ? 1 : 0) == 0)
    throw Error(ErrorCode::unavailable, "the ranks run different builds of isostrata-rank" +
                                            (first == own ? std::string() : "; that of rank " + std::to_string(rank_) + " on " + node_ + " is not the first rank's"));
}

void RankLine::wait(MPI_Request& request, const std::function<void()>& meanwhile) {
  GrowingSleep pause;
  for (int done = 0;;) {
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (done) return;
    if (meanwhile) meanwhile();
    pause.sleep();
  }
}

void RankLine::send(const RankOrder& order) {
  std::string body = to_bytes(order).body;
  std::uint64_t size = body.size();
  MPI_Request request;
  MPI_Ibcast(&size, 1, MPI_UINT64_T, 0, all_, &request);
  wait(request);
  MPI_Ibcast(body.data(), static_cast<int>(body.size()), MPI_CHAR, 0, all_, &request);
  wait(request);
}

RankOrder RankLine::receive(const std::function<void()>& meanwhile) {
  std::uint64_t size = 0;
  MPI_Request request;
  MPI_Ibcast(&size, 1, MPI_UINT64_T, 0, all_, &request);
  wait(request, [&] {
    drop_sent();
    meanwhile();
  });
  MessageBytes bytes;
  bytes.body.resize(size);
  MPI_Ibcast(bytes.body.data(), static_cast<int>(size), MPI_CHAR, 0, all_, &request);
  wait(request);
  return to_rank_order(bytes);
}

void RankLine::reply(RankReply reply) {
  reply.rank = rank_;
  if (reply.failed) reply.message = "rank " + std::to_string(rank_) + " on " + node_ + ": " + reply.message;
  Sent& of = sent_.emplace_back(Sent{to_bytes(reply).body, MPI_REQUEST_NULL});
  MPI_Isend(of.bytes.data(), static_cast<int>(of.bytes.size()), MPI_CHAR, 0, kReply, all_, &of.request);
}

void RankLine::drop_sent() {
  std::erase_if(sent_, [](Sent& of) {
    int done = 0;
    MPI_Test(&of.request, &done, MPI_STATUS_IGNORE);
    return done != 0;
  });
}

std::vector<RankReply> RankLine::collect() {
  std::vector<RankReply> replies;
  for (;;) {
    int there = 0, size = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, kReply, all_, &there, &status);
    if (!there) return replies;
    MPI_Get_count(&status, MPI_CHAR, &size);
    MessageBytes bytes;
    bytes.body.resize(static_cast<std::size_t>(size));
    MPI_Recv(bytes.body.data(), size, MPI_CHAR, status.MPI_SOURCE, kReply, all_, MPI_STATUS_IGNORE);
    replies.push_back(to_rank_reply(bytes));
  }
}

int RankLine::agree(int word) {
  int least = word;
  MPI_Request request;
  MPI_Iallreduce(&word, &least, 1, MPI_INT, MPI_MIN, all_, &request);
  wait(request);
  return least;
}

void RankLine::least(std::vector<float>& numbers) {
  MPI_Reduce(rank_ == 0 ? MPI_IN_PLACE : numbers.data(), numbers.data(), static_cast<int>(numbers.size()), MPI_FLOAT, MPI_MIN, 0, all_);
}

}  // namespace isostrata
