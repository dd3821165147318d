#include "worker/message_channel.h"

#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <vector>

namespace isostrata {
namespace {

constexpr std::uint32_t kMagic = 0x4d617349;  // a stream that has lost its step does not hold it

constexpr std::uint64_t kPiece = 4ull << 20;

struct Header {
  std::uint32_t magic = kMagic;
  std::uint32_t by_file = 0;
  std::uint64_t body = 0;
  std::uint64_t picture = 0;
  std::uint64_t has_picture = 0;
};

void write_file(int file, const Bytes& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = pwrite(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw_system_error("a picture cannot be written to memory", errno);
    done += static_cast<std::size_t>(n);
  }
}

// Read, not mapped: a file that its maker makes shorter gives an error then, and no SIGBUS.
void read_file(int file, Bytes& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = pread(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw Error(ErrorCode::bad_data, "a picture is shorter than announced");
    done += static_cast<std::size_t>(n);
  }
}

}  // namespace

Descriptor make_memory_file(const char* name, std::uint64_t bytes) {
  Descriptor file(memfd_create(name, MFD_CLOEXEC));
  if (!file || ftruncate(file.get(), static_cast<off_t>(bytes)) != 0) throw_system_error("cannot make a memory file", errno);
  return file;
}

std::pair<Descriptor, Descriptor> MessageChannel::make_pair() {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) throw_system_error("cannot make a pair of sockets", errno);
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

void MessageChannel::send(const MessageBytes& message) {
  Header header;
  header.body = message.body.size();
  if (header.body > kMaxBody)
    throw Error(ErrorCode::too_large, "a message of " + std::to_string(header.body) + " bytes; at most " +
                                          std::to_string(kMaxBody) + " pass between server and worker");
  Descriptor file;
  if (message.picture) {
    header.has_picture = 1;
    header.picture = message.picture->size();
    if (header.picture > kMaxPicture)
      throw Error(ErrorCode::too_large, "the picture has " + std::to_string(header.picture) + " bytes; at most " +
                                            std::to_string(kMaxPicture) + " pass between server and worker");
    if (header.picture > kMaxInline) {
      file = make_memory_file("isostrata-picture", 0);
      write_file(file.get(), *message.picture);
      header.by_file = 1;
    }
  }
  std::lock_guard lock(send_mutex_);
  write_all(&header, sizeof header, file.get());
  write_all(message.body.data(), message.body.size(), -1);
  if (message.picture && !header.by_file) write_all(message.picture->data(), message.picture->size(), -1);
}

std::optional<MessageBytes> MessageChannel::receive() {
  Header header;
  Descriptor file;
  if (!read_all(&header, sizeof header, &file)) return std::nullopt;
  const std::uint64_t most = header.by_file ? kMaxPicture : kMaxInline;
  if (header.magic != kMagic || header.body > kMaxBody || header.by_file > 1 || header.has_picture > 1 ||
      header.picture > (header.has_picture ? most : 0) || (header.by_file && !file))
    throw Error(ErrorCode::bad_data, "what came is not a message");
  MessageBytes message;
  // Piece by piece, so that memory is taken by what comes and not by what was announced.
  for (std::uint64_t done = 0; done < header.body;) {
    const std::uint64_t piece = std::min(header.body - done, kPiece);
    message.body.resize(done + piece);
    if (!read_all(message.body.data() + done, piece, nullptr)) return std::nullopt;
    done += piece;
  }
  if (!header.has_picture) return message;
  struct stat facts {};
  if (header.by_file && (fstat(file.get(), &facts) != 0 || static_cast<std::uint64_t>(facts.st_size) != header.picture))
    throw Error(ErrorCode::bad_data, "a picture is not as long as announced");
  auto picture = std::make_shared<Bytes>(header.picture);
  if (header.by_file)
    read_file(file.get(), *picture);
  else if (!read_all(picture->data(), picture->size(), nullptr))
    return std::nullopt;
  message.picture = std::move(picture);
  return message;
}

void MessageChannel::shut_down() { shutdown(socket_.get(), SHUT_RDWR); }

bool MessageChannel::read_all(void* to, std::size_t size, Descriptor* passed) {
  char* at = static_cast<char*>(to);
  while (size > 0) {
    std::vector<Descriptor> came;  // one that nobody expects is closed
    const ssize_t n = receive_passed(socket_.get(), at, size, came);
    if (n < 0 && errno != ECONNRESET) throw_system_error("a message cannot be read", errno);
    if (n <= 0) return false;
    if (passed && !came.empty()) *passed = std::move(came.back());
    at += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

void MessageChannel::write_all(const void* from, std::size_t size, int pass) {
  const char* at = static_cast<const char*>(from);
  while (size > 0) {
    const ssize_t n = send_passing(socket_.get(), at, size, {pass});
    if (n <= 0) throw_system_error("a message cannot be sent", errno);
    pass = -1;
    at += n;
    size -= static_cast<std::size_t>(n);
  }
}

}  // namespace isostrata
