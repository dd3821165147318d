#include "base/landlock.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace isostrata {
namespace {

// What Landlock can refuse, by the version of its interface; older headers do not name the later rights.
constexpr std::uint64_t kRights1 = (1ull << 13) - 1;  // reading, writing, executing, making and removing
constexpr std::uint64_t kRefer = 1ull << 13;          // since 2: linking and renaming between directories
constexpr std::uint64_t kTruncate = 1ull << 14;       // since 3
constexpr std::uint64_t kDevices = 1ull << 15;        // since 5: ioctl of devices
constexpr std::uint64_t kTcp = 3;                     // since 4: binding and connecting
constexpr std::uint64_t kAbstract = 1, kSignals = 2;  // since 6
constexpr std::uint64_t kOfFiles = LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_READ_FILE | kTruncate | kDevices;

static_assert(PathRules::kReadFile == LANDLOCK_ACCESS_FS_READ_FILE && PathRules::kReadFolder == LANDLOCK_ACCESS_FS_READ_DIR);
static_assert(PathRules::kWriteFile == (LANDLOCK_ACCESS_FS_WRITE_FILE | kTruncate) && PathRules::kExecute == LANDLOCK_ACCESS_FS_EXECUTE);
static_assert(PathRules::kMakeFiles == (LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_REMOVE_FILE));
static_assert(PathRules::kMakeFolders == (LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_REMOVE_DIR | kRefer));

std::uint64_t rights_of(int version) {
  return kRights1 | (version >= 2 ? kRefer : 0) | (version >= 3 ? kTruncate : 0) | (version >= 5 ? kDevices : 0);
}

struct Ruleset {
  std::uint64_t files = 0, network = 0, scopes = 0;  // as the kernel's landlock_ruleset_attr
};

}  // namespace

int landlock_version() {
  const long version = syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  return version > 0 ? static_cast<int>(version) : 0;
}

PathRules::PathRules(bool signals) : version_(landlock_version()) {
  if (version_ == 0) return;
  const Ruleset handled{.files = rights_of(version_),
                        .network = version_ >= 4 ? kTcp : 0,
                        .scopes = version_ >= 6 ? kAbstract | (signals ? kSignals : 0) : 0};
  ruleset_ = static_cast<int>(syscall(SYS_landlock_create_ruleset, &handled, sizeof handled, 0));
}

PathRules::~PathRules() {
  if (ruleset_ >= 0) close(ruleset_);
}

void PathRules::allow(int opened, std::uint64_t rights) const {
  struct stat about {};
  if (opened < 0 || fstat(opened, &about) != 0) return;
  landlock_path_beneath_attr rule{};
  rule.parent_fd = opened;
  rule.allowed_access = rights & rights_of(version_) & (S_ISDIR(about.st_mode) ? ~0ull : kOfFiles);
  if (rule.allowed_access != 0) syscall(SYS_landlock_add_rule, ruleset_, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
}

void PathRules::allow(const std::filesystem::path& path, std::uint64_t rights) const {
  const int opened = open(path.c_str(), O_PATH | O_CLOEXEC);
  allow(opened, rights);
  if (opened >= 0) close(opened);
}

bool PathRules::enforce() const { return usable() && syscall(SYS_landlock_restrict_self, ruleset_, 0) == 0; }

}  // namespace isostrata
