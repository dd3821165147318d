#include "data/values/source_mapping.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>
#include <mutex>

#include "base/error.h"

namespace isostrata {
namespace {

/// What the signal's handler can look at: fixed memory, read without a lock. A place is free while `begin` is null; what is mapped beyond these places
/// is mapped all the same, and only its name is missing from the last line.
struct Listed {
  std::atomic<const std::byte*> begin{nullptr};
  std::atomic<const std::byte*> end{nullptr};
  std::array<char, 256> name{};
};
std::array<Listed, 1024> listed;
std::mutex listing;  // guards changes of `listed`

const Listed* find(const void* address) {
  const auto* at = static_cast<const std::byte*>(address);
  for (const Listed& one : listed) {
    const std::byte* begin = one.begin.load(std::memory_order_acquire);
    if (begin && at >= begin && at < one.end.load(std::memory_order_relaxed)) return &one;
  }
  return nullptr;
}

void say(const char* text) { [[maybe_unused]] const auto written = write(STDERR_FILENO, text, std::strlen(text)); }

void on_lost_page(int signal, siginfo_t* info, void*) {
  if (const Listed* of = find(info->si_addr)) {
    say("isostrata: ");
    say(of->name.data());
    say(": was cut short, or its disk failed, while it was being read; open it again\n");
    _exit(1);
  }
  ::signal(signal, SIG_DFL);  // not ours: it is raised again on return
}

/// Unless somebody else looks after the signal.
void watch_lost_pages() {
  static std::once_flag once;
  std::call_once(once, [] {
    struct sigaction now {};
    if (sigaction(SIGBUS, nullptr, &now) != 0 || now.sa_handler != SIG_DFL) return;
    struct sigaction ours {};
    ours.sa_sigaction = on_lost_page;
    ours.sa_flags = SA_SIGINFO;
    sigaction(SIGBUS, &ours, nullptr);
  });
}

class Mapping {
 public:
  Mapping(int descriptor, std::uint64_t offset, std::uint64_t bytes, const std::string& name) {
    const std::uint64_t page = static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)), before = offset % page;
    size_ = static_cast<std::size_t>(bytes + before);
    data_ = mmap(nullptr, size_, PROT_READ, MAP_SHARED, descriptor, static_cast<off_t>(offset - before));
    if (data_ == MAP_FAILED) throw_system_error(name + ": cannot map " + std::to_string(bytes) + " bytes", errno);
    bytes_ = {static_cast<const std::byte*>(data_) + before, static_cast<std::size_t>(bytes)};
    const std::lock_guard lock(listing);
    for (Listed& one : listed) {
      if (one.begin.load(std::memory_order_relaxed)) continue;
      one.name.fill(0);
      name.copy(one.name.data(), one.name.size() - 1);
      one.end.store(static_cast<const std::byte*>(data_) + size_, std::memory_order_relaxed);
      one.begin.store(static_cast<const std::byte*>(data_), std::memory_order_release);
      place_ = &one;
      break;
    }
  }
  ~Mapping() {
    {
      const std::lock_guard lock(listing);
      if (place_) place_->begin.store(nullptr, std::memory_order_release);
    }
    munmap(data_, size_);
  }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  void* data_ = nullptr;
  std::size_t size_ = 0;
  std::span<const std::byte> bytes_;
  Listed* place_ = nullptr;
};

}  // namespace

SourceMapping map_source(int descriptor, std::uint64_t offset, std::uint64_t bytes, const std::string& name) {
  struct stat status {};
  if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) throw Error(ErrorCode::bad_data, name + ": is not a regular file");
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (offset > size || bytes > size - offset)
    throw Error(ErrorCode::bad_data, name + ": has " + std::to_string(size) + " bytes; expected " + std::to_string(bytes) + " from byte " +
                                         std::to_string(offset) + " on");
  if (bytes == 0) return {};
  watch_lost_pages();
  const auto mapping = std::make_shared<const Mapping>(descriptor, offset, bytes, name);
  return {mapping->bytes(), mapping};
}

bool is_in_source(const void* address) { return find(address) != nullptr; }

void drop_pages(const PointArray& array) {
  std::visit(
      [](auto values) {
        if (values.empty() || !is_in_source(values.data())) return;
        const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE)), at = reinterpret_cast<std::uintptr_t>(values.data()), begin = at / page * page;
        madvise(reinterpret_cast<void*>(begin), at + values.size_bytes() - begin, MADV_DONTNEED);
      },
      array.values);
}

}  // namespace isostrata
