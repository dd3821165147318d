// `isostrata cache`: what was read from files and is kept between runs.
#include <boost/json.hpp>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "base/error.h"
#include "main/arguments.h"
#include "main/cache_environment.h"
#include "main/commands.h"

namespace isostrata {
namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

struct Arguments {
  bool clear = false, json = false;
};

void run(const Arguments& arguments) {
  const auto& cache = import_cache();
  if (arguments.clear && cache) clear(*cache);
  const ImportCacheUse use = cache ? use_of(*cache) : ImportCacheUse{};
  if (arguments.json) {
    boost::json::object out{{"folder", nullptr}, {"max_bytes", 0}, {"entries", use.entries}, {"bytes", use.bytes}};
    if (cache) {
      out["folder"] = cache->folder.string();
      out["max_bytes"] = cache->max_bytes;
    }
    print_json(out);
  } else if (!cache) {
    std::printf("nothing is kept: ISOSTRATA_CACHE is \"off\", or there is no home directory\n");
  } else {
    std::printf("%s: %d entries, %.3g of at most %.3g GB\n", cache->folder.c_str(), use.entries, static_cast<double>(use.bytes) / 1e9,
                static_cast<double>(cache->max_bytes) / 1e9);
  }
}

}  // namespace

std::optional<ImportCache> import_cache_of_environment() {
  ImportCache cache;
  const std::string given = variable("ISOSTRATA_CACHE"), base = variable("XDG_CACHE_HOME"), home = variable("HOME");
  if (given == "off") return std::nullopt;
  if (!given.empty())
    cache.folder = std::filesystem::absolute(given);
  else if (base.starts_with('/'))
    cache.folder = std::filesystem::path(base) / "isostrata";
  else if (home.starts_with('/'))
    cache.folder = std::filesystem::path(home) / ".cache" / "isostrata";
  else
    return std::nullopt;
  if (std::string size = variable("ISOSTRATA_CACHE_SIZE"); !size.empty()) {
    const std::string said = size;
    bool good = false;
    try {
      good = CLI::AsSizeValue(false)(size).empty() && size.size() <= 18 && size.find_first_not_of("0123456789") == std::string::npos;
    } catch (const CLI::ValidationError&) {
    }
    if (!good) throw Error(ErrorCode::invalid_argument, "ISOSTRATA_CACHE_SIZE is '" + said + "'; expected a number of bytes, as 8GB");
    cache.max_bytes = std::stoull(size);
  }
  return cache;
}

void add_cache_command(CLI::App& app) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "cache",
      "Says what is kept of files that took half a second or more to read, so that every command and server of this user opens them at once the next "
      "time. ISOSTRATA_CACHE names another folder, or is \"off\"; ISOSTRATA_CACHE_SIZE is how much it may hold (4GB)");
  command->add_flag("--clear", arguments->clear, "Remove all of it");
  command->add_flag("--json", arguments->json, "As JSON: folder, max_bytes, entries, bytes");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
